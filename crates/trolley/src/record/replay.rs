//! Replaying a recorded ranking.

use super::{Record, line};
use crate::bodies::{Bodies, OnProgress, PartyBody};
use crate::plausibility;
use crate::scenario::Scenario;
use crate::texts::{SourceText, Texts};
use crate::{BUILD, Failure, FailureKind};
use body::Shells;
use coordinator::{
    Answer, BodySet, CourseHistory, CourseRequest, Explanation, PlanScene, RankedCourses,
};
use record::{RecordContent, RecordedSource, RecordedText};
use runtime::{FileMap, InputKind};
use scenario::{EngineSettings, FileRef, Members, Overrides, Source};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// A ranking that was repeated from its record, with the same jobs.
///
/// ```
/// # use trolley::{Engine, Limits, Record, Scenario};
/// # let folder = std::env::temp_dir().join(format!("trolley-replay-{}", std::process::id()));
/// # std::fs::create_dir_all(&folder).ok();
/// # let scenario = Scenario::open("../../config/scenarios/small.toml")?;
/// # let mut engine = Engine::builder().in_process().build()?;
/// # let ranking = engine.rank(&scenario, &Limits::default().with_record())?;
/// # let path = Record::write(&folder, &ranking)?;
/// # let record = Record::read(&path)?;
/// let replay = record.replay(&path, None, trolley::bodies::SILENT)?;
/// assert_eq!(replay.answer, ranking.answer);
/// # std::fs::remove_dir_all(&folder).ok();
/// # Ok::<(), trolley::Failure>(())
/// ```
#[derive(Debug)]
pub struct Replay {
    /// The scenario.
    pub scenario: Scenario,
    /// The answer.
    pub answer: Answer,
    /// Its explanation.
    pub explanation: Option<Explanation>,
    /// Where everybody is over time, and what is hit, for pictures.
    pub scene: PlanScene,
    /// The bodies of the parties, each once: [`ContactScene`](crate::plan::ContactScene)s name them
    /// by number.
    pub bodies: Bodies,
    /// How many jobs it took.
    pub jobs: u64,
    /// The answer as JSON, as it would be recorded.
    pub json: String,
}

impl Record {
    /// Returns whether this build wrote the record.
    ///
    /// ```
    /// # use trolley::{Engine, Limits, Record, Scenario};
    /// # let folder = std::env::temp_dir().join(format!("trolley-build-{}", std::process::id()));
    /// # std::fs::create_dir_all(&folder).ok();
    /// # let scenario = Scenario::open("../../config/scenarios/small.toml")?;
    /// # let mut engine = Engine::builder().in_process().build()?;
    /// # let ranking = engine.rank(&scenario, &Limits::default().with_record())?;
    /// # let path = Record::write(&folder, &ranking)?;
    /// # let record = Record::read(&path)?;
    /// assert!(record.is_of_this_build());
    /// # std::fs::remove_dir_all(&folder).ok();
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    #[must_use]
    pub fn is_of_this_build(&self) -> bool {
        self.content.build == BUILD
    }

    /// Repeats the recorded ranking. `file` is the record's name in messages; `models` is the
    /// folder of the model files, which are found by their hash.
    ///
    /// ```
    /// # use trolley::{Engine, Limits, Record, Scenario};
    /// # let folder = std::env::temp_dir().join(format!("trolley-method-{}", std::process::id()));
    /// # std::fs::create_dir_all(&folder).ok();
    /// # let scenario = Scenario::open("../../config/scenarios/small.toml")?;
    /// # let mut engine = Engine::builder().in_process().build()?;
    /// # let ranking = engine.rank(&scenario, &Limits::default().with_record())?;
    /// # let path = Record::write(&folder, &ranking)?;
    /// # let record = Record::read(&path)?;
    /// let replay = record.replay(&path, None, trolley::bodies::SILENT)?;
    /// assert_eq!(replay.json, record.content.answer);
    /// # std::fs::remove_dir_all(&folder).ok();
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    ///
    /// # Errors
    ///
    /// If a text or a body is not the recorded one, or a body is missing. A different answer is not
    /// an error: compare [`Replay::json`] with
    /// [`RecordContent::answer`](super::RecordContent::answer).
    pub fn replay(
        &self,
        file: &Path,
        models: Option<&Path>,
        progress: OnProgress<'_>,
    ) -> Result<Replay, Failure> {
        let content = &self.content;
        self.check_texts(file)?;
        let files = content.files.iter().map(source_text).collect();
        let scenario = Scenario::of_texts(self.texts(), files)?;
        let (parsed, all) = (scenario.parsed(), scenario.bodies());
        let (unique, numbers) = PartyBody::unique(&all);
        let found = self.found(file, models)?;
        // Parties with one body have one model file.
        let path_of = |number: usize, _: &FileRef| {
            let party = numbers.iter().position(|known| *known == number);
            party.and_then(|party| found.get(&party)).cloned().unwrap_or_default()
        };
        let engine = self.engine()?;
        let bodies = Bodies::of_parties(&unique, &engine, scenario.file(), &path_of, progress)?;
        let kinds = numbers.iter().map(|number| bodies[*number].kind()).collect::<Vec<_>>();
        parsed.check_kinds(scenario.file(), &kinds)?;
        let bodies = Bodies::seal(bodies)?;
        self.compare(file, &bodies.recorded(&all, &numbers))?;
        let views = bodies.views()?;
        let shells: Vec<Shells> = views.iter().map(|(_, view)| Shells::of(view.corners)).collect();
        let stage = BodySet { bodies: &views, extremes: None, depth: content.settings.depth };
        let request = CourseRequest {
            scenario: parsed,
            models: &numbers,
            shells: &shells,
            criteria: scenario.criteria().clone(),
            members: self.members()?,
            worlds: scenario::Worlds::USUAL,
            history: false,
            explanation: true,
            scene: true,
        };
        let (until, search, rounds) = (content.until, content.search, content.rounds.clone());
        let open_steps = content.open_steps.clone();
        let history = CourseHistory { until, search, rounds, open_steps };
        let ranked = coordinator::replay_courses(&stage, &request, &history)?;
        let RankedCourses { answer, explanation, effort, scene, .. } = ranked;
        let implausible = plausibility::of_scenario(parsed, &views, &numbers);
        let answer = plausibility::stated(answer, implausible);
        let jobs = effort.jobs_in_process;
        let json = line(&answer)?;
        drop((all, views));
        let scene = scene.unwrap_or_default();
        Ok(Replay { scenario, answer, explanation, scene, bodies, jobs, json })
    }

