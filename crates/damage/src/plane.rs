//! The plane of a contact: the chord through the crossings of two outlines, swept over the depth to
//! which the bodies press into each other.
//!
//! The chord through the crossings of two outlines in plan is the plane that reconstruction of
//! crashes uses (H. Kudlich, K. Slibar). It is the gradient of the area of their overlap, too, and
//! so the sum of the outline of one body inside the other (divergence theorem). Only the depth at
//! which it is taken is free, so it is summed over depths: at D(k+½)/24, k = 0…23, beyond first
//! contact along the direction of motion u, D being at most [`DEPTH_MAX_M`] and no more than
//! either body measures along u, never a function of speed. Bands of height that meet count by the
//! height that they share.
//!
//! Both outlines are cut and the difference is taken, so the plane is the same, but turned round,
//! when the bodies are exchanged. Sides that coincide do not count. Overlaps that would push the
//! bodies together are dropped.
//!
//! It knows no masses and no speeds.

use crate::approach::Approach;
use crate::dynamics::of_turning;
use crate::party::CollisionParty;
use face::faces;
use footprint::Axes;
use geometry::DVec3;
use overlap::{Facing, Overlap};
use schemars::JsonSchema;
use serde::Serialize;
use smallvec::SmallVec;

mod face;
mod footprint;
mod overlap;
#[cfg(test)]
mod tests;

pub use face::LongFace;
pub use footprint::{Footprint, PlacedBand};

/// Number of depths at which the bodies are intersected.
pub const DEPTHS: usize = 6;

/// Number of depths at which chords are taken: steps between them show in what grazes a pole.
const CHORDS: usize = 24;

/// The greatest depth (m).
pub const DEPTH_MAX_M: f64 = 0.9;

/// A sum of chords below this (m²) is no plane.
const CHORD_MIN_M2: f64 = 1e-6;

/// Bodies that lie in each other by more than this (m³) without a plane do not graze.
const INSIDE_M3: f64 = 0.005;

/// One lies in the other, or passes through it, where the chord of their overlap is shorter than
/// this share of the root of its area: where they part or slide, it is about as long as that.
const INSIDE_CHORD: f64 = 0.1;

/// What makes the plane of a contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum PlaneOrigin {
    /// The outlines cross: the swept chord.
    Chord,
    /// The outlines do not cross, although both hold the point of contact: the bodies slide past
    /// each other, and exchange no impulse.
    Graze,
    /// Only a weak part of a body is hit, as a mirror: it breaks off, without an impulse.
    WeakPart,
    /// The point of contact belongs to no outline, or one body lies in the other: across the
    /// direction of motion.
    Motion,
}

/// How a party is met in height.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Ride {
    /// At its own height.
    #[default]
    Level,
    /// Nothing below the edge of its bonnet is met: it goes under the other.
    Under,
    /// Only what lies below half of that is met: it goes over the other.
    Over,
}

/// The plane of a contact. Everything is in A's frame; lengths are metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// The normal, horizontal, from A to B.
    pub normal: DVec3,
    /// From the centre of mass of A and of B to the point of contact, in plan.
    pub arms_m: [DVec3; 2],
    /// The point of contact, A's frame.
    pub point_m: DVec3,
    /// D: how deep the bodies press into each other.
    pub depth_m: f64,
    /// Between which heights outlines cross, along the vertical of A's frame.
    pub height_m: [f64; 2],
    /// What makes it.
    pub origin: PlaneOrigin,
    /// A long flat face, if one is struck: if A slides to the left of the normal, and to its right.
    pub faces: [Option<LongFace>; 2],
    /// Whether the face that is struck is flat and belongs to a wall, long or not.
    pub is_flat: bool,
    /// How A and B are met in height.
    pub rides: [Ride; 2],
}

