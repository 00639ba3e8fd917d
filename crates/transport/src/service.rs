//! The public service: planners ask, one server answers, anyone may listen.
//!
//! ```text
//! Client  --ask--> Pending --receive--> WireAnswer      Server  --take--> Asked --answer--> (gone)
//!   trolley/rank/v1, and a ring at trolley/wake/v1           publishes trolley/ranking/v1,
//! Listener: the latest ranking, the latest health                      trolley/health/v1
//! ```
//!
//! Its folder has a fixed name, `FOLDER/trolley-INSTANCE`, so that clients find it. Each start of
//! the server has a place of its own in there; clients change over to it by themselves.
//!
//! # Invariants
//!
//! - One server at a time: its folder is locked with flock(2) as long as it lives. What dead
//!   clients left is removed in a process of its own, see [`Housekeeper`]; a place goes with its
//!   last user.
//! - A request is copied out of shared memory once, and the copy is what is checked and used.
//! - No call blocks. A client that vanished costs its request, nothing else: `service/tests.rs`.

mod client;
mod housekeeper;
mod listener;
mod place;
mod server;
#[cfg(test)]
mod tests;
mod wire;

pub use client::{ClientPort, Pending};
pub use housekeeper::Housekeeper;
pub use listener::TopicSubscriber;
pub use server::{Server, TakenRequest};

use crate::domain::{config, is_instance};
use crate::error::OpenError;
use crate::folder;
use crate::ipc::Ipc;
use crate::place::Place;
use core::time::Duration;
use iceoryx2::node::{Node, NodeState};
use iceoryx2::prelude::CallbackProgression;
use std::path::{Path, PathBuf};

/// Longest folder of an instance (bytes): the path of a socket, which lies in a place below it, has
/// at most 107.
const ROOT_MAX: usize = 49;
/// Maximum number of nodes of a service: its server, its clients and listeners.
const NODES_MAX: usize = 64;
/// Maximum number of listeners of a topic.
const LISTENERS_MAX: usize = 16;

/// Where a service is: the name of its instance, and the folder of its root.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Address {
    instance: String,
    root: PathBuf,
    group: Option<u32>,
}

impl Address {
    /// The service of this instance in this folder, which should be on a tmpfs; without one, in the
    /// [default folder](folder::default_folder).
    ///
    /// # Errors
    ///
    /// If the name is not 1 to 12 of a-z, 0-9 and -, or the root would be longer than 49 bytes.
    pub fn new(folder: Option<&Path>, instance: &str) -> Result<Self, OpenError> {
        if !is_instance(instance) {
            return Err(OpenError::Name { name: instance.to_owned() });
        }
        let folder = folder.map_or_else(folder::default_folder, Path::to_owned);
        let root = folder.join(format!("trolley-{instance}"));
        if root.as_os_str().len() > ROOT_MAX {
            let root = root.display().to_string();
            return Err(OpenError::RootTooLong { root, most: ROOT_MAX });
        }
        Ok(Self { instance: instance.to_owned(), root, group: None })
    }

    /// With a group whose members may be clients, too, by its number. Only the server needs it.
    #[must_use]
    pub fn with_group(self, group: Option<u32>) -> Self {
        Self { group, ..self }
    }

    /// The name of the instance.
    #[must_use]
    pub fn instance(&self) -> &str {
        &self.instance
    }

    /// The folder of the instance.
    #[must_use]
    pub fn root(&self) -> &Path {
        &self.root
    }

    pub(crate) fn group(&self) -> Option<u32> {
        self.group
    }

    /// Enters the place of the running server, as a client.
    fn enter(&self) -> Result<Place, OpenError> {
        let absent = || {
            let folder = self.root.parent().unwrap_or(Path::new("/")).display().to_string();
            OpenError::NoService { instance: self.instance.clone(), folder }
        };
        match folder::enter(&self.root) {
            Err(error) if error.is_absent() => return Err(absent()),
            checked => drop(checked?),
        }
        let place = place::current(&self.root).ok_or_else(absent)?;
        match Place::enter(&place) {
            Err(error) if error.is_absent() => Err(absent()),
            entered => entered,
        }
    }
}

/// Removes what dead nodes left to iceoryx2 in a place, so that new clients find room.
///
/// It opens memory that dead processes wrote: it may fail, or not return, if that is corrupt. Call
/// it in a process that is not needed for anything else.
pub fn clean(place: &Path) {
    let Ok(config) = config(place) else { return };
    let listed = Node::<Ipc>::list(&config, |state| {
        if let NodeState::Dead(node) = state
            && let Err(error) = node.blocking_remove_stale_resources(Duration::from_millis(100))
        {
            // What stays is small, and is retried later.
            tracing::debug!(%error, "a dead node stays");
        }
        CallbackProgression::Continue
    });
    if let Err(error) = listed {
        tracing::debug!(%error, "cannot list nodes");
    }
}

/// Whether a process that had a node in a place is dead. Reads names alone.
fn has_dead_node(place: &Path) -> bool {
    let Ok(entries) = std::fs::read_dir(place.join("nodes")) else { return false };
    let names = entries.flatten().filter_map(|entry| entry.file_name().into_string().ok());
    // A node goes by its number, which holds the id of its process in its third word.
    let pids = names.filter_map(|name| {
        let digits = name.split(|c: char| !c.is_ascii_digit()).find(|part| part.len() > 16)?;
        let number: u128 = digits.parse().ok()?;
        Some((number >> 64 & 0xffff_ffff) as u32)
    });
    let mut pids: Vec<u32> = pids.collect();
    pids.sort_unstable();
    pids.dedup();
    pids.into_iter().any(|pid| !Path::new(&format!("/proc/{pid}")).exists())
}
