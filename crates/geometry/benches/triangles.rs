//! The triangle test by kind of pair: one at a time, and in patches at every level.
//!
//! All pairs have overlapping boxes, like those that a traversal leaves over.

use criterion::{BenchmarkId, Criterion, Throughput};
use fearless_simd::dispatch;
use std::hint::black_box;
use trolley_geometry::patch::{LANES, Patches, meet_all};
use trolley_geometry::{
    Aabb, Corners, DVec3, Pose, Posed, RelativePose, Triangle, hash, simd, triangle,
};

/// Pairs of each kind: more than a branch predictor memorises.
const PAIRS: usize = 4096;

/// The kind of a pair.
#[derive(Clone, Copy)]
enum Kind {
    /// One triangle on one side of the other's plane.
    Apart,
    /// Each crosses the other's plane, but they do not meet.
    Miss,
    /// Each crosses the other's plane, and they meet.
    Hit,
    /// A corner in common.
    Corner,
    /// Both in one plane, which is tilted; about half of them meet.
    Coplanar,
}

const KINDS: &[(&str, Kind)] = &[
    ("apart", Kind::Apart),
    ("miss", Kind::Miss),
    ("hit", Kind::Hit),
    ("corner", Kind::Corner),
    ("coplanar", Kind::Coplanar),
];

fn main() {
    let mut criterion = Criterion::default().configure_from_args();
    let pose = RelativePose::between(&Pose::IDENTITY, &Pose::IDENTITY);
    for (name, kind) in KINDS {
        let (a, b) = pairs(*kind);
        let numbers: Vec<[u32; 2]> = (0..PAIRS as u32).map(|i| [i, i]).collect();
        let posed = Posed::new(&pose, &a, &b);
        let mut group = criterion.benchmark_group(format!("triangles/{name}"));
        group.throughput(Throughput::Elements(PAIRS as u64));
        group.bench_function("one by one", |bencher| {
            let wide: Vec<[Triangle; 2]> = numbers.iter().map(|n| posed.triangles(*n)).collect();
            let meet = |pair: &&[Triangle; 2]| triangle::intersect(&pair[0], &pair[1]);
            bencher.iter(|| black_box(&wide).iter().filter(meet).count());
        });
        // Eight of A against eight of B: most pairs are of another kind, as in a traversal.
        for level in simd::levels() {
            group.bench_function(BenchmarkId::new("patches", simd::name(level)), |bencher| {
                let mut patches = Patches::default();
                bencher.iter(|| {
                    let mut hits = 0;
                    for start in (0..PAIRS as u32).step_by(LANES) {
                        let range = start..start + LANES as u32;
                        dispatch!(level, simd => {
                            let ranges = (range.clone(), range.clone());
                            meet_all(simd, &posed, &mut patches, ranges, &mut |_| hits += 1);
                        });
                    }
                    hits
                });
            });
        }
    }
    criterion.final_summary();
}

/// Random pairs of a kind; those of other kinds are discarded.
fn pairs(kind: Kind) -> (Vec<Corners>, Vec<Corners>) {
    let mut random = Random(kind as u64);
    let (mut all_a, mut all_b) = (Vec::new(), Vec::new());
    while all_a.len() < PAIRS {
        let (a, mut b) = match kind {
            Kind::Coplanar => (random.in_plane(), random.in_plane()),
            _ => (random.triangle(), random.triangle()),
        };
        if let Kind::Corner = kind {
            b[1] = a[2];
        }
        if boxes_overlap(&a, &b) && is(kind, &a, &b) {
            all_a.push(a);
            all_b.push(b);
        }
    }
    (all_a, all_b)
}

fn is(kind: Kind, a: &Corners, b: &Corners) -> bool {
    let (a, b) = (wide(a), wide(b));
    let across = crosses(&a, &b) && crosses(&b, &a);
    match kind {
        Kind::Apart => !across,
        Kind::Miss => across && !triangle::intersect(&a, &b),
        Kind::Hit => across && triangle::intersect(&a, &b),
        Kind::Corner | Kind::Coplanar => true,
    }
}

/// Whether corners of `t` lie on both sides of the plane of `plane`; random ones never lie in it.
fn crosses(plane: &Triangle, t: &Triangle) -> bool {
    let [p, q, r] = plane.0;
    let normal = (q - p).cross(r - p);
    let above = t.0.map(|corner| normal.dot(corner - p) > 0.0);
    above != [above[0]; 3]
}

fn boxes_overlap(a: &Corners, b: &Corners) -> bool {
    Aabb::of(a).bounds().overlaps(&Aabb::of(b).bounds())
}

fn wide(corners: &Corners) -> Triangle {
    Triangle(corners.map(|corner| DVec3::from_array(corner.map(f64::from))))
}

/// SplitMix64.
struct Random(u64);

impl Random {
    /// A multiple of 1/256 in [0, 1): sums of a few are exact.
    fn step(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(1 << 32);
        (hash::splitmix64(self.0) >> 56) as f32 / 256.0
    }

    fn triangle(&mut self) -> Corners {
        [0; 3].map(|_| [0; 3].map(|_| self.step() + self.step() / 256.0))
    }

    /// In the plane z = x + y / 2.
    fn in_plane(&mut self) -> Corners {
        [0; 3].map(|_| {
            let (x, y) = (self.step(), self.step());
            [x, y, x + y / 2.0]
        })
    }
}
