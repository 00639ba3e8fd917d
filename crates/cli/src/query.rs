//! `trolley query`: sends a scenario file to a running service.

mod document;
mod names;

use crate::answer_args::Assume;
use crate::output::Output;
use crate::print;
use crate::ranking_table::{self, StatedRow};
use crate::reference_args::ReferenceArgs;
use clap::Args;
use client::public::{
    Reason, WireAnswer, WireContact, WireMet, WirePersons, WirePlace, WireState, flag,
};
use client::{Client, Waiting};
use names::{name_of, party};
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;
use trolley::{Failure, FailureKind, Implausible, OpenDeployment, Scenario};

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
    /// Follow the candidates in N draws of what is known only up to errors, and rank by expected
    /// harm; 1: in the scene as stated alone [default: as the scenario says, else the deployment].
    #[arg(long, value_name = "N")]
    members: Option<i64>,
    /// Draw N members at most, where the best two are too close to call with fewer [default: 128,
    /// or `--members`].
    #[arg(long, value_name = "N", requires = "members")]
    members_max: Option<i64>,
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

pub(crate) fn run(options: &QueryArgs, output: &Output) -> Result<ExitCode, Failure> {
    let (instance, references) = (options.instance.as_deref(), options.references.references());
    let opened = OpenDeployment::open_with(&options.deployment, instance, references)?;
    let named = Scenario::open_with(&options.scenario, references)?;
    let scenario = named.parsed();
    let unknown_is_fixed = options.assume == Some(Assume::UnknownFixed);
    let mut ask = opened.ask(&named, unknown_is_fixed)?;
    if let Some(count) = options.members {
        // As for `rank`: with the same refusals.
        let members = trolley::Limits::members_of(count, options.members_max)?;
        ask.set_members(members.count, members.most);
    }
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
    // After the answer: it does not wait for the models to be read.
    let doubts = doubts(&opened, &named, &answer).unwrap_or_else(|failure| {
        output.say(&format!("note: what is hardly true was not looked for: {failure}"));
        Vec::new()
    });
    if output.json {
        let document = document::of_answer(scenario, &answer, &doubts);
        print::out(&print::json(&document)?)?;
    } else if answer.verdict().has_ranking() {
        print::text(&ranking(scenario, &answer, &doubts))?;
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

/// What the scenario states, and what the first candidate does, that is hardly true: the service
/// does not say it.
fn doubts(
    opened: &OpenDeployment,
    named: &Scenario,
    answer: &WireAnswer,
) -> Result<Vec<Implausible>, Failure> {
    if !answer.verdict().has_ranking() {
        return Ok(Vec::new());
    }
    let mut doubts = opened.implausible(named)?;
    let free = answer.ranking().first().filter(|best| best.flags & flag::TOUCHES_NOBODY != 0);
    doubts.extend(free.and_then(|best| {
        let is_known = best.flags & flag::NEAREST != 0;
        let nearest = (party(named.parsed(), best.nearest_party), best.nearest_m);
        scenario::unmet(name_of(named.parsed(), best.candidate), is_known.then_some(nearest))
    }));
    Ok(doubts)
}

fn code(answer: &WireAnswer) -> FailureKind {
    match (answer.verdict(), answer.reason()) {
        (WireState::Busy, _) | (_, Reason::NoService | Reason::Stopping) => FailureKind::TryAgain,
        _ => FailureKind::Refused,
    }
}

/// Whom a candidate meets, one a line.
fn meets(scenario: &scenario::Scenario, place: &WirePlace) -> String {
    let contact = |contact: &WireContact| {
        let kind = if contact.flags & flag::HEAVY == 0 { "light" } else { "heavy" };
        let name = party(scenario, contact.party);
        let is_certain = contact.flags & flag::TOUCHES != 0;
        let ego_m_s = contact.ego_delta_v_m_s[1];
        ranking_table::contact(contact.time_s, name, kind, ego_m_s, is_certain)
    };
    let mut lines: Vec<String> = place.listed().iter().map(contact).collect();
    let more = place.contact_count as usize - lines.len().min(place.contact_count as usize);
    if more > 0 {
        lines.push(format!("and {more} more"));
    }
    if place.flags & flag::OPEN != 0 {
        lines.push(format!("not known after {:.2} s", place.open_from_s));
    } else if lines.is_empty() && place.flags & (flag::TOUCHES_NOBODY | flag::STATED_ALONE) == 0 {
        lines.push("nobody after the start".to_owned());
    } else if lines.is_empty() {
        let nearest = (party(scenario, place.nearest_party), place.nearest_m, place.nearest_s);
        let is_known = place.flags & flag::NEAREST != 0;
        lines.push(ranking_table::nobody(is_known.then_some(nearest)));
    }
    lines.join("\n")
}

/// As [`ranking_table::is_marked`], for the candidate in this place.
fn is_marked(
    scenario: &scenario::Scenario,
    (at, place): (usize, &WirePlace),
    doubts: &[Implausible],
) -> bool {
    let expected = place.expected().into_iter().flat_map(|of| of.listed()).map(|met| met.party);
    let met = place.listed().iter().map(|contact| contact.party).chain(expected);
    ranking_table::is_marked(doubts, at == 0, met.map(|number| party(scenario, number)))
}

/// The table of candidates in the scene as stated.
fn stated(scenario: &scenario::Scenario, answer: &WireAnswer, doubts: &[Implausible]) -> String {
    ranking_table::stated(answer.ranking().iter().enumerate().map(|(at, place)| {
        let who = || {
            let seat = WirePersons::seat_name(place.worst_seat);
            ranking_table::worst_off(party(scenario, place.worst_party), seat)
        };
        let is_known = place.flags & flag::PERSON != 0;
        StatedRow {
            is_marked: is_marked(scenario, (at, place), doubts),
            name: name_of(scenario, place.candidate),
            meets: meets(scenario, place),
            worst: is_known.then(|| (who(), place.worst[1])),
            work: place.work,
            range: place.range,
        }
    }))
}

/// The table of candidates over members.
fn over_members(
    scenario: &scenario::Scenario,
    answer: &WireAnswer,
    doubts: &[Implausible],
) -> String {
    let met = |met: &WireMet| (party(scenario, met.party), met.probability, met.from_s);
    let rows = answer.ranking().iter().enumerate();
    let rows = rows.filter_map(|(at, place)| place.expected().map(|of| (at, place, of)));
    ranking_table::expected(rows.map(|(at, place, of)| ranking_table::ExpectedRow {
        is_marked: is_marked(scenario, (at, place), doubts),
        name: name_of(scenario, place.candidate),
        meets: of.listed().iter().map(met).collect(),
        more: (of.met_count as usize).saturating_sub(of.listed().len()),
        open: of.open,
        work: place.work,
        range: place.range,
        spread: place.has_spread().then_some(ranking_table::Spread {
            error: of.error,
            outer: [of.quantiles[0], of.quantiles[2]],
            best: of.best,
        }),
        worlds: answer.has_worlds().then_some(of.worlds),
    }))
}

/// The ranking as text.
fn ranking(scenario: &scenario::Scenario, answer: &WireAnswer, doubts: &[Implausible]) -> String {
    let all = answer.ranking();
    let has = |place: &WirePlace, bit: u32| place.flags & bit != 0;
    let name = |place: &WirePlace| name_of(scenario, place.candidate);
    let with = |bit: u32| all.iter().filter(move |place| has(place, bit)).map(name);
    let free: Vec<&str> = with(flag::TOUCHES_NOBODY).collect();
    let best = all.first();
    let best_name = best.map_or("?", name);
    let over = best.and_then(|best| best.expected().map(|of| (best, of)));
    let table = match over {
        Some(_) => over_members(scenario, answer, doubts),
        None => stated(scenario, answer, doubts),
    };
    let mut lines = Vec::new();
    let others: Vec<&str> = with(flag::TIED).filter(|name| *name != best_name).collect();
    let least = ranking_table::least(best_name, others.len());
    let hits_nobody = all.iter().any(WirePlace::hits_nobody);
    let is_known = best.is_none_or(|best| !has(best, flag::STATED_ALONE));
    lines.push(ranking_table::first(&free, is_known.then_some(hits_nobody), &least));
    if !free.is_empty() && !free.contains(&best_name) {
        lines.push(format!("First under the policy: {best_name}."));
    }
    lines.extend(ranking_table::implausible(doubts));
    lines.push(format!(
        "{}: answered in {:.0} µs, after {:.0} µs of waiting.",
        answer.verdict().name().to_uppercase(),
        answer.worked_ns as f64 / 1e3,
        answer.queued_ns as f64 / 1e3,
    ));
    if let Some((best, of)) = over {
        let injured = best.has_spread().then_some(of.injured[1]);
        lines.push(ranking_table::members(answer.members, answer.replaced, injured));
        lines.extend(answer.lead().and_then(|(mean, error)| ranking_table::lead(mean, error)));
        if answer.has_worlds() {
            lines.push(ranking_table::worlds(answer.worlds, of.worlds, None));
        }
    }
    lines.extend(ranking_table::tied(&others));
    if !answer.text().is_empty() {
        lines.push(format!("Note: {}", answer.text()));
    }
    format!("{table}\n\n{}", lines.join("\n"))
}
