//! The files and locks of a domain. Knows nothing of iceoryx2 but where its files lie.

use super::sweep;
use crate::error::OpenError;
use protocol::Boot;
use rustix::fs::{CWD, FallocateFlags, FlockOperation, RenameFlags, flock};
use rustix::io::Errno;
use std::fs::{self, DirBuilder, File};
use std::io;
use std::os::unix::fs::{DirBuilderExt, MetadataExt};
use std::path::Path;

/// Where iceoryx2 keeps its memory, so its root lies there too: one place to sweep, and a tmpfs.
pub(crate) const SHM: &str = "/dev/shm";
/// Prefix of all our names in [`SHM`].
pub(super) const OURS: &str = "trolley.";
/// Name of a root before it is locked.
pub(super) const UNBORN: &str = ".trolley-new.";
/// The file in a root that workers lock.
const GUESTS: &str = "guests";
/// Longest instance name; the root then has 46 bytes, and iceoryx2 allows 49.
const INSTANCE_MAX: usize = 12;

/// The role of a process in a domain.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Role {
    /// Made it, and removes it.
    Owner,
    /// Entered it.
    Guest,
}

/// A root with a lock on it.
#[derive(Debug)]
pub(super) struct Place {
    root: String,
    boot: Boot,
    role: Role,
    /// The root itself for its owner, the guests' file for a guest. Closing it unlocks.
    _lock: File,
}

impl Place {
    pub(super) fn create(instance: &str, boot: Boot) -> Result<Self, OpenError> {
        let name =
            name_of(instance, boot).ok_or_else(|| OpenError::Name { name: instance.to_owned() })?;
        let root = format!("{SHM}/{name}");
        let lock = create_locked(&root, boot).map_err(OpenError::at("create", &root))?;
        Ok(Self { root, boot, role: Role::Owner, _lock: lock })
    }

    pub(super) fn enter(text: &str) -> Result<Self, OpenError> {
        let boot = text
            .strip_prefix(SHM)
            .and_then(|rest| rest.strip_prefix('/'))
            .and_then(boot_of)
            .ok_or_else(|| OpenError::Text { text: text.to_owned() })?;
        let lock = lock_as_guest(text).map_err(OpenError::at("enter", text))?;
        Ok(Self { root: text.to_owned(), boot, role: Role::Guest, _lock: lock })
    }

    pub(super) fn root(&self) -> &str {
        &self.root
    }

    pub(super) fn boot(&self) -> Boot {
        self.boot
    }

    pub(super) fn role(&self) -> Role {
        self.role
    }

    /// What the names of this domain's memory begin with.
    pub(super) fn prefix(&self) -> String {
        prefix_of(self.name())
    }

    fn name(&self) -> &str {
        self.root.rsplit('/').next().unwrap_or_default()
    }

    pub(super) fn commit(&self) -> Result<(), OpenError> {
        commit_all(&self.prefix())
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        // The owner's lock is held until the end of this function: no sweeper interferes.
        if self.role == Role::Owner && !sweep::remove(self.name(), sweep::OWN_LOOKS) {
            tracing::warn!(root = self.root, "left for the next run to remove");
        }
    }
}

/// The name of a domain in [`SHM`]; `None` if the instance's name is not fit for it.
fn name_of(instance: &str, boot: Boot) -> Option<String> {
    is_instance(instance).then(|| format!("{OURS}{instance}.{:016x}", boot.0))
}

/// Whether a name can be that of an instance.
pub(crate) fn is_instance(name: &str) -> bool {
    let fits = |byte: u8| byte.is_ascii_lowercase() || byte.is_ascii_digit() || byte == b'-';
    (1..=INSTANCE_MAX).contains(&name.len()) && name.bytes().all(fits)
}

/// The boot in the name of a domain; `None` if it is not one.
pub(super) fn boot_of(name: &str) -> Option<Boot> {
    let (instance, boot) = name.strip_prefix(OURS)?.split_once('.')?;
    let boot = Boot(u64::from_str_radix(boot, 16).ok()?);
    (name_of(instance, boot)? == name).then_some(boot)
}

/// What the names of a domain's memory begin with.
pub(super) fn prefix_of(name: &str) -> String {
    format!("{name}-")
}

pub(crate) fn names_in_shm() -> io::Result<Vec<String>> {
    let mut names = Vec::new();
    for entry in fs::read_dir(SHM)? {
        // What is not UTF-8 is not ours.
        names.extend(entry?.file_name().into_string());
    }
    Ok(names)
}

/// Makes the root under another name, locks it, and only then gives it its name: under that, no
/// process ever sees it unlocked while its owner lives.
fn create_locked(root: &str, boot: Boot) -> io::Result<File> {
    let unborn = format!("{SHM}/{UNBORN}{}.{:016x}", std::process::id(), boot.0);
    DirBuilder::new().mode(0o700).create(&unborn)?;
    let made = (|| {
        let lock = File::open(&unborn)?;
        flock(&lock, FlockOperation::NonBlockingLockExclusive)?;
        File::create_new(format!("{unborn}/{GUESTS}"))?;
        rustix::fs::renameat_with(CWD, &unborn, CWD, root, RenameFlags::NOREPLACE)?;
        Ok(lock)
    })();
    if made.is_err() {
        // Nothing but this file can be in it. If it cannot be removed, the next sweep will.
        let _swept_later = fs::remove_dir_all(&unborn);
    }
    made
}

/// Locks the guests' file together with all other guests.
fn lock_as_guest(root: &str) -> io::Result<File> {
    let lock = File::options().read(true).write(true).open(Path::new(root).join(GUESTS))?;
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
pub(super) fn lock_out_guests(root: &str) -> io::Result<Option<File>> {
    let lock = match File::options().read(true).write(true).open(Path::new(root).join(GUESTS)) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
        opened => opened?,
    };
    flock(&lock, FlockOperation::NonBlockingLockExclusive)?;
    Ok(Some(lock))
}

/// Locks a root whose owner is dead; `None` if it is alive.
pub(super) fn lock_root(root: &str) -> Option<File> {
    let lock = File::open(root).ok()?;
    flock(&lock, FlockOperation::NonBlockingLockExclusive).ok().map(|()| lock)
}

/// Allocates all memory whose name begins with `prefix`.
pub(crate) fn commit_all(prefix: &str) -> Result<(), OpenError> {
    for name in names_in_shm().map_err(OpenError::at("list", SHM))? {
        if name.starts_with(prefix) {
            let path = format!("{SHM}/{name}");
            commit_file(&path).map_err(OpenError::at("take shared memory for", &path))?;
        }
    }
    Ok(())
}

fn commit_file(path: &str) -> io::Result<()> {
    let file = match File::options().read(true).write(true).open(path) {
        Ok(file) => file,
        // Removed or still being made by a peer, who commits it itself.
        Err(e) if matches!(e.kind(), io::ErrorKind::NotFound | io::ErrorKind::PermissionDenied) => {
            return Ok(());
        }
        Err(e) => return Err(e),
    };
    let len = file.metadata()?.len();
    if len == 0 {
        return Ok(());
    }
    loop {
        match rustix::fs::fallocate(&file, FallocateFlags::empty(), 0, len) {
            Err(Errno::INTR) => {}
            done => return Ok(done?),
        }
    }
}
