//! Queries: the walk over boxes alone, the triangle tests alone, and all three questions.

mod posed;
mod scene;

use body::Build;
use criterion::{BenchmarkId, Criterion, Throughput};
use fearless_simd::dispatch;
use geometry::patch::{self, Patches, meet_all};
use geometry::{DVec3, Directions, simd, triangle};
use posed::Posed;
use std::hint::black_box;
use trolley_bvh::Question;
use trolley_bvh::build::LEAF_SIZE_MAX;

/// Triangles in a leaf, as by default.
const LEAF_SIZE: u32 = 4;

fn main() {
    let mut criterion = Criterion::default().configure_from_args();
    boxes(&mut criterion);
    triangles(&mut criterion);
    queries(&mut criterion);
    criterion.final_summary();
}

/// Down both trees to the leaves: time per pair of leaves that remains.
fn boxes(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("boxes");
    for scene in ["cars-10k-deep", "cars-100k-deep", "cars-100k-miss"] {
        let posed = Posed::new(scene, Build::Sah, LEAF_SIZE);
        group.throughput(Throughput::Elements(posed.leaves().len() as u64));
        group.bench_function(scene, |bencher| bencher.iter(|| black_box(&posed).leaves()));
    }
}

/// The triangle tests of a crash: candidates one by one, and whole leaves in patches.
fn triangles(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("triangles of a crash");
    let single = Posed::new("cars-10k-deep", Build::Sah, 1);
    let candidates = single.candidates();
    group.throughput(Throughput::Elements(candidates.len() as u64));
    group.bench_function("one by one", |bencher| {
        let (a, b, pose) = single.parts();
        let posed = patch::Posed::new(pose, a.corners, b.corners);
        bencher.iter(|| {
            let hit = |pair: &&[u32; 2]| {
                let [a, b] = posed.triangles(**pair);
                triangle::intersect(&a, &b)
            };
            black_box(&candidates).iter().filter(hit).count()
        });
    });
    let leaves = Posed::new("cars-10k-deep", Build::Sah, LEAF_SIZE_MAX);
    let leaf_pairs = leaves.leaf_pairs();
    let (a, b, pose) = leaves.parts();
    let posed = patch::Posed::new(pose, a.corners, b.corners);
    for level in simd::levels() {
        let mut patches = Patches::default();
        group.bench_function(BenchmarkId::new("patches", simd::name(level)), |bencher| {
            bencher.iter(|| {
                let mut hits = 0;
                for pair in black_box(&leaf_pairs) {
                    dispatch!(level, simd => {
                        meet_all(simd, &posed, &mut patches, pair.clone(), &mut |_| hits += 1);
                    });
                }
                hits
            });
        });
    }
}

/// Whole queries: time per hit, or per query where nothing is hit.
fn queries(criterion: &mut Criterion) {
    let directions = Directions::around(DVec3::X, DVec3::Z);
    let scenes = [
        "cars-10k-scratch",
        "cars-10k-deep",
        "cars-100k-miss",
        "cars-100k-scratch",
        "cars-100k-deep",
        "comb",
    ];
    for scene in scenes {
        let mut group = criterion.benchmark_group(scene);
        let mut posed = Posed::new(scene, Build::Sah, LEAF_SIZE);
        let hits = posed.ask(Question::Pairs, None).pairs;
        group.throughput(Throughput::Elements(hits.max(1)));
        let questions = [
            ("pairs", Question::Pairs, None),
            ("pairs and supports", Question::Pairs, Some(&directions)),
            ("sets", Question::Sets, None),
            ("touches", Question::Touches, None),
        ];
        for (name, question, directions) in questions {
            group.bench_function(name, |bencher| {
                bencher.iter(|| posed.ask(question, black_box(directions)));
            });
        }
        let mut posed = Posed::new(scene, Build::Paper, LEAF_SIZE);
        group.bench_function("pairs, paper's split", |bencher| {
            bencher.iter(|| posed.ask(Question::Pairs, black_box(None)));
        });
    }
}
