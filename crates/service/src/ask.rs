//! Turns a received request into one for the engine: every value is checked here, once.
//!
//! Candidates and parties have numbers on the wire; their names in the engine are these numbers in
//! decimal. Nothing here depends on when a request arrives or on earlier requests.

use crate::deployment::Deployment;
use body::{BodyKind, BodyView, Meta, Seat, meta::Occupant};
use protocol::public::{
    Ask, CANDIDATES_MAX, Motion, PARTIES_MAX, PERSONS_MAX, Reason, VERSION, WireParty,
};
use scenario::{
    Candidate, Misfit, MotionState, Opponent, PartyIndex, Scenario, TextPosition, live,
};
use smallvec::SmallVec;
use smol_str::format_smolstr;

/// Why a request is refused, as a code and as text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Refusal {
    pub(crate) reason: Reason,
    pub(crate) text: String,
}

fn refuse<T>(reason: Reason, text: impl Into<String>) -> Result<T, Refusal> {
    Err(Refusal { reason, text: text.into() })
}

/// A checked request.
#[derive(Clone, Debug)]
pub(crate) struct Checked {
    pub(crate) scenario: Scenario,
    /// The body of each party in the store.
    pub(crate) models: SmallVec<[usize; PARTIES_MAX]>,
    /// Assumptions about parties of unknown kind.
    pub(crate) has_unknown: bool,
}

/// Buffers for the lists of a request.
#[derive(Debug, Default)]
pub(crate) struct Lists {
    parties: Vec<scenario::Party>,
    candidates: Vec<Candidate>,
}

impl Checked {
    /// Returns the buffers for the next request.
    pub(crate) fn into_room(self) -> Lists {
        let Scenario { mut parties, mut candidates, .. } = self.scenario;
        parties.clear();
        candidates.clear();
        Lists { parties, candidates }
    }
}

/// Seats by their numbers on the wire; 0 is a person on foot.
const SEATS: [Option<Seat>; 8] = [
    None,
    Some(Seat::FrontLeft),
    Some(Seat::FrontRight),
    Some(Seat::RearLeft),
    Some(Seat::RearMiddle),
    Some(Seat::RearRight),
    Some(Seat::Rider),
    Some(Seat::Pillion),
];

/// The number of a seat on the wire.
#[must_use]
pub fn seat_number(seat: Option<Seat>) -> u32 {
    SEATS.iter().position(|known| *known == seat).unwrap_or(0) as u32
}

