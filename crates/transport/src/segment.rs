//! Memory that processes share, as files of a private folder.
//!
//! A segment exists whole or not at all: it is made without a name, allocated, and initialised, and
//! only then linked into its folder. So
//!
//! - a process that is killed while it makes one leaves nothing, and no other process ever waits
//!   for one to be finished;
//! - a full file system is an error here, and not a SIGBUS at a later write;
//! - no file can be opened by other users, whatever the umask and whatever iceoryx2 asks for, but
//!   by the group to which its folder is lent.
//!
//! iceoryx2's own storages make the name first; its shared-memory one then waits without bound for
//! a size that a killed process never set.

mod config;

pub(crate) use config::SegmentConfig;

use core::fmt::Debug;
use core::marker::PhantomData;
use core::mem::{MaybeUninit, offset_of};
use core::ptr::NonNull;
use core::sync::atomic::{AtomicBool, Ordering};
use core::time::Duration;
use iceoryx2::prelude::{FileName, Path as IceoryxPath, SemanticString};
use iceoryx2_bb_elementary::bump_allocator::BumpAllocator;
use iceoryx2_bb_elementary_traits::testing::abandonable::Abandonable;
use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;
use iceoryx2_bb_posix::access_mode::AccessMode;
use iceoryx2_cal::dynamic_storage::{
    DynamicStorage, DynamicStorageBuilder, DynamicStorageCreateError, DynamicStorageOpenError,
    DynamicStorageOpenOrCreateError, Initializer,
};
use iceoryx2_cal::named_concept::{
    NamedConcept, NamedConceptBuilder, NamedConceptConfiguration, NamedConceptDoesExistError,
    NamedConceptListError, NamedConceptMgmt, NamedConceptPathHintRemoveError,
    NamedConceptRemoveError,
};
use memmap2::{MmapOptions, MmapRaw};
use rustix::fs::{AtFlags, CWD, FallocateFlags, Mode, OFlags};
use rustix::io::Errno;
use std::fs::{self, File};
use std::os::fd::AsRawFd as _;
use std::path::{Path, PathBuf};

/// First word of every segment; changes with the layout of what follows.
const MAGIC: u64 = u64::from_le_bytes(*b"trolley1");
/// Attempts to open or make a segment while others make and remove it.
const ATTEMPTS_MAX: usize = 64;

/// What a segment begins with; the memory behind it is for what `T` points to.
#[repr(C)]
struct Contents<T> {
    magic: u64,
    value: MaybeUninit<T>,
}

/// A value of type `T` in shared memory, and what it points to.
#[derive(Debug)]
pub(crate) struct Segment<T: Debug + Send + Sync + ZeroCopySend> {
    name: FileName,
    path: PathBuf,
    map: MmapRaw,
    is_owner: AtomicBool,
    of: PhantomData<T>,
}

impl<T: Debug + Send + Sync + ZeroCopySend> Segment<T> {
    fn value(&self) -> *mut T {
        self.map.as_mut_ptr().wrapping_add(offset_of!(Contents<T>, value)).cast()
    }
}

// SAFETY: the mapping belongs to no thread, and `T` may be shared between threads and sent.
unsafe impl<T: Debug + Send + Sync + ZeroCopySend> Send for Segment<T> {}
// SAFETY: as above.
unsafe impl<T: Debug + Send + Sync + ZeroCopySend> Sync for Segment<T> {}

impl<T: Debug + Send + Sync + ZeroCopySend> Drop for Segment<T> {
    fn drop(&mut self) {
        if !*self.is_owner.get_mut() {
            return;
        }
        // SAFETY: the value was initialised before the segment got its name, and its owner alone
        // drops it, once.
        unsafe { self.value().drop_in_place() };
        if let Err(error) = fs::remove_file(&self.path) {
            tracing::debug!(path = %self.path.display(), %error, "a segment stays");
        }
    }
}

