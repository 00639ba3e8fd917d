//! A shot of one contact, or of where two bodies come nearest: both posed, the hit triangles, and
//! the patch.

use geometry::{Corners, DVec3};

/// A body, in its own frame.
#[derive(Clone, Debug, PartialEq)]
pub struct ShotBody {
    /// The party's name.
    pub name: String,
    /// Its triangles (m).
    pub corners: Vec<Corners>,
}

/// The contact patch, in the ego's frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShotPatch {
    /// Its middle (m).
    pub centre_m: [f64; 3],
    /// Normal from the ego to the other.
    pub normal: [f64; 3],
    /// Length across the normal, and upwards (m).
    pub size_m: [f64; 2],
}

/// Two bodies at one pose: a contact, or where they come nearest.
#[derive(Clone, Debug, PartialEq)]
pub struct Shot {
    /// The candidate, whom it meets and when.
    pub name: String,
    /// The candidate's name.
    pub candidate: String,
    /// Numbers of the ego and of the other among the bodies.
    pub bodies: [usize; 2],
    /// Names of both as parties.
    pub parties: [String; 2],
    /// The other seen from the ego: rotation, row by row.
    pub rotation: [[f64; 3]; 3],
    /// Where the other's origin is (m).
    pub translation: [f64; 3],
    /// Numbers of the triangles hit: of the ego, of the other.
    pub hits: [Vec<u32>; 2],
    /// The patch; `None` without contact.
    pub patch: Option<ShotPatch>,
    /// Caption of the picture, a sentence.
    pub caption: String,
    /// Nothing touches: it is where the ego comes nearest to the other.
    pub is_nearest: bool,
}

impl Shot {
    /// Whether the bodies touch.
    #[must_use]
    pub fn is_contact(&self) -> bool {
        !self.is_nearest
    }

    /// A point of a body as posed in this shot (m); `other`: of the other body.
    #[must_use]
    pub fn place(&self, point: [f32; 3], other: bool) -> [f64; 3] {
        let p = point.map(f64::from);
        if !other {
            return p;
        }
        [0, 1, 2].map(|i| {
            let r = self.rotation[i];
            r[0] * p[0] + r[1] * p[1] + r[2] * p[2] + self.translation[i]
        })
    }

    /// Least and greatest corner of both bodies (m).
    #[must_use]
    pub fn focus(&self, bodies: &[ShotBody]) -> [[f64; 3]; 2] {
        let all = self.bodies.into_iter().enumerate();
        let bounds = all.filter_map(|(side, number)| self.bounds(bodies.get(number)?, side));
        let none = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
        bounds.fold(none, |[low, high], [a, b]| {
            [[0, 1, 2].map(|axis| low[axis].min(a[axis])), [0, 1, 2].map(|i| high[i].max(b[i]))]
        })
    }

    /// Least and greatest corner of a body as posed in this shot (m): 0 the ego, 1 the other.
    #[must_use]
    pub fn bounds(&self, body: &ShotBody, side: usize) -> Option<[[f64; 3]; 2]> {
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for corner in body.corners.iter().flatten() {
            let point = self.place(*corner, side == 1);
            for axis in 0..3 {
                low[axis] = low[axis].min(point[axis]);
                high[axis] = high[axis].max(point[axis]);
            }
        }
        (!body.corners.is_empty()).then_some([low, high])
    }
}

impl ShotPatch {
    /// The four corners of a rectangle of the patch's size across its normal (m).
    #[must_use]
    pub fn corners(&self) -> [[f64; 3]; 4] {
        let n = DVec3::from_array(self.normal);
        let flat = DVec3::new(n.x, n.y, 0.0);
        let n = if flat.length() > 1e-9 { flat.normalize() } else { DVec3::X };
        let (across, up) = (DVec3::new(-n.y, n.x, 0.0), DVec3::Z);
        let [width, height] = self.size_m.map(|size| 0.5 * size.max(0.05));
        let centre = DVec3::from_array(self.centre_m);
        [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
            .map(|[i, j]| (centre + across * (i * width) + up * (j * height)).to_array())
    }
}
