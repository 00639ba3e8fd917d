//! After what share of the work the winner is certain, by strategy and depth.

use super::figures::{median, names, percentile};
use super::requests::{self, Pool};
use crate::progress::{Progress, SyncProgress};
use body::{BodyView, Meta};
use coordinator::{RankingRun, Request, RequestLimits, SearchOrder, Until, run_in_process};
use damage::evidence::Touch;
use geometry::rng::Rng;
use runtime::clock;
use serde::Serialize;
use std::fmt::Write as _;
use std::path::PathBuf;
use trolley::{Failure, files};

/// What to test.
#[derive(Clone, Debug)]
pub struct ShareOptions {
    /// Bodies, as model files or shape:triangles; the first is the ego. Empty: seven generated
    /// ones.
    pub bodies: Vec<String>,
    /// Number of requests, of 6 to 16 candidates each.
    pub requests: u32,
    /// Seed of the random requests.
    pub seed: u64,
    /// Only requests in which every candidate makes contact.
    pub unavoidable: bool,
    /// Distribution depths.
    pub depths: Vec<u32>,
    /// File to write the table to as well.
    pub out: Option<PathBuf>,
}

/// After what share of the work winners were certain.
#[derive(Clone, Debug, Serialize)]
pub struct ShareReport {
    schema: &'static str,
    bodies: Vec<String>,
    requests: usize,
    unavoidable: bool,
    /// Median tests and time of a complete run.
    whole_tests: f64,
    whole_ms: f64,
    rows: Vec<Row>,
}

/// One strategy at one depth; shares are relative to a complete run in request order.
#[derive(Clone, Debug, Serialize)]
struct Row {
    depth: u32,
    strategy: &'static str,
    median_share: f64,
    p90_share: f64,
    worst_share: f64,
    /// Requests whose winner was certain before the end.
    early: usize,
    requests: usize,
    median_time: f64,
}

/// Random requests to try for each that can be ranked and is wanted.
const TRIES: u64 = 1_000;

/// One request, executed with one strategy.
#[derive(Clone, Copy, Debug)]
struct Ran {
    /// Work at certification, relative to a complete run in request order.
    share: f64,
    /// Time at certification, likewise.
    time: f64,
}

/// The winner.
struct Winner {
    name: String,
    /// Number of candidates that make contact.
    touches: usize,
    /// What an answer that is neither complete nor certified lacks.
    missing: Option<String>,
}

