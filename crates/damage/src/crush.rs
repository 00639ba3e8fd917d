//! Crush by stiffness, as a check of the depth that the bodies' shapes give.
//!
//! A body's front yields at a force per width of A + B·C, C being the permanent crush (m); with the
//! elastic part a crush absorbs w (A C + B C²/2 + A²/(2B)) (J) over a width w (m) (the form of the
//! CRASH3 program, after Campbell). Both bodies press with equal force, which gives both crushes in
//! closed form. Stiffness must be configured: none is built in.
//!
//! It is shown beside the depth and never ranks: depth comes from a given pose and speed, not from
//! how far bodies really yield, so a mismatch means that pose and speed are inconsistent.

use crate::interval::Interval;
use serde::Serialize;

/// Crush and depth further apart than this are inconsistent (m); our assumption.
const MISMATCH_M: f64 = 0.2;

/// Stiffness of one body.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Stiffness {
    /// A: force per width at which crush begins (N/m), at least 0.
    pub a_n_m: f64,
    /// B: what each metre of crush adds (N/m²), above 0.
    pub b_n_m2: f64,
}

/// Crush of both bodies, beside the depth.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Crush {
    /// Permanent crush of A and of B (m); 0 for what is fixed.
    pub crush_m: [f64; 2],
    /// Their sum is further than 0.2 m from every depth that is possible.
    pub mismatch: bool,
}

impl Crush {
    /// Crush of two bodies that absorb `energy_j` (J) over `width_m` (m), beside a depth (m).
    ///
    /// A body is `None` if it is fixed to the ground, and taken as rigid then. `None` if the
    /// stiffness of a body that is not fixed is unknown, both are fixed, or there is no width.
    #[must_use]
    pub fn of(
        bodies: [Option<Option<Stiffness>>; 2],
        energy_j: f64,
        width_m: f64,
        depth_m: Interval,
    ) -> Option<Self> {
        let mut softness = 0.0;
        for stiffness in bodies.iter().flatten() {
            softness += 1.0 / (*stiffness)?.b_n_m2;
        }
        if !(softness > 0.0 && width_m > 0.0) {
            return None;
        }
        // A crush absorbs w F²/(2B) for F = A + B C, its force per width.
        let force = (2.0 * energy_j / (width_m * softness)).sqrt();
        let crush_m = bodies
            .map(|body| body.flatten().map_or(0.0, |s| ((force - s.a_n_m) / s.b_n_m2).max(0.0)));
        let sum = crush_m[0] + crush_m[1];
        let mismatch = sum > depth_m.hi() + MISMATCH_M || sum < depth_m.lo() - MISMATCH_M;
        Some(Self { crush_m, mismatch })
    }
}

#[cfg(test)]
mod tests;
