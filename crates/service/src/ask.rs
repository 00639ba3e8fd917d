//! Turns a received request into one for the engine: every value is checked here, once.
//!
//! Candidates and parties have numbers on the wire; their names in the engine are these numbers in
//! decimal. Nothing here depends on when a request arrives or on earlier requests.

use crate::deployment::Deployment;
use body::{BodyKind, BodyView, Meta, Seat};
use protocol::public::{
    Ask, CANDIDATES_MAX, ModelSet, PARTIES_MAX, PATHS_MAX, PATHS_PER_PARTY_MAX, PERSONS_MAX,
    PartyErrors, REACTIONS_MAX, Reason, STATES_MAX, STATES_PER_PATH_MAX, VERSION, WireParty,
    WirePath, WirePathKind, WirePathState,
};
use scenario::{
    Candidate, Errors, GivenMotion, GivenState, Misfit, Motion, Occupancy, OccupantGroup, Party,
    PartyIndex, Prediction, Reaction, Scenario, TextPosition, live, live::GivenErrors,
};
use smol_str::format_smolstr;

mod send;

pub use send::of_scenario;

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
    pub(crate) models: Vec<usize>,
    /// Assumptions about parties of unknown kind.
    pub(crate) has_unknown: bool,
}

/// Seats by their numbers on the wire; 0 is a person on foot, or on some seat.
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

