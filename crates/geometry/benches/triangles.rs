//! The triangle test by kind of pair: one at a time, and in patches at every level. Then first
//! contact along a straight line.
//!
//! All pairs of the test have overlapping boxes, like those that a traversal leaves over.

use criterion::{BenchmarkId, Criterion, Throughput};
use fearless_simd::dispatch;
use std::hint::black_box;
use trolley_geometry::patch::{LANES, Patches, meet_all};
use trolley_geometry::sweep::{self, Sweep};
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

/// The kind of a pair and its motion.
#[derive(Clone, Copy)]
enum Way {
    /// They touch on the way.
    Touch,
    /// They pass each other, with overlapping boxes across the motion.
    Pass,
    /// Their boxes across the motion are apart.
    Beside,
    /// The motion ends too early.
    Early,
    /// A corner in common at the end, on a lattice: decided by whole numbers.
    Whole,
    /// The same with a minute coordinate: decided by wide sums.
    Wide,
}

const WAYS: &[(&str, Way)] = &[
    ("touch", Way::Touch),
    ("pass", Way::Pass),
    ("beside", Way::Beside),
    ("early", Way::Early),
    ("whole numbers", Way::Whole),
    ("wide sums", Way::Wide),
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
    let mut group = criterion.benchmark_group("first contact");
    group.throughput(Throughput::Elements(PAIRS as u64));
    for (name, way) in WAYS {
        let (sweep, pairs) = motions(*way);
        group.bench_function(*name, |bencher| {
            let touch =
                |pair: &&[Triangle; 2]| sweep::first_contact(&pair[0], &pair[1], &sweep).is_some();
            bencher.iter(|| black_box(&pairs).iter().filter(touch).count());
        });
    }
    group.finish();
    criterion.final_summary();
}

/// A motion over 4 m, and random pairs for it.
fn motions(way: Way) -> (Sweep, Vec<[Triangle; 2]>) {
    let mut random = Random(way as u64);
    let direction = match way {
        Way::Whole | Way::Wide => DVec3::X,
        _ => DVec3::new(0.36, 0.48, 0.8),
    };
    let to_m = if let Way::Early = way { 0.5 } else { 4.0 };
    let sweep = Sweep::new(direction, 0.0, to_m).expect("a direction and ascending travels");
    let back = match way {
        Way::Beside => sweep.direction() * -2.0 + DVec3::new(0.0, 1.5, -0.9),
        Way::Early => sweep.direction() * -3.0,
        _ => sweep.direction() * -2.0,
    };
    let mut pairs = Vec::new();
    while pairs.len() < PAIRS {
        let (mut a, mut b) = (wide(&random.triangle()), wide(&random.triangle()));
        if let Way::Whole | Way::Wide = way {
            b.0[1] = a.0[2];
        }
        if let Way::Wide = way {
            a.0[0].y = 1e-30;
        }
        b = Triangle(b.0.map(|corner| corner + back));
        let touches = sweep::first_contact(&a, &b, &sweep).is_some();
        if touches != matches!(way, Way::Pass | Way::Beside | Way::Early) {
            pairs.push([a, b]);
        }
    }
    (sweep, pairs)
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
