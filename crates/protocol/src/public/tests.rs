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
    ask.seal();
    assert!(ask.is_intact());
    for bit in 0..8 * ask.used_bytes() {
        let at = bytemuck::bytes_of_mut(&mut *ask);
        flip(at, bit);
        assert!(!ask.is_intact(), "bit {bit}");
        flip(bytemuck::bytes_of_mut(&mut *ask), bit);
    }
    let mut answer =
        WireAnswer::without_ranking(7, WireState::Busy, Reason::QueueFull, "").sealed();
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
