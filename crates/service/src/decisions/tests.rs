//! Requests and answers are kept unchanged; every changed byte is found; files are bounded.

use super::book::last_hash;
use super::*;
use crate::deployment::Decisions;
use protocol::public::{Reason, WireState};
use record::{HeadProof, Proof, Provenance, SigningKey};
use std::fs;
use std::path::Path;

/// Bytes of a decision of [`ask`] that is signed.
const ENTRY_SIGNED: usize = LENGTHS + Ask::BYTES_MIN + END_SIGNED;

fn ask(number: u64) -> Box<Ask> {
    let mut ask = Ask::new(5.0);
    ask.sequence = number;
    ask
}

fn answer(number: u64) -> WireAnswer {
    WireAnswer::without_ranking(number, WireState::Refused, Reason::Internal, "x")
}

#[test]
fn decisions_rotate_follow_on_each_other_and_are_found_changed() {
    let folder = tempfile::tempdir().unwrap();
    let settings = Decisions { folder: folder.path().join("d"), per_file: 3, files: 2 };
    let mut book = Book::open(&settings, None).unwrap();
    for number in 0..8 {
        book.add(ask(number).used(), &answer(number)).unwrap();
    }
    drop(book);
    assert_eq!(numbers(&settings.folder).unwrap(), [1, 2]);
    let entries = read_decisions(&name(&settings.folder, 2)).unwrap();
    assert_eq!(entries.len(), 2);
    assert_eq!((&entries[0].ask, entries[0].answer), (&ask(6), answer(6)));
    // The next run continues the chain.
    Book::open(&settings, None).unwrap().add(ask(8).used(), &answer(8)).unwrap();
    assert_eq!(numbers(&settings.folder).unwrap(), [2, 3]);
    let path = name(&settings.folder, 3);
    assert_eq!(fs::read(&path).unwrap()[16..48], last_hash(&name(&settings.folder, 2)).unwrap());
    let whole = fs::read(&path).unwrap();
    for at in (START..whole.len()).step_by(97) {
        let mut changed = whole.clone();
        changed[at] ^= 0x10;
        fs::write(&path, &changed).unwrap();
        assert!(matches!(read_decisions(&path), Err(DecisionError::Changed(0))), "byte {at}");
    }
    fs::write(&path, b"TROLDEX\n and more than a head would have, of other bytes").unwrap();
    assert!(matches!(read_decisions(&path), Err(DecisionError::Foreign)));
}

/// Its requests and answers have other lengths: a chain that went on from it could not be checked.
#[test]
fn decisions_of_another_version_are_refused_and_not_continued() {
    let place = tempfile::tempdir().unwrap();
    let is_other = |error: DecisionError| matches!(error, DecisionError::OtherVersion { .. });
    for (folder, key, magic) in [("a", None, b"TROLDC2\n"), ("b", Some(signer(1)), b"TROLDS2\n")] {
        let folder = place.path().join(folder);
        let mut book = Book::open(&settings(&folder), key.clone()).unwrap();
        book.add(ask(1).used(), &answer(1)).unwrap();
        book.mark(true).unwrap();
        drop(book);
        let path = name(&folder, 0);
        let mut bytes = fs::read(&path).unwrap();
        bytes[..8].copy_from_slice(magic);
        fs::write(&path, bytes).unwrap();
        assert!(is_other(read_decisions(&path).unwrap_err()));
        assert!(is_other(verify_decisions(&folder, None, None).unwrap_err()));
        assert!(is_other(Book::open(&settings(&folder), key).unwrap_err()));
        assert_eq!(numbers(&folder).unwrap(), [0]);
    }
}

fn signer(seed: u8) -> DecisionSigner {
    let provenance =
        Provenance { written_ns: 0, host: "h".into(), deployment: None, build: "b".into() };
    DecisionSigner { key: SigningKey::from_seed(&[seed; 32]), provenance }
}

fn settings(folder: &Path) -> Decisions {
    Decisions { folder: folder.to_owned(), per_file: 2, files: 100 }
}

/// Runs of a service, each of so many decisions, ended in order.
fn kept(folder: &Path, seed: u8, runs: &[u64]) {
    for count in runs {
        let mut book = Book::open(&settings(folder), Some(signer(seed))).unwrap();
        (0..*count).for_each(|number| book.add(ask(number).used(), &answer(number)).unwrap());
        book.mark(true).unwrap();
    }
}

