//! The folder of a service, and the lock on it.

use super::{Address, clean};
use crate::domain::{SHM, names_in_shm};
use crate::error::OpenError;
use rustix::fs::{FlockOperation, flock};
use std::fs::{self, DirBuilder, File};
use std::io::{self, Write as _};
use std::os::unix::fs::{DirBuilderExt, MetadataExt};
use std::path::Path;

/// The file in which the server writes its process id, for people.
const PID: &str = "pid";

/// A root that is ours as long as this lives.
#[derive(Debug)]
pub(super) struct Place {
    address: Address,
    _lock: File,
}

impl Place {
    /// Creates the root if there is none, locks it, and removes unused files.
    pub(super) fn take(address: &Address) -> Result<Self, OpenError> {
        let root = address.root();
        let mut tries = 0;
        let lock = loop {
            match lock(root) {
                Ok(Some(lock)) => break lock,
                Ok(None) => {
                    let pid = fs::read_to_string(Path::new(root).join(PID)).unwrap_or_default();
                    let pid = if pid.trim().is_empty() { "?" } else { pid.trim() }.to_owned();
                    return Err(OpenError::Taken { instance: address.instance().to_owned(), pid });
                }
                // The last server removed it at this moment.
                Err(error) if error.kind() == io::ErrorKind::NotFound && tries < 3 => tries += 1,
                Err(error) => return Err(OpenError::at("lock", root)(error)),
            }
        };
        let place = Self { address: address.clone(), _lock: lock };
        if clean(&address.config()?) == 0 {
            place.empty().map_err(OpenError::at("empty", root))?;
        }
        let path = Path::new(root).join(PID);
        let written =
            File::create(&path).and_then(|mut file| write!(file, "{}", std::process::id()));
        written.map_err(OpenError::at("write", &path.display().to_string()))?;
        Ok(place)
    }

    /// Removes all files; the caller ensures that they are unused.
    fn empty(&self) -> io::Result<()> {
        let prefix = self.address.prefix();
        for name in names_in_shm()?.iter().filter(|name| name.starts_with(&prefix)) {
            fs::remove_file(Path::new(SHM).join(name))?;
        }
        for entry in fs::read_dir(self.address.root())? {
            let path = entry?.path();
            if path.is_dir() { fs::remove_dir_all(&path)? } else { fs::remove_file(&path)? }
        }
        Ok(())
    }
}

impl Drop for Place {
    /// Removes everything, unless a client is still alive: then the next server does.
    fn drop(&mut self) {
        let Ok(config) = self.address.config() else { return };
        let living = clean(&config);
        if living > 0 {
            tracing::info!(living, "clients are connected: the service's files stay for them");
            let _for_people = fs::remove_file(Path::new(self.address.root()).join(PID));
            return;
        }
        // The lock is held until the end of this function: no server starts in between.
        let gone = self.empty().and_then(|()| fs::remove_dir(self.address.root()));
        if let Err(error) = gone {
            tracing::warn!(root = self.address.root(), %error, "left for the next to remove");
        }
    }
}

/// Locks the root; `None` if another process holds the lock.
fn lock(root: &str) -> io::Result<Option<File>> {
    match DirBuilder::new().recursive(true).mode(0o700).create(root) {
        Err(error) if error.kind() != io::ErrorKind::AlreadyExists => return Err(error),
        Ok(()) | Err(_) => {}
    }
    let lock = File::open(root)?;
    match flock(&lock, FlockOperation::NonBlockingLockExclusive) {
        Ok(()) => {}
        Err(rustix::io::Errno::WOULDBLOCK) => return Ok(None),
        Err(error) => return Err(error.into()),
    }
    // Between opening and locking, its last owner may have removed it.
    if lock.metadata()?.nlink() == 0 {
        return Err(io::ErrorKind::NotFound.into());
    }
    Ok(Some(lock))
}
