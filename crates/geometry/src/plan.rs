//! Outlines in plan: how near bodies come to each other, seen from above.
//!
//! A [`ConvexOutline`] holds a body: it is the intersection of the half planes that
//! its supports bound, in equal steps of angle. A distance between two is thus never more than that
//! of the bodies' hulls, and less by at most a tenth of a side of either hull. For people and
//! flags; nothing is decided by it.

use crate::Pose;

/// Sides of an outline: every 10°.
const SIDES: usize = 36;
/// Far above the rounding of squares of distances within 1000 km, and far below what matters (m²).
const ROUNDING_M2: f64 = 1e-9;
/// Shorter edges are none (m).
const EDGE_MIN_M: f64 = 1e-9;

/// A convex polygon around a body in plan, in the frame of the body.
#[derive(Clone, Debug, PartialEq)]
pub struct ConvexOutline {
    /// Counter-clockwise (m).
    corners: Vec<[f64; 2]>,
    /// The greatest distance of a corner from the origin (m).
    radius_m: f64,
    bounds: Bounds,
}

/// A convex polygon in the plane of the world.
#[derive(Clone, Debug, PartialEq)]
pub struct PlacedOutline {
    /// Counter-clockwise (m).
    corners: Vec<[f64; 2]>,
}

/// A parallelogram around corners.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Bounds {
    /// (m).
    middle: [f64; 2],
    /// From the middle to the middles of two sides that meet (m).
    half_axes: [[f64; 2]; 2],
}

impl Bounds {
    fn around(corners: &[[f64; 2]]) -> Self {
        let ends = [0, 1].map(|axis| {
            let along = corners.iter().map(|corner| corner[axis]);
            along.fold([f64::INFINITY, f64::NEG_INFINITY], |[lo, hi], x| [lo.min(x), hi.max(x)])
        });
        let [x, y] = ends.map(|[lo, hi]| 0.5 * (hi - lo));
        Self { middle: ends.map(|[lo, hi]| 0.5 * (lo + hi)), half_axes: [[x, 0.0], [0.0, y]] }
    }

    fn placed(&self, pose: &Pose) -> Self {
        let half_axes = self.half_axes.map(|axis| turned(pose, axis));
        Self { middle: placed(pose, self.middle), half_axes }
    }
}

/// A direction in plan, in the world.
fn turned(pose: &Pose, [x, y]: [f64; 2]) -> [f64; 2] {
    let [[a, b, _], [c, d, _], _] = pose.rotation;
    [a * x + b * y, c * x + d * y]
}

/// A point in plan, in the world (m).
fn placed(pose: &Pose, point: [f64; 2]) -> [f64; 2] {
    let [x, y] = turned(pose, point);
    [x + pose.translation[0], y + pose.translation[1]]
}

impl ConvexOutline {
    /// The outline of a body in its own frame, given the greatest coordinate (m) of any of its
    /// points along a horizontal unit vector, which is asked of neighbours in turn.
    #[must_use]
    pub fn of(mut support: impl FnMut([f64; 2]) -> f64) -> Self {
        let side = |i: usize| {
            let (sin, cos) = libm::sincos((360.0 / SIDES as f64 * i as f64).to_radians());
            ([cos, sin], support([cos, sin]))
        };
        let sides: Vec<_> = (0..SIDES).map(side).collect();
        // Where two neighbouring sides meet. Supports of one body keep these in order.
        let corner = |i: usize| {
            let ([a, b], s) = sides[i];
            let ([c, d], t) = sides[(i + 1) % SIDES];
            let area = a * d - b * c;
            [(s * d - t * b) / area, (t * a - s * c) / area]
        };
        let corners: Vec<[f64; 2]> = (0..SIDES).map(corner).collect();
        let radius_m = corners.iter().map(|[x, y]| libm::sqrt(x * x + y * y)).fold(0.0, f64::max);
        let bounds = Bounds::around(&corners);
        Self { corners, radius_m, bounds }
    }

    /// The outline in the world, of a body that stands upright or nearly so.
    #[must_use]
    pub fn placed(&self, pose: &Pose) -> PlacedOutline {
        PlacedOutline { corners: self.corners.iter().map(|c| placed(pose, *c)).collect() }
    }

    /// Its corners (m), counter-clockwise.
    #[must_use]
    pub fn corners(&self) -> &[[f64; 2]] {
        &self.corners
    }

