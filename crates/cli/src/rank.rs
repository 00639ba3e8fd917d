//! `trolley demo` and `trolley rank`: from a scenario to a printed answer.

use crate::args::{AnswerArgs, Assume, EngineArgs, Output, RankArgs};
use crate::bodies;
use crate::failure::{Code, Failure};
use crate::inputs::{self, Inputs, Read};
use crate::record::{self, Made};
use crate::run::{self, Run, Stages};
use crate::terms::{Kept, certain};
use crate::traffic;
use crate::{explain, print, table};
use coordinator::{Request, Work};
use damage::State;
use runtime::clock;
use runtime::error::chain;
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
    #[serde(skip_serializing_if = "Option::is_none")]
    explanation: Option<&'a coordinator::Explanation>,
    run: &'a Run,
}

pub(crate) fn demo(
    asked: &AnswerArgs,
    options: &EngineArgs,
    output: &Output,
) -> Result<ExitCode, Failure> {
    answer(Path::new("config/scenarios/demo.toml"), DEMO, asked, options, output)
}

pub(crate) fn rank(args: &RankArgs, output: &Output) -> Result<ExitCode, Failure> {
    let RankArgs { scenario: path, traffic, answer: asked, options } = args;
    if !traffic::is_traffic(path) {
        let text = inputs::text(path)?;
        return answer(path, &text, asked, options, output);
    }
    let imported = traffic::import(path, traffic)?;
    if !output.quiet && !output.json {
        print::err(&imported.summary());
    }
    match &imported.text {
        Some(text) => answer(path, text, asked, options, output),
        None => nothing(path, &imported, output),
    }
}

/// Nobody is met: a complete answer without a candidate.
fn nothing(
    path: &Path,
    imported: &traffic::Imported,
    output: &Output,
) -> Result<ExitCode, Failure> {
    if !output.json {
        return print::out("No manoeuvre meets anybody: there is nothing to rank. COMPLETE.");
    }
    let none: [&str; 0] = [];
    let document = serde_json::json!({
        "schema": "trolley.rank/1",
        "answer": {"state": State::Complete, "ranking": none, "tie_class": none, "missing": none},
        "traffic": imported.document(path),
    });
    print::out(&print::line(&document)?)
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

/// Refuses what nobody knows, unless something may be assumed of it.
fn check_unknown(file: &str, scenario: &Scenario, asked: &AnswerArgs) -> Result<(), Failure> {
    let Some(party) = scenario.parties.iter().find(|party| party.is_unknown) else {
        return Ok(());
    };
    match asked.assume {
        Some(Assume::UnknownFixed) => Ok(scenario.check_fixed(file)?),
        None => {
            let fault = format!("{file}:{}: \"{}\" is of unknown kind", party.place, party.name);
            Err(Failure::new(Code::Refused, fault).help(
                "say what it is, or let it be taken as fixed to the ground with nobody in it: \
                 --assume unknown=fixed",
            ))
        }
    }
}

fn answer(
    path: &Path,
    text: &str,
    asked: &AnswerArgs,
    options: &EngineArgs,
    output: &Output,
) -> Result<ExitCode, Failure> {
    let begun_ns = clock::now_ns();
    let inputs = Inputs::of(path, text)?;
    let Read { scenario, policy, curves } = inputs.read()?;
    check_unknown(&inputs.scenario.name, &scenario, asked)?;
    asked.record.as_deref().map(record::ready).transpose()?;
    let engine = scenario.engine.apply(&overrides(options)?).map_err(|misfit| {
        Failure::new(Code::Configuration, misfit.fault.clone()).help(misfit.help)
    })?;
    let terms = asked.terms.terms(scenario.deadline, asked.record.is_some())?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let beside = |_: usize, reference: &FileRef| folder.join(&reference.path);
    let bodies = bodies::load(&scenario, &engine, &inputs.scenario.name, &beside, output)?;
    let named = asked.record.as_ref().map(|_| record::bodies(&scenario, &bodies)).transpose()?;
    let files: Vec<&[u8]> = bodies.iter().map(|body| body.bytes.bytes()).collect();
    let store = coordinator::seal(&files)?;
    drop(bodies);
    let views = body::store::open(store.bytes())
        .map_err(|error| Failure::new(Code::Internal, chain(&error)))?;
    let loaded_ns = clock::now_ns();
    let request = Request::new(&scenario, &views, policy, curves)?;
    let mut stages = Stages {
        load_ms: run::milliseconds(loaded_ns - begun_ns),
        plan_ms: run::milliseconds(clock::now_ns() - loaded_ns),
        ..Stages::default()
    };
    let work = Work::new(&request, &views, engine.depth).with_terms(terms);
    let work = if asked.record.is_some() { work.with_ledger() } else { work };
    let (work, ran, crew) = if options.in_process {
        let (work, ran) = run::here(work, &engine, &views, &mut stages);
        (work, ran, None)
    } else {
        let (work, ran, crew) = run::crew(work, &engine, &views, &store, options, &mut stages)?;
        (work, ran, Some(crew))
    };
    let before_ns = clock::now_ns();
    let answer = work.answer()?;
    let answered_ns = clock::now_ns();
    stages.assess_ms = run::milliseconds(answered_ns - before_ns);
    let deadline = asked
        .terms
        .deadline(scenario.deadline)
        .map(|due| Kept::of(due, answered_ns.saturating_sub(work.accepted_ns())));
    // Whoever waits for an answer does not wait for the workers' end.
    let crew = if deadline.is_some() { crew } else { run::stop(crew, &mut stages) };
    let [winner_certain, order_certain] = certain(&work);
    let ran = Run { deadline, winner_certain, order_certain, ..ran };
    let explains = asked.explain || asked.record.is_some();
    let explanation = explains.then(|| work.explanation()).transpose()?;
    let run = Run { stages, ..ran };
    let recorded = match (&asked.record, &named) {
        (Some(folder), Some(bodies)) => {
            let made = Made {
                inputs: &inputs,
                engine: &engine,
                bodies,
                work: &work,
                run: &run,
                unknown_is_fixed: asked.assume == Some(Assume::UnknownFixed),
                answer: print::line(&answer)?,
                explanation: print::line(&explanation)?,
            };
            record::write(folder, made).map(Some)
        }
        _ => Ok(None),
    };
    let explanation = explanation.filter(|_| asked.explain);
    show(&scenario, &answer, explanation.as_ref(), &run, output)?;
    run::stop(crew, &mut Stages::default());
    // An answer that could not be recorded is shown, and then the failure.
    if let Some(path) = recorded?
        && !output.json
        && !output.quiet
    {
        print::err(&format!("recorded as {}", path.display()));
    }
    Ok(match answer.state {
        State::Complete | State::Certified => ExitCode::SUCCESS,
        State::Degraded => Code::Degraded.into(),
        State::Refused => Code::Refused.into(),
    })
}

/// Prints the answer, as a document or as a table.
fn show(
    scenario: &Scenario,
    answer: &coordinator::Answer,
    explanation: Option<&coordinator::Explanation>,
    run: &Run,
    output: &Output,
) -> Result<(), Failure> {
    if output.json {
        let document = Document { schema: "trolley.rank/1", answer, explanation, run };
        print::out(&print::json(&document)?)?;
        return Ok(());
    }
    print::out(&table::ranking(scenario, answer, run))?;
    if let Some(explanation) = explanation {
        print::out(&format!("\n{}", explain::text(explanation)))?;
    }
    Ok(())
}
