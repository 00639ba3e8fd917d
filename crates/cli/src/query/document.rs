//! The JSON document of `trolley query --json`.

use super::names::{name_of, party};
use client::public::{WireAnswer, WireContact, WireExpected, WireMet, WirePlace, flag};
use serde::Serialize;
use trolley::Implausible;

/// What `--json` prints.
#[derive(Serialize)]
pub(super) struct Document<'a> {
    schema: &'static str,
    state: &'static str,
    reason: &'static str,
    text: &'a str,
    request: u64,
    queued_us: f64,
    worked_us: f64,
    ranking: Vec<Row<'a>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    members: Option<Members>,
    /// As `trolley rank` prints it: what is allowed and hardly true.
    #[serde(skip_serializing_if = "<[_]>::is_empty")]
    implausible: &'a [Implausible],
}

/// The members that harm is the mean of, as `trolley rank` prints them.
#[derive(Serialize)]
struct Members {
    count: u32,
    most: u32,
    replaced: u32,
    lead: Option<Lead>,
    is_late: bool,
    /// How many worlds were drawn; `None`: none were.
    worlds: Option<u32>,
}

/// By how much the best two differ.
#[derive(Serialize)]
struct Lead {
    mean: f64,
    error: f64,
}

/// One candidate of the ranking.
#[derive(Serialize)]
struct Row<'a> {
    name: &'a str,
    work: [f64; 2],
    range: [f64; 2],
    touches_nobody: bool,
    certain: bool,
    tied: bool,
    open_from_s: Option<f64>,
    contact_count: u32,
    contacts: Vec<Contact<'a>>,
    worst: Option<[f64; 2]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    expected: Option<Expected<'a>>,
}

/// What members say of a candidate, as `trolley rank` prints it.
#[derive(Serialize)]
struct Expected<'a> {
    contact: f64,
    meets: Vec<Met<'a>>,
    met_count: u32,
    injured: [f64; 2],
    open: u32,
    undecided: u32,
    spread: Option<Spread>,
    worlds: Option<f64>,
}

/// A party that a candidate meets in some members.
#[derive(Serialize)]
struct Met<'a> {
    party: &'a str,
    probability: f64,
    from_s: f64,
}

/// How the leading measure is spread over members.
#[derive(Serialize)]
struct Spread {
    error: f64,
    quantiles: [f64; 3],
    best: f64,
    regret: f64,
}

/// One of the first contacts of a candidate.
#[derive(Serialize)]
struct Contact<'a> {
    party: &'a str,
    time_s: f64,
    heavy: bool,
    closing_m_s: f64,
    delta_v_m_s: [[f64; 2]; 2],
}

pub(super) fn of_answer<'a>(
    scenario: &'a scenario::Scenario,
    answer: &'a WireAnswer,
    doubts: &'a [Implausible],
) -> Document<'a> {
    let contact = |contact: &WireContact| Contact {
        party: party(scenario, contact.party),
        time_s: contact.time_s,
        heavy: contact.flags & flag::HEAVY != 0,
        closing_m_s: contact.closing_m_s,
        delta_v_m_s: [contact.ego_delta_v_m_s, contact.other_delta_v_m_s],
    };
    let row = |place: &WirePlace| {
        let has = |bit: u32| place.flags & bit != 0;
        Row {
            name: name_of(scenario, place.candidate),
            work: place.work,
            range: place.range,
            touches_nobody: has(flag::TOUCHES_NOBODY),
            certain: has(flag::CERTAIN),
            tied: has(flag::TIED),
            open_from_s: has(flag::OPEN).then_some(place.open_from_s),
            contact_count: place.contact_count,
            contacts: place.listed().iter().map(contact).collect(),
            worst: has(flag::PERSON).then_some(place.worst),
            expected: place.expected().map(|of| expected(scenario, answer, place, of)),
        }
    };
    let lead = answer.lead().map(|(mean, error)| Lead { mean, error });
    let has_members = answer.ranking().iter().any(|place| place.expected().is_some());
    let members = has_members.then(|| Members {
        count: answer.members,
        most: answer.members_max,
        replaced: answer.replaced,
        lead,
        is_late: answer.is_late(),
        worlds: answer.has_worlds().then_some(answer.worlds),
    });
    Document {
        schema: "trolley.query/2",
        state: answer.verdict().name(),
        reason: answer.reason().name(),
        text: answer.text(),
        request: answer.request,
        queued_us: answer.queued_ns as f64 / 1e3,
        worked_us: answer.worked_ns as f64 / 1e3,
        ranking: answer.ranking().iter().map(row).collect(),
        members,
        implausible: doubts,
    }
}

fn expected<'a>(
    scenario: &'a scenario::Scenario,
    answer: &WireAnswer,
    place: &WirePlace,
    of: &WireExpected,
) -> Expected<'a> {
    let met = |met: &WireMet| Met {
        party: party(scenario, met.party),
        probability: met.probability,
        from_s: met.from_s,
    };
    let spread =
        Spread { error: of.error, quantiles: of.quantiles, best: of.best, regret: of.regret };
    Expected {
        contact: of.contact,
        meets: of.listed().iter().map(met).collect(),
        met_count: of.met_count,
        injured: of.injured,
        open: of.open,
        undecided: of.undecided,
        spread: place.has_spread().then_some(spread),
        worlds: answer.has_worlds().then_some(of.worlds),
    }
}
