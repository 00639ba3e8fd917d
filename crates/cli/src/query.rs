//! `trolley query`: sends a scenario file to a running service.

use crate::answer_args::Assume;
use crate::output::Output;
use crate::reference_args::ReferenceArgs;
use crate::{print, table};
use clap::Args;
use client::public::{Reason, WireAnswer, WirePlace, WireState, flag};
use client::{Client, Waiting};
use comfy_table::{CellAlignment, Table};
use scenario::Scenario;
use serde::Serialize;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;
use trolley::files::InputKind;
use trolley::{Failure, FailureKind, OpenDeployment};

/// The example of the laboratory.
#[cfg(feature = "lab")]
macro_rules! repeated {
    () => {
        "  trolley query D.toml S.toml --repeat 100000    latencies, compared with in-process\n"
    };
}
#[cfg(not(feature = "lab"))]
macro_rules! repeated {
    () => {
        ""
    };
}

pub(crate) const EXAMPLES: &str = concat!(
    "Examples:
  trolley query config/deployments/minimal.toml config/scenarios/minimal.toml
  trolley query D.toml S.toml --json | jq .ranking[0].name
",
    repeated!(),
    "
Exit codes: 0 complete or certified, 3 degraded, 4 refused, 75 busy or not running."
);

/// The scenario, and the service to query.
#[derive(Clone, Debug, Args)]
pub(crate) struct QueryArgs {
    /// Deployment that the service was started with: names the service and its models.
    deployment: PathBuf,
    /// Scenario, TOML: see `trolley schema`. The service's engine, policy and curves apply.
    scenario: PathBuf,
    /// Instance name, overriding the file's.
    #[arg(long, value_name = "NAME")]
    instance: Option<String>,
    #[command(flatten)]
    references: ReferenceArgs,
    /// How long to wait for the answer (ms).
    #[arg(long, value_name = "MS", default_value_t = 1000.0)]
    deadline_ms: f64,
    /// Treat parties of unknown kind as unoccupied and fixed to the ground.
    #[arg(long, value_name = "unknown=fixed")]
    assume: Option<Assume>,
    /// Send the request N times, and compare the latencies with those of in-process execution.
    #[cfg(feature = "lab")]
    #[arg(long, value_name = "N")]
    repeat: Option<u32>,
}

/// What `--json` prints.
#[derive(Serialize)]
struct Document<'a> {
    schema: &'static str,
    state: &'static str,
    reason: &'static str,
    text: &'a str,
    request: u64,
    queued_us: f64,
    worked_us: f64,
    ranking: Vec<Row<'a>>,
}

/// One candidate of the ranking.
#[derive(Serialize)]
struct Row<'a> {
    name: &'a str,
    other: &'a str,
    work: [f64; 2],
    range: [f64; 2],
    touches: bool,
    certain: bool,
    tied: bool,
    depth_m: [f64; 2],
    delta_v_m_s: [[f64; 2]; 2],
    worst: Option<[f64; 2]>,
}

pub(crate) fn run(options: &QueryArgs, output: &Output) -> Result<ExitCode, Failure> {
    let (instance, references) = (options.instance.as_deref(), options.references.references());
    let opened = OpenDeployment::open_with(&options.deployment, instance, references)?;
    let text = trolley::files::text(&options.scenario, InputKind::Scenario)?;
    let name = options.scenario.display().to_string();
    let scenario = Scenario::parse(&name, &text)?;
    let unknown_is_fixed = options.assume == Some(Assume::UnknownFixed);
    let ask = opened.ask(&options.scenario, &scenario, unknown_is_fixed)?;
    if !(options.deadline_ms > 0.0 && options.deadline_ms <= 3_600_000.0) {
        let fault = format!("--deadline-ms {}: out of range", options.deadline_ms);
        return Err(Failure::setting(fault).with_remedy("use up to 3600000 ms"));
    }
    let patience = Duration::from_secs_f64(options.deadline_ms / 1000.0);
    let deployment = &opened.deployment;
    let mut client =
        Client::connect(deployment.folder.as_deref(), &deployment.instance, Waiting::Spin)?;
    #[cfg(feature = "lab")]
    if let Some(repeat) = options.repeat {
        let latency = ::lab::latency::run(&mut client, &ask, repeat, patience, &opened)?;
        let shown = crate::lab::shown::show(&latency, || latency.text(), output)?;
        return Ok(if latency.is_right() { shown } else { FailureKind::CheckFailed.into() });
    }
    let answer = client.ask(&ask, patience);
    if output.json {
        let document = document(&scenario, &answer);
        print::out(&print::json(&document)?)?;
    } else if answer.verdict().has_ranking() {
        print::out(&ranking(&scenario, &answer))?;
    }
    match answer.verdict() {
        WireState::Complete | WireState::Certified => Ok(ExitCode::SUCCESS),
        WireState::Degraded => Ok(FailureKind::Degraded.into()),
        _ if output.json => Ok(code(&answer).into()),
        verdict => {
            let fault = format!("{}: {}", verdict.name(), answer.text());
            Err(Failure::new(code(&answer), fault))
        }
    }
}

