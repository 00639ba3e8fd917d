//! Rankings of scenarios.

use super::loaded::Subject;
use super::{Begun, Engine, Recorded, Settings, applied};
use crate::bodies::{Bodies, OnProgress, PartyBody, SILENT};
use crate::limits::Limits;
use crate::plausibility;
use crate::run::{Kept, Run, Stages, milliseconds};
use crate::scenario::Scenario;
use crate::{Failure, FailureKind};
use ::scenario::{Implausible, Worlds};
use body::BodyKind;
use coordinator::{
    Answer, Backend, BodySet, CourseRequest, CourseRow, Explanation, PlanScene, RankedCourses,
    SearchedCourses,
};
use damage::Criteria;
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
        limits.check()?;
        let deadline = scenario.parsed().deadline;
        let request_limits = limits.request_limits(deadline);
        self.settings.check_limits(&request_limits, limits.wants_job_history())?;
        let due_ns = request_limits.deadline_ns;
        let is_drawn = drawn.is_some();
        let (ranking, scene) = self.with_scene(scenario, limits, due_ns, progress, |scene| {
            let Scene { stage, request, bodies, run, times_ns, .. } = scene;
            let request = CourseRequest {
                history: limits.wants_job_history(),
                explanation: limits.wants_explanation(),
                scene: is_drawn,
                ..request
            };
            // Workers that could not finish are not used again.
            let RankedCourses { answer, effort, reports, history, explanation, scene: picture } =
                coordinator::rank_courses(&stage, &request, request_limits, scene.backend)?;
            let answer = plausibility::stated(answer, scene.implausible);
            let answered_ns = clock::now_ns();
            let mut run = run.with_courses(&effort, reports, bodies.store().bytes().len());
            let [loaded_ns, started_ns] = times_ns;
            run.stages = Stages {
                load_ms: milliseconds(loaded_ns - begun_ns),
                plan_ms: milliseconds(effort.search_ns),
                start_ms: milliseconds(started_ns - loaded_ns),
                work_ms: milliseconds(effort.surveys_ns),
                assess_ms: milliseconds(effort.assess_ns + effort.judge_ns),
                worlds_ms: milliseconds(effort.worlds_ns),
                stop_ms: 0.0,
            };
            let took_ns = answered_ns.saturating_sub(effort.accepted_ns);
            run.deadline = limits.deadline(deadline).map(|due| Kept::of(due, took_ns));
            let recorded = history.map(|history| Recorded {
                texts: scenario.texts.clone(),
                files: scenario.files.clone(),
                unknown_is_fixed: scenario.unknown_is_fixed,
                members: request.members,
                history,
                settings: scene.settings.clone(),
                bodies: bodies.recorded(&scenario.bodies(), request.models),
            });
            Ok((Ranking { answer, explanation, run, recorded }, picture))
        })?;
        if let (Some(drawn), Some(scene)) = (drawn, scene) {
            *drawn = scene;
        }
        Ok(ranking)
    }

    /// Searches a scenario for all that any policy and any curves may ask of it, to be assessed
    /// without geometry as often as wanted. It follows as many members as `limits`, or the
    /// scenario, allow at most, so it may take longer than a ranking. One that is not done by a
    /// deadline of `limits` is refused; a deadline that the scenario states does not count.
    ///
    /// ```
    /// use trolley::{Limits, Scenario, Worlds};
    ///
    /// let scenario = Scenario::open("../../config/scenarios/crossing.toml")?;
    /// let mut engine = trolley::Engine::builder().in_process().build()?;
    /// let limits = Limits::default().with_members(4, Some(8))?;
    /// let searched = engine.search(&scenario, &limits)?;
    /// for name in trolley::policy_names() {
    ///     let judged = scenario.clone().with_policy(trolley::read_policy(name.as_ref())?)?;
    ///     let answer = searched.assess(judged.criteria(), Worlds::USUAL)?;
    ///     assert_eq!(answer, engine.rank(&judged, &limits)?.answer);
    /// }
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    ///
    /// # Errors
    ///
    /// As [`Engine::rank`]; if `limits` end work early, or ask for an explanation or a record; if
    /// there was no time for it, or a worker lost work, so that harm has bounds only.
    pub fn search(&mut self, scenario: &Scenario, limits: &Limits) -> Result<Searched, Failure> {
        limits.check_search()?;
        self.with_scene(scenario, limits, None, SILENT, |scene| {
            let Scene { stage, request, implausible, backend, .. } = scene;
            let deadline = limits.deadline(None);
            // Below an hour.
            let due_ns = deadline.map(|length| clock::now_ns() + length.as_nanos() as u64);
            let courses = coordinator::search_courses(&stage, &request, due_ns, backend)?;
            let lost = || {
                if let Some(length) = deadline
                    && due_ns.is_some_and(|due_ns| clock::now_ns() >= due_ns)
                {
                    let what = format!("it was not searched within {} s", length.as_secs_f64());
                    return Failure::new(FailureKind::Refused, what)
                        .at(scenario.file())
                        .with_remedy("allow more time, or fewer members");
                }
                let failure = Failure::new(FailureKind::System, "work of the search was lost");
                failure.at(scenario.file()).with_remedy("search it again, or rank it")
            };
            Ok(Searched { courses: courses.ok_or_else(lost)?, implausible })
        })
    }

    /// Does work on a scenario, once its bodies are loaded and what runs jobs is ready.
    fn with_scene<T>(
        &mut self,
        scenario: &Scenario,
        limits: &Limits,
        due_ns: Option<u64>,
        progress: OnProgress<'_>,
        work: impl FnOnce(Scene<'_>) -> Result<T, Failure>,
    ) -> Result<T, Failure> {
        scenario.check_unknown()?;
        let parsed = scenario.parsed();
        let settings = applied(&parsed.engine, &self.settings.overrides)?;
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
        let begun = self.begin(&subject, &settings, due_ns, progress)?;
        let Begun { loaded, mut backend, run, loaded_ns, started_ns } = begun;
        let views = loaded.bodies.views()?;
        // Before the clock of a deadline starts.
        let implausible = plausibility::of_scenario(parsed, &views, &models);
        let stage =
            BodySet { bodies: &views, extremes: loaded.extremes.as_deref(), depth: settings.depth };
        let request = CourseRequest {
            scenario: parsed,
            models: &models,
            shells: &loaded.shells,
            criteria: scenario.criteria().clone(),
            members: limits.members(parsed.members()),
            worlds: limits.worlds(),
            history: false,
            explanation: false,
            scene: false,
        };
        let done = work(Scene {
            stage,
            request,
            bodies: &loaded.bodies,
            settings: &settings,
            implausible,
            run,
            times_ns: [loaded_ns, started_ns],
            backend: &mut backend,
        })?;
        drop(views);
        loaded.backend = Some(backend);
        Ok(done)
    }
}

