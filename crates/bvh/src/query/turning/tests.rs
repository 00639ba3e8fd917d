//! Laws of first contact in motion: it is that of brute force over all pairs of triangles, to the
//! bit; exact touches at closely spaced poses never contradict it.

use super::*;
use crate::fixtures::{any_build, options, soup, torus};
use crate::{Build, Tree};
use geometry::motion::{MotionPath, MovingBodies, Orientation, State, TimeInterval};
use geometry::{Corners, DVec3, Sweep, Triangle, simd, triangle};
use proptest::prelude::*;
use std::collections::BTreeSet;

/// The closed box between two corners, as twelve triangles.
fn cuboid(min: [f32; 3], max: [f32; 3]) -> Vec<Corners> {
    let corner = |k: usize| [0, 1, 2].map(|axis| if k >> axis & 1 == 0 { min } else { max }[axis]);
    let faces =
        [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]];
    let halves = |[p, q, r, s]: [usize; 4]| [[p, q, r], [p, r, s]];
    faces.into_iter().flat_map(halves).map(|half| half.map(corner)).collect()
}

/// A car of boxes, with mirrors as thick as this (m).
fn car(thickness: f32) -> Vec<Corners> {
    let mirror = |y: [f32; 2]| cuboid([0.6, y[0], 0.8], [0.6 + thickness, y[1], 0.95]);
    let body = cuboid([-2.2, -0.9, 0.2], [2.2, 0.9, 1.4]);
    [body, mirror([0.9, 1.1]), mirror([-1.1, -0.9])].concat()
}

fn tree(corners: &[Corners], build: Build, leaf_size: u32) -> Tree {
    Tree::build(corners, &options(build, leaf_size)).unwrap()
}

fn state(time_s: f64, position_m: [f64; 3], [yaw, pitch, roll]: [f64; 3]) -> State {
    State { time_s, position_m, orientation: Orientation::from_degrees(yaw, pitch, roll) }
}

fn workspaces() -> Vec<MotionWorkspace> {
    let with = |walk, level| {
        let mut workspace = MotionWorkspace::new();
        workspace.set_walk(walk);
        workspace.set_level(level);
        workspace
    };
    let wide = simd::levels().map(|level| with(Walk::Wide, level));
    wide.chain([with(Walk::Plain, Level::new())]).collect()
}

/// Whether any triangle touches any other at the pose at a time, exactly.
fn touching(a: &Tree, b: &Tree, motion: &RelativeMotion<'_>, time_s: f64) -> BTreeSet<[u32; 2]> {
    let pose = motion.pose_at(time_s);
    let mut ids = BTreeSet::new();
    for (of_a, id_a) in a.corners().iter().zip(a.ids()) {
        let stored = Triangle::stored(of_a);
        for (of_b, id_b) in b.corners().iter().zip(b.ids()) {
            if triangle::intersect(&stored, &pose.triangle(of_b)) {
                ids.insert([*id_a, *id_b]);
            }
        }
    }
    ids
}

/// An earlier touch, by bisection over the pairs that touch at a time.
fn earlier(a: &Tree, b: &Tree, motion: &RelativeMotion<'_>, mut from_s: f64, mut to_s: f64) -> f64 {
    let mut pairs = touching(a, b, motion, to_s);
    for _ in 0..20 {
        let time_s = from_s + (to_s - from_s) * 0.5;
        let touching = touching(a, b, motion, time_s);
        if touching.is_disjoint(&pairs) {
            from_s = time_s;
        } else {
            to_s = time_s;
            pairs = &pairs & &touching;
        }
    }
    to_s
}

