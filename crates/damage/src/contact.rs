//! What a contact is like: its plane, and the patch that the bodies' triangles make of it.
//!
//! The plane comes from outlines ([`crate::plane`]), so it is known before any job. The patch and
//! its zones come from hit sets; they are computed from supports, so they do not depend on the
//! mesh. They are shown, and lift ranges; no nominal figure depends on them.
//!
//! It does not know masses or persons.

use crate::approach::{Approach, HORIZONTAL, QUARTER, UP, opposite};
use crate::evidence::Evidence;
use crate::interval::Interval;
use crate::path::survey;
use crate::plane::{Plane, PlaneOrigin, Ride};
use schemars::JsonSchema;
use serde::Serialize;

/// The contact of one candidate, as far as it is known. Lengths in metres.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct ContactPatch {
    /// What makes the plane.
    pub origin: PlaneOrigin,
    /// Normal of the plane, from A to B, A's frame.
    pub normal: [f64; 3],
    /// Its angle from u, −180 to 180 degrees, positive to the left of u.
    pub normal_degrees: f64,
    /// The point of contact, A's frame.
    pub centre_m: [f64; 3],
    /// Which party has the long flat face that is struck, if one is: 0 for A, 1 for B.
    pub long_face_of: Option<usize>,
    /// How A and B are met in height.
    pub rides: [Ride; 2],
    /// Between which heights the outlines cross, above the origin of A.
    pub outline_heights_m: [f64; 2],
    /// Length of the patch across the normal.
    pub width_m: Interval,
    /// Length upwards.
    pub height_m: Interval,
    /// Length along the normal.
    pub span_m: Interval,
    /// How far the bodies press into each other along the normal, at the greatest depth.
    pub depth_m: f64,
    /// Bits of the zones hit: of A, of B.
    pub zones: [u16; 2],
    /// Bits of the zones that may be hit.
    pub zones_at_most: [u16; 2],
}

/// The direction a quarter turn to the left of `i`.
fn across(i: usize) -> usize {
    (i + QUARTER) % HORIZONTAL
}

/// The features of a contact, as far as its jobs are done.
pub(crate) fn describe(
    approach: &Approach,
    evidence: &Evidence,
    plane: &Plane,
    long_face_of: Option<usize>,
) -> ContactPatch {
    let d = &approach.directions.d;
    let along = plane.normal.dot(d[0]);
    let left = plane.normal.dot(d[across(0)]);
    let degrees = libm::atan2(left, along).to_degrees();
    // The nearest direction that supports are kept for.
    let n = ((degrees / 5.0).round() as isize).rem_euclid(HORIZONTAL as isize) as usize;
    let stops = survey(approach);
    let last_m = stops.iter().rfind(|stop| stop.patch).map_or(0.0, |stop| stop.travel_m);
    let reach = approach.reach(0.0, last_m);
    let middle = evidence.middle(UP, UP + 1, &reach);
    let level = plane.point_m - d[UP] * plane.point_m.dot(d[UP]);
    ContactPatch {
        origin: plane.origin,
        normal: plane.normal.to_array().map(|x| x + 0.0),
        normal_degrees: degrees + 0.0,
        centre_m: (level + d[UP] * middle).to_array().map(|x| x + 0.0),
        long_face_of,
        rides: plane.rides,
        outline_heights_m: plane.height_m,
        width_m: evidence.span(across(n), opposite(across(n)), &reach),
        height_m: evidence.span(UP, UP + 1, &reach),
        span_m: evidence.span(n, opposite(n), &reach),
        depth_m: plane.depth_m * along.max(0.0),
        zones: evidence.zones().map(|zones| zones.0),
        zones_at_most: evidence.zones_at_most().map(|zones| zones.0),
    }
}