/// A scenario whose bodies are loaded, and what runs its jobs.
struct Scene<'s> {
    stage: BodySet<'s>,
    request: CourseRequest<'s>,
    bodies: &'s Bodies,
    settings: &'s Settings,
    implausible: Vec<Implausible>,
    /// With nothing done yet.
    run: Run,
    /// When bodies were loaded, and when what runs jobs was ready (ns).
    times_ns: [u64; 2],
    backend: &'s mut Backend,
}

/// A scenario, searched: whom every candidate meets, where and how, whatever the policy.
///
/// It needs neither its engine nor bodies any more, and may be used by several threads.
///
/// ```
/// # let scenario = trolley::Scenario::open("../../config/scenarios/small.toml")?;
/// # let mut engine = trolley::Engine::builder().in_process().build()?;
/// let searched = engine.search(&scenario, &trolley::Limits::default().with_members(1, None)?)?;
/// drop(engine);
/// let answer = searched.assess(scenario.criteria(), trolley::Worlds::USUAL)?;
/// assert_eq!(answer.ranking.len(), 4);
/// # Ok::<(), trolley::Failure>(())
/// ```
#[derive(Clone, Debug)]
pub struct Searched {
    courses: SearchedCourses,
    implausible: Vec<Implausible>,
}

impl Searched {
    /// Returns the answer under a policy and curves: that of [`Engine::rank`] of the scenario with
    /// these and without a deadline, byte for byte. Without members no worlds are drawn.
    ///
    /// ```
    /// # let scenario = trolley::Scenario::open("../../config/scenarios/small.toml")?;
    /// # let mut engine = trolley::Engine::builder().in_process().build()?;
    /// # let limits = trolley::Limits::default().with_members(2, Some(2))?;
    /// # let searched = engine.search(&scenario, &limits)?;
    /// use trolley::Worlds;
    ///
    /// let answer = searched.assess(scenario.criteria(), Worlds::new(50, 7)?)?;
    /// assert_eq!(answer.worlds.map(|worlds| worlds.count), Some(50));
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    ///
    /// # Errors
    ///
    /// If a ranking had an error, or the parameters are others than those of the search.
    pub fn assess(&self, criteria: &Criteria, worlds: Worlds) -> Result<Answer, Failure> {
        let answer = self.courses.assess(criteria, worlds)?;
        Ok(plausibility::stated(answer, self.implausible.clone()))
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
