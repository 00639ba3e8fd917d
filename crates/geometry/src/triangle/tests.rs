//! Invariants of the test and of the contact that need no oracle. The oracle is in `tests/oracle`.

use super::exact::{kept, orient2d, orient3d};
use super::lattice::{Lattice, area};
use super::wide::{Magnitude, Wide};
use super::*;
use proptest::prelude::*;
use proptest::sample::select;

/// Coordinates that often coincide, line up or almost do; a few far outside any body.
fn coordinate() -> impl Strategy<Value = f64> {
    prop_oneof![
        6 => (-2_i8..=2).prop_map(f64::from),
        3 => -1.0..1.0_f64,
        1 => (-2_i8..=2, -50_i32..50).prop_map(|(x, e)| libm::scalbn(f64::from(x), e)),
        1 => (-2_i8..=2).prop_map(|x| f64::from(x) + f64::EPSILON),
    ]
}

fn point() -> impl Strategy<Value = DVec3> {
    [coordinate(), coordinate(), coordinate()].prop_map(DVec3::from_array)
}

fn triangle() -> impl Strategy<Value = Triangle> {
    [point(), point(), point()].prop_map(Triangle)
}

/// Every order of three corners.
const ORDERS: [[usize; 3]; 6] = [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]];

fn reordered(t: &Triangle, order: [usize; 3]) -> Triangle {
    Triangle(order.map(|i| t.0[i]))
}

/// The distance of a point from a triangle, rounded (m): to its plane if inside, else to its edges.
fn distance(t: &Triangle, p: DVec3) -> f64 {
    let [a, b, c] = t.0;
    let to_segment = |q: DVec3, r: DVec3| {
        let along = r - q;
        let length = along.length_squared();
        let share = if length > 0.0 { ((p - q).dot(along) / length).clamp(0.0, 1.0) } else { 0.0 };
        (q + along * share - p).length()
    };
    let edges = to_segment(a, b).min(to_segment(b, c)).min(to_segment(c, a));
    let normal = (b - a).cross(c - a);
    let inside =
        [(a, b), (b, c), (c, a)].iter().all(|(q, r)| (*r - *q).cross(p - *q).dot(normal) >= 0.0);
    if inside && normal.length() > 0.0 {
        edges.min((normal.dot(p - a) / normal.length()).abs())
    } else {
        edges
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2_000))]

    /// Neither the roles nor the order of corners matter.
    #[test]
    fn is_symmetric(a in triangle(), b in triangle(), p in select(&ORDERS), q in select(&ORDERS)) {
        let answer = intersect(&a, &b);
        prop_assert_eq!(intersect(&b, &a), answer);
        prop_assert_eq!(intersect(&reordered(&a, p), &reordered(&b, q)), answer);
    }

    /// Multiplying by powers of two, one per axis, preserves every bit of the problem.
    #[test]
    fn is_the_same_at_every_scale(
        a in triangle(),
        b in triangle(),
        scale in [-900_i32..900, -900_i32..900, -900_i32..900],
    ) {
        let scaled = |t: &Triangle| Triangle(t.0.map(|p| {
            let p = p.to_array();
            DVec3::from_array(core::array::from_fn(|i| libm::scalbn(p[i], scale[i])))
        }));
        prop_assert_eq!(intersect(&scaled(&a), &scaled(&b)), intersect(&a, &b));
    }

    /// A triangle meets itself, its corners, and what shares a corner.
    #[test]
    fn meets_itself(a in triangle(), p in point(), q in point(), i in 0_usize..3) {
        prop_assert!(intersect(&a, &a));
        prop_assert!(intersect(&a, &Triangle([a.0[i]; 3])));
        prop_assert!(intersect(&a, &Triangle([p, a.0[i], q])));
    }

    /// A contact exists exactly where the triangles meet, in both boxes, near both triangles.
    #[test]
    fn contact_is_on_both(a in triangle(), b in triangle()) {
        let contact = contact(&a, &b);
        prop_assert_eq!(contact.points().is_empty(), !intersect(&a, &b));
        let reach = a.0.iter().chain(&b.0).map(|p| p.abs().max_element()).fold(1.0, f64::max);
        for p in contact.points() {
            for t in [&a, &b] {
                let bounds = t.bounds();
                prop_assert!(p.cmpge(bounds.min).all() && p.cmple(bounds.max).all());
                prop_assert!(distance(t, *p) <= 1e-9 * reach, "{} from {:?}", p, t);
            }
        }
    }

    /// The adaptive predicates and the wide sum agree, so an error would have to affect both.
    #[test]
    fn adaptive_and_wide_signs_agree(a in point(), b in point(), c in point(), d in point()) {
        let points = [a, b, c, d];
        prop_assert_eq!(orient3d(points), Wide::orient3d(points).sign());
        let [p, q, r] = [a, b, c].map(|p| [p.x, p.y]);
        prop_assert_eq!(orient2d([p, q, r]), Wide::orient2d([p, q, r]).sign());
    }

    /// Where the corners are on a lattice, it agrees with the signs and fractions of the wide sum.
    #[test]
    fn lattice_and_wide_numbers_agree(
        a in triangle(),
        b in triangle(),
        far in point(),
        e in -60_i32..60,
    ) {
        let moved = |p: DVec3| (p + far.round()) * libm::scalbn(1.0, e);
        let [a, b] = [a, b].map(|t| Triangle(t.0.map(moved)));
        let ([a0, a1, a2], [b0, b1, b2]) = (&a.0, &b.0);
        let corners = [a0, a1, a2, b0, b1, b2];
        let (box_a, box_b) = (a.bounds(), b.bounds());
        let extent = box_a.max.max(box_b.max) - box_a.min.min(box_b.min);
        let Some(lattice) = Lattice::of(&corners, extent.max_element()) else { return Ok(()) };
        for [p, q, r, s, t] in [[0, 1, 2, 3, 4], [3, 4, 5, 0, 1], [0, 3, 1, 4, 2]] {
            let normal = lattice.normal([p, q, r]);
            let heights = [s, t].map(|end| lattice.height(&normal, p, end));
            let wide = [s, t].map(|end| Wide::orient3d([p, q, r, end].map(|i| *corners[i])));
            prop_assert_eq!(heights[0].sign(), wide[0].sign());
            let share = Magnitude::share(heights[0].magnitude(), heights[1].magnitude());
            let wide = Magnitude::share(wide[0].magnitude(), wide[1].magnitude());
            prop_assert_eq!(share.to_bits(), wide.to_bits());
            for (drop, n) in normal.iter().enumerate() {
                let projected = [p, q, r].map(|i| {
                    let (x, y) = kept(drop);
                    [corners[i][x], corners[i][y]]
                });
                prop_assert_eq!(n.signum() as Sign, Wide::orient2d(projected).sign());
                let whole = lattice.without(drop);
                prop_assert_eq!(area([whole[p], whole[q], whole[r]]), *n);
            }
        }
    }

    /// A NaN or an infinity gives some result: no panic, no endless loop.
    #[test]
    fn survives_what_is_not_finite(
        a in triangle(),
        b in triangle(),
        at in prop::collection::vec(
            (0_usize..18, select(&[f64::NAN, f64::INFINITY, -f64::INFINITY, f64::MAX])), 1..4),
    ) {
        let mut corners = [a, b];
        for (place, value) in at {
            corners[place / 9].0[place % 9 / 3][place % 3] = value;
        }
        let [a, b] = corners;
        prop_assert!(contact(&a, &b).points().len() <= 6);
        prop_assert_eq!(intersect(&a, &b), intersect(&a, &b));
    }
}

