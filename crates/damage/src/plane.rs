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
use body::Outlines;
use geometry::{DVec3, RelativePose};
use overlap::{Facing, Overlap};
use serde::Serialize;
use smallvec::SmallVec;

mod overlap;
#[cfg(test)]
mod tests;

/// Number of depths at which the bodies are intersected.
pub const DEPTHS: usize = 6;

/// Number of depths at which chords are taken: steps between them show in what grazes a pole.
const CHORDS: usize = 24;

/// The greatest depth (m).
pub const DEPTH_MAX_M: f64 = 0.9;

/// A sum of chords below this (m²) is no plane.
const CHORD_MIN_M2: f64 = 1e-6;

/// Bodies that overlap by more than this (m³) without a plane lie in each other: they do not graze.
const INSIDE_M3: f64 = 0.005;

/// The point of first contact belongs to an outline that it lies this near to (m): what outlines
/// leave out, twice, and the closing of gaps.
const BELONGS_M: f64 = 0.02;

/// A face is the plane's, if it is turned from it by at most this cosine (8°).
const PARALLEL: f64 = 0.990_268;

/// A long face is at least this share of the length of who hits it: the front of another car is
/// not.
const LONG_SHARE: f64 = 0.6;

/// ... and at least so long (m): a door or a bumper turns nobody, however short who hits it is.
const LONG_M: f64 = 2.5;

/// A flat face of a fixed object is at least so long (m): a pole has none.
const FLAT_M: f64 = 1.0;

/// The face of a barrier reaches this share of the length of who hits it beyond the contact.
const REACH_SHARE: f64 = 1.0 / 3.0;

/// What makes the plane of a contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
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
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
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

/// A long flat face that is struck: who strikes it is turned along it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct LongFace {
    /// The party that it belongs to: 0 for A, 1 for B.
    pub of: usize,
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

/// The outline of a body between two heights, where it stands.
#[derive(Clone, Debug, PartialEq)]
pub struct PlacedBand {
    /// Heights along the vertical of A's frame (m).
    pub height_m: [f64; 2],
    /// Rings in plan, along u and to its left (m), counter-clockwise.
    pub rings: Vec<Vec<[f64; 2]>>,
    /// Their box.
    bounds: [[f64; 2]; 2],
}

/// The outlines of a body where it stands, in plan along u.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Footprint(Vec<PlacedBand>);

/// Axes of the plan: along u, to its left, and upwards.
#[derive(Clone, Copy, Debug)]
struct Axes([DVec3; 3]);

impl Axes {
    fn of(approach: &Approach) -> Self {
        let d = &approach.directions.d;
        let (u, up) = (d[0], d[crate::approach::UP]);
        Self([u, up.cross(u), up])
    }

    fn plan(&self, p: DVec3) -> [f64; 2] {
        [p.dot(self.0[0]), p.dot(self.0[1])]
    }

    fn height(&self, p: DVec3) -> f64 {
        p.dot(self.0[2])
    }

    fn vector(&self, [x, y]: [f64; 2]) -> DVec3 {
        self.0[0] * x + self.0[1] * y
    }
}

fn bounds(rings: &[Vec<[f64; 2]>]) -> [[f64; 2]; 2] {
    let mut bounds = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];
    for p in rings.iter().flatten() {
        for axis in 0..2 {
            bounds[0][axis] = bounds[0][axis].min(p[axis]);
            bounds[1][axis] = bounds[1][axis].max(p[axis]);
        }
    }
    bounds
}

impl PlacedBand {
    fn new(height_m: [f64; 2], rings: Vec<Vec<[f64; 2]>>) -> Self {
        let bounds = bounds(&rings);
        Self { height_m, rings, bounds }
    }

    fn shared_height(&self, other: &Self) -> f64 {
        self.height_m[1].min(other.height_m[1]) - self.height_m[0].max(other.height_m[0])
    }
}

impl Footprint {
    /// The outlines of a body at a pose in A's frame; `None`: it is A.
    ///
    /// A body that does not stand upright, as one that lies on the road, is taken by the convex
    /// hulls of its bands.
    #[must_use]
    pub fn of(outlines: &Outlines, pose: Option<&RelativePose>, approach: &Approach) -> Self {
        /// A body that leans less stands upright: by then its roof is 5 cm away.
        const UPRIGHT: f64 = 0.999_39;
        let axes = Axes::of(approach);
        let placed = |x: f64, y: f64, z: f64| match pose {
            None => DVec3::new(x, y, z),
            Some(pose) => {
                let r = &pose.rotation;
                let row =
                    |i: usize| ((r[i][0] * x + r[i][1] * y) + r[i][2] * z) + pose.translation[i];
                DVec3::new(row(0), row(1), row(2))
            }
        };
        let vertical = placed(0.0, 0.0, 1.0) - placed(0.0, 0.0, 0.0);
        let is_upright = axes.height(vertical) >= UPRIGHT;
        let slab = |band: &body::Band| {
            let [low, high] = band.height_m;
            if is_upright {
                let middle = 0.5 * (low + high);
                let point = |p: &[f64; 2]| axes.plan(placed(p[0], p[1], middle));
                let height = |z: f64| axes.height(placed(0.0, 0.0, z));
                let rings =
                    band.rings.iter().map(|ring| ring.iter().map(point).collect()).collect();
                return PlacedBand::new([height(low), height(high)], rings);
            }
            let ends = || [low, high].into_iter();
            let corners: Vec<DVec3> = (band.rings.iter().flatten())
                .flat_map(|p| ends().map(|z| placed(p[0], p[1], z)))
                .collect();
            let heights = corners.iter().map(|p| axes.height(*p));
            let height_m = heights.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], z| {
                [low.min(z), high.max(z)]
            });
            PlacedBand::new(height_m, vec![hull(corners.iter().map(|p| axes.plan(*p)).collect())])
        };
        Self(outlines.bands.iter().map(slab).collect())
    }

    /// Its slabs, by ascending height where it stands upright.
    #[must_use]
    pub fn slabs(&self) -> &[PlacedBand] {
        &self.0
    }

    /// Whether a point (plan and height) belongs to an outline or its near surroundings.
    fn holds(&self, p: [f64; 2], height: f64) -> bool {
        let is_at = |slab: &&PlacedBand| {
            slab.height_m[0] - BELONGS_M <= height && height <= slab.height_m[1] + BELONGS_M
        };
        self.0.iter().filter(is_at).any(|slab| overlap::holds(&slab.rings, p, BELONGS_M))
    }

    /// Its length along a direction in plan (m).
    fn extent(&self, [x, y]: [f64; 2]) -> f64 {
        let along = self.0.iter().flat_map(|s| &s.rings).flatten().map(|p| p[0] * x + p[1] * y);
        let ends = along
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], s| [low.min(s), high.max(s)]);
        (ends[1] - ends[0]).max(0.0)
    }
}

