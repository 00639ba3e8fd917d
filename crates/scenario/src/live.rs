//! Values that do not come from a file: the same rules, without a position.
//!
//! A request of the service carries what a scenario carries. Its reader checks here whether a value
//! may stand in a scenario.

use crate::document::TextPosition;
use crate::error::Misfit;
use crate::limit;
use crate::members::{Errors, Members};
use crate::rules;
use crate::scenario::path::{self, RowFault};
use crate::scenario::{GivenMotion, GivenState, Motion, OccupantGroup};
use body::BodyKind;

/// What is wrong with a motion.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MotionMisfit {
    /// With which of its states, from 0; `None`: with the whole.
    pub state: Option<usize>,
    /// What is wrong.
    pub misfit: Misfit,
}

/// A motion until the horizon (s), as a scenario's would be.
///
/// # Errors
///
/// The first number that is beyond its range, or the first state that no body reaches.
pub fn motion(
    given: GivenMotion,
    horizon_s: f64,
    place: TextPosition,
) -> Result<Motion, MotionMisfit> {
    let whole = |misfit| MotionMisfit { state: None, misfit };
    let given = match given {
        GivenMotion::Place { position_m, angles_deg } => GivenMotion::Place {
            position_m: position(position_m).map_err(whole)?,
            angles_deg: angles(angles_deg).map_err(whole)?,
        },
        GivenMotion::Onward { position_m, angles_deg, velocity_m_s, yaw_rate_deg_s } => {
            limit::TURN_RATE_DEG_S.check("yaw_rate_deg_s", yaw_rate_deg_s).map_err(whole)?;
            GivenMotion::Onward {
                position_m: position(position_m).map_err(whole)?,
                angles_deg: angles(angles_deg).map_err(whole)?,
                velocity_m_s: velocity(velocity_m_s).map_err(whole)?,
                yaw_rate_deg_s: yaw_rate_deg_s + 0.0,
            }
        }
        GivenMotion::States(mut states) => {
            for (number, state) in states.iter_mut().enumerate() {
                *state = checked(*state)
                    .map_err(|misfit| MotionMisfit { state: Some(number), misfit })?;
            }
            GivenMotion::States(states)
        }
    };
    path::motion(given, horizon_s, place)
        .map_err(|RowFault { row, misfit }| MotionMisfit { state: row, misfit })
}

fn checked(state: GivenState) -> Result<GivenState, Misfit> {
    Ok(GivenState {
        time_s: limit::PATH_TIME_S.check("t_s", state.time_s)? + 0.0,
        position_m: position(state.position_m)?,
        angles_deg: angles(state.angles_deg)?,
        velocity_m_s: state.velocity_m_s.map(velocity).transpose()?,
    })
}

// Adding +0.0 turns −0.0 into +0.0, so that equal requests are equal in every bit.
fn position(position_m: [f64; 3]) -> Result<[f64; 3], Misfit> {
    for position_m in position_m {
        limit::POSITION_M.check("position_m", position_m)?;
    }
    Ok(position_m.map(|metres| metres + 0.0))
}

fn angles([yaw, pitch, roll]: [f64; 3]) -> Result<[f64; 3], Misfit> {
    limit::YAW_DEG.check("yaw_deg", yaw)?;
    limit::PITCH_DEG.check("pitch_deg", pitch)?;
    limit::ROLL_DEG.check("roll_deg", roll)?;
    Ok([yaw, pitch, roll].map(|degrees| degrees + 0.0))
}

fn velocity([x, y]: [f64; 2]) -> Result<[f64; 2], Misfit> {
    for speed in [x, y, (x * x + y * y).sqrt()] {
        limit::PATH_SPEED_M_S.check("velocity_m_s", speed)?;
    }
    Ok([x + 0.0, y + 0.0])
}

