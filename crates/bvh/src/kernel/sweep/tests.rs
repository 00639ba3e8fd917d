//! Laws of first contact: it is that of brute force, to the bit, whatever the trees, the walk, the
//! vectors and the cuts; and nothing touches before.

use super::*;
use crate::fixtures::{any_build, body_of, options, pose, soup, torus, triangles};
use crate::{Kernel, Question, Task, Tree};
use body::Body;
use geometry::{Corners, simd};
use proptest::prelude::*;

/// Every triangle against every other: the earliest pairs.
fn brute_force(task: &SweepTask<'_>, count: usize) -> Vec<Witness> {
    let mut all = Vec::new();
    for a in 0..task.a.corners.len() as u32 {
        all.extend((0..task.b.corners.len() as u32).filter_map(|b| Witness::of(task, [a, b])));
    }
    all.sort_by(Witness::order);
    all.truncate(count);
    all
}

/// What does not depend on the order of triangles in a tree.
fn named(witnesses: &[Witness]) -> Vec<(u64, [u32; 2])> {
    witnesses.iter().map(|witness| (witness.travel_m.to_bits(), witness.ids)).collect()
}

fn kernels(count: usize) -> Vec<SweepKernel> {
    let kernel = |walk, level| {
        let mut kernel = SweepKernel::with_room(32, 32, count);
        kernel.set_walk(walk);
        kernel.set_level(level);
        kernel
    };
    let wide = simd::levels().map(|level| kernel(Walk::Wide, level));
    wide.chain([kernel(Walk::Plain, Level::new())]).collect()
}

/// Runs jobs within limits until nothing is left open that matters.
fn run_all(
    kernel: &mut SweepKernel,
    task: &SweepTask<'_>,
    limits: SweepLimits,
    count: usize,
) -> Vec<Witness> {
    let mut open = vec![(NodePair::ROOTS, f32::NEG_INFINITY)];
    let mut found: Vec<Witness> = Vec::new();
    while let Some((start, from_m)) = open.pop() {
        let limit_m = found.get(count - 1).map_or(task.sweep.to_m(), |last| last.travel_m);
        if f64::from(from_m) > limit_m {
            continue;
        }
        let task = SweepTask { sweep: task.sweep.until(limit_m), ..*task };
        let outcome = kernel.run(&task, start, limits, &mut Silent);
        assert_eq!(outcome.end == End::Complete, kernel.remaining().next().is_none());
        open.extend(kernel.remaining().map(|open| (open.pair, open.from_m)));
        // Bounds of what is open hold for all that is found there.
        found.extend_from_slice(kernel.nearest());
        found.sort_by(Witness::order);
        found.truncate(count);
    }
    found
}

fn direction() -> impl Strategy<Value = DVec3> {
    let aligned =
        prop::array::uniform3(-1_i8..=1).prop_map(|d| DVec3::from_array(d.map(f64::from)));
    let any = prop::array::uniform3(-1.0..1.0_f64).prop_map(DVec3::from_array);
    prop_oneof![aligned, any].prop_filter("it has a length", |d| d.length() > 0.1)
}

fn motion() -> impl Strategy<Value = Sweep> {
    (direction(), -4.0..2.0_f64, 0.0..6.0_f64)
        .prop_map(|(d, from, length)| Sweep::new(d, from, from + length).unwrap())
}

fn check(
    a: &[Corners],
    b: &[Corners],
    pose: RelativePose,
    sweep: Sweep,
    sizes: [u32; 2],
    build: body::Build,
) {
    let count = 3;
    let [a, b]: [Body; 2] =
        [(a, sizes[0]), (b, sizes[1])].map(|(c, size)| body_of(c, &options(build, size)));
    let task = SweepTask { a: a.view(), b: b.view(), pose, sweep };
    let expected = named(&brute_force(&task, count));
    for mut kernel in kernels(count) {
        let found = run_all(&mut kernel, &task, SweepLimits::default(), count);
        assert_eq!(named(&found), expected, "{:?} {:?}", kernel.walk, kernel.level);
        let limits = SweepLimits { budget: 40 };
        let found = run_all(&mut kernel, &task, limits, count);
        assert_eq!(named(&found), expected, "{:?} {:?}, cut", kernel.walk, kernel.level);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, ..ProptestConfig::default() })]

    /// The same pairs at the same travels, to the bit.
    #[test]
    fn finds_what_brute_force_finds(
        a in triangles(60),
        b in triangles(60),
        pose in pose(),
        sweep in motion(),
        sizes in [1_u32..=64, 1_u32..=64],
        build in any_build(),
    ) {
        check(&a, &b, pose, sweep, sizes, build);
    }

    /// Where many wide nodes and full leaves are involved.
    #[test]
    fn finds_what_brute_force_finds_in_larger_bodies(
        sizes in [200_usize..900, 200_usize..900],
        seeds in [any::<u32>(), any::<u32>()],
        pose in pose(),
        sweep in motion(),
        leaf in 1_u32..9,
        build in any_build(),
    ) {
        let soup = |k: usize| soup(sizes[k], 0.2, u64::from(seeds[k]));
        check(&soup(0), &soup(1), pose, sweep, [leaf; 2], build);
    }
}

/// Nothing touches at a pose before first contact; a little after it, something does.
#[test]
fn nothing_touches_before() {
    let tori = [torus(40, 20, 0.3), torus(30, 24, 0.25)];
    let [a, b] = tori.map(|corners| Tree::build(&corners, &options(body::Build::Sah, 4)).unwrap());
    let mut kernel = SweepKernel::with_room(32, 32, 1);
    let mut still = Kernel::with_room(32, 32, a.ids().len(), b.ids().len());
    let mut touching = 0;
    for k in 0..40 {
        let degrees = f64::from(k) * 9.0;
        let at =
            geometry::Pose::from_degrees(degrees, 30.0, 50.0, [3.0, 0.1 * f64::from(k % 20), 0.2]);
        let pose = RelativePose::between(&geometry::Pose::IDENTITY, &at);
        let sweep = Sweep::new(DVec3::new(-1.0, 0.02 * f64::from(k % 7), 0.01), -1.0, 8.0).unwrap();
        let task = SweepTask { a: a.view(), b: b.view(), pose, sweep };
        kernel.run(&task, NodePair::ROOTS, SweepLimits::default(), &mut Silent);
        let first = kernel.nearest().first().copied();
        let mut touches = |s: f64| {
            let pose = pose.moved(sweep.direction() * s);
            let task = Task {
                a: a.view(),
                b: b.view(),
                pose,
                question: Question::Touches,
                directions: None,
            };
            struct Ignore;
            impl crate::Sink for Ignore {
                fn hit(&mut self, _: crate::Side, _: u32) -> ControlFlow<()> {
                    ControlFlow::Continue(())
                }
                fn beat(&mut self, _: u64) -> ControlFlow<()> {
                    ControlFlow::Continue(())
                }
            }
            still.run(&task, NodePair::ROOTS, u64::MAX, &mut Ignore).pairs > 0
        };
        let end = first.map_or(sweep.to_m(), |witness| witness.travel_m - 1e-6);
        for step in 0..200 {
            let s = sweep.from_m() + (end - sweep.from_m()) * f64::from(step) / 199.0;
            assert!(!touches(s), "{k}: at {s} before {first:?}");
        }
        touching += u32::from(first.is_some_and(|witness| touches(witness.travel_m + 1e-6)));
    }
    assert!(touching > 20, "{touching}");
}
