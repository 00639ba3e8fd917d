//! A picture shows what was followed: contacts lie on both bodies, and run-outs leave the path.

use super::super::tests::{drawn, ego, go_on, party};
use super::*;
use crate::fixtures::body;
use body::Shape;
use geometry::rng::Rng;

/// Where a track is at a time: the rule that a reader of the scene has to apply.
fn at(track: &[PlanSample], time_s: f64) -> [f64; 2] {
    let after = track.partition_point(|sample| sample.0[0] <= time_s);
    let (a, b) = (track[after.saturating_sub(1)].0, track[after.min(track.len() - 1)].0);
    let share = if b[0] > a[0] { (time_s - a[0]) / (b[0] - a[0]) } else { 0.0 };
    [1, 2].map(|k| a[k] + (b[k] - a[k]) * share)
}

/// Whether a body that lies there holds a point, but for 1 cm.
fn holds(outline: &[[f64; 2]], [x, y]: [f64; 2], [p, q]: [f64; 2], [cos, sin]: [f64; 2]) -> bool {
    let (dx, dy) = (x - p, y - q);
    let (x, y) = (cos * dx + sin * dy, cos * dy - sin * dx);
    let next = outline.iter().cycle().skip(1);
    outline.iter().zip(next).all(|(a, b)| {
        let [along, across] = [b[0] - a[0], b[1] - a[1]];
        along * (y - a[1]) - across * (x - a[0]) >= -0.01 * along.hypot(across)
    })
}

#[test]
fn a_heavy_contact_lies_on_both_bodies_and_the_ego_runs_out_from_it() {
    let (sedan, wall) = (body(Shape::Sedan, 900), body(Shape::Wall, 900));
    let bodies = [&sedan, &wall];
    let placed = party("wall", "wall", "place = { position_m = [30, 0, 0], yaw_deg = 90 }");
    let (answer, scene) = drawn(&format!("{}{placed}{}", ego(), go_on(14.0)), &bodies);
    let (course, row) = (&scene.courses[0], &answer.ranking[0]);
    let contact = course.contacts[0];
    assert_eq!((contact.time_s, course.contacts.len()), (row.contacts[0].time_s, 1));
    assert!(contact.is_heavy);
    assert_eq!(course.run_outs_s, [contact.time_s]);
    let wall = &scene.parties[1];
    let ego_at = at(&course.ego, contact.time_s);
    assert!(holds(&scene.parties[0].outline_m, contact.at_m, ego_at, [1.0, 0.0]), "{contact:?}");
    assert!(holds(&wall.outline_m, contact.at_m, [30.0, 0.0], [0.0, 1.0]), "{contact:?}");
    // Before: as planned. After: not on.
    let before = at(&course.ego, 0.9 * contact.time_s);
    assert!((before[0] - 14.0 * 0.9 * contact.time_s).abs() < 1e-3, "{before:?}");
    let end = at(&course.ego, scene.horizon_s);
    assert!(end[0] < 14.0 * contact.time_s + 0.5 * row.run_outs[0].length_m + 1.0, "{end:?}");
}

#[test]
fn a_reaction_is_drawn_instead_of_the_prediction_and_only_in_its_candidate() {
    let sedan = body(Shape::Sedan, 900);
    let bodies = [&sedan, &sedan];
    let other = party("other", "sedan", "state = { position_m = [60, 9, 0], speed_m_s = 5 }");
    let reaction = "[candidates.reactions.other]\nplace = { position_m = [60, 9, 0] }\n";
    let second = "[[candidates]]\nname = \"slow\"\nstate = { position_m = [0, 0, 0], \
                  speed_m_s = 2 }\n";
    let (_, scene) = drawn(&format!("{}{other}{}{reaction}{second}", ego(), go_on(10.0)), &bodies);
    let (party, track) = &scene.courses[0].reactions[0];
    assert_eq!(*party, 1);
    assert_eq!(at(track, scene.horizon_s), [60.0, 9.0]);
    // What stands is told by its first and last sample.
    assert_eq!(track.len(), 2);
    assert!(scene.courses[1].reactions.is_empty());
    let predicted = at(&scene.parties[1].paths[0].track, scene.horizon_s);
    assert!((predicted[0] - (60.0 + 5.0 * scene.horizon_s)).abs() < 1e-3, "{predicted:?}");
    assert!(scene.courses.iter().all(|course| course.contacts.is_empty()));
}

/// Where a line is at a time.
fn along(line: &[PlanPoint], time_s: f64) -> [f64; 2] {
    let after = line.partition_point(|point| point.0[0] <= time_s);
    let (a, b) = (line[after.saturating_sub(1)].0, line[after.min(line.len() - 1)].0);
    let share = if b[0] > a[0] { (time_s - a[0]) / (b[0] - a[0]) } else { 0.0 };
    [1, 2].map(|k| a[k] + (b[k] - a[k]) * share)
}