fn checked(folder: &Path) -> Result<VerifiedDecisions, DecisionError> {
    verify_decisions(folder, Some(signer(1).key.verifying_key()), None)
}

fn files(folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let paths = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut files: Vec<_> = paths.map(|path| (path.clone(), fs::read(path).unwrap())).collect();
    files.sort();
    files
}

fn put_back(folder: &Path, files: &[(PathBuf, Vec<u8>)]) {
    fs::remove_dir_all(folder).unwrap();
    fs::create_dir(folder).unwrap();
    files.iter().for_each(|(path, bytes)| fs::write(path, bytes).unwrap());
}

#[test]
fn signed_decisions_pass_with_their_key_alone() {
    let place = tempfile::tempdir().unwrap();
    let folder = place.path().join("d");
    kept(&folder, 1, &[3, 0, 2]);
    let key = signer(1).key.verifying_key();
    let found = checked(&folder).unwrap();
    assert_eq!((found.count, found.first, found.torn_bytes), (5, 0, 0));
    let head = Some(HeadProof { count: 5, after: 0 });
    assert_eq!(found.proof, Proof::Signed { key, head });
    assert_eq!(found.statement.unwrap().statement.provenance.host, "h");
    let found = verify_decisions(&folder, None, None).unwrap();
    assert_eq!(found.proof, Proof::OfUnknownKey { key });
    let other = verify_decisions(&folder, Some(signer(2).key.verifying_key()), None);
    assert!(matches!(other, Err(DecisionError::Chain(ChainError::Key { .. }))));
    assert_eq!(read_decisions(&name(&folder, 0)).unwrap().len(), 2);
    // Nobody goes on without the key, or with another one.
    let without = Book::open(&settings(&folder), None);
    assert!(matches!(without, Err(DecisionError::Chain(ChainError::Signed { .. }))));
    let other = Book::open(&settings(&folder), Some(signer(2)));
    assert!(matches!(other, Err(DecisionError::Chain(ChainError::Key { .. }))));
    // Unsigned ones are no signed ones, and the next service does not sign on.
    let bare = place.path().join("bare");
    Book::open(&settings(&bare), None).unwrap().add(ask(0).used(), &answer(0)).unwrap();
    assert_eq!(verify_decisions(&bare, None, None).unwrap().proof, Proof::Unsigned);
    let unsigned = |error| matches!(error, DecisionError::Chain(ChainError::Unsigned { .. }));
    assert!(unsigned(checked(&bare).unwrap_err()));
    assert!(unsigned(Book::open(&settings(&bare), Some(signer(1))).unwrap_err()));
    // The oldest files go: their number is known.
    let few = Decisions { files: 2, ..settings(&folder) };
    drop(Book::open(&few, Some(signer(1))).unwrap());
    let found = checked(&folder).unwrap();
    assert_eq!((found.count, found.first), (2, 3));
}

/// Every byte of heads and starts, and every 19th of decisions.
#[test]
fn changed_bytes_of_signed_decisions_are_found_and_the_file_named() {
    let place = tempfile::tempdir().unwrap();
    let folder = place.path().join("d");
    kept(&folder, 1, &[2, 1]);
    for (path, good) in files(&folder) {
        let step = |at: &usize| *at < 900 || at.is_multiple_of(19) || good.len() - at < 120;
        for at in (0..good.len()).filter(step) {
            let mut bad = good.clone();
            bad[at] ^= 0x11;
            fs::write(&path, &bad).unwrap();
            let error = checked(&folder).expect_err("changed").to_string();
            let name = path.file_name().unwrap().to_str().unwrap();
            assert!(error.contains(name), "{name} at {at}: {error}");
        }
        fs::write(&path, &good).unwrap();
    }
    assert!(checked(&folder).is_ok());
}

