//! `cargo x inputs`: every file of public collections, through the program as users have it.
//!
//! Meshes become models, recordings and traces scenarios, in a process of their own each, whose
//! memory is watched. What counts is whether each file is read or refused with a message; a panic,
//! a signal, too much memory or too much time is a fault of the program.

mod collection;
mod page;
mod watched;

use crate::machine;
use anyhow::Result;
use check::built::{CargoWorkspace, executable, write};
use check::step::cargo;
use collection::{Collection, Sort};
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;
use watched::Ended;

/// The unit that is stated for decks (m).
const MILLIMETRE: f64 = 1e-3;

/// What to read.
#[derive(Debug, clap::Args)]
pub(crate) struct Options {
    /// Collections: git checkouts, each named OWNER+NAME after its public repository, or folders.
    #[arg(required = true, value_name = "FOLDER")]
    folders: Vec<PathBuf>,
    /// Memory of all processes that one file needs together (MiB).
    #[arg(long, default_value_t = 2048, value_name = "MIB")]
    memory_mib: u64,
    /// Time for one file (s).
    #[arg(long, default_value_t = 120, value_name = "S")]
    seconds: u64,
    /// Files read at the same time; by default one a core.
    #[arg(long, value_name = "N")]
    jobs: Option<usize>,
    /// The program, if it is built already.
    #[arg(long, value_name = "FILE")]
    program: Option<PathBuf>,
    /// The page to write.
    #[arg(long, value_name = "FILE.md")]
    out: Option<PathBuf>,
}

/// What became of one file.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Fate {
    /// Imported. The note says what the user had to add, if anything.
    Loaded,
    /// Refused, with this message and remedy.
    Refused(String),
    /// The program fell: how.
    Fell(String),
    /// More than the limit of memory.
    TooMuch,
    /// More than the limit of time.
    TooSlow,
}

/// One file, and what became of it.
#[derive(Debug)]
struct Outcome {
    /// Number of its collection.
    collection: usize,
    /// Its path in the collection.
    name: String,
    sort: Sort,
    /// What had to be added to the command, such as which obstacle is the ego.
    added: Option<&'static str>,
    fate: Fate,
    peak_mib: u64,
    seconds: f64,
}

