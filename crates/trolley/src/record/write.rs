//! Writing records: each whole or not at all, and then the head of a signed chain.

use super::content;
use super::sign::Signer;
use super::{bytes, records, unwritable};
use crate::engine::Ranking;
use crate::files::{self, InputKind};
use crate::{Failure, FailureKind};
use record::chain::{self, ChainError, HEAD_FILE, file_name, parse_head};
use record::{Link, RecordSigner, SignedStatement, StatementKind};
use runtime::{clock, output};
use std::fs::{File, TryLockError};
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

/// How long a writer waits for another one of the same folder (ns).
const LOCK_LIMIT_NS: u64 = 10_000_000_000;
/// How often it looks (ns).
const LOCK_NAP_NS: u64 = 2_000_000;

pub(super) fn prepare(folder: &Path, signer: Option<&Signer>) -> Result<(), Failure> {
    std::fs::create_dir_all(folder).map_err(|error| unwritable(folder, &error))?;
    tempfile::tempfile_in(folder).map_err(|error| unwritable(folder, &error))?;
    match signer {
        None => end(folder).and_then(|end| end.resume(folder, None)).map(drop),
        Some(signer) => SignedFolder::open(folder, signer).map(drop),
    }
}

pub(super) fn write(
    folder: &Path,
    ranking: &Ranking,
    signer: Option<&Signer>,
) -> Result<PathBuf, Failure> {
    let record = content::of_ranking(ranking)?;
    // Another process may take the number meanwhile: then take the next one.
    for _ in 0..100 {
        let signed = signer.map(|signer| SignedFolder::open(folder, signer)).transpose()?;
        let last = match &signed {
            Some(open) => open.last,
            None => {
                let end = end(folder)?;
                end.resume(folder, None)?;
                end.link()
            }
        };
        let (file, link) =
            record::encode(&record, last.as_ref(), signed.as_ref().map(|open| &open.signer))?;
        let Some(path) = add(folder, &file, link.number)? else { continue };
        if let Some(open) = signed {
            open.write_head(link.number + 1, link.hash)?;
        }
        return Ok(path);
    }
    Err(Failure::new(FailureKind::Resources, "other processes keep writing records here")
        .at(folder.display())
        .with_remedy("give each process its own folder"))
}

/// Adds a file under its number; `None`: the number is taken.
fn add(folder: &Path, bytes: &[u8], number: u64) -> Result<Option<PathBuf>, Failure> {
    let mut file =
        tempfile::NamedTempFile::new_in(folder).map_err(|error| unwritable(folder, &error))?;
    let written = file.write_all(bytes).and_then(|()| file.as_file().sync_all());
    written.map_err(|error| unwritable(folder, &error))?;
    let path = folder.join(file_name(number));
    match file.persist_noclobber(&path) {
        Ok(_) => Ok(Some(path)),
        Err(error) if error.error.kind() == io::ErrorKind::AlreadyExists => Ok(None),
        Err(error) => Err(unwritable(&path, &error.error)),
    }
}

/// The end of a folder's records.
struct End {
    last: Option<(String, Link, Option<SignedStatement>)>,
    head: Option<SignedStatement>,
}

/// The last record of a folder, by its name, and its head.
fn end(folder: &Path) -> Result<End, Failure> {
    let last = records(folder)?.pop().map(|path| {
        let name = path.display().to_string();
        let (link, statement) = record::file::link(&bytes(&path)?)
            .map_err(|error| Failure::from(error).at(path.display()))?;
        if chain::number_of(&name) != Some(link.number) {
            let found = link.number;
            return Err(Failure::from(ChainError::FileName { name, found }));
        }
        Ok((name, link, statement))
    });
    let path = folder.join(HEAD_FILE);
    let head = match path.try_exists() {
        Ok(false) => None,
        _ => {
            let bytes = files::bytes(&path, InputKind::ChainHead)?;
            let name = path.display().to_string();
            Some(parse_head(&name, &bytes, StatementKind::Head)?)
        }
    };
    Ok(End { last: last.transpose()?, head })
}

