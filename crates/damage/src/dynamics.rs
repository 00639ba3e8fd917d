//! From velocities, masses and arms to impulses and changes of velocity.
//!
//! Two bodies exchange an impulse at one point, normal and tangential parts coupled by their arms
//! (R. M. Brach, planar impact mechanics): with restitution e along the normal, and across it
//! either sticking or sliding at friction μ. With arms of zero and μ = 0 it is ΔV₁ = (1+e) v /
//! (1+m₁/m₂) (McHenry).
//!
//! Whoever strikes a long flat face is turned along it and does not turn about the point of
//! contact: a car along a barrier (fitted on MASH tests 3-10 and 3-11, our assumption).
//!
//! ΔV rises with the normal speed, with e, with the partner's mass, and falls with the own mass:
//! no violation in 200,000 draws, which is evidence, not proof. It is not monotone in the sliding
//! speed, in μ and in the radius of gyration, so ranges sample those. Proven: |J| is at most
//! `(1+e) |v|` over the sum of the inverse masses, as the coupled solution is cut there; scaling
//! all velocities scales it.

use crate::parameters::PairParameters;
use geometry::DVec3;
use serde::Serialize;

/// One body in an impact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImpactBody {
    /// 1/m (1/kg); 0 for an object fixed to the ground.
    pub inverse_mass: f64,
    /// Yaw radius of gyration k (m), above 0.
    pub gyration_m: f64,
    /// From its centre of mass to the point of contact: along the normal, and to the left of it
    /// (m).
    pub arm_m: [f64; 2],
}

/// How tangential impulses arise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Surface {
    /// Bodies that catch each other: restitution e and friction μ.
    Coupled {
        /// e.
        restitution: f64,
        /// μ.
        friction: f64,
    },
    /// A long flat face, along which the striker is turned.
    Redirecting {
        /// e at steep angles.
        restitution: f64,
        /// What is added to it at flat angles.
        restitution_more: f64,
        /// The most that the tangential impulse is of the normal one.
        tangential_share: f64,
    },
}

/// An impact in the plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Impact {
    /// Velocity of A against B at the point of contact: along the normal (A to B), and to the left
    /// of it (m/s).
    pub velocity_m_s: [f64; 2],
    /// What they meet with.
    pub surface: Surface,
    /// A and B; at most one of them fixed.
    pub sides: [ImpactBody; 2],
}

/// The response of both bodies to an impact.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Response {
    /// Normal impulse (N s), at least 0.
    pub normal_n_s: f64,
    /// Tangential impulse (N s): on B to the left of the normal, on A to the right.
    pub tangential_n_s: f64,
    /// Change of velocity of either body (m/s).
    pub delta_v_m_s: [f64; 2],
    /// Change of yaw rate of either body (rad/s), positive to the left.
    pub delta_yaw_rad_s: [f64; 2],
    /// Kinetic energy lost (J).
    pub energy_j: f64,
    /// The bodies slide past each other while they are in contact.
    pub slides: bool,
}

/// Below this share of K_nn the coupling of friction does not lessen a normal compliance.
const COMPLIANCE_MIN: f64 = 0.05;

/// Below this sliding speed (m/s) bodies slide the way that sticking would push them.
const SLIDES_M_S: f64 = 1e-9;

impl Impact {
    /// The response to this impact. All zeros if the bodies do not approach each other.
    #[must_use]
    pub fn respond(&self) -> Response {
        let inverse: f64 = self.sides.iter().map(|side| side.inverse_mass).sum();
        let [v_n, _] = self.velocity_m_s;
        if !(v_n > 0.0 && inverse > 0.0) {
            return Response::default();
        }
        match self.surface {
            Surface::Coupled { restitution, friction } => {
                self.coupled(restitution, friction, inverse)
            }
            Surface::Redirecting { restitution, restitution_more, tangential_share } => {
                self.redirected(restitution, restitution_more, tangential_share, inverse)
            }
        }
    }