    /// How many members were followed.
    fn members(&self) -> Result<Members, Failure> {
        let settings = &self.content.settings;
        Ok(Members::new(i64::from(settings.members), Some(i64::from(settings.members_max)))?)
    }

    /// The texts but for the paths.
    fn texts(&self) -> Texts {
        let RecordContent { scenario, policy, curves, parameters, .. } = &self.content;
        Texts {
            scenario: source_text(scenario),
            policy: source_text(policy),
            curves: source_text(curves),
            parameters: source_text(parameters),
        }
    }

    /// The settings that the job history depends on.
    fn engine(&self) -> Result<EngineSettings, Failure> {
        let settings = &self.content.settings;
        let changes = Overrides {
            depth: Some(i64::from(settings.depth)),
            build: Some(settings.tree.name().to_owned()),
            leaf_size: Some(i64::from(settings.leaf_size)),
            ..Overrides::default()
        };
        let applied = EngineSettings::DEFAULT.apply(&changes);
        applied.map_err(|misfit| Failure::from(misfit).of_kind(FailureKind::Input))
    }

    /// The model file of each party that has one, found by its hash.
    fn found(
        &self,
        file: &Path,
        models: Option<&Path>,
    ) -> Result<BTreeMap<usize, PathBuf>, Failure> {
        let mut wanted = BTreeMap::new();
        for (party, body) in self.content.bodies.iter().enumerate() {
            if let RecordedSource::File { hash, .. } = &body.source {
                wanted.insert(party, hash.as_str());
            }
        }
        if wanted.is_empty() {
            return Ok(BTreeMap::new());
        }
        let there = models.map(hashes).transpose()?.unwrap_or_default();
        let mut files = BTreeMap::new();
        for (party, hash) in wanted {
            let Some(found) = there.get(hash) else {
                let name = &self.content.bodies[party].party;
                let remedy = match models {
                    None => "name the folder of the model files: --models DIR".to_owned(),
                    Some(folder) => format!("no *.trolley in {} has this hash", folder.display()),
                };
                return Err(Failure::input(format!("the body of \"{name}\" is missing: {hash}"))
                    .at(file.display())
                    .with_remedy(remedy));
            };
            files.insert(party, found.clone());
        }
        Ok(files)
    }

    /// Checks that a scenario is the recorded one: its text, its policy, its curves, and the files
    /// of its bodies. `file` is the record's name in messages.
    ///
    /// ```
    /// # use trolley::{Engine, Limits, Record, Scenario};
    /// # let folder = std::env::temp_dir().join(format!("trolley-same-{}", std::process::id()));
    /// # std::fs::create_dir_all(&folder).ok();
    /// # let scenario = Scenario::open("../../config/scenarios/small.toml")?;
    /// # let mut engine = Engine::builder().in_process().build()?;
    /// # let ranking = engine.rank(&scenario, &Limits::default().with_record())?;
    /// # let path = Record::write(&folder, &ranking)?;
    /// # let record = Record::read(&path)?;
    /// assert!(record.check_scenario(&path, &scenario).is_ok());
    /// assert!(record.check_scenario(&path, &Scenario::demo()?).is_err());
    /// # std::fs::remove_dir_all(&folder).ok();
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    ///
    /// # Errors
    ///
    /// If one of them differs, or a body's file cannot be read.
    pub fn check_scenario(&self, file: &Path, scenario: &Scenario) -> Result<(), Failure> {
        let path_of = |reference: &FileRef| scenario.path_of(reference);
        let texts = (&scenario.texts, &scenario.files[..]);
        self.check_sources(file, texts, &scenario.bodies(), &path_of)
    }

