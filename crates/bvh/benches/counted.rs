//! Workloads whose instructions `cargo x count` counts: without arguments, prints their names, one
//! per line; with a name, runs that one, once to warm up and once inside [`measured`].

#[expect(dead_code, reason = "one family is enough")]
mod encounter;
#[expect(dead_code, reason = "one way to halve is enough")]
mod halving;
mod motion;
mod posed;
mod scene;
mod search;

use body::Build;
use encounter::{Encounter, Family};
use fearless_simd::dispatch;
use geometry::patch::{self, Patches, meet_all};
use geometry::simd::Level;
use geometry::{DVec3, Directions, triangle};
use halving::Grid;
use motion::Cars;
use posed::Posed;
use scene::Scene;
use search::{Ready, Search};
use std::hint::black_box;
use trolley_bvh::build::LEAF_SIZE_MAX;
use trolley_bvh::query::{self, MotionLimits, MotionWorkspace};
use trolley_bvh::{BuildOptions, Question, Tree, build};

/// Large enough to amortise start-up, small enough for an emulated processor.
const SCENE: &str = "cars-10k-deep";

/// Prepares a workload.
type Prepare = fn() -> Box<dyn FnMut() -> u64>;

const WORKLOADS: &[(&str, Prepare)] = &[
    ("pairs", || ask(Build::Sah, Question::Pairs)),
    ("pairs, paper's split", || ask(Build::Paper, Question::Pairs)),
    ("pairs and supports", || {
        let directions = Directions::around(DVec3::X, DVec3::Z);
        let mut posed = Posed::new(SCENE, Build::Sah, 4);
        Box::new(move || posed.ask(Question::Pairs, Some(&directions)).hash)
    }),
    ("sets", || ask(Build::Sah, Question::Sets)),
    ("touches", || ask(Build::Sah, Question::Touches)),
    ("boxes", || {
        let posed = Posed::new(SCENE, Build::Sah, 4);
        Box::new(move || posed.leaves().len() as u64)
    }),
    ("triangles in patches", || {
        let posed = Posed::new(SCENE, Build::Sah, LEAF_SIZE_MAX);
        let leaf_pairs = posed.leaf_pairs();
        let level = Level::new();
        let mut patches = Patches::default();
        Box::new(move || {
            let (a, b, pose) = posed.parts();
            let posed = patch::Posed::new(pose, a.corners, b.corners);
            let mut hits = 0;
            for pair in &leaf_pairs {
                dispatch!(level, simd => {
                    meet_all(simd, &posed, &mut patches, pair.clone(), &mut |_| hits += 1);
                });
            }
            hits
        })
    }),
    ("triangles one by one", || {
        let posed = Posed::new(SCENE, Build::Sah, 1);
        let candidates = posed.candidates();
        Box::new(move || {
            let (a, b, pose) = posed.parts();
            let posed = patch::Posed::new(pose, a.corners, b.corners);
            let hit = |pair: &&[u32; 2]| {
                let [a, b] = posed.triangles(**pair);
                triangle::intersect(&a, &b)
            };
            candidates.iter().filter(hit).count() as u64
        })
    }),
    ("first contact", || first_contact("deep-180")),
    ("first contact by halving", || halve("deep-180")),
    ("pass at 1 mm", || first_contact("pass-oncoming-3deg-1mm")),
    ("first contact in motion", || first_contact_in_motion("contact")),
    ("slide in motion", || first_contact_in_motion("slide")),
    ("build, paper's split", || grow(Build::Paper)),
    ("build, sah", || grow(Build::Sah)),
];

fn ask(build: Build, question: Question) -> Box<dyn FnMut() -> u64> {
    let mut posed = Posed::new(SCENE, build, 4);
    Box::new(move || posed.ask(question, None).counters.tests())
}

fn first_contact(ending: &str) -> Box<dyn FnMut() -> u64> {
    let (encounter, mut search) = encounter(ending);
    Box::new(move || search.first(encounter).1.counters.tests())
}

/// Of all motions of a kind of two cars of 10,000 triangles.
fn first_contact_in_motion(kind: &'static str) -> Box<dyn FnMut() -> u64> {
    let cars = Cars::named(SCENE);
    let options = BuildOptions { leaf_size: 4, threads: 1, ..BuildOptions::default() };
    let tree = |body: &_| Tree::build(body, &options).expect("a car has triangles");
    let (a, b) = (tree(&cars.a), tree(&cars.b));
    let (limits, mut workspace) = (MotionLimits::default(), MotionWorkspace::new());
    Box::new(move || {
        let motions = cars.motions.iter().filter(|of| of.kind == kind);
        let tests = motions.map(|of| {
            let motion = of.relative();
            query::first_contact_in_motion(&a, &b, &motion, &limits, &mut workspace)
                .expect("limits");
            workspace.effort().counters.tests()
        });
        tests.sum()
    })
}

fn halve(ending: &str) -> Box<dyn FnMut() -> u64> {
    let (encounter, mut search) = encounter(ending);
    Box::new(move || search.halving(encounter, Grid::Whole).1.tests())
}

/// An encounter of two cars of 10,000 triangles, and searches for it.
fn encounter(ending: &str) -> (&'static Encounter, Search<'static>) {
    // Workloads own what they need: this one's bodies last until the program ends.
    let bodies: &'static Ready = Box::leak(Box::new(Ready::new(Family::named("cars-10k"))));
    let mut encounters = bodies.family.encounters.iter();
    let encounter = encounters.find(|of| of.name.ends_with(ending)).expect("one of the family");
    (encounter, bodies.search(encounter))
}

fn grow(split: Build) -> Box<dyn FnMut() -> u64> {
    let triangles = Scene::named(SCENE).a;
    let options = BuildOptions { build: split, leaf_size: 4, threads: 1 };
    Box::new(move || build(&triangles, &options, &|_| ()).map_or(0, |tree| tree.depth.into()))
}

/// Instructions between entry and return are counted; callgrind finds it by this name.
#[inline(never)]
fn measured(work: &mut dyn FnMut() -> u64) -> u64 {
    black_box(work())
}

#[expect(clippy::print_stdout, reason = "the names are what it is asked for")]
fn main() {
    // `cargo bench` adds options for harnesses; a workload is not an option.
    let Some(name) = std::env::args().skip(1).find(|word| !word.starts_with('-')) else {
        WORKLOADS.iter().for_each(|(name, _)| println!("{name}"));
        return;
    };
    let (_, prepare) =
        WORKLOADS.iter().find(|workload| workload.0 == name).expect("one of the names it lists");
    let mut work = prepare();
    black_box(work());
    black_box(measured(&mut work));
}
