//! Invariants of the header: a sealed message is accepted, and nothing else.

use super::*;
use proptest::prelude::*;

const PEER: Incarnation = Incarnation { worker: 2, inc: 7 };

fn sealed(payload: &[u64]) -> Head {
    seal(Head::new(Boot(5), RequestId(9), PEER, MessageKind::Result), payload)
}

proptest! {
    #[test]
    fn a_sealed_message_is_accepted(payload in prop::collection::vec(any::<u64>(), 0..40)) {
        let head = sealed(&payload);
        prop_assert_eq!(head.accept(Boot(5), PEER, payload.len()), Ok(MessageKind::Result));
        prop_assert_eq!(verify(&head, &payload), Ok(()));
    }

    #[test]
    fn no_flipped_bit_passes(
        payload in prop::collection::vec(any::<u64>(), 1..40),
        at in any::<prop::sample::Index>(),
        bit in 0_u32..64,
    ) {
        let mut words = vec![0_u64; 8 + payload.len()];
        let head = sealed(&payload);
        words[..8].copy_from_slice(bytemuck::cast_slice(bytemuck::bytes_of(&head)));
        words[8..].copy_from_slice(&payload);
        let at = at.index(words.len());
        words[at] ^= 1 << bit;
        let broken: Head = bytemuck::pod_read_unaligned(bytemuck::cast_slice(&words[..8]));
        let refused = broken.accept(Boot(5), PEER, payload.len()).is_err()
            || verify(&broken, &words[8..]).is_err();
        prop_assert!(refused);
    }
}

#[test]
fn another_run_another_worker_and_a_lying_length_are_told_apart() {
    let head = sealed(&[1, 2, 3]);
    assert_eq!(head.accept(Boot(6), PEER, 3), Err(Reject::Stale));
    let other = Incarnation { inc: 8, ..PEER };
    assert_eq!(head.accept(Boot(5), other, 3), Err(Reject::NotOwner));
    assert_eq!(head.accept(Boot(5), PEER, 2), Err(Reject::Length));
    assert_eq!(Head { layout: 0, ..head }.accept(Boot(5), PEER, 3), Err(Reject::Foreign));
    assert_eq!(Head { kind: 99, ..head }.accept(Boot(5), PEER, 3), Err(Reject::Foreign));
}
