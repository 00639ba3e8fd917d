//! How late answers are: a histogram over many requests, among them such of adversarial cost.

use super::requests::{self, Pool};
use super::{percentile, wrong};
use crate::BUILD;
use crate::args::Output;
use crate::progress::Progress;
use body::{BodyView, Meta};
use coordinator::{Chance, Crew, Options, Request, Terms, Work, run_in_process};
use damage::State;
use diagnostic::Failure;
use dispatch::Queues;
use runtime::{affinity, clock};
use std::fmt::Write as _;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// What is asked.
#[derive(Debug, clap::Args)]
pub(crate) struct DeadlineArgs {
    /// Bodies, as files or shape:triangles; the first is the ego. A second body like the first is
    /// put right into it [default: seven generated ones].
    #[arg(long, value_name = "BODY")]
    body: Vec<String>,
    /// Requests.
    #[arg(long, value_name = "N", default_value_t = 10_000)]
    requests: u32,
    /// Each is due so many milliseconds after it was accepted.
    #[arg(long, value_name = "MS", default_value_t = 20.0)]
    deadline_ms: f64,
    /// Which requests.
    #[arg(long, value_name = "S", default_value_t = 1)]
    seed: u64,
    /// Worker processes.
    #[arg(long, value_name = "N", default_value_t = 4)]
    workers: u8,
    /// Threads that do nothing but take time from everybody.
    #[arg(long, value_name = "N", default_value_t = 0)]
    load: usize,
    /// Most tests of a job.
    #[arg(long, value_name = "TESTS", default_value_t = Terms::BUDGET)]
    budget: u64,
}

/// Upper ends of the histogram's classes (ms).
const CLASSES_MS: [f64; 10] = [0.0, 0.1, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 250.0];
/// Requests of one round: made once, asked again and again.
const ROUND: usize = 32;

/// Runs the requests. Says what was found, and whether all answers were as they must be.
pub(crate) fn run(args: &DeadlineArgs, output: &Output) -> Result<String, Failure> {
    let pool = Pool::load(&args.body)?;
    let views = pool.views()?;
    let mut chance = Chance::new(args.seed);
    let mut asked = Vec::new();
    while asked.len() < ROUND.min(args.requests as usize) {
        let candidates = 6 + chance.below(11) as usize;
        let policy = requests::policy(asked.len())?;
        asked.extend(requests::request(&views, (candidates, 1.1), &mut chance, policy)?);
    }
    if pool.names[0] == pool.names[1] {
        // Identical bodies, one in the other to the last triangle.
        let policy = requests::policy(0)?;
        asked[0] = requests::parse(&requests::interpenetrating(&views), &views, policy)?;
    }
    let winners: Result<Vec<Option<String>>, Failure> =
        asked.iter().map(|request| winner(request, &views)).collect();
    let winners = winners?;
    let cores = affinity::in_turn(&affinity::allowed_cores(), args.workers.into());
    let options = Options {
        queues: Queues { capacity: 8, ..Options::QUEUES },
        ..Options::new(format!("d{}", std::process::id()), BUILD, cores)
    };
    let due = Duration::from_secs_f64(args.deadline_ms / 1e3);
    let terms = Terms { budget: args.budget, ..Terms::due_in(due) };
    let over = AtomicBool::new(false);
    std::thread::scope(|scope| {
        for _ in 0..args.load {
            scope.spawn(|| {
                while !over.load(Ordering::Relaxed) {
                    std::hint::spin_loop();
                }
            });
        }
        let ran = ask(
            args,
            (&asked, &winners),
            &views,
            terms,
            || Ok(Crew::start(&pool.store, &options)?),
            output,
        );
        over.store(true, Ordering::Relaxed);
        Ok(page(args, &pool, &ran?))
    })
}