/// The answer by all pairs of triangles in the same intervals: no box of a node, no bound on
/// memory.
fn brute_force(
    a: &Tree,
    b: &Tree,
    motion: &RelativeMotion<'_>,
    resolution_m: f64,
) -> MotionContact {
    let certain = |time_s: f64, excluded_before_s: f64| {
        let ids = touching(a, b, motion, time_s).pop_first().unwrap();
        MotionContact::Certain { time_s, excluded_before_s, ids }
    };
    if !touching(a, b, motion, motion.from_s()).is_empty() {
        return certain(motion.from_s(), motion.from_s());
    }
    let (box_a, box_b) = (a.bounds(), b.bounds());
    let bodies = MovingBodies::new(motion, [&box_a, &box_b]);
    let mut all = Vec::new();
    for of_a in 0..a.ids().len() {
        all.extend((0..b.ids().len()).map(|of_b| [of_a, of_b]));
    }
    let mut possible: Option<(f64, f64, [u32; 2])> = None;
    let answer = |possible: Option<(f64, f64, [u32; 2])>| match possible {
        Some((time_s, to_s, ids)) => MotionContact::Possible { time_s, to_s, ids },
        None => MotionContact::Excluded,
    };
    for piece in motion.pieces() {
        let mut todo = vec![(TimeInterval::of(motion, &bodies, &piece), all.clone())];
        while let Some((interval, mut pairs)) = todo.pop() {
            if let Some((from_s, to_s, _)) = possible
                && interval.from_s >= to_s + 32.0 * (to_s - from_s)
            {
                return answer(possible);
            }
            pairs.retain(|[of_a, of_b]| {
                let corners = (&a.corners()[*of_a], &b.corners()[*of_b]);
                let moved = interval.moved_b(corners.1);
                if interval.is_short(resolution_m) {
                    return !interval.are_apart(corners.0, corners.1, &moved);
                }
                !interval.are_clearly_apart(corners.0, corners.1, &moved)
            });
            if pairs.is_empty() {
                continue;
            }
            if !interval.is_short(resolution_m) {
                let [first, second] = interval.halves(motion, &bodies, &piece).unwrap();
                todo.push((second, pairs.clone()));
                todo.push((first, pairs));
                continue;
            }
            let times = pairs.iter().filter_map(|[of_a, of_b]| {
                let corners = (&a.corners()[*of_a], &b.corners()[*of_b]);
                interval.first_touch(motion, corners.0, corners.1, f64::INFINITY)
            });
            let time_s = times.fold(f64::INFINITY, f64::min);
            if time_s.is_finite() {
                let time_s = earlier(a, b, motion, interval.from_s, time_s);
                return certain(time_s, possible.map_or(interval.from_s, |(from_s, ..)| from_s));
            }
            let ids = pairs.iter().map(|[of_a, of_b]| [a.ids()[*of_a], b.ids()[*of_b]]).min();
            possible = possible.or(ids.map(|ids| (interval.from_s, interval.to_s, ids)));
        }
    }
    answer(possible)
}

/// The answer, the same for all walks and vectors; and that exact poses do not contradict it.
fn checked(a: &Tree, b: &Tree, motion: &RelativeMotion<'_>, step_s: f64) -> MotionContact {
    let limits = MotionLimits::default();
    let answers: Vec<MotionContact> = workspaces()
        .iter_mut()
        .map(|workspace| first_contact_in_motion(a, b, motion, &limits, workspace).unwrap())
        .collect();
    let first = answers[0];
    assert!(answers.iter().all(|answer| *answer == first), "{answers:?}");
    let clear_before_s = match first {
        MotionContact::Excluded => f64::INFINITY,
        MotionContact::Certain { time_s, excluded_before_s, ids } => {
            assert_eq!(touching(a, b, motion, time_s).pop_first(), Some(ids), "{first:?}");
            assert!(motion.from_s() <= excluded_before_s && excluded_before_s <= time_s);
            assert!(time_s <= motion.to_s());
            excluded_before_s
        }
        MotionContact::Possible { time_s, to_s, .. } => {
            assert!(motion.from_s() <= time_s && time_s < to_s && to_s <= motion.to_s());
            time_s
        }
        MotionContact::OutOfBudget { .. } => panic!("{first:?} without a budget"),
    };
    let steps = ((motion.to_s() - motion.from_s()) / step_s) as u32;
    let mut poses = Workspace::new();
    for step in 0..=steps {
        let time_s = motion.from_s() + f64::from(step) * step_s;
        if time_s >= clear_before_s.min(motion.to_s()) {
            break;
        }
        let touches = super::super::touches(a, b, &motion.pose_at(time_s), &mut poses).unwrap();
        assert!(!touches, "{first:?}, but they touch at {time_s}");
    }
    first
}

