//! `trolley demo` and `trolley rank`: from a scenario to a printed answer.

use crate::answer_args::{AnswerArgs, Assume};
use crate::engine_args::EngineArgs;
use crate::output::Output;
use crate::reference_args::ReferenceArgs;
use crate::traffic::TrafficArgs;
use crate::{course_table, print, traffic};
use clap::Args;
use report::pictures;
use report::plan::PlanPage;
use report::text::COLUMNS;
use report::work::WorkDone;
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use trolley::plan::PlanScene;
use trolley::record::Signer;
use trolley::{
    Answer, AnswerState, Engine, Explanation, Failure, FailureKind, Ranking, Record, References,
    Run, Scenario,
};

/// The arguments of `rank`.
#[derive(Clone, Debug, Args)]
pub(crate) struct RankArgs {
    /// Scenario, TOML: see `trolley help keys`; or traffic: CommonRoad (.xml), or a trace of a
    /// simulator (.osi, .mcap, .csv); - for a scenario on the standard input.
    scenario: PathBuf,
    #[command(flatten)]
    references: ReferenceArgs,
    #[command(flatten)]
    traffic: TrafficArgs,
    #[command(flatten)]
    answer: AnswerArgs,
    /// Write a page of the ranking: the scene from above over time, and every contact. A single
    /// file that needs no network.
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
    /// Write what the page shows as one JSON document, for notebooks and dashboards: `trolley
    /// schema --report` describes it.
    #[arg(long, value_name = "FILE.json")]
    report_json: Option<PathBuf>,
    #[command(flatten)]
    options: EngineArgs,
}

/// What stands for the standard input.
const STDIN: &str = "-";

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
    let code = answer(Scenario::demo()?, asked, options, Drawn::default(), output)?;
    output.say("Next: trolley init crash.toml && trolley rank crash.toml");
    output.say("Next: trolley help tutorial");
    Ok(code)
}

pub(crate) fn rank(args: &RankArgs, output: &Output) -> Result<ExitCode, Failure> {
    let RankArgs { scenario: path, references, traffic, answer: asked, options, .. } = args;
    let drawn = Drawn { page: args.report.as_deref(), json: args.report_json.as_deref() };
    // Fail before the work, not after it, if a file cannot be written.
    for file in drawn.files() {
        trolley::files::check(file, Some(path))?;
    }
    let references = references.references();
    if path == Path::new(STDIN) {
        let text = trolley::read_text(Path::new("/dev/stdin"))?;
        // Files that it names are sought from the current folder.
        let scenario = Scenario::parse_with(STDIN, &text, references)?;
        return answer(scenario, asked, options, drawn, output);
    }
    if !trolley::traffic::is_traffic(path) {
        let scenario = Scenario::open_with(path, references)?;
        return answer(scenario, asked, options, drawn, output);
    }
    let imported = traffic::import(path, traffic, references)?;
    output.say(&imported.summary());
    let name = path.display().to_string();
    // Its models are those of the library, which was asked already.
    let scenario = Scenario::parse_with(&name, &imported.text, References::Anywhere)?;
    answer(scenario, asked, options, drawn, output)
}

/// Ranks a scenario, and prints the answer.
fn answer(
    scenario: Scenario,
    asked: &AnswerArgs,
    options: &EngineArgs,
    drawn: Drawn<'_>,
    output: &Output,
) -> Result<ExitCode, Failure> {
    let scenario = match asked.assume {
        Some(Assume::UnknownFixed) => scenario.assuming_unknown_is_fixed(),
        None => scenario,
    };
    let expiry = trolley::policy::expiry(&scenario.criteria().policy, trolley::policy::today());
    if let Some(expiry) = expiry.filter(|_| !output.quiet) {
        print::err(&format!("warning: {expiry}"));
    }
    options.check(&scenario.parsed().engine)?;
    let records = Records::prepare(asked, options)?;
    let mut engine = engine(options)?;
    let progress = output.progress("building bodies: triangles");
    let told = |done, total| progress.set(done, total);
    let is_drawn = drawn.files().next().is_some();
    let mut scene = is_drawn.then(PlanScene::default);
    let limits = asked.limits()?;
    let limits = if is_drawn { limits.with_explanation() } else { limits };
    let mut ranking = engine.rank_drawn(&scenario, &limits, &told, scene.as_mut())?;
    drop(progress);
    if asked.strict {
        trolley::check_plausible(&scenario, &ranking.answer)?;
    }
    // The answer does not wait for the workers to end.
    if ranking.run.deadline.is_none() {
        ranking.run.stages.stop_ms = engine.stop_workers();
    }
    let recorded = records.as_ref().map(|records| records.write(&ranking));
    let name = &scenario.parsed().name;
    let page = scene.as_ref().map(|scene| draw(drawn, name, &ranking, scene, &engine));
    show(name, &ranking, asked.explain, output)?;
    drop(engine);
    // If recording fails, the answer is shown before the failure.
    if let Some(path) = recorded.transpose()? {
        output.say(&format!("recorded as {}", path.display()));
    }
    // If the page cannot be written, the answer is shown before the failure.
    page.transpose()?;
    for file in drawn.files() {
        output.say(&format!("written: {}", file.display()));
    }
    Ok(code(&ranking.answer))
}

/// Where the page of a ranking is written, and what it shows as JSON.
#[derive(Clone, Copy, Debug, Default)]
struct Drawn<'a> {
    page: Option<&'a Path>,
    json: Option<&'a Path>,
}

impl<'a> Drawn<'a> {
    fn files(self) -> impl Iterator<Item = &'a Path> {
        self.page.into_iter().chain(self.json)
    }
}

/// Writes the page of a ranking, and its document.
fn draw(
    drawn: Drawn<'_>,
    name: &str,
    ranking: &Ranking,
    scene: &PlanScene,
    engine: &Engine,
) -> Result<(), Failure> {
    let bodies = engine.bodies().map(pictures::bodies).transpose()?.unwrap_or_default();
    let explanation = ranking.explanation.as_ref();
    let explanation = explanation.map(|of| report::explain::text(of, COLUMNS));
    let page = PlanPage {
        scenario: name,
        answer: &ranking.answer,
        work: &WorkDone::of_run(&ranking.run),
        scene,
        bodies: &bodies,
        shots: &pictures::all_shots(scene, &ranking.answer),
        explanation: explanation.as_deref(),
    };
    if let Some(file) = drawn.page {
        trolley::files::replace(file, report::plan::page(&page).as_bytes())?;
    }
    if let Some(file) = drawn.json {
        trolley::files::replace(file, report::document::document(&page)?.as_bytes())?;
    }
    Ok(())
}

/// Prints the answer, as a document or as a table.
fn show(name: &str, ranking: &Ranking, explains: bool, output: &Output) -> Result<(), Failure> {
    let Ranking { answer, run, .. } = ranking;
    let explanation = ranking.explanation.as_ref().filter(|_| explains);
    if output.json {
        let document = Document { schema: "trolley.rank/2", answer, explanation, run };
        print::out(&print::json(&document)?)?;
        return Ok(());
    }
    print::text(&course_table::ranking(name, answer, run))?;
    if let Some(explanation) = explanation {
        print::lines(&course_table::courses(answer))?;
        let columns = print::columns().unwrap_or(COLUMNS);
        print::out(&format!("\n{}", report::explain::text(explanation, columns)))?;
    }
    Ok(())
}

fn code(answer: &Answer) -> ExitCode {
    if answer.refusal().is_some() {
        return FailureKind::Refused.into();
    }
    match answer.state {
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

    fn write(&self, ranking: &Ranking) -> Result<PathBuf, Failure> {
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
