//! Signed chains: every change by somebody without the key is found and named; what a crash leaves
//! is not called forgery, and can be continued.

use super::*;
use crate::file::tests::signed;
use crate::key::SigningKey;
use crate::statement::tests::provenance;
use crate::statement::{ChainId, Statement};
use proptest::prelude::*;

const CHAIN: ChainId = [9; 16];
const OTHER: ChainId = [8; 16];

fn key(seed: u8) -> SigningKey {
    SigningKey::from_seed(&[seed; 32])
}

/// A folder: its head, and its records with their names.
#[derive(Clone, Debug, PartialEq)]
struct Folder {
    head: Option<Vec<u8>>,
    files: Vec<(String, Vec<u8>)>,
}

fn head(count: u64, hash: [u8; 32], chain: ChainId, key: &SigningKey) -> Vec<u8> {
    let (kind, number, provenance) = (StatementKind::Head, count, provenance());
    Statement { kind, chain, number, hash, provenance }.sign(key).into_bytes()
}

/// What a folder held after each of its writes: the empty head, record, head, record, head …
fn history(count: u64, chain: ChainId, key: &SigningKey, salt: &str) -> Vec<Folder> {
    let mut folder = Folder { head: Some(head(0, [0; 32], chain, key)), files: Vec::new() };
    let (mut states, mut last) = (vec![folder.clone()], None);
    for number in 0..count {
        let (bytes, link) = signed(&format!("{salt}{number}"), last.as_ref(), key, chain);
        folder.files.push((file_name(number), bytes));
        states.push(folder.clone());
        folder.head = Some(head(number + 1, link.hash, chain, key));
        states.push(folder.clone());
        last = Some(link);
    }
    states
}

fn whole(count: u64) -> Folder {
    history(count, CHAIN, &key(1), "s").pop().expect("states")
}

/// The check of a folder as a program makes it: files in the order of their names.
fn check(folder: &Folder, key: Option<&SigningKey>) -> Result<Proof, ChainError> {
    let mut chain = Chain::new(key.map(SigningKey::verifying_key));
    if let Some(head) = &folder.head {
        chain.head(HEAD_FILE, head)?;
    }
    let mut files = folder.files.clone();
    files.sort();
    for (name, bytes) in &files {
        chain.next(name, bytes)?;
    }
    chain.finish(HEAD_FILE)
}

fn checked(folder: &Folder) -> Result<Proof, ChainError> {
    check(folder, Some(&key(1)))
}

fn continued(folder: &Folder, key: Option<&SigningKey>) -> Result<Resume, ChainError> {
    let head = folder.head.as_ref().map(|bytes| SignedStatement::parse(bytes).expect("a head"));
    let last = folder.files.last().map(|(name, bytes)| {
        let (link, statement) = link(bytes).expect("a record");
        (name.as_str(), link, statement)
    });
    let last = last.as_ref().map(|(name, link, signed)| (*name, *link, signed.as_ref()));
    resume(last, head.as_ref(), key.map(SigningKey::verifying_key))
}

/// Whatever ends a writer, its chain passes, the words say what happened, and it can be continued.
#[test]
fn every_state_of_a_writer_passes_and_can_be_continued() {
    let signer = key(1).verifying_key();
    for (step, folder) in history(4, CHAIN, &key(1), "s").iter().enumerate() {
        let count = step as u64 / 2;
        let after = step as u64 % 2;
        let proof = checked(folder).expect("a crash is no forgery");
        let head = Some(HeadProof { count, after });
        assert_eq!(proof, Proof::Signed { key: signer, head });
        assert_eq!(proof.to_string().contains("no sign of forgery"), after == 1, "{proof}");
        let resumed = Resume { chain: Some(CHAIN), needs_head: after == 1 };
        assert_eq!(continued(folder, Some(&key(1))), Ok(resumed), "step {step}");
        // Without the key, it does not say that nothing was forged.
        let unproved = check(folder, None).expect("intact").to_string();
        assert!(unproved.contains("accidents, not forgery"), "{unproved}");
    }
    let nothing = Folder { head: None, files: Vec::new() };
    assert_eq!(continued(&nothing, Some(&key(1))), Ok(Resume { chain: None, needs_head: true }));
    assert_eq!(continued(&nothing, None), Ok(Resume { chain: None, needs_head: false }));
}

