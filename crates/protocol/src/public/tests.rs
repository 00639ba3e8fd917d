//! No bit that counts changes unseen; what is added is there, and no more than there is room for.

use super::*;
use proptest::prelude::*;

/// Two parties, one candidate.
fn small() -> Box<Ask> {
    let mut ask = Ask::new(5.0);
    let still = WirePath::of_kind(WirePathKind::Place);
    let onward = WirePath::of_kind(WirePathKind::Onward);
    let [post, ego] = [30.0, 0.0].map(|x| WirePathState::at(0.0, [x, 0.0], 0.0));
    ask.ego = ask.add_party(WireParty::of_model(1)).unwrap();
    ask.add_party_on(WireParty::of_model(2), still, &[post]).unwrap();
    let path = ask.add_path(onward, &[ego.with_velocity([10.0, 0.0])]).unwrap();
    ask.add_candidate(path, &[]).unwrap();
    ask
}

fn flip(bytes: &mut [u8], bit: usize) {
    bytes[bit / 8] ^= 1 << (bit % 8);
}

#[test]
fn no_single_bit_of_a_request_or_an_answer_changes_unseen() {
    let mut ask = small();
    ask.set_members(8, 64);
    let errors = PartyErrors { lateral_m: Some(0.5), ..PartyErrors::default() };
    ask.parties[1] = ask.parties[1].with_errors(&errors);
    ask.seal();
    assert!(ask.is_intact());
    for bit in 0..8 * ask.used_bytes() {
        let at = bytemuck::bytes_of_mut(&mut *ask);
        flip(at, bit);
        assert!(!ask.is_intact(), "bit {bit}");
        flip(bytemuck::bytes_of_mut(&mut *ask), bit);
    }
    let mut answer = WireAnswer::without_ranking(7, WireState::Complete, Reason::None, "");
    (answer.flags, answer.members, answer.lead) = (flag::LEAD, 8, 0.25);
    answer.places[0] = WirePlace { flags: flag::MEMBERS, ..WirePlace::default() };
    let mut answer = answer.sealed();
    assert!(answer.is_intact());
    for bit in 0..8 * size_of::<WireAnswer>() {
        flip(bytemuck::bytes_of_mut(&mut answer), bit);
        assert!(!answer.is_intact(), "bit {bit}");
        flip(bytemuck::bytes_of_mut(&mut answer), bit);
    }
}

proptest! {
    /// Also many bits at once, and a new number of states, which decides what counts.
    #[test]
    fn changed_requests_are_not_intact(
        bits in prop::collection::btree_set(0_usize..8 * (Ask::BYTES_MIN + 160), 1..64),
        states in 0_u32..9_000,
    ) {
        let mut ask = small();
        ask.seal();
        for bit in &bits {
            flip(bytemuck::bytes_of_mut(&mut *ask), *bit);
        }
        prop_assert!(!ask.is_intact());
        let mut ask = small();
        ask.seal();
        ask.state_count = states;
        prop_assert_eq!(ask.is_intact(), states == 2);
    }
}

#[test]
fn what_is_added_has_its_number_and_room_ends() {
    let mut ask = small();
    assert_eq!((ask.ego, ask.party_count, ask.path_count, ask.state_count), (0, 2, 2, 2));
    assert_eq!((ask.paths[1].first_state, ask.paths[1].state_count), (1, 1));
    let states = [WirePathState::default(); STATES_PER_PATH_MAX + 1];
    let through = WirePath::of_kind(WirePathKind::States);
    assert_eq!(ask.add_path(through, &states), None);
    let mut paths = 2;
    while let Some(number) = ask.add_path(through, &states[..STATES_PER_PATH_MAX]) {
        assert_eq!(number, paths);
        paths += 1;
    }
    // Nothing of what had no room is left.
    assert_eq!((ask.path_count, ask.state_count), (113, 2 + 111 * 64));
    assert!(ask.state_count as usize + STATES_PER_PATH_MAX > STATES_MAX);
    let reaction = WireReaction { party: 1, path: 0 };
    assert_eq!(ask.add_candidate(0, &[reaction; REACTIONS_MAX]), Some(1));
    assert_eq!(ask.add_candidate(0, &[reaction]), None);
    assert_eq!((ask.reaction_count, ask.candidate_count), (128, 2));
}

#[test]
fn errors_that_are_set_are_used_and_all_others_are_the_usual() {
    let all = PartyErrors {
        lateral_m: Some(0.5),
        longitudinal_m: Some(0.0),
        correlation: Some(-0.25),
        yaw_deg: Some(3.0),
        speed_share: Some(0.125),
    };
    let mut party = WireParty::of_model(1);
    party.flags = WireParty::MASS;
    assert_eq!(party.errors(), PartyErrors::default());
    let known = party.with_errors(&all);
    assert_eq!((known.flags, known.errors()), (WireParty::MASS | WireParty::ERRORS, all));
    let one = PartyErrors { yaw_deg: Some(0.0), ..PartyErrors::default() };
    let known = known.with_errors(&one);
    assert_eq!((known.flags, known.errors()), (WireParty::MASS | WireParty::YAW, one));
    assert_eq!(known.with_errors(&PartyErrors::default()), party);
}

#[test]
fn what_is_not_known_is_said_so_and_no_number() {
    let answer = WireAnswer::without_ranking(7, WireState::Busy, Reason::QueueFull, "");
    assert!(answer.lead.is_nan() && answer.lead_error.is_nan());
    assert_eq!((answer.lead(), answer.is_late(), answer.members), (None, false, 0));
    let mut place = WirePlace::default();
    let WireExpected { contact, injured, error, quantiles, best, regret, worlds, .. } =
        place.expected;
    let figures = [contact, error, best, regret, worlds];
    assert!(figures.iter().chain(&injured).chain(&quantiles).all(|x| x.is_nan()));
    assert!(place.expected().is_none() && !place.has_spread() && place.hits_nobody());
    // NaN is equal to itself here: answers are compared bit by bit.
    assert_eq!(place, place);
    assert_eq!(answer, answer);
    let mut other = answer;
    other.lead = 0.0;
    assert_ne!(other, answer);
    // Where some members are open, nobody knows that it hits nobody.
    place.flags = flag::MEMBERS;
    place.expected.contact = 0.0;
    assert!(!place.hits_nobody());
    place.flags |= flag::SPREAD;
    assert!(place.hits_nobody());
    place.expected.met_count = 11;
    assert_eq!(place.expected.listed().len(), 8);
}

#[test]
fn a_request_is_copied_from_the_bytes_that_count() {
    let mut ask = small();
    ask.seal();
    let mut copy = Ask::new(1.0);
    assert_eq!(copy.fill(ask.used()), Some(()));
    assert_eq!(copy, ask);
    for length in [0, 100, Ask::BYTES_MIN, ask.used_bytes() - 8] {
        assert_eq!(Ask::new(1.0).fill(&ask.used()[..length]), None, "{length}");
    }
    let mut long = ask.used().to_vec();
    long.extend([0; 80]);
    assert_eq!(Ask::new(1.0).fill(&long), None);
}