impl End {
    fn link(&self) -> Option<Link> {
        self.last.as_ref().map(|(_, link, _)| *link)
    }

    /// Where a writer goes on.
    fn resume(&self, folder: &Path, signer: Option<&Signer>) -> Result<chain::Resume, Failure> {
        let last = self.last.as_ref();
        let last = last.map(|(name, link, signed)| (name.as_str(), *link, signed.as_ref()));
        let key = signer.map(|signer| signer.key().verifying_key());
        let resumed = chain::resume(last, self.head.as_ref(), key);
        resumed.map_err(|error| {
            let (what, remedy) = match &error {
                ChainError::Signed { .. } => (
                    "these records are signed, and this one would not be".to_owned(),
                    "add --sign KEY, or name another folder",
                ),
                ChainError::Unsigned { .. } => (
                    "these records are not signed, and this one would be".to_owned(),
                    "a signed chain begins in a folder of its own: name another one",
                ),
                ChainError::Key { .. } => {
                    (error.to_string(), "sign with the key of this chain, or name another folder")
                }
                _ => return Failure::from(error).at(folder.display()),
            };
            let failure = Failure::new(FailureKind::Configuration, what);
            failure.at(folder.display()).with_remedy(remedy)
        })
    }
}

/// A folder whose records this key signs, locked against other writers that sign: so the head is
/// at most one record behind.
struct SignedFolder<'s> {
    folder: &'s Path,
    /// The folder itself, to sync and to lock it.
    handle: File,
    signer: RecordSigner<'s>,
    last: Option<Link>,
}

impl<'s> SignedFolder<'s> {
    /// Locks a folder, and writes its head if that is due.
    fn open(folder: &'s Path, signer: &'s Signer) -> Result<Self, Failure> {
        let handle = File::open(folder).map_err(|error| unwritable(folder, &error))?;
        lock(folder, &handle)?;
        let end = end(folder)?;
        let resumed = end.resume(folder, Some(signer))?;
        let chain = match resumed.chain {
            Some(chain) => chain,
            None => signer.new_chain()?,
        };
        let signer = RecordSigner { key: signer.key(), chain, provenance: signer.provenance() };
        let last = end.link();
        let open = Self { folder, handle, signer, last };
        if resumed.needs_head {
            let (count, hash) = last.map_or((0, [0; 32]), |link| (link.number + 1, link.hash));
            open.write_head(count, hash)?;
        }
        Ok(open)
    }

    /// Writes the head. The records that it counts are on the disk before, and it is after.
    fn write_head(&self, count: u64, hash: [u8; 32]) -> Result<(), Failure> {
        let sync = || self.handle.sync_all().map_err(|error| unwritable(self.folder, &error));
        sync()?;
        let head = self.signer.sign(StatementKind::Head, count, hash);
        output::replace(&self.folder.join(HEAD_FILE), head.as_bytes())?;
        sync()
    }
}

/// Waits for the lock of a folder, which its holder's end releases, however it ends.
fn lock(folder: &Path, handle: &File) -> Result<(), Failure> {
    let begun_ns = clock::now_ns();
    loop {
        match handle.try_lock() {
            Ok(()) => return Ok(()),
            Err(TryLockError::Error(error)) => return Err(unwritable(folder, &error)),
            Err(TryLockError::WouldBlock) if clock::now_ns() - begun_ns < LOCK_LIMIT_NS => {
                clock::nap_ns(LOCK_NAP_NS);
            }
            Err(TryLockError::WouldBlock) => {
                let what = "another process has held the lock of this folder for 10 s";
                return Err(Failure::new(FailureKind::TryAgain, what)
                    .at(folder.display())
                    .with_remedy("give each process its own folder, or try again"));
            }
        }
    }
}
