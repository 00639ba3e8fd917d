//! The points of a contact: at most six, without repetition.

use crate::DVec3;

/// The maximum number of corners of the intersection: each edge bounds at most one side.
const POINTS: usize = 6;

/// The points whose convex hull is (nearly) the intersection of two triangles: at most six.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactPoints {
    points: [DVec3; POINTS],
    count: u8,
}

impl ContactPoints {
    /// No points yet.
    pub(super) const EMPTY: Self = Self { points: [DVec3::ZERO; POINTS], count: 0 };

    /// The points (m): without repetition, and none only if the triangles do not intersect.
    #[must_use]
    pub fn points(&self) -> &[DVec3] {
        &self.points[..usize::from(self.count)]
    }

    /// Adds a point unless it is present; a seventh cannot occur and would be dropped.
    pub(super) fn push(&mut self, point: DVec3) {
        if self.points().contains(&point) {
            return;
        }
        if let Some(free) = self.points.get_mut(usize::from(self.count)) {
            *free = point;
            self.count += 1;
        }
    }
}
