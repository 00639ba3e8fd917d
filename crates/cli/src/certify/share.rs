//! After which share of the work the winner was certain, by strategy and depth.

use super::requests::{self, Pool};
use super::{median, percentile};
use crate::args::Output;
use crate::progress::Progress;
use body::{BodyView, Meta};
use coordinator::{Chance, Pursuit, Request, Terms, Until, Work, run_in_process};
use damage::evidence::Touch;
use diagnostic::Failure;
use runtime::clock;
use std::fmt::Write as _;

/// What is asked.
#[derive(Debug, clap::Args)]
pub(crate) struct ShareArgs {
    /// Bodies, as files or shape:triangles; the first is the ego [default: seven generated ones].
    #[arg(long, value_name = "BODY")]
    body: Vec<String>,
    /// Requests, of 6 to 16 candidates each.
    #[arg(long, value_name = "N", default_value_t = 24)]
    requests: u32,
    /// Which requests.
    #[arg(long, value_name = "S", default_value_t = 1)]
    seed: u64,
    /// Only requests whose every candidate touches: no way past is left.
    #[arg(long)]
    unavoidable: bool,
    /// Distribution depths.
    #[arg(long, value_name = "LIST", value_delimiter = ',', default_value = "3,5,8")]
    depth: Vec<u32>,
}

/// One request, worked on by one strategy.
#[derive(Clone, Copy, Debug)]
struct Ran {
    /// Work at certification, in units of running everything as it comes.
    share: f64,
    /// Time, in the same way.
    time: f64,
}

/// Who won.
struct Winner {
    name: String,
    /// How many candidates touch.
    touches: usize,
}

/// Runs everything, or until the winner is certain.
fn run(
    request: &Request,
    views: &[(Meta, BodyView<'_>)],
    depth: u32,
    terms: Terms,
) -> Result<(f64, f64, Winner), Failure> {
    let mut work = Work::new(request, views, depth).with_terms(terms);
    let begun_ns = clock::now_ns();
    run_in_process(&mut work, views);
    let took_ns = (clock::now_ns() - begun_ns) as f64;
    let effort = work.effort();
    let tests = (effort.descent.tests() + effort.jobs.tests()) as f64;
    let answer = work.answer()?;
    let name = answer.ranking.first().map(|row| row.name.clone()).unwrap_or_default();
    let touching = answer.ranking.iter().filter(|row| row.contact.touch == Touch::Yes);
    let winner = Winner { name, touches: touching.count() };
    let state = answer.state;
    if !matches!(state, damage::State::Complete | damage::State::Certified) {
        return Err(super::wrong(format!("a run ended {}", state.name())));
    }
    Ok((tests, took_ns, winner))
}

/// The table, as text.
pub(crate) fn table(args: &ShareArgs, output: &Output) -> Result<String, Failure> {
    let pool = Pool::load(&args.body)?;
    let views = pool.views()?;
    let bar = Progress::new("requests", u64::from(args.requests) * args.depth.len() as u64, output);
    let mut text = String::from(
        "| depth | strategy | median share | p90 | worst | certified before the end | median time \
         |\n|--:|---|--:|--:|--:|--:|--:|\n",
    );
    let mut sizes = Vec::new();
    for &depth in &args.depth {
        let mut ran: Vec<Vec<Ran>> = vec![Vec::new(); Pursuit::ALL.len()];
        let mut chance = Chance::new(args.seed);
        let mut made = 0;
        while made < args.requests {
            let candidates = 6 + chance.below(11) as usize;
            let policy = requests::policy(made as usize)?;
            let miss = if args.unavoidable { 0.6 } else { 1.1 };
            let way = (candidates, miss);
            let Some(request) = requests::request(&views, way, &mut chance, policy)? else {
                continue;
            };
            let (all, whole_ns, winner) = run(&request, &views, depth, Terms::default())?;
            let is_avoidable = winner.touches < candidates;
            if args.unavoidable && is_avoidable {
                continue;
            }
            made += 1;
            if depth == args.depth[0] {
                sizes.push((candidates as f64, all, whole_ns / 1e6));
            }
            for (number, pursuit) in Pursuit::ALL.into_iter().enumerate() {
                let terms = Terms { until: Until::Certified, pursuit, ..Terms::default() };
                let (tests, took_ns, first) = run(&request, &views, depth, terms)?;
                if first.name != winner.name {
                    let (first, winner) = (first.name, winner.name);
                    let what = format!("{} certified {first}, not {winner}", pursuit.name());
                    return Err(super::wrong(what));
                }
                let of = |part: f64, whole: f64| if whole > 0.0 { part / whole } else { 0.0 };
                ran[number].push(Ran { share: of(tests, all), time: of(took_ns, whole_ns) });
            }
            bar.add(1);
        }
        for (pursuit, ran) in Pursuit::ALL.into_iter().zip(&ran) {
            let mut shares: Vec<f64> = ran.iter().map(|ran| ran.share).collect();
            let mut times: Vec<f64> = ran.iter().map(|ran| ran.time).collect();
            let early = shares.iter().filter(|share| **share < 0.99).count();
            let _written = writeln!(
                text,
                "| {depth} | {} | {:.1} % | {:.1} % | {:.1} % | {early} of {} | {:.1} % |",
                pursuit.name(),
                100.0 * median(&mut shares),
                100.0 * percentile(&mut shares, 0.9),
                100.0 * percentile(&mut shares, 1.0),
                ran.len(),
                100.0 * median(&mut times),
            );
        }
    }
    let mut tests: Vec<f64> = sizes.iter().map(|(_, tests, _)| *tests).collect();
    let mut ms: Vec<f64> = sizes.iter().map(|(_, _, ms)| *ms).collect();
    let _written = writeln!(
        text,
        "\n{} requests of 6 to 16 candidates{} between {} bodies ({}), policies in turn. Running \
         everything takes {:.2} million tests and {:.1} ms in the median.",
        sizes.len(),
        if args.unavoidable { ", all of which touch," } else { "" },
        pool.names.len(),
        super::names(&pool.names),
        median(&mut tests) / 1e6,
        median(&mut ms),
    );
    Ok(text)
}
