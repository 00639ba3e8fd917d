//! `trolley demo` and `trolley rank`: from a scenario to a printed answer.

use crate::answer_args::{AnswerArgs, Assume};
use crate::engine_args::EngineArgs;
use crate::output::Output;
use crate::reference_args::ReferenceArgs;
use crate::traffic::TrafficArgs;
use crate::{course_table, print, table, traffic};
use clap::Args;
use report::plan::PlanPage;
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use trolley::explanation::Explanation;
use trolley::record::{Recordable, Signer};
use trolley::{
    Answer, AnswerState, Engine, Explanation, Failure, FailureKind, Horizon, HorizonRanking,
    PlanScene, Ranking, Record, References, Run, Scenario,
};

/// The arguments of `rank`.
#[derive(Clone, Debug, Args)]
pub(crate) struct RankArgs {
    /// Scenario, TOML: see `trolley schema`; or traffic: CommonRoad or OpenSCENARIO, XML.
    scenario: PathBuf,
    #[command(flatten)]
    references: ReferenceArgs,
    #[command(flatten)]
    traffic: TrafficArgs,
    #[command(flatten)]
    answer: AnswerArgs,
    /// Write a page of the ranking over a horizon: the scene from above over time, and every
    /// contact. A single file that needs no network.
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
    #[command(flatten)]
    options: EngineArgs,
}

/// What `--json` prints.
#[derive(Serialize)]
struct Document<'a> {
    schema: &'static str,
    answer: &'a Answer,
    #[serde(skip_serializing_if = "Option::is_none")]
    explanation: Option<&'a Explanation>,
    run: &'a Run,
}

pub(crate) fn demo(
    asked: &AnswerArgs,
    options: &EngineArgs,
    output: &Output,
) -> Result<ExitCode, Failure> {
    answer(Scenario::demo()?, asked, options, output)
}

pub(crate) fn rank(args: &RankArgs, output: &Output) -> Result<ExitCode, Failure> {
    let RankArgs { scenario: path, references, traffic, answer: asked, report, options } = args;
    let drawn = report.as_deref();
    // Fail before the work, not after it, if the page cannot be written.
    if let Some(page) = drawn {
        trolley::files::check(page, Some(path))?;
    }
    let references = references.references();
    if !trolley::traffic::is_traffic(path) {
        let text = trolley::read_text(path)?;
        let name = path.display().to_string();
        if scenario::is_horizon_text(&text) {
            let horizon = Horizon::parse_with(&name, &text, references)?;
            return answer_horizon(horizon, asked, options, drawn, output);
        }
        if drawn.is_some() {
            let what = "--report: this scenario says who meets whom, and has no scene to draw";
            let help = "record it with --record DIR, then: trolley report DIR/000000.record --out \
                        FILE.html";
            return Err(Failure::setting(what).with_remedy(help));
        }
        let scenario = Scenario::parse_with(&name, &text, references)?;
        return answer(scenario, asked, options, output);
    }
    let imported = traffic::import(path, traffic, references)?;
    let name = path.display().to_string();
    let document = imported.horizon_document(path)?;
    output.say(&imported.horizon_summary());
    // Its models are those of the library, which was asked already.
    let horizon = Horizon::parse_with(&name, document.scenario, References::Anywhere)?;
    answer_horizon(horizon, asked, options, drawn, output)
}

fn answer(
    scenario: Scenario,
    asked: &AnswerArgs,
    options: &EngineArgs,
    output: &Output,
) -> Result<ExitCode, Failure> {
    let scenario = match asked.assume {
        Some(Assume::UnknownFixed) => scenario.assuming_unknown_is_fixed(),
        None => scenario,
    };
    let records = Records::prepare(asked, options)?;
    let limits = asked.limits()?;
    let mut engine = engine(options)?;
    let progress = output.progress("building bodies: triangles");
    let told = |done, total| progress.set(done, total);
    let mut ranking = engine.rank_telling(&scenario, &limits, &told)?;
    drop(progress);
    // The answer does not wait for the workers to end.
    if ranking.run.deadline.is_none() {
        ranking.run.stages.stop_ms = engine.stop_workers();
    }
    let recorded = records.as_ref().map(|records| records.write(&ranking));
    show(&scenario, &ranking, asked.explain, output)?;
    drop(engine);
    // If recording fails, the answer is shown before the failure.
    if let Some(path) = recorded.transpose()? {
        output.say(&format!("recorded as {}", path.display()));
    }
    Ok(code(ranking.answer.state))
}

