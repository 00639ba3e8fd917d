//! `trolley demo` and `trolley rank`: from a scenario to a printed answer.

use crate::args::{EngineArgs, Output};
use crate::bodies;
use crate::failure::{Code, Failure, chain};
use crate::run::{self, Run, Stages};
use crate::{print, table};
use coordinator::Request;
use damage::{Curves, Policy, State};
use runtime::clock;
use scenario::{FileRef, Overrides, Scenario};
use serde::Serialize;
use std::path::Path;
use std::process::ExitCode;

const DEMO: &str = include_str!("../../../config/scenarios/demo.toml");

/// What `--json` prints.
#[derive(Serialize)]
struct Document<'a> {
    schema: &'static str,
    answer: &'a coordinator::Answer,
    run: &'a Run,
}

pub(crate) fn demo(options: &EngineArgs, output: &Output) -> Result<ExitCode, Failure> {
    answer(Path::new("config/scenarios/demo.toml"), DEMO, options, output)
}

pub(crate) fn rank(
    path: &Path,
    options: &EngineArgs,
    output: &Output,
) -> Result<ExitCode, Failure> {
    let text = read(path)?;
    answer(path, &text, options, output)
}

/// Reads a text file that a person wrote.
fn read(path: &Path) -> Result<String, Failure> {
    let about = std::fs::metadata(path)
        .map_err(|error| Failure::input(format!("{}: {error}", path.display())))?;
    if about.len() > scenario::TEXT_BYTES_MAX as u64 {
        let fault = format!("{}: {} bytes are too many", path.display(), about.len());
        return Err(Failure::input(fault).help("is this the right file?"));
    }
    std::fs::read_to_string(path)
        .map_err(|error| Failure::input(format!("{}: {error}", path.display())))
}

fn overrides(options: &EngineArgs) -> Result<Overrides, Failure> {
    let cores = match options.cores.as_deref() {
        None => None,
        Some("none") => Some(Vec::new()),
        Some(list) => {
            let cores: Result<Vec<i64>, _> = list.split(',').map(|c| c.trim().parse()).collect();
            Some(cores.map_err(|error| {
                Failure::new(Code::Configuration, format!("--cores {list}: {error}"))
                    .help("write --cores 0,1,2,3, or --cores none")
            })?)
        }
    };
    Ok(Overrides {
        workers: options.workers,
        cores,
        coordinator_core: None,
        depth: options.depth,
        scheme: options.scheme.clone(),
        alpha: options.alpha,
        batch: options.batch,
        queue: options.queue,
        build: options.build.clone(),
        leaf_size: options.leaf_size,
        seed: options.seed,
    })
}

/// The text of a file that the scenario names.
fn named(path: &Path, reference: &FileRef) -> Result<(String, String), Failure> {
    let name = path.parent().unwrap_or(Path::new("")).join(&reference.path);
    let text = read(&name).map_err(|failure| Failure {
        fault: format!("{}:{}: {}", path.display(), reference.place, failure.fault),
        ..failure
    })?;
    Ok((name.display().to_string(), text))
}

fn judged_by(path: &Path, scenario: &Scenario) -> Result<(Policy, Curves), Failure> {
    let broken = |fault: damage::Fault| Failure::input(fault.to_string());
    let policy = match &scenario.policy {
        None => Policy::shipped(),
        Some(reference) => {
            let (name, text) = named(path, reference)?;
            Policy::parse(&name, &text)
        }
    };
    let curves = match &scenario.curves {
        None => Curves::shipped(),
        Some(reference) => {
            let (name, text) = named(path, reference)?;
            Curves::parse(&name, &text)
        }
    };
    let (policy, curves) = (policy.map_err(broken)?, curves.map_err(broken)?);
    curves.covers(policy.outcome).map_err(|missing| Failure::input(missing.to_string()))?;
    Ok((policy, curves))
}

fn answer(
    path: &Path,
    text: &str,
    options: &EngineArgs,
    output: &Output,
) -> Result<ExitCode, Failure> {
    let begun_ns = clock::now_ns();
    let scenario = Scenario::parse(&path.display().to_string(), text)?;
    let engine = scenario.engine.apply(&overrides(options)?).map_err(|misfit| {
        Failure::new(Code::Configuration, misfit.fault.clone()).help(misfit.help)
    })?;
    let (policy, curves) = judged_by(path, &scenario)?;
    if scenario.deadline.is_some() {
        tracing::warn!("deadline_ms is not kept yet: the answer comes when all work is done");
    }
    let bodies = bodies::load(&scenario, &engine, path, output)?;
    let files: Vec<&[u8]> = bodies.iter().map(|body| body.bytes.bytes()).collect();
    let store = coordinator::seal(&files)?;
    drop(bodies);
    let views = model::store::open(store.bytes())
        .map_err(|error| Failure::new(Code::Internal, chain(&error)))?;
    let loaded_ns = clock::now_ns();
    let request = Request::new(&scenario, &views, policy, curves)?;
    let mut stages = Stages {
        load_ms: run::milliseconds(loaded_ns - begun_ns),
        plan_ms: run::milliseconds(clock::now_ns() - loaded_ns),
        ..Stages::default()
    };
    let (work, ran) = if options.in_process {
        run::here(&request, &views, &engine, &mut stages)
    } else {
        run::crew(&request, &views, &engine, &store, options, &mut stages)?
    };
    let before_ns = clock::now_ns();
    let (answer, _) = work.answer()?;
    stages.assess_ms = run::milliseconds(clock::now_ns() - before_ns);
    let run = Run { stages, ..ran };
    if output.json {
        let document = Document { schema: "trolley.rank/1", answer: &answer, run: &run };
        let text = serde_json::to_string_pretty(&document)
            .map_err(|error| Failure::new(Code::Internal, error.to_string()))?;
        print::out(&text)?;
    } else {
        print::out(&table::ranking(&scenario, &answer, &run))?;
    }
    Ok(match answer.state {
        State::Complete | State::Certified => ExitCode::SUCCESS,
        State::Degraded => Code::Degraded.into(),
        State::Refused => Code::Refused.into(),
    })
}
