//! Rankings of scenarios.

use super::loaded::Subject;
use super::{Begun, Engine, Recorded, applied};
use crate::Failure;
use crate::bodies::{OnProgress, PartyBody, SILENT};
use crate::limits::Limits;
use crate::plausibility;
use crate::run::{Kept, Run, Stages, milliseconds};
use crate::scenario::Scenario;
use body::BodyKind;
use coordinator::{
    Answer, BodySet, CourseRequest, CourseRow, Explanation, PlanScene, RankedCourses,
};
use runtime::clock;

/// A scenario, ranked.
///
/// ```
/// # let scenario = trolley::Scenario::open("../../config/scenarios/crossing.toml")?;
/// # let mut engine = trolley::Engine::builder().in_process().build()?;
/// let ranking = engine.rank(&scenario, &trolley::Limits::default())?;
/// println!("{} after {} ms", ranking.answer.state.name(), ranking.run.stages.plan_ms);
/// # Ok::<(), trolley::Failure>(())
/// ```
#[derive(Clone, Debug)]
pub struct Ranking {
    /// The answer. A complete one is the same, byte for byte, with and without workers.
    pub answer: Answer,
    /// Every figure from contact to rank, if it was requested.
    pub explanation: Option<Explanation>,
    /// How the work was done.
    pub run: Run,
    /// What a record is made from, if one was requested.
    pub(crate) recorded: Option<Recorded>,
}

impl Engine {
    /// Ranks a scenario: every candidate among everybody around.
    ///
    /// ```
    /// # let scenario = trolley::Scenario::open("../../config/scenarios/crossing.toml")?;
    /// # let mut engine = trolley::Engine::builder().in_process().build()?;
    /// let ranking = engine.rank(&scenario, &trolley::Limits::default())?;
    /// let best = ranking.answer.best().expect("every candidate has bounds");
    /// println!("least harm: {}", best.name);
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    ///
    /// # Errors
    ///
    /// If a body cannot be loaded, the scenario cannot be ranked, or the machine refuses what
    /// workers need. An incomplete answer is not an error: see [`Answer::state`].
    pub fn rank(&mut self, scenario: &Scenario, limits: &Limits) -> Result<Ranking, Failure> {
        self.rank_telling(scenario, limits, SILENT)
    }

    /// Ranks like [`rank`](Self::rank), and reports how far the bodies are built.
    ///
    /// ```
    /// # let scenario = trolley::Scenario::open("../../config/scenarios/crossing.toml")?;
    /// # let mut engine = trolley::Engine::builder().in_process().build()?;
    /// let progress = |done, total| eprintln!("{done} of {total} triangles");
    /// let limits = trolley::Limits::default();
    /// let ranking = engine.rank_telling(&scenario, &limits, &progress)?;
    /// assert_eq!(ranking.answer.ranking.len(), 3);
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    ///
    /// # Errors
    ///
    /// As [`Engine::rank`].
    pub fn rank_telling(
        &mut self,
        scenario: &Scenario,
        limits: &Limits,
        progress: OnProgress<'_>,
    ) -> Result<Ranking, Failure> {
        self.rank_drawn(scenario, limits, progress, None)
    }

    /// Ranks like [`rank_telling`](Self::rank_telling), and fills in what a picture
    /// of it is drawn from, if that is wanted.
    ///
    /// ```
    /// # let scenario = trolley::Scenario::open("../../config/scenarios/crossing.toml")?;
    /// # let mut engine = trolley::Engine::builder().in_process().build()?;
    /// let limits = trolley::Limits::default();
    /// let mut scene = trolley::plan::PlanScene::default();
    /// engine.rank_drawn(&scenario, &limits, &|_, _| {}, Some(&mut scene))?;
    /// assert_eq!((scene.courses.len(), scene.parties[scene.ego].name.as_str()), (3, "ego"));
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    ///
    /// # Errors
    ///
    /// As [`Engine::rank`].
    pub fn rank_drawn(
        &mut self,
        scenario: &Scenario,
        limits: &Limits,
        progress: OnProgress<'_>,
        drawn: Option<&mut PlanScene>,
    ) -> Result<Ranking, Failure> {
        let begun_ns = clock::now_ns();
        scenario.check_unknown()?;
        let parsed = scenario.parsed();
        let settings = applied(&parsed.engine, &self.settings.overrides)?;
        limits.check()?;
        let request_limits = limits.request_limits(parsed.deadline);
        let members = limits.members(parsed.members());
        scenario.check_references()?;
        let all = scenario.bodies();
        let (unique, models) = PartyBody::unique(&all);
        let check_kinds = |kinds: &[BodyKind]| {
            let kinds: Vec<BodyKind> = models.iter().map(|model| kinds[*model]).collect();
            parsed.check_kinds(scenario.file(), &kinds)
        };
        let subject = Subject {
            file: scenario.file(),
            bodies: unique,
            find: &|reference| scenario.path_of(reference),
            check_kinds: &check_kinds,
        };
        let begun = self.begin(&subject, &settings, request_limits.deadline_ns, progress)?;
        let Begun { loaded, mut backend, run, loaded_ns, started_ns } = begun;
        let views = loaded.bodies.views()?;
        // Before the clock of a deadline starts.
        let implausible = plausibility::of_scenario(parsed, &views, &models);
        let stage =
            BodySet { bodies: &views, extremes: loaded.extremes.as_deref(), depth: settings.depth };
        let (shells, criteria) = (&loaded.shells[..], scenario.criteria().clone());
        let request = CourseRequest {
            scenario: parsed,
            models: &models,
            shells,
            criteria,
            members,
            history: limits.wants_job_history(),
            explanation: limits.wants_explanation(),
            scene: drawn.is_some(),
        };
        // Workers that could not finish are not used again.
        let RankedCourses { answer, effort, reports, history, explanation, scene } =
            coordinator::rank_courses(&stage, &request, request_limits, &mut backend)?;
        let answer = plausibility::stated(answer, implausible);
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
            worlds_ms: milliseconds(effort.worlds_ns),
            stop_ms: 0.0,
        };
        let due = limits.deadline(parsed.deadline);
        let took_ns = answered_ns.saturating_sub(effort.accepted_ns);
        run.deadline = due.map(|due| Kept::of(due, took_ns));
        let recorded = history.map(|history| Recorded {
            texts: scenario.texts.clone(),
            files: scenario.files.clone(),
            unknown_is_fixed: scenario.unknown_is_fixed,
            members,
            history,
            settings,
            bodies: loaded.bodies.recorded(&all, &models),
        });
        Ok(Ranking { answer, explanation, run, recorded })
    }
}

impl Ranking {
    /// Returns the candidate of least harm, if there is one: see [`Answer::best`].
    ///
    /// ```
    /// # let scenario = trolley::Scenario::open("../../config/scenarios/small.toml")?;
    /// # let mut engine = trolley::Engine::builder().in_process().build()?;
    /// let ranking = engine.rank(&scenario, &trolley::Limits::default())?;
    /// if let Some(best) = ranking.best() {
    ///     println!("least harm: {}", best.name);
    /// }
    /// # assert!(ranking.best().is_some());
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    #[must_use]
    pub fn best(&self) -> Option<&CourseRow> {
        self.answer.best()
    }
}
