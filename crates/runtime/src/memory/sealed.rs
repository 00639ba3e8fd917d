//! Memory that is written once and can then never change: the model store.
//!
//! A memfd is filled through a mapping that is gone before the seals are set (else the kernel says
//! EBUSY). A child that is being started has a copy of it until it runs its program; that is waited
//! for. From then on no process can write, grow or shrink it, nor take the seals off. It is
//! mapped `MAP_PRIVATE | PROT_READ`: the same pages without a copy, and kernels before 6.7 refuse
//! a shared mapping of a write-sealed memfd.

use crate::clock::{nap_ns, now_ns};
use crate::error::{OsError, Result};
use core::fmt;
use memmap2::{Mmap, MmapOptions};
use rustix::fs::{FallocateFlags, MemfdFlags, SealFlags};
use rustix::io::Errno;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};

/// Every seal that keeps the bytes and their number as they are, and itself.
const SEALS: SealFlags =
    SealFlags::WRITE.union(SealFlags::GROW).union(SealFlags::SHRINK).union(SealFlags::SEAL);

/// How long children are waited for: far longer than one takes from fork to exec `[ns]`.
const CHILDREN_NS: u64 = 5_000_000_000;
/// Between two looks whether it has run its program `[ns]`.
const NAP_NS: u64 = 100_000;

/// Read-only memory that was sealed.
pub struct SealedMemory {
    map: Mmap,
    len: usize,
    fd: OwnedFd,
}

impl SealedMemory {
    /// Makes `len` bytes, lets `fill` write them (they are zero before), and seals them.
    ///
    /// `name` shows in /proc/PID/maps, and is at most 249 bytes long. All memory is taken before
    /// `fill` runs: running out of it is an error here, not a SIGBUS there.
    ///
    /// # Errors
    ///
    /// If memory or file descriptors ran out, or a child that another thread starts has not run its
    /// program for seconds.
    pub fn create(name: &str, len: usize, fill: impl FnOnce(&mut [u8])) -> Result<Self> {
        let fd = rustix::fs::memfd_create(name, MemfdFlags::CLOEXEC | MemfdFlags::ALLOW_SEALING)
            .map_err(OsError::at("create memory", name))?;
        rustix::fs::ftruncate(&fd, len as u64).map_err(OsError::at("size memory", name))?;
        if len > 0 {
            rustix::fs::fallocate(&fd, FallocateFlags::empty(), 0, len as u64)
                .map_err(OsError::at("take memory for", name))?;
            // SAFETY: the memfd was made above and nothing else refers to it, so nothing but this
            // mapping changes its pages; it is `len` bytes long and cannot be shortened.
            let mut map = unsafe { MmapOptions::new().len(len).map_mut(&fd) }
                .map_err(OsError::at("map memory", name))?;
            fill(&mut map);
        } else {
            fill(&mut []);
        }
        seal(&fd).map_err(OsError::at("seal memory", name))?;
        Self::map(fd, name)
    }

    /// Takes over a memfd that another process made by [`SealedMemory::create`].
    ///
    /// # Errors
    ///
    /// If a seal is missing: then another process could still change what was checked.
    pub fn from_fd(fd: OwnedFd) -> Result<Self> {
        let name = "inherited memory";
        let seals =
            rustix::fs::fcntl_get_seals(&fd).map_err(OsError::at("read the seals of", name))?;
        if !seals.contains(SEALS) {
            let why = std::io::Error::new(std::io::ErrorKind::InvalidData, "a seal is missing");
            return Err(OsError::new("trust", name, why));
        }
        Self::map(fd, name)
    }

    fn map(fd: OwnedFd, name: &str) -> Result<Self> {
        let size = rustix::fs::fstat(&fd).map_err(OsError::at("measure", name))?.st_size;
        let len = usize::try_from(size).map_err(|_overflow| {
            OsError::new("map memory", name, std::io::Error::from(std::io::ErrorKind::FileTooLarge))
        })?;
        // Populated now, so that no request pays for page faults.
        // SAFETY: all seals are set (by `create`, or seen by `from_fd`), so the kernel refuses
        // every change of contents and length for as long as the memfd lives.
        let map = unsafe { MmapOptions::new().len(len).populate().map_copy_read_only(&fd) }
            .map_err(OsError::at("map memory", name))?;
        Ok(Self { map, len, fd })
    }

    /// The bytes, from the start of a page.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        &self.map
    }

    /// The memfd, to be inherited by children.
    #[must_use]
    pub fn fd(&self) -> BorrowedFd<'_> {
        self.fd.as_fd()
    }
}

/// Sets the seals, once no child that another thread is starting has a copy of the mapping.
fn seal(fd: &OwnedFd) -> rustix::io::Result<()> {
    let until_ns = now_ns() + CHILDREN_NS;
    loop {
        match rustix::fs::fcntl_add_seals(fd, SEALS) {
            Err(Errno::BUSY) if now_ns() < until_ns => nap_ns(NAP_NS),
            sealed => return sealed,
        }
    }
}

impl fmt::Debug for SealedMemory {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("SealedMemory").field("len", &self.len).field("fd", &self.fd).finish()
    }
}
