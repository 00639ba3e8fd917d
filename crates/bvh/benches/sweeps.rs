//! First contact of bodies that move, beside how it used to be sought.
//!
//! `cargo bench --bench sweeps` times some encounters. With the word `table`, it prints a table of
//! all of them instead, or of those whose names contain a further word, or of the family that a
//! third word names; with `lines`, as JSON.

mod encounter;
mod halving;
#[expect(dead_code, reason = "the poses of scenes are not needed")]
mod scene;
mod search;

use criterion::Criterion;
use encounter::{Encounter, FAMILIES, Family};
use geometry::{DVec3, Sweep, Triangle};
use halving::Grid;
use search::{Ready, Search};
use std::hint::black_box;
use std::time::Instant;
use trolley_bvh::Counters;
use trolley_bvh::kernel::sweep::{SweepTask, Witness};
use trolley_bvh::query::{SweepEffort, Workspace, touches};

/// Exact poses along the way that must not touch, and those close to first contact.
const EVEN: i32 = 200;
const CLOSE: i32 = 24;

/// Larger bodies are not tested by brute force.
const BRUTE_FORCE_MAX: usize = 10_000;

/// What is printed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Form {
    Table,
    /// JSON, with checks of our answers.
    Lines,
}

/// How often each search is timed for the table; the median counts. Queries take microseconds: what
/// else the machine does disturbs some.
const RUNS: usize = 25;

fn main() {
    let mut words = std::env::args().skip(1).filter(|word| !word.starts_with('-'));
    let form = match words.next().as_deref() {
        Some("table") => Some(Form::Table),
        Some("lines") => Some(Form::Lines),
        _ => None,
    };
    if let Some(form) = form {
        let [only, family] = [(); 2].map(|()| words.next().unwrap_or_default());
        return print(&only, &family, form);
    }
    let mut criterion = Criterion::default().configure_from_args();
    for family in ["cars-10k", "cars-100k", "tori-200k"] {
        let bodies = Ready::new(Family::named(family));
        let mut group = criterion.benchmark_group(format!("first contact/{family}"));
        for encounter in bodies.family.encounters.iter().filter(|of| is_typical(&of.name)) {
            let mut search = bodies.search(encounter);
            group.bench_function(&encounter.name, |bencher| {
                bencher.iter(|| search.first(black_box(encounter)));
            });
            group.bench_function(format!("{}, halving", encounter.name), |bencher| {
                bencher.iter(|| search.halving(black_box(encounter), Grid::Whole));
            });
        }
        group.finish();
    }
    criterion.final_summary();
}

/// One head-on, one oblique contact, and passes of an oncoming car.
fn is_typical(name: &str) -> bool {
    let endings = ["deep-180", "scratch-225", "oncoming-3deg-1mm", "oncoming-parallel-10cm"];
    endings.iter().any(|ending| name.ends_with(ending)) || name == "tori-200k-045"
}

/// Both searches of one encounter, measured.
struct Measured {
    first_m: Option<f64>,
    effort: SweepEffort,
    halving_m: Option<f64>,
    whole: Counters,
    until_touching: Counters,
    /// Of first contact, of halving, and of halving after a grid that ends at the first touch.
    times_us: [f64; 3],
}

impl Measured {
    fn of(of: &Encounter, search: &mut Search<'_>) -> Self {
        let mut times = [[0.0; RUNS]; 3];
        // All take turns, so that what disturbs one disturbs all.
        for run in 0..=RUNS {
            let took = [
                time_us(|| search.first(black_box(of)).0),
                time_us(|| search.halving(black_box(of), Grid::Whole).0),
                time_us(|| search.halving(black_box(of), Grid::UntilTouching).0),
            ];
            // The first run warms up.
            if let Some(run) = run.checked_sub(1) {
                (0..3).for_each(|k| times[k][run] = took[k]);
            }
        }
        let (first_m, effort) = search.first(of);
        let (halving_m, whole) = search.halving(of, Grid::Whole);
        let (_, until_touching) = search.halving(of, Grid::UntilTouching);
        let times_us = times.map(median);
        Self { first_m, effort, halving_m, whole, until_touching, times_us }
    }

    fn row(&self, name: &str) -> String {
        let [new_us, old_us, lazy_us] = self.times_us;
        let travel = |s: Option<f64>| s.map_or("never".into(), |s| format!("{s:.6}"));
        let (effort, whole) = (&self.effort, &self.whole);
        let tests = effort.counters.tests() as f64;
        let lazy = self.until_touching.tests();
        format!(
            "| {name} | {} | {new_us:.1} | {} | {} | {} | {} | {old_us:.1} | {} | {} \
             | {lazy_us:.1} | {lazy} | {:.3} | {:.2} | {:.3} | {:.2} |",
            travel(self.first_m),
            effort.counters.nb,
            effort.counters.np,
            effort.exact_tests,
            travel(self.halving_m),
            whole.nb,
            whole.np,
            tests / whole.tests() as f64,
            new_us / old_us,
            tests / lazy as f64,
            new_us / lazy_us,
        )
    }