/// What outlines need of a body besides.
#[derive(Clone, Copy, Debug)]
pub struct Front {
    /// Its centre of mass (m, A's frame).
    pub centre_m: DVec3,
    /// Where it points (A's frame).
    pub forward: DVec3,
    /// The height of its front above its lowest point (m), if it has one.
    pub height_m: Option<f64>,
    /// Whether weak parts were left out of its outlines.
    pub has_weak_parts: bool,
    /// Whether it is fixed to the ground.
    pub is_fixed: bool,
}

impl Front {
    /// Of a party.
    #[must_use]
    pub fn of(party: &CollisionParty) -> Self {
        Self {
            centre_m: party.centre_m,
            forward: party.forward,
            height_m: party.front_m,
            has_weak_parts: party.kind.is_car_like(),
            is_fixed: party.mass_kg.is_none(),
        }
    }
}

/// What is summed over depths and bands.
#[derive(Default)]
struct Sum {
    /// The mean volume in which one lies in the other, over depths.
    inside_m3: f64,
    chord: [f64; 2],
    weight: f64,
    arms: [[f64; 2]; 2],
    point: [f64; 2],
    height: f64,
    heights: Option<[f64; 2]>,
    /// The struck edges of A's outline and of B's: their ends at first contact, and how much of
    /// them is struck.
    struck: [SmallVec<[overlap::Struck; 16]>; 2],
}

impl Sum {
    fn add(&mut self, found: &Overlap, weight: f64, travel_m: f64, centres: [[f64; 2]; 2]) {
        let [x, y] = found.chord;
        if x * x + y * y < INSIDE_CHORD * INSIDE_CHORD * found.area_m2 {
            self.inside_m3 += weight * found.area_m2 / CHORDS as f64;
        }
        if x <= 0.0 {
            return;
        }
        let w = weight * (x * x + y * y).sqrt();
        self.weight += w;
        let add = |sum: &mut [f64; 2], more: [f64; 2], by: f64| {
            *sum = [sum[0] + by * more[0], sum[1] + by * more[1]];
        };
        let apart = |from: [f64; 2]| [found.centre[0] - from[0], found.centre[1] - from[1]];
        let moved = [centres[1][0] - travel_m, centres[1][1]];
        add(&mut self.chord, found.chord, weight);
        add(&mut self.arms[0], apart(centres[0]), w);
        add(&mut self.arms[1], apart(moved), w);
        add(&mut self.point, found.centre, w);
    }
}

impl Plane {
    /// The velocity of A against B at the point of contact (m/s), with the bodies' turning.
    #[must_use]
    pub fn velocity_m_s(&self, approach: &Approach) -> DVec3 {
        let up = approach.directions.d[crate::approach::UP];
        let [of_a, of_b] = [0, 1].map(|p| of_turning(approach.yaw_rad_s[p], self.arms_m[p], up));
        approach.velocity_m_s + of_a - of_b
    }

    /// Across the direction of motion, through the middle between two centres (m, A's frame).
    #[must_use]
    pub(crate) fn across_motion(approach: &Approach, centres_m: [DVec3; 2]) -> Self {
        let point_m = (centres_m[0] + centres_m[1]) * 0.5;
        let axes = Axes::of(approach);
        let arms_m = centres_m.map(|centre| {
            let arm = axes.plan(point_m - centre);
            axes.vector(arm)
        });
        Self {
            normal: axes.0[0],
            arms_m,
            point_m,
            depth_m: 0.0,
            height_m: [axes.height(point_m); 2],
            origin: PlaneOrigin::Motion,
            faces: [None; 2],
            is_flat: false,
            rides: [Ride::Level; 2],
        }
    }

