//! Over members, no more is followed than it takes to know who wins; and who wins is the same.

use super::CourseOrder;
use crate::course::history::{SearchClock, Surveyor};
use crate::course::tests::{ego, party, with_request, worked_within};
use crate::course::trial::{TrialResult, check_figures};
use crate::course::{CourseRequest, follow};
use crate::fixtures::body;
use crate::in_process::InProcessExecutor;
use crate::request_limits::{RequestLimits, Until};
use crate::{Answer, CourseRow};
use body::{Body, Shape};
use damage::AnswerState;
use geometry::rng::Rng;
use scenario::Members;

fn way(name: &str, y: f64, speed_m_s: f64) -> String {
    let (one, two) = (speed_m_s, 2.0 * speed_m_s);
    format!(
        "[[candidates]]\nname = \"{name}\"\npath = {{ states = [ {{ t_s = 0, position_m = [0, 0, \
         0] }}, {{ t_s = 1, position_m = [{one:?}, {y:?}, 0] }}, {{ t_s = 2, position_m = \
         [{two:?}, {y:?}, 0] }} ] }}\n"
    )
}

fn certified(deadline_ns: Option<u64>) -> RequestLimits {
    RequestLimits { until: Until::Certified, deadline_ns, ..RequestLimits::default() }
}

fn count(answer: &Answer) -> u32 {
    answer.members.expect("they were followed").count
}

/// In how many members a candidate was not followed to its end.
fn open(answer: &Answer, name: &str) -> u32 {
    let row = answer.ranking.iter().find(|row| row.name == name).expect("ranked");
    row.expected.as_ref().expect("members").open
}

/// Between two poles, and into a wall beside them.
fn poles_and_wall(members: &str, ways: &str) -> (String, [Body; 4]) {
    let place = |x: f64, y: f64| format!("place = {{ position_m = [{x:?}, {y:?}, 0] }}");
    let text = format!(
        "{members}{}{}{}{}{ways}",
        ego(),
        party("left", "pole", &place(25.0, -1.2)),
        party("right", "pole", &place(25.0, 1.2)),
        party("wall", "wall", &place(20.0, 9.0)),
    );
    // Sorted by name.
    let pole = || body(Shape::Pole, 600);
    (text, [body(Shape::Sedan, 900), pole(), pole(), body(Shape::Wall, 900)])
}

/// Three speeds into a wall: of the slowest all is known, of the others no more than it takes.
#[test]
fn rivals_are_followed_no_farther_than_it_takes() {
    let ways = [way("fast", 0.0, 14.0), way("slow", 0.0, 9.0), way("faster", 0.0, 19.0)].concat();
    let wall = party("wall", "wall", "place = { position_m = [16, 0, 0] }");
    let text = format!("members = 32\nmembers_max = 128\n{}{wall}{ways}", ego());
    let bodies = [body(Shape::Sedan, 900), body(Shape::Wall, 900)];
    let bodies = [&bodies[0], &bodies[1]];
    let whole = worked_within(&text, &bodies, RequestLimits::default());
    let early = worked_within(&text, &bodies, certified(None));
    let (whole_answer, answer) = (&whole.answer, &early.answer);
    assert_eq!(whole_answer.state, AnswerState::Complete);
    assert_eq!(answer.state, AnswerState::Certified, "{answer:#?}");
    assert_eq!((&*answer.ranking[0].name, count(answer)), ("slow", 32));
    assert_eq!((&*whole_answer.ranking[0].name, count(whole_answer)), ("slow", 32));
    assert_eq!(answer.ranking[0].work, whole_answer.ranking[0].work, "the winner's mean is known");
    assert_eq!(open(answer, "slow"), 0);
    let (fast, faster) = (open(answer, "fast"), open(answer, "faster"));
    assert!(fast >= 8 && faster >= fast, "{fast} and {faster} of 32 are open");
    assert_eq!(early.effort.spared, u64::from(fast + faster));
    let encounters = |effort: &crate::CourseEffort| effort.search.encounters;
    assert!(3 * encounters(&early.effort) < 2 * encounters(&whole.effort));
}

/// A stage after which another one comes for sure is not finished.
#[test]
fn who_cannot_be_second_is_not_followed_to_tell_that_the_best_two_are_close() {
    let members = "members = 8\nmembers_max = 64\n";
    let mut doubled = 0;
    for [first, second] in [[0.1, -0.15], [0.2, -0.2], [0.4, -0.45], [0.05, -0.05]] {
        let ways = [way("first", first, 15.0), way("wall", 9.0, 18.0), way("second", second, 15.0)];
        let (text, bodies) = poles_and_wall(members, &ways.concat());
        let bodies: Vec<&Body> = bodies.iter().collect();
        let whole = worked_within(&text, &bodies, RequestLimits::default()).answer;
        let early = worked_within(&text, &bodies, certified(None)).answer;
        assert_eq!(whole.ranking[2].name, "wall", "{whole:#?}");
        assert_eq!(early.ranking[0].name, whole.ranking[0].name);
        assert_eq!(count(&early), count(&whole), "{first} and {second}");
        if count(&whole) > 8 {
            doubled += 1;
            let open = open(&early, "wall");
            assert!(4 * open > count(&early), "{open} of {} are open", count(&early));
        }
    }
    assert!(doubled > 0, "in none the best two are close");
}