    /// Checks that the texts of a scenario and the files of its bodies are those recorded.
    fn check_sources(
        &self,
        file: &Path,
        (texts, files): (&Texts, &[SourceText]),
        bodies: &[PartyBody<'_>],
        path_of: &dyn Fn(&FileRef) -> PathBuf,
    ) -> Result<(), Failure> {
        let content = &self.content;
        let other = |what: &str, name: &str, is: &str, was: &str| {
            Err(Failure::input(format!(
                "{what} {name} is not the one of {}: its BLAKE3 is {is}, and was {was}",
                file.display()
            ))
            .with_remedy("name the file that was ranked, or replay without --scenario"))
        };
        let four = [
            ("the scenario", &texts.scenario, &content.scenario),
            ("the policy", &texts.policy, &content.policy),
            ("the set of curves", &texts.curves, &content.curves),
            ("the set of parameters", &texts.parameters, &content.parameters),
        ];
        // The same text names the same files, in the same order.
        let paths = files.iter().zip(&content.files).map(|(now, then)| ("the path", now, then));
        for (what, now, then) in four.into_iter().chain(paths) {
            let hash = record::hash_of_text(&now.text);
            if hash != then.hash {
                return other(what, &now.name, &hash, &then.hash);
            }
        }
        // The same text has the same parties, in the same order.
        for (party, body) in bodies.iter().zip(&content.bodies) {
            let (Source::File(reference), RecordedSource::File { hash: was, .. }) =
                (party.source, &body.source)
            else {
                continue;
            };
            let path = path_of(reference);
            let map = FileMap::open(&path, InputKind::Model)?;
            let is = body::file::content_hash(map.bytes())
                .map_err(|error| Failure::from(error).at(path.display()))?;
            if is != *was {
                return other("the model file", &path.display().to_string(), &is, was);
            }
        }
        Ok(())
    }

    /// Whether the texts are those whose hashes are recorded beside them.
    fn check_texts(&self, file: &Path) -> Result<(), Failure> {
        let content = &self.content;
        let four = [
            ("scenario", &content.scenario),
            ("policy", &content.policy),
            ("set of curves", &content.curves),
            ("set of parameters", &content.parameters),
        ];
        let paths = content.files.iter().map(|text| ("path", text));
        for (what, text) in four.into_iter().chain(paths) {
            let is = record::hash_of_text(&text.text);
            if is != text.hash {
                let was = &text.hash;
                let what = format!(
                    "the {what} in it is not the one that was ranked: its BLAKE3 is {is}, and the \
                     recorded one is {was}"
                );
                return Err(Failure::input(what).at(file.display()).with_remedy(
                    "it was changed and hashed again: use another copy, and sign records to see \
                     who wrote them",
                ));
            }
        }
        Ok(())
    }

    /// Whether the bodies are those of the record.
    fn compare(&self, file: &Path, now: &[record::RecordedBody]) -> Result<(), Failure> {
        let then = &self.content.bodies;
        let names = |bodies: &[record::RecordedBody]| -> Vec<String> {
            bodies.iter().map(|body| body.party.clone()).collect()
        };
        if names(now) != names(then) {
            let what = format!(
                "its scenario has the parties {}, and it holds the bodies of {}",
                names(now).join(", "),
                names(then).join(", ")
            );
            return Err(Failure::input(what)
                .at(file.display())
                .with_remedy("it was changed and hashed again: use another copy"));
        }
        let other = now.iter().zip(then).find(|(now, then)| now.hash != then.hash);
        let Some((now, then)) = other else { return Ok(()) };
        let what =
            format!("the body of \"{}\" is {} here, and was {}", now.party, now.hash, then.hash);
        Err(Failure::new(FailureKind::Skew, what).at(file.display()).with_remedy(
            "another build generates bodies or builds trees differently: use the recorded one",
        ))
    }
}

fn source_text(text: &RecordedText) -> SourceText {
    SourceText { name: text.name.clone(), text: text.text.clone() }
}

/// The model files of a folder by the hash that they state, which is checked on opening.
fn hashes(folder: &Path) -> Result<BTreeMap<String, PathBuf>, Failure> {
    let wrong = |error: std::io::Error| Failure::input(error.to_string()).at(folder.display());
    let mut files = BTreeMap::new();
    for entry in std::fs::read_dir(folder).map_err(wrong)? {
        let path = entry.map_err(wrong)?.path();
        if path.extension().is_none_or(|end| end != "trolley") {
            continue;
        }
        let map = FileMap::open(&path, InputKind::Model)?;
        // Files that are not model files are skipped.
        if let Ok(hash) = body::file::content_hash(map.bytes()) {
            files.insert(hash, path);
        }
    }
    Ok(files)
}
