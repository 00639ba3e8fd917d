//! A scene under all policies and curves of a study, by one engine in this process.

use crate::attempts::TRIES;
use crate::plan::{Plan, SceneKey};
use crate::rows::Answered;
use crate::scene::Scenes;
use runtime::clock;
use std::panic::{AssertUnwindSafe, catch_unwind};
use trolley::{Answer, Engine, Failure, FailureKind, Judge, Limits, Scenario};

/// How refusals begin that say nothing of the scene alone: another process may have an answer.
const OF_PROCESSES: [&str; 3] = [DIED, LATE, PANICKED];
const DIED: &str = "the process that ranked it died";
const LATE: &str = "it took longer than";
const PANICKED: &str = "a panic, which is a bug of this program";

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
    ///
    /// # Errors
    ///
    /// If the machine is at fault, and not the scene, each of [`TRIES`] times.
    pub(crate) fn outcomes(
        &mut self,
        plan: &Plan,
        scenes: &mut Scenes<'_>,
        key: &SceneKey,
    ) -> Result<Vec<Result<Answered, String>>, Failure> {
        let row_of = |failure: Failure| {
            if is_passing(&failure) {
                return Err(failure);
            }
            let what = failure.what().replace(&format!("{}/", plan.dir().display()), "");
            Ok(refused(plan, &what))
        };
        let scenario = match scenes.scenario(key) {
            Ok(scenario) => scenario,
            Err(failure) => return row_of(failure),
        };
        let mut tries = 1;
        let answers = loop {
            match self.answers(plan, &scenario) {
                // What the machine refused it may grant the next time.
                Err(failure) if is_passing(&failure) && tries < TRIES => tries += 1,
                Err(failure) => return row_of(failure),
                Ok(answers) => break answers,
            }
        };
        let answered = |answer: Answer| {
            let answered = Answered::new(answer).map_err(|failure| failure.what().to_owned())?;
            Ok(answered)
        };
        Ok(answers.into_iter().map(answered).collect())
    }

    /// The answers under each policy and set of curves, curves varying fastest.
    fn answers(&mut self, plan: &Plan, scenario: &Scenario) -> Result<Vec<Answer>, Failure> {
        let engine = match &mut self.engine {
            Some(engine) => engine,
            none => none.insert(Engine::builder().in_process().body_cache(CACHE_BYTES).build()?),
        };
        let judges = &self.judges;
        let judged = catch_unwind(AssertUnwindSafe(|| judged(engine, judges, plan, scenario)));
        judged.unwrap_or_else(|_| {
            // Whatever it was in the middle of is not used again.
            self.engine = None;
            Err(Failure::internal(PANICKED))
        })
    }
}

/// The answers to one scene: searched once, and assessed under each policy and set of curves.
fn judged(
    engine: &mut Engine,
    judges: &[Judge],
    plan: &Plan,
    scenario: &Scenario,
) -> Result<Vec<Answer>, Failure> {
    let (begun_ns, limit_s) = (clock::now_ns(), plan.scene_limit_s());
    let in_time = || {
        if (clock::now_ns() - begun_ns) as f64 * 1e-9 < limit_s {
            return Ok(());
        }
        let what = format!("{LATE} {limit_s} s, the scene_limit_s of the study");
        Err(Failure::new(FailureKind::Refused, what))
    };
    let searched = engine.search(scenario, &Limits::default().with_deadline_ms(limit_s * 1e3)?);
    in_time()?;
    let searched = searched?;
    let answer = |judge: &Judge| {
        let answer = searched.assess(&judge.criteria(scenario)?, plan.worlds())?;
        in_time().map(|()| answer)
    };
    judges.iter().map(answer).collect()
}

/// The same refusal under each policy and set of curves.
fn refused(plan: &Plan, why: &str) -> Vec<Result<Answered, String>> {
    (0..plan.answers_per_scene()).map(|_| Err(why.to_owned())).collect()
}

/// What becomes of a scene of which processes died too often.
pub(crate) fn died(plan: &Plan) -> Vec<Result<Answered, String>> {
    refused(plan, &format!("{DIED}, {TRIES} times"))
}

/// Whether a refusal says nothing of the scene alone.
pub(crate) fn is_of_processes(refusal: &str) -> bool {
    OF_PROCESSES.iter().any(|begin| refusal.starts_with(begin))
}

/// Whether the machine is at fault, and not the scene.
fn is_passing(failure: &Failure) -> bool {
    matches!(failure.kind(), FailureKind::Resources | FailureKind::System | FailureKind::TryAgain)
}