pub(crate) fn run(options: &Options) -> Result<ExitCode> {
    let workspace = CargoWorkspace::find()?;
    let build = ["build", "--release", "-p", "trolley-cli", "--bin", "trolley"];
    let program = match &options.program {
        Some(program) => program.canonicalize()?,
        None => executable(cargo().args(build))?,
    };
    let collections: Vec<Collection> =
        options.folders.iter().map(|folder| Collection::find(folder)).collect::<Result<_>>()?;
    let files: Vec<(usize, &Path, Sort)> = collections
        .iter()
        .enumerate()
        .flat_map(|(number, one)| {
            one.files.iter().map(move |(path, sort)| (number, &**path, *sort))
        })
        .collect();
    let jobs = options.jobs.or_else(|| std::thread::available_parallelism().ok().map(Into::into));
    let limits =
        watched::Bounds { mib: options.memory_mib, time: Duration::from_secs(options.seconds) };
    let next = AtomicUsize::new(0);
    let outcomes = Mutex::new(Vec::new());
    let work = || -> Result<()> {
        let folder = tempfile::tempdir()?;
        loop {
            let number = next.fetch_add(1, Ordering::Relaxed);
            let Some((collection, path, sort)) = files.get(number) else { return Ok(()) };
            let root = &collections[*collection].root;
            let (fate, added, ended) = read(&program, folder.path(), root, path, *sort, limits)?;
            let mut out = std::io::stdout().lock();
            let _w = match &fate {
                Fate::Loaded => writeln!(out, "{}: loaded", path.display()),
                Fate::Refused(text) => writeln!(out, "{}: refused: {text}", path.display()),
                other => writeln!(out, "{}: FAULT: {other:?}", path.display()),
            };
            let outcome = Outcome {
                collection: *collection,
                name: path.display().to_string(),
                sort: *sort,
                added,
                fate,
                peak_mib: ended.peak_mib,
                seconds: ended.time.as_secs_f64(),
            };
            outcomes.lock().unwrap_or_else(|error| error.into_inner()).push(outcome);
        }
    };
    std::thread::scope(|scope| {
        let threads: Vec<_> = (0..jobs.unwrap_or(1)).map(|_| scope.spawn(work)).collect();
        threads.into_iter().try_for_each(|thread| {
            thread.join().unwrap_or_else(|_| Err(anyhow::anyhow!("a thread of this command fell")))
        })
    })?;
    let mut outcomes = outcomes.into_inner().unwrap_or_else(|error| error.into_inner());
    outcomes.sort_by(|a, b| (a.collection, &a.name).cmp(&(b.collection, &b.name)));
    let text = page::text(&collections, &outcomes, limits, &machine::commit(&workspace.root)?);
    let _w = writeln!(std::io::stdout(), "{text}");
    if let Some(out) = &options.out {
        write(&workspace.root.join(out), &text)?;
    }
    let is_fault = |one: &Outcome| !matches!(one.fate, Fate::Loaded | Fate::Refused(_));
    let is_sound = !outcomes.iter().any(is_fault);
    Ok(if is_sound { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// Reads one file, in the folder of its collection, as a user would: what a message asks for, a
/// choice of the ego or a unit, is given once.
fn read(
    program: &Path,
    scratch: &Path,
    root: &Path,
    file: &Path,
    sort: Sort,
    limits: watched::Bounds,
) -> Result<(Fate, Option<&'static str>, Ended)> {
    let command = |more: &[String]| {
        let mut command = Command::new(program);
        command.current_dir(root);
        match sort {
            Sort::Mesh => {
                command.args(["model", "import", "--kind", "sedan", "--quiet", "--out"]);
                command.arg(scratch.join("body.trolley"));
            }
            Sort::Recording | Sort::Trace | Sort::Script | Sort::Other => {
                command.args(["scenario", "import", "--quiet"]);
            }
        }
        command.args(more).arg("--").arg(file);
        command
    };
    let mut more: Vec<String> = Vec::new();
    let mut added = None;
    // Twice at most: an ego or a unit, and a factor besides.
    loop {
        let ended = watched::run(command(&more), scratch, limits)?;
        let fate = fate(&ended, limits);
        let Fate::Refused(text) = &fate else { return Ok((fate, added, ended)) };
        let asked = match sort {
            Sort::Mesh if text.contains("--unit mm, --unit m") => Some(("--unit", "mm".to_owned())),
            Sort::Mesh => factor(text, &more).map(|unit| ("--unit", unit)),
            _ if text.contains("--ego ID") => first_listed(text).map(|id| ("--ego", id.to_owned())),
            _ => None,
        };
        let is_new = |(flag, _): &(&str, String)| {
            more.len() < 4 && !more.contains(&(*flag).into())
                || (sort == Sort::Mesh && more == ["--unit", "mm"])
        };
        let Some((flag, value)) = asked.filter(is_new) else { return Ok((fate, added, ended)) };
        added = Some(if flag == "--ego" { "which is the ego" } else { "a unit" });
        more = vec![flag.to_owned(), value];
    }
}

/// The factor that makes a body of a plausible length, as its message asks for: "0.2 × 0.1 × 0.1 m
/// is not a plausible sedan: its greatest length should be 1 to 30 m". Where a unit was stated
/// `before`, it was a millimetre.
fn factor(text: &str, before: &[String]) -> Option<String> {
    let (size, range) = text.split_once(" is not a plausible ")?;
    let numbers = |text: &str| -> Vec<f64> {
        let words = text.split_whitespace();
        words.filter_map(|word| word.parse().ok()).filter(|number| *number > 0.0).collect()
    };
    let largest = numbers(size).into_iter().reduce(f64::max)?;
    let range = numbers(range.split(" m").next()?);
    let [least, greatest] = range[..] else { return None };
    let unit = if before.is_empty() { 1.0 } else { MILLIMETRE };
    Some(format!("{}", unit * (least * greatest).sqrt() / largest))
}

/// The first of the things that a message lists: "obstacles here: 1, 2".
fn first_listed(text: &str) -> Option<&str> {
    let listed = text.split("here: ").nth(1)?;
    listed.split([',', ';', ')']).next().map(str::trim)
}

/// What the end of a process means.
fn fate(ended: &Ended, limits: watched::Bounds) -> Fate {
    if ended.peak_mib > limits.mib {
        return Fate::TooMuch;
    }
    let said = ended.stderr.trim();
    match ended.code {
        None if ended.time >= limits.time => Fate::TooSlow,
        None => Fate::Fell(format!("killed: {said}")),
        Some(_) if said.contains("panicked at") || said.contains("fell over") => {
            Fate::Fell(said.to_owned())
        }
        Some(0) => Fate::Loaded,
        Some(65 | 66) => Fate::Refused(message(said)),
        Some(code) => Fate::Fell(format!("exit code {code}: {said}")),
    }
}

/// The message of a refusal and its remedy, without what was only logged before.
fn message(said: &str) -> String {
    let begin = said.find("error: ").unwrap_or(0);
    let lines: Vec<&str> = said[begin..].lines().map(str::trim).collect();
    lines.join(" — ").trim_start_matches("error: ").to_owned()
}
