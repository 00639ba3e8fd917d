//! Decision records: what was asked, decided, and by what, so that the answer can be made again.
//!
//! Records lie in their folder as `000000.record`, `000001.record`, ...: one chain. A record is
//! written aside and then given its name, so a folder never holds half of one, and two writers
//! never take the same number.

use crate::engine::{Ranking, Recorded};
use crate::run::Run;
use crate::{BUILD, Failure, FailureKind};
use record::{Chain, Edge, RecordedSpan, RecordedStage, RecordedText, Settings};
use std::io::Write as _;
use std::path::{Path, PathBuf};

mod replay;

pub use record::{Link, RecordContent, RecordedBody, RecordedEnd, RecordedSource};
pub use replay::Replay;

/// A decision record, and its place in its chain.
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    /// Everything about one request.
    pub content: RecordContent,
    /// Its number and hash, and the hash of the one before it.
    pub link: Link,
}

impl Record {
    /// Looks whether a folder can take a record, and makes it if it is not there: better known
    /// before the work than after it.
    ///
    /// # Errors
    ///
    /// If it cannot be written to, or its last record cannot be read.
    pub fn prepare(folder: &Path) -> Result<(), Failure> {
        std::fs::create_dir_all(folder).map_err(|error| unwritable(folder, &error))?;
        tempfile::tempfile_in(folder).map_err(|error| unwritable(folder, &error))?;
        end(folder).map(drop)
    }

    /// Adds a ranking to a folder's records; returns the new record's path. The ranking must have
    /// been made for it: see [`Limits::with_record`](crate::Limits::with_record).
    ///
    /// # Errors
    ///
    /// If the folder cannot be written to.
    pub fn write(folder: &Path, ranking: &Ranking) -> Result<PathBuf, Failure> {
        let record = content(ranking)?;
        // Somebody else may take the number meanwhile: then the next one is ours.
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
        Err(Failure::new(FailureKind::Resources, "others write records here all the time")
            .at(folder.display())
            .with_remedy("give each of them a folder of its own"))
    }

    /// Reads a record, and checks every byte of it.
    ///
    /// # Errors
    ///
    /// If it cannot be read, is none, or was changed since it was written.
    pub fn read(path: &Path) -> Result<Self, Failure> {
        let read = record::decode(&bytes(path)?);
        let (content, link) = read.map_err(|error| Failure::from(error).at(path.display()))?;
        Ok(Self { content, link })
    }

    /// Checks every byte of all records of a folder, and that each follows on the one before it; or
    /// of a single record. Says how many there are, and gives the last one's link.
    ///
    /// # Errors
    ///
    /// If one was changed, exchanged or removed.
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
                    .with_remedy("take the copy of another keeper, and compare")
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
        .with_remedy("--record needs a folder that may be written to")
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

/// When each job ran on its worker, from the beginning of the first.
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

/// What went between coordinator and workers.
fn edges(run: &Run) -> Vec<Edge> {
    let of = |worker: &coordinator::WorkerReport| {
        let name = format!("worker {}", worker.worker);
        let coordinator = || "coordinator".to_owned();
        let (messages, bytes) = (worker.batches, worker.batch_bytes);
        let out = Edge { from: coordinator(), to: name.clone(), messages, bytes };
        let (messages, bytes) = (worker.results, worker.result_bytes);
        [out, Edge { from: name, to: coordinator(), messages, bytes }]
    };
    run.workers.iter().flat_map(of).collect()
}

fn name(number: u64) -> String {
    format!("{number:06}.record")
}

/// The number that comes next in a folder, and the link of the last record.
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
    // By number: the millionth has one digit more.
    paths.sort_by_key(|path| (path.as_os_str().len(), path.clone()));
    Ok(paths)
}

fn bytes(path: &Path) -> Result<Vec<u8>, Failure> {
    let wrong = |error: std::io::Error| Failure::input(error.to_string()).at(path.display());
    let length = std::fs::metadata(path).map_err(wrong)?.len();
    if length > record::file::LENGTH_MAX as u64 {
        return Err(Failure::input(format!("{length} bytes are too many for a record"))
            .at(path.display())
            .with_remedy("is this the right file?"));
    }
    std::fs::read(path).map_err(wrong)
}

/// A hash as people read it.
#[must_use]
pub fn hex(hash: &[u8; 32]) -> String {
    hash.iter().map(|byte| format!("{byte:02x}")).collect()
}
