//! A picture shows what was followed: contacts lie on both bodies, and run-outs leave the path.

use super::super::tests::{drawn, ego, go_on, party};
use super::*;
use crate::fixtures::body;
use body::Shape;

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
