//! A scene under all policies and curves of a study, by one engine in this process.

use crate::attempts::TRIES;
use crate::plan::{Plan, SceneKey};
use crate::rows::Answered;
use crate::scene::Scenes;
use std::panic::{AssertUnwindSafe, catch_unwind};
use trolley::{Answer, Engine, Failure, FailureKind, Judge, Limits, Scenario, Worlds};

/// Bytes of bodies that are kept from scene to scene.
const CACHE_BYTES: usize = 256 << 20;

/// An engine, made when it is needed, and again after a panic.
pub(crate) struct Ranker {
    engine: Option<Engine>,
    /// Every policy with every set of curves, curves varying fastest.
    judges: Vec<Judge>,
}

impl Ranker {
    pub(crate) fn new(plan: &Plan) -> Result<Self, Failure> {
        let texts = plan.judges();
        let mut judges = Vec::new();
        for policy in &texts.policies {
            for curves in &texts.curves {
                judges.push(Judge::new(Some(policy), Some(curves))?);
            }
        }
        Ok(Self { engine: None, judges })
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
            match self.answers(plan.worlds(), &scenario) {
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
    fn answers(&mut self, worlds: Worlds, scenario: &Scenario) -> Result<Vec<Answer>, Failure> {
        let engine = match &mut self.engine {
            Some(engine) => engine,
            none => none.insert(Engine::builder().in_process().body_cache(CACHE_BYTES).build()?),
        };
        let judges = &self.judges;
        let judged = catch_unwind(AssertUnwindSafe(|| judged(engine, judges, worlds, scenario)));
        judged.unwrap_or_else(|_| {
            // Whatever it was in the middle of is not used again.
            self.engine = None;
            Err(Failure::internal("a panic, which is a bug of this program"))
        })
    }
}

/// The answers to one scene: searched once, and assessed under each policy and set of curves.
fn judged(
    engine: &mut Engine,
    judges: &[Judge],
    worlds: Worlds,
    scenario: &Scenario,
) -> Result<Vec<Answer>, Failure> {
    let searched = engine.search(scenario, &Limits::default())?;
    let answer = |judge: &Judge| searched.assess(&judge.criteria(scenario)?, worlds);
    judges.iter().map(answer).collect()
}

/// Whether the machine is at fault, and not the scene.
fn is_passing(failure: &Failure) -> bool {
    matches!(failure.kind(), FailureKind::Resources | FailureKind::System | FailureKind::TryAgain)
}
