//! Decision records: an answer with everything it was made from, so that it can be replayed.
//!
//! The records of a folder are `000000.record`, `000001.record`, ...: one chain. A record is
//! written under a temporary name and then renamed, so a folder never holds half a record, and two
//! writers never use the same number.
//!
//! ```
//! # use trolley::{Engine, Limits, Record, Scenario};
//! # let folder = std::env::temp_dir().join(format!("trolley-record-{}", std::process::id()));
//! # std::fs::create_dir_all(&folder).ok();
//! # let scenario = Scenario::open("../../config/scenarios/small.toml")?;
//! # let mut engine = Engine::builder().in_process().build()?;
//! Record::prepare(&folder)?;
//! let ranking = engine.rank(&scenario, &Limits::default().with_record())?;
//! let path = Record::write(&folder, &ranking)?;
//! assert!(path.ends_with("000000.record"));
//! # std::fs::remove_dir_all(&folder).ok();
//! # Ok::<(), trolley::Failure>(())
//! ```

use crate::engine::{Ranking, Recorded};
use crate::files::{self, InputKind};
use crate::run::Run;
use crate::{BUILD, Failure, FailureKind};
use record::{Chain, Edge, RecordedSpan, RecordedStage, RecordedText, Settings};
use std::io::Write as _;
use std::path::{Path, PathBuf};

mod replay;

/// The place of a [`Record`] in its chain.
///
/// ```
/// # use trolley::{Engine, Limits, Record, Scenario};
/// # let folder = std::env::temp_dir().join(format!("trolley-link-{}", std::process::id()));
/// # std::fs::create_dir_all(&folder).ok();
/// # let scenario = Scenario::open("../../config/scenarios/small.toml")?;
/// # let mut engine = Engine::builder().in_process().build()?;
/// # let ranking = engine.rank(&scenario, &Limits::default().with_record())?;
/// # let path = Record::write(&folder, &ranking)?;
/// let next = Record::write(&folder, &ranking)?;
/// let [first, second] = [Record::read(&path)?.link, Record::read(&next)?.link];
/// assert_eq!((second.number, second.previous), (1, first.hash));
/// # std::fs::remove_dir_all(&folder).ok();
/// # Ok::<(), trolley::Failure>(())
/// ```
pub use record::Link;

/// The content of a [`Record`].
///
/// ```
/// # use trolley::{Engine, Limits, Record, Scenario};
/// # let folder = std::env::temp_dir().join(format!("trolley-content-{}", std::process::id()));
/// # std::fs::create_dir_all(&folder).ok();
/// # let scenario = Scenario::open("../../config/scenarios/small.toml")?;
/// # let mut engine = Engine::builder().in_process().build()?;
/// # let ranking = engine.rank(&scenario, &Limits::default().with_record())?;
/// # let path = Record::write(&folder, &ranking)?;
/// # let record = Record::read(&path)?;
/// assert_eq!(record.content.build, trolley::BUILD);
/// assert!(record.content.answer.starts_with('{'), "JSON");
/// # std::fs::remove_dir_all(&folder).ok();
/// # Ok::<(), trolley::Failure>(())
/// ```
pub use record::RecordContent;

/// A body in a [`RecordContent`].
///
/// ```
/// # use trolley::{Engine, Limits, Record, Scenario};
/// # let folder = std::env::temp_dir().join(format!("trolley-body-{}", std::process::id()));
/// # std::fs::create_dir_all(&folder).ok();
/// # let scenario = Scenario::open("../../config/scenarios/small.toml")?;
/// # let mut engine = Engine::builder().in_process().build()?;
/// # let ranking = engine.rank(&scenario, &Limits::default().with_record())?;
/// # let path = Record::write(&folder, &ranking)?;
/// # let record = Record::read(&path)?;
/// for body in &record.content.bodies {
///     println!("{}: {}", body.party, body.hash);
/// }
/// # assert_eq!(record.content.bodies.len(), 5);
/// # std::fs::remove_dir_all(&folder).ok();
/// # Ok::<(), trolley::Failure>(())
/// ```
pub use record::RecordedBody;

