//! Memory that one process writes and others read.
//!
//! Its size is sealed, so that no access can raise SIGBUS; and nobody but its maker can map it
//! writable.

use crate::error::{OsError, Result};
use core::sync::atomic::{AtomicU64, Ordering};
use memmap2::{MmapOptions, MmapRaw};
use rustix::fs::{FallocateFlags, MemfdFlags, SealFlags};
use std::io;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};

const SEALS: SealFlags =
    SealFlags::GROW.union(SealFlags::SHRINK).union(SealFlags::FUTURE_WRITE).union(SealFlags::SEAL);

/// Words that this process writes and others read.
#[derive(Debug)]
pub struct WrittenWords {
    words: Words,
    fd: OwnedFd,
}

/// Words that another process writes.
#[derive(Debug)]
pub struct ReadWords(Words);

/// A mapping of so many words.
#[derive(Debug)]
struct Words {
    map: MmapRaw,
    len: usize,
}

impl Words {
    fn all(&self) -> &[AtomicU64] {
        // SAFETY: the mapping starts on a page boundary, has this many words, cannot be shortened
        // (sealed), and lives as long as `self`. Every bit pattern is a valid atomic, and writes by
        // another process to atomics are no races. Only the maker's mapping is writable, and only
        // `WrittenWords::write` stores: a load of eight aligned bytes needs no writable memory.
        unsafe { core::slice::from_raw_parts(self.map.as_ptr().cast(), self.len) }
    }
}

impl WrittenWords {
    /// Makes so many words, all 0.
    ///
    /// # Errors
    ///
    /// If memory or file descriptors ran out.
    pub fn create(name: &str, len: usize) -> Result<Self> {
        let bytes = len * size_of::<u64>();
        let fd = rustix::fs::memfd_create(name, MemfdFlags::CLOEXEC | MemfdFlags::ALLOW_SEALING)
            .map_err(OsError::at("create memory", name))?;
        rustix::fs::ftruncate(&fd, bytes as u64).map_err(OsError::at("size memory", name))?;
        rustix::fs::fallocate(&fd, FallocateFlags::empty(), 0, bytes as u64)
            .map_err(OsError::at("take memory for", name))?;
        let map = MmapOptions::new().len(bytes).map_raw(&fd).map_err(OsError::at("map", name))?;
        rustix::fs::fcntl_add_seals(&fd, SEALS).map_err(OsError::at("seal", name))?;
        Ok(Self { words: Words { map, len }, fd })
    }

    /// Writes words from word `first` on.
    ///
    /// # Panics
    ///
    /// There are not so many.
    pub fn write(&self, first: usize, words: &[u64]) {
        let place = &self.words.all()[first..first + words.len()];
        place.iter().zip(words).for_each(|(place, word)| place.store(*word, Ordering::Relaxed));
    }

    /// The memfd, to be inherited by children.
    #[must_use]
    pub fn fd(&self) -> BorrowedFd<'_> {
        self.fd.as_fd()
    }
}

impl ReadWords {
    /// Takes over words that another process made.
    ///
    /// # Errors
    ///
    /// If their number is another, or others may be written: these are no such words.
    pub fn from_fd(fd: OwnedFd, len: usize) -> Result<Self> {
        let name = "inherited words";
        let bytes = len * size_of::<u64>();
        let seals =
            rustix::fs::fcntl_get_seals(&fd).map_err(OsError::at("read the seals of", name))?;
        let size = rustix::fs::fstat(&fd).map_err(OsError::at("measure", name))?.st_size;
        if !seals.contains(SEALS) || size != bytes as i64 {
            let why = io::Error::new(io::ErrorKind::InvalidData, "wrong size or wrong seals");
            return Err(OsError::new("trust", name, why));
        }
        let map = MmapOptions::new()
            .len(bytes)
            .map_raw_read_only(&fd)
            .map_err(OsError::at("map", name))?;
        Ok(Self(Words { map, len }))
    }

    /// Appends `count` words from word `first` on; `false` if there are not so many.
    #[must_use]
    pub fn read(&self, first: usize, count: usize, words: &mut Vec<u64>) -> bool {
        let place = first.checked_add(count).and_then(|end| self.0.all().get(first..end));
        let Some(place) = place else { return false };
        words.extend(place.iter().map(|word| word.load(Ordering::Relaxed)));
        true
    }
}
