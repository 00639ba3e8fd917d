//! The folder of a service, and the lock on it.
//!
//! ```text
//! FOLDER/trolley-INSTANCE/           locked by the server for as long as it lives
//! FOLDER/trolley-INSTANCE/pid        the server's process id, for people
//! FOLDER/trolley-INSTANCE/current    the name of the place of the server that runs
//! FOLDER/trolley-INSTANCE/<place>/   iceoryx2's root for one start of the server
//! ```
//!
//! Each start of a server has a place of its own: what a killed server or its clients left half
//! done is never opened again, and goes when the last of them has gone.

use super::Address;
use crate::error::OpenError;
use crate::folder::{self, default_folder};
use crate::place::{OwnFiles, Place, lock_dead, remove_if_empty, sweep_places};
use rustix::fs::{CWD, FlockOperation, Mode, OFlags, flock, openat};
use rustix::rand::{GetRandomFlags, getrandom};
use std::fs::{self, File};
use std::io::{self, Read as _, Write as _};
use std::os::unix::fs::MetadataExt as _;
use std::path::{Path, PathBuf};

/// The file in which the server writes its process id.
const PID: &str = "pid";
/// The file that names the place of the running server.
const CURRENT: &str = "current";
/// Length of the name of a place, in hexadecimal digits: short, because the path of a socket lies
/// below it.
const DIGITS: usize = 8;
/// Attempts to lock the folder while its last owner removes it.
const ATTEMPTS_MAX: usize = 16;

/// A service's folder, which is this process's as long as this lives.
#[derive(Debug)]
pub(super) struct ServicePlace {
    // Dropped in this order: the place, what a forced end would remove, then the lock.
    place: Option<Place>,
    root: PathBuf,
    _own: Option<OwnFiles>,
    _lock: File,
}

impl ServicePlace {
    /// Creates the folder if there is none, locks it, removes what dead servers left, and makes a
    /// new place.
    pub(super) fn take(address: &Address) -> Result<Self, OpenError> {
        let root = address.root().to_owned();
        let shown = root.display().to_string();
        let group = address.group();
        let mut attempt = 0;
        let lock = loop {
            match lock(above(address).and_then(|_checked| folder::make(&root, group))) {
                Ok(Some(lock)) => break lock,
                Ok(None) => {
                    let pid = read_short(&root.join(PID)).unwrap_or_default();
                    let pid = if pid.is_empty() { "?".to_owned() } else { pid };
                    return Err(OpenError::Taken { instance: address.instance().to_owned(), pid });
                }
                // The last server removed it at this moment.
                Err(error) if error.is_absent() && attempt < ATTEMPTS_MAX => attempt += 1,
                Err(error) => return Err(error),
            }
        };
        sweep(&root);
        let mut random = [0; DIGITS / 2];
        getrandom(&mut random, GetRandomFlags::empty()).map_err(OpenError::at("name", &shown))?;
        let name = format!("{:08x}", u32::from_ne_bytes(random));
        let place = Place::create(&root, &name, 1)?;
        let files = [CURRENT, PID].map(|name| root.join(name));
        let own = OwnFiles::note(&files, None, &root, &lock);
        let place = Self { place: Some(place), root, _own: own, _lock: lock };
        place.write(PID, &std::process::id().to_string(), group)?;
        Ok(place)
    }

    /// iceoryx2's root.
    pub(super) fn root(&self) -> &Path {
        self.place.as_ref().map_or(&self.root, Place::root)
    }

    /// Lets clients find this server. Before that, no other user can enter its place: what
    /// iceoryx2 made there is lent to their group all at once.
    pub(super) fn announce(&self, group: Option<u32>) -> Result<(), OpenError> {
        if let Some(group) = group {
            let shown = self.root().display().to_string();
            folder::lend(CWD, self.root(), group)
                .map_err(OpenError::at("lend to the group of clients", &shown))?;
        }
        let name = self.root().file_name().unwrap_or_default().to_string_lossy().into_owned();
        self.write(CURRENT, &name, group)
    }

