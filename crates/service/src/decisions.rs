//! Requests and their answers, kept in bounded and chained files.
//!
//! ```text
//! decisions-00000007.bin: [magic 8] [number of the file 8] [hash before 32]  then per decision
//!                         [Ask 3536] [Answer 2016] [hash 32]
//! ```
//!
//! A hash is BLAKE3 over the hash before it and the two structs; the first of a file continues the
//! last of the file before. When a file is full, the next begins, and the oldest is deleted.
//! Removing whole files from either end cannot be detected from the rest.

use crate::deployment::Decisions;
use bytemuck::Zeroable as _;
use diagnostic::{Diagnostic, FailureKind};
use protocol::public::{Ask, WireAnswer};
use runtime::{InputError, InputKind, input};
use std::borrow::Cow;
use std::fs::{self, File};
use std::io::{self, Write as _};
use std::os::unix::fs::FileExt as _;
use std::path::{Path, PathBuf};

const MAGIC: [u8; 8] = *b"TROLDEC\n";
const HEAD: usize = 8 + 8 + 32;
const ENTRY: usize = size_of::<Ask>() + size_of::<WireAnswer>() + 32;

/// A stored decision.
#[derive(Clone, Debug, PartialEq)]
pub struct Decision {
    /// The request.
    pub ask: Ask,
    /// The answer.
    pub answer: WireAnswer,
}

/// A file of decisions that cannot be trusted.
#[derive(Debug, thiserror::Error)]
pub enum DecisionError {
    /// It cannot be read.
    #[error(transparent)]
    Unread(#[from] InputError),
    /// It is not a file of decisions.
    #[error("this is not a file of decisions")]
    Foreign,
    /// It has been changed since it was written.
    #[error("decision {0} was changed since it was written: its hash does not match")]
    Changed(usize),
}

impl Diagnostic for DecisionError {
    fn kind(&self) -> FailureKind {
        FailureKind::Input
    }

    fn remedy(&self) -> Option<Cow<'_, str>> {
        match self {
            Self::Unread(error) => error.remedy(),
            Self::Foreign => Some("name a file that a service wrote".into()),
            Self::Changed(_) => Some("compare with a copy kept elsewhere".into()),
        }
    }
}

/// Reads a file of decisions and checks its chain. A file cut in the middle of an entry yields the
/// entries before it.
///
/// # Errors
///
/// If the file cannot be read, is not a file of decisions, or was changed.
pub fn read_decisions(path: &Path) -> Result<Vec<Decision>, DecisionError> {
    let bytes = input::bytes(path, InputKind::Decisions)?;
    let (head, body) = bytes.split_at_checked(HEAD).ok_or(DecisionError::Foreign)?;
    if head[..8] != MAGIC {
        return Err(DecisionError::Foreign);
    }
    let mut before = [0; 32];
    before.copy_from_slice(&head[16..]);
    let mut entries = Vec::new();
    for (number, bytes) in body.chunks_exact(ENTRY).enumerate() {
        let (ask_bytes, rest) = bytes.split_at(size_of::<Ask>());
        let (answer_bytes, hash) = rest.split_at(size_of::<WireAnswer>());
        let mut entry = Decision { ask: Ask::zeroed(), answer: WireAnswer::zeroed() };
        bytemuck::bytes_of_mut(&mut entry.ask).copy_from_slice(ask_bytes);
        bytemuck::bytes_of_mut(&mut entry.answer).copy_from_slice(answer_bytes);
        before = link(&before, &entry.ask, &entry.answer);
        if hash != before {
            return Err(DecisionError::Changed(number));
        }
        entries.push(entry);
    }
    Ok(entries)
}

fn link(before: &[u8; 32], ask: &Ask, answer: &WireAnswer) -> [u8; 32] {
    let mut hasher = blake3::Hasher::new();
    hasher.update(before).update(bytemuck::bytes_of(ask)).update(bytemuck::bytes_of(answer));
    *hasher.finalize().as_bytes()
}

/// Writes decisions.
#[derive(Debug)]
pub(crate) struct Book {
    settings: Decisions,
    file: File,
    number: u64,
    entries: u32,
    last: [u8; 32],
}

impl Book {
    /// Continues the chain of the files in the folder, in a new file.
    pub(crate) fn open(settings: &Decisions) -> io::Result<Self> {
        fs::create_dir_all(&settings.folder)?;
        let files = numbers(&settings.folder)?;
        let number = files.last().map_or(0, |last| last + 1);
        // Cut by a crash or not, the last file's chain ends with its last whole entry.
        let last = files.last().and_then(|last| last_hash(&name(&settings.folder, *last)));
        let last = last.unwrap_or_default();
        let file = begin(&settings.folder, number, &last)?;
        let book = Self { settings: settings.clone(), file, number, entries: 0, last };
        book.forget()?;
        Ok(book)
    }