#[test]
fn every_changed_byte_of_a_signed_chain_is_found() {
    let good = whole(3);
    let mut tried = 0;
    for at in 0..good.head.as_ref().map_or(0, Vec::len) {
        let mut bad = good.clone();
        bad.head.as_mut().expect("a head")[at] ^= 0x21;
        let error = checked(&bad).expect_err("byte of the head");
        assert!(error.to_string().contains(HEAD_FILE), "{error}");
        tried += 1;
    }
    for file in 0..good.files.len() {
        for at in 0..good.files[file].1.len() {
            let mut bad = good.clone();
            bad.files[file].1[at] ^= 0x21;
            let error = checked(&bad).expect_err("byte of a record").to_string();
            assert!(error.contains(&good.files[file].0), "byte {at}: {error}");
            tried += 1;
        }
    }
    assert!(tried > 4000, "{tried}");
}

#[test]
fn another_key_a_missing_signature_and_a_missing_head_are_named() {
    let good = whole(3);
    let error = check(&good, Some(&key(2))).expect_err("another key");
    assert!(matches!(&error, ChainError::Key { name, .. } if name == HEAD_FILE), "{error}");
    let without = Folder { head: None, ..good.clone() };
    assert_eq!(checked(&without), Err(ChainError::NoHead { name: HEAD_FILE.into() }));
    assert!(matches!(continued(&without, Some(&key(1))), Err(ChainError::NoHead { .. })));
    // A chain that a forger made anew, without a key and with one of his own.
    let forged = history(3, CHAIN, &key(3), "f").pop().expect("states");
    assert!(matches!(checked(&forged), Err(ChainError::Key { .. })));
    let headless = Folder { head: None, ..forged.clone() };
    assert!(matches!(checked(&headless), Err(ChainError::Key { .. })));
    let mixed = Folder { head: good.head.clone(), ..forged };
    assert!(matches!(checked(&mixed), Err(ChainError::Key { .. })));
    let bare: Vec<_> = files().into_iter().map(|bytes| (named(&bytes), bytes)).collect();
    let unsigned = Folder { head: None, files: bare.clone() };
    let first = file_name(0);
    assert_eq!(checked(&unsigned), Err(ChainError::Unsigned { name: first.clone() }));
    assert_eq!(check(&unsigned, None), Ok(Proof::Unsigned));
    let beside = Folder { head: good.head.clone(), files: bare };
    assert_eq!(check(&beside, None), Err(ChainError::Unsigned { name: first }));
    // An empty folder proves nothing to somebody with a key.
    assert!(checked(&Folder { head: None, files: Vec::new() }).is_err());
    // Nobody goes on with another key, or without one.
    assert!(matches!(continued(&good, Some(&key(2))), Err(ChainError::Key { .. })));
    assert!(matches!(continued(&good, None), Err(ChainError::Signed { .. })));
    assert!(matches!(continued(&unsigned, Some(&key(1))), Err(ChainError::Unsigned { .. })));
}

#[test]
fn records_taken_from_the_middle_or_the_end_are_named() {
    let good = whole(4);
    for gone in 0..3 {
        let mut bad = good.clone();
        bad.files.remove(gone);
        let (found, expected) = (gone as u64 + 1, gone as u64);
        let name = file_name(found);
        assert_eq!(checked(&bad), Err(ChainError::Number { name, found, expected }));
    }
    for left in 0..4 {
        let mut bad = good.clone();
        bad.files.truncate(left);
        let (name, found) = (HEAD_FILE.to_owned(), left as u64);
        assert_eq!(checked(&bad), Err(ChainError::Cut { name, stated: 4, found }));
    }
    // With a head of its past, a folder that was cut looks as it did then: a copy shows it.
    let states = history(4, CHAIN, &key(1), "s");
    let past = &states[4];
    assert!(checked(past).is_ok());
    let mut chain = Chain::new(Some(key(1).verifying_key()));
    chain.head(HEAD_FILE, past.head.as_ref().expect("a head")).expect("signed");
    chain.copy_of_head("copy", good.head.as_ref().expect("a head")).expect("signed");
    for (name, bytes) in &past.files {
        chain.next(name, bytes).expect("signed");
    }
    let cut = ChainError::Cut { name: "copy".into(), stated: 4, found: 2 };
    assert_eq!(chain.finish(HEAD_FILE), Err(cut));
    // And an old head in a folder that was not cut is none that a crash leaves.
    let stale = Folder { head: past.head.clone(), ..good };
    let name = HEAD_FILE.to_owned();
    assert_eq!(checked(&stale), Err(ChainError::Stale { name, stated: 2, found: 4 }));
    assert!(matches!(continued(&stale, Some(&key(1))), Err(ChainError::Stale { .. })));
}

