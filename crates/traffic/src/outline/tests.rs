//! Overlap against oracles that are slower and simpler: separating axes, sampled points.

use super::*;
use proptest::prelude::*;

fn place() -> impl Strategy<Value = Placed> {
    (-6.0..6.0, -6.0..6.0, -7.0..7.0).prop_map(|(x, y, yaw)| Placed { at: [x, y], yaw })
}

/// The gap between two convex polygons along the best of their edges' normals (m); negative: depth.
fn gap(a: &[[f64; 2]], b: &[[f64; 2]]) -> f64 {
    let along = |polygon: &[[f64; 2]], n: [f64; 2]| {
        let heights = polygon.iter().map(|p| p[0] * n[0] + p[1] * n[1]);
        heights.fold((f64::MAX, f64::MIN), |(low, high), h| (low.min(h), high.max(h)))
    };
    edges(a)
        .chain(edges(b))
        .map(|[p, q]| {
            let length = libm::hypot(q[0] - p[0], q[1] - p[1]);
            let n = [(q[1] - p[1]) / length, (p[0] - q[0]) / length];
            let ((l, h), (m, o)) = (along(a, n), along(b, n));
            (m - h).max(l - o)
        })
        .fold(f64::MIN, f64::max)
}

proptest! {
    #[test]
    fn rectangles_overlap_unless_an_axis_separates_them(
        a in (0.1..6.0, 0.1..4.0), b in (0.1..6.0, 0.1..4.0), p in place(), q in place(),
    ) {
        let (a, b) = (Outline::rectangle(a.0, a.1), Outline::rectangle(b.0, b.1));
        let polygon = |outline: &Outline, place| match &outline.placed(place)[0] {
            OutlinePart::Polygon(points) => points.clone(),
            OutlinePart::Circle(..) => unreachable!("rectangles are polygons"),
        };
        let gap = gap(&polygon(&a, p), &polygon(&b, q));
        prop_assume!(gap.abs() > 1e-9);
        prop_assert_eq!(overlap(&a, p, &b, q), gap < 0.0, "gap {}", gap);
        prop_assert_eq!(overlap(&b, q, &a, p), gap < 0.0);
    }

    /// An L is concave: a point of a grid that lies in both is never missed, and where the shapes
    /// are apart no point of the grid lies in both.
    #[test]
    fn concave_polygons_and_circles_share_what_points_they_share(
        p in place(), q in place(), radius in 0.2..2.0_f64,
    ) {
        let corners = vec![[0.0, 0.0], [4.0, 0.0], [4.0, 1.0], [1.0, 1.0], [1.0, 3.0], [0.0, 3.0]];
        let ell = Outline { parts: vec![OutlinePart::Polygon(corners)] };
        let ball = Outline { parts: vec![OutlinePart::Circle([0.5, -0.2], radius)] };
        let (OutlinePart::Polygon(points), OutlinePart::Circle(centre, _)) =
            (&ell.placed(p)[0], &ball.placed(q)[0]) else { unreachable!("as made") };
        // Points of the disc, and the nearest of the polygon's border to its centre.
        let ring = |r: f64, n: u32| {
            let turn = std::f64::consts::TAU * f64::from(n) / 64.0;
            [centre[0] + r * libm::cos(turn), centre[1] + r * libm::sin(turn)]
        };
        let shared = (0..=20).any(|k| {
            (0..64).any(|n| inside(ring(radius * f64::from(k) / 20.0, n), points))
        });
        let near = edges(points).any(|edge| distance(*centre, edge) < radius - 1e-9);
        let said = overlap(&ell, p, &ball, q);
        prop_assert!(said || !shared, "a shared point was missed");
        prop_assert!(!said || shared || near, "nothing is shared");
    }
}

#[test]
fn touching_counts_and_one_inside_the_other_too() {
    let placed_at = |x: f64| Placed { at: [x, 0.0], yaw: 0.0 };
    let square = Outline::rectangle(2.0, 2.0);
    assert!(overlap(&square, placed_at(0.0), &square, placed_at(2.0)));
    assert!(!overlap(&square, placed_at(0.0), &square, placed_at(2.000_001)));
    assert!(overlap(&square, placed_at(0.0), &Outline::rectangle(0.5, 0.5), placed_at(0.3)));
    let ball = Outline { parts: vec![OutlinePart::Circle([0.0; 2], 1.0)] };
    assert!(
        overlap(&ball, placed_at(0.0), &ball, placed_at(2.0))
            && !overlap(&ball, placed_at(0.0), &ball, placed_at(2.001))
    );
    assert!(overlap(&Outline::rectangle(9.0, 9.0), placed_at(0.0), &ball, placed_at(1.0)));
    assert!(ball.is_round() && ball.size() == [2.0; 2]);
}

#[test]
fn several_parts_have_one_box() {
    let parts = vec![
        OutlinePart::Circle([3.0, 0.0], 1.0),
        OutlinePart::Polygon(corners(2.0, 1.0, [-1.0, 0.0], 0.0)),
    ];
    let both = Outline { parts };
    assert_eq!(both.bounds(), [[-2.0, -1.0], [4.0, 1.0]]);
    assert_eq!((both.size(), both.middle()), ([6.0, 2.0], [1.0, 0.0]));
    let far = Placed { at: [0.0, 5.0], yaw: 0.0 };
    let up = Placed { at: [0.0, 1.2], yaw: 0.0 };
    let small = Outline::rectangle(0.5, 0.5);
    assert!(overlap(
        &both,
        Placed { at: [-3.0, 0.9], yaw: 0.0 },
        &small,
        Placed { at: [0.0, 0.9], yaw: 0.0 }
    ));
    assert!(!overlap(&both, Placed { at: [0.0; 2], yaw: 0.0 }, &small, far));
    assert!(!overlap(&both, Placed { at: [0.0; 2], yaw: 0.0 }, &small, up), "between the parts");
}
