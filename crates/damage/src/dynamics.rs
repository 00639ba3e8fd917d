//! From speeds, masses and lever arms to changes of velocity.
//!
//! Two bodies exchange a normal impulse J_n with restitution e, and a tangential one J_t that
//! sticks (`v_t/w_t`) or slides (`μ J_n`). Lever arms reduce the effective masses. With e = h = μ =
//! 0 this is ΔV₁ = m₂/(m₁+m₂)·v (TUM); with h = μ = 0 it is (1+e)v/(1+m₁/m₂) (McHenry).
//!
//! Everything is monotone: ΔV rises in v_n, v_t, e, μ, k and the partner's mass, and falls in h, q
//! and the own mass; energy falls in h and q. So intervals are evaluated at their end points. The
//! coupled solution in n and t is not monotone, and only a test's oracle.

use serde::Serialize;

/// One body in an impact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImpactBody {
    /// 1/m (1/kg); 0 for an object fixed to the ground.
    pub inverse_mass: f64,
    /// Yaw radius of gyration k (m), above 0.
    pub gyration_m: f64,
    /// Distance of the centre of mass from the contact point across the normal, h (m).
    pub across_m: f64,
    /// Distance of the centre of mass from the contact point along the normal, q (m).
    pub along_m: f64,
}

/// An impact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Impact {
    /// Closing speed along the normal, v_n ≥ 0 (m/s).
    pub normal_m_s: f64,
    /// Sliding speed across it, v_t ≥ 0 (m/s).
    pub tangential_m_s: f64,
    /// Coefficient of restitution e.
    pub restitution: f64,
    /// Coefficient of friction μ.
    pub friction: f64,
    /// The two bodies; at most one of them fixed.
    pub sides: [ImpactBody; 2],
}

/// The response of both bodies to an impact.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Response {
    /// Normal impulse (N s).
    pub normal_n_s: f64,
    /// Tangential impulse (N s).
    pub tangential_n_s: f64,
    /// Change of velocity of either body (m/s).
    pub delta_v_m_s: [f64; 2],
    /// Kinetic energy lost (J).
    pub energy_j: f64,
}

/// A parameter with its expert range.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Setting {
    /// Low end.
    pub low: f64,
    /// What the nominal computation takes.
    pub nominal: f64,
    /// High end.
    pub high: f64,
}

/// Parameters of contact and dynamics.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Parameters {
    /// Restitution e. Constant: falling with speed it could make harm fall with speed (SAE 931842).
    pub restitution: Setting,
    /// Friction μ; our assumption.
    pub friction: Setting,
    /// Gyration is known to this share.
    pub gyration_share: f64,
    /// Masses are known to this share.
    pub mass_share: f64,
    /// Speeds are known to this share.
    pub speed_share: f64,
    /// Poses are known to this distance (m).
    pub pose_error_m: f64,
}

/// Which end of the parameters' ranges.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Pick {
    Low,
    Nominal,
    High,
}

/// A parameter out of its range.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0} is out of its range: 0 ≤ low ≤ nominal ≤ high, restitution at most 1, shares below 1")]
pub struct ParameterError(&'static str);

impl Default for Parameters {
    fn default() -> Self {
        Self {
            restitution: Setting { low: 0.0, nominal: 0.1, high: 0.3 },
            friction: Setting { low: 0.3, nominal: 0.45, high: 0.6 },
            gyration_share: 0.15,
            mass_share: 0.10,
            speed_share: 0.05,
            pose_error_m: 0.10,
        }
    }
}

impl Parameters {
    /// Checks ranges.
    ///
    /// # Errors
    ///
    /// Names the first parameter that is not finite, negative, out of order or too large.
    pub fn check(&self) -> Result<(), ParameterError> {
        let ordered = |s: &Setting, most: f64| {
            0.0 <= s.low && s.low <= s.nominal && s.nominal <= s.high && s.high <= most
        };
        let share = |s: f64| (0.0..1.0).contains(&s);
        let checks = [
            ("restitution", ordered(&self.restitution, 1.0)),
            ("friction", ordered(&self.friction, 10.0)),
            ("gyration share", share(self.gyration_share)),
            ("mass share", share(self.mass_share)),
            ("speed share", share(self.speed_share)),
            ("pose error", (0.0..10.0).contains(&self.pose_error_m)),
        ];
        match checks.iter().find(|(_, holds)| !holds) {
            Some((name, _)) => Err(ParameterError(name)),
            None => Ok(()),
        }
    }
}

impl Setting {
    pub(crate) fn pick(&self, pick: Pick) -> f64 {
        match pick {
            Pick::Low => self.low,
            Pick::Nominal => self.nominal,
            Pick::High => self.high,
        }
    }
}

/// The factor `1 ± share`.
pub(crate) fn factor(share: f64, pick: Pick) -> f64 {
    match pick {
        Pick::Low => 1.0 - share,
        Pick::Nominal => 1.0,
        Pick::High => 1.0 + share,
    }
}

impl Impact {
    /// The response to this impact. All zeros if the bodies do not approach each other.
    #[must_use]
    pub fn respond(&self) -> Response {
        let (e, mu) = (self.restitution, self.friction);
        let (v_n, v_t) = (self.normal_m_s, self.tangential_m_s);
        let compliance = |lever: fn(&ImpactBody) -> f64| -> f64 {
            let body_compliance = |s: &ImpactBody| {
                let turn = lever(s) / s.gyration_m;
                (1.0 + turn * turn) * s.inverse_mass
            };
            body_compliance(&self.sides[0]) + body_compliance(&self.sides[1])
        };
        let (w_n, w_t) = (compliance(|s| s.across_m), compliance(|s| s.along_m));
        if v_n <= 0.0 || w_n <= 0.0 || w_t <= 0.0 {
            return Response::default();
        }
        let j_n = (1.0 + e) * v_n / w_n;
        let j_t = (mu * j_n).min(v_t / w_t);
        let j = (j_n * j_n + j_t * j_t).sqrt();
        Response {
            normal_n_s: j_n,
            tangential_n_s: j_t,
            delta_v_m_s: self.sides.map(|s| j * s.inverse_mass),
            energy_j: 0.5 * (1.0 - e * e) * v_n * v_n / w_n + j_t * (v_t - 0.5 * w_t * j_t),
        }
    }
}

#[cfg(test)]
mod tests;