/// How far ahead a scenario looks (s).
///
/// # Errors
///
/// If it is not within 1 ms to 30 s.
pub fn horizon_s(value: f64) -> Result<f64, Misfit> {
    limit::HORIZON_S.check("horizon_s", value)
}

/// Within which distance bodies count as touching where that cannot be decided (m); 0: the usual.
///
/// # Errors
///
/// If it is not within 1e-5 to 0.1.
pub fn resolution_m(value: f64) -> Result<f64, Misfit> {
    if value == 0.0 {
        return Ok(crate::scenario::DEFAULT_RESOLUTION_M);
    }
    limit::RESOLUTION_M.check("resolution_m", value)
}

/// Persons of a party, after the groups before.
///
/// # Errors
///
/// If a seat is taken twice, or a party has more than 90 persons; with its kind, also if it has no
/// such seat, or not as much room.
pub fn group(
    kind: Option<BodyKind>,
    group: OccupantGroup,
    before: &[OccupantGroup],
) -> Result<OccupantGroup, Misfit> {
    limit::OCCUPANTS.whole::<u32>("count", i64::from(group.count))?;
    let all = before.iter().map(|group| i64::from(group.count)).sum::<i64>();
    limit::OCCUPANTS.whole::<u32>("count", all + i64::from(group.count))?;
    if let (Some(seat), true) = (group.seat, group.count > 1) {
        let fault = format!("{} persons cannot have the seat {:?}", group.count, seat.name());
        return Err(Misfit::new("count", fault, "one person to a seat"));
    }
    rules::group_fits(kind, group, before)?;
    Ok(group)
}

/// Probabilities of what a party may do.
///
/// # Errors
///
/// If they do not sum to 1 within 1e-6.
pub fn sums_to_one(probabilities: impl Iterator<Item = f64>) -> Result<(), Misfit> {
    let sum: f64 = probabilities.sum();
    if (sum - 1.0).abs() <= limit::PROBABILITY_SUM_OFF {
        return Ok(());
    }
    let fault = format!("the probabilities sum to {sum}");
    Err(Misfit::new("probability", fault, "what a party may do sums to 1"))
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

/// How many members there are, and at most; 0 of both: as many as `usual`. 0 as the most alone: as
/// a scenario that says nothing.
///
/// # Errors
///
/// As [`Members::new`].
pub fn members(count: u32, most: u32, usual: Members) -> Result<Members, Misfit> {
    let written = |number: u32| (number != 0).then_some(i64::from(number));
    match (written(count), written(most)) {
        (None, None) => Ok(usual),
        (count, most) => Members::new(count.unwrap_or_else(|| usual.count.into()), most),
    }
}

/// Errors of a party as far as they are given.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GivenErrors {
    /// As [`Errors::lateral_m`].
    pub lateral_m: Option<f64>,
    /// As [`Errors::longitudinal_m`].
    pub longitudinal_m: Option<f64>,
    /// As [`Errors::correlation`].
    pub correlation: Option<f64>,
    /// As [`Errors::yaw_deg`].
    pub yaw_deg: Option<f64>,
    /// As [`Errors::speed_share`].
    pub speed_share: Option<f64>,
}

