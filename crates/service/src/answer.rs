//! Encodes the engine's answer for the wire. The only place where states are mapped.

use crate::ask::seat_number;
use body::Seat;
use coordinator::{Answer, ContactRow, CourseRow, ExpectedRow};
use damage::AnswerState;
use damage::course::Severity;
use protocol::public::{
    Reason, WireAnswer, WireContact, WireExpected, WireMet, WirePlace, WireState, flag,
};

/// The verdict of a state.
fn verdict(state: AnswerState) -> WireState {
    match state {
        AnswerState::Complete => WireState::Complete,
        AnswerState::Certified => WireState::Certified,
        AnswerState::Degraded => WireState::Degraded,
        AnswerState::Refused => WireState::Refused,
    }
}

/// Encodes an answer. Candidates and parties are named by their numbers: see `ask.rs`. Where the
/// policy lets no candidate be chosen there is no ranking, lest anybody take its first place.
pub(crate) fn lay_out(sequence: u64, answer: &Answer) -> WireAnswer {
    if let Some(refusal) = answer.refusal() {
        let (refused, reason) = (WireState::Refused, Reason::NoneAcceptable);
        return WireAnswer::without_ranking(sequence, refused, reason, &refusal.sentence());
    }
    let verdict = verdict(answer.state);
    let reason = if verdict == WireState::Refused { Reason::Unassessable } else { Reason::None };
    let mut out = WireAnswer::without_ranking(sequence, verdict, reason, "");
    if verdict == WireState::Refused {
        out.say(answer.missing.first().map_or("no candidate has a bound", String::as_str));
        return out;
    }
    for (row, place) in answer.ranking.iter().zip(&mut out.places) {
        *place = place_of(row, answer);
        out.place_count += 1;
    }
    write_members(&mut out, answer);
    let said = answer.missing.first().or_else(|| answer.assumptions.first());
    if let Some(said) = said {
        out.say(said);
    }
    out
}

/// What members and worlds say of the answer as a whole.
fn write_members(out: &mut WireAnswer, answer: &Answer) {
    (out.members, out.members_max) = (1, 1);
    let mut set = |bit: u32, is_set: bool| out.flags |= if is_set { bit } else { 0 };
    if let Some(members) = &answer.members {
        set(flag::LATE, members.is_late);
        set(flag::LEAD, members.lead.is_some());
        set(flag::WORLDS, answer.worlds.is_some());
        (out.members, out.members_max) = (members.count, members.most);
        out.replaced = members.replaced;
        if let Some(lead) = members.lead {
            (out.lead, out.lead_error) = (lead.mean, lead.error);
        }
        out.worlds = answer.worlds.as_ref().map_or(0, |worlds| worlds.count);
    } else {
        set(flag::LATE, answer.ranking.iter().any(|row| row.is_stated_alone));
    }
}

/// What members say of a candidate.
fn expected_of(row: &ExpectedRow) -> WireExpected {
    let mut out = WireExpected {
        contact: row.contact,
        injured: row.injured.into(),
        worlds: row.worlds.unwrap_or(f64::NAN),
        open: row.open,
        undecided: row.undecided,
        met_count: row.meets.len() as u32,
        ..WireExpected::UNKNOWN
    };
    if let Some(spread) = &row.spread {
        (out.error, out.quantiles) = (spread.error, spread.quantiles);
        (out.best, out.regret) = (spread.best, spread.regret);
    }
    for (met, row) in out.meets.iter_mut().zip(&row.meets) {
        *met = WireMet {
            party: number(&row.party),
            probability: row.probability,
            from_s: row.from_s,
            ..WireMet::default()
        };
    }
    out
}

fn number(name: &str) -> u32 {
    name.parse().unwrap_or(u32::MAX)
}