/// A path of two or three states near a place, turning about any axis up to several rad/s.
fn path(spread: f64, turn: f64) -> impl Strategy<Value = MotionPath> {
    let around = prop::array::uniform3(-spread..spread);
    let turns = prop_oneof![
        Just([0.0; 3]),
        (-turn..turn).prop_map(|yaw| [yaw, 0.0, 0.0]),
        prop::array::uniform3(-turn..turn),
    ];
    let step = (0.1..0.4_f64, around, turns);
    prop::collection::vec(step, 2..4).prop_map(|steps| {
        let mut time_s = 0.0;
        let mut states = Vec::new();
        for (k, (step_s, position_m, turn)) in steps.into_iter().enumerate() {
            time_s += if k == 0 { 0.0 } else { step_s };
            states.push(state(time_s, position_m, turn));
        }
        MotionPath::new(&states).unwrap()
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 96, ..ProptestConfig::default() })]

    /// The same bits as brute force, for all builds and leaf sizes, walks and vectors.
    #[test]
    fn finds_what_brute_force_finds(
        (a, b) in (path(2.5, 60.0), path(2.5, 100.0)),
        counts in [1_usize..12, 1_usize..12],
        seeds in [any::<u16>(), any::<u16>()],
        sizes in [1_u32..=64, 1_u32..=64],
        build in any_build(),
    ) {
        let motion = RelativeMotion::new(&a, &b).unwrap();
        let tree_of = |k: usize| tree(&soup(counts[k], 0.5, u64::from(seeds[k])), build, sizes[k]);
        let (a, b) = (tree_of(0), tree_of(1));
        let first = checked(&a, &b, &motion, 2e-3);
        prop_assert_eq!(first, brute_force(&a, &b, &motion, 1e-3));
    }

    /// The same on ways that are long and straight, or nearly so, where it is sought until when
    /// they are clear.
    #[test]
    fn finds_what_brute_force_finds_on_long_ways(
        (ends, beside) in (prop::array::uniform2(-1.0..1.0_f64), -1.5..1.5_f64),
        (turn, of_a) in (prop_oneof![Just(0.0), -3.0..3.0_f64], 0.0..360.0_f64),
        far in 1.0..12.0_f64,
        counts in [1_usize..12, 1_usize..12],
        seeds in [any::<u16>(), any::<u16>()],
        build in any_build(),
    ) {
        let tree_of = |k: usize| tree(&soup(counts[k], 0.5, u64::from(seeds[k])), build, 2);
        let (a, b) = (tree_of(0), tree_of(1));
        let lasts_s = far / 6.0;
        let orientation = Orientation::from_degrees(of_a, 0.0, 0.0);
        let a_path = MotionPath::still([0.0; 3], orientation, [0.0, lasts_s]).unwrap();
        let b_path = MotionPath::new(&[
            state(0.0, [-far, beside + ends[0], 0.2], [0.0; 3]),
            state(lasts_s, [far, beside + ends[1], -0.2], [turn, 0.0, 0.0]),
        ]).unwrap();
        let motion = RelativeMotion::new(&a_path, &b_path).unwrap();
        let first = checked(&a, &b, &motion, 2e-3);
        prop_assert_eq!(first, brute_force(&a, &b, &motion, 1e-3));
    }

    /// Rods that cross while one passes over the other, by less than the resolution or little more:
    /// what counts as near leaves out nothing that is possible.
    #[test]
    fn finds_rods_that_pass_as_brute_force_does(
        gap_m in -2e-4..2.5e-3_f64,
        (yaw, pitch) in (-80.0..80.0_f64, -20.0..20.0_f64),
        turn in prop_oneof![Just(0.0), -0.5..0.5_f64],
        speed in 1.0..20.0_f64,
        build in any_build(),
    ) {
        let rod = tree(&cuboid([-1.0, -0.01, -0.01], [1.0, 0.01, 0.01]), build, 4);
        let lasts_s = 2.0 / speed;
        let a_path = MotionPath::still([0.0; 3], Orientation::IDENTITY, [0.0, lasts_s]).unwrap();
        let up = 0.01 * (1.0 + 1.0 / pitch.to_radians().cos()) + gap_m;
        let b_path = MotionPath::new(&[
            state(0.0, [0.1, -1.0, up], [yaw, pitch, 0.0]),
            state(lasts_s, [0.1, 1.0, up], [yaw + turn, pitch, 0.0]),
        ]).unwrap();
        let motion = RelativeMotion::new(&a_path, &b_path).unwrap();
        let first = checked(&rod, &rod, &motion, lasts_s / 500.0);
        prop_assert_eq!(first, brute_force(&rod, &rod, &motion, 1e-3));
    }

    /// Cars whose mirrors pass each other: thin plates that overlap, or are close to it.
    #[test]
    fn finds_mirrors_that_pass(
        thickness in prop_oneof![Just(2e-3_f32), 2e-3..6e-2_f32],
        overlap in prop_oneof![-1e-2..-1e-4_f64, 1e-4..1e-3_f64, 1e-3..0.2_f64],
        speed in 2.0..20.0_f64,
        start in 1.3..4.0_f64,
        turn in prop_oneof![Just(0.0), -1.0..1.0_f64],
        build in any_build(),
    ) {
        let corners = car(thickness);
        let [a, b] = [4, 1].map(|size| tree(&corners, build, size));
        let lasts_s = (start + 2.0) / speed;
        // The other car comes towards A with its right side, which its mirror is on, turned to A's
        // left one; both turn a little meanwhile.
        let (half, y) = (turn * 0.5, 2.2 - overlap);
        let to = [start - speed * lasts_s, y, 0.0];
        let b_path = MotionPath::new(&[
            state(0.0, [start, y, 0.0], [180.0 - half, 0.0, 0.0]),
            state(lasts_s, to, [180.0 + half, 0.0, 0.0]),
        ]).unwrap();
        let a_path = MotionPath::still([0.0; 3], Orientation::IDENTITY, [0.0, lasts_s]).unwrap();
        let motion = RelativeMotion::new(&a_path, &b_path).unwrap();
        let first = checked(&a, &b, &motion, 5e-4);
        if turn == 0.0 {
            let is_contact = matches!(first, MotionContact::Certain { .. });
            prop_assert_eq!(is_contact, overlap > 0.0, "{:?}", first);
            prop_assert!(is_contact || first == MotionContact::Excluded);
        }
    }

    /// Without turning it is the first contact of the straight motion, to a nanometre.
    #[test]
    fn agrees_with_a_straight_motion(
        along in prop::array::uniform3(-1.0..1.0_f64),
        turn in prop::array::uniform3(-180.0..180.0_f64),
        speed in 0.5..30.0_f64,
        seed in any::<u16>(),
    ) {
        let along = DVec3::from_array(along);
        prop_assume!(along.length() > 0.1);
        let along = along.normalize();
        let [a, b] = [0, 1].map(|k| {
            tree(&soup(60, 0.4, u64::from(seed) * 2 + k), Build::Sah, 4)
        });
        let (start, lasts_s) = (along * -4.0, 8.0 / speed);
        let a_path = MotionPath::still([0.0; 3], Orientation::IDENTITY, [0.0, lasts_s]).unwrap();
        let b_path = MotionPath::new(&[
            state(0.0, start.to_array(), turn),
            state(lasts_s, (-start).to_array(), turn),
        ]).unwrap();
        let motion = RelativeMotion::new(&a_path, &b_path).unwrap();
        let first = checked(&a, &b, &motion, lasts_s / 500.0);
        let sweep = Sweep::new(along, 0.0, 8.0).unwrap();
        let mut workspace = super::super::SweepWorkspace::new();
        let pose = motion.pose_at(0.0);
        let straight = super::super::first_contact(&a, &b, &pose, &sweep, &mut workspace).unwrap();
        match (first, straight) {
            (MotionContact::Excluded, None) => {}
            (MotionContact::Certain { time_s, excluded_before_s, .. }, Some(witness)) => {
                let off_m = time_s * speed - witness.travel_m;
                prop_assert!((-2e-9..2e-9).contains(&off_m), "{} m", off_m);
                prop_assert!(excluded_before_s * speed <= witness.travel_m + 2e-9);
                prop_assert!((time_s - excluded_before_s) * speed <= 1e-3);
            }
            (first, straight) => prop_assert!(false, "{:?} and {:?}", first, straight),
        }
    }
}