/// Checks a request against the deployment and its bodies. `buffers` are those of an earlier
/// request.
pub(crate) fn check(
    ask: &Ask,
    deployment: &Deployment,
    bodies: &[(Meta, BodyView<'_>)],
    buffers: Lists,
) -> Result<Checked, Refusal> {
    counts(ask)?;
    let parties = &ask.parties[..ask.party_count as usize];
    let Lists { parties: mut checked, candidates } = buffers;
    let mut models = SmallVec::<[usize; PARTIES_MAX]>::new();
    for (number, party) in parties.iter().enumerate() {
        let Some(model) = deployment.model(party.model) else {
            let text = format!("party {number}: the deployment has no model {}", party.model);
            return refuse(Reason::UnknownModel, text);
        };
        models.push(model);
        checked.push(party_of(ask, number, party)?);
    }
    let scenario = Scenario {
        name: String::new(),
        policy: None,
        curves: None,
        deadline: None,
        engine: deployment.engine.clone(),
        ego: PartyIndex(ask.ego as usize),
        parties: checked,
        candidates: listed(ask, candidates)?,
    };
    let kinds: SmallVec<[BodyKind; PARTIES_MAX]> =
        models.iter().map(|model| bodies[*model].0.kind).collect();
    if let Err(error) = scenario.check_kinds("", &kinds) {
        let number = error.place.line;
        return refuse(Reason::Misfit, format!("{} {}", whose(number), error.what));
    }
    let has_unknown = scenario.parties.iter().any(|party| party.is_unknown);
    if has_unknown {
        if ask.flags & Ask::UNKNOWN_IS_FIXED == 0 {
            let text = "a party is of unknown kind; set UNKNOWN_IS_FIXED to take it as fixed";
            return refuse(Reason::UnknownKind, text);
        }
        if scenario.parties[ask.ego as usize].is_unknown {
            return refuse(Reason::UnknownKind, "the ego knows what it is");
        }
        if let Err(error) = scenario.check_fixed("") {
            return refuse(Reason::UnknownKind, error.what);
        }
    }
    Ok(Checked { scenario, models, has_unknown })
}

/// Places in errors of `scenario`: the party numbers, then the candidate numbers.
fn place(number: usize) -> TextPosition {
    TextPosition { line: number, column: 0 }
}

fn whose(number: usize) -> String {
    match number.checked_sub(PARTIES_MAX) {
        None => format!("party {number}:"),
        Some(candidate) => format!("candidate {candidate}:"),
    }
}

/// Checks version, counts and flags, which decide what the rest means.
fn counts(ask: &Ask) -> Result<(), Refusal> {
    if ask.version != VERSION {
        let text = format!("layout {} is not known, this is {VERSION}", ask.version);
        return refuse(Reason::Malformed, text);
    }
    for (what, count, least, most) in [
        ("candidate_count", ask.candidate_count, 1, CANDIDATES_MAX),
        ("party_count", ask.party_count, 2, PARTIES_MAX),
        ("person_count", ask.person_count, 0, PERSONS_MAX),
    ] {
        if !(least..=most).contains(&(count as usize)) {
            return refuse(Reason::Malformed, format!("{what} is {count}, not {least} to {most}"));
        }
    }
    if ask.ego >= ask.party_count {
        let text = format!("the ego is party {}, which does not exist", ask.ego);
        return refuse(Reason::Malformed, text);
    }
    if ask.flags & !Ask::UNKNOWN_IS_FIXED != 0 {
        return refuse(Reason::Malformed, format!("unknown flags {:#x}", ask.flags));
    }
    let persons = &ask.persons[..ask.person_count as usize];
    for (number, person) in persons.iter().enumerate() {
        if person.party >= ask.party_count {
            let text = format!("person {number}: party {} does not exist", person.party);
            return refuse(Reason::Malformed, text);
        }
        if ask.parties[person.party as usize].flags & WireParty::PERSONS == 0 {
            let text = format!("person {number}: party {} has no PERSONS flag", person.party);
            return refuse(Reason::Malformed, text);
        }
        if person.seat as usize >= SEATS.len() {
            let text = format!("person {number}: seat {} does not exist", person.seat);
            return refuse(Reason::Malformed, text);
        }
    }
    Ok(())
}

fn beyond(number: usize) -> impl Fn(Misfit) -> Refusal {
    move |misfit| Refusal {
        reason: Reason::OutOfRange,
        text: format!("{} {}: {}", whose(number), misfit.what, misfit.remedy),
    }
}

fn party_of(ask: &Ask, number: usize, party: &WireParty) -> Result<scenario::Party, Refusal> {
    const KNOWN: u32 = WireParty::PERSONS | WireParty::MASS | WireParty::UNKNOWN | WireParty::CRUSH;
    let beyond = beyond(number);
    if party.flags & !KNOWN != 0 {
        let text = format!("party {number}: unknown flags {:#x}", party.flags);
        return refuse(Reason::Malformed, text);
    }
    let has = |flag: u32| party.flags & flag != 0;
    if has(WireParty::UNKNOWN)
        && (has(WireParty::PERSONS) || has(WireParty::MASS) || has(WireParty::CRUSH))
    {
        let text = format!("party {number}: a party of unknown kind has a shape only");
        return refuse(Reason::Misfit, text);
    }
    let persons = has(WireParty::PERSONS).then(|| {
        let listed = ask.persons[..ask.person_count as usize].iter();
        let own = listed.filter(|person| person.party as usize == number);
        own.map(|person| Occupant { seat: SEATS[person.seat as usize] }).collect()
    });
    Ok(scenario::Party {
        name: format_smolstr!("{number}"),
        place: place(number),
        // Bodies are in the store already: this path is never read.
        source: scenario::Source::File(scenario::FileRef {
            path: String::new(),
            place: place(number),
        }),
        size: None,
        mass_kg: has(WireParty::MASS)
            .then(|| live::mass_kg(party.mass_kg))
            .transpose()
            .map_err(&beyond)?,
        persons,
        responsibility: live::share("responsibility", party.responsibility).map_err(&beyond)?,
        is_unknown: has(WireParty::UNKNOWN),
        crush: has(WireParty::CRUSH)
            .then(|| live::crush(party.crush))
            .transpose()
            .map_err(&beyond)?,
    })
}

fn listed(ask: &Ask, mut candidates: Vec<Candidate>) -> Result<Vec<Candidate>, Refusal> {
    for (number, asked) in ask.candidates[..ask.candidate_count as usize].iter().enumerate() {
        let at = PARTIES_MAX + number;
        if asked.party >= ask.party_count || asked.party == ask.ego {
            let text = format!("candidate {number}: party {} cannot be hit", asked.party);
            return refuse(Reason::Malformed, text);
        }
        let beyond = beyond(at);
        let state = |motion: &Motion| {
            MotionState::new(motion.position_m, motion.angles_deg, motion.velocity_m_s)
                .map_err(&beyond)
        };
        candidates.push(Candidate {
            name: format_smolstr!("{number}"),
            place: place(at),
            probability: live::share("probability", asked.probability).map_err(&beyond)?,
            ego: state(&asked.ego)?,
            other: Opponent {
                party: PartyIndex(asked.party as usize),
                state: state(&asked.other)?,
            },
        });
    }
    Ok(candidates)
}

/// The request of a scenario. `model` gives the id of each party's model.
///
/// # Errors
///
/// If the scenario does not fit: it has too many persons, parties or candidates.
pub fn of_scenario(
    scenario: &Scenario,
    models: &[u32],
    unknown_is_fixed: bool,
) -> Result<Ask, String> {
    let mut ask = Ask::new(0);
    ask.ego = scenario.ego.0 as u32;
    ask.flags = if unknown_is_fixed { Ask::UNKNOWN_IS_FIXED } else { 0 };
    for (number, (party, model)) in scenario.parties.iter().zip(models).enumerate() {
        let mut row = WireParty::of_model(*model);
        row.responsibility = party.responsibility;
        row.flags = if party.is_unknown { WireParty::UNKNOWN } else { 0 };
        if let Some(mass_kg) = party.mass_kg {
            (row.mass_kg, row.flags) = (mass_kg, row.flags | WireParty::MASS);
        }
        if let Some(crush) = party.crush {
            (row.crush, row.flags) = (crush, row.flags | WireParty::CRUSH);
        }
        if let Some(persons) = party.persons.as_ref().filter(|_| !party.is_unknown) {
            row.flags |= WireParty::PERSONS;
            for person in persons {
                let seat = seat_number(person.seat);
                let row = protocol::public::Person { party: number as u32, seat };
                ask.add_person(row).ok_or("a request names at most 64 persons")?;
            }
        }
        ask.add_party(row).ok_or("a request has at most 17 parties")?;
    }
    for candidate in &scenario.candidates {
        let motion = |state: &MotionState| Motion {
            position_m: state.pose.translation,
            angles_deg: state.angles_deg,
            velocity_m_s: [state.velocity_m_s.x, state.velocity_m_s.y],
        };
        let row = protocol::public::WireCandidate {
            party: candidate.other.party.0 as u32,
            spare: 0,
            probability: candidate.probability,
            ego: motion(&candidate.ego),
            other: motion(&candidate.other.state),
        };
        ask.add_candidate(row).ok_or("a request has at most 16 candidates")?;
    }
    Ok(ask)
}

#[cfg(test)]
mod tests;
