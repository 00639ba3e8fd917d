//! The public service: planners ask, one server answers, anyone may listen.
//!
//! ```text
//! Client  --ask--> Pending --receive--> WireAnswer      Server  --take--> Asked --answer--> (gone)
//!   trolley/rank/v3, and a ring at trolley/wake/v3           publishes trolley/ranking/v3,
//! Listener: the latest ranking, the latest health                      trolley/health/v3
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
mod extent;
mod housekeeper;
mod listener;
mod notify_socket;
mod place;
mod server;
#[cfg(test)]
mod tests;
mod wire;

pub use client::{ClientPort, Pending};
pub use extent::{shared_bytes, shared_segments};
pub use housekeeper::Housekeeper;
pub use listener::TopicSubscriber;
pub use notify_socket::{Notice, NotifySocket};
pub use place::remove_dead_service;
pub use server::{Server, TakenRequest};

use crate::domain::{config, is_instance};
use crate::error::OpenError;
use crate::folder;
use crate::ipc::Ipc;
use crate::place::Place;
use core::time::Duration;
use iceoryx2::config::Config;
use iceoryx2::node::{DeadNodeView, Node, NodeState, NodeView as _};
use iceoryx2::prelude::CallbackProgression;
use rustix::fs::{Access, CWD, access};
use rustix::io::Errno;
use rustix::process::{Pid, test_kill_process};
use std::path::{Path, PathBuf};
use std::{fs, io};

/// Longest folder of an instance (bytes): the path of a socket, which lies in a place below it, has
/// at most 107.
const ROOT_MAX: usize = 49;
/// Maximum number of nodes of a service: its server, its clients and listeners.
const NODES_MAX: usize = 64;
/// How long cleaning up after one node may wait for another process that does the same.
const CLEAN_PATIENCE: Duration = Duration::from_millis(100);
/// Channels of dead clients that are no reason to clean up: a few for each client.
const DEAD_CHANNELS_MAX: usize = 4 * protocol::public::CLIENTS_MAX;
/// What the names of channels end with.
const CHANNEL: &str = ".connection";
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

    /// With a group whose members may be clients, too, by its number. Only the server needs it, and
    /// the user must be [of it](folder::is_member).
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
        if place::is_dead(&place) {
            return Err(absent());
        }
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
    let clean = |dead: DeadNodeView<Ipc>| {
        if let Err(error) = dead.blocking_remove_stale_resources(CLEAN_PATIENCE) {
            tracing::debug!(%error, "a dead node stays");
        }
    };
    let mut remaining = Vec::new();
    let remains = |dead: DeadNodeView<Ipc>| remaining.push(dead.id().value());
    if !each_dead_node(&config, clean) || !each_dead_node(&config, remains) {
        return;
    }
    // The others died while they were made, or were half removed: nothing refers to them.
    for (path, node) in nodes(place) {
        if !remaining.contains(&node) && is_dead(node) {
            let is_folder = path.symlink_metadata().is_ok_and(|file| file.is_dir());
            let removed =
                if is_folder { fs::remove_dir_all(&path) } else { fs::remove_file(&path) };
            if let Err(error) = removed {
                tracing::debug!(path = %path.display(), %error, "stays");
            }
        }
    }
    // A port that dies between making a channel and entering itself in it, or between leaving it
    // and removing it, is not known to it: iceoryx2 then keeps its file for ever.
    let remains = |port: &u128| remaining.iter().any(|node| process_of(*node) == process_of(*port));
    for (path, ports) in channels(place) {
        if ports.iter().any(|port| is_dead(*port)) && !ports.iter().any(remains) {
            match fs::remove_file(&path) {
                // The server has let go of it at this moment.
                Err(error) if error.kind() == io::ErrorKind::NotFound => {}
                Err(error) => tracing::debug!(path = %path.display(), %error, "stays"),
                Ok(()) => tracing::debug!(path = %path.display(), "removed a channel of nobody"),
            }
        }
    }
}

/// Calls `f` with every dead node that iceoryx2 can clean up after; `false` if none can be listed.
fn each_dead_node(config: &Config, mut f: impl FnMut(DeadNodeView<Ipc>)) -> bool {
    let listed = Node::<Ipc>::list(config, |state| {
        // One without details has opened nothing, and iceoryx2 would look for it elsewhere.
        if let NodeState::Dead(dead) = state
            && dead.details().is_some()
        {
            f(dead);
        }
        CallbackProgression::Continue
    });
    listed.inspect_err(|error| tracing::debug!(%error, "cannot list nodes")).is_ok()
}

/// Whether a process that had a node in a place is dead, or too many that had channels. Reads names
/// alone.
fn has_dead(place: &Path) -> bool {
    let is_of_dead = |(_, ports): &(PathBuf, [u128; 2])| ports.iter().any(|port| is_dead(*port));
    // One of a client of another user, killed before it lent it to the group, stays until that user
    // or root removes it: nothing refers to it.
    let is_removable = |path: &Path| access(path, Access::WRITE_OK).is_ok();
    nodes(place).any(|(path, node)| is_dead(node) && is_removable(&path))
        // Some are let go of by the server when it hears from the next client.
        || channels(place).filter(is_of_dead).nth(DEAD_CHANNELS_MAX).is_some()
}

/// Files and folders of nodes, with the node's number, which their names hold.
fn nodes(place: &Path) -> impl Iterator<Item = (PathBuf, u128)> {
    let entries = fs::read_dir(place.join("nodes")).into_iter().flatten().flatten();
    entries.filter_map(|entry| {
        let name = entry.file_name().into_string().ok()?;
        let digits = name.split(|c: char| !c.is_ascii_digit()).find(|part| part.len() > 16)?;
        Some((entry.path(), digits.parse().ok()?))
    })
}

/// Files of channels, with the numbers of their sender and receiver, which end their names.
fn channels(place: &Path) -> impl Iterator<Item = (PathBuf, [u128; 2])> {
    let entries = fs::read_dir(place).into_iter().flatten().flatten();
    entries.filter_map(|entry| {
        let name = entry.file_name().into_string().ok()?;
        let mut ports = name.strip_suffix(CHANNEL)?.rsplit('_').map(str::parse);
        let (receiver, sender) = (ports.next()?.ok()?, ports.next()?.ok()?);
        Some((entry.path(), [sender, receiver]))
    })
}

/// Whether the process of a node or port is dead. /proc would not tell: that of a service may hide
/// the processes of other users, who may be clients.
fn is_dead(number: u128) -> bool {
    let pid = i32::try_from(process_of(number)).ok().and_then(Pid::from_raw);
    pid.is_none_or(|pid| test_kill_process(pid) == Err(Errno::SRCH))
}

/// Lends what a node of this process has made to the group of clients, if there is one: its server
/// removes it, should this process be killed.
fn lend_node(place: &Path, node: &Node<Ipc>) -> Result<(), OpenError> {
    let Some(group) = folder::borrower(place) else { return Ok(()) };
    let own = node.id().value();
    for (path, _) in nodes(place).filter(|(_, node)| *node == own) {
        let shown = path.display().to_string();
        folder::lend(CWD, &path, group)
            .map_err(OpenError::at("lend to the group of clients", &shown))?;
    }
    Ok(())
}

/// The process of a node or port: the third word of its number.
fn process_of(number: u128) -> u32 {
    (number >> 64 & 0xffff_ffff) as u32
}
