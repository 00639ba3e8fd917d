//! `trolley record replay`: the recorded answer, made again from what it was made from.

use super::read;
use crate::BUILD;
use crate::args::Output;
use crate::bodies;
use crate::failure::{Code, Failure};
use crate::inputs::{Inputs, Read, Text};
use crate::print;
use coordinator::{Request, Work};
use record::{Record, Source};
use runtime::FileMap;
use runtime::error::chain;
use scenario::{Engine, Overrides, Scenario};
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

#[derive(Serialize)]
struct Document {
    schema: &'static str,
    same: bool,
    build: String,
    same_build: bool,
    jobs: u64,
}

pub(super) fn run(
    path: &Path,
    models: Option<&Path>,
    output: &Output,
) -> Result<ExitCode, Failure> {
    let (record, _) = read(path)?;
    let (answer, jobs) = again(path, &record, models, output)?;
    let (same, same_build) = (answer == record.answer, record.build == BUILD);
    if output.json {
        let schema = "trolley.record-replay/1";
        let document = Document { schema, same, build: record.build.clone(), same_build, jobs };
        print::out(&print::json(&document)?)?;
    }
    if !same_build {
        print::err(&format!("warning: recorded by build {}, replayed by {BUILD}", record.build));
    }
    if same && !output.json {
        print::out(&format!(
            "{}: the same answer, bit for bit, from {jobs} jobs of the {} recorded",
            path.display(),
            record.jobs.len()
        ))?;
    }
    if same {
        return Ok(ExitCode::SUCCESS);
    }
    let at = answer.bytes().zip(record.answer.bytes()).take_while(|(a, b)| a == b).count();
    let around = |text: &str| {
        let from = (0..=at.min(text.len())).rev().find(|i| text.is_char_boundary(*i)).unwrap_or(0);
        text[from..].chars().take(60).collect::<String>()
    };
    let fault = format!(
        "{}: another answer than the recorded one, from byte {at} on: {:?} instead of {:?}",
        path.display(),
        around(&answer),
        around(&record.answer)
    );
    let (code, help) = if same_build {
        (Code::Internal, "the same build must give the same answer: keep both and report it")
    } else {
        (Code::Skew, "replay it with the build that recorded it")
    };
    Err(Failure::new(code, fault).help(help))
}

/// The answer once more, and how many jobs it took.
fn again(
    path: &Path,
    record: &Record,
    models: Option<&Path>,
    output: &Output,
) -> Result<(String, u64), Failure> {
    with(path, record, models, output, |made| {
        let answer = print::line(&made.work.answer()?)?;
        Ok((answer, made.jobs))
    })
}

/// A request made again from its record.
pub(crate) struct Again<'a> {
    pub(crate) scenario: &'a Scenario,
    pub(crate) views: &'a [(body::Meta, body::BodyView<'a>)],
    pub(crate) work: &'a Work<'a>,
    pub(crate) jobs: u64,
}

/// Makes a recorded request again, as its ledger says it was done, and hands it to `then`.
pub(crate) fn with<T>(
    path: &Path,
    record: &Record,
    models: Option<&Path>,
    output: &Output,
    then: impl FnOnce(&Again<'_>) -> Result<T, Failure>,
) -> Result<T, Failure> {
    let text = |text: &record::Text| Text { name: text.name.clone(), text: text.text.clone() };
    let inputs = Inputs {
        scenario: text(&record.scenario),
        policy: text(&record.policy),
        curves: text(&record.curves),
    };
    let Read { scenario, policy, curves } = inputs.read()?;
    let engine = engine(record)?;
    let files = found(path, record, models)?;
    let find = |party: usize, _: &scenario::FileRef| files[&party].clone();
    let loaded = bodies::load(&scenario, &engine, &inputs.scenario.name, &find, output)?;
    compare(path, record, &scenario, &loaded)?;
    let bytes: Vec<&[u8]> = loaded.iter().map(|body| body.bytes.bytes()).collect();
    let store = coordinator::seal(&bytes)?;
    let views = body::store::open(store.bytes())
        .map_err(|error| Failure::new(Code::Internal, chain(&error)))?;
    let request = Request::new(&scenario, &views, policy, curves)?;
    let mut work = Work::new(&request, &views, record.settings.depth);
    let jobs = coordinator::replay(&mut work, &views, &record.places, &record.jobs);
    then(&Again { scenario: &scenario, views: &views, work: &work, jobs })
}

/// The settings that the ledger depends on.
fn engine(record: &Record) -> Result<Engine, Failure> {
    let changes = Overrides {
        depth: Some(i64::from(record.settings.depth)),
        build: Some(record.settings.tree.clone()),
        leaf_size: Some(i64::from(record.settings.leaf_size)),
        ..Overrides::default()
    };
    let wrong = |misfit: scenario::Misfit| Failure::input(misfit.fault).help(misfit.help);
    Engine::DEFAULT.apply(&changes).map_err(wrong)
}

/// The model file of each party that has one, found by its hash.
fn found(
    path: &Path,
    record: &Record,
    models: Option<&Path>,
) -> Result<BTreeMap<usize, PathBuf>, Failure> {
    let mut wanted = BTreeMap::new();
    for (party, body) in record.bodies.iter().enumerate() {
        if let Source::File { hash, .. } = &body.source {
            wanted.insert(party, hash.as_str());
        }
    }
    if wanted.is_empty() {
        return Ok(BTreeMap::new());
    }
    let there = models.map(hashes).transpose()?.unwrap_or_default();
    let mut files = BTreeMap::new();
    for (party, hash) in wanted {
        let Some(file) = there.get(hash) else {
            let name = &record.bodies[party].party;
            let fault = format!("{}: the body of \"{name}\" is missing: {hash}", path.display());
            let help = match models {
                None => "name the folder of the model files: --models DIR".to_owned(),
                Some(folder) => format!("no *.trolley in {} has this hash", folder.display()),
            };
            return Err(Failure::input(fault).help(help));
        };
        files.insert(party, file.clone());
    }
    Ok(files)
}

/// The model files of a folder by the hash that they state; it is checked when they are opened.
fn hashes(folder: &Path) -> Result<BTreeMap<String, PathBuf>, Failure> {
    let wrong = |error: std::io::Error| Failure::input(format!("{}: {error}", folder.display()));
    let mut files = BTreeMap::new();
    for entry in std::fs::read_dir(folder).map_err(wrong)? {
        let path = entry.map_err(wrong)?.path();
        if path.extension().is_none_or(|end| end != "trolley") {
            continue;
        }
        let map = FileMap::open(&path).map_err(|error| Failure::input(chain(&error)))?;
        // What is no model file is none of ours.
        if let Ok(hash) = body::file::content_hash(map.bytes()) {
            files.insert(hash, path);
        }
    }
    Ok(files)
}

/// Whether the bodies are those of the record.
fn compare(
    path: &Path,
    record: &Record,
    scenario: &Scenario,
    loaded: &[bodies::Loaded],
) -> Result<(), Failure> {
    let bodies = super::bodies(scenario, loaded)?;
    let other = bodies.iter().zip(&record.bodies).find(|(now, then)| now.hash != then.hash);
    let Some((now, then)) = other else { return Ok(()) };
    let fault = format!(
        "{}: the body of \"{}\" is {} here, and was {}",
        path.display(),
        now.party,
        now.hash,
        then.hash
    );
    let help = "another build generates or divides bodies differently: use the recorded one";
    Err(Failure::new(Code::Skew, fault).help(help))
}