fn place_of(row: &CourseRow, answer: &Answer) -> WirePlace {
    let mut place = WirePlace {
        candidate: number(&row.name),
        work: row.work.into(),
        range: row.range.into(),
        contact_count: row.contacts.len() as u32,
        ..WirePlace::default()
    };
    let mut set = |bit: u32, is_set: bool| place.flags |= if is_set { bit } else { 0 };
    set(flag::TOUCHES_NOBODY, row.touches_nobody());
    set(flag::CERTAIN, row.certain);
    set(flag::TIED, answer.tie_class.len() > 1 && answer.tie_class.contains(&row.name));
    set(flag::UNEVALUABLE, row.contacts.iter().any(|contact| contact.unevaluable.is_some()));
    set(flag::OPEN, row.open_from_s.is_some());
    set(flag::NEAREST, row.nearest.is_some());
    set(flag::PERSON, !row.persons.is_empty());
    set(flag::ALTERNATIVE, !row.alternatives.is_empty());
    set(flag::MEMBERS, row.expected.is_some());
    set(flag::STATED_ALONE, row.is_stated_alone);
    set(flag::SPREAD, row.expected.as_ref().is_some_and(|of| of.spread.is_some()));
    if let Some(expected) = &row.expected {
        place.expected = expected_of(expected);
    }
    place.open_from_s = row.open_from_s.unwrap_or(0.0);
    if let Some(nearest) = &row.nearest {
        place.nearest_party = number(&nearest.party);
        (place.nearest_m, place.nearest_s) = (nearest.gap_m, nearest.time_s);
    }
    let worst = row.persons.iter().max_by(|a, b| a.work.hi().total_cmp(&b.work.hi()));
    if let Some(worst) = worst {
        let is_seat = |seat: &Seat| Some(seat.name()) == worst.seat;
        place.worst_party = number(&worst.party);
        place.worst_seat = seat_number(Seat::ALL.into_iter().find(is_seat));
        place.worst = worst.work.into();
    }
    for (contact, row) in place.contacts.iter_mut().zip(&row.contacts) {
        *contact = contact_of(row);
    }
    place
}

fn contact_of(row: &ContactRow) -> WireContact {
    let flags = [
        (flag::HEAVY, row.severity == Severity::Heavy),
        (flag::MAY_BE_OTHER, row.may_be_other),
        (flag::AT_START, row.is_at_start),
        (flag::TOUCHES, row.is_certain),
        (flag::FIXED, row.is_other_fixed),
    ];
    let flags = flags.iter().filter(|(_, is_set)| *is_set).map(|(bit, _)| bit);
    WireContact {
        party: number(&row.party),
        flags: flags.fold(0, |all, bit| all | bit),
        time_s: row.time_s,
        closing_m_s: row.closing_m_s,
        ego_delta_v_m_s: row.delta_v_m_s[0].work.into(),
        other_delta_v_m_s: row.delta_v_m_s[1].work.into(),
    }
}

#[cfg(test)]
mod tests {
    //! What the policy refuses has no ranking, whatever its state.
    use super::*;
    use damage::Note;

    #[test]
    fn where_the_policy_lets_none_be_chosen_there_is_no_first_place() {
        let missing = Some("0".into());
        for state in [AnswerState::Complete, AnswerState::Certified, AnswerState::Degraded] {
            let answer = Answer {
                state,
                policy: "board".to_owned(),
                ranking: Vec::new(),
                tie_class: Vec::new(),
                notes: vec![
                    Note::EgoOnly,
                    Note::Refused { at_most: 0.1, missing: missing.clone() },
                ],
                assumptions: Vec::new(),
                settled_places: 0,
                missing: Vec::new(),
                implausible: Vec::new(),
                members: None,
                worlds: None,
            };
            let out = lay_out(7, &answer);
            assert_eq!((out.verdict(), out.reason()), (WireState::Refused, Reason::NoneAcceptable));
            assert_eq!((out.place_count, out.sequence), (0, 7));
            assert!(
                out.text().starts_with("none is acceptable under the policy"),
                "{}",
                out.text()
            );
        }
    }
}