/// A rod that turns about its end, at rates from slow to fast: its tip meets a wall when it should,
/// or passes it by a tenth of a millimetre.
#[test]
fn turns_in_place() {
    let rod = tree(&cuboid([0.0, -0.01, -0.01], [1.0, 0.01, 0.01]), Build::Sah, 1);
    for gap_m in [-1e-2, -1e-4, 1e-4, 1e-3, 1e-2] {
        for rate in [0.2, 1.0, 5.0, 10.0_f64] {
            // Its farthest edges are at a radius of √(1 + 0.01²) m.
            let radius = (1.0_f64 + 1e-4).sqrt();
            let at = (radius + gap_m) as f32;
            let wall = tree(&cuboid([-0.5, at, -0.5], [0.5, at + 0.1, 0.5]), Build::Sah, 1);
            let lasts_s = std::f64::consts::PI / rate;
            let a = MotionPath::still([0.0; 3], Orientation::IDENTITY, [0.0, lasts_s]).unwrap();
            let b = MotionPath::new(&[
                state(0.0, [0.0; 3], [0.0; 3]),
                state(lasts_s * 0.5, [0.0; 3], [90.0, 0.0, 0.0]),
                state(lasts_s, [0.0; 3], [180.0, 0.0, 0.0]),
            ])
            .unwrap();
            let motion = RelativeMotion::new(&a, &b).unwrap();
            let first = checked(&wall, &rod, &motion, lasts_s / 2000.0);
            if gap_m > 0.0 {
                assert_eq!(first, MotionContact::Excluded, "{gap_m} {rate}");
                continue;
            }
            let MotionContact::Certain { time_s, excluded_before_s, .. } = first else {
                panic!("{first:?} at {gap_m}, {rate}")
            };
            // The upper of the edges at the tip is 0.01 m ahead.
            let angle = (f64::from(at) / radius).asin() - (0.01_f64).atan();
            assert!((time_s * rate - angle).abs() < 2e-6, "{} {angle}", time_s * rate);
            assert!((time_s - excluded_before_s) * rate * radius <= 1e-3);
        }
    }
}