/// How a job in a [`RecordContent`] ended.
///
/// ```
/// # use trolley::{Engine, Limits, Record, Scenario};
/// # let folder = std::env::temp_dir().join(format!("trolley-end-{}", std::process::id()));
/// # std::fs::create_dir_all(&folder).ok();
/// # let scenario = Scenario::open("../../config/scenarios/small.toml")?;
/// # let mut engine = Engine::builder().in_process().build()?;
/// # let ranking = engine.rank(&scenario, &Limits::default().with_record())?;
/// # let path = Record::write(&folder, &ranking)?;
/// # let record = Record::read(&path)?;
/// use trolley::record::RecordedEnd;
///
/// assert!(record.content.jobs.iter().any(|job| job.end == RecordedEnd::Done));
/// # std::fs::remove_dir_all(&folder).ok();
/// # Ok::<(), trolley::Failure>(())
/// ```
pub use record::RecordedEnd;

/// Where a [`RecordedBody`] comes from.
///
/// ```
/// # use trolley::{Engine, Limits, Record, Scenario};
/// # let folder = std::env::temp_dir().join(format!("trolley-source-{}", std::process::id()));
/// # std::fs::create_dir_all(&folder).ok();
/// # let scenario = Scenario::open("../../config/scenarios/small.toml")?;
/// # let mut engine = Engine::builder().in_process().build()?;
/// # let ranking = engine.rank(&scenario, &Limits::default().with_record())?;
/// # let path = Record::write(&folder, &ranking)?;
/// # let record = Record::read(&path)?;
/// use trolley::record::RecordedSource;
///
/// let bodies = &record.content.bodies;
/// assert!(bodies.iter().all(|body| body.source == RecordedSource::Generated));
/// # std::fs::remove_dir_all(&folder).ok();
/// # Ok::<(), trolley::Failure>(())
/// ```
pub use record::RecordedSource;
pub use replay::Replay;

/// A decision record, and its place in its chain.
///
/// ```
/// # use trolley::{Engine, Limits, Record, Scenario};
/// # let folder = std::env::temp_dir().join(format!("trolley-struct-{}", std::process::id()));
/// # std::fs::create_dir_all(&folder).ok();
/// # let scenario = Scenario::open("../../config/scenarios/small.toml")?;
/// # let mut engine = Engine::builder().in_process().build()?;
/// # let ranking = engine.rank(&scenario, &Limits::default().with_record())?;
/// let path = Record::write(&folder, &ranking)?;
/// let record = Record::read(&path)?;
/// assert_eq!(record.link.number, 0);
/// # std::fs::remove_dir_all(&folder).ok();
/// # Ok::<(), trolley::Failure>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    /// Everything about one request.
    pub content: RecordContent,
    /// Its number and hash, and the hash of the one before it.
    pub link: Link,
}

impl Record {
    /// Creates a folder for records if it does not exist, and checks that a record can be added:
    /// call it before work is spent on a ranking.
    ///
    /// ```
    /// # let folder = std::env::temp_dir().join(format!("trolley-prepare-{}", std::process::id()));
    /// # std::fs::create_dir_all(&folder).ok();
    /// let records = folder.join("records");
    /// trolley::Record::prepare(&records)?;
    /// assert!(records.is_dir());
    /// # std::fs::remove_dir_all(&folder).ok();
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    ///
    /// # Errors
    ///
    /// If the folder cannot be written to, or its last record cannot be read.
    pub fn prepare(folder: &Path) -> Result<(), Failure> {
        std::fs::create_dir_all(folder).map_err(|error| unwritable(folder, &error))?;
        tempfile::tempfile_in(folder).map_err(|error| unwritable(folder, &error))?;
        end(folder).map(drop)
    }

    /// Adds a ranking to a folder's records, and returns the path of the new one. The ranking must
    /// have been made with [`Limits::with_record`](crate::Limits::with_record).
    ///
    /// ```
    /// # use trolley::{Engine, Limits, Record, Scenario};
    /// # let folder = std::env::temp_dir().join(format!("trolley-write-{}", std::process::id()));
    /// # std::fs::create_dir_all(&folder).ok();
    /// # let scenario = Scenario::open("../../config/scenarios/small.toml")?;
    /// # let mut engine = Engine::builder().in_process().build()?;
    /// let ranking = engine.rank(&scenario, &Limits::default().with_record())?;
    /// let path = Record::write(&folder, &ranking)?;
    ///
    /// let bare = engine.rank(&scenario, &Limits::default())?;
    /// assert!(Record::write(&folder, &bare).is_err(), "nothing was recorded");
    /// # std::fs::remove_dir_all(&folder).ok();
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    ///
    /// # Errors
    ///
    /// If the ranking holds no record, or the folder cannot be written to.
    pub fn write(folder: &Path, ranking: &Ranking) -> Result<PathBuf, Failure> {
        let record = content(ranking)?;
        // Another process may take the number meanwhile: then take the next one.
        for _ in 0..100 {
            let (number, last) = end(folder)?;
            let (bytes, _) = record::encode(&record, last.as_ref())?;
            let mut file = tempfile::NamedTempFile::new_in(folder)
                .map_err(|error| unwritable(folder, &error))?;
            let written = file.write_all(&bytes).and_then(|()| file.as_file().sync_all());
            written.map_err(|error| unwritable(folder, &error))?;
            let path = folder.join(name(number));
            match file.persist_noclobber(&path) {
                Ok(_) => return Ok(path),
                Err(error) if error.error.kind() == std::io::ErrorKind::AlreadyExists => {}
                Err(error) => return Err(unwritable(&path, &error.error)),
            }
        }
        Err(Failure::new(FailureKind::Resources, "other processes keep writing records here")
            .at(folder.display())
            .with_remedy("give each process its own folder"))
    }