    /// The greatest distance of a corner from the origin of the body's frame (m).
    #[must_use]
    pub fn radius_m(&self) -> f64 {
        self.radius_m
    }

    /// How far apart two outlines are at least (m), each at its pose: the greatest gap between the
    /// boxes around them, along a side of either or along the line through their middles. Never
    /// more than [`PlacedOutline::distance_m`] within 1000 km, rounding included; 0 where no gap is
    /// found.
    #[must_use]
    pub fn apart_at_least_m(&self, other: &Self, [pose, far]: [&Pose; 2]) -> f64 {
        // Far above the rounding within 1000 km, and far below what matters (m).
        const MARGIN_M: f64 = 1e-6;
        let [a, b] = [self.bounds.placed(pose), other.bounds.placed(far)];
        let way = [b.middle[0] - a.middle[0], b.middle[1] - a.middle[1]];
        let axes = a.half_axes.into_iter().chain(b.half_axes).chain([way]);
        let gaps = axes.map(|axis| {
            let along = |v: [f64; 2]| (axis[0] * v[0] + axis[1] * v[1]).abs();
            let [of_a, of_b] = [&a, &b].map(|of| of.half_axes.map(along).iter().sum::<f64>());
            (along(way) - of_a - of_b) / libm::sqrt(axis[0] * axis[0] + axis[1] * axis[1])
        });
        // An axis of no length has no gap: `max` ignores it.
        (gaps.fold(0.0, f64::max) - MARGIN_M).max(0.0)
    }
}

impl PlacedOutline {
    /// The outline, moved (m).
    #[must_use]
    pub fn moved(&self, by: [f64; 2]) -> Self {
        let corners = self.corners.iter().map(|c| [c[0] + by[0], c[1] + by[1]]).collect();
        Self { corners }
    }

    /// The distance to another outline (m); 0 where they overlap.
    #[must_use]
    pub fn distance_m(&self, other: &Self) -> f64 {
        if self.is_over(other) {
            return 0.0;
        }
        self.reach(other).min(other.reach(self))
    }

    fn edges(&self) -> impl Iterator<Item = [[f64; 2]; 2]> {
        let next = self.corners.iter().cycle().skip(1);
        self.corners.iter().zip(next).map(|(a, b)| [*a, *b])
    }

    /// Whether two outlines share a point: no edge of either has the other one wholly outside.
    fn is_over(&self, other: &Self) -> bool {
        // Where several sides meet in one point, rounding leaves edges of no direction.
        let is_long = |[x, y]: [f64; 2]| x * x + y * y > EDGE_MIN_M * EDGE_MIN_M;
        let parts = |a: &Self, b: &Self| {
            a.edges().any(|[p, q]| {
                let normal = [q[1] - p[1], p[0] - q[0]];
                let along = |c: &[f64; 2]| normal[0] * (c[0] - p[0]) + normal[1] * (c[1] - p[1]);
                is_long(normal) && b.corners.iter().all(|corner| along(corner) > 0.0)
            })
        };
        !parts(self, other) && !parts(other, self)
    }

    /// The least distance of a corner of `other` from an edge (m).
    ///
    /// Along the line through both middles, an edge and a corner are no nearer than their
    /// projections, so most of the pairs are left out. The margin is far above the rounding of
    /// either: the result is that of all pairs, bit for bit.
    fn reach(&self, other: &Self) -> f64 {
        const MARGIN: f64 = 1.0 + 1e-9;
        let (from, to) = (self.middle(), other.middle());
        let way = [to[0] - from[0], to[1] - from[1]];
        let length = libm::sqrt(way[0] * way[0] + way[1] * way[1]);
        // Where both middles are in one place, nothing is left out.
        let u = if length > 0.0 { way.map(|x| x / length) } else { [0.0; 2] };
        let along = |c: &[f64; 2]| u[0] * (c[0] - from[0]) + u[1] * (c[1] - from[1]);
        let farthest = |[p, q]: &[[f64; 2]; 2]| along(p).max(along(q));
        let corners: Vec<_> = other.corners.iter().map(|c| (along(c), *c)).collect();
        let nearest = corners.iter().map(|(at, _)| *at).fold(f64::INFINITY, f64::min);
        let mut edges: Vec<_> = self.edges().map(|edge| (farthest(&edge), edge)).collect();
        // What is near makes the rest far.
        edges.sort_unstable_by(|a, b| b.0.total_cmp(&a.0));
        let mut least = f64::INFINITY;
        let is_far = |gap: f64, least: f64| gap > 0.0 && gap * gap > least * MARGIN + ROUNDING_M2;
        for (end, edge) in edges {
            // Of those that follow, too.
            if is_far(nearest - end, least) {
                break;
            }
            for (at, corner) in &corners {
                if !is_far(at - end, least) {
                    least = least.min(square_to_edge(*corner, edge));
                }
            }
        }
        libm::sqrt(least)
    }

