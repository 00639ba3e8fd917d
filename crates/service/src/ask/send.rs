//! The request of a scenario over a horizon.

use super::seat_number;
use protocol::public::{
    Ask, PartyErrors, WireParty, WirePath, WirePathKind, WirePathState, WirePersons, WireReaction,
};
use scenario::{Errors, GivenMotion, GivenState, Motion, Occupancy, Scenario};

/// The request of a scenario. `model` gives the id of each party's model. A scenario that says
/// nothing of members leaves them to the service.
///
/// # Errors
///
/// If the scenario does not fit: it has too many parties, persons, candidates, reactions or states,
/// or a body that is stretched.
pub fn of_scenario(
    scenario: &Scenario,
    models: &[u32],
    unknown_is_fixed: bool,
) -> Result<Box<Ask>, String> {
    let mut ask = Ask::new(scenario.horizon_s);
    ask.resolution_m = scenario.resolution_m;
    ask.ego = scenario.ego.0 as u32;
    if let Some(members) = scenario.members {
        ask.set_members(members.count, members.most);
    }
    ask.flags = if unknown_is_fixed { Ask::UNKNOWN_IS_FIXED } else { 0 };
    for (number, (party, model)) in scenario.parties.iter().zip(models).enumerate() {
        if party.size.is_some() {
            return Err(format!(
                "party \"{}\" has size_m: a request takes bodies as the deployment has them",
                party.name
            ));
        }
        let mut row = WireParty::of_model(*model);
        row.responsibility = party.responsibility;
        row.flags = if party.is_unknown { WireParty::UNKNOWN } else { 0 };
        if let Some(mass_kg) = party.mass_kg {
            (row.mass_kg, row.flags) = (mass_kg, row.flags | WireParty::MASS);
        }
        if let Some(crush) = party.crush {
            (row.crush, row.flags) = (crush, row.flags | WireParty::CRUSH);
        }
        row = row.with_errors(&errors(&party.errors));
        let groups: &[_] = match &party.occupancy {
            Occupancy::Stated(groups) => groups,
            Occupancy::Empty | Occupancy::Default => &[],
        };
        if party.occupancy != Occupancy::Default {
            row.flags |= WireParty::PERSONS;
        }
        for group in groups {
            let (party, seat) = (number as u32, seat_number(group.seat));
            let persons = WirePersons { party, seat, count: group.count, spare: 0 };
            ask.add_persons(persons).ok_or("a request has at most 256 rows of persons")?;
        }
        if !party.predictions.is_empty() {
            row.first_path = ask.path_count;
            row.path_count = party.predictions.len() as u32;
        }
        for prediction in &party.predictions {
            add(&mut ask, &prediction.motion, prediction.probability)?;
        }
        ask.add_party(row).ok_or("a request has at most 32 parties")?;
    }
    for candidate in &scenario.candidates {
        let path = add(&mut ask, &candidate.ego, 0.0)?;
        let mut reactions = Vec::with_capacity(candidate.reactions.len());
        for reaction in &candidate.reactions {
            let path = add(&mut ask, &reaction.motion, 0.0)?;
            reactions.push(WireReaction { party: reaction.party.0 as u32, path });
        }
        ask.add_candidate(path, &reactions)
            .ok_or("a request has at most 16 candidates and 128 reactions")?;
    }
    Ok(ask)
}

/// All errors of a party: a service does not know which of them the scenario states.
fn errors(errors: &Errors) -> PartyErrors {
    PartyErrors {
        lateral_m: Some(errors.lateral_m),
        longitudinal_m: Some(errors.longitudinal_m),
        correlation: Some(errors.correlation),
        yaw_deg: Some(errors.yaw_deg),
        speed_share: Some(errors.speed_share),
    }
}

/// Adds a motion as a path, whose number is returned.
fn add(ask: &mut Ask, motion: &Motion, probability: f64) -> Result<u32, String> {
    let placed = |position_m: [f64; 3], angles_deg: [f64; 3]| WirePathState {
        position_m,
        angles_deg,
        ..WirePathState::default()
    };
    let (kind, yaw_rate_deg_s, states) = match &motion.given {
        GivenMotion::Place { position_m, angles_deg } => {
            (WirePathKind::Place, 0.0, vec![placed(*position_m, *angles_deg)])
        }
        GivenMotion::Onward { position_m, angles_deg, velocity_m_s, yaw_rate_deg_s } => {
            let state = placed(*position_m, *angles_deg).with_velocity(*velocity_m_s);
            (WirePathKind::Onward, *yaw_rate_deg_s, vec![state])
        }
        GivenMotion::States(states) => {
            (WirePathKind::States, 0.0, states.iter().map(state).collect())
        }
    };
    let path = WirePath { probability, yaw_rate_deg_s, ..WirePath::of_kind(kind) };
    ask.add_path(path, &states).ok_or_else(|| {
        format!(
            "a path of {} states does not fit: a path of a request has at most 64, and all {} \
             paths together 7168",
            states.len(),
            ask.path_count
        )
    })
}

fn state(given: &GivenState) -> WirePathState {
    let bare = WirePathState {
        t_s: given.time_s,
        position_m: given.position_m,
        angles_deg: given.angles_deg,
        ..WirePathState::default()
    };
    given.velocity_m_s.map_or(bare, |velocity_m_s| bare.with_velocity(velocity_m_s))
}
