//! An assessment is the answer of a fresh ranking, whatever the scene, policy, curves and worlds.

use super::*;
use crate::course::rank_courses;
use crate::course::trial::random_courses;
use crate::fixtures::{models_of, of_all_shapes};
use crate::in_process::InProcessExecutor;
use crate::trial::tests::POLICIES;
use body::{Body, BodyView, Meta, Shells};
use damage::{Curves, Policy};
use geometry::rng::Rng;
use scenario::Scenario;
use std::collections::BTreeMap;

const CURVES: [&str; 2] = [
    include_str!("../../../config/curves/default.toml"),
    include_str!("../../../config/curves/levels.toml"),
];

/// Every policy with every set of curves that covers it; some look at milder injuries.
fn all_criteria() -> Vec<Criteria> {
    let mut all = Vec::new();
    for (number, text) in POLICIES.iter().enumerate() {
        let milder = text.replace("outcome = \"mais3+\"", "outcome = \"mais2+\"");
        for text in [*text, milder.as_str()] {
            let policy = Policy::parse("policy.toml", text).expect("sound");
            for curves in CURVES {
                let curves = Curves::parse("curves.toml", curves).expect("sound");
                if curves.covers(policy.outcome).is_err() {
                    continue;
                }
                let criteria = Criteria::with_policy(policy.clone()).expect("sound");
                all.push(Criteria { curves: Arc::new(curves), ..criteria });
            }
        }
        assert!(all.len() > number, "each is there");
    }
    all
}

/// Searches a scene once, and ranks it afresh under all criteria.
struct Trial {
    bodies: Vec<Body>,
    all: Vec<Criteria>,
    /// How often what came about.
    seen: BTreeMap<&'static str, u32>,
}

impl Trial {
    fn new() -> Self {
        Self { bodies: of_all_shapes(), all: all_criteria(), seen: BTreeMap::new() }
    }

    fn note(&mut self, what: &'static str) {
        *self.seen.entry(what).or_default() += 1;
    }

    /// All of these have come about.
    fn holds(&self, expected: &[&str]) {
        let seen = &self.seen;
        assert!(expected.iter().all(|what| seen.contains_key(what)), "{expected:?}: {seen:?}");
    }

