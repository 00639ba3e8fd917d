//! Whether jobs keep their budget: tests of each, and CPU time against what these tests cost.

use super::requests::Pool;
use super::{percentile, wrong};
use crate::args::Output;
use crate::progress::Progress;
use bvh::{End, Kernel, NodePair, Question, Task, kernel};
use core::ops::ControlFlow;
use diagnostic::Failure;
use geometry::{DVec3, Directions, Pose, RelativePose};
use runtime::clock;
use std::fmt::Write as _;

/// What is asked.
#[derive(Debug, clap::Args)]
pub(crate) struct BudgetArgs {
    /// Bodies, as files or shape:triangles; the first is the ego [default: seven generated ones].
    #[arg(long, value_name = "BODY")]
    body: Vec<String>,
    /// Most tests of a job.
    #[arg(long, value_name = "TESTS", default_value_t = coordinator::Terms::BUDGET)]
    budget: u64,
    /// Jobs.
    #[arg(long, value_name = "N", default_value_t = 20_000)]
    jobs: u64,
}

/// Takes hits and wants more.
struct Taken(u64);

impl bvh::Sink for Taken {
    fn hit(&mut self, _: bvh::Side, _: u32) -> ControlFlow<()> {
        self.0 += 1;
        ControlFlow::Continue(())
    }

    fn beat(&mut self, _: u64) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}

/// One job: its tests, its CPU time (ns), and whether its budget ended it.
struct Job {
    tests: u64,
    cpu_ns: u64,
    is_cut: bool,
}

/// Ends of classes, in units of budget times mean cost.
const CLASSES: [f64; 8] = [0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0, 10.0];

/// Runs jobs over all pairs of bodies, deep in each other and only just, and all that they leave.
pub(crate) fn run(args: &BudgetArgs, output: &Output) -> Result<String, Failure> {
    let pool = Pool::load(&args.body)?;
    let views = pool.views()?;
    let depth = views.iter().map(|(meta, _)| meta.depth).max().unwrap_or(1);
    let triangles = views.iter().map(|(_, body)| body.corners.len()).max().unwrap_or(0);
    let mut kernel = Kernel::with_room(depth, depth, triangles, triangles);
    let directions = Directions::around(DVec3::X, DVec3::Z);
    let bar = Progress::new("jobs", args.jobs, output);
    let mut jobs: Vec<Job> = Vec::new();
    let mut round = 0;
    while (jobs.len() as u64) < args.jobs {
        for (_, other) in &views {
            let (_, ego) = &views[0];
            // From right inside, where everything meets, to a touch.
            let x = 0.37 * f64::from(round % 12);
            let placed = Pose::from_degrees(11.0 * f64::from(round), 0.0, 0.0, [x, 0.0, 0.0]);
            let pose = RelativePose::between(&Pose::IDENTITY, &placed);
            let question = [Question::Pairs, Question::Sets][round as usize % 2];
            let directions = (question == Question::Pairs).then_some(&directions);
            let task = Task { a: *ego, b: *other, pose, question, directions };
            let mut open = vec![NodePair::ROOTS];
            while let Some(start) = open.pop() {
                if jobs.len() as u64 >= args.jobs {
                    break;
                }
                let begun_ns = clock::thread_cpu_ns();
                let budget = kernel::within(args.budget);
                let outcome = kernel.run(&task, start, budget, &mut Taken(0));
                let cpu_ns = clock::thread_cpu_ns() - begun_ns;
                open.extend(kernel.remaining());
                let is_cut = outcome.end == End::OutOfBudget;
                jobs.push(Job { tests: outcome.counters.tests(), cpu_ns, is_cut });
                bar.add(1);
            }
        }
        round += 1;
    }
    if let Some(job) = jobs.iter().find(|job| job.tests > args.budget) {
        return Err(wrong(format!("a job took {} tests of {}", job.tests, args.budget)));
    }
    Ok(page(args, &pool, &jobs))
}

fn page(args: &BudgetArgs, pool: &Pool, jobs: &[Job]) -> String {
    let sum = |of: fn(&Job) -> u64| jobs.iter().map(of).sum::<u64>() as f64;
    let cost_ns = sum(|job| job.cpu_ns) / sum(|job| job.tests).max(1.0);
    let most_ns = cost_ns * args.budget as f64;
    let mut shares: Vec<f64> = jobs.iter().map(|job| job.cpu_ns as f64 / most_ns).collect();
    let cut = jobs.iter().filter(|job| job.is_cut).count();
    let most = jobs.iter().map(|job| job.tests).max().unwrap_or(0);
    let within = shares.iter().filter(|share| **share <= 3.0).count();
    let mut text = format!(
        "{} jobs between {} bodies ({}) with a budget of {} tests; {cut} ended by it. The most \
         tests of a job: {most}. Mean cost {cost_ns:.2} ns per test, so budget × cost is {:.2} \
         ms.\n\n | CPU time of a job, in units of that | jobs |\n|--:|--:|\n",
        jobs.len(),
        pool.names.len(),
        super::names(&pool.names),
        args.budget,
        most_ns / 1e6,
    );
    let mut least = f64::NEG_INFINITY;
    for most in CLASSES.into_iter().chain([f64::INFINITY]) {
        let count = shares.iter().filter(|share| **share > least && **share <= most).count();
        let class =
            if most.is_finite() { format!("up to {most}") } else { format!("more than {least}") };
        let _written = writeln!(text, "| {class} | {count} |");
        least = most;
    }
    let _written = writeln!(
        text,
        "\n{:.3} % within 3; 99.9 % by {:.2}, the longest {:.2}.",
        100.0 * within as f64 / jobs.len().max(1) as f64,
        percentile(&mut shares, 0.999),
        percentile(&mut shares, 1.0),
    );
    text
}
