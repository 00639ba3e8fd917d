//! When a request stops, in which order its work is done, and in how large pieces.

use crate::{Failure, FailureKind};
use coordinator::{RequestLimits, SearchOrder, Until};
use core::time::Duration;
use scenario::{Members, Worlds};

/// Least budget: two full leaves are tested in one step.
const BUDGET_MIN: u64 = 2 * bvh::kernel::STEP_TESTS;
/// Longest deadline (ms), as in scenarios.
const DEADLINE_MS: f64 = 3_600_000.0;

/// When to stop, and what to keep besides the answer. No limit changes a complete answer.
///
/// ```
/// use trolley::{Limits, Until};
///
/// let limits = Limits::default().until(Until::Certified).with_deadline_ms(20.0)?;
/// assert!(Limits::default().with_deadline_ms(f64::NAN).is_err());
/// # Ok::<(), trolley::Failure>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Limits {
    until: Until,
    search_order: Option<SearchOrder>,
    explanation: bool,
    job_history: bool,
    deadline: Option<Duration>,
    budget: Option<u64>,
    members: Option<Members>,
    worlds: Option<Worlds>,
}

impl Limits {
    /// Stops as soon as this much is certain.
    ///
    /// ```
    /// use trolley::{Limits, Until};
    ///
    /// let limits = Limits::default().until(Until::Certified);
    /// assert_eq!(limits.request_limits(None).until, Until::Certified);
    /// ```
    #[must_use]
    pub fn until(self, until: Until) -> Self {
        Self { until, ..self }
    }

    /// Sets the order of the jobs, in place of the one that suits deadline and certainty.
    ///
    /// ```
    /// use trolley::{Limits, SearchOrder};
    ///
    /// let limits = Limits::default().with_search_order(SearchOrder::Deciding);
    /// assert_eq!(limits.request_limits(None).search_order, SearchOrder::Deciding);
    /// ```
    #[must_use]
    pub fn with_search_order(self, search_order: SearchOrder) -> Self {
        Self { search_order: Some(search_order), ..self }
    }

    /// Adds an [`Explanation`](crate::Explanation): the chain from contact to rank, with sources.
    ///
    /// ```
    /// # let scenario = trolley::Scenario::open("../../config/scenarios/small.toml")?;
    /// # let mut engine = trolley::Engine::builder().in_process().build()?;
    /// let limits = trolley::Limits::default().with_explanation();
    /// assert!(engine.rank(&scenario, &limits)?.explanation.is_some());
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    #[must_use]
    pub fn with_explanation(self) -> Self {
        Self { explanation: true, ..self }
    }

    /// Adds what a [`Record`](crate::Record) needs: an explanation, and the history of questions
    /// and jobs.
    ///
    /// ```
    /// # let scenario = trolley::Scenario::open("../../config/scenarios/small.toml")?;
    /// # let mut engine = trolley::Engine::builder().in_process().build()?;
    /// let limits = trolley::Limits::default().with_record();
    /// let ranking = engine.rank(&scenario, &limits)?; // for Record::write
    /// assert!(ranking.explanation.is_some());
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    #[must_use]
    pub fn with_record(self) -> Self {
        Self { explanation: true, job_history: true, ..self }
    }

    pub(crate) fn wants_explanation(&self) -> bool {
        self.explanation
    }

    pub(crate) fn wants_job_history(&self) -> bool {
        self.job_history
    }

    /// Sets a deadline (ms), in place of the scenario's: the answer then has bounds for what is not
    /// done. The clock starts when bodies are sealed and workers ready.
    ///
    /// ```
    /// # let scenario = trolley::Scenario::open("../../config/scenarios/small.toml")?;
    /// # let mut engine = trolley::Engine::builder().in_process().build()?;
    /// let limits = trolley::Limits::default().with_deadline_ms(50.0)?;
    /// let run = engine.rank(&scenario, &limits)?.run;
    /// assert!(run.deadline.is_some_and(|kept| kept.due_ms == 50.0));
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    ///
    /// # Errors
    ///
    /// If it is not between 0.001 and 3,600,000 ms.
    pub fn with_deadline_ms(self, ms: f64) -> Result<Self, Failure> {
        if (0.001..=DEADLINE_MS).contains(&ms) {
            return Ok(Self { deadline: Some(Duration::from_secs_f64(ms / 1e3)), ..self });
        }
        Err(Failure::new(FailureKind::Configuration, format!("--deadline-ms is {ms}"))
            .with_remedy(format!("--deadline-ms may be 0.001 to {DEADLINE_MS}")))
    }

    /// Limits one job to this many tests of boxes and triangles; what it leaves becomes new jobs.
    ///
    /// ```
    /// use trolley::Limits;
    ///
    /// let limits = Limits::default().with_budget(1 << 20)?;
    /// assert_eq!(limits.request_limits(None).budget, 1 << 20);
    /// assert!(Limits::default().with_budget(1).is_err());
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    ///
    /// # Errors
    ///
    /// If it is less than one step of a job may take.
    pub fn with_budget(self, tests: u64) -> Result<Self, Failure> {
        if tests >= BUDGET_MIN {
            return Ok(Self { budget: Some(tests), ..self });
        }
        Err(Failure::new(FailureKind::Configuration, format!("--budget is {tests}")).with_remedy(
            format!("--budget may be {BUDGET_MIN} or more: a step of a job takes half"),
        ))
    }

