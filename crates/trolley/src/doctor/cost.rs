//! What a test costs at most: measured on this machine, on jobs that are made to be dear.
//!
//! A *measured bound, not a WCET*: nothing proves that no job is dearer. Times are CPU time of the
//! thread that works, so that other programs count only by what they do to caches and memory; how
//! long the same jobs took on the clock stands beside it.

use super::adversary::{Family, families};
use crate::Failure;
use body::BodyView;
use bvh::kernel::{BEAT_TESTS, STEP_SPENT, STEP_TESTS};
use bvh::query::{MotionLimits, MotionWorkspace, first_contact_in_motion_watched};
use bvh::{Kernel, NodePair, Question, Side, Sink, Task, front};
use coordinator::RequestLimits;
use geometry::motion::{MotionPath, Orientation, RelativeMotion, State};
use geometry::rng::Rng;
use geometry::{DVec3, Directions};
use runtime::clock;
use serde::Serialize;
use std::ops::ControlFlow;

/// Jobs that spend less say what a job costs besides its tests.
const SMALL: u64 = 4096;
/// Budgets of jobs, most of them small: as many jobs as possible begin.
const BUDGETS: [u64; 8] = [64, 64, 256, 256, 1024, 1024, 4096, 1 << 13];
/// One in so many jobs has the whole budget of a job with a deadline.
const WHOLE: u64 = 512;
/// Before one in so many jobs, all caches are emptied.
const COLD: u64 = 4096;
/// What is read to empty them (bytes).
const CACHES: usize = 64 << 20;
/// One in so many jobs is a look at bodies in motion.
const LOOKS: u64 = 128;
/// A look is stopped after so many beats: it would not end by itself for long.
const BEATS: u32 = 16;
/// Between two looks at the bodies, jobs of one pair.
const OF_A_POSE: u64 = 16;

/// What jobs of one kind cost at most.
///
/// ```
/// # let file = "../../config/deployments/minimal.toml";
/// # let opened = trolley::OpenDeployment::open(file.as_ref(), None)?;
/// let bounds = trolley::doctor::DeploymentBounds::find(&opened, 500, true)?;
/// let spent: u64 = bounds.costs.kinds.iter().map(|kind| kind.spent).sum();
/// assert!(spent > 0);
/// # Ok::<(), trolley::Failure>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct KindCost {
    /// What makes them dear.
    pub kind: &'static str,
    /// Jobs, and looks at bodies in motion.
    pub jobs: u64,
    /// What they spent of their budgets: tests, and what else pairs cost.
    pub spent: u64,
    /// Most CPU time for each test that was spent, in jobs of 4,096 and more (ns).
    pub test_ns: f64,
    /// Most CPU time of a job (ns), and on the clock.
    pub job_ns: u64,
    /// As `job_ns`, on the clock.
    pub job_wall_ns: u64,
    /// Most CPU time between two beats of a job (ns).
    pub gap_ns: u64,
    /// Most CPU time between two beats of a look at bodies in motion (ns).
    pub look_gap_ns: u64,
}

/// What a campaign of dear jobs measured.
///
/// ```
/// # let file = "../../config/deployments/minimal.toml";
/// # let opened = trolley::OpenDeployment::open(file.as_ref(), None)?;
/// let costs = trolley::doctor::DeploymentBounds::find(&opened, 0, true)?.costs;
/// assert!(costs.jobs == 0 && costs.kinds.is_empty(), "nothing was measured");
/// # Ok::<(), trolley::Failure>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TestCosts {
    /// Jobs in all.
    pub jobs: u64,
    /// Threads that worked at the same time, sharing caches and memory.
    pub threads: usize,
    /// Most CPU time for each test that is spent of a budget (ns).
    pub test_ns: f64,
    /// Most CPU time of a job that spends little (ns): what a job costs besides its tests.
    pub start_ns: u64,
    /// Most CPU time of as many jobs one after the other as a batch has (ns).
    pub batch_ns: u64,
    /// By kind.
    pub kinds: Vec<KindCost>,
}

