//! A domain: the name space of one start of one coordinator, and the files behind it.
//!
//! ```text
//! /dev/shm/trolley.<instance>.<boot>/          iceoryx2's root: nodes, services
//!                                              locked by the coordinator for as long as it lives
//! /dev/shm/trolley.<instance>.<boot>/guests    locked, shared, by every worker
//! /dev/shm/trolley.<instance>.<boot>-*         iceoryx2's memory
//! ```
//!
//! Locks are flock(2): the kernel gives them back however a process ends. iceoryx2 cannot clean up
//! after a killed coordinator without a live one that shares its names; here the names end with the
//! run, and any process that finds a free lock may remove all of it.

mod place;
mod sweep;

pub(crate) use place::{SHM, commit_all, is_instance, names_in_shm};
pub use sweep::{dead_instances, sweep_leftovers};

use crate::error::OpenError;
use core::fmt;
use core::time::Duration;
use iceoryx2::config::Config;
use iceoryx2::node::{Node, NodeBuilder, NodeState};
use iceoryx2::prelude::{
    CallbackProgression, FileName, LogLevel, NodeName, Path, SemanticString, SignalHandlingMode,
    ipc, set_log_level,
};
use place::{Place, Role};
use protocol::Boot;
use std::rc::Rc;

/// One start of one coordinator, as seen by one process. Clones refer to the same one.
///
/// It belongs to one thread. When the last copy and the last link of the creator are gone, so are
/// all files; end the workers first.
#[derive(Clone)]
pub struct Domain(Rc<Inner>);

struct Inner {
    /// Before the place: its files must be closed before they are removed.
    node: Node<ipc::Service>,
    place: Place,
}

impl Domain {
    /// Starts a domain. `boot` must be random: it makes the names new.
    ///
    /// # Errors
    ///
    /// If the instance has no proper name, or /dev/shm refuses: no space, no permission, no file
    /// descriptors.
    pub fn create(instance: &str, boot: Boot) -> Result<Self, OpenError> {
        Self::start(Place::create(instance, boot)?)
    }

    /// Enters the domain that the coordinator calls by this [`Domain::text`].
    ///
    /// # Errors
    ///
    /// If there is no such domain, or its coordinator is gone and it is being removed.
    pub fn open(text: &str) -> Result<Self, OpenError> {
        Self::start(Place::enter(text)?)
    }

    fn start(place: Place) -> Result<Self, OpenError> {
        // iceoryx2 logs what it also returns, and a returned error is enough.
        set_log_level(LogLevel::Fatal);
        let root = place.root();
        let fail = "join";
        let name = match place.role() {
            Role::Owner => "coordinator",
            Role::Guest => "worker",
        };
        let name = NodeName::new(name).map_err(OpenError::at(fail, root))?;
        let config = config(&place.prefix(), place.root())?;
        let node = NodeBuilder::new()
            .name(&name)
            .config(&config)
            .signal_handling_mode(SignalHandlingMode::Disabled)
            .create::<ipc::Service>()
            .map_err(OpenError::at(fail, root))?;
        Ok(Self(Rc::new(Inner { node, place })))
    }

    /// The name that [`Domain::open`] understands: for a command line.
    #[must_use]
    pub fn text(&self) -> &str {
        self.0.place.root()
    }

    /// The boot number that is part of the name.
    #[must_use]
    pub fn boot(&self) -> Boot {
        self.0.place.boot()
    }

    /// Removes what dead workers left to iceoryx2, from any thread.
    #[must_use]
    pub fn cleaner(&self) -> Cleaner {
        Cleaner { config: self.0.node.config().clone() }
    }

    /// Allocates all memory of the domain now: later, writing beyond what is available would raise
    /// SIGBUS.
    ///
    /// # Errors
    ///
    /// If there is not enough.
    pub(crate) fn commit(&self) -> Result<(), OpenError> {
        self.0.place.commit()
    }

    pub(crate) fn node(&self) -> &Node<ipc::Service> {
        &self.0.node
    }
}

impl fmt::Debug for Domain {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Domain").field(&self.text()).finish()
    }
}

/// Removes what dead workers of a running domain left. Made by [`Domain::cleaner`].
#[derive(Clone, Debug)]
pub struct Cleaner {
    config: Config,
}

impl Cleaner {
    /// Removes nodes whose process is dead; returns how many. Takes milliseconds for each.
    ///
    /// Only after the dead worker's results were taken: it removes them too. Not while another
    /// worker is starting: iceoryx2's clean-up races with creation (its issues 927 and 1578).
    #[must_use]
    pub fn run(&self) -> usize {
        let mut removed = 0;
        let listed = Node::<ipc::Service>::list(&self.config, |state| {
            if let NodeState::Dead(node) = state {
                match node.blocking_remove_stale_resources(Duration::from_millis(100)) {
                    Ok(()) => removed += 1,
                    // What stays is small, and is removed with the domain.
                    Err(error) => tracing::debug!(%error, "a dead node stays"),
                }
            }
            CallbackProgression::Continue
        });
        if let Err(error) = listed {
            tracing::debug!(%error, "cannot list nodes");
        }
        removed
    }
}

/// Everything in code: iceoryx2 would look for files in the working directory, home and /etc.
pub(crate) fn config(prefix: &str, root: &str) -> Result<Config, OpenError> {
    let mut config = Config::default();
    config.global.prefix =
        FileName::new(prefix.as_bytes()).map_err(OpenError::at("use the prefix of", root))?;
    let path = Path::new(root.as_bytes()).map_err(OpenError::at("use the path", root))?;
    config.global.set_root_path(&path);
    config.global.creation_timeout = Duration::from_millis(500);
    config.global.node.cleanup_dead_nodes_on_creation = false;
    config.global.node.cleanup_dead_nodes_on_destruction = false;
    config.global.service.cleanup_dead_nodes_on_open = false;
    Ok(config)
}

#[cfg(test)]
mod tests;
