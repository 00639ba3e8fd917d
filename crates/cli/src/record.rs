//! `--record DIR`, and `trolley record show|verify|replay`.
//!
//! Records lie in their folder as `000000.record`, `000001.record`, ...: one chain. A record is
//! written aside and then given its name, so a folder never holds half of one, and two writers
//! never take the same number.

use crate::BUILD;
use crate::args::Output;
use crate::bodies::Loaded;
use crate::inputs::Inputs;
use crate::print;
use crate::run::Run;
use clap::Subcommand;
use coordinator::Work;
use diagnostic::{Failure, Kind};
use record::{Body, Chain, Edge, Link, Record, Settings, Source, Span, Stage, Text};
use scenario::{Engine, Scenario};
use serde::Serialize;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

pub(crate) mod replay;
mod show;

const EXAMPLES: &str = "\
Examples:
  trolley demo --record decisions
  trolley record verify decisions
  trolley record show decisions/000000.record
  trolley record replay decisions/000000.record --models bodies

A record complements the recorders of UN R157 (DSSAD) and R160 (EDR); it does not claim to comply
with them. Removing the last records of a chain cannot be seen in what is left: keep the hash that
verify prints elsewhere.";

#[derive(Debug, Subcommand)]
pub(crate) enum Verb {
    /// Say what a record holds.
    #[command(after_help = EXAMPLES)]
    Show {
        /// A record.
        file: PathBuf,
    },
    /// Check every byte of records, and that each follows on the one before it.
    #[command(after_help = EXAMPLES)]
    Verify {
        /// A folder that --record wrote into, or one record.
        path: PathBuf,
    },
    /// Make the recorded answer again and compare it, byte for byte.
    #[command(after_help = EXAMPLES)]
    Replay {
        /// A record.
        file: PathBuf,
        /// Folder with the model files that the record names; they are found by their hash.
        #[arg(long, value_name = "DIR")]
        models: Option<PathBuf>,
    },
}

pub(crate) fn run(verb: &Verb, output: &Output) -> Result<ExitCode, Failure> {
    match verb {
        Verb::Show { file } => show::run(file, output),
        Verb::Verify { path } => verify(path, output),
        Verb::Replay { file, models } => replay::run(file, models.as_deref(), output),
    }
}

/// Everything that a record is made from.
pub(crate) struct Made<'a> {
    pub(crate) inputs: &'a Inputs,
    pub(crate) engine: &'a Engine,
    pub(crate) bodies: &'a [Body],
    pub(crate) work: &'a Work<'a>,
    pub(crate) run: &'a Run,
    pub(crate) unknown_is_fixed: bool,
    /// The answer as JSON.
    pub(crate) answer: String,
    /// The explanation as JSON.
    pub(crate) explanation: String,
}

/// The bodies as a record names them.
pub(crate) fn bodies(scenario: &Scenario, loaded: &[Loaded]) -> Result<Vec<Body>, Failure> {
    let one = |(party, body): (&scenario::Party, &Loaded)| {
        let hash = body::file::content_hash(body.bytes.bytes())
            .map_err(|error| Failure::internal(error.to_string()))?;
        let source = match (&party.source, &body.source_hash) {
            (scenario::Source::File(reference), Some(hash)) => {
                Source::File { path: reference.path.clone(), hash: hash.clone() }
            }
            _ => Source::Generated,
        };
        Ok(Body { party: party.name.to_string(), source, hash })
    };
    scenario.parties.iter().zip(loaded).map(one).collect()
}

/// Whether a folder can take a record: better known before the work than after it.
pub(crate) fn ready(folder: &Path) -> Result<(), Failure> {
    std::fs::create_dir_all(folder).map_err(|error| unwritable(folder, &error))?;
    tempfile::tempfile_in(folder).map_err(|error| unwritable(folder, &error))?;
    end(folder).map(drop)
}

/// Writes the next record of a folder; returns its path.
pub(crate) fn write(folder: &Path, made: Made<'_>) -> Result<PathBuf, Failure> {
    let record = content(made);
    // Somebody else may take the number meanwhile: then the next one is ours.
    for _ in 0..100 {
        let (number, last) = end(folder)?;
        let (bytes, _) = record::encode(&record, last.as_ref())?;
        let mut file =
            tempfile::NamedTempFile::new_in(folder).map_err(|error| unwritable(folder, &error))?;
        let written = file.write_all(&bytes).and_then(|()| file.as_file().sync_all());
        written.map_err(|error| unwritable(folder, &error))?;
        let path = folder.join(name(number));
        match file.persist_noclobber(&path) {
            Ok(_) => return Ok(path),
            Err(error) if error.error.kind() == std::io::ErrorKind::AlreadyExists => {}
            Err(error) => return Err(unwritable(&path, &error.error)),
        }
    }
    let fault = format!("{}: others write records here all the time", folder.display());
    Err(Failure::new(Kind::Resources, fault).with_remedy("give each of them a folder of its own"))
}