impl<T: Debug + Send + Sync + ZeroCopySend> Abandonable for Segment<T> {
    unsafe fn abandon_in_place(this: NonNull<Self>) {
        // SAFETY: the caller passes a value that it does not use again.
        let this = unsafe { &mut *this.as_ptr() };
        // The file stays for whoever cleans up.
        *this.is_owner.get_mut() = false;
        // SAFETY: as above; it is dropped once.
        unsafe { core::ptr::drop_in_place(&raw mut this.map) };
        // SAFETY: as above.
        unsafe { core::ptr::drop_in_place(&raw mut this.path) };
    }
}

impl<T: Debug + Send + Sync + ZeroCopySend> DynamicStorage<T> for Segment<T> {
    type Builder<'builder> = SegmentBuilder<'builder, T>;

    fn does_support_persistency() -> bool {
        true
    }

    fn has_ownership(&self) -> bool {
        self.is_owner.load(Ordering::Relaxed)
    }

    fn release_ownership(&self) {
        self.is_owner.store(false, Ordering::Relaxed);
    }

    fn acquire_ownership(&self) {
        self.is_owner.store(true, Ordering::Relaxed);
    }

    fn get(&self) -> &T {
        // SAFETY: the mapping is page-aligned and long enough for `Contents<T>`, which was checked
        // or made so; a named segment is initialised; and `T` is made for being shared.
        unsafe { &*self.value() }
    }

    unsafe fn __internal_set_type_name_in_config(config: &mut Self::Configuration, name: &str) {
        config.set_type_name(name);
    }
}

impl<T: Debug + Send + Sync + ZeroCopySend> NamedConcept for Segment<T> {
    fn name(&self) -> &FileName {
        &self.name
    }
}

impl<T: Debug + Send + Sync + ZeroCopySend> NamedConceptMgmt for Segment<T> {
    type Configuration = SegmentConfig<T>;

    unsafe fn remove_cfg(
        name: &FileName,
        config: &Self::Configuration,
    ) -> Result<bool, NamedConceptRemoveError> {
        match rustix::fs::unlink(config.file(name)) {
            Ok(()) => Ok(true),
            Err(Errno::NOENT) => Ok(false),
            Err(Errno::ACCESS | Errno::PERM) => {
                Err(NamedConceptRemoveError::InsufficientPermissions)
            }
            Err(_) => Err(NamedConceptRemoveError::InternalError),
        }
    }

    fn does_exist_cfg(
        name: &FileName,
        config: &Self::Configuration,
    ) -> Result<bool, NamedConceptDoesExistError> {
        match rustix::fs::lstat(config.file(name)) {
            Ok(_) => Ok(true),
            Err(Errno::NOENT) => Ok(false),
            Err(Errno::ACCESS) => Err(NamedConceptDoesExistError::InsufficientPermissions),
            Err(_) => Err(NamedConceptDoesExistError::InternalError),
        }
    }

    fn list_cfg(config: &Self::Configuration) -> Result<Vec<FileName>, NamedConceptListError> {
        let entries = match fs::read_dir(config.folder()) {
            Ok(entries) => entries,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(Vec::new()),
            Err(_) => return Err(NamedConceptListError::InternalError),
        };
        let names = entries.flatten().filter_map(|entry| {
            use std::os::unix::ffi::OsStrExt as _;
            let name = FileName::new(entry.file_name().as_bytes()).ok()?;
            config.extract_name_from_file(&name)
        });
        Ok(names.collect())
    }

    fn remove_path_hint(folder: &IceoryxPath) -> Result<(), NamedConceptPathHintRemoveError> {
        match rustix::fs::rmdir(folder.as_bytes()) {
            Ok(()) | Err(Errno::NOENT) => Ok(()),
            Err(Errno::ACCESS | Errno::PERM) => {
                Err(NamedConceptPathHintRemoveError::InsufficientPermissions)
            }
            Err(_) => Err(NamedConceptPathHintRemoveError::InternalError),
        }
    }
}

