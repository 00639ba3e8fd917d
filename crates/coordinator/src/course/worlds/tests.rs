//! Worlds give shares that follow from the scene.

use crate::Answer;
use crate::course::tests::{ego, party, worked_within};
use crate::fixtures::body;
use crate::request_limits::RequestLimits;
use body::{Body, Shape};
use damage::AnswerState;

fn way(name: &str, y: f64, speed_m_s: f64) -> String {
    format!(
        "[[candidates]]\nname = \"{name}\"\nstate = {{ position_m = [0, {y:?}, 0], speed_m_s = \
         {speed_m_s:?} }}\n"
    )
}

fn ranked(ways: &str, bodies: &[&Body]) -> Answer {
    let wall = party("wall", "wall", "place = { position_m = [30, 0, 0] }");
    let text = format!("members = 4\nmembers_max = 4\n{}{wall}{ways}", ego());
    let ranked = worked_within(&text, bodies, RequestLimits::default());
    assert!(ranked.effort.worlds_ns > 0);
    ranked.answer
}

fn won(answer: &Answer, name: &str) -> f64 {
    let row = answer.ranking.iter().find(|row| row.name == name).expect("ranked");
    row.expected.as_ref().and_then(|of| of.worlds).expect("all work is done")
}

#[test]
fn equal_ways_tie_in_every_world_and_a_worse_one_wins_none() {
    let (sedan, wall) = (body(Shape::Sedan, 900), body(Shape::Wall, 900));
    let ways = [way("a", 0.0, 8.0), way("b", 0.0, 8.0), way("fast", 0.0, 16.0)].concat();
    let answer = ranked(&ways, &[&sedan, &wall]);
    assert_eq!(answer.state, AnswerState::Complete);
    let shares = ["a", "b", "fast"].map(|name| won(&answer, name));
    assert!((shares[0] - 0.5).abs() < 1e-9 && (shares[1] - 0.5).abs() < 1e-9, "{shares:?}");
    assert_eq!(shares[2], 0.0);
    let worlds = answer.worlds.expect("all work is done");
    assert!(worlds.count == 200 && worlds.flips.iter().all(|flip| (flip.lost - 0.5).abs() < 1e-9));
}

/// Which way is better is certain, though ranges overlap: the doubt is the same for both.
#[test]
fn a_shared_doubt_does_not_hide_who_is_better() {
    let (sedan, wall) = (body(Shape::Sedan, 900), body(Shape::Wall, 900));
    let answer =
        ranked(&[way("slow", 0.0, 10.0), way("fast", 0.0, 12.0)].concat(), &[&sedan, &wall]);
    let [first, second] = answer.ranking.as_slice() else { panic!("two candidates") };
    assert_eq!(first.name, "slow");
    assert!(!first.certain && first.range.high() > second.range.low(), "ranges overlap");
    assert_eq!((won(&answer, "slow"), won(&answer, "fast")), (1.0, 0.0));
    assert!(answer.worlds.expect("all work is done").flips.is_empty());
}
