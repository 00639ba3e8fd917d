//! Boxes as sets: union, overlap and the empty box against one-dimensional definitions.

use super::*;
use proptest::prelude::*;

/// Small whole numbers, so that boxes often touch, including −0.
fn point() -> impl Strategy<Value = [f32; 3]> {
    let coordinate = prop_oneof![(-3_i8..=3).prop_map(f32::from), Just(-0.0)];
    [coordinate.clone(), coordinate.clone(), coordinate]
}

fn of(points: &[[f32; 3]]) -> Aabb {
    let mut sum = Aabb::EMPTY;
    for point in points {
        sum.grow(*point);
    }
    sum
}

proptest! {
    /// Boxes hold exactly the least and greatest coordinates; unions preserve this.
    #[test]
    fn is_minima_and_maxima(
        a in prop::collection::vec(point(), 1..5),
        b in prop::collection::vec(point(), 0..5),
    ) {
        let all = [a.clone(), b.clone()].concat();
        let sum = of(&all);
        for axis in 0..3 {
            let least = all.iter().map(|p| p[axis]).fold(f32::INFINITY, f32::min);
            let most = all.iter().map(|p| p[axis]).fold(f32::NEG_INFINITY, f32::max);
            prop_assert_eq!((sum.min[axis], sum.max[axis]), (least, most));
            prop_assert_eq!(sum.extent(axis), most - least);
        }
        prop_assert_eq!(of(&a).union(&of(&b)), sum);
        prop_assert_eq!(of(&b).union(&of(&a)), sum);
        prop_assert_eq!(sum.union(&Aabb::EMPTY), sum);
        prop_assert_eq!(Aabb::EMPTY.union(&sum), sum);
    }

    /// Closed boxes overlap where, on every axis, neither begins after the other's end.
    #[test]
    fn touching_is_overlap(p in point(), q in point(), r in point(), s in point()) {
        let (a, b) = (of(&[p, q]), of(&[r, s]));
        let overlap = (0..3).all(|i| {
            let shared = |x: f32| (p[i].min(q[i])..=p[i].max(q[i])).contains(&x);
            shared(r[i].min(s[i])) || (r[i].min(s[i])..=r[i].max(s[i])).contains(&p[i].min(q[i]))
        });
        prop_assert_eq!(a.bounds().overlaps(&b.bounds()), overlap);
        prop_assert_eq!(b.bounds().overlaps(&a.bounds()), overlap);
        prop_assert!(!a.bounds().overlaps(&Aabb::EMPTY.bounds()));
    }
}

#[test]
fn area_of_a_box_of_one_by_two_by_three() {
    let box_ = of(&[[0.0; 3], [1.0, 2.0, 3.0]]);
    assert_eq!((box_.half_area(), box_.bounds().half_area()), (11.0, 11.0));
    assert_eq!((Aabb::EMPTY.half_area(), Aabb::EMPTY.bounds().half_area()), (0.0, 0.0));
}
