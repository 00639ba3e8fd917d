//! The names of one coordinator's start: where its channels live, and how they go away.
//!
//! ```text
//! /dev/shm/trolley.INSTANCE.BOOT        root path of iceoryx2: service and node files
//! /dev/shm/trolley.INSTANCE.BOOT.lock   held by the coordinator as long as it lives
//! /dev/shm/trly.BOOT.*                  segments
//! ```
//!
//! Names carry the boot, so two runs never meet, and what a dead one left is known by its free lock.

use crate::OpenError;
use core::time::Duration;
use iceoryx2::config::Config;
use iceoryx2::prelude::{
    FileName, LogLevel, Node, NodeBuilder, NodeName, Path as RootPath, SemanticString,
    SignalHandlingMode, ipc, set_log_level,
};
use protocol::Boot;
use rustix::fs::{FallocateFlags, FlockOperation, fallocate, flock};
use std::fs::{self, File};
use std::io;
use std::os::unix::fs::MetadataExt as _;
use std::path::PathBuf;

const SHM: &str = "/dev/shm";

/// The names, and the node that opens channels under them.
#[derive(Debug)]
pub struct Domain {
    instance: String,
    boot: Boot,
    node: Option<Node<ipc::Service>>,
    /// Held by the coordinator alone.
    lock: Option<File>,
}

fn root(instance: &str, boot: Boot) -> PathBuf {
    PathBuf::from(format!("{SHM}/trolley.{instance}.{:016x}", boot.0))
}

fn lock_file(instance: &str, boot: Boot) -> PathBuf {
    PathBuf::from(format!("{SHM}/trolley.{instance}.{:016x}.lock", boot.0))
}

fn prefix(boot: Boot) -> String {
    format!("trly.{:016x}.", boot.0)
}

fn is_instance(name: &str) -> bool {
    let allowed = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
    (1..=12).contains(&name.len()) && name.chars().all(allowed)
}

impl Domain {
    /// Opens a new domain: the coordinator's.
    ///
    /// # Errors
    ///
    /// If the instance name is not one, or shared memory is not there or not writable.
    pub fn create(instance: &str, boot: Boot) -> Result<Self, OpenError> {
        if !is_instance(instance) {
            return Err(OpenError::Instance(instance.to_owned()));
        }
        let lock = locked(instance, boot)?;
        let mut domain = Self { instance: instance.to_owned(), boot, node: None, lock: Some(lock) };
        let folder = root(instance, boot);
        fs::create_dir(&folder)
            .map_err(OpenError::system("create", &folder.display().to_string()))?;
        domain.node = Some(node(instance, boot, "coordinator")?);
        Ok(domain)
    }

    /// Joins a domain: a worker's way, with the text of [`Domain::text`].
    ///
    /// # Errors
    ///
    /// If the text is not one, or the domain is gone.
    pub fn open(text: &str) -> Result<Self, OpenError> {
        let parsed = text.split_once('.').and_then(|(instance, boot)| {
            let boot = u64::from_str_radix(boot, 16).ok()?;
            is_instance(instance).then(|| (instance.to_owned(), Boot(boot)))
        });
        let (instance, boot) = parsed.ok_or_else(|| OpenError::Instance(text.to_owned()))?;
        let node = Some(node(&instance, boot, "worker")?);
        Ok(Self { instance, boot, node, lock: None })
    }

    /// What a worker needs to join.
    #[must_use]
    pub fn text(&self) -> String {
        format!("{}.{:016x}", self.instance, self.boot.0)
    }

    /// Whose domain it is.
    #[must_use]
    pub fn boot(&self) -> Boot {
        self.boot
    }

    pub(crate) fn node(&self) -> Result<&Node<ipc::Service>, OpenError> {
        self.node.as_ref().ok_or_else(|| OpenError::Instance(self.text()))
    }

    /// Asks the kernel for every page of every segment now: too little memory is then an error
    /// here and not a SIGBUS later.
    ///
    /// # Errors
    ///
    /// If there is not enough shared memory.
    pub fn commit(&self) -> Result<(), OpenError> {
        for path in segments(self.boot) {
            let name = path.display().to_string();
            // A segment may be on its way out: another process cleans up after itself.
            let Ok(file) = File::options().read(true).write(true).open(&path) else { continue };
            let len = file.metadata().map_err(OpenError::system("look at", &name))?.len();
            if len > 0 {
                fallocate(&file, FallocateFlags::empty(), 0, len)
                    .map_err(OpenError::system("reserve shared memory for", &name))?;
            }
        }
        Ok(())
    }
}

