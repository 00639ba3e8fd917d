//! Cleaning up after dead clients, which the server itself never does.

use super::{has_dead, place};
use std::path::{Path, PathBuf};

/// Knows what to clean up after dead clients. Made by [`Server::housekeeper`](super::Server).
#[derive(Clone, Debug)]
pub struct Housekeeper {
    pub(super) root: PathBuf,
    pub(super) place: PathBuf,
}

impl Housekeeper {
    /// The place to [clean](super::clean) in a process of its own, if a client has died in it.
    ///
    /// Removes, at once, places of dead servers that nobody holds any more.
    #[must_use]
    pub fn needs_cleaning(&self) -> Option<&Path> {
        place::sweep(&self.root);
        has_dead(&self.place).then_some(&*self.place)
    }
}