    /// Adds a decision.
    pub(crate) fn add(&mut self, ask: &Ask, answer: &WireAnswer) -> io::Result<()> {
        if self.entries >= self.settings.per_file {
            let file = begin(&self.settings.folder, self.number + 1, &self.last)?;
            (self.file, self.number, self.entries) = (file, self.number + 1, 0);
            self.forget()?;
        }
        let hash = link(&self.last, ask, answer);
        let mut bytes = Vec::with_capacity(ENTRY);
        bytes.extend_from_slice(bytemuck::bytes_of(ask));
        bytes.extend_from_slice(bytemuck::bytes_of(answer));
        bytes.extend_from_slice(&hash);
        self.file.write_all(&bytes)?;
        self.last = hash;
        self.entries += 1;
        Ok(())
    }

    /// Removes the oldest files.
    fn forget(&self) -> io::Result<()> {
        let files = numbers(&self.settings.folder)?;
        let keep = self.settings.files as usize;
        for number in &files[..files.len().saturating_sub(keep)] {
            fs::remove_file(name(&self.settings.folder, *number))?;
        }
        Ok(())
    }
}

fn begin(folder: &Path, number: u64, last: &[u8; 32]) -> io::Result<File> {
    let mut file = File::create_new(name(folder, number))?;
    file.write_all(&MAGIC)?;
    file.write_all(&number.to_le_bytes())?;
    file.write_all(last)?;
    Ok(file)
}

fn last_hash(path: &Path) -> Option<[u8; 32]> {
    let (file, length) = input::regular(path).ok()?;
    let entries = length.checked_sub(HEAD as u64)? / ENTRY as u64;
    let mut hash = [0; 32];
    // A hash ends the head, and each entry.
    file.read_exact_at(&mut hash, (HEAD - 32) as u64 + entries * ENTRY as u64).ok()?;
    Some(hash)
}

fn name(folder: &Path, number: u64) -> PathBuf {
    folder.join(format!("decisions-{number:08}.bin"))
}

/// Numbers of the files there are, ascending.
fn numbers(folder: &Path) -> io::Result<Vec<u64>> {
    let mut numbers = Vec::new();
    for entry in fs::read_dir(folder)? {
        let name = entry?.file_name();
        let number = name.to_str().and_then(|name| {
            name.strip_prefix("decisions-")?.strip_suffix(".bin")?.parse::<u64>().ok()
        });
        numbers.extend(number);
    }
    numbers.sort_unstable();
    Ok(numbers)
}

#[cfg(test)]
mod tests {
    //! Requests and answers are kept unchanged; every changed byte is found; files are bounded.

    use super::*;
    use protocol::public::{Reason, WireState};

    fn answer(number: u64) -> WireAnswer {
        WireAnswer::without_ranking(number, WireState::Refused, Reason::Internal, "x")
    }

    #[test]
    fn decisions_rotate_follow_on_each_other_and_are_found_changed() {
        let folder = tempfile::tempdir().unwrap();
        let settings = Decisions { folder: folder.path().join("d"), per_file: 3, files: 2 };
        let mut book = Book::open(&settings).unwrap();
        for number in 0..8 {
            book.add(&Ask::new(number), &answer(number)).unwrap();
        }
        drop(book);
        assert_eq!(numbers(&settings.folder).unwrap(), [1, 2]);
        let entries = read_decisions(&name(&settings.folder, 2)).unwrap();
        assert_eq!(entries.len(), 2);
        assert_eq!((entries[0].ask, entries[0].answer), (Ask::new(6), answer(6)));
        // The next run continues the chain.
        Book::open(&settings).unwrap().add(&Ask::new(8), &answer(8)).unwrap();
        assert_eq!(numbers(&settings.folder).unwrap(), [2, 3]);
        let path = name(&settings.folder, 3);
        assert_eq!(
            fs::read(&path).unwrap()[16..48],
            last_hash(&name(&settings.folder, 2)).unwrap()
        );
        let whole = fs::read(&path).unwrap();
        for at in (HEAD..whole.len()).step_by(97) {
            let mut changed = whole.clone();
            changed[at] ^= 0x10;
            fs::write(&path, &changed).unwrap();
            assert!(matches!(read_decisions(&path), Err(DecisionError::Changed(0))), "byte {at}");
        }
        fs::write(&path, b"TROLDEX\n and more than a head would have, of other bytes").unwrap();
        assert!(matches!(read_decisions(&path), Err(DecisionError::Foreign)));
    }
}
