//! Writes decisions, signed or not.

use super::{
    DECISION_HEAD, DecisionError, DecisionFile, END, END_SIGNED, Entry, LENGTHS, MAGIC,
    MAGIC_SIGNED, SIGNED, START, is_of_other_version, link, name, numbers, request_length,
};
use crate::deployment::Decisions;
use protocol::public::WireAnswer;
use record::chain::{parse_head, same_key};
use record::statement::STATEMENT_MAX;
use record::{
    ChainError, ChainId, Provenance, SignedStatement, SigningKey, Statement, StatementKind,
};
use runtime::{InputKind, clock, input, output};
use std::fs::{self, File};
use std::io::{self, Write as _};
use std::os::unix::fs::{FileExt as _, PermissionsExt as _};
use std::path::Path;

/// Maximum size of a file (bytes): half of what is read.
const FILE_BYTES_MAX: u64 = 512 << 20;
/// Interval between heads (ns): each waits for the disk.
const HEAD_NS: u64 = 1_000_000_000;

/// Who signs decisions.
#[derive(Clone, Debug)]
pub struct DecisionSigner {
    /// The key.
    pub key: SigningKey,
    /// Where and by what; the time is that of each statement.
    pub provenance: Provenance,
}

/// Writes decisions.
#[derive(Debug)]
pub(crate) struct Book {
    settings: Decisions,
    file: File,
    number: u64,
    entries: u32,
    /// Bytes of the decisions in the file.
    bytes: u64,
    last: [u8; 32],
    signing: Option<Signing>,
}

/// What a signed chain needs besides.
#[derive(Debug)]
struct Signing {
    signer: DecisionSigner,
    chain: ChainId,
    /// Decisions of the chain so far.
    count: u64,
    /// Decisions that the head counts.
    headed: u64,
    /// When the head was written (ns).
    headed_ns: u64,
}

impl Book {
    /// Continues the chain of the files in the folder, in a new file.
    ///
    /// # Errors
    ///
    /// If the folder cannot be written to, or its chain is signed otherwise.
    pub(crate) fn open(
        settings: &Decisions,
        signer: Option<DecisionSigner>,
    ) -> Result<Self, DecisionError> {
        let folder = &settings.folder;
        fs::create_dir_all(folder)?;
        let files = numbers(folder)?;
        let number = files.last().map_or(0, |last| last + 1);
        let (last, mut signing) = match signer {
            None => (unsigned_end(folder, files.last().copied())?, None),
            Some(signer) => {
                let (last, signing) = signed_end(folder, files.last().copied(), signer)?;
                (last, Some(signing))
            }
        };
        let file = begin(folder, number, &last, signing.as_ref())?;
        if let Some(signing) = &mut signing {
            signing.write_head(folder, &file, last)?;
        }
        let settings = settings.clone();
        let book = Self { settings, file, number, entries: 0, bytes: 0, last, signing };
        book.forget()?;
        Ok(book)
    }

    /// Adds a decision: the bytes of a request that count, and its answer.
    pub(crate) fn add(&mut self, request: &[u8], answer: &WireAnswer) -> io::Result<()> {
        let length = request.len() as u64;
        let most = length + (LENGTHS + END_SIGNED) as u64;
        if self.entries >= self.settings.per_file || self.bytes + most > FILE_BYTES_MAX {
            if self.signing.is_some() {
                // The next head counts what is in this file, too.
                self.file.sync_data()?;
            }
            let folder = &self.settings.folder;
            let file = begin(folder, self.number + 1, &self.last, self.signing.as_ref())?;
            (self.file, self.number, self.entries, self.bytes) = (file, self.number + 1, 0, 0);
            self.forget()?;
        }
        let mut bytes = Vec::with_capacity(most as usize);
        bytes.extend_from_slice(&length.to_le_bytes());
        bytes.extend_from_slice(&(!length).to_le_bytes());
        bytes.extend_from_slice(request);
        bytes.extend_from_slice(bytemuck::bytes_of(answer));
        if let Some(signing) = &self.signing {
            bytes.extend_from_slice(&signing.count.to_le_bytes());
            bytes.extend_from_slice(&clock::time_of_day_ns().to_le_bytes());
        }
        let hash = link(&self.last, &bytes);
        bytes.extend_from_slice(&hash);
        if let Some(signing) = &mut self.signing {
            bytes.extend_from_slice(&signing.signer.key.sign(&[SIGNED, &hash].concat()));
            signing.count += 1;
        }
        self.file.write_all(&bytes)?;
        self.last = hash;
        self.entries += 1;
        self.bytes += bytes.len() as u64;
        Ok(())
    }

