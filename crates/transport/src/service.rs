//! The public service: planners ask, one server answers, anyone may listen.
//!
//! ```text
//! Client  --ask--> Pending --receive--> WireAnswer      Server  --take--> Asked --answer--> (gone)
//!   trolley/rank/v1, and a ring at trolley/wake/v1           publishes trolley/ranking/v1,
//! Listener: the latest ranking, the latest health                      trolley/health/v1
//! ```
//!
//! Its names are fixed, so that clients of any language find them: the root is
//! `FOLDER/trolley-INSTANCE`, and names of memory begin with `trolley-INSTANCE.`. Unlike a domain
//! it outlives its server: clients may stay connected while it is restarted.
//!
//! # Invariants
//!
//! - One server at a time: the root is locked with flock(2) as long as it lives. What dead nodes
//!   left is removed by the server alone: when it starts, by its [`Housekeeper`], and when it ends;
//!   the files themselves only if no living node is left.
//! - A request is copied out of shared memory once, and the copy is what is checked and used.
//! - No call blocks. A client that vanished costs its request, nothing else: `service/tests.rs`.

mod client;
mod listener;
mod place;
mod server;
#[cfg(test)]
mod tests;
mod wire;

pub use client::{ClientPort, Pending};
pub use listener::TopicSubscriber;
pub use server::{Housekeeper, Server, TakenRequest};

use crate::domain::{self, is_instance};
use crate::error::OpenError;
use iceoryx2::config::Config;
use iceoryx2::node::{Node, NodeBuilder, NodeState};
use iceoryx2::prelude::{
    CallbackProgression, LogLevel, NodeName, SignalHandlingMode, ipc, set_log_level,
};

/// The default folder of services.
pub const FOLDER: &str = domain::SHM;
/// Longest root that iceoryx2 takes (bytes).
const ROOT_MAX: usize = 49;
/// Maximum number of nodes of a service: its server, its clients and listeners.
const NODES_MAX: usize = 64;
/// Maximum number of listeners of a topic.
const LISTENERS_MAX: usize = 16;

/// Where a service is: the name of its instance, and the folder of its root.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Address {
    instance: String,
    root: String,
}

impl Address {
    /// The service of this instance in this folder, which should be on a tmpfs.
    ///
    /// # Errors
    ///
    /// If the name is not 1 to 12 of a-z, 0-9 and -, or the root would be longer than 49 bytes.
    pub fn new(folder: &str, instance: &str) -> Result<Self, OpenError> {
        if !is_instance(instance) {
            return Err(OpenError::Name { name: instance.to_owned() });
        }
        let root = format!("{}/trolley-{instance}", folder.trim_end_matches('/'));
        if root.len() > ROOT_MAX {
            return Err(OpenError::RootTooLong { root, most: ROOT_MAX });
        }
        Ok(Self { instance: instance.to_owned(), root })
    }

    /// The name of the instance.
    #[must_use]
    pub fn instance(&self) -> &str {
        &self.instance
    }

    /// iceoryx2's root.
    #[must_use]
    pub fn root(&self) -> &str {
        &self.root
    }

    /// What the names of its memory begin with. An instance's name holds no dot, so no two prefixes
    /// overlap.
    #[must_use]
    pub fn prefix(&self) -> String {
        format!("trolley-{}.", self.instance)
    }

    fn config(&self) -> Result<Config, OpenError> {
        domain::config(&self.prefix(), &self.root)
    }

    /// A node of this process, with this name.
    fn node(&self, name: &str) -> Result<Node<ipc::Service>, OpenError> {
        // iceoryx2 logs what it also returns, and a returned error is enough.
        set_log_level(LogLevel::Fatal);
        let fail = "join";
        let name = NodeName::new(name).map_err(OpenError::at(fail, &self.root))?;
        NodeBuilder::new()
            .name(&name)
            .config(&self.config()?)
            .signal_handling_mode(SignalHandlingMode::Disabled)
            .create::<ipc::Service>()
            .map_err(OpenError::at(fail, &self.root))
    }

    /// A node of a guest; it must not be the first, or the root would be unlocked.
    fn guest(&self, name: &str) -> Result<Node<ipc::Service>, OpenError> {
        if !std::path::Path::new(&self.root).is_dir() {
            return Err(self.no_service());
        }
        self.node(name)
    }

    fn no_service(&self) -> OpenError {
        let folder = self.root.rsplit_once('/').map_or("", |(folder, _)| folder);
        OpenError::NoService { instance: self.instance.clone(), folder: folder.to_owned() }
    }
}

/// Removes what dead nodes left to iceoryx2; returns how many nodes are still alive.
fn clean(config: &Config) -> usize {
    let mut living = 0;
    let listed = Node::<ipc::Service>::list(config, |state| {
        match state {
            NodeState::Dead(node) => {
                let patience = core::time::Duration::from_millis(100);
                if let Err(error) = node.blocking_remove_stale_resources(patience) {
                    // What stays is small, and is retried later.
                    tracing::debug!(%error, "a dead node stays");
                }
            }
            NodeState::Alive(_) | NodeState::Inaccessible(_) => living += 1,
            NodeState::Undefined(_) => {}
        }
        CallbackProgression::Continue
    });
    if let Err(error) = listed {
        tracing::debug!(%error, "cannot list nodes");
        // Which nodes are alive is unknown: nothing may be removed.
        return usize::MAX;
    }
    living
}