    /// Reads a record, and checks every byte of it.
    ///
    /// ```
    /// # use trolley::{Engine, Limits, Record, Scenario};
    /// # let folder = std::env::temp_dir().join(format!("trolley-read-{}", std::process::id()));
    /// # std::fs::create_dir_all(&folder).ok();
    /// # let scenario = Scenario::open("../../config/scenarios/small.toml")?;
    /// # let mut engine = Engine::builder().in_process().build()?;
    /// # let ranking = engine.rank(&scenario, &Limits::default().with_record())?;
    /// # let path = Record::write(&folder, &ranking)?;
    /// let record = Record::read(&path)?;
    /// println!("{} by {}", record.content.scenario.name, record.content.build);
    /// # std::fs::remove_dir_all(&folder).ok();
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    ///
    /// # Errors
    ///
    /// If it cannot be read, is not a record, or was changed since it was written.
    pub fn read(path: &Path) -> Result<Self, Failure> {
        let read = record::decode(&bytes(path)?);
        let (content, link) = read.map_err(|error| Failure::from(error).at(path.display()))?;
        Ok(Self { content, link })
    }

    /// Checks every byte of a record, or of all records of a folder and that each follows the one
    /// before it. Returns how many there are, and the link of the last one.
    ///
    /// ```
    /// # use trolley::{Engine, Limits, Record, Scenario};
    /// # let folder = std::env::temp_dir().join(format!("trolley-verify-{}", std::process::id()));
    /// # std::fs::create_dir_all(&folder).ok();
    /// # let scenario = Scenario::open("../../config/scenarios/small.toml")?;
    /// # let mut engine = Engine::builder().in_process().build()?;
    /// # let ranking = engine.rank(&scenario, &Limits::default().with_record())?;
    /// # let path = Record::write(&folder, &ranking)?;
    /// let (count, last) = Record::verify(&folder)?;
    /// assert_eq!((count, last.map(|link| link.number)), (1, Some(0)));
    /// # std::fs::remove_dir_all(&folder).ok();
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    ///
    /// # Errors
    ///
    /// If one was changed, replaced or removed.
    pub fn verify(path: &Path) -> Result<(usize, Option<Link>), Failure> {
        if !path.is_dir() {
            return Ok((1, Some(Self::read(path)?.link)));
        }
        let files = records(path)?;
        let (mut chain, mut last) = (Chain::default(), None);
        for file in &files {
            let name = file.display().to_string();
            let link = chain.next(&name, &bytes(file)?).map_err(|error| {
                Failure::input(diagnostic::chain(&error))
                    .with_remedy("compare with another copy of the records")
            })?;
            last = Some(link);
        }
        // The content must decode, too.
        for file in &files {
            Self::read(file)?;
        }
        Ok((files.len(), last))
    }
}

fn unwritable(path: &Path, error: &std::io::Error) -> Failure {
    Failure::new(FailureKind::System, error.to_string())
        .at(path.display())
        .with_remedy("--record needs a folder that can be written to")
}