    fn coupled(&self, e: f64, mu: f64, inverse: f64) -> Response {
        let [v_n, v_t] = self.velocity_m_s;
        let compliance = |of: fn(&ImpactBody, f64) -> f64| -> f64 {
            let of_side = |side: &ImpactBody| {
                of(side, side.inverse_mass / (side.gyration_m * side.gyration_m))
            };
            of_side(&self.sides[0]) + of_side(&self.sides[1])
        };
        let k_nn = inverse + compliance(|side, w| w * side.arm_m[1] * side.arm_m[1]);
        let k_tt = inverse + compliance(|side, w| w * side.arm_m[0] * side.arm_m[0]);
        let k_nt = -compliance(|side, w| w * side.arm_m[0] * side.arm_m[1]);
        let determinant = k_nn * k_tt - k_nt * k_nt;
        let wanted = (1.0 + e) * v_n;
        let stick = [
            (wanted * k_tt - k_nt * v_t) / determinant,
            (k_nn * v_t - k_nt * wanted) / determinant,
        ];
        let [mut j_n, mut j_t] = stick;
        let mut slides = false;
        if j_n <= 0.0 || j_t.abs() > mu * j_n {
            let way = if v_t.abs() < SLIDES_M_S { j_t } else { v_t };
            let s = if way < 0.0 { -1.0 } else { 1.0 };
            let n = wanted / (k_nn + s * mu * k_nt).max(COMPLIANCE_MIN * k_nn);
            let t = s * mu * n;
            // Else sliding ends before the impact does.
            slides = j_n <= 0.0 || s * (v_t - k_nt * n - k_tt * t) >= 0.0;
            if slides {
                (j_n, j_t) = (n, t);
            }
        }
        let most = (1.0 + e) * (v_n * v_n + v_t * v_t).sqrt() / inverse;
        let size = (j_n * j_n + j_t * j_t).sqrt();
        if size > most {
            (j_n, j_t) = (j_n * (most / size), j_t * (most / size));
        }
        let lost = j_n * v_n + j_t * v_t
            - 0.5 * (k_nn * j_n * j_n + 2.0 * k_nt * j_n * j_t + k_tt * j_t * j_t);
        self.response([j_n, j_t], lost, slides)
    }

    fn redirected(&self, e: f64, more: f64, share: f64, inverse: f64) -> Response {
        let [v_n, v_t] = self.velocity_m_s;
        let degrees = libm::atan2(v_n, v_t.abs()).to_degrees();
        let e = e + more * ((60.0 - degrees) / 30.0).clamp(0.0, 1.0);
        let delta_n = (1.0 + e) * v_n;
        let delta_t = (share * delta_n).min(v_t.abs()) * if v_t < 0.0 { -1.0 } else { 1.0 };
        let [j_n, j_t] = [delta_n / inverse, delta_t / inverse];
        let lost = j_n * v_n + j_t * v_t - 0.5 * inverse * (j_n * j_n + j_t * j_t);
        self.response([j_n, j_t], lost, true)
    }

    fn response(&self, [j_n, j_t]: [f64; 2], lost: f64, slides: bool) -> Response {
        let size = (j_n * j_n + j_t * j_t).sqrt();
        // The impulse acts on B along the normal and to its left, on A the other way.
        let turned = [-1.0, 1.0].map(|sign| [sign * j_n, sign * j_t]);
        let yaw = |p: usize| {
            let side = &self.sides[p];
            let [n, t] = side.arm_m;
            let turn = n * turned[p][1] - t * turned[p][0];
            turn * side.inverse_mass / (side.gyration_m * side.gyration_m) + 0.0
        };
        Response {
            normal_n_s: j_n,
            tangential_n_s: j_t + 0.0,
            delta_v_m_s: self.sides.map(|side| size * side.inverse_mass),
            delta_yaw_rad_s: [yaw(0), yaw(1)],
            energy_j: lost.max(0.0),
            slides,
        }
    }
}

/// The velocity (m/s) of a body's point against its centre of mass, which turns at a rate (rad/s):
/// `arm_m` leads from the centre to the point, `up` is the axis.
#[must_use]
pub fn of_turning(yaw_rad_s: f64, arm_m: DVec3, up: DVec3) -> DVec3 {
    up.cross(arm_m) * yaw_rad_s
}

/// The greatest change of velocity (m/s) that A can have from an impact with B at a speed at the
/// point of contact (m/s), with nominal parameters, wherever and however they meet; masses in kg,
/// `None` for what is fixed.
#[must_use]
pub fn delta_v_at_most(
    speed_m_s: f64,
    [a, b]: [Option<f64>; 2],
    parameters: &PairParameters,
) -> f64 {
    let [a, b] = [a, b].map(|mass_kg| mass_kg.map_or(0.0, |mass_kg| 1.0 / mass_kg));
    if a == 0.0 {
        return 0.0;
    }
    let coupled = 1.0 + parameters.restitution.nominal;
    let face = 1.0 + parameters.face_restitution.nominal + parameters.face_restitution_more;
    let share = parameters.face_tangential_share;
    let redirected = face * (1.0 + share * share).sqrt();
    coupled.max(redirected) * speed_m_s * a / (a + b)
}

#[cfg(test)]
mod tests;
