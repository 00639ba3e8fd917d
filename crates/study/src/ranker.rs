//! A scene under all policies and curves of a study, by one engine in this process.

use crate::attempts::TRIES;
use crate::plan::{Plan, SceneKey};
use crate::rows::Answered;
use crate::scene::Scenes;
use std::panic::{AssertUnwindSafe, catch_unwind};
use trolley::{Answer, Engine, Failure, FailureKind, Limits, Scenario};

/// Bytes of bodies that are kept from scene to scene.
const CACHE_BYTES: usize = 256 << 20;

/// An engine, made when it is needed, and again after a panic.
pub(crate) struct Ranker {
    engine: Option<Engine>,
}

impl Ranker {
    pub(crate) fn new() -> Self {
        Self { engine: None }
    }

    /// What becomes of a scene: for each policy and set of curves an answer, or why there is none.
    pub(crate) fn outcomes(
        &mut self,
        plan: &Plan,
        scenes: &mut Scenes<'_>,
        key: &SceneKey,
    ) -> Vec<Result<Answered, String>> {
        let count = plan.answers_per_scene() as usize;
        let refused = |failure: &Failure| {
            let what = failure.what().replace(&format!("{}/", plan.dir().display()), "");
            (0..count).map(|_| Err(what.clone())).collect()
        };
        let scenario = match scenes.scenario(key) {
            Ok(scenario) => scenario,
            Err(failure) => return refused(&failure),
        };
        let mut tries = 1;
        let answers = loop {
            match self.answers(plan, &scenario) {
                // What the machine refused it may grant the next time.
                Err(failure) if is_passing(&failure) && tries < TRIES => tries += 1,
                Err(failure) => return refused(&failure),
                Ok(answers) => break answers,
            }
        };
        let answered = |answer: Answer| {
            let answered = Answered::new(answer).map_err(|failure| failure.what().to_owned())?;
            Ok(answered)
        };
        answers.into_iter().map(answered).collect()
    }

    /// The answers under each policy and set of curves, curves varying fastest.
    fn answers(&mut self, plan: &Plan, scenario: &Scenario) -> Result<Vec<Answer>, Failure> {
        let engine = match &mut self.engine {
            Some(engine) => engine,
            none => none.insert(Engine::builder().in_process().body_cache(CACHE_BYTES).build()?),
        };
        let judged = catch_unwind(AssertUnwindSafe(|| judged(engine, plan, scenario)));
        judged.unwrap_or_else(|_| {
            // Whatever it was in the middle of is not used again.
            self.engine = None;
            Err(Failure::internal("a panic, which is a bug of this program"))
        })
    }
}

/// The answers to one scene.
fn judged(engine: &mut Engine, plan: &Plan, scenario: &Scenario) -> Result<Vec<Answer>, Failure> {
    let judges = plan.judges();
    let mut answers = Vec::with_capacity(judges.policies.len() * judges.curves.len());
    for policy in &judges.policies {
        for curves in &judges.curves {
            let scenario =
                scenario.clone().with_curves(curves.clone())?.with_policy(policy.clone())?;
            answers.push(engine.rank(&scenario, &Limits::default())?.answer);
        }
    }
    Ok(answers)
}

/// Whether the machine is at fault, and not the scene.
fn is_passing(failure: &Failure) -> bool {
    matches!(failure.kind(), FailureKind::Resources | FailureKind::System | FailureKind::TryAgain)
}
