//! A ranking on more cores than there are: simulated with one, two and four workers, and measured
//! with as many as this machine can give a core each.

use super::bench::Bench;
use super::calibrate::calibrate;
use super::ranking::RankOptions;
use super::sweep::FINE;
use crate::pair::PairName;
use crate::progress::{Progress, SyncProgress};
use coordinator::{MessageCosts, VirtualSetup, VirtualTime};
use kind::Kind;
use runtime::clock;
use separate::Separate;
use serde::Serialize;
use simulate::Costs;
use std::fmt::Write as _;
use std::thread;
use trolley::dispatch_options::DispatchOptions;
use trolley::{Engine, Failure, Scenario};

mod kind;
mod separate;

/// What messages cost is measured with these bodies.
const PAIR: &str = "sedan:20000,suv:20000,deep";

/// Rankings of each kind, in turns: as many as level out that a core has more to do for others in
/// some of them.
const TURNS: u64 = 9;

/// Numbers of workers, and whether the coordinator shares a core with one of them.
const SETUPS: [(usize, bool); 4] = [(1, false), (2, true), (4, true), (4, false)];

/// A ranking with so many workers.
#[derive(Clone, Debug, Default, Serialize)]
pub struct VirtualRow {
    /// How many workers.
    pub workers: usize,
    /// On how many cores they and the coordinator are.
    pub cores: usize,
    /// How much sooner it is done than alone, by the same pieces of work: least, median, most.
    pub simulated: [f64; 3],
    /// The coordinator is busy by itself for so much of the time, in the median.
    pub coordinator: f64,
    /// Workers are busy for so much of the time, in the mean and the median.
    pub busy: f64,
    /// The speed-up with real workers, over the ranking alone just before: the median; `None`:
    /// there are too few cores.
    pub measured: Option<f64>,
}

/// What was found.
#[derive(Clone, Debug, Serialize)]
pub struct VirtualReport {
    schema: &'static str,
    scenario: String,
    turns: u64,
    /// Rankings without workers: the median (ms).
    alone_ms: f64,
    costs_ns: [u64; 5],
    /// How many cores are measured on.
    cores: usize,
    /// How many times as much these do at once as one does alone, if each ranks by itself: the
    /// median. No program gains more. `None`: workers are measured on none.
    at_once: Option<f64>,
    rows: Vec<VirtualRow>,
}

/// Simulates the ranking of a scenario with its overrides and limits. `told` is called with the
/// turns done.
///
/// # Errors
///
/// If the scenario cannot be ranked, or workers cannot be started.
pub fn virtual_cores(
    options: &RankOptions,
    told: SyncProgress<'_>,
) -> Result<VirtualReport, Failure> {
    let scenario = Scenario::open_with(&options.scenario, options.references)?;
    let costs = message_costs()?;
    // Numbers of workers come after them, and in their place.
    let builder = || Engine::builder().overrides(options.overrides.clone());
    let make = || Kind::of(builder().in_process());
    let mut alone = make()?;
    let allowed = runtime::affinity::allowed_cores();
    let is_measured = |workers: usize, is_shared: bool| used(workers, is_shared) <= allowed.len();
    let (mut simulated, mut measured) = (Vec::new(), Vec::new());
    for (workers, is_shared) in SETUPS {
        let setup = VirtualSetup { workers, is_shared, costs };
        let virtual_cores = Some(setup);
        let dispatch_options = DispatchOptions { virtual_cores, ..DispatchOptions::default() };
        simulated.push(Kind::of(builder().in_process().dispatch_options(dispatch_options))?);
    }
    for (workers, _) in SETUPS.iter().filter(|setup| is_measured(setup.0, setup.1)) {
        measured.push(Kind::of(builder().workers(*workers))?);
    }
    let most = SETUPS.iter().map(|setup| used(setup.0, setup.1));
    let most = most.filter(|used| *used <= allowed.len()).max().unwrap_or(0);
    let cores = &allowed[..most];
    let bar = Progress::new(TURNS + 1, told);
    let at_once_ns = thread::scope(|scope| {
        let mut separate = Separate::of(scope, cores, &make, (&scenario, &options.limits));
        for turn in 0..=TURNS {
            let answer = alone.rank(&scenario, &options.limits)?;
            let mut others = separate.rank()?;
            for kind in measured.iter_mut().chain(&mut simulated) {
                others.push(kind.rank(&scenario, &options.limits)?);
            }
            if others.iter().any(|other| *other != answer) {
                return Err(Failure::internal("an answer depends on how it was worked out"));
            }
            // Bodies are loaded, and workers started, in the first one.
            if turn == 0 {
                let all = measured.iter_mut().chain(&mut simulated);
                all.chain([&mut alone]).for_each(Kind::forget);
                separate.took_ns.clear();
            }
            bar.add(1);
        }
        Ok(separate.took_ns)
    })?;
    let over = |took_ns: &[f64]| {
        let gains: Vec<f64> =
            alone.took_ns.iter().zip(took_ns).map(|(alone, took)| alone / took).collect();
        least_median_most(&gains)[1]
    };
    let mut measured = measured.iter();
    let rows = SETUPS.into_iter().zip(&simulated).map(|((workers, is_shared), kind)| {
        let real = is_measured(workers, is_shared).then(|| measured.next()).flatten();
        let measured = real.map(|real| over(&real.took_ns));
        VirtualRow { measured, ..row(workers, is_shared, &kind.times) }
    });
    let rows = rows.collect();
    let MessageCosts { hand_out_ns, flight_ns, send_ns, take_ns, thread_ns } = costs;
    Ok(VirtualReport {
        schema: "trolley.measure-virtual/3",
        scenario: options.scenario.display().to_string(),
        turns: TURNS,
        alone_ms: least_median_most(&alone.took_ns)[1] / 1e6,
        costs_ns: [hand_out_ns, flight_ns, send_ns, take_ns, thread_ns],
        cores: cores.len(),
        at_once: (!cores.is_empty()).then(|| cores.len() as f64 * over(&at_once_ns)),
        rows,
    })
}