fn unwritable(path: &Path, error: &std::io::Error) -> Failure {
    Failure::new(Kind::System, format!("{}: {error}", path.display()))
        .with_remedy("--record needs a folder that may be written to")
}

fn content(made: Made<'_>) -> Record {
    let Made { inputs, engine, run, .. } = made;
    let text = |text: &crate::inputs::Text| Text::new(&text.name, &text.text);
    let lost = run.workers.iter().filter_map(|worker| {
        worker.lost.as_ref().map(|how| format!("worker {} was lost: {how}", worker.worker))
    });
    let ledger = made.work.ledger();
    Record {
        build: BUILD.to_owned(),
        scenario: text(&inputs.scenario),
        policy: text(&inputs.policy),
        curves: text(&inputs.curves),
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
            unknown_is_fixed: made.unknown_is_fixed,
        },
        bodies: made.bodies.to_vec(),
        places: ledger.map(|ledger| ledger.places.clone()).unwrap_or_default(),
        jobs: ledger.map(|ledger| ledger.jobs.clone()).unwrap_or_default(),
        moments: ledger.map(|ledger| ledger.moments.clone()).unwrap_or_default(),
        spans: spans(run),
        edges: edges(run),
        stages: stages(run),
        faults: lost.chain(run.remarks.iter().cloned()).collect(),
        answer: made.answer,
        explanation: made.explanation,
    }
}

fn stages(run: &Run) -> Vec<Stage> {
    let s = &run.stages;
    let all = [
        ("load", s.load_ms),
        ("plan", s.plan_ms),
        ("start", s.start_ms),
        ("work", s.work_ms),
        ("assess", s.assess_ms),
        ("stop", s.stop_ms),
    ];
    all.into_iter().map(|(name, ms)| Stage { name: name.to_owned(), ms }).collect()
}

/// When each job ran on its worker, from the beginning of the first.
fn spans(run: &Run) -> Vec<Span> {
    let begun = |[end, wall]: &[u64; 2]| end.saturating_sub(*wall);
    let all = || run.workers.iter().flat_map(|w| w.spans.iter().map(move |span| (w.worker, span)));
    let first = all().map(|(_, span)| begun(span)).min().unwrap_or(0);
    let span = |(worker, span): (u8, &[u64; 2])| Span {
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
    let (_, link) = read(&last)?;
    Ok((link.number + 1, Some(link)))
}

/// The records of a folder, by name.
fn records(folder: &Path) -> Result<Vec<PathBuf>, Failure> {
    let wrong = |error: std::io::Error| Failure::input(format!("{}: {error}", folder.display()));
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
    let wrong = |error: std::io::Error| Failure::input(format!("{}: {error}", path.display()));
    let length = std::fs::metadata(path).map_err(wrong)?.len();
    if length > record::file::LENGTH_MAX as u64 {
        let fault = format!("{}: {length} bytes are too many for a record", path.display());
        return Err(Failure::input(fault).with_remedy("is this the right file?"));
    }
    std::fs::read(path).map_err(wrong)
}

/// A record and its link, every byte checked.
pub(crate) fn read(path: &Path) -> Result<(Record, Link), Failure> {
    record::decode(&bytes(path)?).map_err(|error| Failure::from(error).at(path.display()))
}

pub(crate) fn hex(hash: &[u8; 32]) -> String {
    hash.iter().map(|byte| format!("{byte:02x}")).collect()
}

fn verify(path: &Path, output: &Output) -> Result<ExitCode, Failure> {
    #[derive(Serialize)]
    struct Document {
        schema: &'static str,
        records: usize,
        last: Option<String>,
    }
    let files = if path.is_dir() { records(path)? } else { vec![path.to_owned()] };
    let mut last = None;
    if path.is_dir() {
        let mut whole = Chain::default();
        for file in &files {
            let name = file.display().to_string();
            last = Some(whole.next(&name, &bytes(file)?)?);
        }
    } else {
        last = Some(read(path)?.1);
    }
    // The content must decode, too.
    for file in &files {
        read(file)?;
    }
    let last = last.map(|link| hex(&link.hash));
    let records = files.len();
    if output.json {
        let document = Document { schema: "trolley.record-verify/1", records, last };
        return print::out(&print::json(&document)?);
    }
    match last {
        None => print::out(&format!("{}: no records", path.display())),
        Some(hash) => print::out(&format!(
            "{}: {records} records are as they were written\nhash of the last: {hash}",
            path.display()
        )),
    }
}
