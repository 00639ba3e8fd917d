//! Harm is the mean over members, which are what they say; stages end as they should.

use crate::course::tests::{attempted, ego, go_on, party, worked_within};
use crate::fixtures::{body, cuboid, sedan_of};
use crate::request_limits::{RequestLimits, Until};
use crate::{Answer, CourseRow};
use body::{Body, Shape};
use damage::AnswerState;

fn ranked(text: &str, bodies: &[&Body]) -> Answer {
    worked_within(text, bodies, RequestLimits::default()).answer
}

fn way(name: &str, y: f64, speed_m_s: f64) -> String {
    format!(
        "[[candidates]]\nname = \"{name}\"\npath = {{ states = [ {{ t_s = 0, position_m = [0, 0, \
         0] }}, {{ t_s = 1, position_m = [{:?}, {y:?}, 0] }}, {{ t_s = 2, position_m = [{:?}, \
         {y:?}, 0] }} ] }}\n",
        speed_m_s,
        2.0 * speed_m_s
    )
}

fn row<'a>(answer: &'a Answer, name: &str) -> &'a CourseRow {
    answer.ranking.iter().find(|row| row.name == name).expect("ranked")
}

const NONE: &str = "errors = { lateral_m = 0, longitudinal_m = 0, yaw_deg = 0, speed_share = 0 }";

/// With nothing drawn apart from run-outs, every member is the scene as stated.
#[test]
fn without_errors_harm_is_that_of_the_scene_as_stated() {
    let (sedan, pole) = (body(Shape::Sedan, 900), body(Shape::Pole, 600));
    let scene = |members: &str, errors: &str| {
        let pole =
            party("pole", "pole", &format!("{errors}\nplace = {{ position_m = [20, 0.3, 0] }}"));
        let ego =
            party("ego", "sedan", &format!("persons = [{{ seat = \"front-left\" }}]\n{errors}"));
        format!("{members}{ego}{pole}{}{}", go_on(14.0), way("slow", 0.0, 7.0))
    };
    let nominal = ranked(&scene("", ""), &[&sedan, &pole]);
    let drawn = ranked(&scene("members = 8\n", NONE), &[&sedan, &pole]);
    assert_eq!(drawn.state, AnswerState::Complete);
    for (drawn, nominal) in drawn.ranking.iter().zip(&nominal.ranking) {
        assert_eq!(drawn.name, nominal.name);
        assert!((drawn.work.hi() - nominal.work.hi()).abs() < 1e-9);
        assert_eq!(drawn.contacts, nominal.contacts);
        let expected = drawn.expected.as_ref().expect("members were followed");
        let spread = expected.spread.expect("nothing is open");
        assert!(expected.contact == 1.0 && spread.error < 1e-12 && spread.regret >= 0.0);
        assert!((spread.quantiles[0] - spread.quantiles[2]).abs() < 1e-12);
    }
    let first = drawn.ranking[0].expected.as_ref().and_then(|of| of.spread).expect("known");
    assert_eq!((first.best, first.regret), (1.0, 0.0));
    let members = drawn.members.expect("they were followed");
    assert_eq!((members.count, members.replaced), (8, 0), "equal members need no more");
}

/// A pole beside the way: the scene as stated misses it or hits it, members rise and fall with the
/// distance.
#[test]
fn expected_harm_has_no_cliff() {
    let (sedan, pole) = (body(Shape::Sedan, 900), body(Shape::Pole, 600));
    let harm = |y: f64| {
        let place = format!("place = {{ position_m = [25, {y:?}, 0] }}");
        let beside = party("pole", "pole", &place);
        let text = format!("members = 64\nmembers_max = 64\n{}{beside}{}", ego(), go_on(20.0));
        let answer = ranked(&text, &[&sedan, &pole]);
        let row = &answer.ranking[0];
        let expected = row.expected.as_ref().expect("members");
        assert!(expected.meets.iter().all(|met| met.party == "pole" && met.probability > 0.0));
        (row.work.hi(), expected.contact)
    };
    let series: Vec<(f64, f64)> = (5..=14).map(|k| harm(0.1 * f64::from(k))).collect();
    let most = series.iter().map(|(harm, _)| *harm).fold(0.0, f64::max);
    assert!(most > 0.0);
    for pair in series.windows(2) {
        assert!((pair[1].0 - pair[0].0).abs() < 0.3 * most, "{series:?}");
        assert!(pair[1].1 <= pair[0].1 + 1e-12, "contact is less probable farther out: {series:?}");
    }
}

/// An oncoming car passes farther and farther aside.
#[test]
fn expected_harm_has_no_cliff_beside_an_oncoming_car() {
    let sedan = body(Shape::Sedan, 900);
    let harm = |y: f64| {
        let comes =
            format!("state = {{ position_m = [60, {y:?}, 0], yaw_deg = 180, speed_m_s = 15 }}");
        let comes = party("comes", "sedan", &comes);
        let text = format!("members = 32\nmembers_max = 32\n{}{comes}{}", ego(), go_on(20.0));
        ranked(&text, &[&sedan, &sedan]).ranking[0].work.hi()
    };
    let series: Vec<f64> = (14..=18).map(|k| harm(0.1 * f64::from(k))).collect();
    let most = series.iter().copied().fold(0.0, f64::max);
    assert!(most > 0.0);
    for pair in series.windows(2) {
        assert!((pair[1] - pair[0]).abs() < 0.3 * most, "{series:?}");
    }
}

