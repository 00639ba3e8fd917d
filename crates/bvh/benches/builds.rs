//! Tree builds: time per triangle, on one thread and on two.

use body::Build;
use body::Shape;
use criterion::{BenchmarkId, Criterion, SamplingMode, Throughput};
use shapes::generate;
use std::hint::black_box;
use trolley_bvh::{BuildOptions, build};

fn main() {
    let mut criterion = Criterion::default().configure_from_args().sample_size(20);
    for count in [10_000, 100_000] {
        let sedan = generate(Shape::Sedan, count, 0).expect("a count that can be generated");
        let triangles = sedan.corners;
        let mut group = criterion.benchmark_group(format!("build/{count}"));
        group.sampling_mode(SamplingMode::Flat);
        group.throughput(Throughput::Elements(u64::from(count)));
        for (name, split) in [("paper", Build::Paper), ("sah", Build::Sah)] {
            for threads in [1, 2] {
                let options = BuildOptions { build: split, leaf_size: 4, threads };
                group.bench_function(BenchmarkId::new(name, threads), |bencher| {
                    bencher.iter(|| build(black_box(&triangles), &options, &|_| ()));
                });
            }
        }
    }
    criterion.final_summary();
}
