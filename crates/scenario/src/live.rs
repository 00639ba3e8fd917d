//! Values that do not come from a file: the same rules, without a position.
//!
//! A request of the service carries what a scenario carries. Its reader checks here whether a value
//! may stand in a scenario.

use crate::error::Misfit;
use crate::limit;
use crate::scenario::MotionState;
use geometry::{DVec3, Pose};

impl MotionState {
    /// Pose and velocity from position (m), yaw, pitch and roll (degrees), and velocity in the
    /// ground plane (m/s), as a scenario's would be.
    ///
    /// # Errors
    ///
    /// The first value that is not finite or beyond its range.
    pub fn new(
        position_m: [f64; 3],
        angles_deg: [f64; 3],
        velocity_m_s: [f64; 2],
    ) -> Result<Self, Misfit> {
        for position_m in position_m {
            limit::POSITION_M.check("position_m", position_m)?;
        }
        let [yaw, pitch, roll] = angles_deg;
        limit::YAW_DEG.check("yaw_deg", yaw)?;
        limit::PITCH_DEG.check("pitch_deg", pitch)?;
        limit::ROLL_DEG.check("roll_deg", roll)?;
        let [x, y] = velocity_m_s;
        limit::SPEED_M_S.check("velocity_m_s", x)?;
        limit::SPEED_M_S.check("velocity_m_s", y)?;
        limit::SPEED_M_S.check("velocity_m_s", (x * x + y * y).sqrt())?;
        // Adding +0.0 turns −0.0 into +0.0, so that equal requests are equal in every bit.
        let [yaw, pitch, roll] = angles_deg.map(|degrees| degrees + 0.0);
        Ok(Self {
            angles_deg: [yaw, pitch, roll],
            pose: Pose::from_degrees(yaw, pitch, roll, position_m.map(|metres| metres + 0.0)),
            velocity_m_s: DVec3::new(x + 0.0, y + 0.0, 0.0),
        })
    }
}

/// A probability or a share.
///
/// # Errors
///
/// If it is not within 0 to 1.
pub fn share(setting: &'static str, value: f64) -> Result<f64, Misfit> {
    Ok(limit::SHARE.check(setting, value)? + 0.0)
}

/// A mass (kg).
///
/// # Errors
///
/// If no road user has such a mass.
pub fn mass_kg(value: f64) -> Result<f64, Misfit> {
    limit::MASS_KG.check("mass_kg", value)
}

/// Stiffness A (N/m) and B (N/m²).
///
/// # Errors
///
/// If no body is so soft or so stiff.
pub fn crush([a, b]: [f64; 2]) -> Result<[f64; 2], Misfit> {
    Ok([limit::CRUSH_A.check("a_n_m", a)? + 0.0, limit::CRUSH_B.check("b_n_m2", b)?])
}

#[cfg(test)]
mod tests {
    //! A state made here is the state that a file would have given.
    use super::*;
    use crate::testing::{FULL, parse};

    #[test]
    fn a_state_comes_back_in_every_bit() {
        for candidate in parse(FULL).unwrap().candidates {
            for state in [candidate.ego, candidate.other.state] {
                let velocity = [state.velocity_m_s.x, state.velocity_m_s.y];
                let again = MotionState::new(state.pose.translation, state.angles_deg, velocity);
                assert_eq!(again.unwrap(), state);
            }
        }
    }

    #[test]
    fn what_is_not_finite_or_too_large_is_named() {
        let state = |at: usize, value: f64| {
            let mut values = [0.0; 8];
            values[at] = value;
            let [x, y, z, yaw, pitch, roll, u, v] = values;
            MotionState::new([x, y, z], [yaw, pitch, roll], [u, v])
        };
        for at in 0..8 {
            assert!(state(at, 1.0).is_ok());
            for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e9] {
                let misfit = state(at, value).unwrap_err();
                assert!(misfit.what.contains(misfit.setting), "{misfit}");
            }
        }
        assert!(share("probability", 1.5).is_err() && share("probability", f64::NAN).is_err());
        assert!(mass_kg(0.0).is_err() && crush([-1.0, 1e6]).is_err());
    }
}
