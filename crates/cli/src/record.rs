//! `trolley record show|verify|replay`.

use crate::output::Output;
use crate::print;
use crate::reference_args::ReferenceArgs;
use clap::Subcommand;
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use trolley::record::{
    Proof, Replay, SignedStatement, Verified, VerifyOptions, hex, holds_decisions, verify_decisions,
};
use trolley::{BUILD, Failure, FailureKind, Record, References, Scenario};

mod show;
mod stated;

use stated::Stated;

const EXAMPLES: &str = "\
Examples:
  trolley demo --record decisions
  trolley record verify decisions
  trolley record show decisions/000000.record
  trolley record replay decisions

Signed with a key of openssl, and checked:
  openssl genpkey -algorithm ed25519 -out key.pem
  openssl pkey -in key.pem -pubout -out key.pub
  trolley demo --record signed --sign key.pem
  trolley record verify signed --key key.pub

A record complements the recorders of UN R157 (DSSAD) and R160 (EDR); it does not claim to comply
with them. Unsigned records show accidents, not forgery. Signed ones show forgery, but not that a
folder as a whole was replaced by an older state of itself: keep copies of chain.head elsewhere.";

#[derive(Debug, Subcommand)]
pub(crate) enum Verb {
    /// Show what a record holds.
    #[command(after_help = EXAMPLES)]
    Show {
        /// A decision record.
        file: PathBuf,
    },
    /// Check every byte of records, that each continues the one before it, and their signatures.
    #[command(after_help = EXAMPLES)]
    Verify {
        /// A folder of records, one record, or a folder of decisions that a service kept.
        path: PathBuf,
        /// Public key of the signer: everything must be signed with it. Without it, verify shows
        /// accidents, not forgery.
        #[arg(long, value_name = "PUBLIC")]
        key: Option<PathBuf>,
        /// A copy of an earlier chain.head: what it counts must still be there.
        #[arg(long, value_name = "COPY")]
        head: Option<PathBuf>,
    },
    /// Compute recorded answers again and compare them, byte for byte.
    #[command(after_help = EXAMPLES)]
    Replay {
        /// A decision record, or a folder of them.
        file: PathBuf,
        /// Folder with the record's model files, which are found by their hash.
        #[arg(long, value_name = "DIR")]
        models: Option<PathBuf>,
        /// Check first that this scenario file, and what it names, is what was recorded.
        #[arg(long, value_name = "SCENARIO")]
        scenario: Option<PathBuf>,
        #[command(flatten)]
        references: ReferenceArgs,
    },
}

pub(crate) fn run(verb: &Verb, output: &Output) -> Result<ExitCode, Failure> {
    match verb {
        Verb::Show { file } => show::run(file, output),
        Verb::Verify { path, key, head } => {
            let key = key.as_deref().map(trolley::record::public_key).transpose()?;
            verify(path, &VerifyOptions { key, head: head.clone() }, output)
        }
        Verb::Replay { file, models, scenario, references } => {
            let named = scenario.as_deref().map(|path| (path, references.references()));
            for record in records(file)? {
                replay(&record, models.as_deref(), named, output)?;
            }
            Ok(ExitCode::SUCCESS)
        }
    }
}

/// The records of a folder, in their order, or the one record that is named.
fn records(path: &Path) -> Result<Vec<PathBuf>, Failure> {
    if !path.is_dir() {
        return Ok(vec![path.to_owned()]);
    }
    let wrong = |error: std::io::Error| Failure::input(error.to_string()).at(path.display());
    let mut records = Vec::new();
    for entry in std::fs::read_dir(path).map_err(wrong)? {
        let entry = entry.map_err(wrong)?.path();
        if entry.extension().is_some_and(|end| end == "record") {
            records.push(entry);
        }
    }
    records.sort();
    if records.is_empty() {
        let failure = Failure::input("there is no record in it").at(path.display());
        return Err(failure.with_remedy("make one: trolley rank SCENARIO --record DIR"));
    }
    Ok(records)
}

/// What was found in records, or in decisions.
struct Found {
    what: &'static str,
    count: u64,
    last: Option<String>,
    proof: Proof,
    signed: Option<Stated>,
    /// What else there is to say.
    notes: Vec<String>,
}

