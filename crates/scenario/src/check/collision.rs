//! A candidate: two bodies at predicted impact, each with a pose and a velocity.

use crate::document::{Path, TextPosition};
use crate::error::Misfit;
use crate::fault::{At, Fault};
use crate::fields::{self, name, number, undefined};
use crate::limit;
use crate::names::quoted;
use crate::scenario::{Candidate, MotionState, Opponent, Party, PartyIndex};
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
    if let Some(kind) = parties[party.0].source.kind() {
        rules::stands_still(kind, other_state.velocity_m_s)
            .at(&path.key(velocity_key(&raw_state)))?;
    }
    let other = Opponent { party, state: other_state };
    Ok(Candidate { name: raw.name.into(), place, probability, ego: ego_state, other })
}

/// The party of this name, which is not the ego.
fn opponent(written: &str, parties: &[Party], ego: PartyIndex) -> Result<PartyIndex, Misfit> {
    let index = parties.iter().position(|party| party.name == written);
    let index = index.ok_or_else(|| {
        let known: Vec<&str> = parties.iter().map(|party| party.name.as_str()).collect();
        undefined("party", written, &known, "")
    })?;
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
    let position_m = fields::numbers(&raw.position_m, "position_m", limit::POSITION_M, path)?;
    let angles_deg = fields::angles([raw.yaw_deg, raw.pitch_deg, raw.roll_deg], path)?;
    let [yaw_deg, pitch_deg, roll_deg] = angles_deg;
    let pose = Pose::from_degrees(yaw_deg, pitch_deg, roll_deg, position_m);
    let velocity = raw.velocity_m_s.as_deref();
    let [x, y] = fields::velocity(raw.speed_m_s, velocity, yaw_deg, limit::SPEED_M_S, path)?;
    Ok(MotionState { angles_deg, pose, velocity_m_s: DVec3::new(x, y, 0.0) })
}