/// What slides along a long wall close by takes as few intervals as what is farther away.
#[test]
fn passing_closely_takes_few_intervals() {
    let wall = tree(&cuboid([-20.0, 0.0, 0.0], [20.0, 0.2, 1.0]), Build::Sah, 1);
    let car = tree(&car(0.02), Build::Sah, 1);
    let a = MotionPath::still([0.0; 3], Orientation::IDENTITY, [0.0, 4.0]).unwrap();
    let mut workspace = MotionWorkspace::new();
    for (gap_m, most) in [(2e-3, 60), (1e-2, 60), (0.1, 60)] {
        let y = -1.1 - gap_m;
        let b = MotionPath::new(&[
            state(0.0, [-30.0, y, 0.0], [0.0; 3]),
            state(4.0, [30.0, y, 0.0], [0.0; 3]),
        ])
        .unwrap();
        let motion = RelativeMotion::new(&a, &b).unwrap();
        let limits = MotionLimits::default();
        let first = first_contact_in_motion(&wall, &car, &motion, &limits, &mut workspace);
        assert_eq!(first, Ok(MotionContact::Excluded));
        let MotionEffort { intervals, .. } = workspace.effort();
        assert!(intervals <= most, "{intervals} at {gap_m}");
    }
}

/// MovingBodies that overlap at first do so certainly; a budget leaves an honest end.
#[test]
fn begins_and_ends_honestly() {
    let body = tree(&car(0.02), Build::Sah, 4);
    let a = MotionPath::still([0.0; 3], Orientation::IDENTITY, [0.0, 2.0]).unwrap();
    let through = MotionPath::new(&[
        state(0.5, [8.0, 0.5, 0.0], [10.0, 0.0, 0.0]),
        state(1.5, [-8.0, 0.5, 0.0], [50.0, 0.0, 0.0]),
    ])
    .unwrap();
    let motion = RelativeMotion::new(&a, &through).unwrap();
    assert_eq!((motion.from_s(), motion.to_s()), (0.5, 1.5));
    let first = checked(&body, &body, &motion, 5e-4);
    let MotionContact::Certain { time_s, excluded_before_s, .. } = first else {
        panic!("{first:?}")
    };
    let inside = motion.between(time_s, 1.5).unwrap();
    let at_once = checked(&body, &body, &inside, 5e-4);
    assert!(matches!(at_once, MotionContact::Certain { time_s: at, excluded_before_s: from, .. }
            if at == time_s && from == time_s));
    let mut workspace = MotionWorkspace::new();
    let (mut ended, mut last_s) = (0, 0.5);
    for budget in (0..2_000).step_by(50) {
        let limits = MotionLimits { budget, ..MotionLimits::default() };
        match first_contact_in_motion(&body, &body, &motion, &limits, &mut workspace).unwrap() {
            MotionContact::OutOfBudget { excluded_before_s: until_s } => {
                assert!(last_s <= until_s && until_s <= excluded_before_s);
                (ended, last_s) = (ended + 1, until_s);
            }
            other => assert_eq!(other, first),
        }
    }
    assert!(ended > 3, "{ended}");
    let limits = MotionLimits { resolution_m: 0.0, ..MotionLimits::default() };
    let refused = first_contact_in_motion(&body, &body, &motion, &limits, &mut workspace);
    assert_eq!(refused, Err(ResolutionError(0.0)));
}

/// Where very many pairs touch at the first pose, the budget holds there too, and nothing is said
/// to be excluded after it.
#[test]
fn a_budget_holds_where_bodies_coincide() {
    let body = tree(&torus(40, 20, 0.3), Build::Sah, 4);
    let a = MotionPath::still([0.0; 3], Orientation::IDENTITY, [0.0, 1.0]).unwrap();
    let motion = RelativeMotion::new(&a, &a).unwrap();
    let mut workspace = MotionWorkspace::new();
    let mut first = |budget| {
        let limits = MotionLimits { budget, ..MotionLimits::default() };
        first_contact_in_motion(&body, &body, &motion, &limits, &mut workspace).unwrap()
    };
    let open = MotionContact::OutOfBudget { excluded_before_s: 0.0 };
    assert_eq!(first(2_000), open);
    let touching = MotionContact::Certain { time_s: 0.0, excluded_before_s: 0.0, ids: [0, 0] };
    assert_eq!(first(u64::MAX), touching);
}
