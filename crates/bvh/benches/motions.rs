//! First contact of cars that drive and turn for three seconds.
//!
//! `cargo bench --bench motions` times some motions. With the word `table`, it prints a table of
//! all of them by kind instead, and fails if one touches before it is said to.

mod motion;
#[expect(dead_code, reason = "the poses of scenes are not needed")]
mod scene;

use criterion::Criterion;
use motion::{Cars, KINDS, Motion};
use std::hint::black_box;
use std::time::Instant;
use trolley_bvh::query::{
    MotionContact, MotionEffort, MotionLimits, MotionWorkspace, Workspace, first_contact_in_motion,
    touches,
};
use trolley_bvh::{BuildOptions, Tree};

const BODIES: [&str; 2] = ["cars-10k-deep", "cars-100k-deep"];

/// How often each query is timed for the table; the median counts.
const RUNS: usize = 9;

/// Exact poses before contact, or in all of the time, that must not touch.
const POSES: u32 = 1500;

fn main() {
    if std::env::args().any(|word| word == "table") {
        return table();
    }
    let mut criterion = Criterion::default().configure_from_args();
    for name in BODIES {
        let cars = Cars::named(name);
        let mut search = Search::new(&cars);
        let mut group = criterion.benchmark_group(format!("first contact in motion/{name}"));
        for kind in KINDS {
            let motion = cars.motions.iter().find(|of| of.kind == *kind).expect("one of each kind");
            group.bench_function(*kind, |bencher| bencher.iter(|| search.first(black_box(motion))));
        }
        group.finish();
    }
    criterion.final_summary();
}

/// Trees of two cars, and scratch.
struct Search {
    trees: [Tree; 2],
    workspace: MotionWorkspace,
}

impl Search {
    fn new(cars: &Cars) -> Self {
        let options = BuildOptions::default();
        let tree = |corners: &_| Tree::build(corners, &options).expect("a car has triangles");
        Self { trees: [tree(&cars.a), tree(&cars.b)], workspace: MotionWorkspace::new() }
    }

    fn first(&mut self, motion: &Motion) -> (MotionContact, MotionEffort) {
        let [a, b] = &self.trees;
        let (limits, relative) = (MotionLimits::default(), motion.relative());
        let first = first_contact_in_motion(a, b, &relative, &limits, &mut self.workspace);
        (first.expect("a resolution of 1 mm"), self.workspace.effort())
    }

    /// How many exact poses touch of those before the contact, and how many were tried.
    fn touching_before(&self, motion: &Motion, first: &MotionContact) -> (usize, usize) {
        let relative = motion.relative();
        let end_s = match *first {
            MotionContact::Excluded => relative.to_s(),
            MotionContact::Certain { excluded_before_s: time_s, .. }
            | MotionContact::Possible { time_s, .. }
            | MotionContact::OutOfBudget { excluded_before_s: time_s } => time_s,
        };
        let mut workspace = Workspace::new();
        let [a, b] = &self.trees;
        let from_s = relative.from_s();
        let step_s = (end_s - from_s) / f64::from(POSES);
        let times = (0..POSES).map(|step| from_s + step_s * f64::from(step));
        // At its very begin they may touch already.
        let times: Vec<f64> = times.filter(|time_s| *time_s < end_s).collect();
        let touch = times.iter().filter(|time_s| {
            let pose = relative.pose_at(**time_s);
            touches(a, b, &pose, &mut workspace).expect("a pose that is finite")
        });
        (touch.count(), times.len())
    }
}

/// Prints a row for each kind and size.
#[expect(clippy::print_stdout, reason = "the rows are what it is asked for")]
fn table() {
    println!(
        "| cars | motions | contact | possible | median ms | worst ms | median tests | most tests \
         | median intervals | poses before | that touch |\n|---|{}",
        "--:|".repeat(10)
    );
    for name in BODIES {
        let cars = Cars::named(name);
        let mut search = Search::new(&cars);
        for kind in KINDS {
            let (mut certain, mut possible) = (0, 0);
            let (mut times, mut tests, mut intervals) = (Vec::new(), Vec::new(), Vec::new());
            let (mut touching, mut tried) = (0, 0);
            let of_kind: Vec<&Motion> = cars.motions.iter().filter(|of| of.kind == *kind).collect();
            for motion in &of_kind {
                let (first, effort) = search.first(motion);
                match first {
                    MotionContact::Certain { .. } => certain += 1,
                    MotionContact::Possible { .. } => possible += 1,
                    MotionContact::Excluded | MotionContact::OutOfBudget { .. } => {}
                }
                times.push(middle((0..RUNS).map(|_| time_ms(|| search.first(motion))).collect()));
                tests.push(effort.counters.tests() as f64);
                intervals.push(effort.intervals as f64);
                let (touch, poses) = search.touching_before(motion, &first);
                (touching, tried) = (touching + touch, tried + poses);
            }
            let most = |of: &[f64]| of.iter().copied().fold(0.0, f64::max);
            println!(
                "| {}, {kind} | {} | {certain} | {possible} | {:.3} | {:.3} | {:.0} | {:.0} \
                 | {:.0} | {tried} | {touching} |",
                name.trim_end_matches("-deep"),
                of_kind.len(),
                middle(times.clone()),
                most(&times),
                middle(tests.clone()),
                most(&tests),
                middle(intervals),
            );
            assert_eq!(touching, 0, "{name}, {kind}: a touch before first contact");
        }
    }
}

#[expect(clippy::disallowed_methods, reason = "a measuring aid: nothing is decided by it")]
fn time_ms<T>(work: impl FnOnce() -> T) -> f64 {
    let begun = Instant::now();
    black_box(work());
    begun.elapsed().as_secs_f64() * 1e3
}

fn middle(mut of: Vec<f64>) -> f64 {
    of.sort_by(f64::total_cmp);
    of[of.len() / 2]
}
