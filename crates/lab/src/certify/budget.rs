//! Whether jobs keep their budget: the tests of each, and its CPU time against their mean cost.

use super::figures::{Class, classes, names, percentile};
use super::requests::Pool;
use crate::progress::{Progress, SyncProgress};
use bvh::{End, Kernel, NodePair, Question, Task, kernel};
use core::ops::ControlFlow;
use geometry::{DVec3, Directions, Pose, RelativePose};
use runtime::clock;
use serde::Serialize;
use std::fmt::Write as _;
use trolley::Failure;

/// What to test.
#[derive(Clone, Debug)]
pub struct BudgetOptions {
    /// Bodies, as model files or shape:triangles; the first is the ego. Empty: seven generated
    /// ones.
    pub bodies: Vec<String>,
    /// Maximum number of tests per job.
    pub budget: u64,
    /// Number of jobs.
    pub jobs: u64,
}

/// What jobs took.
#[derive(Clone, Debug, Serialize)]
pub struct BudgetReport {
    schema: &'static str,
    bodies: Vec<String>,
    budget: u64,
    jobs: usize,
    /// Jobs that their budget ended.
    cut: usize,
    /// The most tests of a job.
    most_tests: u64,
    /// Mean CPU time of a test.
    cost_ns: f64,
    /// Jobs by their CPU time, in units of budget times cost; so are the shares.
    classes: Vec<Class>,
    /// Jobs within three of these.
    within: usize,
    p999_share: f64,
    most_share: f64,
}

/// Accepts every hit and continues.
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

/// Runs jobs over all pairs of bodies, deep inside each other and barely touching, and all jobs
/// that they leave. `told` is called with the jobs done.
///
/// # Errors
///
/// If a body cannot be used, or a job takes more tests than its budget.
pub fn budget(options: &BudgetOptions, told: SyncProgress<'_>) -> Result<BudgetReport, Failure> {
    let pool = Pool::load(&options.bodies)?;
    let views = pool.bodies.views()?;
    let depth = views.iter().map(|(meta, _)| meta.depth).max().unwrap_or(1);
    let triangles = views.iter().map(|(_, body)| body.corners.len()).max().unwrap_or(0);
    let mut kernel = Kernel::with_room(depth, depth, triangles, triangles);
    let directions = Directions::around(DVec3::X, DVec3::Z);
    let bar = Progress::new(options.jobs, told);
    let mut jobs: Vec<Job> = Vec::new();
    let mut round = 0;
    while (jobs.len() as u64) < options.jobs {
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
                if jobs.len() as u64 >= options.jobs {
                    break;
                }
                let begun_ns = clock::thread_cpu_ns();
                let budget = kernel::within(options.budget);
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
    if let Some(job) = jobs.iter().find(|job| job.tests > options.budget) {
        return Err(Failure::internal(format!(
            "a job took {} tests of {}",
            job.tests, options.budget
        )));
    }
    Ok(report(options, pool.names, &jobs))
}

fn report(options: &BudgetOptions, bodies: Vec<String>, jobs: &[Job]) -> BudgetReport {
    let sum = |of: fn(&Job) -> u64| jobs.iter().map(of).sum::<u64>() as f64;
    let cost_ns = sum(|job| job.cpu_ns) / sum(|job| job.tests).max(1.0);
    let most_ns = cost_ns * options.budget as f64;
    let mut shares: Vec<f64> = jobs.iter().map(|job| job.cpu_ns as f64 / most_ns).collect();
    BudgetReport {
        schema: "trolley.certify-budget/1",
        bodies,
        budget: options.budget,
        jobs: jobs.len(),
        cut: jobs.iter().filter(|job| job.is_cut).count(),
        most_tests: jobs.iter().map(|job| job.tests).max().unwrap_or(0),
        cost_ns,
        classes: classes(&shares, &CLASSES),
        within: shares.iter().filter(|share| **share <= 3.0).count(),
        p999_share: percentile(&mut shares, 0.999),
        most_share: percentile(&mut shares, 1.0),
    }
}

impl BudgetReport {
    /// The report as text.
    #[must_use]
    pub fn text(&self) -> String {
        let mut text = format!(
            "{} jobs between {} bodies ({}) with a budget of {} tests; {} ended by it. The most \
             tests of a job: {}. Mean cost {:.2} ns per test, so budget × cost is {:.2} ms.\n\n | \
             CPU time of a job, in units of that | jobs |\n|--:|--:|\n",
            self.jobs,
            self.bodies.len(),
            names(&self.bodies),
            self.budget,
            self.cut,
            self.most_tests,
            self.cost_ns,
            self.cost_ns * self.budget as f64 / 1e6,
        );
        let mut least = 0.0;
        for Class { up_to, count } in &self.classes {
            let class = match up_to {
                Some(most) => format!("up to {most}"),
                None => format!("more than {least}"),
            };
            // A String takes whatever it is given.
            let _written = writeln!(text, "| {class} | {count} |");
            least = up_to.unwrap_or(least);
        }
        let _written = writeln!(
            text,
            "\n{:.3} % within 3; 99.9 % by {:.2}, the longest {:.2}.",
            100.0 * self.within as f64 / self.jobs.max(1) as f64,
            self.p999_share,
            self.most_share,
        );
        text
    }
}
