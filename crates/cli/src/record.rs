//! `trolley record show|verify|replay`.

use crate::output::Output;
use crate::print;
use clap::Subcommand;
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use trolley::record::hex;
use trolley::{BUILD, Failure, FailureKind, Record};

mod show;

const EXAMPLES: &str = "\
Examples:
  trolley demo --record decisions
  trolley record verify decisions
  trolley record show decisions/000000.record
  trolley record replay decisions/000000.record --models bodies

A record complements the recorders of UN R157 (DSSAD) and R160 (EDR); it does not claim to comply
with them. Removing the last records of a chain cannot be detected from the rest: keep the hash that
verify prints elsewhere.";

#[derive(Debug, Subcommand)]
pub(crate) enum Verb {
    /// Show what a record holds.
    #[command(after_help = EXAMPLES)]
    Show {
        /// A decision record.
        file: PathBuf,
    },
    /// Check every byte of records, and that each continues the one before it.
    #[command(after_help = EXAMPLES)]
    Verify {
        /// A folder of records, or one record.
        path: PathBuf,
    },
    /// Compute the recorded answer again and compare it, byte for byte.
    #[command(after_help = EXAMPLES)]
    Replay {
        /// A decision record.
        file: PathBuf,
        /// Folder with the record's model files, which are found by their hash.
        #[arg(long, value_name = "DIR")]
        models: Option<PathBuf>,
    },
}

pub(crate) fn run(verb: &Verb, output: &Output) -> Result<ExitCode, Failure> {
    match verb {
        Verb::Show { file } => show::run(file, output),
        Verb::Verify { path } => verify(path, output),
        Verb::Replay { file, models } => replay(file, models.as_deref(), output),
    }
}

fn verify(path: &Path, output: &Output) -> Result<ExitCode, Failure> {
    #[derive(Serialize)]
    struct Document {
        schema: &'static str,
        records: usize,
        last: Option<String>,
    }
    let (records, last) = Record::verify(path)?;
    let last = last.map(|link| hex(&link.hash));
    if output.json {
        let document = Document { schema: "trolley.record-verify/1", records, last };
        return print::out(&print::json(&document)?);
    }
    match last {
        None => print::out(&format!("{}: no records", path.display())),
        Some(hash) => print::out(&format!(
            "{}: {records} records are intact\nhash of the last: {hash}",
            path.display()
        )),
    }
}

/// What `--json` prints of a replay.
#[derive(Serialize)]
struct Replayed<'r> {
    schema: &'static str,
    same: bool,
    build: &'r str,
    same_build: bool,
    jobs: u64,
}

fn replay(path: &Path, models: Option<&Path>, output: &Output) -> Result<ExitCode, Failure> {
    let record = Record::read(path)?;
    let progress = output.progress("building bodies: triangles");
    let replay = record.replay(path, models, &|done, total| progress.set(done, total))?;
    drop(progress);
    let (was, jobs, build) = (&record.content.answer, replay.jobs, &record.content.build);
    let (same, same_build) = (replay.json == *was, record.is_of_this_build());
    if output.json {
        let schema = "trolley.record-replay/1";
        let document = Replayed { schema, same, build, same_build, jobs };
        print::out(&print::json(&document)?)?;
    }
    if !same_build {
        print::err(&format!("warning: recorded by build {build}, replayed by {BUILD}"));
    }
    if !same {
        return Err(another(path, &replay.json, was, same_build));
    }
    if !output.json {
        print::out(&format!(
            "{}: the same answer, bit for bit, from {jobs} jobs of the {} recorded",
            path.display(),
            record.content.jobs.len()
        ))?;
    }
    Ok(ExitCode::SUCCESS)
}

/// Where two answers differ.
fn another(path: &Path, is: &str, was: &str, same_build: bool) -> Failure {
    let at = is.bytes().zip(was.bytes()).take_while(|(a, b)| a == b).count();
    let around = |text: &str| {
        let from = (0..=at.min(text.len())).rev().find(|i| text.is_char_boundary(*i)).unwrap_or(0);
        text[from..].chars().take(60).collect::<String>()
    };
    let what = format!(
        "the answer differs from the recorded one from byte {at} on: {:?} instead of {:?}",
        around(is),
        around(was)
    );
    let (kind, remedy) = if same_build {
        (FailureKind::Internal, "the same build must give the same answer: keep both and report it")
    } else {
        (FailureKind::Skew, "replay it with the build that recorded it")
    };
    Failure::new(kind, what).at(path.display()).with_remedy(remedy)
}
