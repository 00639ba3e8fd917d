//! A statement comes back as it was signed, and every changed byte is found.

use super::*;
use crate::key::tests::SECRET_PEM;
use proptest::prelude::*;

pub(crate) fn provenance() -> Provenance {
    Provenance {
        written_ns: 1_763_971_812_123_456_789,
        host: "vehicle-7".into(),
        deployment: Some(RecordedDeployment { name: "quad-core".into(), hash: Some([7; 32]) }),
        build: "0.1.0+b".into(),
    }
}

fn statement() -> Statement {
    Statement {
        kind: StatementKind::Record,
        chain: [3; 16],
        number: 7,
        hash: [5; 32],
        provenance: provenance(),
    }
}

#[test]
fn the_text_is_pinned_and_can_be_read_by_people() {
    let key = SigningKey::from_pem(SECRET_PEM).expect("a key");
    let text = statement().sign(&key);
    let mut lines: Vec<&str> = text.lines().collect();
    let signature = lines.pop().expect("a signature");
    let (chain, hash, deployment) = ("03".repeat(16), "05".repeat(32), "07".repeat(32));
    let expected = [
        "trolley statement 1".to_owned(),
        "of: record".to_owned(),
        format!("chain: {chain}"),
        "number: 7".to_owned(),
        format!("hash: {hash}"),
        "time: 2025-11-24T08:10:12.123456789Z".to_owned(),
        "host: vehicle-7".to_owned(),
        format!("deployment: quad-core {deployment}"),
        "build: 0.1.0+b".to_owned(),
        format!("key: {}", key.verifying_key()),
    ];
    assert_eq!(lines, expected);
    assert_eq!(signature.len(), "signature: ".len() + 128);
}

#[test]
fn every_changed_byte_every_cut_and_every_addition_is_found() {
    let good = statement().sign(&SigningKey::from_seed(&[3; 32])).into_bytes();
    assert!(SignedStatement::parse(&good).is_ok());
    for at in 0..good.len() {
        for flip in 1..=255 {
            let mut bad = good.clone();
            bad[at] ^= flip;
            assert!(SignedStatement::parse(&bad).is_err(), "byte {at} ^ {flip}");
        }
        assert!(SignedStatement::parse(&good[..at]).is_err(), "cut at {at}");
        let longer = [&good[..at], b"\n", &good[at..]].concat();
        assert!(SignedStatement::parse(&longer).is_err(), "line feed at {at}");
    }
    assert!(SignedStatement::parse(&[&good[..], b"x"].concat()).is_err());
}

#[test]
fn the_longest_statement_is_within_its_limit() {
    let long = "h".repeat(10_000);
    let deployment = Some(RecordedDeployment { name: long.clone(), hash: Some([255; 32]) });
    let provenance =
        Provenance { written_ns: u64::MAX, host: long.clone(), deployment, build: long };
    let statement = Statement { number: u64::MAX, provenance, ..statement() };
    let text = statement.sign(&SigningKey::from_seed(&[3; 32]));
    assert!(text.len() <= STATEMENT_MAX, "{}", text.len());
    assert!(SignedStatement::parse(text.as_bytes()).is_ok());
}

proptest! {
    /// Whatever a machine calls itself, its statement is read again, and lines cannot be forged.
    #[test]
    fn a_statement_comes_back(
        kind in prop::sample::select(StatementKind::ALL.to_vec()),
        chain: [u8; 16],
        (number, hash, written_ns) in any::<(u64, [u8; 32], u64)>(),
        (host, name, build) in (".{0,300}", "\\PC{0,40}", "(?s).{0,80}"),
        (deployed, of_file) in any::<(bool, bool)>(),
    ) {
        let deployment = deployed.then(|| {
            RecordedDeployment { name: name.clone(), hash: of_file.then_some(hash) }
        });
        let provenance = Provenance { written_ns, host, deployment, build };
        let stated = Statement { kind, chain, number, hash, provenance };
        let key = SigningKey::from_seed(&hash);
        let read = SignedStatement::parse(stated.sign(&key).as_bytes());
        let read = read.map_err(|error| TestCaseError::fail(error.to_string()))?;
        prop_assert_eq!(read.signer, key.verifying_key());
        let found = read.statement;
        prop_assert_eq!((found.kind, found.chain, found.number), (kind, chain, number));
        prop_assert_eq!((found.hash, found.provenance.written_ns), (hash, written_ns));
        prop_assert_eq!(found.provenance.host, word(&stated.provenance.host));
        prop_assert_eq!(found.provenance.build, word(&stated.provenance.build));
        let hash_found = found.provenance.deployment.map(|deployment| deployment.hash);
        prop_assert_eq!(hash_found, deployed.then(|| of_file.then_some(hash)));
    }

    #[test]
    fn no_bytes_are_taken_for_a_statement(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        prop_assert!(SignedStatement::parse(&bytes).is_err());
    }
}