/// Three ways into equal cars, at three speeds: which is best is hardly in doubt.
#[test]
fn equal_crashes_at_three_speeds_are_told_apart() {
    let sedan = body(Shape::Sedan, 900);
    let stands =
        |x: f64, y: f64| format!("place = {{ position_m = [{x:?}, {y:?}, 0], yaw_deg = 180 }}");
    // Each way goes along a lane of its own, and the car that stands there is met at its speed.
    let lanes = [(10.0, -8.0), (15.0, 0.0), (20.0, 8.0)];
    let mut text = format!("members = 32\nmembers_max = 32\nhorizon_s = 4\n{}", ego());
    for (number, (_, y)) in lanes.iter().enumerate() {
        text += &party(&format!("p{number}"), "sedan", &stands(40.0, *y));
    }
    for (speed_m_s, y) in lanes {
        text += &format!(
            "[[candidates]]\nname = \"{speed_m_s}\"\npath = {{ states = [ {{ t_s = 0, position_m = \
             [0, 0, 0] }}, {{ t_s = 1, position_m = [15, {y:?}, 0] }}, {{ t_s = {:?}, position_m = \
             [45, {y:?}, 0] }} ] }}\n",
            1.0 + 30.0 / speed_m_s
        );
    }
    let answer = ranked(&text, &[&sedan, &sedan, &sedan, &sedan]);
    let names: Vec<&str> = answer.ranking.iter().map(|row| row.name.as_str()).collect();
    assert_eq!(names, ["10", "15", "20"], "{answer:#?}");
    let best = answer.ranking[0].expected.as_ref().and_then(|of| of.spread).expect("known");
    assert!(best.best >= 0.99, "{best:?}");
}

/// Predicted paths are taken as often as they are probable.
#[test]
fn paths_are_taken_by_their_probability() {
    let sedan = body(Shape::Sedan, 900);
    let path = |probability: f64, y: f64| {
        format!(
            "[[parties.other.paths]]\nprobability = {probability:?}\nstates = [ \
             {{ t_s = 0, position_m = [40, 6, 0], yaw_deg = 180 }}, \
             {{ t_s = 2, position_m = [20, {y:?}, 0], yaw_deg = 180 }} ]\n"
        )
    };
    let other = party("other", "sedan", NONE);
    let text = format!(
        "members = 64\nmembers_max = 64\n{}{other}{}{}{}",
        ego(),
        path(0.75, 6.0),
        path(0.25, 0.0),
        go_on(10.0)
    );
    let answer = ranked(&text, &[&sedan, &sedan]);
    let row = &answer.ranking[0];
    assert!(row.contacts.is_empty(), "on the likeliest path nobody is met");
    assert!(!row.touches_nobody() && row.alternatives.is_empty());
    let expected = row.expected.as_ref().expect("members");
    assert_eq!(expected.contact, 0.25);
    assert!(!answer.assumptions.iter().any(|said| said.contains("was followed")));
}

/// What stands at the bumper overlaps it in some draws, which are replaced.
#[test]
fn draws_in_which_bodies_overlap_are_replaced() {
    let sedan = body(Shape::Sedan, 900);
    let queue =
        |x: f64| party("queue", "sedan", &format!("place = {{ position_m = [{x:?}, 0, 0] }}"));
    let text = |x: f64| {
        format!("members = 32\nmembers_max = 32\n{}{}{}", ego(), queue(x), way("on", 0.0, 0.5))
    };
    let answer = ranked(&text(5.0), &[&sedan, &sedan]);
    let members = answer.members.expect("they were followed");
    assert!(members.count == 32 && (4..512).contains(&members.replaced), "{members:?}");
    let touched = row(&answer, "on").expected.as_ref().expect("members");
    assert!(touched.meets.iter().all(|met| met.from_s > 0.0), "nobody is met at the start");
    // Stated as overlapping, they are left so.
    let overlapping = ranked(&text(4.0), &[&sedan, &sedan]);
    assert_eq!(overlapping.members.map(|members| members.replaced), Some(0));
}