    /// Writes the head of a signed chain if that is due, and `now` in any case.
    pub(crate) fn mark(&mut self, now: bool) -> Result<(), DecisionError> {
        let Some(signing) = &mut self.signing else { return Ok(()) };
        let is_due = now || clock::now_ns() - signing.headed_ns >= HEAD_NS;
        if signing.count > signing.headed && is_due {
            signing.write_head(&self.settings.folder, &self.file, self.last)?;
        }
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

impl Signing {
    fn sign(&self, kind: StatementKind, hash: [u8; 32]) -> String {
        let provenance = self.signer.provenance.clone();
        let provenance = Provenance { written_ns: clock::time_of_day_ns(), ..provenance };
        Statement { kind, chain: self.chain, number: self.count, hash, provenance }
            .sign(&self.signer.key)
    }

    /// Writes the head, once what it counts is on the disk.
    fn write_head(
        &mut self,
        folder: &Path,
        file: &File,
        last: [u8; 32],
    ) -> Result<(), DecisionError> {
        self.headed_ns = clock::now_ns();
        file.sync_data()?;
        File::open(folder)?.sync_all()?;
        let head = self.sign(StatementKind::DecisionHead, last);
        output::replace(&folder.join(DECISION_HEAD), head.as_bytes())?;
        self.headed = self.count;
        Ok(())
    }
}

/// Begins a file. It is there whole or not at all.
fn begin(
    folder: &Path,
    number: u64,
    last: &[u8; 32],
    signing: Option<&Signing>,
) -> io::Result<File> {
    let magic = if signing.is_some() { MAGIC_SIGNED } else { MAGIC };
    let mut bytes = [&magic[..], &number.to_le_bytes(), last].concat();
    if let Some(signing) = signing {
        let statement = signing.sign(StatementKind::DecisionFile, *blake3::hash(&bytes).as_bytes());
        bytes.extend_from_slice(&(statement.len() as u64).to_le_bytes());
        bytes.extend_from_slice(statement.as_bytes());
    }
    // Less the umask.
    let permissions = fs::Permissions::from_mode(0o666);
    let mut file = tempfile::Builder::new().permissions(permissions).tempfile_in(folder)?;
    file.write_all(&bytes)?;
    if signing.is_some() {
        // Whole after a loss of power, too.
        file.as_file().sync_data()?;
    }
    Ok(file.persist_noclobber(name(folder, number))?)
}

/// The hash of the last decision of a folder that is not signed.
fn unsigned_end(folder: &Path, last: Option<u64>) -> Result<[u8; 32], DecisionError> {
    let head = folder.join(DECISION_HEAD);
    if head.try_exists()? {
        return Err(ChainError::Signed { name: head.display().to_string() }.into());
    }
    let Some(path) = last.map(|last| name(folder, last)) else { return Ok([0; 32]) };
    let mut magic = [0; 8];
    let _length = input::start(&path, &mut magic);
    if is_of_other_version(&magic) {
        return Err(DecisionError::OtherVersion { path });
    }
    if magic == MAGIC_SIGNED {
        return Err(ChainError::Signed { name: path.display().to_string() }.into());
    }
    // Cut by a crash or not, the last file's chain ends with its last whole entry.
    Ok(last_hash(&path).unwrap_or_default())
}

pub(super) fn last_hash(path: &Path) -> Option<[u8; 32]> {
    let (file, length) = input::regular(path).ok()?;
    length.checked_sub(START as u64)?;
    let mut hash = [0; 32];
    // A hash ends the start, and each entry.
    let ends = ends(&file, START as u64, length, END).ok()?;
    let end = ends.last().copied().unwrap_or(START as u64);
    file.read_exact_at(&mut hash, end - 32).ok()?;
    Some(hash)
}

/// Where the whole decisions of a file end, from the end of its beginning on.
fn ends(file: &File, from: u64, length: u64, end: usize) -> io::Result<Vec<u64>> {
    let (mut ends, mut at) = (Vec::new(), from);
    let mut lengths = [0; LENGTHS];
    while at + (LENGTHS as u64) <= length {
        file.read_exact_at(&mut lengths, at)?;
        let Some(request) = request_length(&lengths) else { break };
        at += (LENGTHS + request + end) as u64;
        if at > length {
            break;
        }
        ends.push(at);
    }
    Ok(ends)
}

/// The hash of the last decision of a signed folder, and how many there are; in an empty folder, a
/// chain that begins, with its head.
fn signed_end(
    folder: &Path,
    last: Option<u64>,
    signer: DecisionSigner,
) -> Result<([u8; 32], Signing), DecisionError> {
    let path = folder.join(DECISION_HEAD);
    let head_name = path.display().to_string();
    let mut head = None;
    if path.try_exists()? {
        let bytes = input::bytes(&path, InputKind::ChainHead)?;
        head = Some(parse_head(&head_name, &bytes, StatementKind::DecisionHead)?);
    }
    let key = signer.key.verifying_key();
    let mut signing = Signing { signer, chain: [0; 16], count: 0, headed: 0, headed_ns: 0 };
    let mut hash = [0; 32];
    if let Some(path) = last.map(|last| name(folder, last)) {
        let (statement, end) = last_entry(&path)?;
        same_key(&path.display().to_string(), &statement, Some(key))?;
        let Some(head) = &head else { return Err(ChainError::NoHead { name: head_name }.into()) };
        if head.statement.chain != statement.statement.chain {
            let name = path.display().to_string();
            return Err(ChainError::OtherChain { name, of: head_name }.into());
        }
        (signing.count, hash) = end;
    }
    if let Some(head) = &head {
        same_key(&head_name, head, Some(key))?;
        let (stated, found) = (head.statement.number, signing.count);
        if stated > found {
            return Err(ChainError::Cut { name: head_name, stated, found }.into());
        }
        signing.chain = head.statement.chain;
        return Ok((hash, signing));
    }
    // The head of an empty chain comes first: no file is ever without one.
    for half in signing.chain.chunks_exact_mut(8) {
        let drawn = clock::random_u64().map_err(io::Error::other)?;
        half.copy_from_slice(&drawn.to_le_bytes());
    }
    let text = signing.sign(StatementKind::DecisionHead, hash);
    output::replace(&path, text.as_bytes())?;
    Ok((hash, signing))
}

/// The statement of a signed file; how many decisions of its chain there are with its last sound
/// one, and the hash of that one. What comes after it was torn by a crash.
fn last_entry(path: &Path) -> Result<(SignedStatement, (u64, [u8; 32])), DecisionError> {
    let (file, length) = input::open(path, InputKind::Decisions)?;
    let mut start = vec![0; (length as usize).min(START + 8 + STATEMENT_MAX)];
    file.read_exact_at(&mut start, 0)?;
    let name = path.display().to_string();
    let found = DecisionFile::parse(&name, &start)?;
    let Some(statement) = found.statement else { return Err(ChainError::Unsigned { name }.into()) };
    let from = (start.len() - found.body.len()) as u64;
    let ends = ends(&file, from, length, END_SIGNED)?;
    for (number, end) in ends.iter().enumerate().rev() {
        let mut before = found.before;
        let begin = number.checked_sub(1).map_or(from, |last| ends[last]);
        if number > 0 {
            // Its hash is before its signature.
            file.read_exact_at(&mut before, begin - 96)?;
        }
        let mut bytes = vec![0; (end - begin) as usize];
        file.read_exact_at(&mut bytes, begin)?;
        let entry = Entry { bytes: &bytes, signer: Some(statement.signer) };
        if let (Some(hash), Some(number)) = (entry.checked(&before), entry.number()) {
            return Ok((statement, (number + 1, hash)));
        }
    }
    let count = statement.statement.number;
    Ok((statement, (count, found.before)))
}