    fn check(&mut self, text: &str) {
        // Some turn faster than a vehicle does.
        let Ok(scenario) = Scenario::parse("random.toml", text) else {
            assert!(text.contains("name = \"random\""), "it can be read: {text}");
            return;
        };
        let bodies = std::mem::take(&mut self.bodies);
        let views: Vec<(Meta, BodyView<'_>)> =
            bodies.iter().map(|body| (body.meta.clone(), body.view())).collect();
        let shells: Vec<Shells> = views.iter().map(|(_, view)| Shells::of(view.corners)).collect();
        let stage = BodySet { bodies: &views, extremes: None, depth: 3 };
        let models = models_of(&scenario);
        let request = |criteria: &Criteria, worlds: Worlds| CourseRequest {
            scenario: &scenario,
            models: &models,
            shells: &shells,
            criteria: criteria.clone(),
            members: scenario.members(),
            worlds,
            history: false,
            explanation: false,
            scene: false,
        };
        // A deadline that is not reached changes nothing.
        let due_ns = runtime::clock::now_ns() + 3_600_000_000_000;
        let due_ns = text.len().is_multiple_of(2).then_some(due_ns);
        let executor = Box::new(InProcessExecutor::with_room_for(&views));
        let mut backend = Backend::InProcess(executor);
        let all = std::mem::take(&mut self.all);
        let searched =
            search_courses(&stage, &request(&all[0], Worlds::USUAL), due_ns, &mut backend);
        for (number, criteria) in all.iter().enumerate() {
            let worlds = [
                Worlds::USUAL,
                Worlds { count: 40, seed: number as u32 },
                Worlds { count: 0, seed: 0 },
                Worlds { count: 90, seed: 7 },
            ][number % 4];
            let request = request(criteria, worlds);
            let fresh = rank_courses(&stage, &request, RequestLimits::default(), &mut backend);
            let fresh = fresh.map(|ranked| ranked.answer);
            match (&searched, fresh) {
                (Ok(Some(searched)), Ok(fresh)) => {
                    let again = searched.assess(criteria, worlds).expect("a fresh one is ranked");
                    assert_eq!(format!("{again:?}"), format!("{fresh:?}"), "{text}");
                    assert_eq!(json(&again), json(&fresh));
                    self.note(fresh.state.name());
                    let count = fresh.members.map_or(1, |members| members.count);
                    self.note(if count > scenario.members().count { "doubled" } else { "at once" });
                    if fresh.worlds.is_some() {
                        self.note("worlds");
                    }
                }
                (Ok(Some(searched)), Err(RunError::Request(fresh))) => {
                    let error = searched.assess(criteria, worlds).expect_err("as a fresh one");
                    assert_eq!(error.to_string(), fresh.to_string());
                    self.note("no answer");
                }
                (Err(error), Err(fresh)) => assert_eq!(error.to_string(), fresh.to_string()),
                (searched, fresh) => panic!("{:?}, {:?}\n{text}", searched.is_ok(), fresh.is_ok()),
            }
        }
        self.all = all;
        drop(views);
        self.bodies = bodies;
    }
}

fn json(answer: &Answer) -> String {
    serde_json::to_string(answer).expect("it can be written")
}

/// A scene of an ego and these parties, with a way for each.
fn scene(head: &str, parties: &[(&str, &str)], ways: &[&str]) -> String {
    let party = |(shape, rest): &(&str, &str)| {
        let generate = format!("generate = {{ shape = \"{shape}\", triangles = 600 }}");
        format!("[parties.{shape}-1]\n{generate}\n{rest}\n")
    };
    let ego = "[parties.ego]\ngenerate = { shape = \"sedan\", triangles = 600 }\n";
    let ways = ways.iter().enumerate();
    let ways = ways.map(|(k, state)| format!("[[candidates]]\nname = \"way {k}\"\n{state}\n"));
    let parties: String = parties.iter().map(party).collect();
    let head = format!("schema = \"trolley.scenario/2\"\nname = \"test\"\nhorizon_s = 3\n{head}");
    format!("{head}\n{ego}{parties}{}", ways.collect::<String>())
}

#[test]
fn an_assessment_is_the_answer_of_a_fresh_ranking() {
    let mut trial = Trial::new();
    for seed in 0..16 {
        trial.check(&random_courses(&mut Rng::new(seed)));
    }
    trial.holds(&["complete", "at once", "worlds"]);
}

/// Nearly equal ways: most policies ask for more members, some for more than others.
#[test]
fn stages_end_under_each_policy_as_they_do_afresh() {
    let mut trial = Trial::new();
    for y in [0.0, 0.03, 0.1] {
        let place = format!("place = {{ position_m = [18, {y:?}, 0] }}");
        let walks = "state = { position_m = [16, -3, 0], yaw_deg = 90, speed_m_s = 1.5 }";
        let left = "state = { position_m = [0, 0, 0], velocity_m_s = [11, 0.3] }";
        let right = "state = { position_m = [0, 0, 0], velocity_m_s = [11, -0.3] }";
        let parties = [("pole", place.as_str()), ("pedestrian", walks)];
        trial.check(&scene("members = 4\nmembers_max = 24", &parties, &[left, right]));
    }
    trial.holds(&["complete", "at once", "doubled", "worlds"]);
}

/// Bodies that overlap and stand: of them nothing is known, under any policy.
#[test]
fn what_has_no_figures_has_none_under_any_policy() {
    let mut trial = Trial::new();
    let inside = [
        ("pole", "place = { position_m = [2.2, 0.3, 0] }"),
        ("wall", "place = { position_m = [30, 0, 0] }"),
    ];
    let stand = "state = { position_m = [0, 0, 0], speed_m_s = 0 }";
    let back = "state = { position_m = [0, 0, 0], speed_m_s = -3 }";
    let on = "state = { position_m = [0, 0, 0], speed_m_s = 12 }";
    for head in ["members = 1", "members = 3\nmembers_max = 6"] {
        trial.check(&scene(head, &inside, &[stand, back, on]));
        trial.check(&scene(head, &inside, &[stand, on]));
    }
    assert!(
        trial.seen.keys().any(|what| ["certified", "degraded", "refused"].contains(what)),
        "{:?}",
        trial.seen
    );
}

/// Most draws overlap, so that there are not as many members as may be asked for.
#[test]
fn a_stage_that_cannot_be_drawn_is_refused_to_whom_asks_for_it() {
    let mut trial = Trial::new();
    trial.all.retain(|criteria| criteria.policy.outcome.name() == "mais3+");
    trial.all.truncate(4);
    let near = |x: f64| {
        format!("errors = {{ longitudinal_m = 3 }}\nplace = {{ position_m = [{x:?}, 0, 0] }}")
    };
    for y in [-0.02, 0.0, 0.02] {
        let pole =
            format!("errors = {{ lateral_m = 0.5 }}\nplace = {{ position_m = [18, {y:?}, 0] }}");
        let parties = [("suv", near(-5.1)), ("truck", near(-8.0)), ("pole", pole)];
        let parties = parties.each_ref().map(|(shape, rest)| (*shape, rest.as_str()));
        let left = "state = { position_m = [0, 0, 0], velocity_m_s = [11, 0.3] }";
        let right = "state = { position_m = [0, 0, 0], velocity_m_s = [11, -0.3] }";
        trial.check(&scene("members = 100\nmembers_max = 1024", &parties, &[left, right]));
    }
    trial.holds(&["no answer", "complete"]);
}