/// Opens or makes a [`Segment`].
#[derive(Debug)]
pub(crate) struct SegmentBuilder<'builder, T: Debug + Send + Sync + ZeroCopySend> {
    name: FileName,
    config: SegmentConfig<T>,
    /// Bytes behind the value.
    supplement: usize,
    is_owner: bool,
    initializer: Initializer<'builder, T>,
}

impl<T: Debug + Send + Sync + ZeroCopySend> NamedConceptBuilder<Segment<T>>
    for SegmentBuilder<'_, T>
{
    fn new(name: &FileName) -> Self {
        Self {
            name: *name,
            config: SegmentConfig::default(),
            supplement: 0,
            is_owner: true,
            initializer: Initializer::new(|_, _| false),
        }
    }

    fn config(mut self, config: &SegmentConfig<T>) -> Self {
        self.config = config.clone();
        self
    }
}

impl<'builder, T: Debug + Send + Sync + ZeroCopySend> DynamicStorageBuilder<'builder, T, Segment<T>>
    for SegmentBuilder<'builder, T>
{
    fn has_ownership(mut self, value: bool) -> Self {
        self.is_owner = value;
        self
    }

    /// Ignored: no segment is for all users.
    fn enable_global_access(self, _value: bool) -> Self {
        self
    }

    fn supplementary_size(mut self, value: usize) -> Self {
        self.supplement = value;
        self
    }

    /// Ignored: there is nothing to wait for.
    fn timeout(self, _value: Duration) -> Self {
        self
    }

    fn initializer<F: FnMut(&mut MaybeUninit<T>, &mut BumpAllocator) -> bool + 'builder>(
        mut self,
        value: F,
    ) -> Self {
        self.initializer = Initializer::new(value);
        self
    }

    fn create(mut self) -> Result<Segment<T>, DynamicStorageCreateError> {
        self.make()
    }

    fn open(self, access_mode: AccessMode) -> Result<Segment<T>, DynamicStorageOpenError> {
        self.find(access_mode)
    }

    fn open_or_create(mut self) -> Result<Segment<T>, DynamicStorageOpenOrCreateError> {
        for _ in 0..ATTEMPTS_MAX {
            match self.find(AccessMode::ReadWrite) {
                Err(DynamicStorageOpenError::DoesNotExist) => {}
                found => return Ok(found?),
            }
            match self.make() {
                Err(DynamicStorageCreateError::AlreadyExists) => {}
                made => return Ok(made?),
            }
        }
        Err(DynamicStorageCreateError::InternalError.into())
    }
}