/// Checks a request against the deployment and its bodies, whose identity is `model_set`.
pub(crate) fn check(
    ask: &Ask,
    deployment: &Deployment,
    (bodies, model_set): (&[(Meta, BodyView<'_>)], &ModelSet),
) -> Result<Checked, Refusal> {
    counts(ask)?;
    if ask.model_set != [0; 32] && ask.model_set != *model_set {
        let text = "the service has other bodies than the request was made for";
        return refuse(Reason::OtherModels, text);
    }
    let members = live::members(ask.members, ask.members_max, deployment.members);
    let mut members = members.map_err(Whose::Request.beyond())?;
    let limit = deployment.members_limit;
    if ask.members_max == 0 {
        members.most = members.most.min(limit).max(members.count);
    }
    if members.most > limit {
        let text = format!(
            "the request: {} members, and this service follows {limit} at most",
            members.most
        );
        return refuse(Reason::OutOfRange, text);
    }
    let horizon_s = live::horizon_s(ask.horizon_s).map_err(Whose::Request.beyond())?;
    let resolution_m = live::resolution_m(ask.resolution_m).map_err(Whose::Request.beyond())?;
    let request = Request { ask, horizon_s };
    let mut parties = Vec::with_capacity(ask.party_count as usize);
    let mut models = Vec::with_capacity(ask.party_count as usize);
    for (number, party) in ask.parties[..ask.party_count as usize].iter().enumerate() {
        let Some(model) = deployment.model(party.model) else {
            let text = format!("party {number}: the deployment has no model {}", party.model);
            return refuse(Reason::UnknownModel, text);
        };
        models.push(model);
        parties.push(request.party(number, party, bodies[model].0.kind)?);
    }
    let scenario = Scenario {
        name: String::new(),
        policy: None,
        curves: None,
        parameters: None,
        deadline: None,
        engine: deployment.engine.clone(),
        ego: PartyIndex(ask.ego as usize),
        horizon_s,
        resolution_m,
        members: Some(members),
        parties,
        candidates: request.candidates()?,
    };
    let misfit = |error: scenario::ScenarioError| Refusal {
        reason: Reason::Misfit,
        // The lines of a request are its paths.
        text: format!("{}: {}", Whose::at(error.place), error.what.replace("line ", "path ")),
    };
    let kinds: Vec<BodyKind> = models.iter().map(|model| bodies[*model].0.kind).collect();
    scenario.check_kinds("", &kinds).map_err(misfit)?;
    scenario.check_begin("").map_err(misfit)?;
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

/// What of a request an error is about: a place in errors of `scenario`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Whose {
    Request,
    Party(usize),
    Candidate(usize),
    Path(usize),
}

impl Whose {
    fn place(self) -> TextPosition {
        let (column, line) = match self {
            Self::Request => (0, 0),
            Self::Party(number) => (1, number),
            Self::Candidate(number) => (2, number),
            Self::Path(number) => (3, number),
        };
        TextPosition { line, column }
    }

    fn at(TextPosition { line, column }: TextPosition) -> Self {
        match column {
            1 => Self::Party(line),
            2 => Self::Candidate(line),
            3 => Self::Path(line),
            _ => Self::Request,
        }
    }

    fn beyond(self) -> impl Fn(Misfit) -> Refusal {
        move |misfit| Refusal {
            reason: Reason::OutOfRange,
            text: format!("{self}: {}: {}", misfit.what, misfit.remedy),
        }
    }
}

impl core::fmt::Display for Whose {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Request => f.write_str("the request"),
            Self::Party(number) => write!(f, "party {number}"),
            Self::Candidate(number) => write!(f, "candidate {number}"),
            Self::Path(number) => write!(f, "path {number}"),
        }
    }
}

/// Checks version, counts, flags and references, which decide what the rest means.
fn counts(ask: &Ask) -> Result<(), Refusal> {
    let malformed = |text: String| refuse(Reason::Malformed, text);
    if ask.version != VERSION {
        return malformed(format!("layout {} is not known, this is {VERSION}", ask.version));
    }
    for (what, count, least, most) in [
        ("candidate_count", ask.candidate_count, 1, CANDIDATES_MAX),
        ("party_count", ask.party_count, 2, PARTIES_MAX),
        ("person_count", ask.person_count, 0, PERSONS_MAX),
        ("path_count", ask.path_count, 1, PATHS_MAX),
        ("reaction_count", ask.reaction_count, 0, REACTIONS_MAX),
        ("state_count", ask.state_count, 1, STATES_MAX),
    ] {
        if !(least..=most).contains(&(count as usize)) {
            return malformed(format!("{what} is {count}, not {least} to {most}"));
        }
    }
    if ask.ego >= ask.party_count {
        return malformed(format!("the ego is party {}, which does not exist", ask.ego));
    }
    if ask.flags & !Ask::UNKNOWN_IS_FIXED != 0 {
        return malformed(format!("unknown flags {:#x}", ask.flags));
    }
    if ask.spare != 0 || ask.room != 0 {
        return malformed("what is spare is not 0".to_owned());
    }
    let mut all = 0;
    for (number, persons) in ask.persons[..ask.person_count as usize].iter().enumerate() {
        let of = persons.party;
        if of >= ask.party_count {
            return malformed(format!("persons {number}: party {of} does not exist"));
        }
        if ask.parties[of as usize].flags & WireParty::PERSONS == 0 {
            return malformed(format!("persons {number}: party {of} has no PERSONS flag"));
        }
        if persons.seat as usize >= SEATS.len() || persons.spare != 0 {
            return malformed(format!("persons {number}: seat {} does not exist", persons.seat));
        }
        all += u64::from(persons.count);
        if all > PERSONS_MAX as u64 {
            return malformed(format!("up to persons {number} there are {all}, not 256 at most"));
        }
    }
    Ok(())
}

/// A request whose counts are right.
struct Request<'a> {
    ask: &'a Ask,
    horizon_s: f64,
}