/// What one thread measured.
#[derive(Clone, Debug, Default)]
struct Measured {
    kinds: Vec<KindCost>,
    start_ns: u64,
    batch_ns: u64,
}

impl TestCosts {
    /// Runs `jobs` jobs of all kinds on `threads` threads. `bodies` are those of a deployment, and
    /// `batch` the jobs of a batch.
    pub(super) fn measure(
        bodies: &[BodyView<'_>],
        (jobs, batch, threads): (u64, usize, usize),
    ) -> Result<Self, Failure> {
        let families = match jobs {
            0 => Vec::new(),
            _ => families(bodies).map_err(|error| Failure::internal(error.to_string()))?,
        };
        let threads = threads.max(1);
        let share = jobs.div_ceil(threads as u64);
        let number_of_threads = if families.is_empty() { 0 } else { threads };
        let all: Vec<Measured> = std::thread::scope(|scope| {
            let worker = |number: usize| {
                let families = &families;
                scope.spawn(move || Campaign::new(families, number as u64).run(share, batch))
            };
            let workers: Vec<_> = (0..number_of_threads).map(worker).collect();
            let ends = workers.into_iter().map(|worker| worker.join());
            ends.map(|end| end.map_err(|_panic| Failure::internal("a campaign panicked")))
                .collect::<Result<_, _>>()
        })?;
        let mut kinds = Vec::new();
        for (number, family) in families.iter().enumerate() {
            let mut sum = KindCost { kind: family.name, ..KindCost::default() };
            for kind in all.iter().map(|measured| &measured.kinds[number]) {
                sum.jobs += kind.jobs;
                sum.spent += kind.spent;
                sum.test_ns = sum.test_ns.max(kind.test_ns);
                sum.job_ns = sum.job_ns.max(kind.job_ns);
                sum.job_wall_ns = sum.job_wall_ns.max(kind.job_wall_ns);
                sum.gap_ns = sum.gap_ns.max(kind.gap_ns);
                sum.look_gap_ns = sum.look_gap_ns.max(kind.look_gap_ns);
            }
            kinds.push(sum);
        }
        Ok(Self {
            jobs: kinds.iter().map(|kind| kind.jobs).sum(),
            threads,
            test_ns: kinds.iter().map(|kind| kind.test_ns).fold(0.0, f64::max),
            start_ns: all.iter().map(|measured| measured.start_ns).max().unwrap_or(0),
            batch_ns: all.iter().map(|measured| measured.batch_ns).max().unwrap_or(0),
            kinds,
        })
    }

    /// The bound of a job with this budget (ns): what it costs to begin, and its tests. The last
    /// step may exceed the budget.
    pub(super) fn job_bound_ns(&self, budget: u64) -> u64 {
        self.start_ns + (self.test_ns * (budget + STEP_SPENT) as f64) as u64
    }

    /// The bound of the time between two looks at the clock within a job (ns): how long work goes
    /// on that nobody waits for any more.
    pub(super) fn gap_bound_ns(&self) -> u64 {
        self.start_ns + (self.test_ns * (BEAT_TESTS + STEP_TESTS + STEP_SPENT) as f64) as u64
    }

    /// The most that a job took (CPU, ns).
    pub(super) fn job_ns(&self) -> u64 {
        self.kinds.iter().map(|kind| kind.job_ns).max().unwrap_or(0)
    }

    /// The longest time between two beats of a job, and of a look (CPU, ns).
    pub(super) fn gaps_ns(&self) -> [u64; 2] {
        let longest = |gap: fn(&KindCost) -> u64| self.kinds.iter().map(gap).max().unwrap_or(0);
        [longest(|kind| kind.gap_ns), longest(|kind| kind.look_gap_ns)]
    }
}

/// Measures the time between beats.
#[derive(Debug)]
struct Beats {
    last_ns: u64,
    gap_ns: u64,
    hits: u64,
}

impl Beats {
    fn new(now_ns: u64) -> Self {
        Self { last_ns: now_ns, gap_ns: 0, hits: 0 }
    }