    /// Follows the candidates in so many members, and at most so many, in place of the scenario's
    /// numbers. 1: in the scene as stated alone. `most` is 128 where nothing is said, or `count`
    /// where that is more.
    ///
    /// ```
    /// # let scenario = trolley::Scenario::open("../../config/scenarios/small.toml")?;
    /// # let mut engine = trolley::Engine::builder().in_process().build()?;
    /// let limits = trolley::Limits::default().with_members(4, Some(4))?;
    /// let answer = engine.rank(&scenario, &limits)?.answer;
    /// assert_eq!(answer.members.map(|members| members.count), Some(4));
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    ///
    /// # Errors
    ///
    /// If `count` is not within 1 and 1,024, or `most` is less.
    pub fn with_members(self, count: i64, most: Option<i64>) -> Result<Self, Failure> {
        Ok(Self { members: Some(Self::members_of(count, most)?), ..self })
    }

    /// How many members these numbers ask for: see [`with_members`](Self::with_members).
    ///
    /// ```
    /// let members = trolley::Limits::members_of(32, None)?;
    /// assert_eq!((members.count, members.most), (32, 128));
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    ///
    /// # Errors
    ///
    /// As [`with_members`](Self::with_members).
    pub fn members_of(count: i64, most: Option<i64>) -> Result<Members, Failure> {
        Members::new(count, most).map_err(|misfit| {
            let option = misfit.setting.replace('_', "-");
            Failure::new(FailureKind::Configuration, misfit.what)
                .with_remedy(format!("--{option}: {}", misfit.remedy))
        })
    }

    /// How many members there are; `scenario` has the scenario's numbers, which hold if no others
    /// were set.
    pub(crate) fn members(&self, scenario: Members) -> Members {
        self.members.unwrap_or(scenario)
    }

    /// Draws these worlds where all work is done, in place of the usual ones.
    ///
    /// ```
    /// use trolley::{Limits, Worlds};
    ///
    /// # let scenario = trolley::Scenario::open("../../config/scenarios/small.toml")?;
    /// # let mut engine = trolley::Engine::builder().in_process().build()?;
    /// let limits = Limits::default().with_members(2, Some(2))?.with_worlds(Worlds::new(20, 1)?);
    /// let worlds = engine.rank(&scenario, &limits)?.answer.worlds;
    /// assert_eq!(worlds.map(|worlds| worlds.count), Some(20));
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    #[must_use]
    pub fn with_worlds(self, worlds: Worlds) -> Self {
        Self { worlds: Some(worlds), ..self }
    }

    /// Which worlds are drawn.
    pub(crate) fn worlds(&self) -> Worlds {
        self.worlds.unwrap_or(Worlds::USUAL)
    }

    /// Refuses what a search that suits every policy cannot keep to.
    pub(crate) fn check_search(&self) -> Result<(), Failure> {
        let refused = |what: &str| {
            let remedy = "leave it out, or rank the scenario under each policy";
            Err(Failure::setting(format!("a search for every policy has no {what}"))
                .with_remedy(remedy))
        };
        match self {
            Self { until: Until::Ordered | Until::Certified, .. } => refused("early end"),
            Self { budget: Some(_), .. } => refused("budget"),
            Self { job_history: true, .. } => refused("record"),
            Self { explanation: true, .. } => refused("explanation"),
            Self { .. } => Ok(()),
        }
    }

    /// Refuses limits that contradict each other.
    pub(crate) fn check(&self) -> Result<(), Failure> {
        if self.job_history && self.worlds.is_some_and(|worlds| worlds != Worlds::USUAL) {
            let failure = Failure::setting("a record holds no other worlds than the usual ones");
            return Err(failure.with_remedy("leave the worlds out, or the record"));
        }
        match (self.budget, self.job_history) {
            (Some(_), true) => {
                let what = "a record holds no parts of jobs, so a budget cannot be replayed";
                Err(Failure::setting(what).with_remedy("leave the budget out, or the record"))
            }
            _ => Ok(()),
        }
    }

    /// Returns when the answer is due, counted from when the request was accepted. `scenario` is
    /// the scenario's deadline, which holds if no other was set.
    ///
    /// ```
    /// use std::time::Duration;
    ///
    /// let limits = trolley::Limits::default();
    /// let [own, stated] = [20, 100].map(Duration::from_millis);
    /// assert_eq!(limits.deadline(Some(stated)), Some(stated));
    /// assert_eq!(limits.with_deadline_ms(20.0)?.deadline(Some(stated)), Some(own));
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    #[must_use]
    pub fn deadline(&self, scenario: Option<Duration>) -> Option<Duration> {
        self.deadline.or(scenario)
    }

    /// Returns the limits in the form that the coordinator takes; `scenario` as in
    /// [`deadline`](Self::deadline).
    ///
    /// ```
    /// let limits = trolley::Limits::default().with_deadline_ms(20.0)?;
    /// assert!(limits.request_limits(None).deadline_ns.is_some_and(|ns| ns < 20_000_000));
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    #[must_use]
    pub fn request_limits(&self, scenario: Option<Duration>) -> RequestLimits {
        let deadline = self.deadline(scenario);
        let is_early = self.until != Until::Complete || deadline.is_some();
        let usual = if is_early { SearchOrder::Deciding } else { SearchOrder::AsAsked };
        // A replay repeats the jobs of a job history, and cannot split them.
        let budget = match (self.budget, deadline) {
            (Some(budget), _) => budget,
            (None, Some(_)) if !self.job_history => RequestLimits::BUDGET,
            (None, _) => u64::MAX,
        };
        RequestLimits {
            until: self.until,
            deadline_ns: deadline.map(RequestLimits::guarded),
            search_order: self.search_order.unwrap_or(usual),
            budget,
        }
    }
}