    /// The plane of a contact at the given pose. `point` is the point of first contact, A's frame.
    #[must_use]
    pub fn of(
        approach: &Approach,
        [a, b]: [&Footprint; 2],
        parties: [Front; 2],
        point: DVec3,
    ) -> Self {
        let axes = Axes::of(approach);
        // Of the outlines: a sheet of no thickness has one of its own there.
        let along = [1.0, 0.0];
        let depth_m = match [a.extent(along), b.extent(along)] {
            [of_a, of_b] if of_a > 0.0 && of_b > 0.0 => DEPTH_MAX_M.min(of_a).min(of_b),
            _ => approach.extent_up_to(DEPTH_MAX_M),
        };
        let centres = parties.map(|party| axes.plan(party.centre_m));
        let mut sum = Sum::default();
        for slab_a in a.slabs() {
            for slab_b in b.slabs() {
                let shared = slab_a.shared_height(slab_b);
                if !(shared > 0.0) {
                    continue;
                }
                let Some(mut facing) = Facing::of(slab_a, slab_b, depth_m) else { continue };
                let before = sum.weight;
                for k in 0..CHORDS {
                    if let Some(found) = facing.overlap(k, &mut sum.struck) {
                        sum.add(&found, shared, facing.travel_m(k), centres);
                    }
                }
                let more = sum.weight - before;
                if more > 0.0 {
                    let low = slab_a.height_m[0].max(slab_b.height_m[0]);
                    sum.height += more * (low + 0.5 * shared);
                    let [from, to] = sum.heights.unwrap_or([f64::INFINITY, f64::NEG_INFINITY]);
                    sum.heights = Some([from.min(low), to.max(low + shared)]);
                }
            }
        }
        let at = (axes.plan(point), axes.height(point));
        let mut plane = Self {
            normal: axes.0[0],
            arms_m: [0, 1].map(|p| axes.vector([at.0[0] - centres[p][0], at.0[1] - centres[p][1]])),
            point_m: point,
            depth_m,
            height_m: sum.heights.unwrap_or([at.1; 2]),
            origin: PlaneOrigin::Motion,
            faces: [None; 2],
            is_flat: false,
            rides: [Ride::Level; 2],
        };
        let [x, y] = sum.chord;
        let length = (x * x + y * y).sqrt();
        if length < CHORD_MIN_M2 {
            let holds = [a.holds(at.0, at.1), b.holds(at.0, at.1)];
            let is_weak = |p: usize| !holds[p] && parties[p].has_weak_parts;
            plane.origin = if sum.inside_m3 >= INSIDE_M3 {
                PlaneOrigin::Motion
            } else if is_weak(0) || is_weak(1) {
                PlaneOrigin::WeakPart
            } else if holds == [true; 2] {
                PlaneOrigin::Graze
            } else {
                PlaneOrigin::Motion
            };
        } else {
            // Rounding of a symmetric overlap is no direction.
            let y = if y.abs() <= 1e-12 * length { 0.0 } else { y };
            let n = [x / length, y / length];
            plane.origin = PlaneOrigin::Chord;
            plane.normal = axes.vector(n);
            plane.arms_m = sum.arms.map(|arm| axes.vector(arm.map(|s| s / sum.weight)));
            let middle = sum.point.map(|s| s / sum.weight);
            plane.point_m = axes.vector(middle) + axes.0[2] * (sum.height / sum.weight);
            (plane.faces, plane.is_flat) = {
                let forwards = parties.map(|party| axes.plan(party.forward));
                let are_fixed = parties.map(|party| party.is_fixed);
                faces(&sum.struck, n, at.0, [a, b], (forwards, are_fixed))
            };
        }
        let down = crate::approach::UP + 1;
        let bases = [&approach.supports_a, &approach.supports_b].map(|s| -s.0[down]);
        plane.rides = [0, 1].map(|p| ride(&plane, &parties[p], bases[p]));
        plane
    }
}

/// How a party with a front is met.
fn ride(plane: &Plane, party: &Front, base: f64) -> Ride {
    let [low, high] = plane.height_m;
    match party.height_m {
        Some(front) if plane.origin == PlaneOrigin::Chord && low >= base + front => Ride::Under,
        Some(front) if plane.origin == PlaneOrigin::Chord && high <= base + 0.5 * front => {
            Ride::Over
        }
        _ => Ride::Level,
    }
}
