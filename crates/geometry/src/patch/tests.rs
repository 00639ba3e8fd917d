//! The invariant: at every level, however triangles are grouped, patches agree with the exact test.

use super::*;
use crate::{Pose, hash::splitmix64, simd, triangle};
use fearless_simd::{Level, dispatch};
use proptest::prelude::*;
use proptest::sample::select;

/// Coordinates that often coincide or almost do; some at the ends of the range of f32.
fn coordinate() -> impl Strategy<Value = f32> {
    prop_oneof![
        12 => (-2_i8..=2).prop_map(f32::from),
        12 => -1.0..1.0_f32,
        1 => (-2_i8..=2).prop_map(|x| f32::from(x) + f32::EPSILON),
        1 => (-2_i8..=2, -148_i32..126).prop_map(|(x, e)| libm::scalbnf(f32::from(x), e)),
    ]
}

fn corners() -> impl Strategy<Value = Corners> {
    prop::array::uniform3(prop::array::uniform3(coordinate()))
}

/// Poses with right angles, small ones and any; near, and as far away as a city is wide.
fn pose() -> impl Strategy<Value = RelativePose> {
    let angle = || {
        prop_oneof![
            2 => Just(0.0),
            2 => select(&[-90.0, 90.0, 180.0]),
            1 => (-1070_i32..0).prop_map(|e| libm::scalbn(1.0, e)),
            3 => -180.0..180.0_f64,
        ]
    };
    let offset = prop_oneof![
        3 => Just([0.0; 3]),
        3 => prop::array::uniform3((-2_i8..=2).prop_map(f64::from)),
        3 => prop::array::uniform3(-1.0..1.0_f64),
        1 => prop::array::uniform3(-1e5..1e5_f64),
    ];
    (angle(), angle(), angle(), offset).prop_map(|(yaw, pitch, roll, offset)| {
        RelativePose::between(&Pose::IDENTITY, &Pose::from_degrees(yaw, pitch, roll, offset))
    })
}

/// All pairs, by the exact test.
fn exact(posed: &Posed<'_>) -> Vec<[u32; 2]> {
    let (of_a, of_b) = (posed.a.len() as u32, posed.b.len() as u32);
    let pairs = (0..of_a).flat_map(|a| (0..of_b).map(move |b| [a, b]));
    let hit = |pair: &[u32; 2]| {
        let [a, b] = posed.triangles(*pair);
        triangle::intersect(&a, &b)
    };
    pairs.filter(hit).collect()
}

/// All pairs, by patches of `size` triangles.
fn by_patches(level: Level, posed: &Posed<'_>, size: usize) -> Vec<[u32; 2]> {
    let cut = |count: usize| (0..count).step_by(size).map(move |at| at..count.min(at + size));
    let whole = |range: Range<usize>| range.start as u32..range.end as u32;
    let (mut patches, mut hits) = (Patches::default(), Vec::new());
    for a in cut(posed.a.len()) {
        for b in cut(posed.b.len()) {
            let ranges = (whole(a.clone()), whole(b));
            dispatch!(level, simd => {
                meet_all(simd, posed, &mut patches, ranges, &mut |pair| hits.push(pair));
            });
        }
    }
    hits.sort_unstable();
    hits
}

