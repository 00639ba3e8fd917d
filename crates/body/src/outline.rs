//! The outlines of a body in plan, in bands of height: what makes the plane of a contact.
//!
//! A band is the region that the body covers between two heights, seen from above: the union of
//! its cross-sections at several heights, and of whatever lies between these and reaches out of
//! them. Cavities are filled, gaps below [`GAP_M`] closed. Weak parts are left out: triangles of
//! parts that are named so ([`is_weak`]) and, of vehicles, whatever is narrower than twice
//! [`WEAK_M`] (a morphological opening). They touch, but they do not carry an impact.
//!
//! Outlines are computed once, when a body is made, and are a part of its metadata. They do not
//! depend on how flat faces are cut into triangles, but for [`TOLERANCE_M`].

use crate::{BodyKind, Mesh};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

mod region;
mod section;
#[cfg(test)]
mod tests;

/// Openings of a surface up to twice this width (m) are closed.
pub const GAP_M: f64 = 0.05;

/// Parts of a vehicle up to twice this width (m) are weak.
pub const WEAK_M: f64 = 0.14;

/// Outlines may leave out points that lie this near to them (m).
pub const TOLERANCE_M: f64 = 0.002;

/// Most points of all outlines of a body: bounds the work on a contact.
pub const POINTS_MAX: usize = 4096;

/// Where bands end, above the lowest point of a body (m).
const EDGES_M: [f64; 22] = [
    0.2, 0.4, 0.6, 0.8, 1.0, 1.2, 1.4, 1.6, 1.8, 2.0, 2.5, 3.0, 3.5, 4.0, 5.0, 6.0, 8.0, 10.0,
    15.0, 20.0, 30.0, 50.0,
];

/// Cross-sections per band.
const SECTIONS: usize = 8;

/// A closed line in plan, counter-clockwise, metres, body frame; its last point joins its first.
pub type Ring = Vec<[f64; 2]>;

/// The outline of a body between two heights.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Band {
    /// From and to this height, body frame `[m]`.
    pub height_m: [f64; 2],
    /// Rings that do not overlap.
    pub rings: Vec<Ring>,
}

/// The outlines of a body, by ascending height; bands without a ring are left out.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Outlines {
    /// The bands.
    pub bands: Vec<Band>,
}

/// Whether a part of this name is weak: a mirror, an antenna, a wiper, whatever the case.
#[must_use]
pub fn is_weak(name: &str) -> bool {
    let name = name.to_lowercase();
    ["mirror", "antenna", "aerial", "wiper"].iter().any(|word| name.contains(word))
}

impl Outlines {
    /// The outlines of a mesh.
    ///
    /// In a thread of a pool of rayon, all threads of that pool share the bands; which of them does
    /// what changes nothing.
    ///
    /// Where a whole band of a vehicle is weak, as its wheels near the ground are, it is left out.
    /// Where that holds for the whole body, nothing is weak.
    #[must_use]
    pub fn of(mesh: &Mesh, kind: BodyKind) -> Self {
        let strong = |&at: &usize| {
            let part = mesh.part_of.get(at).and_then(|part| mesh.parts.get(usize::from(*part)));
            !part.is_some_and(|name| is_weak(name))
        };
        let named: Vec<_> = (0..mesh.corners.len()).filter(strong).collect();
        let all = || (0..mesh.corners.len()).collect();
        let chosen = if named.is_empty() { all() } else { named };
        let opened = Self::opened_by(mesh, &chosen, if kind.is_car_like() { WEAK_M } else { 0.0 });
        if opened.bands.is_empty() { Self::opened_by(mesh, &all(), 0.0) } else { opened }
    }