    fn note(&mut self) {
        let now_ns = clock::thread_cpu_ns();
        self.gap_ns = self.gap_ns.max(now_ns - self.last_ns);
        self.last_ns = now_ns;
    }
}

impl Sink for Beats {
    fn hit(&mut self, _: Side, triangle: u32) -> ControlFlow<()> {
        self.hits = self.hits.wrapping_add(u64::from(triangle));
        ControlFlow::Continue(())
    }

    fn beat(&mut self, _: u64) -> ControlFlow<()> {
        self.note();
        ControlFlow::Continue(())
    }
}

/// The jobs of one thread.
struct Campaign<'f, 'b> {
    families: &'f [Family<'b>],
    rng: Rng,
    kernel: Kernel,
    motions: MotionWorkspace,
    starts: Vec<NodePair>,
    directions: Directions,
    measured: Measured,
    caches: Vec<u64>,
}

impl<'f, 'b> Campaign<'f, 'b> {
    fn new(families: &'f [Family<'b>], number: u64) -> Self {
        let views = || families.iter().flat_map(|family| family.pairs.iter().flatten());
        let triangles = views().map(|body| body.view().corners.len()).max().unwrap_or(0);
        let empty = |family: &Family<'_>| KindCost { kind: family.name, ..KindCost::default() };
        let kinds = families.iter().map(empty).collect();
        Self {
            families,
            rng: Rng::new(number),
            // As deep as a stack can be.
            kernel: Kernel::with_room(4096, 4096, triangles, triangles),
            motions: MotionWorkspace::new(),
            starts: Vec::new(),
            directions: Directions::around(DVec3::X, DVec3::Z),
            measured: Measured { kinds, ..Measured::default() },
            caches: vec![1; CACHES / 8],
        }
    }

    fn run(mut self, jobs: u64, batch: usize) -> Measured {
        let mut last = std::collections::VecDeque::from(vec![0_u64; batch.max(1)]);
        let mut sum_ns = 0;
        let mut done = 0;
        while done < jobs {
            let kind = self.rng.below(self.families.len() as u64) as usize;
            let family = &self.families[kind];
            let pair = &family.pairs[self.rng.below(family.pairs.len() as u64) as usize];
            let (a, b) = (pair[0].view(), pair[1].view());
            let pose = family.pose(&mut self.rng);
            let depth = self.rng.below(9) as u32;
            self.starts.clear();
            front(&a, &b, &pose, depth, &mut self.starts, &mut bvh::Counters::default());
            for _ in 0..OF_A_POSE.min(jobs - done) {
                done += 1;
                if self.rng.below(COLD) == 0 {
                    self.empty_caches();
                }
                if self.rng.below(LOOKS) == 0 || self.starts.is_empty() {
                    self.look(kind, [a, b]);
                    continue;
                }
                let start = self.starts[self.rng.below(self.starts.len() as u64) as usize];
                let (question, directions) = (Question::Sets, None);
                let ns = self.job(kind, &Task { a, b, pose, question, directions }, start);
                sum_ns = sum_ns + ns - last.pop_front().unwrap_or(0);
                last.push_back(ns);
                self.measured.batch_ns = self.measured.batch_ns.max(sum_ns);
            }
        }
        self.measured
    }

    /// Runs a job; returns the CPU time that it took (ns).
    fn job(&mut self, kind: usize, task: &Task<'_>, start: NodePair) -> u64 {
        let budget = match self.rng.below(WHOLE) {
            0 => RequestLimits::BUDGET,
            _ => BUDGETS[self.rng.below(BUDGETS.len() as u64) as usize],
        };
        let (question, directions) = match self.rng.below(4) {
            0 => (Question::Touches, None),
            1 => (Question::Pairs, Some(&self.directions)),
            _ => (Question::Sets, None),
        };
        let task = Task { question, directions, ..*task };
        let wall_ns = clock::now_ns();
        let begun_ns = clock::thread_cpu_ns();
        let mut beats = Beats::new(begun_ns);
        let outcome = self.kernel.run(&task, start, budget, &mut beats);
        let ended_ns = clock::thread_cpu_ns();
        let wall_ns = clock::now_ns() - wall_ns;
        let (cpu_ns, spent) = (ended_ns - begun_ns, outcome.spent());
        beats.gap_ns = beats.gap_ns.max(ended_ns - beats.last_ns);
        let cost = &mut self.measured.kinds[kind];
        cost.jobs += 1;
        cost.spent += spent;
        cost.job_ns = cost.job_ns.max(cpu_ns);
        cost.job_wall_ns = cost.job_wall_ns.max(wall_ns);
        cost.gap_ns = cost.gap_ns.max(beats.gap_ns);
        if spent < SMALL {
            self.measured.start_ns = self.measured.start_ns.max(cpu_ns);
        } else {
            cost.test_ns = cost.test_ns.max(cpu_ns as f64 / spent as f64);
        }
        cpu_ns
    }

    /// Looks at bodies that move and turn.
    fn look(&mut self, kind: usize, [a, b]: [BodyView<'_>; 2]) {
        let mut state = |time_s: f64| State {
            time_s,
            position_m: [0; 3].map(|_| self.rng.between(-1.5, 1.5)),
            orientation: Orientation::from_degrees(self.rng.between(-90.0, 90.0), 0.0, 0.0),
        };
        let paths = [[state(0.0), state(2.0)], [state(0.0), state(2.0)]];
        let paths = paths.map(|states| MotionPath::new(&states));
        let [Ok(of_a), Ok(of_b)] = &paths else { return };
        let Ok(motion) = RelativeMotion::new(of_a, of_b) else { return };
        let wall_ns = clock::now_ns();
        let begun_ns = clock::thread_cpu_ns();
        let mut beats = Beats::new(begun_ns);
        let mut left = BEATS;
        let mut watch = |_| {
            beats.note();
            left = left.saturating_sub(1);
            if left == 0 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        let limits = MotionLimits::default();
        let _seen = first_contact_in_motion_watched(
            a,
            b,
            &motion,
            (&limits, &mut watch),
            &mut self.motions,
        );
        let ended_ns = clock::thread_cpu_ns();
        let wall_ns = clock::now_ns() - wall_ns;
        let cost = &mut self.measured.kinds[kind];
        cost.jobs += 1;
        cost.spent += self.motions.effort().counters.tests();
        cost.job_wall_ns = cost.job_wall_ns.max(wall_ns);
        cost.look_gap_ns = cost.look_gap_ns.max(beats.gap_ns.max(ended_ns - beats.last_ns));
    }

    /// Reads more than any cache holds.
    fn empty_caches(&mut self) {
        // A line has eight of them.
        let sum = self.caches.iter().step_by(8).fold(0_u64, |sum, word| sum.wrapping_add(*word));
        self.caches[0] = std::hint::black_box(sum) | 1;
    }
}

#[cfg(test)]
mod tests {
    //! What is measured lies within what is computed from it.
    use super::*;

    // verifies REQ-BUDGET
    #[test]
    fn no_job_exceeds_the_bound_that_is_made_of_all() {
        let costs = TestCosts::measure(&[], (4_000, 4, 2)).unwrap();
        assert!(costs.jobs >= 4_000 && costs.threads == 2 && costs.test_ns > 0.0);
        assert!(costs.kinds.iter().all(|kind| kind.jobs > 0 && kind.spent > 0), "{costs:?}");
        for budget in BUDGETS {
            assert!(costs.job_bound_ns(budget) >= costs.start_ns);
        }
        let jobs = costs.kinds.iter().map(|kind| kind.job_ns).max().unwrap();
        assert!(jobs <= costs.job_bound_ns(RequestLimits::BUDGET), "{costs:?}");
        assert!(costs.batch_ns >= jobs, "a batch has that job");
    }
}