    /// The mean of its corners (m).
    fn middle(&self) -> [f64; 2] {
        let share = 1.0 / self.corners.len() as f64;
        let sum = |axis: usize| self.corners.iter().map(|corner| corner[axis]).sum::<f64>();
        [share * sum(0), share * sum(1)]
    }
}

/// The convex hull of points, counter-clockwise, without points on its sides (A. M. Andrew 1979).
/// `points` ascend along x, then y, none twice; `turns_left` says whether the third lies to the
/// left of the way from the first to the second.
pub fn hull<P: Copy>(points: &[P], turns_left: impl Fn(P, P, P) -> bool) -> Vec<P> {
    let chain = |points: &mut dyn Iterator<Item = &P>| {
        let mut chain: Vec<P> = Vec::new();
        for &p in points {
            // Each turn removes a point.
            while let [.., a, b] = chain[..]
                && !turns_left(a, b, p)
            {
                chain.pop();
            }
            chain.push(p);
        }
        chain.pop();
        chain
    };
    let mut hull = chain(&mut points.iter());
    hull.extend(chain(&mut points.iter().rev()));
    hull
}

/// [`hull`] of points in any order (m).
#[must_use]
pub fn hull_of(mut points: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    points.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    points.dedup();
    hull(&points, |a, b, p| (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]) > 0.0)
}

/// The distance of a point from a segment (m).
#[must_use]
pub fn distance_m(point: [f64; 2], segment: [[f64; 2]; 2]) -> f64 {
    square_to_edge(point, segment).sqrt()
}

