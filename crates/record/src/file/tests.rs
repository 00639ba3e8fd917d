//! A record comes back as it was written; nothing else is accepted; the bytes are pinned.

use super::*;
use crate::content::{
    Edge, Mode, OpenStep, PoseQuestion, RecordedBody, RecordedEnd, RecordedJob, RecordedRound,
    RecordedSearch, RecordedSource, RecordedSpan, RecordedStage, RecordedText, RecordedUntil,
    Settings,
};
use crate::key::tests::SECRET_PEM;
use crate::statement::tests::provenance;
use proptest::prelude::*;

pub(crate) fn record(name: &str) -> RecordContent {
    RecordContent {
        build: "0.1.0+b".into(),
        scenario: RecordedText::new(name, "schema = 1\n"),
        policy: RecordedText::new("p.toml", "p"),
        curves: RecordedText::new("c.toml", "c"),
        parameters: RecordedText::new("q.toml", "q"),
        files: vec![RecordedText::new("path.csv", "t_s")],
        settings: Settings {
            mode: Mode::Workers,
            workers: 4,
            depth: 8,
            tree: body::Build::Paper,
            leaf_size: 4,
            scheme: scenario::Scheme::BestMatchLoad,
            alpha: 0.5,
            batch: 16,
            queue: 64,
            seed: 0,
            unknown_is_fixed: false,
            members: 32,
            members_max: 128,
        },
        bodies: vec![
            RecordedBody {
                party: "ego".into(),
                source: RecordedSource::Generated,
                hash: "aa".into(),
            },
            RecordedBody {
                party: "suv".into(),
                source: RecordedSource::File { path: "suv.trolley".into(), hash: "bb".into() },
                hash: "cc".into(),
            },
        ],
        rounds: vec![RecordedRound {
            places: vec![PoseQuestion { candidate: 0, travel_m: 0.25 }],
            jobs: [RecordedEnd::Done, RecordedEnd::Cut, RecordedEnd::Abandoned]
                .map(|end| RecordedJob { place: 0, a: 3, b: 5, end })
                .to_vec(),
        }],
        until: RecordedUntil::Ordered,
        search: Some(RecordedSearch { over_at: Some(7) }),
        open_steps: vec![OpenStep { course: 2, number: 300 }, OpenStep { course: 3, number: 1 }],
        spans: vec![RecordedSpan { worker: 1, from_ns: 0, to_ns: 9 }],
        edges: vec![Edge { from: "a".into(), to: "b".into(), messages: 1, bytes: 64 }],
        stages: vec![RecordedStage { name: "work".into(), ms: 1.5 }],
        faults: vec!["worker 1 was lost".into()],
        answer: "{}".into(),
        explanation: "{}".into(),
    }
}

#[test]
fn a_record_comes_back_with_its_link() {
    let (bytes, first) = encode(&record("a.toml"), None, None).expect("short");
    assert_eq!(decode(&bytes), Ok((record("a.toml"), first, None)));
    assert_eq!((first.number, first.previous), (0, [0; 32]));
    let (bytes, second) = encode(&record("b.toml"), Some(&first), None).expect("short");
    assert_eq!(link(&bytes), Ok((second, None)));
    assert_eq!((second.number, second.previous), (1, first.hash));
}

/// A change of the layout or the codec must change [`VERSION`] too.
#[test]
fn the_bytes_are_pinned() {
    let (bytes, link) = encode(&record("a.toml"), None, None).expect("short");
    let hash: String = link.hash.iter().map(|byte| format!("{byte:02x}")).collect();
    assert_eq!((bytes.len(), VERSION), (GOLDEN.0, 19));
    assert_eq!(hash, GOLDEN.1);
}

const GOLDEN: (usize, &str) =
    (1061, "c7ebfd79f48fc0705a601dc9c4342316d7037f8aa370b1bea6107acf6aebbeca");

#[test]
fn every_changed_byte_and_every_cut_is_found() {
    let (good, _) = encode(&record("a.toml"), None, None).expect("short");
    for at in 0..good.len() {
        for flip in [1, 0x80, 0xff] {
            let mut bad = good.clone();
            bad[at] ^= flip;
            assert!(decode(&bad).is_err(), "byte {at} ^ {flip}");
        }
        assert!(decode(&good[..at]).is_err(), "cut at {at}");
    }
    let longer = [&good[..], &[0]].concat();
    let stated = good.len() as u64;
    assert_eq!(decode(&longer), Err(RecordError::Length { stated, found: stated + 1 }));
}

/// A record of a chain of this identity, signed with this key.
pub(crate) fn signed(
    name: &str,
    previous: Option<&Link>,
    key: &SigningKey,
    chain: ChainId,
) -> (Vec<u8>, Link) {
    let signer = RecordSigner { key, chain, provenance: provenance() };
    encode(&record(name), previous, Some(&signer)).expect("short")
}