/// Whenever time ends: what is certified is so, and a replay chooses the same (each ranking here is
/// replayed).
#[test]
fn what_is_certified_before_a_deadline_wins_in_the_end() {
    let ways = [way("first", 0.3, 15.0), way("wall", 9.0, 18.0), way("second", -0.1, 12.0)];
    let (text, bodies) = poles_and_wall("members = 16\nmembers_max = 64\n", &ways.concat());
    let bodies: Vec<&Body> = bodies.iter().collect();
    let whole = worked_within(&text, &bodies, RequestLimits::default()).answer;
    for deadline_ns in (1..=40).map(|step| step * step * 100_000) {
        let answer = worked_within(&text, &bodies, certified(Some(deadline_ns))).answer;
        match answer.state {
            AnswerState::Complete | AnswerState::Certified => {
                assert_eq!(answer.ranking[0].name, whole.ranking[0].name);
                assert_eq!(count(&answer), count(&whole));
            }
            _ => {
                assert!(!answer.missing.is_empty(), "{answer:#?}");
                assert!(!answer.ranking.iter().any(CourseRow::touches_nobody));
            }
        }
    }
}

/// A scene whose work is stopped at its looks: after so many of them.
fn stopped(
    (text, bodies): (&str, &[&Body]),
    (members, until): (Option<Members>, Until),
    over_at: Option<u64>,
) -> Answer {
    with_request(text, bodies, |stage, request| {
        let members = members.unwrap_or(request.members);
        let request = &CourseRequest { members, ..request.clone() };
        let executor = Box::new(InProcessExecutor::with_room_for(stage.bodies));
        let mut surveyor = Surveyor::Lossy { executor, rng: Rng::new(1), loses: 0 };
        let (how, clock) = ((until, CourseOrder::Race), SearchClock::trial(over_at));
        follow((stage, request), how, &clock, &mut surveyor).expect("it can be ranked").answer
    })
}

/// In the same time more members can be followed, and what a part leaves open is followed in the
/// next one if it matters there.
#[test]
fn a_part_is_finished_once_its_winner_is_certain() {
    let ways = [way("fast", 0.0, 14.0), way("slow", 0.0, 9.0), way("faster", 0.0, 19.0)].concat();
    let wall = party("wall", "wall", "place = { position_m = [16, 0, 0] }");
    let text = format!("members = 32\nmembers_max = 32\n{}{wall}{ways}", ego());
    let bodies = [body(Shape::Sedan, 900), body(Shape::Wall, 900)];
    let bodies = [&bodies[0], &bodies[1]];
    // After how many looks at the clock so many members are known.
    let reached = |until: Until, least: u32| {
        let is_known = |over_at: &u64| {
            let answer = stopped((&text, &bodies), (None, until), Some(*over_at));
            if let Some(members) = answer.members.filter(|members| members.is_late) {
                assert_eq!(answer.ranking[0].name, "slow", "of {} members", members.count);
                assert_eq!(open(&answer, "slow"), 0);
            }
            answer.members.is_some_and(|members| members.count >= least)
        };
        (0..).step_by(3).find(is_known).expect("in the end all are known")
    };
    for least in [4, 8, 16] {
        let [whole, early] = [Until::Complete, Until::Certified].map(|until| reached(until, least));
        assert!(3 * early < 2 * whole, "{least} members after {early} looks, and {whole}");
    }
}

/// Wherever time ends, what the scene as stated has left open is said to be so.
#[test]
fn what_was_not_followed_is_open() {
    // Whoever passes everybody wins, so the others need not be followed.
    let ways = [way("free", -9.0, 12.0), way("wall", 9.0, 18.0), way("pole", -0.9, 12.0)];
    let (text, bodies) = poles_and_wall("members = 8\nmembers_max = 8\n", &ways.concat());
    let bodies: Vec<&Body> = bodies.iter().collect();
    let scene = (&*text, &bodies[..]);
    let end = stopped(scene, (Some(Members::NOMINAL), Until::Complete), None);
    let (mut result, mut open) = (TrialResult::default(), 0);
    for over_at in 0.. {
        let answer = stopped(scene, (None, Until::Certified), Some(over_at));
        if answer.members.is_some() {
            break;
        }
        check_figures(&answer, &end, &mut result);
        open += answer.ranking.iter().filter(|row| row.open_from_s.is_some()).count();
        assert!(result.violations.is_empty(), "after {over_at} looks: {:?}", result.violations);
    }
    assert!(open > 0 && result.intervals > 0);
}