fn found(path: &Path, options: &VerifyOptions) -> Result<Found, Failure> {
    let stated = |signed: &Option<SignedStatement>| signed.as_ref().map(Stated::of);
    if !holds_decisions(path) {
        let Verified { count, last, proof, statement } = Record::verify(path, options)?;
        let (last, signed) = (last.map(|link| hex(&link.hash)), stated(&statement));
        return Ok(Found { what: "record", count, last, proof, signed, notes: Vec::new() });
    }
    let found = verify_decisions(path, options)?;
    let mut notes = Vec::new();
    if found.first > 0 {
        notes.push(format!(
            "decisions before number {} are gone: a service deletes its oldest files; nothing \
             shows who did",
            found.first
        ));
    }
    if found.torn_bytes > 0 {
        let bytes = found.torn_bytes;
        notes.push(format!(
            "{bytes} bytes after whole decisions are none: a service was killed while it wrote"
        ));
    }
    Ok(Found {
        what: "decision",
        count: found.count,
        last: (found.count > 0).then(|| hex(&found.last)),
        proof: found.proof,
        signed: stated(&found.statement),
        notes,
    })
}

fn verify(path: &Path, options: &VerifyOptions, output: &Output) -> Result<ExitCode, Failure> {
    let Found { what, count, last, proof, signed, notes } = found(path, options)?;
    if output.json {
        let document = serde_json::json!({
            "schema": "trolley.record-verify/1", "of": what, "records": count, "last": last,
            "proof": proof.name(), "shows": proof.to_string(), "signed": signed, "notes": notes,
        });
        return print::out(&print::json(&document)?);
    }
    let path = path.display();
    let mut lines = vec![match count {
        0 => format!("{path}: no {what}s"),
        1 => format!("{path}: 1 {what} is intact"),
        _ => format!("{path}: {count} {what}s are intact"),
    }];
    lines.extend(last.map(|hash| format!("hash of the last: {hash}")));
    lines.extend(signed.map(|stated| format!("last signed {stated}")));
    lines.extend(notes);
    let copy = options.head.as_ref();
    lines.extend(copy.map(|copy| format!("{}: what it counts is here", copy.display())));
    lines.push(proof.to_string());
    // The first line begins with a path, which is not broken.
    print::out(&lines[0])?;
    print::text(&lines[1..].join("\n"))
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

fn replay(
    path: &Path,
    models: Option<&Path>,
    scenario: Option<(&Path, References)>,
    output: &Output,
) -> Result<(), Failure> {
    let record = Record::read(path)?;
    if let Some((scenario, allowed)) = scenario {
        check(&record, path, scenario, allowed)?;
    }
    let progress = output.progress("building bodies: triangles");
    let told = |done, total| progress.set(done, total);
    let Replay { json, jobs, .. } = record.replay(path, models, &told)?;
    drop(progress);
    let (was, build) = (&record.content.answer, &record.content.build);
    let (same, same_build) = (json == *was, record.is_of_this_build());
    if output.json {
        let schema = "trolley.record-replay/1";
        let document = Replayed { schema, same, build, same_build, jobs };
        print::out(&print::json(&document)?)?;
    }
    if !same_build {
        print::err(&format!("warning: recorded by build {build}, replayed by {BUILD}"));
    }
    if !same {
        return Err(another(path, &json, was, same_build));
    }
    if !output.json {
        print::out(&format!(
            "{}: the same answer, bit for bit, from {jobs} jobs of the {} recorded",
            path.display(),
            record.content.all_jobs().count()
        ))?;
    }
    Ok(())
}

/// Checks that a scenario file, and what it names, is what was recorded.
fn check(
    record: &Record,
    path: &Path,
    scenario: &Path,
    allowed: References,
) -> Result<(), Failure> {
    if trolley::traffic::is_traffic(scenario) {
        let what = "a recording of traffic becomes a scenario by options that no record holds";
        return Err(Failure::input(what)
            .at(scenario.display())
            .with_remedy("replay without --scenario: the scenario's text is in the record"));
    }
    record.check_scenario(path, &Scenario::open_with(scenario, allowed)?)
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
