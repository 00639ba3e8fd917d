//! Whether two triangles touch at a pose of a motion: the times at which that is tried.

use super::{RelativeMotion, TimeInterval};
use crate::sweep::{TOLERANCE_M, first_contact};
use crate::{Corners, Sweep, Triangle, triangle};

/// After the first contact of the straight motion, poses are tried so many nanometres later: the
/// straight motion is off by turning, and its contact by up to 1 nm.
const LATER: [f64; 4] = [0.0, 1.0, 256.0, 65536.0];

/// What is tried in a short interval: its begin, middle and end, and what follows from a sweep.
const TIMES: usize = 3 + LATER.len();

impl TimeInterval {
    /// The first of a few times up to `until_s` within this interval at which two triangles touch,
    /// exactly: [`triangle::intersect`] at the pose that [`RelativeMotion::pose_at`] returns.
    ///
    /// Tried are the begin, the middle and the end, the first contact of B's triangle as it moves
    /// along its chord without turning ([`first_contact`]), and shortly after that. A pure
    /// function; that it finds nothing proves nothing.
    #[must_use]
    pub fn first_touch(
        &self,
        motion: &RelativeMotion<'_>,
        a: &Corners,
        b: &Corners,
        until_s: f64,
    ) -> Option<f64> {
        let stored = Triangle::stored(a);
        let lasts_s = self.to_s - self.from_s;
        let mut times = [f64::INFINITY; TIMES];
        times[..3].copy_from_slice(&[self.from_s, self.from_s + lasts_s * 0.5, self.to_s]);
        if let Some((share, per_metre)) = self.swept(&stored, b) {
            for (time, later) in times[3..].iter_mut().zip(LATER) {
                *time = self.from_s + lasts_s * (share + per_metre * (later * TOLERANCE_M));
            }
        }
        times.sort_unstable_by(f64::total_cmp);
        let until_s = until_s.min(self.to_s);
        let mut tried = times.into_iter().take_while(|time_s| *time_s <= until_s);
        tried.find(|time_s| triangle::intersect(&stored, &motion.pose_at(*time_s).triangle(b)))
    }

    /// The first contact of B's triangle along its chord without turning: the share of the way that
    /// it has gone, and what a metre is of the way.
    fn swept(&self, a: &Triangle, b: &Corners) -> Option<(f64, f64)> {
        let [begin, end] = self.poses().map(|pose| pose.triangle(b).0);
        let moved = [0, 1, 2].map(|k| end[k] - begin[k]);
        let moved = ((moved[0] + moved[1]) + moved[2]) * (1.0 / 3.0);
        let length = libm::sqrt(moved.dot(moved));
        let sweep = Sweep::new(moved, 0.0, length).ok()?;
        let touch = first_contact(a, &Triangle(begin), &sweep)?;
        Some((touch.travel_m / length, 1.0 / length))
    }
}
