//! The contact of two bodies: normal, place, size, depth. Computed from supports, so it does not
//! depend on the mesh.
//!
//! The normal comes from the hulls, not from the patch: at a flat wall or round a pole the patch is
//! a planar ring whose thinnest direction misleads. N is the set of directions along which the
//! hulls overlap least at pose r; the nominal normal is its member nearest to u. While the first
//! contact is known only between two travels, `Normals` holds what may and what must belong to N,
//! so that the set only narrows as the search goes on.
//!
//! It does not know masses or persons.

use crate::approach::{Approach, HORIZONTAL, QUARTER, UP, cosine, opposite, turn};
use crate::evidence::{Evidence, Touch};
use crate::interval::Interval;
use crate::party::CollisionParty;
use crate::path::{PATCH_M, Path};
use geometry::{DVec3, Supports};
use serde::Serialize;
use smallvec::{SmallVec, smallvec};

/// Directions belong to N up to this multiple of the least overlap ...
const NEARLY_LEAST: f64 = 1.5;
/// ... or up to this overlap (m).
const SHALLOW_M: f64 = 0.02;

/// A value per direction that may be a normal. It is computed after every result, so it stores all
/// of them in place and does not allocate.
pub type PerNormal<T> = SmallVec<[T; HORIZONTAL]>;

/// The directions that may be the normal of a contact.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Normals {
    /// Those that the nominal normal may be; one, once the first contact is known.
    pub(crate) nominal: PerNormal<usize>,
    /// Those that may belong to N.
    pub(crate) possible: PerNormal<usize>,
    /// Those that surely belong to N.
    pub(crate) sure: PerNormal<usize>,
}

/// Travels of the patch's landmarks (m), as far as the first contact is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Places {
    pub(crate) first: Interval,
    pub(crate) patch_end: Interval,
    pub(crate) crush_end: Interval,
    /// Half way through the patch: where lever arms are measured.
    pub(crate) middle: Interval,
}

/// The contact of one candidate, as far as it is known.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Contact {
    /// Whether the bodies touch.
    pub touch: Touch,
    /// No contact, but the hulls come nearer than poses are known.
    pub near_miss: bool,
    /// Least distance of the hulls (m), not more than the true one; negative: they overlap.
    pub hull_gap_m: f64,
    /// Features of the patch; `None` without contact.
    pub patch: Option<ContactPatch>,
}

/// Features of a contact patch. Lengths in metres.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ContactPatch {
    /// Travel of the first contact.
    pub first_m: Interval,
    /// Nominal normal, from A to B, A's frame.
    pub normal: [f64; 3],
    /// Its angle from u, −180 to 180 degrees, positive to the left of u.
    pub normal_degrees: f64,
    /// Angles of all members of N from u, degrees.
    pub normals_degrees: PerNormal<f64>,
    /// Middle of the patch in A's frame, when half of it has come to be.
    pub centre_m: [f64; 3],
    /// Length across the normal.
    pub width_m: Interval,
    /// Length upwards.
    pub height_m: Interval,
    /// Length along the normal.
    pub span_m: Interval,
    /// Overlap of the hulls along the normal at pose r.
    pub penetration_m: Interval,
    /// The larger of the hulls' overlap and of the hits' length along the normal, at pose e.
    pub depth_m: Interval,
    /// Bits of the zones hit: of A, of B.
    pub zones: [u16; 2],
    /// Bits of the zones that may be hit.
    pub zones_at_most: [u16; 2],
}

/// The least multiple of 5° in (−180, 180] for a direction.
fn degrees(i: usize) -> f64 {
    let angle = 5.0 * turn(i) as f64;
    if i % HORIZONTAL > HORIZONTAL / 2 { -angle } else { angle }
}

/// The direction a quarter turn to the left of `i`.
pub(crate) fn across(i: usize) -> usize {
    (i + QUARTER) % HORIZONTAL
}

impl Normals {
    /// Of a concave body the hull says nothing: the normal is u.
    pub(crate) fn head_on() -> Self {
        Self { nominal: smallvec![0], possible: smallvec![0], sure: smallvec![0] }
    }

    /// N at a pose between two travels, with hulls that overlap `raise_m` more than they do.
    pub(crate) fn between(approach: &Approach, from_m: f64, to_m: f64, raise_m: f64) -> Self {
        let overlap = |i: usize| {
            let penetration_at = |s: f64| approach.penetration(i, s) + raise_m;
            Interval::new(penetration_at(from_m), penetration_at(to_m))
        };
        // Overlaps are linear in travel, so their least value at any travel lies between these.
        let (least, most) = (0..HORIZONTAL)
            .map(overlap)
            .fold((f64::INFINITY, f64::INFINITY), |(l, m), o| (l.min(o.lo()), m.min(o.hi())));
        let limit = |least: f64| (NEARLY_LEAST * least).max(SHALLOW_M);
        let all = 0..HORIZONTAL;
        let possible: PerNormal<_> =
            all.clone().filter(|&i| overlap(i).lo() <= limit(most)).collect();
        let sure: PerNormal<_> = all.filter(|&i| overlap(i).hi() <= limit(least)).collect();
        let nominal = if from_m.to_bits() == to_m.to_bits() {
            let nearer = |a: &&usize, b: &&usize| {
                let by_overlap = || overlap(**a).lo().total_cmp(&overlap(**b).lo());
                turn(**a).cmp(&turn(**b)).then_with(by_overlap).then(a.cmp(b))
            };
            possible.iter().min_by(nearer).copied().into_iter().collect()
        } else {
            let furthest = sure.iter().map(|&i| turn(i)).min().unwrap_or(HORIZONTAL);
            possible.iter().copied().filter(|&i| turn(i) <= furthest).collect()
        };
        Self { nominal, possible, sure }
    }
}

