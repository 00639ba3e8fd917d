//! Work stops where nothing that is open can change what was asked for, and not before.

use crate::course::tests::{ego, party, worked_within};
use crate::fixtures::body;
use crate::request_limits::{RequestLimits, Until};
use body::{Body, Shape};
use damage::AnswerState;

fn way(name: &str, y_m: f64, speed_m_s: f64) -> String {
    let x_m = 2.0 * speed_m_s;
    format!(
        "[[candidates]]\nname = \"{name}\"\npath = {{ states = [ \
         {{ t_s = 0, position_m = [0, 0, 0] }}, {{ t_s = 2, position_m = [{x_m:?}, {y_m:?}, 0] }} \
         ] }}\n"
    )
}

fn wall_ahead() -> (String, Body, Body) {
    let wall = party("wall", "wall", "place = { position_m = [20, 0, 0] }");
    (format!("{}{wall}", ego()), body(Shape::Sedan, 900), body(Shape::Wall, 900))
}

fn until(until: Until) -> RequestLimits {
    RequestLimits { until, ..RequestLimits::default() }
}

#[test]
fn a_way_that_touches_nobody_ends_the_work_before_any_survey() {
    let (head, sedan, wall) = wall_ahead();
    // The crash is bad for sure, though its hit sets are not known.
    let text = format!("{head}{}{}", way("hit", 0.0, 15.0), way("stop", 0.0, 2.0));
    let work = |limits| worked_within(&text, &[&sedan, &wall], limits);
    let whole = work(until(Until::Complete));
    assert_eq!((whole.answer.state, whole.effort.spared), (AnswerState::Complete, 0));
    let early = work(until(Until::Certified));
    assert_eq!(early.answer.state, AnswerState::Certified);
    assert_eq!((early.effort.rounds, early.effort.spared), (0, 1), "{:?}", early.effort);
    let [first, second] = early.answer.ranking.as_slice() else { panic!("two candidates") };
    assert!(first.name == "stop" && first.touches_nobody());
    // Whom it meets is known, and what comes of it is not.
    assert_eq!(second.contacts[0].party, "wall");
    assert!(second.open_from_s.is_some() && !second.work.is_settled());
    assert_eq!(early.answer.missing.len(), 1);
}

#[test]
fn ways_after_one_that_nobody_can_beat_are_not_searched() {
    let (head, sedan, wall) = wall_ahead();
    let ways = [way("stop", 0.0, 2.0), way("hit", 0.0, 15.0), way("fast", 0.0, 20.0)].concat();
    let text = format!("{head}{ways}");
    let early = worked_within(&text, &[&sedan, &wall], until(Until::Certified));
    assert_eq!(early.effort.search.encounters, 1, "the first way alone was searched");
    assert_eq!(early.answer.ranking[0].name, "stop");
    assert!(early.answer.ranking[1].open_from_s == Some(0.0));
}

#[test]
fn the_order_takes_all_but_one_candidate() {
    let (head, sedan, wall) = wall_ahead();
    let ways = [way("hit", 0.0, 15.0), way("fast", 0.0, 20.0), way("stop", 0.0, 2.0)].concat();
    let text = format!("{head}{ways}");
    let work = |limits| worked_within(&text, &[&sedan, &wall], limits);
    let (whole, ordered) = (work(until(Until::Complete)), work(until(Until::Ordered)));
    let names = |answer: &crate::Answer| -> Vec<String> {
        answer.ranking.iter().map(|row| row.name.clone()).collect()
    };
    assert_eq!(names(&whole.answer), names(&ordered.answer));
    assert_eq!(ordered.answer.settled_places, 3);
}

#[test]
fn a_candidate_alone_is_followed_to_its_end() {
    let (head, sedan, wall) = wall_ahead();
    let text = format!("{head}{}", way("hit", 0.0, 15.0));
    let work = |limits| worked_within(&text, &[&sedan, &wall], limits).answer;
    let (whole, early) = (work(until(Until::Complete)), work(until(Until::Certified)));
    assert_eq!(early, whole);
}