fn code(answer: &WireAnswer) -> FailureKind {
    match (answer.verdict(), answer.reason()) {
        (WireState::Busy, _) | (_, Reason::NoService | Reason::Stopping) => FailureKind::TryAgain,
        _ => FailureKind::Refused,
    }
}

fn name_of<'a>(scenario: &'a Scenario, place: &WirePlace) -> (&'a str, &'a str) {
    let candidate = scenario.candidates.get(place.candidate as usize);
    candidate.map_or(("?", "?"), |candidate| {
        let other = scenario.parties.get(candidate.other.party.0);
        (&candidate.name, other.map_or("?", |party| &party.name))
    })
}

fn document<'a>(scenario: &'a Scenario, answer: &'a WireAnswer) -> Document<'a> {
    let row = |place: &WirePlace| {
        let (name, other) = name_of(scenario, place);
        let has = |bit: u32| place.flags & bit != 0;
        Row {
            name,
            other,
            work: place.work,
            range: place.range,
            touches: has(flag::TOUCHES),
            certain: has(flag::CERTAIN),
            tied: has(flag::TIED),
            depth_m: place.depth_m,
            delta_v_m_s: [place.ego_delta_v_m_s, place.other_delta_v_m_s],
            worst: has(flag::PERSON).then_some(place.worst),
        }
    };
    Document {
        schema: "trolley.query/1",
        state: answer.verdict().name(),
        reason: answer.reason().name(),
        text: answer.text(),
        request: answer.request,
        queued_us: answer.queued_ns as f64 / 1e3,
        worked_us: answer.worked_ns as f64 / 1e3,
        ranking: answer.ranking().iter().map(row).collect(),
    }
}

/// The ranking as text.
fn ranking(scenario: &Scenario, answer: &WireAnswer) -> String {
    let mut table = Table::new();
    table.load_style(comfy_table::presets::NOTHING);
    table.set_header(["#", "candidate", "contact", "depth", "ΔV ego/other", "harm %", "range %"]);
    for (number, place) in answer.ranking().iter().enumerate() {
        let (name, other) = name_of(scenario, place);
        let touches = place.flags & flag::TOUCHES != 0;
        let contact = if touches { format!("with {other}") } else { "none".to_owned() };
        let dash = |text: String| if touches { text } else { "–".to_owned() };
        table.add_row([
            (number + 1).to_string(),
            name.to_owned(),
            contact,
            dash(format!("{:.2} m", place.depth_m[1])),
            dash(format!("{:.1} / {:.1}", place.ego_delta_v_m_s[1], place.other_delta_v_m_s[1])),
            table::percent(place.work[1]),
            format!("{}–{}", table::percent(place.range[0]), table::percent(place.range[1])),
        ]);
    }
    for number in 3..7 {
        if let Some(column) = table.column_mut(number) {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    let best = answer.ranking().first().map_or("?", |place| name_of(scenario, place).0);
    let mut text = format!(
        "{}\n\nLeast harm: {best}. {}: answered in {:.0} µs, after {:.0} µs of waiting.",
        table.to_string().lines().map(str::trim_end).collect::<Vec<_>>().join("\n"),
        answer.verdict().name().to_uppercase(),
        answer.worked_ns as f64 / 1e3,
        answer.queued_ns as f64 / 1e3,
    );
    if !answer.text().is_empty() {
        text.push_str(&format!("\nNote: {}", answer.text()));
    }
    text
}
