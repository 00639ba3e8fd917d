//! Encodes the engine's answer for the wire. The only place where states are mapped.

use crate::ask::seat_number;
use coordinator::{AnswerRow, AnswerView};
use damage::AnswerState;
use protocol::public::{Reason, VERSION, WireAnswer, WirePlace, WireState, flag};

/// The verdict of a state.
fn verdict(state: AnswerState) -> WireState {
    match state {
        AnswerState::Complete => WireState::Complete,
        AnswerState::Certified => WireState::Certified,
        AnswerState::Degraded => WireState::Degraded,
        AnswerState::Refused => WireState::Refused,
    }
}

/// Encodes an answer. Candidates and parties are named by their numbers: see `ask.rs`.
pub(crate) fn lay_out(sequence: u64, answer: &AnswerView<'_>) -> WireAnswer {
    let verdict = verdict(answer.state());
    let reason = if verdict == WireState::Refused { Reason::Unassessable } else { Reason::None };
    let mut out = WireAnswer::without_ranking(sequence, verdict, reason, "");
    debug_assert_eq!(out.version, VERSION);
    if verdict == WireState::Refused {
        out.say("no candidate has a bound");
        return out;
    }
    for (row, place) in answer.rows().zip(&mut out.places) {
        *place = place_of(&row, answer);
        out.place_count += 1;
    }
    if let Some(assumption) = answer.assumption() {
        out.say(&assumption);
    }
    out
}

fn number(name: &str) -> u32 {
    name.parse().unwrap_or(u32::MAX)
}

fn place_of(row: &AnswerRow<'_>, answer: &AnswerView<'_>) -> WirePlace {
    let (harm, contact) = (row.harm, &row.harm.contact);
    let mut place = WirePlace {
        candidate: number(row.name),
        work: row.place.work.into(),
        range: row.place.range.into(),
        ego_delta_v_m_s: harm.delta_v[0].work.into(),
        other_delta_v_m_s: harm.delta_v[1].work.into(),
        ..WirePlace::default()
    };
    let mut set = |bit: u32, is_set: bool| place.flags |= if is_set { bit } else { 0 };
    set(flag::TOUCHES, contact.patch.is_some());
    set(flag::CERTAIN, row.place.certain);
    set(flag::TIED, row.is_tied);
    set(flag::UNEVALUABLE, harm.unevaluable.is_some());
    set(flag::MISSING, harm.is_open);
    set(flag::NEAR_MISS, contact.near_miss);
    if let Some(patch) = &contact.patch {
        place.depth_m = patch.depth_m.into();
    }
    let worst = harm.persons.iter().max_by(|a, b| a.work.hi().total_cmp(&b.work.hi()));
    if let Some(worst) = worst {
        place.flags |= flag::PERSON;
        place.worst_party = number(answer.party_of(worst));
        place.worst_seat = seat_number(worst.seat);
        place.worst = worst.work.into();
    }
    place
}
