//! Latency of a service's answers, compared with the same work done in this process in turns.
//!
//! Every answer is compared with that of this process: complete ones bit by bit, others by their
//! intervals.

use client::Client;
use hdrhistogram::Histogram;
use protocol::public::{Ask, WireAnswer, WirePlace, WireState};
use runtime::clock;
use serde::Serialize;
use service::InProcess;
use std::time::Duration;
use trolley::bodies::Bodies;
use trolley::{Failure, OpenDeployment};

/// Warm-up requests, which are not counted.
pub(crate) const WARM: u32 = 200;
/// After how many requests the work is repeated in this process.
const HERE: u32 = 8;
/// The longest time that a histogram resolves (ns).
const LONGEST_NS: u64 = 60_000_000_000;

/// The answers to the requests, and their latencies.
#[derive(Clone, Debug, Serialize)]
pub struct Latency {
    schema: &'static str,
    requests: u32,
    /// Answers by verdict: complete, certified, degraded, refused, busy.
    answers: [u64; 5],
    /// Number of rankings that contradict that of this process.
    wrong: u64,
    /// From the request to the answer (µs).
    service_us: Figures,
    /// The same request executed in this process (µs).
    kernel_us: Figures,
    /// Execution as the service reports it, without the transport (µs).
    worked_us: Figures,
    overhead_p50_us: f64,
}

/// A distribution (µs).
#[derive(Clone, Copy, Debug, Serialize)]
struct Figures {
    p50: f64,
    p99: f64,
    p999: f64,
    max: f64,
}

fn figures(times: &Histogram<u64>) -> Figures {
    let quantile_us = |share| times.value_at_quantile(share) as f64 / 1e3;
    Figures {
        p50: quantile_us(0.5),
        p99: quantile_us(0.99),
        p999: quantile_us(0.999),
        max: times.max() as f64 / 1e3,
    }
}

/// Sends a request to a service repeatedly, and sometimes executes it in this process too.
///
/// # Errors
///
/// If the bodies or rules of the deployment cannot be used. An answer that is wrong or late is no
/// error: see [`Latency::is_right`].
pub fn run(
    client: &mut Client,
    ask: &Ask,
    repeat: u32,
    patience: Duration,
    opened: &OpenDeployment,
) -> Result<Latency, Failure> {
    let criteria = opened.criteria()?;
    let bodies = Bodies::of_deployment(opened)?;
    let views = bodies.views()?;
    let depth = opened.deployment.engine.depth;
    let mut twin = InProcess::new(&opened.deployment, &views, criteria, depth);
    let mut here = || twin.answer(ask);
    let expected = here();
    let empty = || {
        Histogram::<u64>::new_with_max(LONGEST_NS, 3)
            .map_err(|error| Failure::internal(error.to_string()))
    };
    let (mut service, mut kernel, mut worked) = (empty()?, empty()?, empty()?);
    let (mut answers, mut wrong) = ([0; 5], 0);
    for number in 0..repeat.saturating_add(WARM) {
        let begun_ns = clock::now_ns();
        let answer = client.ask(ask, patience);
        let asked_ns = clock::now_ns();
        let here_ns = if number.is_multiple_of(HERE) {
            let done = here();
            wrong += u64::from(done.places != expected.places);
            Some(clock::now_ns() - asked_ns)
        } else {
            None
        };
        let has_ranking = answer.verdict().has_ranking();
        wrong += u64::from(!is_right(&answer, &expected));
        if number < WARM {
            continue;
        }
        answers[answer.verdict() as usize - 1] += 1;
        if has_ranking {
            service.saturating_record(asked_ns - begun_ns);
            worked.saturating_record(answer.worked_ns);
        }
        if let Some(here_ns) = here_ns {
            kernel.saturating_record(here_ns);
        }
    }
    Ok(Latency {
        schema: "trolley.latency/1",
        requests: repeat,
        answers,
        wrong,
        service_us: figures(&service),
        kernel_us: figures(&kernel),
        worked_us: figures(&worked),
        overhead_p50_us: figures(&service).p50 - figures(&kernel).p50,
    })
}

impl Latency {
    /// Whether no ranking contradicts that of this process.
    #[must_use]
    pub fn is_right(&self) -> bool {
        self.wrong == 0
    }

    /// The report as text.
    #[must_use]
    pub fn text(&self) -> String {
        page(self)
    }
}

/// Whether an answer agrees with the complete one: in every bit if it is complete itself; otherwise
/// its intervals hold the known values, and its certain winner wins. Means over fewer members are
/// others: their intervals say nothing of it.
fn is_right(answer: &WireAnswer, complete: &WireAnswer) -> bool {
    let is_whole = answer.place_count == complete.place_count;
    let places = &answer.places[..(answer.place_count as usize).min(answer.places.len())];
    let holds = |place: &WirePlace| {
        let known = complete.places.iter().find(|known| known.candidate == place.candidate);
        known.is_some_and(|k| place.work[0] <= k.work[0] && k.work[1] <= place.work[1])
    };
    match answer.verdict() {
        WireState::Complete => {
            bytemuck::bytes_of(&answer.places) == bytemuck::bytes_of(&complete.places) && is_whole
        }
        WireState::Certified => {
            let wins = answer.places[0].candidate == complete.places[0].candidate;
            wins && is_whole && places.iter().all(holds)
        }
        WireState::Degraded => {
            let is_same_mean = answer.members == complete.members;
            is_whole && (!is_same_mean || places.iter().all(holds))
        }
        _ => true,
    }
}

fn page(latency: &Latency) -> String {
    let row = |name: &str, figures: &Figures| {
        let Figures { p50, p99, p999, max } = figures;
        format!("{name:<26}{p50:>10.1}{p99:>10.1}{p999:>10.1}{max:>12.1}")
    };
    let [complete, certified, degraded, refused, busy] = latency.answers;
    format!(
        "{:<26}{:>10}{:>10}{:>10}{:>12}\n{}\n{}\n{}\n\n\
         {} requests: {complete} complete, {certified} certified, {degraded} degraded, \
         {refused} refused, {busy} busy; {} wrong.\n\
         The median request takes {:.1} µs more than the same work in this process.",
        "µs",
        "p50",
        "p99",
        "p99.9",
        "max",
        row("request to answer", &latency.service_us),
        row("execution in the service", &latency.worked_us),
        row("execution in this process", &latency.kernel_us),
        latency.requests,
        latency.wrong,
        latency.overhead_p50_us,
    )
}
