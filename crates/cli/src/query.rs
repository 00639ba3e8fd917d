//! `trolley query`: sends a scenario file to a running service.

use crate::answer_args::Assume;
use crate::output::Output;
use crate::reference_args::ReferenceArgs;
use crate::{print, table};
use clap::Args;
use client::public::{Reason, WireAnswer, WireContact, WirePlace, WireState, flag};
use client::{Client, Waiting};
use serde::Serialize;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;
use trolley::{Failure, FailureKind, OpenDeployment, Scenario};

/// The example of the laboratory.
#[cfg(feature = "lab")]
macro_rules! repeated {
    () => {
        "  trolley query DEPLOYMENT SCENARIO --repeat 100000   latencies, beside in-process\n"
    };
}
#[cfg(not(feature = "lab"))]
macro_rules! repeated {
    () => {
        ""
    };
}

pub(crate) const EXAMPLES: &str = concat!(
    "Examples, beside `trolley serve config/deployments/minimal.toml`:
  trolley query config/deployments/minimal.toml config/scenarios/wall-or-pole.toml --wait
  trolley query config/deployments/minimal.toml config/scenarios/minimal.toml --json
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
    /// Wait up to this long for the service to start (s); without a number 10 s.
    #[arg(long, value_name = "S", num_args = 0..=1, require_equals = true,
          default_missing_value = "10")]
    wait: Option<f64>,
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
    work: [f64; 2],
    range: [f64; 2],
    touches_nobody: bool,
    certain: bool,
    tied: bool,
    open_from_s: Option<f64>,
    contact_count: u32,
    contacts: Vec<Contact<'a>>,
    worst: Option<[f64; 2]>,
}

/// One of the first contacts of a candidate.
#[derive(Serialize)]
struct Contact<'a> {
    party: &'a str,
    time_s: f64,
    heavy: bool,
    closing_m_s: f64,
    delta_v_m_s: [[f64; 2]; 2],
}