/// Where nearly no draw is possible, the request is refused, and the party named.
#[test]
fn what_overlaps_in_nearly_every_draw_is_refused() {
    let sedan = body(Shape::Sedan, 900);
    // A lane between two walls, two millimetres wider than the car.
    let bounds = sedan.view().bounds();
    let [low, high] = [bounds.min[1], bounds.max[1]].map(f64::from);
    let lane = [
        cuboid([-9.0, high + 0.001, 0.0], [9.0, 9.0, 3.0]),
        cuboid([-9.0, -9.0, 0.0], [9.0, low - 0.001, 3.0]),
    ];
    let lane = sedan_of(lane.concat());
    let beside = party("lane", "sedan", "place = { position_m = [0, 0, 0] }");
    let text = format!("members = 32\n{}{beside}{}", ego(), go_on(5.0));
    let refused = attempted(&text, &[&sedan, &lane], RequestLimits::default());
    let message = refused.expect_err("it is refused").to_string();
    assert!(message.contains("\"lane\"") && message.contains("of 1024 draws"), "{message}");
    let stated = attempted(
        &text.replace("members = 32", "members = 1"),
        &[&sedan, &lane],
        RequestLimits::default(),
    );
    assert!(stated.is_ok(), "as stated they are apart");
}

/// Two ways that are too close to call take more members; clear ones do not.
#[test]
fn stages_double_while_the_best_two_are_close() {
    let (sedan, pole) = (body(Shape::Sedan, 900), body(Shape::Pole, 600));
    let text = |[first, second]: [f64; 2]| {
        let poles = [(-1.2, "left"), (1.2, "right")].map(|(y, name)| {
            party(name, "pole", &format!("place = {{ position_m = [25, {y:?}, 0] }}"))
        });
        format!(
            "members = 8\nmembers_max = 64\n{}{}{}{}",
            ego(),
            poles.concat(),
            way("first", first, 15.0),
            way("second", second, 15.0)
        )
    };
    // Sorted by name: ego, left, right.
    let bodies = [&sedan, &pole, &pole];
    let count = |answer: &Answer| answer.members.map(|of| of.count).expect("members");
    let is_close = |answer: &Answer| {
        answer.members.and_then(|of| of.lead).expect("nothing is open").is_close()
    };
    let mut counts = Vec::new();
    for ways in [[0.0, 0.0], [0.2, -0.2], [0.1, -0.15], [0.4, -0.45], [0.6, -0.6], [0.0, 1.2]] {
        let whole = ranked(&text(ways), &bodies);
        assert!(count(&whole) == 64 || !is_close(&whole), "{:?}", whole.members);
        let spread = |row: &CourseRow| row.expected.as_ref().and_then(|of| of.spread);
        let best = whole.ranking.iter().map(|row| spread(row).expect("known").best);
        assert!((best.sum::<f64>() - 1.0).abs() < 1e-12);
        for until in [Until::Certified, Until::Ordered] {
            let limits = RequestLimits { until, ..RequestLimits::default() };
            let early = worked_within(&text(ways), &bodies, limits).answer;
            assert_eq!(early.ranking[0].name, whole.ranking[0].name);
            assert_eq!(count(&early), count(&whole), "{ways:?}");
        }
        counts.push(count(&whole));
    }
    assert_eq!((counts[0], counts[5]), (8, 8), "equal ones, and a clear case: {counts:?}");
    assert!(counts.iter().any(|count| *count > 8), "{counts:?}");
}

/// Answers do not depend on time: those that came in time are the same, and late ones say of which
/// stage, or of which part of the first, they are.
#[test]
fn a_stage_that_is_not_finished_in_time_is_left_out() {
    let (sedan, pole) = (body(Shape::Sedan, 900), body(Shape::Pole, 600));
    let pole_beside = party("pole", "pole", "place = { position_m = [25, 1.2, 0] }");
    let ways = format!("{}{}", way("first", 0.05, 15.0), way("second", -0.05, 15.0));
    let text = format!("members = 16\nmembers_max = 512\n{}{pole_beside}{ways}", ego());
    let whole = ranked(&text, &[&sedan, &pole]);
    let mut late = 0;
    for deadline_ns in (1..=60).map(|step| step * step * 50_000) {
        let limits = RequestLimits { deadline_ns: Some(deadline_ns), ..RequestLimits::default() };
        let ranked = worked_within(&text, &[&sedan, &pole], limits);
        let answer = ranked.answer;
        let explained = ranked.explanation.map(|explanation| explanation.members);
        let count = answer.members.map(|members| members.count);
        assert_eq!(explained, Some(count.unwrap_or(0)), "of the members that the answer is of");
        let says = |words: &str| answer.missing.iter().any(|said| said.contains(words));
        match (answer.state, answer.members) {
            (AnswerState::Complete, _) => assert_eq!(answer, whole),
            (AnswerState::Degraded, None) => {
                assert!(says("ranked as stated"), "{answer:#?}");
                assert!(!answer.ranking.iter().any(CourseRow::touches_nobody), "{answer:#?}");
            }
            (AnswerState::Degraded, Some(members)) if members.is_late => {
                late += u32::from(members.count >= 16);
                let words = if members.count < 16 { "of 16 members" } else { "too close to call" };
                assert!(says(words), "{answer:#?}");
                let rows = answer.ranking.iter();
                let spreads = rows.filter_map(|row| row.expected.as_ref()?.spread);
                assert_eq!(spreads.count(), 2, "of what is finished all is known");
            }
            _ => assert!(!answer.missing.is_empty(), "{answer:#?}"),
        }
    }
    assert!(whole.members.is_some_and(|of| of.count > 16) || late == 0);
}
