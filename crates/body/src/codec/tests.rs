//! The bytes are pinned; every encoding survives a round trip; nothing else is accepted.

use super::*;
use crate::impact::OwnParameters;
use crate::meta::{BodyKind, Build, Meta, Occupant, Seat};
use crate::outline::{Band, Outlines};

fn meta() -> Meta {
    Meta {
        name: "ab".into(),
        kind: BodyKind::Suv,
        mass_kg: Some(1.5),
        centre_m: [1.0, -2.0, 0.5],
        gyration_m: 0.25,
        mass_source: "s".into(),
        impact: OwnParameters { mass_share: Some(0.25), ..OwnParameters::default() },
        impact_source: "i".into(),
        occupants: Some(vec![Occupant { seat: Some(Seat::RearLeft) }, Occupant { seat: None }]),
        parts: vec!["p".into()],
        origin: "o".into(),
        origin_hash: "h".into(),
        degenerate: 3,
        build: Build::Sah,
        leaf_size: 4,
        depth: 5,
        outlines: Outlines {
            bands: vec![Band { height_m: [0.5, 1.0], rings: vec![vec![[1.0, 2.0]]] }],
        },
        front_height_m: Some(0.5),
    }
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Model files and records number seats: a new one does not change what the others mean.
#[test]
fn the_numbers_of_seats_are_pinned() {
    for (number, seat) in (0_u32..).zip(Seat::ALL) {
        let bytes = encode(&Occupant { seat: Some(seat) }).expect("small");
        assert_eq!((bytes[0], &bytes[1..]), (1, &number.to_le_bytes()[..]), "{}", seat.name());
    }
    assert_eq!(Seat::ALL[5..], [Seat::Rider, Seat::Pillion]);
}

#[test]
fn the_bytes_are_pinned() {
    let golden = concat!(
        "0200000000000000",
        "6162",
        "01000000",
        "01000000000000f83f",
        "000000000000f03f00000000000000c0000000000000e03f",
        "000000000000d03f",
        "0100000000000000",
        "73",
        "0000000000",
        "01000000000000d03f",
        "0100000000000000",
        "69",
        "01",
        "0200000000000000",
        "0102000000",
        "00",
        "0100000000000000",
        "0100000000000000",
        "70",
        "0100000000000000",
        "6f",
        "0100000000000000",
        "68",
        "03000000",
        "02000000",
        "04000000",
        "05000000",
        "0100000000000000",
        "000000000000e03f000000000000f03f",
        "0100000000000000",
        "0100000000000000",
        "000000000000f03f0000000000000040",
        "01000000000000e03f",
    );
    let bytes = encode(&meta()).expect("small");
    assert_eq!(hex(&bytes), golden);
    assert_eq!(decode::<Meta>(&bytes), Ok(meta()));
}

#[test]
fn a_shortened_or_lengthened_encoding_is_refused() {
    let mut bytes = encode(&meta()).expect("small");
    for cut in 0..bytes.len() {
        assert!(decode::<Meta>(&bytes[..cut]).is_err(), "cut at {cut}");
    }
    bytes.push(0);
    let given = bytes.len();
    assert_eq!(decode::<Meta>(&bytes), Err(CodecError::Trailing { used: given - 1, given }));
}

#[test]
fn a_length_that_lies_allocates_nothing() {
    // A vector of 2^60 strings in eight bytes.
    let bytes = (1_u64 << 60).to_le_bytes();
    assert!(matches!(decode::<Vec<String>>(&bytes), Err(CodecError::Decode(_))));
}

#[test]
fn what_is_too_long_to_read_is_not_written() {
    let long = "x".repeat(ENCODED_MAX);
    assert_eq!(encode(&long), Err(CodecError::TooLong(ENCODED_MAX + 8)));
}
