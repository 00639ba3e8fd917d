//! Invariants of jobs: whatever the tree, the depth and the cuts, the answer equals brute force.

use super::*;
use crate::fixtures::{
    Found, Gathered, Listener, Way, any_build, any_way, body_of, brute_force, directions,
    kernel_for, options, pose, run_all, soup, task, torus, triangles,
};
use crate::{BuildOptions, front};
use body::Shape;
use body::{Body, Build};
use geometry::Pose;
use proptest::prelude::*;
use std::collections::BTreeSet;

const ALL: u64 = u64::MAX;

/// The union of all jobs of a front, each cut by `budget`.
fn answer(
    way: Way,
    a: &Body,
    b: &Body,
    pose: RelativePose,
    question: Question,
    depth: u32,
    budget: u64,
) -> Gathered {
    let directions = directions();
    let task = task(a, b, pose, question, &directions);
    let mut starts = Vec::new();
    front(&task.a, &task.b, &pose, depth, &mut starts, &mut Counters::default());
    run_all(&mut way.kernel(a, b), &task, &starts, budget, Listener::new)
}

fn turned(yaw: f64, at: [f64; 3]) -> RelativePose {
    RelativePose::between(&Pose::IDENTITY, &Pose::from_degrees(yaw, 12.0, 5.0, at))
}

fn built_options() -> impl Strategy<Value = BuildOptions> {
    (any_build(), 1_u32..9).prop_map(|(build, leaf_size)| options(build, leaf_size))
}