#[test]
fn what_is_drawn_of_members_is_what_the_answer_counts() {
    let sedan = body(Shape::Sedan, 900);
    let bodies = [&sedan, &sedan, &sedan];
    let ahead = party(
        "ahead",
        "sedan",
        "state = { position_m = [22, 2.1, 0], speed_m_s = 2 }\n\
         errors = { lateral_m = 0.4, speed_share = 0.5 }",
    );
    let far = party("far", "sedan", "place = { position_m = [60, 40, 0] }");
    let slow = "[[candidates]]\nname = \"slow\"\nstate = { position_m = [0, 0, 0], \
                speed_m_s = 3 }\n[candidates.reactions.ahead]\n\
                state = { position_m = [22, 2.1, 0], speed_m_s = 4 }\n";
    let text = format!("members = 16\n{}{ahead}{far}{}{slow}", ego(), go_on(14.0));
    let (answer, scene) = drawn(&text, &bodies);
    let members = answer.members.expect("there are members");
    assert_eq!(scene.members.len(), members.count as usize);
    let mut met = 0;
    for (k, course) in scene.courses.iter().enumerate() {
        let row = answer.ranking.iter().find(|row| row.name == course.name).expect("ranked");
        let expected = row.expected.as_ref().expect("of members");
        for (number, party) in scene.parties.iter().enumerate() {
            let meets = |member: &&PlanMember| {
                member.courses[k].contacts.iter().any(|contact| contact.party == number)
            };
            let share =
                scene.members.iter().filter(meets).count() as f64 / f64::from(members.count);
            let said = expected.meets.iter().find(|one| one.party == party.name);
            assert_eq!(
                share,
                said.map_or(0.0, |met| met.probability),
                "{} {}",
                row.name,
                party.name
            );
            met += usize::from(share > 0.0 && share < 1.0);
        }
    }
    assert!(met > 0, "somebody is met in some members and not in others");
    // The ego is drawn where each contact is, and nobody where the scenario has them stand exactly.
    for member in &scene.members {
        assert!(member.parties[scene.ego].is_empty());
        assert_eq!(member.courses[1].reactions.len(), 1);
        for contact in member
            .courses
            .iter()
            .flat_map(|course| course.contacts.iter().map(|contact| (contact, &course.ego)))
        {
            let (contact, way) = contact;
            let [x, y] = along(way, contact.time_s);
            let reach = f64::hypot(contact.at_m[0] - x, contact.at_m[1] - y);
            assert!(reach < 4.0, "{contact:?} is {reach} m from the ego");
        }
    }
}

#[test]
fn a_line_is_near_the_motion_and_ends_where_it_ends() {
    let mut rng = Rng::new(17);
    for _ in 0..200 {
        let (mut at, mut v) = ([0.0, 0.0], [rng.between(-20.0, 20.0), rng.between(-5.0, 5.0)]);
        let samples: Vec<PlanSample> = (0..60)
            .map(|step| {
                (0..2).for_each(|k| {
                    at[k] += 0.05 * v[k];
                    v[k] += rng.between(-2.0, 2.0);
                });
                PlanSample([0.05 * f64::from(step), at[0], at[1], 1.0, 0.0])
            })
            .collect();
        let line = line(&samples);
        for sample in &samples {
            let [time_s, x, y, ..] = sample.0;
            let [p, q] = along(&line, time_s);
            assert!(f64::hypot(p - x, q - y) < 0.05 + 0.01, "at {time_s} s");
        }
        assert!(line.len() <= samples.len());
    }
    let straight = [0.0, 1.0, 2.0, 3.0].map(|t| PlanSample([t, 7.0 * t, 0.0, 1.0, 0.0]));
    assert_eq!(line(&straight), [PlanPoint([0.0; 3]), PlanPoint([3.0, 21.0, 0.0])]);
    assert!(line(&[]).is_empty());
}

#[test]
fn who_meets_nobody_is_shown_where_it_is_nearest() {
    let sedan = body(Shape::Sedan, 900);
    let bodies = [&sedan, &sedan];
    let other = party("other", "sedan", "place = { position_m = [20, 4, 0] }");
    let (answer, scene) = drawn(&format!("{}{other}{}", ego(), go_on(10.0)), &bodies);
    let row = answer.ranking[0].nearest.as_ref().expect("nobody is met");
    let nearest = scene.courses[0].nearest.as_ref().expect("it is drawn");
    assert_eq!((nearest.time_s, nearest.gap_m, nearest.party), (row.time_s, row.gap_m, 1));
    let [x, y] = at(&scene.courses[0].ego, nearest.time_s);
    let [p, q, _] = nearest.scene.pose.translation;
    assert!((x + p - 20.0).abs() < 1e-3 && (y + q - 4.0).abs() < 1e-3, "{nearest:?}");
    assert!(nearest.scene.hits.iter().all(Vec::is_empty));
}