/// Ranks a scenario over a horizon, and prints the answer.
fn answer_horizon(
    horizon: Horizon,
    asked: &AnswerArgs,
    options: &EngineArgs,
    drawn: Option<&Path>,
    output: &Output,
) -> Result<ExitCode, Failure> {
    let horizon = match asked.assume {
        Some(Assume::UnknownFixed) => horizon.assuming_unknown_is_fixed(),
        None => horizon,
    };
    let records = Records::prepare(asked, options)?;
    let mut engine = engine(options)?;
    let progress = output.progress("building bodies: triangles");
    let told = |done, total| progress.set(done, total);
    let mut scene = drawn.map(|_| PlanScene::default());
    let limits = asked.limits()?;
    let mut ranking = engine.rank_horizon_drawn(&horizon, &limits, &told, scene.as_mut())?;
    drop(progress);
    if ranking.run.deadline.is_none() {
        ranking.run.stages.stop_ms = engine.stop_workers();
    }
    let recorded = records.as_ref().map(|records| records.write(&ranking));
    let HorizonRanking { answer, run, .. } = &ranking;
    let explanation = ranking.explanation.as_ref().filter(|_| asked.explain);
    let page = drawn.zip(scene.as_ref()).map(|(file, scene)| {
        let page = PlanPage { scenario: &horizon.parsed().name, answer, run, scene };
        trolley::files::replace(file, report::plan::page(&page).as_bytes()).map(|()| file)
    });
    if output.json {
        let document = CourseDocument { schema: "trolley.rank/2", answer, explanation, run };
        print::out(&print::json(&document)?)?;
    } else {
        print::out(&course_table::ranking(&horizon.parsed().name, answer, run))?;
        if let Some(explanation) = explanation {
            print::out(&course_table::courses(answer))?;
            print::out(&format!("\n{}", report::explain::courses(explanation)))?;
        }
    }
    drop(engine);
    // If recording fails, the answer is shown before the failure.
    if let Some(path) = recorded.transpose()? {
        output.say(&format!("recorded as {}", path.display()));
    }
    // If the page cannot be written, the answer is shown before the failure.
    if let Some(file) = page.transpose()? {
        output.say(&format!("written: {}", file.display()));
    }
    Ok(code(answer.state))
}

/// What `--json` prints of a scenario over a horizon.
#[derive(Serialize)]
struct CourseDocument<'a> {
    schema: &'static str,
    answer: &'a Answer,
    #[serde(skip_serializing_if = "Option::is_none")]
    explanation: Option<&'a Explanation>,
    run: &'a Run,
}

fn code(state: AnswerState) -> ExitCode {
    match state {
        AnswerState::Complete | AnswerState::Certified => ExitCode::SUCCESS,
        AnswerState::Degraded => FailureKind::Degraded.into(),
        AnswerState::Refused => FailureKind::Refused.into(),
    }
}

/// Where a record is written, and the key that signs it.
struct Records<'a> {
    folder: &'a Path,
    signer: Option<Signer>,
}

impl<'a> Records<'a> {
    /// Checks that a record can be added, before work is spent.
    fn prepare(asked: &'a AnswerArgs, options: &EngineArgs) -> Result<Option<Self>, Failure> {
        let Some(folder) = asked.record.as_deref() else { return Ok(None) };
        let signer = asked.sign.as_deref().map(Signer::open).transpose()?;
        let signer = match (signer, &options.instance) {
            (Some(signer), Some(name)) => Some(signer.with_instance(name)),
            (signer, _) => signer,
        };
        match &signer {
            Some(signer) => signer.prepare(folder)?,
            None => Record::prepare(folder)?,
        }
        Ok(Some(Self { folder, signer }))
    }

    fn write(&self, ranking: &impl Recordable) -> Result<PathBuf, Failure> {
        match &self.signer {
            Some(signer) => signer.write(self.folder, ranking),
            None => Record::write(self.folder, ranking),
        }
    }
}

/// The engine configured by the command line.
fn engine(options: &EngineArgs) -> Result<Engine, Failure> {
    let mut builder = Engine::builder().overrides(options.overrides()?);
    if let Some(instance) = &options.instance {
        builder = builder.instance(instance);
    }
    if options.in_process {
        builder = builder.in_process();
    }
    builder.build()
}

/// Prints the answer, as a document or as a table.
fn show(
    scenario: &Scenario,
    ranking: &Ranking,
    explains: bool,
    output: &Output,
) -> Result<(), Failure> {
    let Ranking { answer, run, .. } = ranking;
    let explanation = ranking.explanation.as_ref().filter(|_| explains);
    if output.json {
        let document = Document { schema: "trolley.rank/1", answer, explanation, run };
        print::out(&print::json(&document)?)?;
        return Ok(());
    }
    print::out(&table::ranking(scenario.parsed(), answer, run))?;
    if let Some(explanation) = explanation {
        print::out(&format!("\n{}", report::explain::text(explanation)))?;
    }
    Ok(())
}
