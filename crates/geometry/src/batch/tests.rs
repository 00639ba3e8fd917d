//! The law: at every level, in any order and number, the batch says what the exact test says.

use super::*;
use crate::{Pose, hash::splitmix64, simd};
use fearless_simd::dispatch;
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

/// Right angles, small ones and any; near, and as far away as a city is wide.
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

fn exact(batch: &Batch<'_>, pairs: &[[u32; 2]]) -> u64 {
    pairs.iter().enumerate().fold(0, |hits, (i, pair)| {
        let [a, b] = batch.triangles(*pair);
        hits | u64::from(triangle::intersect(&a, &b)) << i
    })
}

#[track_caller]
fn assert_exact(batch: &Batch<'_>, pairs: &[[u32; 2]]) {
    let expected = exact(batch, pairs);
    for level in simd::levels() {
        let found = dispatch!(level, simd => intersecting(simd, batch, pairs));
        assert_eq!(found, expected, "at {}: {batch:?} {pairs:?}", simd::name(level));
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2_000))]

    #[test]
    fn a_batch_is_its_pairs_one_by_one(
        pose in pose(),
        a in prop::collection::vec(corners(), 1..20),
        b in prop::collection::vec(corners(), 1..20),
        numbers in prop::collection::vec((0_u32..20, 0_u32..20), 0..=BATCH),
    ) {
        let batch = Batch::new(&pose, &a, &b);
        let (of_a, of_b) = (a.len() as u32, b.len() as u32);
        let pairs: Vec<_> = numbers.iter().map(|(i, k)| [i % of_a, k % of_b]).collect();
        assert_exact(&batch, &pairs);
    }

    /// Small triangles of a large body, as bodies have them: nearly every lane decides.
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
        // A's stand where B's do, after B is posed.
        let near = |c: &Corners| pose.point(c[0]).to_array().map(|x| x as f32);
        let a: Vec<_> = b.iter().map(|c| small(near(c))).collect();
        let pairs: Vec<_> = (0..64).map(|i| [i / 8, i % 8]).collect();
        assert_exact(&Batch::new(&pose, &a, &b), &pairs);
    }
}

/// Otherwise all of the above would test nothing but the exact test.
#[test]
fn what_is_clear_is_decided_by_the_lanes() {
    let turned = Pose::from_degrees(30.0, 20.0, 10.0, [0.0; 3]);
    let flat: Corners = [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 1.5, 0.0]];
    let across = |z: f32| [[0.0, 0.1, z - 1.0], [0.1, 0.0, z + 1.0], [0.2, 0.1, z + 0.9]];
    // One that crosses it, one far away, one in its plane where the poses are equal.
    let (a, b) = ([flat], [across(0.0), across(5.0), flat]);
    for (pose, doubt) in [(turned, 0b000), (Pose::IDENTITY, 0b100)] {
        let pose = RelativePose::between(&Pose::IDENTITY, &pose);
        let batch = Batch::new(&pose, &a, &b);
        let pairs: [_; BATCH] = core::array::from_fn(|i| [0, i.min(2) as u32]);
        for level in simd::levels() {
            let [hits, open] = dispatch!(level, simd => sifted(simd, &batch, &pairs));
            let found = [hits & 0b011, open & 0b111];
            assert_eq!(found, [0b001, doubt], "at {}", simd::name(level));
        }
    }
}