    fn opened_by(mesh: &Mesh, chosen: &[usize], weak_m: f64) -> Self {
        let corners: Vec<_> =
            chosen.iter().map(|&at| mesh.corners[at].map(|p| p.map(f64::from))).collect();
        let heights = corners.iter().flatten().map(|p| p[2]);
        let (low, high) = heights
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), z| (low.min(z), high.max(z)));
        if !(low <= high) {
            return Self::default();
        }
        let grid = region::Grid::over(&corners);
        let edges = EDGES_M.map(|edge| low + edge);
        let last = edges.iter().position(|edge| *edge >= high).unwrap_or(edges.len());
        let ends: Vec<f64> =
            core::iter::once(low).chain(edges[..last].iter().copied()).chain([high]).collect();
        let bands: Vec<_> = ends.windows(2).map(|pair| [pair[0], pair[1]]).collect();
        let region = |band: &[f64; 2]| {
            let covered = section::of(&corners, *band, &grid).thinned(&grid, 0.25 * TOLERANCE_M);
            covered.closed(&grid, GAP_M).opened(&grid, weak_m)
        };
        let regions: Vec<_> = if rayon::current_thread_index().is_some() {
            bands.par_iter().map(region).collect()
        } else {
            bands.iter().map(region).collect()
        };
        let mut tolerance_m = TOLERANCE_M;
        loop {
            let band = |(height_m, region): (&[f64; 2], &region::Region)| Band {
                height_m: *height_m,
                rings: region.rings(&grid, tolerance_m),
            };
            let made: Vec<_> = bands.iter().zip(&regions).map(band).collect();
            let points: usize = made.iter().flat_map(|band| &band.rings).map(Vec::len).sum();
            if points <= POINTS_MAX || tolerance_m > 1.0 {
                let kept = made.into_iter().filter(|band| !band.rings.is_empty());
                return Self { bands: kept.collect() };
            }
            tolerance_m *= 2.0;
        }
    }

    /// The extents of all rings along x and y (m): length and width without weak parts; `None`
    /// without rings.
    #[must_use]
    pub fn size_m(&self) -> Option<[f64; 2]> {
        let points = || self.bands.iter().flat_map(|band| &band.rings).flatten();
        points().next()?;
        Some([0, 1].map(|axis| {
            let along = points().map(|p| p[axis]);
            let least = along.clone().fold(f64::INFINITY, f64::min);
            along.fold(f64::NEG_INFINITY, f64::max) - least
        }))
    }

    /// Checks what consumers rely on.
    ///
    /// # Errors
    ///
    /// A coordinate that is not finite or far away, bands out of order, a ring of fewer than three
    /// points, or more than [`POINTS_MAX`] points.
    pub fn check(&self) -> Result<(), String> {
        let is_near = |x: &f64| x.abs() <= crate::meta::LENGTH_MAX_M * 1.01;
        let mut from = f64::NEG_INFINITY;
        let mut points = 0;
        for band in &self.bands {
            let [low, high] = band.height_m;
            if !(is_near(&low) && is_near(&high) && from <= low && low <= high) {
                return Err(format!("a band of its outlines has the heights {low} to {high} m"));
            }
            from = high;
            for ring in &band.rings {
                if ring.len() < 3 || !ring.as_flattened().iter().all(is_near) {
                    return Err("a ring of its outlines is no closed line".to_owned());
                }
                points += ring.len();
            }
        }
        if points > POINTS_MAX {
            return Err(format!("its outlines have {points} points, above {POINTS_MAX}"));
        }
        Ok(())
    }
}

/// The height (m above the lowest point) of the leading edge of a front: where a straight edge
/// meets the body that leans back by 50° and reaches from the ground to 1.24 m, as pedestrian tests
/// of cars define it (Euro NCAP, bonnet leading edge reference line; there the edge is 1 m long and
/// begins at 0.6 m).
#[must_use]
pub fn front_height_m(mesh: &Mesh) -> Option<f64> {
    const TOP_M: f64 = 1.24;
    let (sin, cos) = libm::sincos(50_f64.to_radians());
    let low = f64::from(mesh.bounds().min[2]);
    let mut best: Option<(f64, f64)> = None;
    let mut consider = |x: f64, height: f64| {
        let reach = x * cos + height * sin;
        if height <= TOP_M && best.is_none_or(|(most, _)| reach > most) {
            best = Some((reach, height));
        }
    };
    for corners in &mesh.corners {
        let corners = corners.map(|p| (f64::from(p[0]), f64::from(p[2]) - low));
        for k in 0..3 {
            let ((x, z), (x1, z1)) = (corners[k], corners[(k + 1) % 3]);
            consider(x, z);
            if (z < TOP_M) != (z1 < TOP_M) {
                consider(x + (x1 - x) * ((TOP_M - z) / (z1 - z)), TOP_M);
            }
        }
    }
    best.map(|(_, height)| height)
}
