//! The exact closed triangle–triangle test and the contact points of a hit.
//!
//! Two triangles lie in two planes. Where the planes cross, each triangle cuts the common line in
//! an interval, and the triangles meet if the intervals do; which end comes first is given by the
//! sign of one 3×3 determinant (P. Guigue, O. Devillers, *Fast and Robust Triangle-Triangle Overlap
//! Test Using Orientation Predicates*, Journal of Graphics Tools 8(1), 2003). So the whole test
//! reduces to signs:
//!
//! ```text
//! boxes --> sides of the two planes --> two edge signs            (crossing: nearly always)
//!                 \--> all sides 0: exact, by dimension           (planar: coplanar, degenerate)
//! each sign: f64 with an error bound (orient) --> whole numbers (lattice), where they suffice
//!                                             \--> adaptive (exact) --> for any range (wide)
//! ```
//!
//! # Invariants
//!
//! - [`intersect`] is exact for all finite coordinates, denormal and huge ones too: no sign is
//!   decided by a rounded value within its error bound. `tests/oracle` compares with rational
//!   arithmetic.
//! - A degenerate triangle is tested as the segment or point it is.
//! - [`contact()`] has at least one point for every pair that intersects, and none outside the
//!   intersection of the two triangles' boxes.
//!
//! This module does not depend on trees or SIMD; it is the reference for [`crate::patch`].

mod contact;
mod crossing;
mod exact;
mod lattice;
mod orient;
mod planar;
pub mod sweep;
#[cfg(test)]
mod tests;
mod upward;
mod wide;

use crate::{Bounds, Corners, DVec3};
use crossing::Crossing;
use orient::Orient;
use planar::{Flat, Piercing};

pub use contact::ContactPoints;
pub use upward::{RayCrossing, cross_upward};

/// A corner of a pair: one of [`A`] or of [`B`].
type Corner = usize;

/// A's corners.
const A: [Corner; 3] = [0, 1, 2];

/// B's corners.
const B: [Corner; 3] = [3, 4, 5];

/// −1, 0 or 1.
type Sign = i8;

/// A triangle in the frame of the test, f64, in metres. Any three points: it may be degenerate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Triangle(pub [DVec3; 3]);

impl Triangle {
    /// A stored triangle of A, which is already in A's frame; f64 holds f32 exactly.
    #[must_use]
    #[inline]
    pub fn stored(corners: &Corners) -> Self {
        let [a, b, c] = *corners;
        let point = |[x, y, z]: [f32; 3]| DVec3::new(x.into(), y.into(), z.into());
        Self([point(a), point(b), point(c)])
    }

    /// The exact bounding box.
    #[must_use]
    pub fn bounds(&self) -> Bounds {
        let [a, b, c] = self.0;
        Bounds { min: a.min(b).min(c), max: a.max(b).max(c) }
    }
}

/// Whether two closed triangles share a point: touching counts, coplanar overlap counts.
///
/// Exact for any finite f64 coordinates. Symmetric, and independent of the order of corners. If a
/// coordinate is NaN or infinite, the result is unspecified.
#[must_use]
pub fn intersect(a: &Triangle, b: &Triangle) -> bool {
    let (box_a, box_b) = (a.bounds(), b.bounds());
    if !box_a.overlaps(&box_b) {
        return false;
    }
    let orient = Orient::of([a, b], [&box_a, &box_b]);
    let clear = match Sides::certain(&orient) {
        // Neighbours on one surface, or equal bodies in one position: the common case of doubt.
        Err(_) if orient.share_a_corner() => return true,
        Err(doubtful) => doubtful.resolved(&orient),
        Ok(position) => position,
    };
    match clear {
        Position::Apart => false,
        Position::Crossing(crossing) => crossing.meet(&orient),
        Position::Piercing(piercing) => piercing.meet(&orient),
        Position::Flat(flat) => flat.meet(),
    }
}

/// The contact of two triangles that [`intersect`]; without points if they do not.
///
/// The points are the end points of the common segment, the corners of the overlap polygon of
/// coplanar triangles, or the point of touch. Which edges they lie on is decided exactly; their
/// coordinates are rounded: the error is a few parts in 10¹⁰ of the edge's length, even where the
/// planes are nearly parallel, and a few ulps of the coordinates. Every point lies in the
/// intersection of the two triangles' boxes. The bits depend on the input alone.
#[must_use]
pub fn contact(a: &Triangle, b: &Triangle) -> ContactPoints {
    let (box_a, box_b) = (a.bounds(), b.bounds());
    let mut contact = ContactPoints::EMPTY;
    if !box_a.overlaps(&box_b) {
        return contact;
    }
    let (low, high) = (box_a.min.max(box_b.min), box_a.max.min(box_b.max));
    let mut push = |point: DVec3| contact.push(point.max(low).min(high));
    let orient = Orient::of([a, b], [&box_a, &box_b]);
    match Sides::certain(&orient).unwrap_or_else(|doubtful| doubtful.resolved(&orient)) {
        Position::Apart => {}
        Position::Crossing(crossing) => crossing.ends(&orient, &mut push),
        Position::Piercing(piercing) => piercing.point(&orient, &mut push),
        Position::Flat(flat) => flat.corners(&orient, &mut push),
    }
    contact
}

/// The position of two triangles relative to each other: what remains to be decided.
enum Position {
    /// One lies strictly on one side of the other's plane.
    Apart,
    /// Two proper triangles in planes that cross in a line; each reaches that line.
    Crossing(Crossing),
    /// A proper triangle, and a segment whose ends are not both in its plane nor on one side of it.
    Piercing(Piercing),
    /// Everything in one plane, on one line, or in one point.
    Flat(Flat),
}

/// On which side of the other's plane the corners lie, as far as f64 can tell: 0 means undecided.
struct Sides {
    of_a: [Sign; 3],
    of_b: [Sign; 3],
}

impl Sides {
    /// The position, if f64 decides it.
    #[inline]
    fn certain(orient: &Orient<'_>) -> Result<Position, Self> {
        let of_a = orient.certain_sides(B, A);
        if one_side(of_a) {
            return Ok(Position::Apart);
        }
        let of_b = orient.certain_sides(A, B);
        if one_side(of_b) {
            return Ok(Position::Apart);
        }
        if of_a.contains(&0) || of_b.contains(&0) {
            return Err(Self { of_a, of_b });
        }
        Ok(Position::Crossing(Crossing::new(of_a, of_b)))
    }

    /// The position, with undecided sides computed exactly.
    #[cold]
    fn resolved(&self, orient: &Orient<'_>) -> Position {
        let exact = |certain: [Sign; 3], plane: [Corner; 3], points: [Corner; 3]| {
            if certain.contains(&0) { orient.exact().sides(plane, points) } else { certain }
        };
        let of_a = exact(self.of_a, B, A);
        if one_side(of_a) {
            return Position::Apart;
        }
        // All in B's plane, or B is degenerate and has no plane.
        if of_a == [0; 3] {
            return planar::position(orient);
        }
        let of_b = exact(self.of_b, A, B);
        if one_side(of_b) {
            return Position::Apart;
        }
        if of_b == [0; 3] {
            return planar::position(orient);
        }
        Position::Crossing(Crossing::new(of_a, of_b))
    }
}

/// Whether all three are strictly on one side.
fn one_side(sides: [Sign; 3]) -> bool {
    let [p, q, r] = sides;
    p != 0 && p == q && p == r
}
