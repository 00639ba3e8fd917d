//! The law: lanes say of a cell what the model says.

use super::*;
use fearless_simd::dispatch;
use geometry::{Aabb, simd};
use proptest::prelude::*;

/// Small numbers, some of them alike, and some out of any body.
fn coordinate() -> impl Strategy<Value = f32> {
    prop_oneof![-2.0..2.0_f32, (-2_i8..=2).prop_map(f32::from), -1e30..1e30_f32, 0.0..1e-30_f32]
}

fn a_box() -> impl Strategy<Value = Aabb> {
    let corner = || prop::array::uniform3(coordinate());
    (corner(), corner()).prop_map(|(p, q)| Aabb::of(&[p, q, p]))
}

proptest! {
    #[test]
    fn cells_are_those_of_the_grid(over in a_box(), of in a_box()) {
        let expected = Grid::over(&over).cells(&of);
        for level in simd::levels() {
            let found = dispatch!(level, simd => {
                cells_of(&OneBox::of(simd, &of), &OneBox::of(simd, &over))
            });
            prop_assert_eq!(found, expected, "{:?} at {}", over, simd::name(level));
        }
    }
}