impl Request<'_> {
    fn party(&self, number: usize, party: &WireParty, kind: BodyKind) -> Result<Party, Refusal> {
        const KNOWN: u32 = WireParty::PERSONS
            | WireParty::MASS
            | WireParty::UNKNOWN
            | WireParty::CRUSH
            | WireParty::ERRORS;
        let beyond = Whose::Party(number).beyond();
        if party.flags & !KNOWN != 0 {
            let text = format!("party {number}: unknown flags {:#x}", party.flags);
            return refuse(Reason::Malformed, text);
        }
        if party.size_m.iter().any(|value| *value != 0.0) || party.room != 0 {
            let text = format!("party {number}: sizes are not used by this version: leave zeros");
            return refuse(Reason::Malformed, text);
        }
        let has = |flag: u32| party.flags & flag != 0;
        let is_unknown = has(WireParty::UNKNOWN);
        if is_unknown && party.flags & !WireParty::ERRORS != WireParty::UNKNOWN {
            let text = format!("party {number}: a party of unknown kind has a shape only");
            return refuse(Reason::Misfit, text);
        }
        Ok(Party {
            name: format_smolstr!("{number}"),
            place: Whose::Party(number).place(),
            // Bodies are in the store already: this path is never read.
            source: scenario::Source::File(scenario::FileRef {
                path: String::new(),
                place: Whose::Party(number).place(),
            }),
            size: None,
            mass_kg: has(WireParty::MASS)
                .then(|| live::mass_kg(party.mass_kg))
                .transpose()
                .map_err(&beyond)?,
            occupancy: self.occupancy(number, party, kind)?,
            responsibility: live::share("responsibility", party.responsibility).map_err(&beyond)?,
            is_unknown,
            crush: has(WireParty::CRUSH)
                .then(|| live::crush(party.crush))
                .transpose()
                .map_err(&beyond)?,
            errors: self.errors(number, party)?,
            predictions: self.predictions(number, party)?,
        })
    }

    fn errors(&self, number: usize, party: &WireParty) -> Result<Errors, Refusal> {
        // Who sets an error and forgets its flag would be ranked by the usual one.
        for (setting, flag, value) in [
            ("lateral_m", WireParty::LATERAL, party.lateral_m),
            ("longitudinal_m", WireParty::LONGITUDINAL, party.longitudinal_m),
            ("correlation", WireParty::CORRELATION, party.correlation),
            ("yaw_deg", WireParty::YAW, party.yaw_deg),
            ("speed_share", WireParty::SPEED, party.speed_share),
        ] {
            if party.flags & flag == 0 && value != 0.0 {
                let text = format!("party {number}: {setting} is {value}, and its flag is not set");
                return refuse(Reason::Malformed, text);
            }
        }
        let PartyErrors { lateral_m, longitudinal_m, correlation, yaw_deg, speed_share } =
            party.errors();
        let given = GivenErrors { lateral_m, longitudinal_m, correlation, yaw_deg, speed_share };
        live::errors(&given, number == self.ask.ego as usize).map_err(Whose::Party(number).beyond())
    }

    fn occupancy(
        &self,
        number: usize,
        party: &WireParty,
        kind: BodyKind,
    ) -> Result<Occupancy, Refusal> {
        if party.flags & WireParty::PERSONS == 0 {
            return Ok(Occupancy::Default);
        }
        let listed = self.ask.persons[..self.ask.person_count as usize].iter();
        let mut groups: Vec<OccupantGroup> = Vec::new();
        for persons in listed.filter(|persons| persons.party as usize == number) {
            let group = OccupantGroup { seat: SEATS[persons.seat as usize], count: persons.count };
            let group = live::group(Some(kind), group, &groups).map_err(|misfit| Refusal {
                reason: Reason::Misfit,
                text: format!("party {number}: {}", misfit.what),
            })?;
            groups.push(group);
        }
        Ok(if groups.is_empty() { Occupancy::Empty } else { Occupancy::Stated(groups) })
    }

    fn predictions(&self, number: usize, party: &WireParty) -> Result<Vec<Prediction>, Refusal> {
        let malformed = |text: &str| refuse(Reason::Malformed, format!("party {number}: {text}"));
        let count = party.path_count as usize;
        if number == self.ask.ego as usize {
            return match (count, party.first_path) {
                (0, 0) => Ok(Vec::new()),
                _ => malformed("it is the ego, whose motion is in the candidates"),
            };
        }
        if !(1..=PATHS_PER_PARTY_MAX).contains(&count) {
            return malformed(&format!("path_count is {count}, not 1 to 3"));
        }
        let first = party.first_path as usize;
        let Some(paths) = (first..).take(count).last().filter(|last| self.has_path(*last)) else {
            return malformed("a path of it does not exist");
        };
        let beyond = Whose::Party(number).beyond();
        let prediction = |path: usize| {
            let probability = self.ask.paths[path].probability;
            let probability = live::share("probability", probability).map_err(&beyond)?;
            Ok(Prediction { probability, motion: self.motion(path)? })
        };
        let predictions = (first..=paths).map(prediction).collect::<Result<Vec<_>, _>>()?;
        let probabilities = predictions.iter().map(|prediction| prediction.probability);
        live::sums_to_one(probabilities).map_err(&beyond)?;
        Ok(predictions)
    }

    fn has_path(&self, path: usize) -> bool {
        path < self.ask.path_count as usize
    }

    fn motion(&self, number: usize) -> Result<Motion, Refusal> {
        let path: &WirePath = &self.ask.paths[number];
        let malformed = |text: String| refuse(Reason::Malformed, format!("path {number}: {text}"));
        let kind = WirePathKind::from_number(path.kind);
        let Some(kind) = kind.filter(|_| path.spare == 0) else {
            return malformed(format!("kind {} does not exist", path.kind));
        };
        let (first, count) = (path.first_state as usize, path.state_count as usize);
        let most = if kind == WirePathKind::States { STATES_PER_PATH_MAX } else { 1 };
        if !(1..=most).contains(&count) {
            return malformed(format!("state_count is {count}, not 1 to {most}"));
        }
        let all = &self.ask.states[..self.ask.state_count as usize];
        let Some(states) = first.checked_add(count).and_then(|end| all.get(first..end)) else {
            return malformed("a state of it does not exist".to_owned());
        };
        if let Some(state) = states.iter().position(|state| state.flags > WirePathState::VELOCITY) {
            return malformed(format!("state {state}: unknown flags"));
        }
        let now = &states[0];
        let has_velocity = now.flags & WirePathState::VELOCITY != 0;
        let given = match kind {
            WirePathKind::Place => {
                GivenMotion::Place { position_m: now.position_m, angles_deg: now.angles_deg }
            }
            WirePathKind::Onward if !has_velocity || now.t_s != 0.0 => {
                return malformed("what goes on needs its velocity at time 0".to_owned());
            }
            WirePathKind::Onward => GivenMotion::Onward {
                position_m: now.position_m,
                angles_deg: now.angles_deg,
                velocity_m_s: now.velocity_m_s,
                yaw_rate_deg_s: path.yaw_rate_deg_s,
            },
            WirePathKind::States => GivenMotion::States(states.iter().map(given).collect()),
        };
        live::motion(given, self.horizon_s, Whose::Path(number).place()).map_err(|wrong| {
            let state = wrong.state.map_or(String::new(), |state| format!(", state {state}"));
            Refusal {
                reason: Reason::OutOfRange,
                text: format!(
                    "path {number}{state}: {}: {}",
                    wrong.misfit.what, wrong.misfit.remedy
                ),
            }
        })
    }

    fn candidates(&self) -> Result<Vec<Candidate>, Refusal> {
        let ask = self.ask;
        let mut candidates = Vec::with_capacity(ask.candidate_count as usize);
        for (number, asked) in ask.candidates[..ask.candidate_count as usize].iter().enumerate() {
            let malformed =
                |text: &str| refuse(Reason::Malformed, format!("candidate {number}: {text}"));
            let all = &ask.reactions[..ask.reaction_count as usize];
            let (first, count) = (asked.first_reaction as usize, asked.reaction_count as usize);
            let own = first.checked_add(count).and_then(|end| all.get(first..end));
            let Some(own) = own.filter(|_| asked.spare == 0) else {
                return malformed("a reaction of it does not exist");
            };
            if !self.has_path(asked.path as usize)
                || !own.iter().all(|reaction| self.has_path(reaction.path as usize))
            {
                return malformed("a path of it does not exist");
            }
            let mut reactions: Vec<Reaction> = Vec::with_capacity(count);
            for reaction in own {
                if reaction.party >= ask.party_count || reaction.party == ask.ego {
                    return malformed(&format!("party {} cannot react", reaction.party));
                }
                let party = PartyIndex(reaction.party as usize);
                if reactions.iter().any(|before| before.party == party) {
                    return malformed(&format!("party {} reacts twice", reaction.party));
                }
                reactions.push(Reaction { party, motion: self.motion(reaction.path as usize)? });
            }
            reactions.sort_by_key(|reaction| reaction.party.0);
            candidates.push(Candidate {
                name: format_smolstr!("{number}"),
                place: Whose::Candidate(number).place(),
                ego: self.motion(asked.path as usize)?,
                reactions,
            });
        }
        Ok(candidates)
    }
}

fn given(state: &WirePathState) -> GivenState {
    let has_velocity = state.flags & WirePathState::VELOCITY != 0;
    GivenState {
        time_s: state.t_s,
        position_m: state.position_m,
        angles_deg: state.angles_deg,
        velocity_m_s: has_velocity.then_some(state.velocity_m_s),
    }
}

#[cfg(test)]
pub(crate) mod tests;
