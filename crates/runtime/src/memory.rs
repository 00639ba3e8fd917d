//! Memory files: the sealed model store, the shared status page, and mapped model files.

use crate::{Doing as _, OsError};
use memmap2::{Mmap, MmapMut, MmapOptions, MmapRaw};
use protocol::StatusPage;
use rustix::fs::{
    MemfdFlags, SealFlags, fcntl_add_seals, fcntl_get_seals, ftruncate, memfd_create,
};
use std::fs::File;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::path::Path;

const SEALS: SealFlags =
    SealFlags::WRITE.union(SealFlags::GROW).union(SealFlags::SHRINK).union(SealFlags::SEAL);

/// Memory that nobody can change any more, the writer included.
#[derive(Debug)]
pub struct SealedMemory {
    file: File,
    map: Mmap,
}

impl SealedMemory {
    /// Makes a memory file of `len` bytes, lets `fill` write it, and seals it.
    ///
    /// # Errors
    ///
    /// If the system refuses the memory, the mapping or the seals.
    pub fn create(name: &str, len: usize, fill: impl FnOnce(&mut [u8])) -> Result<Self, OsError> {
        let file = memory_file(name, len, MemfdFlags::ALLOW_SEALING)?;
        // SAFETY: the file was made a line ago and nobody else knows it.
        let mut map = unsafe { MmapMut::map_mut(&file) }.doing(|| format!("map {name}"))?;
        fill(&mut map);
        // A writable mapping that is left makes the seal fail.
        drop(map);
        fcntl_add_seals(&file, SEALS).doing(|| format!("seal {name}"))?;
        Self::map(file, name)
    }

    /// Maps sealed memory that was inherited.
    ///
    /// # Errors
    ///
    /// If it is not sealed against every change, or cannot be mapped.
    pub fn from_fd(fd: OwnedFd) -> Result<Self, OsError> {
        let seals = fcntl_get_seals(&fd).doing(|| "read the seals of the store".to_owned())?;
        if !seals.contains(SEALS) {
            return Err(OsError::new("trust the store: it is not sealed", rustix::io::Errno::PERM));
        }
        Self::map(File::from(fd), "the store")
    }

    fn map(file: File, name: &str) -> Result<Self, OsError> {
        // Private: older kernels refuse shared mappings of write-sealed memory. The pages are shared
        // all the same, for nobody writes.
        // SAFETY: sealed against writing and shrinking, so the bytes can never change or vanish.
        let map = unsafe { MmapOptions::new().map_copy_read_only(&file) };
        Ok(Self { map: map.doing(|| format!("map {name}"))?, file })
    }

    /// The bytes, at the beginning of a page.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        &self.map
    }
}

impl AsFd for SealedMemory {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.file.as_fd()
    }
}

fn memory_file(name: &str, len: usize, flags: MemfdFlags) -> Result<File, OsError> {
    let fd = memfd_create(name, flags | MemfdFlags::CLOEXEC)
        .doing(|| format!("make the memory file {name}"))?;
    ftruncate(&fd, len as u64).doing(|| format!("give {name} {len} bytes"))?;
    Ok(File::from(fd))
}

/// The status page, mapped for reading and writing, shared with every process that has its file.
#[derive(Debug)]
pub struct StatusMemory {
    file: File,
    map: MmapRaw,
}

impl StatusMemory {
    /// Makes a page of zeros.
    ///
    /// # Errors
    ///
    /// If the system refuses.
    pub fn create() -> Result<Self, OsError> {
        let flags = MemfdFlags::ALLOW_SEALING;
        let file = memory_file("trolley-status", size_of::<StatusPage>(), flags)?;
        // Its size can then never change, which `page` relies on.
        fcntl_add_seals(&file, SealFlags::SHRINK | SealFlags::GROW)
            .doing(|| "seal the size of the status page".to_owned())?;
        Self::map(file)
    }

    /// Maps an inherited page.
    ///
    /// # Errors
    ///
    /// If it has another size, or can shrink.
    pub fn from_fd(fd: OwnedFd) -> Result<Self, OsError> {
        let file = File::from(fd);
        let seals =
            fcntl_get_seals(&file).doing(|| "read the seals of the status page".to_owned())?;
        let len = file.metadata().doing(|| "read the size of the status page".to_owned())?.len();
        if len != size_of::<StatusPage>() as u64 || !seals.contains(SealFlags::SHRINK) {
            let skew = rustix::io::Errno::INVAL;
            return Err(OsError::new("use the status page: it is another program's", skew));
        }
        Self::map(file)
    }

    fn map(file: File) -> Result<Self, OsError> {
        let map = MmapRaw::map_raw(&file).doing(|| "map the status page".to_owned())?;
        Ok(Self { file, map })
    }

    /// The page.
    #[must_use]
    pub fn page(&self) -> &StatusPage {
        let page = self.map.as_ptr().cast::<StatusPage>();
        // SAFETY: mapped at a page boundary with exactly this size, which is sealed; it consists of
        // atomics alone, so zeros are valid and other processes may write it at any time; it is
        // unmapped only when `self` is dropped.
        unsafe { &*page }
    }
}

impl AsFd for StatusMemory {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.file.as_fd()
    }
}

/// A file mapped for reading.
///
/// Whoever truncates the file while it is mapped makes a later access end the process (SIGBUS), as
/// with every mapped file; so its bytes are copied into a [`SealedMemory`] before they are used.
#[derive(Debug)]
pub struct FileMap {
    map: Option<Mmap>,
}

impl FileMap {
    /// Maps a regular file.
    ///
    /// # Errors
    ///
    /// If it cannot be opened or mapped, or is no regular file.
    pub fn open(path: &Path) -> Result<Self, OsError> {
        let name = || format!("open {}", path.display());
        let file = File::open(path).doing(name)?;
        let about = file.metadata().doing(name)?;
        if !about.is_file() {
            return Err(OsError::new(name(), std::io::Error::other("not a regular file")));
        }
        if about.len() == 0 {
            return Ok(Self { map: None });
        }
        // SAFETY: read-only; a concurrent writer can change what is read, which every reader of
        // these bytes checks for (a hash), or truncate it, see above.
        let map = unsafe { Mmap::map(&file) }.doing(|| format!("map {}", path.display()))?;
        Ok(Self { map: Some(map) })
    }

    /// The bytes, at the beginning of a page.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        self.map.as_deref().unwrap_or_default()
    }
}

#[cfg(test)]
mod tests;