/// The square of the distance of a point from a segment (m²).
fn square_to_edge(point: [f64; 2], [p, q]: [[f64; 2]; 2]) -> f64 {
    let (d, w) = ([q[0] - p[0], q[1] - p[1]], [point[0] - p[0], point[1] - p[1]]);
    let length = d[0] * d[0] + d[1] * d[1];
    let share =
        if length > 0.0 { ((w[0] * d[0] + w[1] * d[1]) / length).clamp(0.0, 1.0) } else { 0.0 };
    let off = [w[0] - share * d[0], w[1] - share * d[1]];
    off[0] * off[0] + off[1] * off[1]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Rng;

    const HERE: Pose = Pose::IDENTITY;

    /// A box of a length and a width about the origin.
    fn cuboid(length: f64, width: f64) -> ConvexOutline {
        ConvexOutline::of(|[x, y]| 0.5 * (x.abs() * length + y.abs() * width))
    }

    #[test]
    fn a_box_keeps_its_corners_and_its_distances() {
        let car = cuboid(4.0, 2.0);
        assert!((car.radius_m() - 5.0_f64.sqrt()).abs() < 1e-9);
        let (car, small) = (car.placed(&HERE), cuboid(0.1, 0.1).placed(&HERE));
        let ahead = cuboid(4.0, 2.0).placed(&Pose::from_degrees(0.0, 0.0, 0.0, [7.0, 0.5, 0.0]));
        assert!((car.distance_m(&ahead) - 3.0).abs() < 1e-9);
        let turned = cuboid(4.0, 2.0).placed(&Pose::from_degrees(90.0, 0.0, 0.0, [7.0, 0.5, 0.0]));
        assert!((car.distance_m(&turned) - 4.0).abs() < 1e-9);
        let corner = car.moved([5.0, 4.0]);
        assert!((car.distance_m(&corner) - 5.0_f64.sqrt()).abs() < 1e-9);
        assert_eq!(car.distance_m(&car.moved([3.9, 1.9])), 0.0);
        assert_eq!(car.distance_m(&small), 0.0, "one inside the other");
    }

    /// What is left out decides nothing.
    #[test]
    fn the_distance_is_the_least_over_all_pairs_of_corners_and_edges() {
        let mut rng = Rng::new(11);
        let (mut apart, mut near) = (0, 0);
        for _ in 0..3_000 {
            let of = [0, 1].map(|_| cuboid(rng.between(0.05, 15.0), rng.between(0.05, 3.0)));
            let far = [1.0, 10.0, 1e5][rng.below(3) as usize];
            let poses = [0, 1].map(|_| {
                let at = [rng.between(-far, far), rng.between(-far, far), 0.0];
                let [pitch, roll] = [0, 1].map(|_| rng.between(-80.0, 80.0));
                Pose::from_degrees(rng.between(0.0, 360.0), pitch, roll, at)
            });
            let [a, b] = [0, 1].map(|i| of[i].placed(&poses[i]));
            let all = |a: &PlacedOutline, b: &PlacedOutline| {
                let squares = a
                    .edges()
                    .flat_map(|edge| b.corners.iter().map(move |c| square_to_edge(*c, edge)));
                libm::sqrt(squares.fold(f64::INFINITY, f64::min))
            };
            let expected = if a.is_over(&b) { 0.0 } else { all(&a, &b).min(all(&b, &a)) };
            assert_eq!(a.distance_m(&b).to_bits(), expected.to_bits());
            assert_eq!(a.reach(&b).to_bits(), all(&a, &b).to_bits());
            apart += u32::from(expected > 0.0);
            let at_least_m = of[0].apart_at_least_m(&of[1], poses.each_ref());
            assert!(at_least_m <= expected, "{at_least_m} {expected}");
            // Boxes are seldom much nearer: their corners are those of the outlines.
            near += u32::from(expected > 0.0 && at_least_m > 0.9 * expected);
        }
        assert!(near > 300, "{near} of {apart}");
        assert!(apart > 500, "{apart}");
    }

    #[test]
    fn a_hull_holds_all_points_and_has_no_corner_on_a_side() {
        let grid = (0..25).map(|i| [f64::from(i % 5), f64::from(i / 5)]).collect();
        assert_eq!(hull_of(grid), [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]]);
        let mut rng = Rng::new(3);
        for _ in 0..50 {
            let points: Vec<[f64; 2]> =
                (0..20).map(|_| [rng.between(-1.0, 1.0), rng.between(-1.0, 1.0)]).collect();
            let hull = hull_of(points.clone());
            for (a, b) in hull.iter().zip(hull.iter().cycle().skip(1)) {
                let off =
                    |p: &[f64; 2]| (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]);
                assert!(points.iter().all(|p| off(p) >= -1e-15), "{hull:?}");
            }
        }
    }

    #[test]
    fn it_is_never_farther_than_points_of_the_bodies_and_hardly_nearer() {
        let mut rng = Rng::new(7);
        let mut points = || -> Vec<[f64; 2]> {
            (0..40).map(|_| [rng.between(-2.0, 2.0), rng.between(-1.0, 1.0)]).collect()
        };
        for turn in 0..60 {
            let (a, b) = (points(), points());
            let outline = |points: &[[f64; 2]]| {
                ConvexOutline::of(|[x, y]| {
                    points.iter().map(|p| p[0] * x + p[1] * y).fold(f64::NEG_INFINITY, f64::max)
                })
            };
            let pose = Pose::from_degrees(6.0 * f64::from(turn), 0.0, 0.0, [5.5, 0.3, 0.0]);
            let far = outline(&b).placed(&pose);
            let gap = outline(&a).placed(&HERE).distance_m(&far);
            let [[c, s, _], [d, e, _], _] = pose.rotation;
            let placed = b.iter().map(|p| [c * p[0] + s * p[1] + 5.5, d * p[0] + e * p[1] + 0.3]);
            let placed: Vec<[f64; 2]> = placed.collect();
            // Separated by at least the gap of the supports along every direction.
            let along = |x: f64, y: f64| {
                let most = a.iter().map(|p| p[0] * x + p[1] * y).fold(f64::MIN, f64::max);
                placed.iter().map(|p| p[0] * x + p[1] * y).fold(f64::MAX, f64::min) - most
            };
            let true_gap = (0..3600)
                .map(|i| libm::sincos(f64::from(i) * 0.1_f64.to_radians()))
                .map(|(sin, cos)| along(cos, sin))
                .fold(0.0, f64::max);
            assert!(gap <= true_gap + 1e-3 && gap >= true_gap - 0.1, "{gap} {true_gap}");
        }
    }
}