#[test]
fn a_signed_record_comes_back_with_its_statement() {
    let key = SigningKey::from_pem(SECRET_PEM).expect("a key");
    let (bytes, first) = signed("a.toml", None, &key, [9; 16]);
    let (content, place, statement) = decode(&bytes).expect("signed");
    assert_eq!((content, place), (record("a.toml"), first));
    let SignedStatement { statement, signer } = statement.expect("signed");
    assert_eq!(signer, key.verifying_key());
    assert_eq!((statement.number, statement.hash, statement.chain), (0, first.hash, [9; 16]));
    assert_eq!(statement.provenance, provenance());
}

/// Every byte, even without the key: the statement is checked against the key that it names.
#[test]
fn every_changed_byte_and_every_cut_of_a_signed_record_is_found() {
    let key = SigningKey::from_seed(&[1; 32]);
    let (good, _) = signed("a.toml", None, &key, [9; 16]);
    for at in 0..good.len() {
        for flip in [1, 0x20, 0x80, 0xff] {
            let mut bad = good.clone();
            bad[at] ^= flip;
            assert!(link(&bad).is_err(), "byte {at} ^ {flip}");
        }
        assert!(link(&good[..at]).is_err(), "cut at {at}");
    }
}

/// With a new hash and a new length, as a forger would who lacks the key.
#[test]
fn what_was_changed_and_hashed_again_does_not_have_the_statement() {
    let key = SigningKey::from_seed(&[1; 32]);
    let (good, _) = signed("a.toml", None, &key, [9; 16]);
    let head: Head = bytemuck::pod_read_unaligned(&good[..HEAD]);
    let end = good.len() - head.statement as usize;
    let with = |head: Head, body: &[u8], statement: &[u8]| {
        let length = (HEAD + body.len() + statement.len()) as u64;
        let mut head = Head { length, statement: statement.len() as u32, ..head };
        head.hash = hash_of(&head, body);
        link(&[bytemuck::bytes_of(&head), body, statement].concat())
    };
    let (body, statement) = (&good[HEAD..end], &good[end..]);
    assert!(with(head, body, statement).is_ok());
    let mut other = body.to_vec();
    other[40] ^= 1;
    assert_eq!(with(head, &other, statement), Err(RecordError::NotSigned));
    let moved = Head { number: 1, ..head };
    assert_eq!(with(moved, body, statement), Err(RecordError::NotSigned));
    assert_eq!(with(head, body, b""), Err(RecordError::Statement(StatementError::Form)));
    let unsigned = Head { version: VERSION, ..head };
    let form = Err(RecordError::Statement(StatementError::Form));
    assert_eq!(with(unsigned, body, statement), form);
    // A statement of something else, by the right key.
    let signer = RecordSigner { key: &key, chain: [9; 16], provenance: provenance() };
    let of_head = signer.sign(StatementKind::Head, 0, head.hash);
    assert_eq!(with(head, body, of_head.as_bytes()), Err(RecordError::NotSigned));
}

#[test]
fn each_fault_is_told_apart_and_has_a_remedy() {
    let (good, _) = encode(&record("a.toml"), None, None).expect("short");
    let with = |at: usize, byte: u8| {
        let mut bad = good.clone();
        bad[at] = byte;
        decode(&bad).expect_err("changed")
    };
    assert_eq!(with(0, b'X'), RecordError::Foreign);
    assert_eq!(with(8, 99), RecordError::Version(99));
    assert!(matches!(with(16, 0), RecordError::Length { .. }));
    assert_eq!(with(24, 7), RecordError::Hash);
    assert_eq!(with(40, 7), RecordError::Hash);
    assert_eq!(with(good.len() - 1, 7), RecordError::Hash);
    assert_eq!(decode(b""), Err(RecordError::Foreign));
    assert!(!with(0, b'X').remedy().unwrap_or_default().is_empty());
}

proptest! {
    /// No bytes make it panic or take them for a record, even behind a sound head.
    #[test]
    fn no_bytes_are_taken_for_a_record(tail in prop::collection::vec(any::<u8>(), 0..400)) {
        prop_assert!(decode(&tail).is_err());
        let mut head = Head {
            magic: MAGIC,
            version: VERSION,
            statement: 0,
            length: (HEAD + tail.len()) as u64,
            number: 0,
            previous: [0; 32],
            hash: [0; 32],
        };
        head.hash = hash_of(&head, &tail);
        let bytes = [bytemuck::bytes_of(&head), &tail].concat();
        prop_assert!(matches!(decode(&bytes), Err(RecordError::Content(_))));
    }
}