pub(crate) fn run(options: &QueryArgs, output: &Output) -> Result<ExitCode, Failure> {
    let (instance, references) = (options.instance.as_deref(), options.references.references());
    let opened = OpenDeployment::open_with(&options.deployment, instance, references)?;
    let named = Scenario::open_with(&options.scenario, references)?;
    let scenario = named.parsed();
    let unknown_is_fixed = options.assume == Some(Assume::UnknownFixed);
    let ask = opened.ask(&named, unknown_is_fixed)?;
    if !(options.deadline_ms > 0.0 && options.deadline_ms <= 3_600_000.0) {
        let fault = format!("--deadline-ms {}: out of range", options.deadline_ms);
        return Err(Failure::setting(fault).with_remedy("use up to 3600000 ms"));
    }
    let patience = Duration::from_secs_f64(options.deadline_ms / 1000.0);
    let deployment = &opened.deployment;
    let connect =
        || Client::connect(deployment.folder.as_deref(), &deployment.instance, Waiting::Spin);
    let mut client = match options.wait {
        None => connect()?,
        Some(seconds) if seconds > 0.0 && seconds <= 3600.0 => {
            connected(connect, Duration::from_secs_f64(seconds))?
        }
        Some(seconds) => {
            let fault = format!("--wait={seconds}: out of range");
            return Err(Failure::setting(fault).with_remedy("wait up to 3600 s"));
        }
    };
    #[cfg(feature = "lab")]
    if let Some(repeat) = options.repeat {
        let latency = ::lab::latency::run(&mut client, &ask, repeat, patience, &opened)?;
        let shown = crate::lab::shown::show(&latency, || latency.text(), output)?;
        return Ok(if latency.is_right() { shown } else { FailureKind::CheckFailed.into() });
    }
    let answer = client.ask(&ask, patience);
    if output.json {
        let document = document(scenario, &answer);
        print::out(&print::json(&document)?)?;
    } else if answer.verdict().has_ranking() {
        print::out(&ranking(scenario, &answer))?;
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

/// Connects as soon as there is a service, within `patience`; else the last failure.
#[expect(clippy::disallowed_methods, reason = "nothing announces a service that is not there yet")]
fn connected<T, E: Into<Failure>>(
    connect: impl Fn() -> Result<T, E>,
    patience: Duration,
) -> Result<T, Failure> {
    /// Between two tries.
    const STEP: Duration = Duration::from_millis(20);
    let begun = std::time::Instant::now();
    loop {
        match connect().map_err(Into::into) {
            Ok(client) => return Ok(client),
            Err(failure) => {
                let failure: Failure = failure;
                if failure.kind() != FailureKind::TryAgain || begun.elapsed() >= patience {
                    return Err(failure);
                }
            }
        }
        std::thread::sleep(STEP);
    }
}

fn code(answer: &WireAnswer) -> FailureKind {
    match (answer.verdict(), answer.reason()) {
        (WireState::Busy, _) | (_, Reason::NoService | Reason::Stopping) => FailureKind::TryAgain,
        _ => FailureKind::Refused,
    }
}

fn name_of(scenario: &scenario::Scenario, candidate: u32) -> &str {
    scenario.candidates.get(candidate as usize).map_or("?", |candidate| &candidate.name)
}

fn party(scenario: &scenario::Scenario, number: u32) -> &str {
    scenario.parties.get(number as usize).map_or("?", |party| &party.name)
}

fn document<'a>(scenario: &'a scenario::Scenario, answer: &'a WireAnswer) -> Document<'a> {
    let contact = |contact: &WireContact| Contact {
        party: party(scenario, contact.party),
        time_s: contact.time_s,
        heavy: contact.flags & flag::HEAVY != 0,
        closing_m_s: contact.closing_m_s,
        delta_v_m_s: [contact.ego_delta_v_m_s, contact.other_delta_v_m_s],
    };
    let row = |place: &WirePlace| {
        let has = |bit: u32| place.flags & bit != 0;
        Row {
            name: name_of(scenario, place.candidate),
            work: place.work,
            range: place.range,
            touches_nobody: has(flag::TOUCHES_NOBODY),
            certain: has(flag::CERTAIN),
            tied: has(flag::TIED),
            open_from_s: has(flag::OPEN).then_some(place.open_from_s),
            contact_count: place.contact_count,
            contacts: place.listed().iter().map(contact).collect(),
            worst: has(flag::PERSON).then_some(place.worst),
        }
    };
    Document {
        schema: "trolley.query/2",
        state: answer.verdict().name(),
        reason: answer.reason().name(),
        text: answer.text(),
        request: answer.request,
        queued_us: answer.queued_ns as f64 / 1e3,
        worked_us: answer.worked_ns as f64 / 1e3,
        ranking: answer.ranking().iter().map(row).collect(),
    }
}

/// Whom a candidate meets, one a line.
fn meets(scenario: &scenario::Scenario, place: &WirePlace) -> String {
    let contact = |contact: &WireContact| {
        let kind = if contact.flags & flag::HEAVY == 0 { "light" } else { "heavy" };
        let (time_s, party) = (contact.time_s, party(scenario, contact.party));
        format!("{time_s:.2} s {party}, {kind} ({:.1} m/s)", contact.ego_delta_v_m_s[1])
    };
    let mut lines: Vec<String> = place.listed().iter().map(contact).collect();
    let more = place.contact_count as usize - lines.len().min(place.contact_count as usize);
    if more > 0 {
        lines.push(format!("and {more} more"));
    }
    if place.flags & flag::OPEN != 0 {
        lines.push(format!("not known after {:.2} s", place.open_from_s));
    } else if lines.is_empty() {
        let is_free = place.flags & flag::TOUCHES_NOBODY != 0;
        lines.push(if is_free { "nobody" } else { "nobody after the start" }.to_owned());
    }
    lines.join("\n")
}

/// The ranking as text.
fn ranking(scenario: &scenario::Scenario, answer: &WireAnswer) -> String {
    let mut table = table::plain(&["#", "candidate", "meets", "harm %", "range %"]);
    for (number, place) in answer.ranking().iter().enumerate() {
        table.add_row([
            (number + 1).to_string(),
            name_of(scenario, place.candidate).to_owned(),
            meets(scenario, place),
            table::percent(place.work[1]),
            format!("{}–{}", table::percent(place.range[0]), table::percent(place.range[1])),
        ]);
    }
    let free = |place: &&WirePlace| place.flags & flag::TOUCHES_NOBODY != 0;
    let name = |place: &WirePlace| name_of(scenario, place.candidate);
    let free: Vec<&str> = answer.ranking().iter().filter(free).map(name).collect();
    let best = answer.ranking().first().map_or("?", name);
    let hits_nobody = |place: &WirePlace| place.contact_count == 0 && place.flags & flag::OPEN == 0;
    let first = match free.as_slice() {
        [] if answer.ranking().iter().any(hits_nobody) => {
            format!("No way is free of contact from the start on. Least harm: {best}.")
        }
        [] => format!("Every way hits somebody, as far as is known. Least harm: {best}."),
        free => format!("Touches nobody until the end of its way: {}.", free.join(", ")),
    };
    let mut text = format!(
        "{}\n\n{first}\n{}: answered in {:.0} µs, after {:.0} µs of waiting.",
        table::lines(table, &[0, 3]),
        answer.verdict().name().to_uppercase(),
        answer.worked_ns as f64 / 1e3,
        answer.queued_ns as f64 / 1e3,
    );
    if !answer.text().is_empty() {
        text.push_str(&format!("\nNote: {}", answer.text()));
    }
    text
}