#[test]
fn decisions_that_are_removed_exchanged_or_of_another_chain_are_found() {
    let place = tempfile::tempdir().unwrap();
    let (folder, other) = (place.path().join("d"), place.path().join("o"));
    kept(&folder, 1, &[7]);
    kept(&other, 1, &[7]);
    let (good, theirs) = (files(&folder), files(&other));
    let past = place.path().join("past.head");
    fs::copy(folder.join(DECISION_HEAD), &past).unwrap();
    let file = |number| name(&folder, number);
    type Deed<'d> = (&'d str, Box<dyn Fn() + 'd>);
    let cases: [Deed<'_>; 9] = [
        ("the file before it is missing", Box::new(|| fs::remove_file(file(1)).unwrap())),
        ("states 7, and there are 6", Box::new(|| fs::remove_file(file(3)).unwrap())),
        ("decisions.head is missing", {
            Box::new(|| fs::remove_file(folder.join(DECISION_HEAD)).unwrap())
        }),
        ("this is file 2 of its chain", { Box::new(|| fs::rename(file(2), file(1)).unwrap()) }),
        ("belongs to another chain", Box::new(|| fs::write(file(1), &theirs[1].1).unwrap())),
        ("belongs to another chain", {
            Box::new(|| fs::write(folder.join(DECISION_HEAD), &theirs[4].1).unwrap())
        }),
        ("written after another record", {
            Box::new(|| fs::write(file(1), &good[1].1[..good[1].1.len() - ENTRY_SIGNED]).unwrap())
        }),
        ("states 7, and there are 6", {
            Box::new(|| fs::write(file(3), &good[3].1[..good[3].1.len() - 1]).unwrap())
        }),
        ("decision 0 of this file was changed", {
            // Exchanged within its file.
            Box::new(|| {
                let (start, body) = good[1].1.split_at(good[1].1.len() - 2 * ENTRY_SIGNED);
                let (first, second) = body.split_at(ENTRY_SIGNED);
                fs::write(file(1), [start, second, first].concat()).unwrap();
            })
        }),
    ];
    for (says, tamper) in cases {
        tamper();
        let error = checked(&folder).expect_err(says).to_string();
        assert!(error.contains(says), "{says}: {error}");
        put_back(&folder, &good);
    }
    // Put back to an older state, as a whole: a copy of the head shows it.
    let kept_head = Some(past.as_path());
    let key = Some(signer(1).key.verifying_key());
    assert!(verify_decisions(&folder, key, kept_head).is_ok());
    assert!(verify_decisions(&other, key, kept_head).is_err());
}

/// At whatever byte a killed service stopped: it passes, and the next one goes on.
#[test]
fn what_a_killed_service_leaves_passes_and_is_continued() {
    let place = tempfile::tempdir().unwrap();
    let folder = place.path().join("d");
    kept(&folder, 1, &[1]);
    let mut book = Book::open(&settings(&folder), Some(signer(1))).unwrap();
    (0..2).for_each(|number| book.add(ask(number).used(), &answer(number)).unwrap());
    // Killed before the next head.
    drop(book);
    let good = files(&folder);
    let (last, whole) = &good[1];
    let start = whole.len() - 2 * ENTRY_SIGNED;
    for length in (start..=whole.len()).step_by(389).chain([whole.len()]) {
        fs::write(last, &whole[..length]).unwrap();
        let found = checked(&folder).unwrap_or_else(|error| panic!("{length}: {error}"));
        let after = ((length - start) / ENTRY_SIGNED) as u64;
        let torn = ((length - start) % ENTRY_SIGNED) as u64;
        assert_eq!((found.count, found.torn_bytes), (1 + after, torn), "{length}");
        let head = Some(HeadProof { count: 1, after });
        let key = signer(1).key.verifying_key();
        assert_eq!(found.proof, Proof::Signed { key, head });
        kept(&folder, 1, &[1]);
        let found = checked(&folder).unwrap_or_else(|error| panic!("{length}: {error}"));
        assert_eq!((found.count, found.torn_bytes), (2 + after, torn), "{length}");
        put_back(&folder, &good);
    }
    // A loss of power may leave zeros: told apart, and left behind by the next service.
    let zeros = [&whole[..start + ENTRY_SIGNED], &vec![0; ENTRY_SIGNED]].concat();
    fs::write(last, zeros).unwrap();
    let error = checked(&folder).expect_err("zeros").to_string();
    assert!(error.contains("torn by a loss of power"), "{error}");
    kept(&folder, 1, &[1]);
    let found = checked(&folder).unwrap();
    assert_eq!((found.count, found.torn_bytes), (3, ENTRY_SIGNED as u64));
    // Killed before the first file: the head of an empty chain.
    let empty = place.path().join("e");
    kept(&empty, 1, &[0]);
    fs::remove_file(name(&empty, 0)).unwrap();
    assert_eq!(checked(&empty).unwrap().count, 0);
    kept(&empty, 1, &[1]);
    assert_eq!(checked(&empty).unwrap().count, 1);
}
