//! Names of what an answer has numbers of; `?` where the scenario has no such number.

/// The name of a candidate.
pub(super) fn name_of(scenario: &scenario::Scenario, candidate: u32) -> &str {
    scenario.candidates.get(candidate as usize).map_or("?", |candidate| &candidate.name)
}

/// The name of a party.
pub(super) fn party(scenario: &scenario::Scenario, number: u32) -> &str {
    scenario.parties.get(number as usize).map_or("?", |party| &party.name)
}