    /// A line of JSON, for `cargo x compare --first-contact`.
    fn line(&self, name: &str, checks: &Checks) -> String {
        let number = |s: Option<f64>| s.map_or("null".into(), |s| format!("{s:?}"));
        let [new_us, old_us, _] = self.times_us;
        let Checks { poses, touching, brute_force } = checks;
        let equals = brute_force.map_or("null".into(), |equals| equals.to_string());
        format!(
            "{{\"peer\":\"trolley\",\"name\":\"{name}\",\"first_contact_m\":{},\
             \"query_ms\":{:?},\"boxes\":{},\"pairs\":{},\"exact_tests\":{},\"poses\":{poses},\
             \"touching\":{touching},\"brute_force\":{equals}}}\n\
             {{\"peer\":\"halving\",\"name\":\"{name}\",\"first_contact_m\":{},\
             \"query_ms\":{:?},\"boxes\":{},\"pairs\":{}}}",
            number(self.first_m),
            new_us / 1e3,
            self.effort.counters.nb,
            self.effort.counters.np,
            self.effort.exact_tests,
            number(self.halving_m),
            old_us / 1e3,
            self.whole.nb,
            self.whole.np,
        )
    }
}

/// What is known about an answer apart from the search.
struct Checks {
    /// Exact poses tried before first contact, or all along the way if there is none.
    poses: usize,
    /// How many of them touch.
    touching: usize,
    /// Whether every triangle against every other gives the same bits, where that was computed.
    brute_force: Option<bool>,
}

impl Checks {
    fn of(of: &Encounter, bodies: &Ready, first_m: Option<f64>) -> Self {
        let [from_m, to_m] = of.travels_m;
        let end_m = first_m.map_or(to_m, |first_m| first_m - 1e-6);
        // Evenly along the way, and ever closer to its end.
        let even = (0..EVEN).map(|k| from_m + (end_m - from_m) * (f64::from(k) / f64::from(EVEN)));
        let close = (0..CLOSE).map(|k| end_m - 1e-6 * 1.5_f64.powi(k));
        let travels: Vec<f64> = even.chain([end_m]).chain(close).collect();
        let mut workspace = Workspace::new();
        let mut touch = |travel: &&f64| {
            let pose = of.pose.moved(of.direction * **travel);
            touches(&bodies.a, &bodies.b, &pose, &mut workspace).expect("a pose that is finite")
        };
        let touching = travels.iter().filter(&mut touch).count();
        let is_small = bodies.a.ids().len() <= BRUTE_FORCE_MAX;
        let brute_force = is_small.then(|| by_brute_force(of, bodies) == first_m);
        Self { poses: travels.len(), touching, brute_force }
    }
}

/// First contact of every triangle with every other, but for those whose projections along the
/// motion are apart by their bounds.
fn by_brute_force(of: &Encounter, bodies: &Ready) -> Option<f64> {
    let [from_m, to_m] = of.travels_m;
    let sweep = Sweep::new(of.direction, from_m, to_m).expect("a motion");
    let [u, v, _] = sweep.axes();
    let bounds = |corners: [DVec3; 3]| {
        let [p, q, r] = corners.map(|corner| [u.dot(corner), v.dot(corner)]);
        let margin = 1e-9;
        [0, 1].map(|k| [p[k].min(q[k]).min(r[k]) - margin, p[k].max(q[k]).max(r[k]) + margin])
    };
    let of_a = bodies.a.corners().iter().map(|corners| bounds(Triangle::stored(corners).0));
    let of_b = bodies.b.corners().iter().map(|corners| bounds(of.pose.triangle(corners).0));
    let (of_a, of_b): (Vec<_>, Vec<_>) = (of_a.collect(), of_b.collect());
    let (a, b) = (bodies.a.view(), bodies.b.view());
    let task = SweepTask { a, b, pose: of.pose, sweep };
    let mut first_m: Option<f64> = None;
    for (i, [x, y]) in of_a.iter().enumerate() {
        for (j, [z, w]) in of_b.iter().enumerate() {
            let apart = x[0] > z[1] || z[0] > x[1] || y[0] > w[1] || w[0] > y[1];
            if !apart && let Some(witness) = Witness::of(&task, [i as u32, j as u32]) {
                let travel_m = witness.travel_m;
                first_m = Some(first_m.map_or(travel_m, |first_m| first_m.min(travel_m)));
            }
        }
    }
    first_m
}

/// Prints a line for each encounter whose name contains `only`, of one family or of all.
#[expect(clippy::print_stdout, reason = "the lines are what it is asked for")]
fn print(only: &str, family: &str, form: Form) {
    if form == Form::Table {
        println!(
            "| encounter | first contact m | µs | boxes | pairs | exact | by halving m | µs \
             | boxes | pairs | until touching µs | tests | tests, ratio | time, ratio \
             | tests, ratio to until touching | time |"
        );
        println!("|---|{}", "--:|".repeat(15));
    }
    for family in FAMILIES.iter().filter(|name| family.is_empty() || **name == family) {
        let mut family = Family::named(family);
        family.encounters.retain(|of| of.name.contains(only));
        if family.encounters.is_empty() {
            continue;
        }
        let bodies = Ready::new(family);
        for of in &bodies.family.encounters {
            let measured = Measured::of(of, &mut bodies.search(of));
            println!(
                "{}",
                match form {
                    Form::Table => measured.row(&of.name),
                    Form::Lines =>
                        measured.line(&of.name, &Checks::of(of, &bodies, measured.first_m)),
                }
            );
        }
    }
}

#[expect(clippy::disallowed_methods, reason = "a measuring aid: nothing is decided by it")]
fn time_us<T>(work: impl FnOnce() -> T) -> f64 {
    let begun = Instant::now();
    black_box(work());
    begun.elapsed().as_secs_f64() * 1e6
}

fn median(mut times: [f64; RUNS]) -> f64 {
    times.sort_by(f64::total_cmp);
    times[RUNS / 2]
}