/// The convex hull of points, counter-clockwise (Andrew 1979).
fn hull(mut points: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    points.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    points.dedup();
    let turn = |a: [f64; 2], b: [f64; 2], p: [f64; 2]| {
        (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])
    };
    let chain = |points: &mut dyn Iterator<Item = [f64; 2]>| {
        let mut chain: Vec<[f64; 2]> = Vec::new();
        for p in points {
            // Each turn removes a point.
            while chain.len() >= 2 && turn(chain[chain.len() - 2], chain[chain.len() - 1], p) <= 0.0
            {
                chain.pop();
            }
            chain.push(p);
        }
        chain.pop();
        chain
    };
    let mut hull = chain(&mut points.iter().copied());
    hull.extend(chain(&mut points.iter().rev().copied()));
    hull
}

/// What is summed over depths and bands.
#[derive(Default)]
struct Sum {
    /// The mean volume of the overlap, over depths.
    volume_m3: f64,
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
        self.volume_m3 += weight * found.area_m2 / CHORDS as f64;
        let [x, y] = found.chord;
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
        for slab_a in &a.0 {
            for slab_b in &b.0 {
                let shared = slab_a.shared_height(slab_b);
                if !(shared > 0.0) {
                    continue;
                }
                let Some(facing) = Facing::of(slab_a, slab_b, depth_m) else { continue };
                let before = sum.weight;
                for k in 0..CHORDS {
                    let travel_m = depth_m * (k as f64 + 0.5) / CHORDS as f64;
                    if let Some(found) = facing.overlap(travel_m, &mut sum.struck) {
                        sum.add(&found, shared, travel_m, centres);
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
            plane.origin = if sum.volume_m3 >= INSIDE_M3 {
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

/// Long flat faces in the plane, where A slides to the left of the normal and where it slides to
/// its right; and whether any flat face is struck.
fn faces(
    struck: &[SmallVec<[overlap::Struck; 16]>; 2],
    n: [f64; 2],
    at: [f64; 2],
    footprints: [&Footprint; 2],
    (forwards, are_fixed): ([[f64; 2]; 2], [bool; 2]),
) -> ([Option<LongFace>; 2], bool) {
    let left = [-n[1], n[0]];
    let along = |p: [f64; 2]| (p[0] - at[0]) * left[0] + (p[1] - at[1]) * left[1];
    let mut best: [Option<(f64, LongFace)>; 2] = [None; 2];
    let mut is_flat = false;
    for (of, struck) in struck.iter().enumerate() {
        // Outward of A is along the normal, outward of B against it.
        let outward = if of == 0 { 1.0 } else { -1.0 };
        let striker = 1 - of;
        let length = footprints[striker].extent(forwards[striker]);
        let of_face = |edge: &overlap::Struck| {
            let ([px, py], [qx, qy]) = (edge.ends[0], edge.ends[1]);
            let size = ((qx - px) * (qx - px) + (qy - py) * (qy - py)).sqrt();
            let normal = [(qy - py) / size * outward, -(qx - px) / size * outward];
            (normal[0] * n[0] + normal[1] * n[1] >= PARALLEL).then_some(size)
        };
        let all: f64 = struck.iter().map(|edge| edge.length).sum();
        let parallel = struck.iter().filter(|edge| of_face(edge).is_some());
        // Most of what is struck of this body is the face.
        if parallel.map(|edge| edge.length).sum::<f64>() < 0.5 * all {
            continue;
        }
        for edge in struck {
            let Some(size) = of_face(edge) else { continue };
            is_flat |= are_fixed[of] && size >= FLAT_M.max(REACH_SHARE * length);
            if size < LONG_M.max(LONG_SHARE * length) {
                continue;
            }
            let ends = [along(edge.ends[0]), along(edge.ends[1])];
            // Where A slides to the left along B, B slides to the right along A.
            let mut reaches = [ends[0].max(ends[1]), -ends[0].min(ends[1])];
            if of == 0 {
                reaches.swap(0, 1);
            }
            for (side, reach) in reaches.into_iter().enumerate() {
                let is_long = reach >= REACH_SHARE * length;
                if is_long && best[side].is_none_or(|(most, _)| reach > most) {
                    best[side] = Some((reach, LongFace { of }));
                }
            }
        }
    }
    (best.map(|best| best.map(|(_, face)| face)), is_flat)
}
