//! Wherever the work on random scenes stops, what is said holds the finished work; and a trial sees
//! when it does not.

use super::*;
use crate::fixtures::{models_of, of_all_shapes};
use body::{Body, BodyView, Meta, Shells};
use damage::{Criteria, Policy};
use scenario::Scenario;

fn tried(scenes: u64, stops: u64, flaw: Option<CourseFlaw>) -> TrialResult {
    let bodies: Vec<Body> = of_all_shapes();
    let views: Vec<(Meta, BodyView<'_>)> =
        bodies.iter().map(|body| (body.meta.clone(), body.view())).collect();
    let shells: Vec<Shells> = views.iter().map(|(_, view)| Shells::of(view.corners)).collect();
    let stage = BodySet { bodies: &views, extremes: None, depth: 3 };
    let criteria = Criteria::with_policy(Policy::shipped().expect("sound")).expect("sound");
    let mut all = TrialResult::default();
    for seed in 0..scenes {
        let text = random_courses(&mut Rng::new(seed));
        // Some turn faster than a vehicle does.
        let Ok(scenario) = Scenario::parse("random.toml", &text) else { continue };
        let models = models_of(&scenario);
        let request = CourseRequest {
            scenario: &scenario,
            models: &models,
            shells: &shells,
            criteria: criteria.clone(),
            members: scenario.members(),
            worlds: scenario::Worlds::USUAL,
            history: false,
            explanation: false,
            scene: false,
        };
        let one = trial_courses(&stage, &request, (seed, stops), flaw).expect("assessed");
        assert!(flaw.is_some() || one.violations.is_empty(), "{text}\n{:#?}", one.violations);
        all.add(one);
    }
    all
}

#[test]
fn what_is_said_at_any_stop_holds_the_finished_work() {
    let all = tried(60, 25, None);
    assert!(all.stops > 1_000 && all.open_intervals > 1_000, "{all:?}");
    assert!(all.certified > 100, "{all:?}");
    assert!(all.late_open > 10 && all.late > all.late_open, "{all:?}");
}

#[test]
fn answers_that_are_wrong_on_purpose_are_noticed() {
    for flaw in [CourseFlaw::ForgetsOpen, CourseFlaw::EndsEarly] {
        assert!(!tried(12, 10, Some(flaw)).violations.is_empty(), "{flaw:?}");
    }
}
