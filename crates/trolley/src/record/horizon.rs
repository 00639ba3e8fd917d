//! Replaying a recorded ranking over a horizon.

use super::replay::source_text;
use super::{Record, line};
use crate::Failure;
use crate::bodies::{Bodies, OnProgress, PartyBody};
use crate::horizon::Horizon;
use body::Shells;
use coordinator::{
    BodySet, CourseAnswer, CourseExplanation, CourseHistory, CourseRequest, RankedCourses,
};
use scenario::FileRef;
use std::path::Path;

/// A ranking over a horizon that was repeated from its record, as far as it had come.
///
/// ```
/// # use trolley::{Engine, Horizon, Limits, Record};
/// # let folder = std::env::temp_dir().join(format!("trolley-again-{}", std::process::id()));
/// # std::fs::create_dir_all(&folder).ok();
/// # let horizon = Horizon::open("../../config/scenarios/crossing.toml")?;
/// # let mut engine = Engine::builder().in_process().build()?;
/// # let ranking = engine.rank_horizon(&horizon, &Limits::default().with_record())?;
/// # let path = Record::write(&folder, &ranking)?;
/// # let record = Record::read(&path)?;
/// let replay = record.replay_horizon(&path, None, trolley::bodies::SILENT)?;
/// assert_eq!(replay.answer.ranking.len(), 3);
/// # std::fs::remove_dir_all(&folder).ok();
/// # Ok::<(), trolley::Failure>(())
/// ```
#[derive(Debug)]
pub struct HorizonReplay {
    /// The scenario.
    pub horizon: Horizon,
    /// The answer.
    pub answer: CourseAnswer,
    /// Its explanation.
    pub explanation: Option<CourseExplanation>,
    /// How many jobs it took.
    pub jobs: u64,
    /// The answer as JSON, as it would be recorded.
    pub json: String,
}

impl Record {
    /// Repeats the recorded ranking over a horizon. `file` is the record's name in messages;
    /// `models` is the folder of the model files, which are found by their hash. Nothing else is
    /// read: paths from CSV files are in the record.
    ///
    /// ```
    /// # use trolley::{Engine, Horizon, Limits, Record};
    /// # let folder = std::env::temp_dir().join(format!("trolley-late-{}", std::process::id()));
    /// # std::fs::create_dir_all(&folder).ok();
    /// # let horizon = Horizon::open("../../config/scenarios/crossing.toml")?;
    /// # let mut engine = Engine::builder().in_process().build()?;
    /// // Not all is known after so short a time. What was known is in the record.
    /// let limits = Limits::default().with_deadline_ms(0.5)?.with_record();
    /// let ranking = engine.rank_horizon(&horizon, &limits)?;
    /// let path = Record::write(&folder, &ranking)?;
    /// let record = Record::read(&path)?;
    /// let replay = record.replay_horizon(&path, None, trolley::bodies::SILENT)?;
    /// assert_eq!(replay.json, record.content.answer);
    /// # std::fs::remove_dir_all(&folder).ok();
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    ///
    /// # Errors
    ///
    /// If a text or a body is not the recorded one, a body is missing, or the scenario is one of
    /// pairs at impact: see [`Record::replay`]. A different answer is not an error: compare
    /// [`HorizonReplay::json`] with [`RecordContent::answer`](super::RecordContent::answer).
    pub fn replay_horizon(
        &self,
        file: &Path,
        models: Option<&Path>,
        progress: OnProgress<'_>,
    ) -> Result<HorizonReplay, Failure> {
        let content = &self.content;
        if !content.is_over_horizon() {
            return Err(Failure::input("its scenario is not one over a horizon")
                .at(file.display())
                .with_remedy("compute it again with `trolley record replay`"));
        }
        self.check_texts(file)?;
        let files = content.files.iter().map(source_text).collect();
        let horizon = Horizon::of_texts(self.texts(), files)?;
        let (scenario, all) = (horizon.parsed(), horizon.bodies());
        let (unique, numbers) = PartyBody::unique(&all);
        let found = self.found(file, models)?;
        // Parties with one body have one model file.
        let path_of = |number: usize, _: &FileRef| {
            let party = numbers.iter().position(|known| *known == number);
            party.and_then(|party| found.get(&party)).cloned().unwrap_or_default()
        };
        let engine = self.engine()?;
        let bodies = Bodies::of_parties(&unique, &engine, horizon.file(), &path_of, progress)?;
        let kinds = numbers.iter().map(|number| bodies[*number].kind()).collect::<Vec<_>>();
        scenario.check_kinds(horizon.file(), &kinds)?;
        let bodies = Bodies::seal(bodies)?;
        self.compare(file, &bodies.recorded(&all, &numbers))?;
        let views = bodies.views()?;
        let shells: Vec<Shells> = views.iter().map(|(_, view)| Shells::of(view.corners)).collect();
        let stage = BodySet { bodies: &views, extremes: None, depth: content.settings.depth };
        let request = CourseRequest {
            scenario,
            models: &numbers,
            shells: &shells,
            rules: horizon.rules(),
            history: false,
            explanation: true,
            scene: false,
        };
        let (until, search, rounds) = (content.until, content.search, content.rounds.clone());
        let history = CourseHistory { until, search, rounds };
        let ranked = coordinator::replay_courses(&stage, &request, &history)?;
        let RankedCourses { answer, explanation, effort, .. } = ranked;
        let jobs = effort.jobs_in_process;
        let json = line(&answer)?;
        drop(all);
        Ok(HorizonReplay { horizon, answer, explanation, jobs, json })
    }

    /// Checks that a scenario over a horizon is the recorded one: its text, its policy, its curves,
    /// its paths, and the files of its bodies. `file` is the record's name in messages.
    ///
    /// ```
    /// # use trolley::{Engine, Horizon, Limits, Record};
    /// # let folder = std::env::temp_dir().join(format!("trolley-alike-{}", std::process::id()));
    /// # std::fs::create_dir_all(&folder).ok();
    /// # let horizon = Horizon::open("../../config/scenarios/crossing.toml")?;
    /// # let mut engine = Engine::builder().in_process().build()?;
    /// # let ranking = engine.rank_horizon(&horizon, &Limits::default().with_record())?;
    /// # let path = Record::write(&folder, &ranking)?;
    /// # let record = Record::read(&path)?;
    /// assert!(record.check_horizon(&path, &horizon).is_ok());
    /// # std::fs::remove_dir_all(&folder).ok();
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    ///
    /// # Errors
    ///
    /// If one of them differs, or a body's file cannot be read.
    pub fn check_horizon(&self, file: &Path, horizon: &Horizon) -> Result<(), Failure> {
        let path_of = |reference: &FileRef| horizon.path_of(reference);
        let texts = (&horizon.texts, &horizon.files[..]);
        self.check_sources(file, texts, &horizon.bodies(), &path_of)
    }
}
