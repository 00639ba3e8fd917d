//! `trolley top`: the state of a running service, each second: rate, answers, latencies, workers,
//! transfer.

use crate::output::Output;
use crate::print;
use clap::Args;
use client::Listener;
use client::public::{Condition, Health, LatencyStage, WireState};
use serde::Serialize;
use std::fmt::Write as _;
use std::io::IsTerminal as _;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;
use trolley::{Failure, FailureKind, OpenDeployment};

pub(crate) const EXAMPLES: &str = "\
Examples:
  trolley top config/deployments/minimal.toml               until Ctrl-C
  trolley top config/deployments/minimal.toml --times 1 --json

The first figures appear within a second. Without a terminal, pages are printed one after another.";

/// What to watch, and for how long.
#[derive(Clone, Debug, Args)]
pub(crate) struct TopArgs {
    /// The deployment that the service was started with.
    deployment: PathBuf,
    /// Instance name, overriding the file's.
    #[arg(long, value_name = "NAME")]
    instance: Option<String>,
    /// Stop after N pages.
    #[arg(long, value_name = "N")]
    times: Option<u64>,
}

/// How long to wait for a message of the service, which sends one each second.
const SILENCE: Duration = Duration::from_secs(5);

/// What `--json` prints, a line each time.
#[derive(Serialize)]
struct Document {
    schema: &'static str,
    condition: &'static str,
    pid: u32,
    up_s: f64,
    requests_per_s: f64,
    /// Answers by verdict since the start.
    answers: [(&'static str, u64); 5],
    waiting: [u32; 2],
    clients: u32,
    workers: [u32; 2],
    lost: u64,
    withdrawn: u64,
    page_faults: u64,
    allocations: u64,
    messages: u64,
    message_bytes: u64,
    /// p50, p99, p99.9, greatest (µs).
    latency_us: [(&'static str, [f64; 4]); 5],
}

pub(crate) fn run(options: &TopArgs, output: &Output) -> Result<ExitCode, Failure> {
    let opened = OpenDeployment::open(&options.deployment, options.instance.as_deref())?;
    let deployment = &opened.deployment;
    let listener = Listener::connect(deployment.folder.as_deref(), &deployment.instance)?;
    let clears = std::io::stdout().is_terminal() && !output.json;
    let mut before: Option<Health> = None;
    let mut shown = 0;
    while options.times.is_none_or(|times| shown < times) {
        let Some(health) = listener.health(SILENCE) else {
            let fault = format!("instance \"{}\" is silent", deployment.instance);
            return Err(Failure::new(FailureKind::TryAgain, fault)
                .with_remedy("it was killed or hangs: run systemctl status trolley"));
        };
        let rate = rate(before.as_ref(), &health);
        let text = if output.json {
            print::line(&document(&health, rate))?
        } else {
            let page = page(&health, rate, &deployment.instance);
            let page = print::folded(&page);
            if clears { format!("\x1b[H\x1b[2J{page}") } else { page }
        };
        let is_read = print::page(&format!("{}\n", text.trim_end_matches('\n')))?;
        shown += 1;
        if !is_read || health.condition == Condition::Stopping as u32 {
            break;
        }
        before = Some(health);
    }
    Ok(ExitCode::SUCCESS)
}

/// Answers per second since the page before, or since the start.
fn rate(before: Option<&Health>, now: &Health) -> f64 {
    let (count, since_ns) = match before {
        Some(before) => (before.answers.iter().sum::<u64>(), before.at_ns),
        None => (0, now.since_ns),
    };
    let seconds = now.at_ns.saturating_sub(since_ns) as f64 / 1e9;
    let answers = now.answers.iter().sum::<u64>().saturating_sub(count);
    if seconds > 0.0 { answers as f64 / seconds } else { 0.0 }
}

fn condition(health: &Health) -> &'static str {
    Condition::from_number(health.condition).map_or("?", Condition::name)
}

fn microseconds(row: [u64; 4]) -> [f64; 4] {
    row.map(|ns| ns as f64 / 1e3)
}

fn document(health: &Health, rate: f64) -> Document {
    let pair = |number: usize| (WireState::ALL[number].name(), health.answers[number]);
    let stage =
        |stage: LatencyStage| (stage.name(), microseconds(health.latency_ns[stage as usize]));
    Document {
        schema: "trolley.top/1",
        condition: condition(health),
        pid: health.pid,
        up_s: health.at_ns.saturating_sub(health.since_ns) as f64 / 1e9,
        requests_per_s: rate,
        answers: core::array::from_fn(pair),
        waiting: [health.waiting, health.queue],
        clients: health.clients,
        workers: [health.alive, health.workers],
        lost: health.lost,
        withdrawn: health.withdrawn,
        page_faults: health.faults,
        allocations: health.allocations,
        messages: health.messages,
        message_bytes: health.message_bytes,
        latency_us: LatencyStage::ALL.map(stage),
    }
}

fn page(health: &Health, rate: f64, instance: &str) -> String {
    let up = health.at_ns.saturating_sub(health.since_ns) / 1_000_000_000;
    let answers: Vec<String> = WireState::ALL
        .iter()
        .zip(health.answers)
        .map(|(verdict, count)| format!("{count} {}", verdict.name()))
        .collect();
    let mut text = format!(
        "trolley \"{instance}\" · {} · pid {} · up {}:{:02}:{:02}\n\n\
         {rate:.0} requests/s · {} of {} wait · {} clients · {} of {} workers, {} lost\n\
         answers: {} · {} withdrawn\n\
         {} page faults within requests · {} allocations in the last · {} messages, {} MiB\n\n\
         {:<10}{:>12}{:>12}{:>12}{:>12}\n",
        condition(health),
        health.pid,
        up / 3600,
        up / 60 % 60,
        up % 60,
        health.waiting,
        health.queue,
        health.clients,
        health.alive,
        health.workers,
        health.lost,
        answers.join(", "),
        health.withdrawn,
        health.faults,
        health.allocations,
        health.messages,
        health.message_bytes >> 20,
        "µs",
        "p50",
        "p99",
        "p99.9",
        "max",
    );
    for stage in LatencyStage::ALL {
        let [p50, p99, p999, max] = microseconds(health.latency_ns[stage as usize]);
        // Writing to a string cannot fail.
        let _ok =
            writeln!(text, "{:<10}{p50:>12.1}{p99:>12.1}{p999:>12.1}{max:>12.1}", stage.name());
    }
    let _ok = writeln!(
        text,
        "\n{:<10}{:>8}{:>6}{:>14}{:>12}{:>10}",
        "worker", "pid", "core", "jobs", "busy s", "replaced"
    );
    for (number, row) in health.each.iter().enumerate().filter(|(_, row)| row.pid != 0) {
        let core = row.core.checked_sub(1).map_or("–".to_owned(), |core| core.to_string());
        let busy = row.busy_ns as f64 / 1e9;
        let _ok = writeln!(
            text,
            "{number:<10}{:>8}{core:>6}{:>14}{busy:>12.1}{:>10}",
            row.pid, row.jobs, row.replaced
        );
    }
    text
}