fn any_budget() -> impl Strategy<Value = u64> {
    prop_oneof![Just(ALL), 1_u64..300]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 160, ..ProptestConfig::default() })]

    #[test]
    fn pairs_are_those_of_brute_force(
        a in triangles(32), b in triangles(32), pose in pose(), depth in 0_u32..13,
        of_a in built_options(), of_b in built_options(), budget in any_budget(), way in any_way(),
    ) {
        let (a, b) = (body_of(&a, &of_a), body_of(&b, &of_b));
        let found = answer(way, &a, &b, pose, Question::Pairs, depth, budget).finish();
        prop_assert_eq!(found, brute_force(&a.view(), &b.view(), &pose));
    }

    #[test]
    fn sets_are_those_of_brute_force(
        a in triangles(32), b in triangles(32), pose in pose(), depth in 0_u32..13,
        of_a in built_options(), of_b in built_options(), budget in any_budget(), way in any_way(),
    ) {
        let (a, b) = (body_of(&a, &of_a), body_of(&b, &of_b));
        let found = answer(way, &a, &b, pose, Question::Sets, depth, budget).finish();
        let all = brute_force(&a.view(), &b.view(), &pose);
        prop_assert_eq!((found.hits, found.zones), (all.hits, all.zones));
        prop_assert_eq!((found.pairs, found.hash), (0, 0));
    }

    #[test]
    fn touches_if_and_only_if_there_is_a_pair(
        a in triangles(6), b in triangles(6), pose in pose(), depth in 0_u32..4,
        built in built_options(), budget in prop_oneof![Just(ALL), 1_u64..100], way in any_way(),
    ) {
        let (a, b) = (body_of(&a, &built), body_of(&b, &built));
        let found = answer(way, &a, &b, pose, Question::Touches, depth, budget).finish();
        let all = brute_force(&a.view(), &b.view(), &pose);
        prop_assert_eq!(found.pairs > 0, all.pairs > 0);
        prop_assert!(found.hits.is_subset(&all.hits));
        prop_assert_eq!((found.hash, found.zones), (0, (0, 0)));
    }

    /// A sink that is full ends the job; nothing is lost and nothing counts twice.
    #[test]
    fn a_sink_may_say_stop_at_any_hit(
        a in triangles(24), b in triangles(24), pose in pose(), built in built_options(),
        hits_max in 2_usize..40, way in any_way(),
    ) {
        let (a, b) = (body_of(&a, &built), body_of(&b, &built));
        // Two leaves may have more hits than a small sink accepts, and would then never complete.
        let hits_max = hits_max.max(2 * LEAF_TRIANGLES.max(built.leaf_size as usize));
        let directions = directions();
        let task = task(&a, &b, pose, Question::Pairs, &directions);
        let small = || Listener { hits_max, ..Listener::new() };
        let found = run_all(&mut way.kernel(&a, &b), &task, &[NodePair::ROOTS], ALL, small);
        prop_assert_eq!(found.finish(), brute_force(&a.view(), &b.view(), &pose));
    }

    /// What remains and what was tested share no pair of triangles, and miss none that intersects.
    #[test]
    fn what_remains_is_what_was_missed(
        a in triangles(24), b in triangles(24), pose in pose(), built in built_options(),
        budget in 1_u64..200, way in any_way(),
    ) {
        let (a, b) = (body_of(&a, &built), body_of(&b, &built));
        let directions = directions();
        let task = task(&a, &b, pose, Question::Pairs, &directions);
        let mut kernel = way.kernel(&a, &b);
        let outcome = kernel.run(&task, NodePair::ROOTS, budget, &mut Listener::new());
        let mut covered = BTreeSet::new();
        for pair in kernel.remaining() {
            for i in section::triangles(task.a.nodes, pair.a) {
                for j in section::triangles(task.b.nodes, pair.b) {
                    prop_assert!(covered.insert((i, j)));
                }
            }
        }
        let rest = kernel.remaining().to_vec();
        let rest = run_all(&mut kernel, &task, &rest, ALL, Listener::new).finish();
        let all = brute_force(&a.view(), &b.view(), &pose);
        prop_assert_eq!(outcome.pairs + rest.pairs, all.pairs);
        prop_assert_eq!(outcome.hash.wrapping_add(rest.hash), all.hash);
        prop_assert_eq!(outcome.end == End::Complete, covered.is_empty());
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]

    /// In all configurations: no job takes more tests than its budget, and all jobs together find
    /// everything.
    // verifies REQ-BUDGET
    #[test]
    fn no_job_takes_more_tests_than_its_budget(
        sizes in (0.05..2.0_f32, 0.05..2.0_f32), leaf_size in 1_u32..65, seed in any::<u16>(),
        budget in STEP_TESTS + 1..60_000, way in any_way(),
    ) {
        let built = options(Build::Sah, leaf_size);
        let a = body_of(&soup(700, sizes.0, seed.into()), &built);
        let b = body_of(&soup(700, sizes.1, u64::from(seed) + 1), &built);
        let directions = directions();
        let pose = turned(f64::from(seed), [0.1, 0.0, 0.0]);
        let task = task(&a, &b, pose, Question::Pairs, &directions);
        let mut kernel = way.kernel(&a, &b);
        let (mut open, mut pairs) = (vec![NodePair::ROOTS], 0);
        while let Some(start) = open.pop() {
            let outcome = kernel.run(&task, start, within(budget), &mut Listener::new());
            prop_assert!(outcome.counters.tests() <= budget, "{:?} of {budget}", outcome.counters);
            pairs += outcome.pairs;
            open.extend(kernel.remaining());
        }
        prop_assert_eq!(pairs, kernel.run(&task, NodePair::ROOTS, ALL, &mut Listener::new()).pairs);
    }
}

/// Closed bodies that share curved, coplanar and touching surfaces, at every build and leaf size.
#[test]
fn structured_bodies_give_the_same_answer_whatever_the_tree() {
    let (ring, fat) = (torus(24, 12, 0.3), torus(18, 10, 0.5));
    let poses = [
        turned(40.0, [0.9, 0.1, 0.2]),
        turned(0.0, [1.0, 0.0, 0.0]),
        RelativePose::between(&Pose::IDENTITY, &Pose::IDENTITY),
    ];
    for (pose, other) in [(poses[0], &fat), (poses[1], &fat), (poses[2], &ring)] {
        let plain = options(Build::Paper, 1);
        let (a, b) = (body_of(&ring, &plain), body_of(other, &plain));
        let expected: Found = brute_force(&a.view(), &b.view(), &pose);
        assert!(expected.pairs > 100, "{}", expected.pairs);
        for build in [Build::Paper, Build::Literal, Build::Sah] {
            for (leaf_size, depth) in [(1, 0), (1, 12), (2, 5), (4, 3), (8, 8), (64, 1)] {
                let built = options(build, leaf_size);
                let (a, b) = (body_of(&ring, &built), body_of(other, &built));
                for way in Way::all() {
                    let found = answer(way, &a, &b, pose, Question::Pairs, depth, 5_000).finish();
                    let place = format!("{build:?}, {leaf_size} to a leaf, depth {depth}, {way:?}");
                    assert!(found == expected, "{place}");
                    let sets = answer(way, &a, &b, pose, Question::Sets, depth, ALL);
                    assert!(sets.hits == expected.hits, "{place}");
                }
            }
        }
    }
}