#[test]
fn records_and_heads_of_another_chain_of_the_same_key_are_named() {
    let good = whole(3);
    let other = history(3, OTHER, &key(1), "o").pop().expect("states");
    for at in 0..3 {
        let mut bad = good.clone();
        bad.files[at] = other.files[at].clone();
        let (name, of) = (file_name(at as u64), HEAD_FILE.to_owned());
        assert_eq!(checked(&bad), Err(ChainError::OtherChain { name, of }));
    }
    let bad = Folder { head: other.head, ..good };
    assert!(matches!(checked(&bad), Err(ChainError::OtherChain { .. })));
    assert!(matches!(continued(&bad, Some(&key(1))), Err(ChainError::OtherChain { .. })));
    // The statement of a record is no head.
    let of_record = &good_statement();
    let mut chain = Chain::new(None);
    let error = chain.head(HEAD_FILE, of_record).expect_err("a record's");
    assert!(matches!(error, ChainError::Kind { .. }), "{error}");
}

fn good_statement() -> Vec<u8> {
    let (kind, number, hash) = (StatementKind::Record, 3, [1; 32]);
    Statement { kind, chain: CHAIN, number, hash, provenance: provenance() }
        .sign(&key(1))
        .into_bytes()
}

/// One thing that somebody without the key can do to a folder.
#[derive(Clone, Debug)]
enum Tamper {
    Flip(prop::sample::Index, u8),
    Remove,
    Swap(prop::sample::Index),
    Rename(u64),
    Copy(prop::sample::Index),
    Replace(prop::sample::Index),
}

fn tamper() -> impl Strategy<Value = Tamper> {
    prop_oneof![
        (any::<prop::sample::Index>(), 1..=255_u8).prop_map(|(at, by)| Tamper::Flip(at, by)),
        Just(Tamper::Remove),
        any::<prop::sample::Index>().prop_map(Tamper::Swap),
        (0..9_u64).prop_map(Tamper::Rename),
        any::<prop::sample::Index>().prop_map(Tamper::Copy),
        any::<prop::sample::Index>().prop_map(Tamper::Replace),
    ]
}

proptest! {
    /// Whatever files are changed, removed, exchanged, renamed or brought from another chain: it is
    /// found, or the folder is as it, or the other chain of the same signer, was at some time.
    #[test]
    fn a_folder_that_passes_is_one_that_its_writer_left(
        count in 1..5_u64,
        what in prop::collection::vec((any::<prop::sample::Index>(), tamper()), 1..4),
    ) {
        let past = history(count, CHAIN, &key(1), "s");
        let others = history(count, OTHER, &key(1), "o");
        let other = others.last().expect("states");
        let mut folder = past.last().expect("states").clone();
        for (at, tamper) in what {
            // The head is a file like others.
            let files = folder.files.len();
            let at = at.index(files + 1);
            let Some((name, bytes)) = folder.files.get_mut(at) else {
                match tamper {
                    Tamper::Flip(byte, by) => {
                        if let Some(head) = &mut folder.head {
                            let byte = byte.index(head.len());
                            head[byte] ^= by;
                        }
                    }
                    Tamper::Replace(from) => folder.head = from.get(&past).head.clone(),
                    Tamper::Copy(_) => folder.head = other.head.clone(),
                    _ => folder.head = None,
                }
                continue;
            };
            match tamper {
                Tamper::Flip(byte, by) => {
                    let byte = byte.index(bytes.len());
                    bytes[byte] ^= by;
                }
                Tamper::Remove => drop(folder.files.remove(at)),
                Tamper::Rename(number) => *name = file_name(number),
                Tamper::Copy(from) => *bytes = from.get(&other.files).1.clone(),
                Tamper::Replace(from) | Tamper::Swap(from) => {
                    let from = from.index(files);
                    let theirs = folder.files[from].1.clone();
                    let ours = core::mem::replace(&mut folder.files[at].1, theirs);
                    if matches!(tamper, Tamper::Swap(_)) {
                        folder.files[from].1 = ours;
                    }
                }
            }
        }
        folder.files.sort();
        let was = past.contains(&folder) || others.contains(&folder);
        prop_assert_eq!(checked(&folder).is_ok(), was, "{:?}", checked(&folder));
    }
}
