//! Corrupted messages: bits flipped, bytes overwritten, words exchanged, pieces cut, repeated or
//! taken from other messages, wrong lengths. None is accepted.

use geometry::rng::Rng;
use trolley_protocol::{Boot, Head, Incarnation, MessageKind, RequestId, seal, verify};

const PEER: Incarnation = Incarnation { worker: 2, inc: 7 };
const BOOT: Boot = Boot(5);

struct RandomWords(Rng);

impl RandomWords {
    fn below(&mut self, end: usize) -> usize {
        self.0.below(end as u64) as usize
    }

    fn word(&mut self) -> u64 {
        self.0.bits()
    }
}

/// Header and payload in memory, with space after them for wrong lengths.
fn message(random: &mut RandomWords) -> Vec<u64> {
    let kind = if random.below(2) == 0 { MessageKind::Result } else { MessageKind::Batch };
    let payload: Vec<u64> = (0..random.below(64)).map(|_| random.word()).collect();
    let head = Head::new(BOOT, RequestId(random.word()), PEER, kind);
    let head = seal(Head { job: random.below(1000) as u32, ..head }, &payload);
    let mut words: Vec<u64> = bytemuck::cast::<Head, [u64; 8]>(head).to_vec();
    words.extend(payload);
    words
}

/// Checks like a receiver: length, then checksum, then the header's content.
fn is_accepted(words: &[u64]) -> bool {
    let (front, room) = words.split_at(8);
    let head: Head = bytemuck::pod_read_unaligned(bytemuck::cast_slice(front));
    let Some(payload) = room.get(..head.len as usize) else { return false };
    verify(&head, payload).is_ok() && head.accept(BOOT, PEER, room.len()).is_ok()
}

fn corrupt(random: &mut RandomWords, words: &[u64], other: &[u64]) -> Vec<u64> {
    let mut bad = words.to_vec();
    match random.below(8) {
        0 => bad[random.below(words.len())] ^= 1 << random.below(64),
        1 => {
            for _ in 0..1 + random.below(8) {
                bad[random.below(words.len())] ^= 1 << random.below(64);
            }
        }
        2 => {
            let at = random.below(words.len() * 8);
            bytemuck::cast_slice_mut::<u64, u8>(&mut bad)[at] = random.below(256) as u8;
        }
        3 => {
            let (a, b) = (random.below(words.len()), random.below(words.len()));
            bad.swap(a, b);
        }
        4 => bad.truncate(8 + random.below(words.len() - 7)),
        5 => {
            let from = random.below(words.len());
            let count = (1 + random.below(16)).min(words.len() - from);
            bad[from..from + count].fill(0);
        }
        6 => {
            let from = random.below(words.len().min(other.len()));
            let count = words.len().min(other.len()) - from;
            bad[from..from + count].copy_from_slice(&other[from..from + count]);
        }
        _ => {
            // The header's length, and the words for it.
            let len = random.below(80) as u64;
            bad[4] = bad[4] & 0xffff_ffff | len << 32;
            bad.resize(words.len().max(8 + len as usize), 0);
        }
    }
    bad
}

fn none_of(count: u64, seed: u64) -> (u64, u64) {
    let mut random = RandomWords(Rng::new(seed));
    let (mut tried, mut accepted) = (0, 0);
    let mut other = message(&mut random);
    while tried < count {
        let words = message(&mut random);
        assert!(is_accepted(&words), "what was sealed is accepted");
        for _ in 0..16 {
            let bad = corrupt(&mut random, &words, &other);
            // Unchanged words, or another whole sealed message: nothing is corrupt.
            let used =
                |words: &[u64]| words[..(8 + (words[4] >> 32) as usize).min(words.len())].to_vec();
            if used(&bad) == used(&words) || used(&bad) == used(&other) {
                continue;
            }
            tried += 1;
            accepted += u64::from(is_accepted(&bad));
        }
        other = words;
    }
    (tried, accepted)
}

#[test]
fn no_corrupted_message_is_accepted() {
    let (tried, accepted) = none_of(200_000, 1);
    assert_eq!(accepted, 0, "of {tried}");
}

/// Prints the counts: `cargo x corrupt`.
#[test]
#[ignore = "a minute: cargo x corrupt"]
fn of_ten_million_corrupted_messages_none_is_accepted() {
    let (tried, accepted) = none_of(10_000_000, 2);
    println!("{tried} corrupted messages, {accepted} accepted");
    assert_eq!(accepted, 0);
}