/// Generated bodies as they are ranked: flat panels, thin parts, shared edges.
#[test]
fn generated_bodies_give_the_answer_of_brute_force() {
    let body = |shape, built: &BuildOptions| {
        let mesh = shapes::generate(shape, 500, 0).expect("500 triangles are possible");
        body_of(&mesh.corners, built)
    };
    let cases = [
        (Shape::Sedan, Shape::Suv, turned(170.0, [3.9, 0.3, 0.2])),
        (Shape::Sedan, Shape::Pedestrian, turned(80.0, [2.0, 0.4, 0.0])),
        (Shape::Truck, Shape::Wall, turned(90.0, [3.0, 0.0, -0.1])),
    ];
    for (of_a, of_b, pose) in cases {
        let plain = options(Build::Paper, 1);
        let (a, b) = (body(of_a, &plain), body(of_b, &plain));
        let expected = brute_force(&a.view(), &b.view(), &pose);
        assert!(expected.pairs > 10, "{of_a} and {of_b}: {} pairs", expected.pairs);
        for build in [Build::Paper, Build::Literal, Build::Sah] {
            let built = options(build, 4);
            let (a, b) = (body(of_a, &built), body(of_b, &built));
            for (depth, way) in [0, 4, 8, 12].into_iter().zip(Way::all().into_iter().cycle()) {
                let found = answer(way, &a, &b, pose, Question::Pairs, depth, ALL).finish();
                assert!(found == expected, "{of_a} and {of_b}, {build:?}, depth {depth}, {way:?}");
            }
        }
    }
}

/// Sets may skip pairs that add nothing: most of them, for bodies that lie within each other.
#[test]
fn sets_test_fewer_triangles_than_pairs() {
    let dense = soup(300, 3.0, 7);
    let body = body_of(&dense, &options(Build::Paper, 4));
    let pose = turned(20.0, [0.1, 0.0, 0.0]);
    for way in Way::all() {
        let np = |question| answer(way, &body, &body, pose, question, 0, ALL).counters.np;
        assert!(3 * np(Question::Sets) < 2 * np(Question::Pairs), "{way:?}");
    }
}

// verifies REQ-BUDGET
#[test]
fn a_beat_comes_at_least_every_so_many_tests() {
    let body = body_of(&soup(2_000, 0.3, 8), &options(Build::Paper, 64));
    let directions = directions();
    let task = task(&body, &body, turned(20.0, [0.1, 0.0, 0.0]), Question::Pairs, &directions);
    let mut listener = Listener::new();
    let outcome = kernel_for(&body, &body).run(&task, NodePair::ROOTS, ALL, &mut listener);
    let marks = [0].iter().chain(&listener.beats).copied().chain([outcome.counters.tests()]);
    let gaps = marks.clone().zip(marks.skip(1)).map(|(from, to)| to - from);
    assert!(listener.beats.len() > 100);
    assert!(gaps.clone().all(|gap| gap <= BEAT_TESTS + STEP_TESTS), "{:?}", gaps.max());
}

#[test]
fn a_beat_may_say_stop_and_nothing_is_lost() {
    let (a, b) = (soup(900, 0.4, 9), soup(900, 0.4, 10));
    let built = options(Build::Paper, 16);
    let (a, b) = (body_of(&a, &built), body_of(&b, &built));
    let pose = turned(70.0, [0.2, 0.3, 0.0]);
    let directions = directions();
    let task = task(&a, &b, pose, Question::Pairs, &directions);
    let mut kernel = kernel_for(&a, &b);
    let expected = brute_force(&a.view(), &b.view(), &pose);
    // Between two leaves as well as in the middle of them.
    for beats_max in 0..20 {
        let mut stopped = Listener { beats_max, ..Listener::new() };
        let first = kernel.run(&task, NodePair::ROOTS, ALL, &mut stopped);
        assert_eq!((first.end, stopped.beats.len()), (End::Stopped, beats_max + 1));
        let rest = kernel.remaining().to_vec();
        let mut all = run_all(&mut kernel, &task, &rest, ALL, Listener::new);
        all.add(&first);
        all.add_heard(&task, &first, &stopped);
        assert!(all.finish() == expected, "stopped at beat {beats_max}");
    }
}

