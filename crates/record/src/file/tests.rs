//! A record comes back as it was written; nothing else is accepted; the bytes are pinned.

use super::*;
use crate::content::{
    Edge, Mode, PoseQuestion, RecordedBody, RecordedEnd, RecordedJob, RecordedMoment,
    RecordedSource, RecordedSpan, RecordedStage, RecordedText, Settings,
};
use proptest::prelude::*;

pub(crate) fn record(name: &str) -> RecordContent {
    RecordContent {
        build: "0.1.0+b".into(),
        scenario: RecordedText::new(name, "schema = 1\n"),
        policy: RecordedText::new("p.toml", "p"),
        curves: RecordedText::new("c.toml", "c"),
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
        places: vec![PoseQuestion { candidate: 0, is_survey: true, travel_m: -0.25 }],
        jobs: [RecordedEnd::Done, RecordedEnd::Cut, RecordedEnd::Abandoned]
            .map(|end| RecordedJob { place: 0, a: 3, b: 5, end })
            .to_vec(),
        moments: vec![RecordedMoment {
            at_ns: 9,
            jobs: 3,
            state: "complete".into(),
            work: vec![[0., 1.]],
        }],
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
    let (bytes, first) = encode(&record("a.toml"), None).expect("short");
    assert_eq!(decode(&bytes), Ok((record("a.toml"), first)));
    assert_eq!((first.number, first.previous), (0, [0; 32]));
    let (bytes, second) = encode(&record("b.toml"), Some(&first)).expect("short");
    assert_eq!(link(&bytes), Ok(second));
    assert_eq!((second.number, second.previous), (1, first.hash));
}

/// A change of the layout or the codec must change [`VERSION`] too.
#[test]
fn the_bytes_are_pinned() {
    let (bytes, link) = encode(&record("a.toml"), None).expect("short");
    let hash: String = link.hash.iter().map(|byte| format!("{byte:02x}")).collect();
    assert_eq!((bytes.len(), VERSION), (GOLDEN.0, 3));
    assert_eq!(hash, GOLDEN.1);
}

const GOLDEN: (usize, &str) =
    (870, "cd24ca2f5245ef9c65672fbc45d05f44b999735db51fb59a2744085e7a0cb0a9");

#[test]
fn every_changed_byte_and_every_cut_is_found() {
    let (good, _) = encode(&record("a.toml"), None).expect("short");
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

#[test]
fn each_fault_is_told_apart_and_has_a_remedy() {
    let (good, _) = encode(&record("a.toml"), None).expect("short");
    let with = |at: usize, byte: u8| {
        let mut bad = good.clone();
        bad[at] = byte;
        decode(&bad).expect_err("changed")
    };
    assert_eq!(with(0, b'X'), RecordError::Foreign);
    assert_eq!(with(8, 9), RecordError::Version(9));
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
            spare: 0,
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
