//! Records that are missing, exchanged or out of order are detected.

mod forgery;

use super::*;
use crate::encode;
use crate::file::tests::record;

fn files() -> Vec<Vec<u8>> {
    let mut last = None;
    let names = ["a.toml", "b.toml", "c.toml", "d.toml"];
    let file = |name: &&str| {
        let (bytes, link) = encode(&record(name), last.as_ref(), None).expect("short");
        last = Some(link);
        bytes
    };
    names.iter().map(file).collect()
}

/// How many of these files are accepted before the first that is not.
///
/// Each is called by its own number, so that its name is not what is wrong.
fn accepted(files: &[&Vec<u8>]) -> (usize, Option<ChainError>) {
    let mut chain = Chain::new(None);
    for (at, bytes) in files.iter().enumerate() {
        if let Err(error) = chain.next(&named(bytes), bytes) {
            return (at, Some(error));
        }
    }
    (files.len(), None)
}

fn named(bytes: &[u8]) -> String {
    file_name(link(bytes).map_or(0, |(link, _)| link.number))
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
    let (_, first) = encode(&record("a.toml"), None, None).expect("short");
    let (forged, _) = encode(&record("x.toml"), Some(&first), None).expect("short");
    let (at, error) = accepted(&[&f[0], &forged, &f[2]]);
    assert_eq!(at, 2);
    assert!(matches!(error, Some(ChainError::Previous { .. })), "{error:?}");
}

#[test]
fn a_name_gives_the_number_of_its_record_or_none() {
    for number in [0, 7, 999_999, 1_000_000, u64::MAX] {
        assert_eq!(number_of(&file_name(number)), Some(number));
        assert_eq!(number_of(&format!("a/0.record/{}", file_name(number))), Some(number));
    }
    for name in ["", "1.record", "0000001.record", "+00001.record", "000001.recorx", "x.record"] {
        assert_eq!(number_of(name), None, "{name}");
    }
}

#[test]
fn a_record_under_the_name_of_another_is_found() {
    let f = files();
    let mut chain = Chain::new(None);
    chain.next("d/000000.record", &f[0]).expect("the first");
    for name in ["d/000002.record", "d/000001", "d/copy.record", "d/1.record"] {
        let error = chain.clone().next(name, &f[1]).expect_err(name);
        assert_eq!(error, ChainError::FileName { name: name.into(), found: 1 });
    }
    assert!(chain.next("d/000001.record", &f[1]).is_ok());
    // By itself, a record may have any name but that of another one.
    assert_eq!(Chain::new(None).single("copy.record", &f[1]), Ok(()));
    let swapped = Chain::new(None).single("000002.record", &f[1]);
    assert_eq!(swapped, Err(ChainError::FileName { name: "000002.record".into(), found: 1 }));
}
