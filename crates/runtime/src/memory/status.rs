//! The status page as memory that all processes of a run share, and may all write.
//!
//! Its size is sealed, so that no access can raise SIGBUS. What the words mean is said by
//! `protocol::status`; here they are only kept alive.

use crate::error::{OsError, Result};
use memmap2::{MmapOptions, MmapRaw};
use protocol::StatusPage;
use rustix::fs::{FallocateFlags, MemfdFlags, SealFlags};
use std::io;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};

const LEN: usize = size_of::<StatusPage>();
const SEALS: SealFlags = SealFlags::GROW.union(SealFlags::SHRINK).union(SealFlags::SEAL);

/// A shared mapping of one [`StatusPage`].
#[derive(Debug)]
pub struct StatusMemory {
    map: MmapRaw,
    fd: OwnedFd,
}

impl StatusMemory {
    /// Makes a page of zeros.
    ///
    /// # Errors
    ///
    /// If memory or file descriptors ran out.
    pub fn create() -> Result<Self> {
        let name = "trolley-status";
        let fd = rustix::fs::memfd_create(name, MemfdFlags::CLOEXEC | MemfdFlags::ALLOW_SEALING)
            .map_err(OsError::at("create memory", name))?;
        rustix::fs::ftruncate(&fd, LEN as u64).map_err(OsError::at("size memory", name))?;
        rustix::fs::fallocate(&fd, FallocateFlags::empty(), 0, LEN as u64)
            .map_err(OsError::at("take memory for", name))?;
        rustix::fs::fcntl_add_seals(&fd, SEALS).map_err(OsError::at("seal the size of", name))?;
        Self::map(fd)
    }

    /// Takes over the page that another process made.
    ///
    /// # Errors
    ///
    /// If it has another size or the size is not sealed: it is not such a page.
    pub fn from_fd(fd: OwnedFd) -> Result<Self> {
        let name = "inherited status page";
        let seals =
            rustix::fs::fcntl_get_seals(&fd).map_err(OsError::at("read the seals of", name))?;
        let size = rustix::fs::fstat(&fd).map_err(OsError::at("measure", name))?.st_size;
        if !seals.contains(SEALS) || seals.contains(SealFlags::WRITE) || size != LEN as i64 {
            let why = io::Error::new(io::ErrorKind::InvalidData, "wrong size or wrong seals");
            return Err(OsError::new("trust", name, why));
        }
        Self::map(fd)
    }

    fn map(fd: OwnedFd) -> Result<Self> {
        let map = MmapOptions::new()
            .len(LEN)
            .populate()
            .map_raw(&fd)
            .map_err(OsError::at("map", "status page"))?;
        Ok(Self { map, fd })
    }

    /// The page.
    #[must_use]
    pub fn page(&self) -> &StatusPage {
        // SAFETY: the mapping starts on a page boundary (so the 128-byte alignment holds), is as
        // long as a `StatusPage`, cannot be shortened (sealed), and lives as long as `self`. Every
        // bit pattern is a valid `StatusPage`, because it consists of atomics alone; so writes by
        // other processes are no races.
        unsafe { &*self.map.as_ptr().cast::<StatusPage>() }
    }

    /// The memfd, to be inherited by children.
    #[must_use]
    pub fn fd(&self) -> BorrowedFd<'_> {
        self.fd.as_fd()
    }
}