fn content(ranking: &Ranking) -> Result<RecordContent, Failure> {
    let Ranking { run, .. } = ranking;
    let (Some(recorded), Some(explanation)) = (&ranking.recorded, &ranking.explanation) else {
        let what = "a ranking without job history and explanation cannot be recorded";
        return Err(Failure::setting(what).with_remedy("rank it with Limits::with_record"));
    };
    let Recorded { scenario, job_history, settings: engine, bodies } = recorded;
    let text = |text: &crate::scenario::SourceText| RecordedText::new(&text.name, &text.text);
    let lost = run.workers.iter().filter_map(|worker| {
        worker.lost.as_ref().map(|how| format!("worker {} was lost: {how}", worker.worker))
    });
    Ok(RecordContent {
        build: BUILD.to_owned(),
        scenario: text(&scenario.texts.scenario),
        policy: text(&scenario.texts.policy),
        curves: text(&scenario.texts.curves),
        settings: Settings {
            mode: run.mode,
            workers: engine.workers as u32,
            depth: run.depth,
            tree: engine.build,
            leaf_size: engine.leaf_size,
            scheme: engine.scheme,
            alpha: engine.alpha,
            batch: engine.batch as u32,
            queue: engine.queue as u32,
            seed: engine.seed,
            unknown_is_fixed: scenario.unknown_is_fixed,
        },
        bodies: bodies.clone(),
        places: job_history.places.clone(),
        jobs: job_history.jobs.clone(),
        moments: job_history.moments.clone(),
        spans: spans(run),
        edges: edges(run),
        stages: stages(run),
        faults: lost.chain(run.remarks.iter().cloned()).collect(),
        answer: line(&ranking.answer)?,
        explanation: line(explanation)?,
    })
}

/// A document as JSON on one line.
pub(crate) fn line(document: &impl serde::Serialize) -> Result<String, Failure> {
    serde_json::to_string(document).map_err(|error| Failure::internal(error.to_string()))
}

fn stages(run: &Run) -> Vec<RecordedStage> {
    let s = &run.stages;
    let all = [
        ("load", s.load_ms),
        ("plan", s.plan_ms),
        ("start", s.start_ms),
        ("work", s.work_ms),
        ("assess", s.assess_ms),
        ("stop", s.stop_ms),
    ];
    all.into_iter().map(|(name, ms)| RecordedStage { name: name.to_owned(), ms }).collect()
}

/// When each job ran on its worker, counted from the start of the first.
fn spans(run: &Run) -> Vec<RecordedSpan> {
    let begun = |[end, wall]: &[u64; 2]| end.saturating_sub(*wall);
    let all = || run.workers.iter().flat_map(|w| w.spans.iter().map(move |span| (w.worker, span)));
    let first = all().map(|(_, span)| begun(span)).min().unwrap_or(0);
    let span = |(worker, span): (u8, &[u64; 2])| RecordedSpan {
        worker,
        from_ns: begun(span) - first,
        to_ns: span[0] - first,
    };
    all().map(span).collect()
}

/// The messages between coordinator and workers.
fn edges(run: &Run) -> Vec<Edge> {
    let both_ways = |worker: &coordinator::WorkerReport| {
        let name = format!("worker {}", worker.worker);
        let coordinator = || "coordinator".to_owned();
        let (messages, bytes) = (worker.batches, worker.batch_bytes);
        let out = Edge { from: coordinator(), to: name.clone(), messages, bytes };
        let (messages, bytes) = (worker.results, worker.result_bytes);
        [out, Edge { from: name, to: coordinator(), messages, bytes }]
    };
    run.workers.iter().flat_map(both_ways).collect()
}

fn name(number: u64) -> String {
    format!("{number:06}.record")
}

/// The next number in a folder, and the link of the last record.
fn end(folder: &Path) -> Result<(u64, Option<Link>), Failure> {
    let Some(last) = records(folder)?.pop() else { return Ok((0, None)) };
    let link = Record::read(&last)?.link;
    Ok((link.number + 1, Some(link)))
}

/// The records of a folder, by name.
fn records(folder: &Path) -> Result<Vec<PathBuf>, Failure> {
    let wrong = |error: std::io::Error| Failure::input(error.to_string()).at(folder.display());
    let mut paths = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(wrong)? {
        let path = entry.map_err(wrong)?.path();
        if path.extension().is_some_and(|end| end == "record") {
            paths.push(path);
        }
    }
    // By number: from a million on, names have one more digit.
    paths.sort_by_key(|path| (path.as_os_str().len(), path.clone()));
    Ok(paths)
}

fn bytes(path: &Path) -> Result<Vec<u8>, Failure> {
    files::bytes(path, InputKind::Record)
}

/// Returns a hash as hexadecimal digits.
///
/// ```
/// assert!(trolley::record::hex(&[10; 32]).starts_with("0a0a"));
/// ```
#[must_use]
pub fn hex(hash: &[u8; 32]) -> String {
    hash.iter().map(|byte| format!("{byte:02x}")).collect()
}