    /// Writes a file at once: no reader sees half of it.
    fn write(&self, name: &str, text: &str, group: Option<u32>) -> Result<(), OpenError> {
        let path = self.root.join(name);
        let new = self.root.join(format!(".{name}.new"));
        let written = (|| -> io::Result<()> {
            let _left_by_a_killed_server = fs::remove_file(&new);
            let mut file = File::create_new(&new)?;
            file.write_all(text.as_bytes())?;
            if let Some(group) = group {
                folder::lend_file(&file, group)?;
            }
            fs::rename(&new, &path)
        })();
        written.map_err(OpenError::at("write", &path.display().to_string()))
    }
}

impl Drop for ServicePlace {
    /// Removes everything; what clients still hold stays for the next server.
    fn drop(&mut self) {
        for name in [CURRENT, PID] {
            let _for_people = fs::remove_file(self.root.join(name));
        }
        drop(self.place.take());
        sweep(&self.root);
        // The lock is held until the end of this function: no server starts in between.
        remove_if_empty(&self.root);
        if let Some(folder) = self.root.parent().filter(|path| **path == default_folder()) {
            remove_if_empty(folder);
        }
    }
}

/// The folder in which a service makes its own: made, or found and checked.
pub(super) fn above(address: &Address) -> Result<File, OpenError> {
    let above = address.root().parent().unwrap_or(address.root());
    let folder = match above.exists() {
        true => folder::check_owner(above),
        false => folder::make(above, address.group()),
    }?;
    address.group().map_or(Ok(()), |group| folder::check_reach(above, group))?;
    Ok(folder)
}

/// Removes what a service left that was killed: for the process that did it. `false` if the service
/// is alive, or its folder cannot be trusted.
///
/// Nothing that it wrote is opened, and nothing is waited for: what its clients still hold stays.
#[must_use]
pub fn remove_dead_service(address: &Address) -> bool {
    let root = address.root();
    let checked = match folder::enter(root) {
        Err(error) if error.is_absent() => return true,
        checked => checked,
    };
    let Ok(Some(lock)) = lock(checked) else { return false };
    // The same as at the end of a server that was not killed.
    drop(ServicePlace { place: None, root: root.to_owned(), _own: None, _lock: lock });
    true
}

/// Removes the places of dead servers that no client holds any more.
pub(super) fn sweep(root: &Path) {
    let _removed = sweep_places(root, is_place, 1);
}

/// Where the server that runs has its place, as it announced; `None` if there is none.
pub(super) fn current(root: &Path) -> Option<PathBuf> {
    let name = read_short(&root.join(CURRENT)).filter(|name| is_place(name))?;
    Some(root.join(name))
}

/// Whether the server of this place is dead: its lock is free.
pub(super) fn is_dead(place: &Path) -> bool {
    lock_dead(place).is_some()
}

fn is_place(name: &str) -> bool {
    name.len() == DIGITS && name.bytes().all(|byte| byte.is_ascii_hexdigit())
}

/// The first line of a small file; whatever lies there, it does not wait.
fn read_short(path: &Path) -> Option<String> {
    let flags = OFlags::RDONLY | OFlags::NOFOLLOW | OFlags::NONBLOCK | OFlags::CLOEXEC;
    let file = File::from(openat(CWD, path, flags, Mode::empty()).ok()?);
    let mut text = String::new();
    file.metadata().ok().filter(fs::Metadata::is_file)?;
    file.take(64).read_to_string(&mut text).ok()?;
    Some(text.trim().to_owned())
}

/// Locks the folder; `None` if another process holds the lock.
fn lock(folder: Result<File, OpenError>) -> Result<Option<File>, OpenError> {
    let lock = folder?;
    let failed = OpenError::at("lock", "the folder of the service");
    match flock(&lock, FlockOperation::NonBlockingLockExclusive) {
        Ok(()) => {}
        Err(rustix::io::Errno::WOULDBLOCK) => return Ok(None),
        Err(error) => return Err(failed(error.into())),
    }
    // Between opening and locking, its last owner may have removed it.
    match lock.metadata() {
        Ok(stat) if stat.nlink() > 0 => Ok(Some(lock)),
        Ok(_) => Err(failed(io::ErrorKind::NotFound.into())),
        Err(error) => Err(failed(error)),
    }
}