impl<T: Debug + Send + Sync + ZeroCopySend> SegmentBuilder<'_, T> {
    fn find(&self, access: AccessMode) -> Result<Segment<T>, DynamicStorageOpenError> {
        let path = self.config.file(&self.name);
        let is_writable = access == AccessMode::ReadWrite;
        let map = map_existing(&path, is_writable, size_of::<Contents<T>>());
        let map = map.map_err(|errno| match errno {
            Errno::NOENT => DynamicStorageOpenError::DoesNotExist,
            error => {
                tracing::debug!(path = %path.display(), %error, "cannot open a segment");
                DynamicStorageOpenError::InternalError
            }
        })?;
        // SAFETY: the mapping is page-aligned and at least as long as `Contents<T>`; it was written
        // before the segment got its name, and not since.
        if unsafe { map.as_ptr().cast::<u64>().read_volatile() } != MAGIC {
            return Err(DynamicStorageOpenError::VersionMismatch);
        }
        let is_owner = AtomicBool::new(false);
        Ok(Segment { name: self.name, path, map, is_owner, of: PhantomData })
    }

    fn make(&mut self) -> Result<Segment<T>, DynamicStorageCreateError> {
        let path = self.config.file(&self.name);
        let failed = |errno| match errno {
            Errno::EXIST => DynamicStorageCreateError::AlreadyExists,
            Errno::ACCESS | Errno::PERM => DynamicStorageCreateError::InsufficientPermissions,
            error => {
                tracing::debug!(path = %path.display(), %error, "cannot make a segment");
                DynamicStorageCreateError::InternalError
            }
        };
        let supplement_at = size_of::<Contents<T>>();
        let length = supplement_at.checked_add(self.supplement);
        let length = length.ok_or(DynamicStorageCreateError::InternalError)?;
        let file = unnamed(self.config.folder(), length).map_err(failed)?;
        let map = MmapOptions::new().len(length).map_raw(&file);
        let map = map.map_err(|error| failed(Errno::from_io_error(&error).unwrap_or(Errno::IO)))?;
        let contents = map.as_mut_ptr().cast::<Contents<T>>();
        // SAFETY: the mapping is page-aligned, at least as long as `Contents<T>`, all zeros, and no
        // other process can open the file yet.
        let contents = unsafe { &mut *contents };
        contents.magic = MAGIC;
        let supplement = map.as_mut_ptr().wrapping_add(supplement_at);
        let supplement =
            NonNull::new(supplement).ok_or(DynamicStorageCreateError::InternalError)?;
        let mut allocator = BumpAllocator::new(supplement, self.supplement);
        if !self.initializer.call(&mut contents.value, &mut allocator) {
            return Err(DynamicStorageCreateError::InitializationFailed);
        }
        // By this path, because linking a bare descriptor takes a privilege.
        let source = format!("/proc/self/fd/{}", file.as_raw_fd());
        rustix::fs::linkat(CWD, source, CWD, &path, AtFlags::SYMLINK_FOLLOW).map_err(failed)?;
        let is_owner = AtomicBool::new(self.is_owner);
        Ok(Segment { name: self.name, path: path.clone(), map, is_owner, of: PhantomData })
    }
}

/// A file of zeros without a name, all of it allocated.
pub(crate) fn unnamed(folder: &Path, length: usize) -> Result<File, Errno> {
    let flags = OFlags::TMPFILE | OFlags::RDWR | OFlags::CLOEXEC;
    let file = rustix::fs::open(folder, flags, Mode::RUSR | Mode::WUSR)?;
    if let Some(group) = crate::folder::borrower(folder) {
        crate::folder::lend_file(&file, group)?;
    }
    loop {
        // Without a name it is gone if this fails, or if the process is killed.
        match rustix::fs::fallocate(&file, FallocateFlags::empty(), 0, length as u64) {
            Err(Errno::INTR) => {}
            done => return done.map(|()| File::from(file)),
        }
    }
}

/// Maps a segment of at least so many bytes. Whatever lies there, it does not wait.
fn map_existing(path: &Path, is_writable: bool, least: usize) -> Result<MmapRaw, Errno> {
    let access = if is_writable { OFlags::RDWR } else { OFlags::RDONLY };
    // Without NONBLOCK, opening a pipe waits for its other end.
    let flags = access | OFlags::CLOEXEC | OFlags::NOFOLLOW | OFlags::NONBLOCK;
    let file = rustix::fs::open(path, flags, Mode::empty())?;
    let stat = rustix::fs::fstat(&file)?;
    let is_file = rustix::fs::FileType::from_raw_mode(stat.st_mode).is_file();
    let length = usize::try_from(stat.st_size).map_err(|_negative| Errno::OVERFLOW)?;
    if !is_file || length < least {
        return Err(Errno::INVAL);
    }
    let mut options = MmapOptions::new();
    options.len(length);
    let map = if is_writable { options.map_raw(&file) } else { options.map_raw_read_only(&file) };
    map.map_err(|error| Errno::from_io_error(&error).unwrap_or(Errno::IO))
}

#[cfg(test)]
mod tests;
