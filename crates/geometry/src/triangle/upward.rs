//! How a ray straight up meets a triangle: what counting crossings needs.
//!
//! A point lies inside a closed surface if a ray from it crosses the surface an odd number of
//! times. A ray that meets an edge or a corner would be counted by each triangle there. So it is
//! moved sideways by (ε, ε²) for an infinitely small ε, which leaves no edge under it: the method
//! of H. Edelsbrunner and E. P. Mücke, *Simulation of Simplicity: A Technique to Cope with
//! Degenerate Cases in Geometric Algorithms*, ACM Transactions on Graphics 9(1), 1990. Moved so
//! little, a point that is not on the surface stays on its side of it.
//!
//! Seen from above, the moved point is on that side of an edge which the exact determinant says;
//! where it is 0, that of the first derivative that is not: by x, and else by y.

use super::exact::{Point2, orient2d, orient3d};
use super::{Sign, Triangle};
use crate::DVec3;

/// How a ray straight up meets a triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RayCrossing {
    /// It passes by, or the triangle is below its start.
    Misses,
    /// It starts on the triangle.
    Starts,
    /// It crosses the triangle, whose normal points up: its corners turn counter-clockwise, seen
    /// from above.
    Leaves,
    /// It crosses the triangle, whose normal points down.
    Enters,
}

/// How the ray from `point` towards greater z meets `triangle`, in one frame. Exact for any finite
/// coordinates.
///
/// The ray is moved sideways by an infinitely small amount, the same for all triangles: it never
/// meets an edge, and of the triangles around one that it would meet it crosses those that the
/// moved ray does. A triangle that is degenerate, or vertical, is never crossed; a point on it is
/// not found to be there.
#[must_use]
pub fn cross_upward(point: DVec3, triangle: &Triangle) -> RayCrossing {
    let bounds = triangle.bounds();
    let is_below = point.z <= bounds.max.z
        && (bounds.min.x..=bounds.max.x).contains(&point.x)
        && (bounds.min.y..=bounds.max.y).contains(&point.y);
    if !is_below {
        return RayCrossing::Misses;
    }
    let corners = triangle.0;
    let [a, b, c] = corners.map(|corner| [corner.x, corner.y]);
    let p = [point.x, point.y];
    let turn = side(a, b, p);
    if turn == 0 || side(b, c, p) != turn || side(c, a, p) != turn {
        return RayCrossing::Misses;
    }
    // Above the plane is where the normal points, if that points up.
    match orient3d([corners[0], corners[1], corners[2], point]) * turn {
        0 => RayCrossing::Starts,
        1 => RayCrossing::Misses,
        _ if turn > 0 => RayCrossing::Leaves,
        _ => RayCrossing::Enters,
    }
}

/// On which side of the line from a to b the moved p lies: 1 for the left, 0 only if a is b.
fn side(a: Point2, b: Point2, p: Point2) -> Sign {
    let sign_of = |from: f64, to: f64| Sign::from(from < to) - Sign::from(from > to);
    match orient2d([a, b, p]) {
        0 => match sign_of(b[1], a[1]) {
            0 => sign_of(a[0], b[0]),
            by_x => by_x,
        },
        sign => sign,
    }
}

#[cfg(test)]
mod tests {
    //! A ray crosses what one that is really moved crosses, at every scale.

    use super::*;
    use proptest::prelude::*;

    /// On whole numbers up to 4, a shift by 2⁻¹⁰ and 2⁻²⁰ does what an infinitely small one does:
    /// areas are whole numbers, sides of triangles at most 8. All of this is exact in f64.
    fn moved(point: DVec3, triangle: &Triangle) -> RayCrossing {
        const SHIFT: f64 = 1.0 / 1024.0;
        let [a, b, c] = triangle.0;
        let p = point + DVec3::new(SHIFT, SHIFT * SHIFT, 0.0);
        let area = |q: DVec3, r: DVec3| (r - q).cross(p - q).z;
        let areas = [area(a, b), area(b, c), area(c, a)];
        let turns_left = areas.iter().all(|area| *area > 0.0);
        if !turns_left && !areas.iter().all(|area| *area < 0.0) {
            return RayCrossing::Misses;
        }
        let normal = (b - a).cross(c - a);
        let above = normal.dot(point - a) * normal.z;
        match (above < 0.0, above == 0.0, turns_left) {
            (true, _, true) => RayCrossing::Leaves,
            (true, _, false) => RayCrossing::Enters,
            (_, is_on, _) => {
                if is_on {
                    RayCrossing::Starts
                } else {
                    RayCrossing::Misses
                }
            }
        }
    }

    fn point() -> impl Strategy<Value = DVec3> {
        prop::array::uniform3((-4_i8..=4).prop_map(f64::from)).prop_map(DVec3::from_array)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(5_000))]

        #[test]
        fn a_ray_crosses_what_a_moved_one_does(
            p in point(), corners in [point(), point(), point()], scale in -300_i32..300,
        ) {
            let triangle = Triangle(corners);
            let found = cross_upward(p, &triangle);
            prop_assert_eq!(found, moved(p, &triangle));
            // Whatever the unit: here neither the lattice nor the adaptive predicates suffice.
            let scaled = |p: DVec3| p * libm::scalbn(1.0, scale);
            prop_assert_eq!(cross_upward(scaled(p), &Triangle(corners.map(scaled))), found);
            // Turned over, it is crossed the other way.
            let [a, b, c] = corners;
            let turned = match found {
                RayCrossing::Leaves => RayCrossing::Enters,
                RayCrossing::Enters => RayCrossing::Leaves,
                other => other,
            };
            prop_assert_eq!(cross_upward(p, &Triangle([b, a, c])), turned);
            prop_assert_eq!(cross_upward(p, &Triangle([b, c, a])), found);
        }
    }
}
