//! A domain: the name space of one start of one coordinator, and the files behind it.
//!
//! ```text
//! FOLDER/trolley.<instance>.<boot>/    locked by the coordinator for as long as it lives
//!     guests                           locked, shared, by every worker
//!     <worker>.<inc>/                  iceoryx2's root for one incarnation
//! ```
//!
//! Each incarnation of a worker has a root of its own, which is removed with it: iceoryx2 never has
//! to clean up after a dead worker, which may wait, and may fail on memory that was corrupted.

use crate::error::OpenError;
use crate::folder::default_folder;
use crate::ipc::Ipc;
use crate::place::{Place, dead_places, sweep_places};
use core::fmt;
use core::time::Duration;
use iceoryx2::config::Config;
use iceoryx2::node::{Node, NodeBuilder};
use iceoryx2::prelude::{
    FileName, LogLevel, NodeName, Path as IceoryxPath, SemanticString, SignalHandlingMode,
    set_log_level,
};
use protocol::{Boot, Incarnation};
use std::os::unix::ffi::OsStrExt as _;
use std::path::{Path, PathBuf};
use std::rc::Rc;

/// Prefix of the names of all domains.
const OURS: &str = "trolley.";
/// Longest instance name.
const INSTANCE_MAX: usize = 12;
/// Prefix of all files that iceoryx2 makes; their folder tells whose they are.
const PREFIX: &str = "t.";
/// How often to look for guests of one's own domain, 1 ms apart: they were told to end, or killed,
/// and a busy machine may be slow to end them.
const LOOKS: usize = 1_000;
/// The same for a domain of another coordinator: its workers die with it, but a moment later.
const GUEST_LOOKS: usize = 200;
/// How long iceoryx2 may wait for a small file that another process is writing. Only processes that
/// start wait for these.
const CREATION: Duration = Duration::from_millis(100);

/// One start of one coordinator, as seen by one process. Clones refer to the same one.
///
/// It belongs to one thread. When the last copy and the last link of the creator are gone, so are
/// all files; end the workers first.
#[derive(Clone)]
pub struct Domain(Rc<Inner>);

struct Inner {
    place: Place,
    boot: Boot,
    text: String,
}

impl Domain {
    /// Starts a domain in a private folder; `None`: the [default one](default_folder). `boot` must
    /// be random: it makes the name new.
    ///
    /// # Errors
    ///
    /// If the instance has no proper name, or the folder cannot be made or
    /// [trusted](crate::folder).
    pub fn create(folder: Option<&Path>, instance: &str, boot: Boot) -> Result<Self, OpenError> {
        let name =
            name_of(instance, boot).ok_or_else(|| OpenError::Name { name: instance.to_owned() })?;
        let folder = folder.map_or_else(default_folder, Path::to_owned);
        let place = Place::create(&folder, &name, LOOKS)?;
        let text = place.root().display().to_string();
        Ok(Self(Rc::new(Inner { place, boot, text })))
    }

    /// Enters the domain that the coordinator calls by this [`Domain::text`].
    ///
    /// # Errors
    ///
    /// If there is no such domain, or its coordinator is gone and it is being removed.
    pub fn open(text: &str) -> Result<Self, OpenError> {
        let root = Path::new(text);
        let is_plain = root.is_absolute()
            && !root.components().any(|part| part == std::path::Component::ParentDir);
        let boot = text.rsplit('/').next().filter(|_| is_plain).and_then(boot_of);
        let boot = boot.ok_or_else(|| OpenError::Text { text: text.to_owned() })?;
        let place = Place::enter(root)?;
        Ok(Self(Rc::new(Inner { place, boot, text: text.to_owned() })))
    }

    /// The name that [`Domain::open`] understands: for a command line.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.0.text
    }

    /// The boot number that is part of the name.
    #[must_use]
    pub fn boot(&self) -> Boot {
        self.0.boot
    }

    /// Its folder.
    pub(crate) fn folder(&self) -> &Path {
        self.0.place.root()
    }

    /// iceoryx2's root for an incarnation.
    pub(crate) fn root_of(&self, who: Incarnation) -> PathBuf {
        self.0.place.root().join(format!("{}.{}", who.worker, who.inc))
    }
}

impl fmt::Debug for Domain {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Domain").field(&self.text()).finish()
    }
}

/// Removes what dead runs of every instance left in a folder; returns the number of runs. Files of
/// other programs stay. Nothing is removed from a folder that cannot be trusted.
#[must_use]
pub fn sweep_leftovers(folder: &Path) -> usize {
    if crate::folder::enter(folder).is_err() {
        return 0;
    }
    sweep_places(folder, |name| boot_of(name).is_some(), GUEST_LOOKS)
}

/// Names of runs and services whose process is dead, in a folder; nothing is removed.
#[must_use]
pub fn dead_instances(folder: &Path) -> Vec<String> {
    dead_places(folder, |name| boot_of(name).is_some() || name.starts_with("trolley-"))
}

/// The name of a domain; `None` if the instance's name is not fit for it.
fn name_of(instance: &str, boot: Boot) -> Option<String> {
    is_instance(instance).then(|| format!("{OURS}{instance}.{:016x}", boot.0))
}

/// Whether a name can be that of an instance.
pub(crate) fn is_instance(name: &str) -> bool {
    let fits = |byte: u8| byte.is_ascii_lowercase() || byte.is_ascii_digit() || byte == b'-';
    (1..=INSTANCE_MAX).contains(&name.len()) && name.bytes().all(fits)
}

/// The boot in the name of a domain; `None` if it is not one.
fn boot_of(name: &str) -> Option<Boot> {
    let (instance, boot) = name.strip_prefix(OURS)?.split_once('.')?;
    let boot = Boot(u64::from_str_radix(boot, 16).ok()?);
    (name_of(instance, boot)? == name).then_some(boot)
}

/// A node of this process in one of iceoryx2's roots.
pub(crate) fn node(root: &Path, name: &str) -> Result<Node<Ipc>, OpenError> {
    // iceoryx2 logs what it also returns, and a returned error is enough.
    set_log_level(LogLevel::Fatal);
    let shown = root.display().to_string();
    let fail = "join";
    let name = NodeName::new(name).map_err(OpenError::at(fail, &shown))?;
    NodeBuilder::new()
        .name(&name)
        .config(&config(root)?)
        .signal_handling_mode(SignalHandlingMode::Disabled)
        .create::<Ipc>()
        .map_err(OpenError::at(fail, &shown))
}

/// Everything in code: iceoryx2 would look for files in the working directory, home and /etc.
pub(crate) fn config(root: &Path) -> Result<Config, OpenError> {
    let shown = root.display().to_string();
    let mut config = Config::default();
    config.global.prefix =
        FileName::new(PREFIX.as_bytes()).map_err(OpenError::at("use the prefix of", &shown))?;
    let path = IceoryxPath::new(root.as_os_str().as_bytes())
        .map_err(OpenError::at("use the path", &shown))?;
    config.global.set_root_path(&path);
    config.global.creation_timeout = CREATION;
    config.global.node.cleanup_dead_nodes_on_creation = false;
    config.global.node.cleanup_dead_nodes_on_destruction = false;
    config.global.service.cleanup_dead_nodes_on_open = false;
    Ok(config)
}

#[cfg(test)]
mod tests;