#[track_caller]
fn assert_exact(posed: &Posed<'_>) {
    let expected = exact(posed);
    for level in simd::levels() {
        for size in [1, 5, ROOM] {
            let found = by_patches(level, posed, size);
            assert_eq!(found, expected, "{size} at {}: {posed:?}", simd::name(level));
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2_000))]

    #[test]
    fn patches_say_what_the_exact_test_says(
        pose in pose(),
        a in prop::collection::vec(corners(), 1..12),
        b in prop::collection::vec(corners(), 1..12),
    ) {
        assert_exact(&Posed::new(&pose, &a, &b));
    }

    /// Small triangles of a large body, as in real bodies: nearly every lane decides.
    #[test]
    fn small_triangles_are_decided_exactly(seed in any::<u64>(), pose in pose(), scale in -30..0) {
        let mut state = seed;
        let mut real = || {
            state = splitmix64(state);
            (state >> 40) as f32 / (1_u32 << 23) as f32 - 1.0
        };
        let size = libm::scalbnf(1.0, scale);
        let mut small = |at: [f32; 3]| -> Corners {
            core::array::from_fn(|_| core::array::from_fn(|k| at[k] + size * real()))
        };
        let b: Vec<_> = (0..8).map(|i| small([i as f32 * 0.3, 1.0, -0.5])).collect();
        // A's triangles are placed where B's are after posing.
        let near = |c: &Corners| pose.point(c[0]).to_array().map(|x| x as f32);
        let a: Vec<_> = b.iter().map(|c| small(near(c))).collect();
        assert_exact(&Posed::new(&pose, &a, &b));
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(500))]

    /// Also after a larger body, of whose triangles nothing must remain.
    #[test]
    fn what_is_wanted_is_taken(
        small in 1..=ROOM,
        at in 0_u32..50,
        some in prop::collection::vec(any::<bool>(), ROOM),
        others in prop::collection::vec(any::<bool>(), ROOM),
    ) {
        let pose = RelativePose::between(&Pose::IDENTITY, &Pose::IDENTITY);
        let flat: Corners = [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 1.5, 0.0]];
        let (large, small) = (vec![flat; 1000 + ROOM], vec![flat; at as usize + small]);
        let around = Aabb::of(&flat);
        for level in simd::levels() {
            let (mut patch_a, mut patch_b) = (Patch::default(), Patch::default());
            for (body, first, some) in [(&large, 1000, &others), (&small, at, &some)] {
                let (posed, mut places) = (Posed::new(&pose, body, body), Places::default());
                let there = body.len() - first as usize;
                (0..there.min(ROOM)).filter(|i| some[*i]).for_each(|i| places.insert(i));
                let close = posed.close(&around, &around);
                dispatch!(level, simd => {
                    patch_a.want_a(simd, &posed, first, &places);
                    patch_b.want_b(simd, &posed, first, &places);
                    patch_a.take_a(simd, (&posed, &close), &All(simd));
                    patch_b.take_b(simd, (&posed, &close), &All(simd));
                });
                let expected = (0..there.min(ROOM)).filter(|i| some[*i]).map(|i| first + i as u32);
                let expected: Vec<_> = expected.collect();
                prop_assert_eq!(patch_a.triangles(), &expected);
                prop_assert_eq!(patch_b.triangles(), &expected);
            }
        }
    }
}

/// Otherwise the tests above would only test the exact test.
#[test]
fn what_is_clear_is_decided_by_the_lanes() {
    let turned = Pose::from_degrees(30.0, 20.0, 10.0, [0.0; 3]);
    let flat: Corners = [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 1.5, 0.0]];
    let across = |z: f32| [[0.0, 0.1, z - 1.0], [0.1, 0.0, z + 1.0], [0.2, 0.1, z + 0.9]];
    // One that crosses it, one far away, one in its plane where the poses are equal.
    let (a, b) = ([flat], [across(0.0), across(5.0), flat]);
    for (pose, doubt) in [(turned, 0b00), (Pose::IDENTITY, 0b10)] {
        let pose = RelativePose::between(&Pose::IDENTITY, &pose);
        let posed = Posed::new(&pose, &a, &b);
        let around = Aabb { min: [-1.0, -1.0, -1.0], max: [1.0, 1.5, 6.0] };
        let close = posed.close(&around, &around);
        let Patches { a: mut patch_a, b: mut patch_b, mut pairs } = Patches::default();
        for level in simd::levels() {
            let [hits, open] = dispatch!(level, simd => {
                patch_a.want_a(simd, &posed, 0, &Places::first(1));
                patch_b.want_b(simd, &posed, 0, &Places::first(3));
                patch_a.take_a(simd, (&posed, &close), &All(simd));
                patch_b.take_b(simd, (&posed, &close), &All(simd));
                pairs.take(simd, &patch_a, (&patch_b, 0));
                let lanes = pairs.eight(simd, &posed, &close, 0);
                // The box of the second one is too far away.
                assert_eq!(pairs.drain(), [[0, 0], [0, 2]]);
                lanes.map(|lanes| lanes.to_bitmask() & 0b11)
            });
            assert_eq!([hits & 0b01, open], [0b01, doubt], "at {}", simd::name(level));
        }
    }
}