/// The bound of the module documentation: no walk over these trees needs a deeper stack.
#[test]
fn the_stack_has_room_for_the_deepest_trees() {
    let chain: Vec<_> = (0..1500)
        .map(|i| {
            let r = 1.0 / (1.0 + i as f32);
            [[-r, -r, -r], [r, r, r], [r, -r, r]]
        })
        .collect();
    let body = body_of(&chain, &options(Build::Literal, 1));
    assert!(body.meta.depth > 500);
    let directions = directions();
    let pose = RelativePose::between(&Pose::IDENTITY, &Pose::IDENTITY);
    let task = task(&body, &body, pose, Question::Sets, &directions);
    let mut kernel = kernel_for(&body, &body);
    let outcome = kernel.run(&task, NodePair::ROOTS, ALL, &mut Listener::new());
    assert_eq!(outcome.end, End::Complete);
}

/// Where f32 cannot hold the boxes' values, the plain walk takes over: nothing is lost.
#[test]
fn bodies_of_any_size_give_the_answer_of_brute_force() {
    let pose = turned(20.0, [0.3, 0.1, 0.0]);
    for size in [1e-37, 1e-30, 1e-12, 1e9, 1e29, 3e37] {
        let scaled = |seed| -> Vec<_> {
            let corners = soup(60, 0.8, seed).into_iter();
            corners.map(|corners| corners.map(|corner| corner.map(|x| x * size))).collect()
        };
        let built = options(Build::Paper, 4);
        let (a, b) = (body_of(&scaled(15), &built), body_of(&scaled(16), &built));
        let pose =
            RelativePose { translation: pose.translation.map(|t| t * f64::from(size)), ..pose };
        let expected = brute_force(&a.view(), &b.view(), &pose);
        assert!(expected.pairs > 10);
        for way in Way::all() {
            let found = answer(way, &a, &b, pose, Question::Pairs, 0, ALL).finish();
            assert!(found == expected, "{size} m, {way:?}");
        }
    }
}

/// A stack that is too small acts like a budget: the job ends early, and the rest can be done.
#[test]
fn a_stack_too_small_loses_nothing() {
    let built = options(Build::Paper, 1);
    let (a, b) = (body_of(&soup(200, 0.4, 11), &built), body_of(&soup(200, 0.4, 12), &built));
    let pose = turned(10.0, [0.0, 0.3, 0.0]);
    let directions = directions();
    let task = task(&a, &b, pose, Question::Pairs, &directions);
    for depth in [0, 1, 3] {
        let mut kernel = Kernel::with_room(depth, depth, 200, 200);
        let found = run_all(&mut kernel, &task, &[NodePair::ROOTS], ALL, Listener::new).finish();
        assert_eq!(found, brute_force(&a.view(), &b.view(), &pose));
    }
}

/// All scratch exists before the first job, and none of it grows or moves.
#[test]
fn a_job_needs_no_more_room_than_it_was_given() {
    let built = options(Build::Paper, 4);
    let (a, b) = (body_of(&soup(3_000, 0.4, 13), &built), body_of(&soup(2_000, 0.4, 14), &built));
    let directions = directions();
    let task = task(&a, &b, turned(33.0, [0.1; 3]), Question::Pairs, &directions);
    let mut kernel = Kernel::with_room(1, 1, 1, 1);
    kernel.ensure_room(a.meta.depth, b.meta.depth, a.corners.len(), b.corners.len());
    let place = |k: &Kernel| {
        let (stack, near) = (k.stack.as_ptr(), k.near.as_ptr());
        (stack, k.stack.capacity(), near, k.near.capacity(), k.hits_a.place(), k.hits_b.place())
    };
    let before = place(&kernel);
    let outcome = kernel.run(&task, NodePair::ROOTS, ALL, &mut Listener::new());
    assert!(outcome.pairs > 1000);
    assert_eq!(place(&kernel), before);
    kernel.ensure_room(1, 1, 1, 1);
    assert_eq!(place(&kernel), before);
}