impl Places {
    /// Where bodies that touch nowhere would touch if poses were off by `pose_error_m`.
    pub(crate) fn missed(approach: &Approach, pose_error_m: f64) -> Self {
        let first = approach.entry(pose_error_m);
        let r = Interval::exactly(first + PATCH_M);
        let first = Interval::exactly(first);
        Self { first, patch_end: r, crush_end: r, middle: first }
    }

    /// Along a path, for what is known of the first contact.
    pub(crate) fn along(path: &Path, first_m: (f64, f64)) -> Self {
        let first = Interval::new(first_m.0, first_m.1);
        let patch_end = first.map(|f| path.patch_end(f));
        Self {
            first,
            patch_end,
            crush_end: first.map(|f| path.crush_end(f)),
            middle: first.map(|f| 0.5 * (f + path.patch_end(f))),
        }
    }
}

/// Where the centre of a body stands along direction `i` in the frame half way between the bodies.
///
/// `sign` is +1 for A, −1 for B.
fn centre(approach: &Approach, centre_m: DVec3, i: usize, sign: f64, middle: Interval) -> Interval {
    let along = centre_m.dot(approach.directions.d[i]);
    let moved = |s: f64| along + sign * 0.5 * s * cosine(i);
    Interval::new(moved(middle.lo()), moved(middle.hi()))
}

/// Distances of both bodies' centres from the middle of the patch: across and along normal `i` (m).
pub(crate) fn levers(
    approach: &Approach,
    evidence: &Evidence,
    reach: &Supports,
    middle: Interval,
    parties: [&CollisionParty; 2],
    i: usize,
) -> [[Interval; 2]; 2] {
    let distance = |party: &CollisionParty, sign: f64, d: usize| {
        let patch = evidence.middle(d, opposite(d), reach);
        patch.distance(centre(approach, party.centre_m, d, sign, middle))
    };
    [(parties[0], 1.0), (parties[1], -1.0)]
        .map(|(party, sign)| [across(i), i].map(|d| distance(party, sign, d)))
}

/// The features of a patch with hits, or of one that may yet be found.
pub(crate) fn describe(
    approach: &Approach,
    evidence: &Evidence,
    reach: &Supports,
    places: &Places,
    normals: &Normals,
) -> Option<ContactPatch> {
    let &n = normals.nominal.first()?;
    let hull = |over: &[usize], of: &dyn Fn(usize) -> Interval| {
        over.iter().map(|&i| of(i)).reduce(Interval::hull).unwrap_or(Interval::ZERO)
    };
    let over = &normals.nominal;
    let overlap = |at: Interval| {
        hull(over, &|i| {
            let a = approach.penetration(i, at.lo()).max(0.0);
            Interval::new(a, approach.penetration(i, at.hi()).max(0.0))
        })
    };
    // The pose e may lie beyond the patch, where the hulls reach further into each other.
    let end_reach = approach.reach(places.crush_end.lo(), places.crush_end.hi());
    let end_span = hull(over, &|i| evidence.end_span(i, opposite(i), &end_reach));
    let end_overlap = overlap(places.crush_end);
    let d = &approach.directions.d;
    let mid = |w: Interval| 0.5 * (w.lo() + w.hi());
    let t = across(n);
    let middle_of = |i: usize, minus: usize| mid(evidence.middle(i, minus, reach));
    let [c_n, c_t] = [n, t].map(|i| {
        // Back from the half-way frame into A's own.
        middle_of(i, opposite(i)) - 0.5 * mid(places.middle) * cosine(i)
    });
    let c = d[n] * c_n + d[t] * c_t + d[UP] * middle_of(UP, UP + 1);
    Some(ContactPatch {
        first_m: places.first,
        normal: d[n].to_array().map(|x| x + 0.0),
        normal_degrees: degrees(n),
        normals_degrees: normals.possible.iter().map(|&i| degrees(i)).collect(),
        centre_m: c.to_array().map(|x| x + 0.0),
        width_m: hull(over, &|i| evidence.span(across(i), opposite(across(i)), reach)),
        height_m: evidence.span(UP, UP + 1, reach),
        span_m: hull(over, &|i| evidence.span(i, opposite(i), reach)),
        penetration_m: overlap(places.patch_end),
        depth_m: Interval::new(
            end_overlap.lo().max(end_span.lo()),
            end_overlap.hi().max(end_span.hi()),
        ),
        zones: evidence.zones().map(|z| z.0),
        zones_at_most: evidence.zones_at_most().map(|z| z.0),
    })
}

#[cfg(test)]
mod tests;
