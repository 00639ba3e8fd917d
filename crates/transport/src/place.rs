//! A folder that belongs to one process, its owner, and that others may enter as guests.
//!
//! ```text
//! FOLDER/NAME/          locked by its owner for as long as it lives
//! FOLDER/NAME/guests    locked, shared, by every guest
//! FOLDER/.trolley-new.* one that is being made
//! ```
//!
//! Locks are flock(2): the kernel gives them back however a process ends. So any process that finds
//! both locks free may remove the folder. Nothing here asks iceoryx2 whether somebody is alive.

mod forced;
mod sweep;

pub(crate) use forced::OwnFiles;
pub use forced::remove_own_files;
pub(crate) use sweep::{dead_places, sweep_places};

use crate::error::OpenError;
use crate::folder::{self, default_folder};
use rustix::fs::{CWD, FlockOperation, Mode, OFlags, RenameFlags, flock, openat};
use std::fs::{self, DirBuilder, File};
use std::io;
use std::os::unix::fs::{DirBuilderExt, MetadataExt};
use std::path::{Path, PathBuf};

/// Name of a folder before it is locked.
const UNBORN: &str = ".trolley-new.";
/// The file that guests lock.
const GUESTS: &str = "guests";
/// Attempts to make a place while others remove its folder, which is empty.
const ATTEMPTS_MAX: usize = 16;

/// The role of a process in a place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Role {
    /// Made it, and removes it.
    Owner {
        /// How often to look for guests, 1 ms apart.
        looks: usize,
    },
    /// Entered it.
    Guest,
}

/// A folder with a lock on it.
#[derive(Debug)]
pub(crate) struct Place {
    root: PathBuf,
    role: Role,
    /// Before the lock: what a forced end removes must still be locked.
    _own: Option<OwnFiles>,
    /// The folder itself for its owner, the guests' file for a guest. Closing it unlocks.
    _lock: File,
}

impl Place {
    /// Makes a new one.
    pub(crate) fn create(folder: &Path, name: &str, looks: usize) -> Result<Self, OpenError> {
        let root = folder.join(name);
        let shown = root.display().to_string();
        let mut attempt = 0;
        loop {
            let made = folder::make(folder, None).and_then(|_checked| {
                create_locked(folder, &root).map_err(OpenError::at("create", &shown))
            });
            match made {
                Ok(lock) => {
                    let own = OwnFiles::note(&[], Some(&root), folder, &lock);
                    let role = Role::Owner { looks };
                    return Ok(Self { root, role, _own: own, _lock: lock });
                }
                // The last user of the folder removed it at this moment.
                Err(error) if error.is_absent() && attempt < ATTEMPTS_MAX => attempt += 1,
                Err(error) => return Err(error),
            }
        }
    }

    /// Enters one that its owner made.
    pub(crate) fn enter(root: &Path) -> Result<Self, OpenError> {
        let _checked = folder::enter(root)?;
        let shown = root.display().to_string();
        let lock = lock_as_guest(root).map_err(OpenError::at("enter", &shown))?;
        Ok(Self { root: root.to_owned(), role: Role::Guest, _own: None, _lock: lock })
    }

    pub(crate) fn root(&self) -> &Path {
        &self.root
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        // The owner's lock is held until the end of this function: no sweeper interferes.
        if let Role::Owner { looks } = self.role {
            if !sweep::remove(&self.root, looks) {
                tracing::info!(root = %self.root.display(), "left for the next run to remove");
            }
            if let Some(folder) = self.root.parent().filter(|folder| **folder == default_folder()) {
                remove_if_empty(folder);
            }
        }
    }
}

/// Removes a folder of this user's that nobody needs any more; nothing happens if it is not empty,
/// or another user's, which root could remove.
pub(crate) fn remove_if_empty(folder: &Path) {
    let is_own = fs::symlink_metadata(folder)
        .is_ok_and(|found| found.uid() == rustix::process::geteuid().as_raw());
    if is_own {
        let _used_by_others = rustix::fs::rmdir(folder);
    }
}

/// Makes the folder under another name, locks it, and only then gives it its name: under that, no
/// process ever sees it unlocked while its owner lives.
fn create_locked(folder: &Path, root: &Path) -> io::Result<File> {
    let name = root.file_name().unwrap_or_default().to_string_lossy();
    let unborn = folder.join(format!("{UNBORN}{}.{name}", std::process::id()));
    DirBuilder::new().mode(0o700).create(&unborn)?;
    let made = (|| {
        let lock = File::open(&unborn)?;
        flock(&lock, FlockOperation::NonBlockingLockExclusive)?;
        File::create_new(unborn.join(GUESTS))?;
        rustix::fs::renameat_with(CWD, &unborn, CWD, root, RenameFlags::NOREPLACE)?;
        Ok(lock)
    })();
    if made.is_err() {
        // Nothing but this file can be in it. If it cannot be removed, the next sweep will.
        let _swept_later = fs::remove_dir_all(&unborn);
    }
    made
}

/// Opens the guests' file; whatever lies there, it does not wait.
fn open_guests(root: &Path) -> io::Result<File> {
    let flags = OFlags::RDONLY | OFlags::NOFOLLOW | OFlags::NONBLOCK | OFlags::CLOEXEC;
    Ok(openat(CWD, root.join(GUESTS), flags, Mode::empty())?.into())
}

/// Locks the guests' file together with all other guests.
fn lock_as_guest(root: &Path) -> io::Result<File> {
    let lock = open_guests(root)?;
    flock(&lock, FlockOperation::NonBlockingLockShared)?;
    // Between opening and locking, a sweeper may have removed it.
    if lock.metadata()?.nlink() == 0 {
        return Err(io::ErrorKind::NotFound.into());
    }
    Ok(lock)
}

/// Locks the guests' file against all guests, as long as what it returns lives; an error while
/// there is one. `None` if the file is gone, because a removal was interrupted: then no process can
/// enter.
fn lock_out_guests(root: &Path) -> io::Result<Option<File>> {
    let lock = match open_guests(root) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
        opened => opened?,
    };
    flock(&lock, FlockOperation::NonBlockingLockExclusive)?;
    Ok(Some(lock))
}

/// Locks a folder whose owner is dead; `None` if it is alive.
pub(crate) fn lock_dead(root: &Path) -> Option<File> {
    let lock = File::from(open_folder(root).ok()?);
    flock(&lock, FlockOperation::NonBlockingLockExclusive).ok().map(|()| lock)
}

pub(crate) fn open_folder(root: &Path) -> rustix::io::Result<std::os::fd::OwnedFd> {
    let flags = OFlags::DIRECTORY | OFlags::NOFOLLOW | OFlags::NONBLOCK | OFlags::CLOEXEC;
    openat(CWD, root, flags | OFlags::RDONLY, Mode::empty())
}
