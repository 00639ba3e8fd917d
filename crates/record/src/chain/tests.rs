//! Records that are missing, exchanged or out of order are detected.

use super::*;
use crate::encode;
use crate::file::tests::record;

fn files() -> Vec<Vec<u8>> {
    let mut last = None;
    let names = ["a.toml", "b.toml", "c.toml", "d.toml"];
    let file = |name: &&str| {
        let (bytes, link) = encode(&record(name), last.as_ref()).expect("short");
        last = Some(link);
        bytes
    };
    names.iter().map(file).collect()
}

/// How many of these files are accepted before the first that is not.
fn accepted(files: &[&Vec<u8>]) -> (usize, Option<ChainError>) {
    let mut chain = Chain::default();
    for (at, bytes) in files.iter().enumerate() {
        if let Err(error) = chain.next(&format!("{at}"), bytes) {
            return (at, Some(error));
        }
    }
    (files.len(), None)
}

#[test]
fn a_whole_chain_is_accepted_and_its_beginning_too() {
    let files = files();
    let all: Vec<_> = files.iter().collect();
    assert_eq!(accepted(&all), (4, None));
    assert_eq!(accepted(&all[..2]), (2, None));
}

#[test]
fn what_is_missing_exchanged_or_out_of_turn_is_found() {
    let f = files();
    let number = |at, error: Option<ChainError>| {
        assert!(matches!(error, Some(ChainError::Number { .. })), "{at}: {error:?}");
    };
    let (at, error) = accepted(&[&f[1], &f[2]]);
    number(at, error);
    let (at, error) = accepted(&[&f[0], &f[2]]);
    assert_eq!(at, 1);
    number(at, error);
    let (at, error) = accepted(&[&f[0], &f[2], &f[1]]);
    number(at, error);
    // A sound record in the place of another: the next one reveals it.
    let (_, first) = encode(&record("a.toml"), None).expect("short");
    let (forged, _) = encode(&record("x.toml"), Some(&first)).expect("short");
    let (at, error) = accepted(&[&f[0], &forged, &f[2]]);
    assert_eq!(at, 2);
    assert!(matches!(error, Some(ChainError::Previous { .. })), "{error:?}");
}
