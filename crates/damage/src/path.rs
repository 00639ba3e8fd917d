//! The depths at which the bodies are intersected from first contact on.
//!
//! D(k+½)/6, k = 0…5, beyond first contact along the relative velocity, without turning. As for the
//! plane of the contact ([`crate::plane`]) D is at most [`DEPTH_MAX_M`] and no more than either
//! body measures, but here with mirrors and all, of which outlines know nothing. The union of the
//! hit sets there says which zones and parts are engaged, and how far the patch reaches.

use crate::approach::Approach;
use crate::plane::{DEPTH_MAX_M, DEPTHS};
use smallvec::SmallVec;

/// How many of the first depths form the patch: where all triangles press into each other, they say
/// nothing of the place of a contact.
const PATCH: usize = 2;

/// The depths of a survey.
pub type Stops = SmallVec<[Stop; DEPTHS]>;

/// A depth, and what is asked there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stop {
    /// Travel beyond first contact (m).
    pub travel_m: f64,
    /// Its hits, with where they are, form the patch; of the others only zones and parts count.
    pub patch: bool,
}

/// The depths of an approach.
#[must_use]
pub fn survey(approach: &Approach) -> Stops {
    let depth_m = approach.extent_up_to(DEPTH_MAX_M);
    let stop =
        |k: usize| Stop { travel_m: depth_m * (k as f64 + 0.5) / DEPTHS as f64, patch: k < PATCH };
    (0..DEPTHS).map(stop).collect()
}