impl Drop for Domain {
    fn drop(&mut self) {
        self.node = None;
        if self.lock.is_some() {
            remove(&self.instance, self.boot);
        }
    }
}

/// A new lock file, locked. A sweep that came between the two took it for a dead run's.
fn locked(instance: &str, boot: Boot) -> Result<File, OpenError> {
    let path = lock_file(instance, boot);
    let name = path.display().to_string();
    loop {
        let lock = File::create_new(&path).map_err(OpenError::system("create", &name))?;
        flock(&lock, FlockOperation::LockExclusive).map_err(OpenError::system("lock", &name))?;
        if lock.metadata().map_err(OpenError::system("look at", &name))?.nlink() > 0 {
            return Ok(lock);
        }
    }
}

fn node(instance: &str, boot: Boot, role: &str) -> Result<Node<ipc::Service>, OpenError> {
    set_log_level(LogLevel::Error);
    let failed = |step| OpenError::shown(step, instance);
    let mut config = Config::default();
    config.global.prefix =
        FileName::new(prefix(boot).as_bytes()).map_err(OpenError::shown("name", instance))?;
    let folder = root(instance, boot);
    let folder = RootPath::new(folder.as_os_str().as_encoded_bytes())
        .map_err(OpenError::shown("name", instance))?;
    config.global.set_root_path(&folder);
    config.global.creation_timeout = Duration::from_millis(500);
    config.global.node.cleanup_dead_nodes_on_creation = false;
    config.global.node.cleanup_dead_nodes_on_destruction = false;
    config.global.service.cleanup_dead_nodes_on_open = false;
    let name = NodeName::new(role).map_err(OpenError::shown("name", instance))?;
    NodeBuilder::new()
        .name(&name)
        .config(&config)
        .signal_handling_mode(SignalHandlingMode::Disabled)
        .create::<ipc::Service>()
        .map_err(failed("open a node in"))
}

fn segments(boot: Boot) -> Vec<PathBuf> {
    let prefix = prefix(boot);
    let entries = fs::read_dir(SHM).into_iter().flatten().flatten();
    let ours = entries.filter(|entry| entry.file_name().to_string_lossy().starts_with(&prefix));
    ours.map(|entry| entry.path()).collect()
}

/// Removes all that bears the names of a domain, the lock last: until then it is ours.
fn remove(instance: &str, boot: Boot) {
    for segment in segments(boot) {
        report(fs::remove_file(&segment), &segment);
    }
    let folder = root(instance, boot);
    report(fs::remove_dir_all(&folder), &folder);
    let lock = lock_file(instance, boot);
    report(fs::remove_file(&lock), &lock);
}

fn report(result: io::Result<()>, path: &std::path::Path) {
    match result {
        Err(error) if error.kind() != io::ErrorKind::NotFound => {
            tracing::warn!(%error, path = %path.display(), "cannot remove");
        }
        _ => {}
    }
}

/// Removes what killed coordinators left behind, and says how many there were.
///
/// A coordinator's workers die with it, so a free lock means that nobody is left.
#[must_use]
pub fn sweep() -> usize {
    let mut swept = 0;
    for entry in fs::read_dir(SHM).into_iter().flatten().flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        let parsed = name
            .strip_prefix("trolley.")
            .and_then(|rest| rest.strip_suffix(".lock"))
            .and_then(|rest| rest.split_once('.'))
            .and_then(|(instance, boot)| {
                let number = u64::from_str_radix(boot, 16).ok()?;
                (boot.len() == 16 && is_instance(instance)).then_some((instance, Boot(number)))
            });
        let Some((instance, boot)) = parsed else { continue };
        let Ok(lock) = File::open(entry.path()) else { continue };
        if flock(&lock, FlockOperation::NonBlockingLockExclusive).is_ok() {
            tracing::info!(%name, "removing what a killed run left behind");
            remove(instance, boot);
            swept += 1;
        }
    }
    swept
}

#[cfg(test)]
mod tests;