/// How well a party is known: what is given, else as [usual](Errors::usual).
///
/// # Errors
///
/// If a standard deviation is not within 0 to 10 m, 90° or half of the speed, or the correlation
/// not within -1 to 1.
pub fn errors(given: &GivenErrors, is_ego: bool) -> Result<Errors, Misfit> {
    let usual = Errors::usual(is_ego);
    let number = |setting, limit: limit::Limit<f64>, given: Option<f64>, usual: f64| {
        given.map_or(Ok(usual), |value| Ok(limit.check(setting, value)? + 0.0))
    };
    let GivenErrors { lateral_m, longitudinal_m, correlation, yaw_deg, speed_share } = *given;
    let speed = limit::ERROR_SPEED_SHARE;
    Ok(Errors {
        lateral_m: number("lateral_m", limit::ERROR_M, lateral_m, usual.lateral_m)?,
        longitudinal_m: number(
            "longitudinal_m",
            limit::ERROR_M,
            longitudinal_m,
            usual.longitudinal_m,
        )?,
        correlation: number("correlation", limit::CORRELATION, correlation, usual.correlation)?,
        yaw_deg: number("yaw_deg", limit::ERROR_YAW_DEG, yaw_deg, usual.yaw_deg)?,
        speed_share: number("speed_share", speed, speed_share, usual.speed_share)?,
    })
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
    //! A motion made here is the one that a file would have given.
    use super::*;
    use crate::scenario::Scenario;

    const CROSSING: &str = include_str!("../config/scenarios/crossing.toml");

    #[test]
    fn a_motion_comes_back_in_every_bit() {
        let scenario = Scenario::parse("crossing.toml", CROSSING).unwrap();
        let predicted = scenario.parties.iter().flat_map(|party| &party.predictions);
        let predicted = predicted.map(|prediction| &prediction.motion);
        for known in predicted.chain(scenario.candidates.iter().map(|way| &way.ego)) {
            let again = motion(known.given.clone(), scenario.horizon_s, known.place);
            assert_eq!(again.as_ref(), Ok(known));
        }
    }

    #[test]
    fn what_is_not_finite_or_too_large_is_named() {
        let onward = |at: usize, value: f64| {
            let mut values = [0.0; 9];
            values[at] = value;
            let [x, y, z, yaw, pitch, roll, u, v, yaw_rate_deg_s] = values;
            let (position_m, angles_deg, velocity_m_s) = ([x, y, z], [yaw, pitch, roll], [u, v]);
            let given =
                GivenMotion::Onward { position_m, angles_deg, velocity_m_s, yaw_rate_deg_s };
            motion(given, 5.0, TextPosition::START)
        };
        for at in 0..9 {
            assert!(onward(at, 1.0).is_ok());
            for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e9] {
                let MotionMisfit { state, misfit } = onward(at, value).unwrap_err();
                assert!(state.is_none() && misfit.what.contains(misfit.setting), "{misfit}");
            }
        }
        assert!(share("probability", 1.5).is_err() && share("probability", f64::NAN).is_err());
        assert!(mass_kg(0.0).is_err() && crush([-1.0, 1e6]).is_err());
    }

    #[test]
    fn errors_and_members_are_those_of_a_scenario_that_says_the_same() {
        let text = CROSSING.replacen(
            "[parties.ego]",
            "[parties.ego]\nerrors = { lateral_m = 0.5, correlation = -0.0, speed_share = 0.5 }",
            1,
        );
        let scenario = Scenario::parse("crossing.toml", &text).unwrap();
        let given = GivenErrors {
            lateral_m: Some(0.5),
            correlation: Some(-0.0),
            speed_share: Some(0.5),
            ..GivenErrors::default()
        };
        let ego = &scenario.parties[scenario.ego.0];
        assert_eq!(errors(&given, true).as_ref(), Ok(&ego.errors));
        assert_eq!(errors(&GivenErrors::default(), false), Ok(Errors::usual(false)));
        let usual = Members { count: 8, most: 16 };
        let sound = |count, most| members(count, most, usual).map(|of| (of.count, of.most)).ok();
        assert_eq!(sound(0, 0), Some((8, 16)));
        assert_eq!(sound(0, 32), Some((8, 32)));
        assert_eq!(sound(32, 0), Some((32, 128)));
        assert_eq!(sound(1, 0), Some((1, 1)));
        for (count, most) in [(0, 4), (1025, 0), (1, 2), (2, 1025), (u32::MAX, 0), (4, 2)] {
            assert_eq!(sound(count, most), None, "{count} {most}");
        }
        let nominal = members(0, 2, Members::NOMINAL).unwrap_err();
        assert_eq!(nominal.setting, "members_max");
    }
}
