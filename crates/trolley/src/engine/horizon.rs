//! Rankings of scenarios over a horizon.

use super::loaded::Subject;
use super::{Begun, Engine, Recorded, RecordedHistory, applied};
use crate::Failure;
use crate::bodies::{OnProgress, PartyBody, SILENT};
use crate::horizon::Horizon;
use crate::limits::Limits;
use crate::run::{Kept, Run, Stages, milliseconds};
use body::BodyKind;
use coordinator::{
    BodySet, CourseAnswer, CourseExplanation, CourseRequest, PlanScene, RankedCourses,
};
use runtime::clock;

/// A scenario over a horizon, ranked.
///
/// ```
/// # let horizon = trolley::Horizon::open("../../config/scenarios/crossing.toml")?;
/// # let mut engine = trolley::Engine::builder().in_process().build()?;
/// let ranking = engine.rank_horizon(&horizon, &trolley::Limits::default())?;
/// println!("{} after {} ms", ranking.answer.state.name(), ranking.run.stages.plan_ms);
/// # Ok::<(), trolley::Failure>(())
/// ```
#[derive(Clone, Debug)]
pub struct HorizonRanking {
    /// The answer. A complete one is the same, byte for byte, with and without workers.
    pub answer: CourseAnswer,
    /// Every figure from contact to rank, if it was requested.
    pub explanation: Option<CourseExplanation>,
    /// How the work was done.
    pub run: Run,
    /// What a record is made from, if one was requested.
    pub(crate) recorded: Option<Recorded>,
}

impl Engine {
    /// Ranks a scenario over a horizon: every candidate among everybody around.
    ///
    /// ```
    /// # let horizon = trolley::Horizon::open("../../config/scenarios/crossing.toml")?;
    /// # let mut engine = trolley::Engine::builder().in_process().build()?;
    /// let ranking = engine.rank_horizon(&horizon, &trolley::Limits::default())?;
    /// let best = ranking.answer.best().expect("every candidate has bounds");
    /// println!("least harm: {}", best.name);
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    ///
    /// # Errors
    ///
    /// As [`Engine::rank`].
    pub fn rank_horizon(
        &mut self,
        horizon: &Horizon,
        limits: &Limits,
    ) -> Result<HorizonRanking, Failure> {
        self.rank_horizon_telling(horizon, limits, SILENT)
    }

    /// Ranks like [`rank_horizon`](Self::rank_horizon), and reports how far the bodies are built.
    ///
    /// ```
    /// # let horizon = trolley::Horizon::open("../../config/scenarios/crossing.toml")?;
    /// # let mut engine = trolley::Engine::builder().in_process().build()?;
    /// let progress = |done, total| eprintln!("{done} of {total} triangles");
    /// let limits = trolley::Limits::default();
    /// let ranking = engine.rank_horizon_telling(&horizon, &limits, &progress)?;
    /// assert_eq!(ranking.answer.ranking.len(), 3);
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    ///
    /// # Errors
    ///
    /// As [`Engine::rank_horizon`].
    pub fn rank_horizon_telling(
        &mut self,
        horizon: &Horizon,
        limits: &Limits,
        progress: OnProgress<'_>,
    ) -> Result<HorizonRanking, Failure> {
        self.rank_horizon_drawn(horizon, limits, progress, None)
    }

    /// Ranks like [`rank_horizon_telling`](Self::rank_horizon_telling), and fills in what a picture
    /// of it is drawn from, if that is wanted.
    ///
    /// ```
    /// # let horizon = trolley::Horizon::open("../../config/scenarios/crossing.toml")?;
    /// # let mut engine = trolley::Engine::builder().in_process().build()?;
    /// let limits = trolley::Limits::default();
    /// let mut scene = trolley::PlanScene::default();
    /// engine.rank_horizon_drawn(&horizon, &limits, &|_, _| {}, Some(&mut scene))?;
    /// assert_eq!((scene.courses.len(), scene.parties[scene.ego].name.as_str()), (3, "ego"));
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    ///
    /// # Errors
    ///
    /// As [`Engine::rank_horizon`].
    pub fn rank_horizon_drawn(
        &mut self,
        horizon: &Horizon,
        limits: &Limits,
        progress: OnProgress<'_>,
        drawn: Option<&mut PlanScene>,
    ) -> Result<HorizonRanking, Failure> {
        let begun_ns = clock::now_ns();
        horizon.check_unknown()?;
        let scenario = horizon.parsed();
        let settings = applied(&scenario.engine, &self.settings.overrides)?;
        limits.check()?;
        let request_limits = limits.request_limits(scenario.deadline);
        horizon.check_references()?;
        let all = horizon.bodies();
        let (unique, models) = PartyBody::unique(&all);
        let check_kinds = |kinds: &[BodyKind]| {
            let kinds: Vec<BodyKind> = models.iter().map(|model| kinds[*model]).collect();
            scenario.check_kinds(horizon.file(), &kinds)
        };
        let subject = Subject {
            file: horizon.file(),
            bodies: unique,
            needs_shells: true,
            find: &|reference| horizon.path_of(reference),
            check_kinds: &check_kinds,
        };
        let begun = self.begin(&subject, &settings, request_limits.deadline_ns, progress)?;
        let Begun { loaded, mut backend, run, loaded_ns, started_ns } = begun;
        let views = loaded.bodies.views()?;
        let stage =
            BodySet { bodies: &views, extremes: loaded.extremes.as_deref(), depth: settings.depth };
        let (shells, rules) = (&loaded.shells[..], horizon.rules());
        let request = CourseRequest {
            scenario,
            models: &models,
            shells,
            rules,
            history: limits.wants_job_history(),
            explanation: limits.wants_explanation(),
            scene: drawn.is_some(),
        };
        // Workers that could not finish are not used again.
        let RankedCourses { answer, effort, reports, history, explanation, scene } =
            coordinator::rank_courses(&stage, &request, request_limits, &mut backend)?;
        if let (Some(drawn), Some(scene)) = (drawn, scene) {
            *drawn = scene;
        }
        let answered_ns = clock::now_ns();
        loaded.backend = Some(backend);
        let mut run = run.with_courses(&effort, reports, loaded.bodies.store().bytes().len());
        run.stages = Stages {
            load_ms: milliseconds(loaded_ns - begun_ns),
            plan_ms: milliseconds(effort.search_ns),
            start_ms: milliseconds(started_ns - loaded_ns),
            work_ms: milliseconds(effort.surveys_ns),
            assess_ms: milliseconds(effort.judge_ns),
            stop_ms: 0.0,
        };
        let due = limits.deadline(scenario.deadline);
        let took_ns = answered_ns.saturating_sub(effort.accepted_ns);
        run.deadline = due.map(|due| Kept::of(due, took_ns));
        let recorded = history.map(|history| Recorded {
            texts: horizon.texts.clone(),
            files: horizon.files.clone(),
            unknown_is_fixed: horizon.unknown_is_fixed,
            history: RecordedHistory::Rounds(history),
            settings,
            bodies: loaded.bodies.recorded(&all, &models),
        });
        Ok(HorizonRanking { answer, explanation, run, recorded })
    }
}