/// Cores that so many workers and a coordinator use.
fn used(workers: usize, is_shared: bool) -> usize {
    workers + usize::from(!is_shared)
}

fn row(workers: usize, is_shared: bool, times: &[VirtualTime]) -> VirtualRow {
    let over = |part: f64, time: &VirtualTime| part / time.total_ns.max(1) as f64;
    let all = |part: &dyn Fn(&VirtualTime) -> f64| {
        let values: Vec<f64> = times.iter().map(|time| over(part(time), time)).collect();
        least_median_most(&values)
    };
    let busy =
        |time: &VirtualTime| time.busy_ns.iter().sum::<u64>() as f64 / time.busy_ns.len() as f64;
    VirtualRow {
        workers,
        cores: used(workers, is_shared),
        simulated: all(&|time| time.alone_ns as f64),
        coordinator: all(&|time| time.coordinator_ns as f64)[1],
        busy: all(&busy)[1],
        measured: None,
    }
}

fn least_median_most(values: &[f64]) -> [f64; 3] {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    match sorted.len().checked_sub(1) {
        None => [f64::NAN; 3],
        Some(last) => [sorted[0], sorted[last / 2], sorted[last]],
    }
}

/// What messages cost between real processes of this machine, and threads.
fn message_costs() -> Result<MessageCosts, Failure> {
    let pair: PairName =
        PAIR.parse().map_err(|fault| Failure::internal(format!("{PAIR}: {fault}")))?;
    let pair = pair.load()?;
    let costs = calibrate(&Bench::new(&pair, 3, false)?, FINE)?;
    let Costs { batch_ns, place_ns, flight_ns, send_ns, take_ns, .. } = costs;
    Ok(MessageCosts {
        // A job at a time, as looks are.
        hand_out_ns: (batch_ns + place_ns) as u64,
        flight_ns: flight_ns as u64,
        send_ns: send_ns as u64,
        take_ns: take_ns as u64,
        thread_ns: thread_ns(),
    })
}

/// From the start of a thread to its first work: the median of some (ns).
fn thread_ns() -> u64 {
    let mut all: Vec<u64> = (0..31)
        .map(|_| {
            let begun_ns = clock::now_ns();
            let first_ns = thread::scope(|scope| scope.spawn(clock::now_ns).join());
            first_ns.map_or(0, |first_ns| first_ns - begun_ns)
        })
        .collect();
    all.sort_unstable();
    all[all.len() / 2]
}

impl VirtualReport {
    /// The report as text.
    #[must_use]
    pub fn text(&self) -> String {
        let mut text = format!(
            "{}: {:.1} ms in one process; medians of {} rankings in turns.\n\n\
             | workers | cores | simulated | least | most | coordinator busy | workers busy | \
             measured |\n|--:|--:|--:|--:|--:|--:|--:|--:|\n",
            self.scenario, self.alone_ms, self.turns
        );
        for row in &self.rows {
            let VirtualRow { workers, cores, simulated: [least, median, most], .. } = row;
            let (coordinator, busy) = (100.0 * row.coordinator, 100.0 * row.busy);
            let measured = row.measured.map_or("–".to_owned(), |times| format!("{times:.2}"));
            let _ = writeln!(
                text,
                "| {workers} | {cores} | {median:.2} | {least:.2} | {most:.2} | {coordinator:.0} % \
                 | {busy:.0} % | {measured} |"
            );
        }
        let [hand_out, flight, send, take, thread] = self.costs_ns;
        let _ = writeln!(
            text,
            "\nA message takes {hand_out} + {flight} ns to a worker and {send} + {flight} + {take} \
             ns back; a thread starts in {thread} ns."
        );
        if let Some(at_once) = self.at_once {
            let cores = self.cores;
            let _ = writeln!(
                text,
                "{cores} rankings at once, each on a core of its own, take {:.2} times as long as \
                 one: no program gains more than {at_once:.2} from these cores.",
                cores as f64 / at_once
            );
        }
        text
    }
}
