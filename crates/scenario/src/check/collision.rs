//! A candidate: two bodies at predicted impact, each with a pose and a velocity.

use super::{At, Fault, name, number, undefined};
use crate::document::{Path, TextPosition};
use crate::error::Misfit;
use crate::limit::{self, Limit, Show};
use crate::names::quoted;
use crate::scenario::{Candidate, MotionState, Opponent, Party, PartyIndex, Source};
use crate::{raw, rules};
use geometry::{DVec3, Pose};

/// A candidate whose name is not taken.
pub(super) fn candidate(
    raw: raw::Candidate,
    path: &Path,
    place: TextPosition,
    parties: &[Party],
    ego: PartyIndex,
) -> Result<Candidate, Fault> {
    name("name", &raw.name).at(&path.key("name"))?;
    let probability = number(raw.probability, "probability", limit::SHARE, path)?.unwrap_or(1.0);
    let ego_state = state(&raw.ego.0, &path.key("ego"))?;
    let path = path.key("other");
    let (written, raw_state) = raw.other.0.split();
    let party = opponent(&written, parties, ego).at(&path.key("party"))?;
    let other_state = state(&raw_state, &path)?;
    if let Source::Generate { shape, .. } = parties[party.0].source {
        rules::stands_still(shape.kind(), other_state.velocity_m_s)
            .at(&path.key(velocity_key(&raw_state)))?;
    }
    let other = Opponent { party, state: other_state };
    Ok(Candidate { name: raw.name.into(), place, probability, ego: ego_state, other })
}

/// The party of this name, which is not the ego.
fn opponent(written: &str, parties: &[Party], ego: PartyIndex) -> Result<PartyIndex, Misfit> {
    let index = parties.iter().position(|party| party.name == written);
    let index = index.ok_or_else(|| undefined("party", written, parties, ""))?;
    if index == ego.0 {
        let fault = format!("party {} is the ego: it cannot hit itself", quoted(written));
        return Err(Misfit::new("party", fault, "name another party"));
    }
    Ok(PartyIndex(index))
}

fn velocity_key(raw: &raw::Ego) -> &'static str {
    if raw.velocity_m_s.is_some() { "velocity_m_s" } else { "speed_m_s" }
}

/// Pose and velocity in the world.
fn state(raw: &raw::Ego, path: &Path) -> Result<MotionState, Fault> {
    let position_m = numbers(&raw.position_m, "position_m", limit::POSITION_M, path)?;
    let yaw_deg = number(raw.yaw_deg, "yaw_deg", limit::YAW_DEG, path)?.unwrap_or(0.0);
    let pitch_deg = number(raw.pitch_deg, "pitch_deg", limit::PITCH_DEG, path)?.unwrap_or(0.0);
    let roll_deg = number(raw.roll_deg, "roll_deg", limit::ROLL_DEG, path)?.unwrap_or(0.0);
    let pose = Pose::from_degrees(yaw_deg, pitch_deg, roll_deg, position_m);
    let speed_m_s = number(raw.speed_m_s, "speed_m_s", limit::SPEED_M_S, path)?;
    let [x, y] = match (speed_m_s, &raw.velocity_m_s) {
        (Some(speed_m_s), None) => {
            // Impact is reckoned in the ground plane, so the heading is the yaw alone.
            let heading = Pose::from_degrees(yaw_deg, 0.0, 0.0, [0.0; 3]).rotation;
            [speed_m_s * heading[0][0], speed_m_s * heading[1][0]]
        }
        (None, Some(velocity_m_s)) => {
            let [x, y] = numbers(velocity_m_s, "velocity_m_s", limit::SPEED_M_S, path)?;
            let speed_m_s = (x * x + y * y).sqrt();
            limit::SPEED_M_S.check("velocity_m_s", speed_m_s).at(&path.key("velocity_m_s"))?;
            [x, y]
        }
        (both, _) => {
            let count = if both.is_some() { "both speed_m_s and" } else { "neither speed_m_s nor" };
            let fault = format!("the state has {count} velocity_m_s");
            let help =
                "write speed_m_s = … along the heading, or velocity_m_s = [x, y] in the world";
            return Err(Misfit::new("speed_m_s", fault, help)).at(path);
        }
    };
    let angles_deg = [yaw_deg, pitch_deg, roll_deg];
    Ok(MotionState { angles_deg, pose, velocity_m_s: DVec3::new(x + 0.0, y + 0.0, 0.0) })
}

/// A list of so many numbers, each within the limit.
fn numbers<const N: usize>(
    written: &[f64],
    setting: &'static str,
    limit: Limit<f64>,
    parent: &Path,
) -> Result<[f64; N], Fault> {
    let path = parent.key(setting);
    let Ok(numbers) = <[f64; N]>::try_from(written) else {
        let axes = ["x", "y", "z"].get(..N).unwrap_or_default().join(", ");
        let fault = format!("{setting} has {} numbers", written.len());
        return Err(Misfit::new(setting, fault, format!("write {setting} = [{axes}]"))).at(&path);
    };
    if let Some(index) = numbers.iter().position(|value| !limit.holds(*value)) {
        let fault = format!("{setting}[{index}] is {}", numbers[index].show());
        let help = format!("each of {setting} may be {}", limit.range());
        return Err(Misfit::new(setting, fault, help)).at(&path.index(index));
    }
    // Adding +0.0 turns −0.0 into +0.0.
    Ok(numbers.map(|value| value + 0.0))
}