/// The winner of the finished run; `None` where that would take too long to know.
fn winner(request: &Request, views: &[(Meta, BodyView<'_>)]) -> Result<Option<String>, Failure> {
    let most_ns = 20_000_000_000;
    let terms = Terms { deadline_ns: Some(most_ns), budget: Terms::BUDGET, ..Terms::default() };
    let mut work = Work::new(request, views, 5).with_terms(terms);
    run_in_process(&mut work, views);
    let answer = work.answer()?;
    let first = answer.ranking.first().map(|row| row.name.clone());
    Ok(first.filter(|_| answer.state == State::Complete))
}

/// What became of the requests.
#[derive(Default)]
struct Asked {
    /// How late each answer was (ms); below 0: in time.
    late: Vec<f64>,
    /// CPU time from the end of the work to the answer (ms): what is late though nobody waited.
    own: Vec<f64>,
    /// How often each state was given.
    states: [u64; 4],
}

fn ask(
    args: &DeadlineArgs,
    (asked, winners): (&[Request], &[Option<String>]),
    views: &[(Meta, BodyView<'_>)],
    terms: Terms,
    start: impl Fn() -> Result<Crew, Failure>,
    output: &Output,
) -> Result<Asked, Failure> {
    let bar = Progress::new("requests", args.requests.into(), output);
    let mut crew = start()?;
    let mut all = Asked::default();
    for number in 0..args.requests as usize {
        let at = number % asked.len();
        let mut work = Work::new(&asked[at], views, 5).with_terms(terms);
        crew.run(&mut work)?;
        let begun_ns = clock::thread_cpu_ns();
        let answer = work.answer()?;
        let took_ms = (clock::now_ns() - work.accepted_ns()) as f64 / 1e6;
        all.own.push((clock::thread_cpu_ns() - begun_ns) as f64 / 1e6);
        all.late.push(took_ms - args.deadline_ms);
        all.states[answer.state as usize] += 1;
        let is_sure = matches!(answer.state, State::Complete | State::Certified);
        let first = answer.ranking.first().map(|row| &row.name);
        if let (true, Some(winner), Some(first)) = (is_sure, &winners[at], first)
            && winner != first
        {
            return Err(wrong(format!("request {number}: {first} was sure, {winner} wins")));
        }
        bar.add(1);
    }
    Ok(all)
}

fn page(args: &DeadlineArgs, pool: &Pool, all: &Asked) -> String {
    let Asked { late, own, states } = all;
    let (mut sorted, mut own) = (late.clone(), own.clone());
    let mut text = format!(
        "{} requests of 6 to 16 candidates between {} bodies ({}), each due after {} ms (put \
         together {} ms before), {} workers on {} cores, {} threads of load: {} complete, {} \
         certified, {} degraded, {} refused.\n\n| later than due by (ms) | answers |\n|--:|--:|\n",
        late.len(),
        pool.names.len(),
        super::names(&pool.names),
        args.deadline_ms,
        Terms::GUARD.as_secs_f64() * 1e3,
        args.workers,
        affinity::allowed_cores().len(),
        args.load,
        states[0],
        states[1],
        states[2],
        states[3],
    );
    let mut least = f64::NEG_INFINITY;
    for most in CLASSES_MS.into_iter().chain([f64::INFINITY]) {
        let count = late.iter().filter(|late| **late > least && **late <= most).count();
        let class = match (least, most) {
            (f64::NEG_INFINITY, _) => "in time".to_owned(),
            (_, f64::INFINITY) => format!("more than {least}"),
            _ => format!("up to {most}"),
        };
        let _written = writeln!(text, "| {class} | {count} |");
        least = most;
    }
    let _written = writeln!(
        text,
        "\nAgainst the deadline: median {:.2} ms, 99 % by {:.2} ms, 99.9 % by {:.2} ms, the last \
         at {:.2} ms. Of that the coordinator's own work on the answer, in CPU time: median \
         {:.2} ms, 99 % {:.2} ms, the most {:.2} ms; the rest is waiting for a core.",
        percentile(&mut sorted, 0.5),
        percentile(&mut sorted, 0.99),
        percentile(&mut sorted, 0.999),
        percentile(&mut sorted, 1.0),
        percentile(&mut own, 0.5),
        percentile(&mut own, 0.99),
        percentile(&mut own, 1.0),
    );
    text
}
