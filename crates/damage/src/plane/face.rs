//! Flat faces of what is struck, along which the striker is turned.

use super::footprint::Footprint;
use super::overlap::Struck;
use serde::Serialize;
use smallvec::SmallVec;

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

/// A long flat face that is struck: who strikes it is turned along it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct LongFace {
    /// The party that it belongs to: 0 for A, 1 for B.
    pub of: usize,
}

/// Long flat faces in the plane, where A slides to the left of the normal and where it slides to
/// its right; and whether any flat face is struck.
pub(super) fn faces(
    struck: &[SmallVec<[Struck; 16]>; 2],
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
        let of_face = |edge: &Struck| {
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
