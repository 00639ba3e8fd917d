//! Where first contact is sought, and the poses at which the bodies are intersected from there on.
//!
//! A given pose may lie before the first touch, or so deep that one body is inside the other and
//! *no triangles cross*. So B is moved along the relative velocity (see [`crate::approach`]), from
//! where the plan-view hulls meet until they have parted for good: first contact is sought on all
//! of that way, continuously. From there on at most [`POSES_MAX`] poses are surveyed; where that
//! forces a larger step, the path says that it is coarse.
//!
//! It does not know triangles: `bvh` finds the first contact on a path, [`Path::survey`] says which
//! poses form the contact patch from there on.

use crate::approach::{Approach, ApproachError, REACH_M, ROUNDING_M, STANDSTILL_M_S};
use serde::Serialize;
use smallvec::SmallVec;

/// Greatest number of poses of a survey.
pub const POSES_MAX: usize = 16;
/// Finest and coarsest step (m) before the limit on poses coarsens it.
const STEP_M: [f64; 2] = [0.02, 0.10];
/// Zones and depth cover at most this travel after first contact (m).
const CRUSH_M: f64 = 0.6;
/// The contact patch covers this much travel after first contact (m).
pub(crate) const PATCH_M: f64 = 0.2;
/// Zones and depth cover this time after first contact (s), and at most [`CRUSH_M`].
const CRUSH_S: f64 = 0.05;
/// Two poses closer than this are one (m).
const SAME_M: f64 = 1e-9;

/// Whether and where the hulls of two bodies meet.
#[derive(Clone, Debug, PartialEq)]
pub enum Meeting {
    /// They never meet: no contact, proven without a job.
    Never(Apart),
    /// They are not apart within 10 m back, or overlap at standstill: refused. (Recordings may list
    /// the ego vehicle among the others.)
    AlreadyOverlapping,
    /// They meet; contact is to be sought along this path.
    Path(Path),
}

/// Why hulls never meet.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Apart {
    /// They pass each other, stand apart, or parted more than 10 m before the given pose.
    Passing,
}

/// The poses of a survey.
pub type Stops = SmallVec<[Stop; POSES_MAX + 2]>;

/// The way on which contact is sought, and how finely it is surveyed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Path {
    /// Where the hulls meet, but for rounding: before, nothing touches (m).
    pub from_m: f64,
    /// Where they have parted for good: from there on, nothing touches (m).
    pub to_m: f64,
    /// Distance between neighbours of a survey (m); the last may be nearer.
    pub step_m: f64,
    /// Whether the limit on poses made the step larger than it should be.
    pub coarse: bool,
    /// Closing speed (m/s).
    pub closing_m_s: f64,
}

/// A pose from first contact on, and what is asked there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stop {
    /// Travel (m).
    pub travel_m: f64,
    /// In f..=r: its hits with their supports form the patch.
    pub patch: bool,
    /// In f..=e: zones and parts hit count.
    pub zones: bool,
    /// The pose e: supports of its hits, if asked for, measure the depth.
    pub depth: bool,
}

/// Plans the poses for an approach.
///
/// # Errors
///
/// If the approach is not usable: [`Approach::check`].
pub fn plan(approach: &Approach) -> Result<Meeting, ApproachError> {
    approach.check()?;
    let closing = approach.closing_m_s;
    if closing < STANDSTILL_M_S {
        if approach.hulls_meet(0.0) {
            return Ok(Meeting::AlreadyOverlapping);
        }
        if closing <= 0.0 {
            return Ok(Meeting::Never(Apart::Passing));
        }
    }
    let start = approach.entry(0.0);
    if !approach.hulls_meet(start) || approach.exit() < -REACH_M {
        return Ok(Meeting::Never(Apart::Passing));
    }
    if start < -REACH_M {
        return Ok(Meeting::AlreadyOverlapping);
    }
    let (step_m, coarse) = step(approach);
    Ok(Meeting::Path(Path {
        from_m: start - ROUNDING_M,
        to_m: approach.exit().max(start) + ROUNDING_M,
        step_m,
        coarse,
        closing_m_s: closing,
    }))
}

impl Path {
    /// The path of bodies whose first contact is known to be at the given pose.
    ///
    /// # Errors
    ///
    /// If the approach is not usable: [`Approach::check`].
    pub fn from_contact(approach: &Approach) -> Result<Self, ApproachError> {
        approach.check()?;
        let closing_m_s = approach.closing_m_s;
        let (step_m, coarse) = step(approach);
        let to_m = approach.exit().max(0.0) + ROUNDING_M;
        Ok(Self { from_m: 0.0, to_m, step_m, coarse, closing_m_s })
    }
}

/// The step of a survey, and whether it had to grow.
fn step(approach: &Approach) -> (f64, bool) {
    let wanted = (0.5 * approach.smaller_extent()).clamp(STEP_M[0], STEP_M[1]);
    fit(PATCH_M.max(crush_m(approach.closing_m_s)), wanted, POSES_MAX - 2)
}

/// How far zones and depth reach after first contact, at a closing speed (m).
fn crush_m(closing_m_s: f64) -> f64 {
    CRUSH_M.min(CRUSH_S * closing_m_s)
}

/// The step of at least `wanted` that covers `length` in at most `steps`, and whether it had to
/// grow.
fn fit(length: f64, wanted: f64, steps: usize) -> (f64, bool) {
    let least = length / steps as f64;
    (wanted.max(least), least > wanted + SAME_M)
}

/// Travels from `start` in equal steps, and `end` itself; at least one.
fn grid(start: f64, end: f64, step: f64) -> SmallVec<[f64; POSES_MAX + 2]> {
    let mut travels: SmallVec<_> = (0..POSES_MAX)
        .map(|k| start + k as f64 * step + 0.0)
        .take_while(|s| *s < end - SAME_M)
        .collect();
    travels.push(end + 0.0);
    travels
}

impl Path {
    /// r: the end of the contact patch, given first contact at `first_m` (m).
    #[must_use]
    pub fn patch_end(&self, first_m: f64) -> f64 {
        first_m + PATCH_M
    }

    /// e: the end of the zones, and where depth is measured (m).
    #[must_use]
    pub fn crush_end(&self, first_m: f64) -> f64 {
        first_m + crush_m(self.closing_m_s)
    }

    /// The poses from first contact on: a grid with the path's step that starts at `first_m`, with
    /// r and e themselves among them, ascending, at most [`POSES_MAX`].
    #[must_use]
    pub fn survey(&self, first_m: f64) -> Stops {
        let (r, e) = (self.patch_end(first_m), self.crush_end(first_m));
        let end = r.max(e).max(first_m);
        // Two fewer steps than the limit allows leave room for r or e between grid poses.
        let (step, _) = fit(end - first_m, self.step_m, POSES_MAX - 2);
        let mut travels = grid(first_m, end, step);
        for milestone in [r, e] {
            match travels.iter_mut().find(|s| (**s - milestone).abs() <= SAME_M) {
                Some(same) => *same = milestone,
                None => travels.push(milestone),
            }
        }
        travels.sort_by(f64::total_cmp);
        travels
            .into_iter()
            .map(|travel_m| Stop {
                travel_m,
                patch: travel_m <= r,
                zones: travel_m <= e,
                depth: travel_m.to_bits() == e.to_bits(),
            })
            .collect()
    }
}

#[cfg(test)]
mod tests;
