//! Rigid poses in f64 and the relative pose that defines what is intersected.

use crate::{Aabb, Bounds, Corners, DVec3, Triangle};

/// A rigid pose: body frame to world frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Rotation matrix, row-major.
    pub rotation: [[f64; 3]; 3],
    /// Position of the body frame's origin in the world (m).
    pub translation: [f64; 3],
}

/// The pose of B in A's frame: x_A = R x_B + t.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RelativePose {
    /// Rotation matrix R, row-major.
    pub rotation: [[f64; 3]; 3],
    /// Translation t (m), in A's frame.
    pub translation: [f64; 3],
}

impl Pose {
    /// The identity: the body frame is the world frame.
    pub const IDENTITY: Self = Self {
        rotation: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        translation: [0.0; 3],
    };

    /// A pose from yaw, pitch, roll in degrees, applied in the order Z·Y·X, and a position (m).
    ///
    /// Sines and cosines come from `libm`, so they are the same on every machine.
    #[must_use]
    pub fn from_degrees(yaw: f64, pitch: f64, roll: f64, translation: [f64; 3]) -> Self {
        let [(sy, cy), (sp, cp), (sr, cr)] =
            [yaw, pitch, roll].map(|degrees| libm::sincos(degrees.to_radians()));
        Self {
            rotation: [
                [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
                [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
                [-sp, cp * sr, cp * cr],
            ],
            translation,
        }
    }

    /// Rotates a world direction into this body's frame: Rᵀ d.
    #[must_use]
    pub fn direction_to_body(&self, d: DVec3) -> DVec3 {
        let r = &self.rotation;
        let column = |j: usize| r[0][j] * d.x + r[1][j] * d.y + r[2][j] * d.z;
        DVec3::new(column(0), column(1), column(2))
    }
}

impl RelativePose {
    /// The pose of B relative to A: R = RaᵀRb, t = Raᵀ(tb − ta), sums left to right.
    #[must_use]
    pub fn between(a: &Pose, b: &Pose) -> Self {
        let (ra, rb) = (&a.rotation, &b.rotation);
        let d: [f64; 3] = core::array::from_fn(|i| b.translation[i] - a.translation[i]);
        Self {
            rotation: core::array::from_fn(|i| {
                core::array::from_fn(|j| {
                    ra[0][i] * rb[0][j] + ra[1][i] * rb[1][j] + ra[2][i] * rb[2][j]
                })
            }),
            translation: core::array::from_fn(|i| {
                ra[0][i] * d[0] + ra[1][i] * d[1] + ra[2][i] * d[2]
            }),
        }
    }

    /// The same orientation, moved by `offset` (m) in A's frame.
    #[must_use]
    pub fn moved(&self, offset: DVec3) -> Self {
        let offset = offset.to_array();
        Self {
            rotation: self.rotation,
            translation: core::array::from_fn(|i| self.translation[i] + offset[i]),
        }
    }

    /// A stored point of B in A's frame: `((R₀x + R₁y) + R₂z) + t`. This defines the input.
    #[must_use]
    #[inline(always)]
    pub fn point(&self, p: [f32; 3]) -> DVec3 {
        let ([x, y, z], [tx, ty, tz]) = (p.map(f64::from), self.translation);
        let row = |r: &[f64; 3], t: f64| ((r[0] * x + r[1] * y) + r[2] * z) + t;
        let [rx, ry, rz] = &self.rotation;
        DVec3::new(row(rx, tx), row(ry, ty), row(rz, tz))
    }

    /// A stored triangle of B in A's frame.
    #[must_use]
    #[inline]
    pub fn triangle(&self, corners: &Corners) -> Triangle {
        let [a, b, c] = *corners;
        Triangle([self.point(a), self.point(b), self.point(c)])
    }

    /// Rotates a direction from A's frame into B's: Rᵀ d.
    #[must_use]
    pub fn direction_to_b(&self, d: DVec3) -> DVec3 {
        Pose { rotation: self.rotation, translation: self.translation }.direction_to_body(d)
    }

    /// A box in A's frame that contains every [`RelativePose::point`] of B's `box_`.
    ///
    /// Rounded outward: with c the centre and h the half extents of the box, each side is moved out
    /// by more than the error of both this computation and that of `point`. Holds for every finite
    /// box and translations up to 1e300 m; the empty box becomes one that overlaps nothing.
    #[must_use]
    pub fn bounds(&self, box_: &Aabb) -> Bounds {
        let b = box_.bounds();
        let (c, h) = ((b.min + b.max) * 0.5, (b.max - b.min) * 0.5);
        let mut sides = [(0.0, 0.0); 3];
        for (i, side) in sides.iter_mut().enumerate() {
            let r = DVec3::from_array(self.rotation[i]);
            let t = self.translation[i];
            let mid = r.dot(c) + t;
            let reach = r.abs().dot(h);
            // In units of u = ε/2 times the sum S of magnitudes: `point` is off by at most 4 (a
            // product and three sums), `mid` by 5 (one more for c), `reach` by 4, each side by 2
            // more when it is moved. That is 15 of the 32 allowed; S itself has a relative error of
            // a few u. Products below the normal range are off by less than the least normal
            // number.
            let magnitude = r.abs().dot(c.abs()) + reach + t.abs();
            let slack = 16.0 * f64::EPSILON * magnitude + f64::MIN_POSITIVE;
            *side = (mid - reach - slack, mid + reach + slack);
        }
        Bounds {
            min: DVec3::new(sides[0].0, sides[1].0, sides[2].0),
            max: DVec3::new(sides[0].1, sides[1].1, sides[2].1),
        }
    }
}

#[cfg(test)]
mod tests;
