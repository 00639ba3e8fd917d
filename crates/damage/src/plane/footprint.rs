//! Outlines of bodies where they stand, in plan along the direction of motion.

use super::overlap;
use crate::approach::Approach;
use body::Outlines;
use geometry::plan::hull_of;
use geometry::{DVec3, RelativePose};

/// The point of first contact belongs to an outline that it lies this near to (m): what outlines
/// leave out, twice, and the closing of gaps.
const BELONGS_M: f64 = 0.02;

/// The outline of a body between two heights, where it stands.
#[derive(Clone, Debug, PartialEq)]
pub struct PlacedBand {
    /// Heights along the vertical of A's frame (m).
    pub height_m: [f64; 2],
    /// Rings in plan, along u and to its left (m), counter-clockwise.
    pub rings: Vec<Vec<[f64; 2]>>,
    /// Their box.
    pub(super) bounds: [[f64; 2]; 2],
}

/// The outlines of a body where it stands, in plan along u.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Footprint(Vec<PlacedBand>);

/// Axes of the plan: along u, to its left, and upwards.
#[derive(Clone, Copy, Debug)]
pub(super) struct Axes(pub(super) [DVec3; 3]);

impl Axes {
    pub(super) fn of(approach: &Approach) -> Self {
        let d = &approach.directions.d;
        let (u, up) = (d[0], d[crate::approach::UP]);
        Self([u, up.cross(u), up])
    }

    pub(super) fn plan(&self, p: DVec3) -> [f64; 2] {
        [p.dot(self.0[0]), p.dot(self.0[1])]
    }

    pub(super) fn height(&self, p: DVec3) -> f64 {
        p.dot(self.0[2])
    }

    pub(super) fn vector(&self, [x, y]: [f64; 2]) -> DVec3 {
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
    pub(super) fn new(height_m: [f64; 2], rings: Vec<Vec<[f64; 2]>>) -> Self {
        let bounds = bounds(&rings);
        Self { height_m, rings, bounds }
    }

    pub(super) fn shared_height(&self, other: &Self) -> f64 {
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
            PlacedBand::new(
                height_m,
                vec![hull_of(corners.iter().map(|p| axes.plan(*p)).collect())],
            )
        };
        Self(outlines.bands.iter().map(slab).collect())
    }

    /// Its slabs, by ascending height where it stands upright.
    #[must_use]
    pub fn slabs(&self) -> &[PlacedBand] {
        &self.0
    }

    /// Whether a point (plan and height) belongs to an outline or its near surroundings.
    pub(super) fn holds(&self, p: [f64; 2], height: f64) -> bool {
        let is_at = |slab: &&PlacedBand| {
            slab.height_m[0] - BELONGS_M <= height && height <= slab.height_m[1] + BELONGS_M
        };
        self.0.iter().filter(is_at).any(|slab| overlap::holds(&slab.rings, p, BELONGS_M))
    }

    /// Its length along a direction in plan (m).
    pub(super) fn extent(&self, [x, y]: [f64; 2]) -> f64 {
        let along = self.0.iter().flat_map(|s| &s.rings).flatten().map(|p| p[0] * x + p[1] * y);
        let ends = along
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], s| [low.min(s), high.max(s)]);
        (ends[1] - ends[0]).max(0.0)
    }
}