#[test]
fn a_hexagon_of_overlap_has_six_corners() {
    let corners = |y: f64| [(-3.0, -y), (3.0, -y), (0.0, 2.0 * y)];
    let star = |y: f64| Triangle(corners(y).map(|(x, y)| DVec3::new(x, y, 1.0)));
    let found = contact(&star(1.0), &star(-1.0));
    assert_eq!(found.points().len(), 6, "{found:?}");
    // y = ±1 are edges of one each; half-way up, at 1 and −1, the slanted edges cross them.
    for (x, y) in [(1.0, 1.0), (-1.0, 1.0), (2.0, 0.0), (-2.0, 0.0), (1.0, -1.0), (-1.0, -1.0)] {
        let corner = DVec3::new(x, y, 1.0);
        assert!(found.points().iter().any(|p| p.distance(corner) < 1e-15), "{corner}: {found:?}");
    }
}

#[test]
fn a_touch_is_one_point() {
    let flat = Triangle([DVec3::ZERO, DVec3::new(2.0, 0.0, 0.0), DVec3::new(0.0, 2.0, 0.0)]);
    let on = |x: f64, y: f64| {
        let tip = DVec3::new(x, y, 0.0);
        Triangle([tip, tip + DVec3::new(1.0, 0.0, 3.0), tip + DVec3::new(0.0, 1.0, 3.0)])
    };
    for (x, y) in [(0.5, 0.5), (1.0, 0.0), (1.0, 1.0), (0.0, 0.0)] {
        assert_eq!(contact(&flat, &on(x, y)).points(), &[DVec3::new(x, y, 0.0)]);
    }
    assert!(contact(&flat, &on(1.0, 1.0 + f64::EPSILON)).points().is_empty());
}