/// Runs everything, or until the winner is certain.
fn run(
    request: &Request,
    views: &[(Meta, BodyView<'_>)],
    depth: u32,
    limits: RequestLimits,
) -> Result<(f64, f64, Winner), Failure> {
    let mut work = RankingRun::new(request, views, depth).with_limits(limits);
    let begun_ns = clock::now_ns();
    run_in_process(&mut work, views);
    let took_ns = (clock::now_ns() - begun_ns) as f64;
    let effort = work.effort();
    let tests = (effort.descent.tests() + effort.jobs.tests()) as f64;
    let answer = work.answer()?;
    let name = answer.ranking.first().map(|row| row.name.clone()).unwrap_or_default();
    let touching = answer.ranking.iter().filter(|row| row.contact.touch == Touch::Yes);
    let is_sure =
        matches!(answer.state, damage::AnswerState::Complete | damage::AnswerState::Certified);
    let missing = (!is_sure).then(|| answer.missing.join("; "));
    Ok((tests, took_ns, Winner { name, touches: touching.count(), missing }))
}

/// Executes requests with every strategy at every depth. `told` is called with the requests done.
///
/// # Errors
///
/// If a body cannot be used, the file cannot be written, or a certain winner differs from the final
/// one.
pub fn share(options: &ShareOptions, told: SyncProgress<'_>) -> Result<ShareReport, Failure> {
    // Fail before the work, not after it, if the file cannot be written.
    options.out.as_deref().map(|path| files::check(path, None)).transpose()?;
    let pool = Pool::load(&options.bodies)?;
    let views = pool.bodies.views()?;
    let bar = Progress::new(u64::from(options.requests) * options.depths.len() as u64, told);
    let mut rows = Vec::new();
    let mut sizes = Vec::new();
    for &depth in &options.depths {
        let mut ran: Vec<Vec<Ran>> = vec![Vec::new(); SearchOrder::ALL.len()];
        let mut rng = Rng::new(options.seed);
        let (mut made, mut tried) = (0, 0);
        while made < options.requests {
            tried += 1;
            if tried > TRIES * u64::from(options.requests) {
                let what = "hardly any random request between these bodies can be ranked";
                return Err(Failure::input(what).with_remedy("name other bodies: --body"));
            }
            let candidates = 6 + rng.below(11) as usize;
            let policy = requests::policy(made as usize)?;
            let miss = if options.unavoidable { 0.6 } else { 1.1 };
            let way = (candidates, miss);
            let Some(request) = requests::request(&views, way, &mut rng, policy)? else {
                continue;
            };
            let (all, whole_ns, winner) = run(&request, &views, depth, RequestLimits::default())?;
            let is_avoidable = winner.touches < candidates;
            // Bodies that overlap at the start have no complete answer, so none can be early.
            if (options.unavoidable && is_avoidable) || winner.missing.is_some() {
                continue;
            }
            made += 1;
            if depth == options.depths[0] {
                sizes.push((all, whole_ns / 1e6));
            }
            for (number, search_order) in SearchOrder::ALL.into_iter().enumerate() {
                let limits = RequestLimits {
                    until: Until::Certified,
                    search_order,
                    ..RequestLimits::default()
                };
                let (tests, took_ns, first) = run(&request, &views, depth, limits)?;
                if let Some(missing) = first.missing {
                    return Err(Failure::internal(format!("a run ended degraded: {missing}")));
                }
                if first.name != winner.name {
                    let (first, winner) = (first.name, winner.name);
                    let what = format!("{} certified {first}, not {winner}", search_order.name());
                    return Err(Failure::internal(what));
                }
                let ratio = |part: f64, whole: f64| if whole > 0.0 { part / whole } else { 0.0 };
                ran[number].push(Ran { share: ratio(tests, all), time: ratio(took_ns, whole_ns) });
            }
            bar.add(1);
        }
        for (search_order, ran) in SearchOrder::ALL.into_iter().zip(&ran) {
            let mut shares: Vec<f64> = ran.iter().map(|ran| ran.share).collect();
            let mut times: Vec<f64> = ran.iter().map(|ran| ran.time).collect();
            rows.push(Row {
                depth,
                strategy: search_order.name(),
                median_share: median(&mut shares),
                p90_share: percentile(&mut shares, 0.9),
                worst_share: percentile(&mut shares, 1.0),
                early: shares.iter().filter(|share| **share < 0.99).count(),
                requests: ran.len(),
                median_time: median(&mut times),
            });
        }
    }
    let mut tests: Vec<f64> = sizes.iter().map(|(tests, _)| *tests).collect();
    let mut ms: Vec<f64> = sizes.iter().map(|(_, ms)| *ms).collect();
    let report = ShareReport {
        schema: "trolley.certify-share/1",
        bodies: pool.names,
        requests: sizes.len(),
        unavoidable: options.unavoidable,
        whole_tests: median(&mut tests),
        whole_ms: median(&mut ms),
        rows,
    };
    if let Some(path) = &options.out {
        files::replace(path, report.text().as_bytes())?;
    }
    Ok(report)
}

impl ShareReport {
    /// The report as text.
    #[must_use]
    pub fn text(&self) -> String {
        let mut text = String::from(
            "| depth | strategy | median share | p90 | worst | certified before the end | median \
             time |\n|--:|---|--:|--:|--:|--:|--:|\n",
        );
        for row in &self.rows {
            // A String takes whatever it is given.
            let _written = writeln!(
                text,
                "| {} | {} | {:.1} % | {:.1} % | {:.1} % | {} of {} | {:.1} % |",
                row.depth,
                row.strategy,
                100.0 * row.median_share,
                100.0 * row.p90_share,
                100.0 * row.worst_share,
                row.early,
                row.requests,
                100.0 * row.median_time,
            );
        }
        let _written = writeln!(
            text,
            "\n{} requests of 6 to 16 candidates{} between {} bodies ({}), policies in turn. \
             Running everything takes {:.2} million tests and {:.1} ms in the median.",
            self.requests,
            if self.unavoidable { ", all of which touch," } else { "" },
            self.bodies.len(),
            names(&self.bodies),
            self.whole_tests / 1e6,
            self.whole_ms,
        );
        text
    }
}
