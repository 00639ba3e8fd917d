//! Finds the first contact on a path: a state machine of questions and answers.
//!
//! It asks whether the bodies touch at a travel: first on the whole grid, then by halving between
//! the last pose without contact and the first with it, down to 1 mm, so that a triangle that
//! grazes a grid pose moves nothing. The outcome is a function of the answers alone: it depends
//! neither on their order nor on their number, and asking less (see [`Search::is_needed`]) changes
//! nothing.
//!
//! It does not know triangles, and it does not look between two poses that both do not touch: the
//! step of the grid is half the smaller body, so nothing passes through unseen.

use crate::path::{POSES_MAX, Path, Travels};
use smallvec::{SmallVec, smallvec};

/// First contact is known to this travel (m).
pub const FIRST_CONTACT_M: f64 = 0.001;

/// Maximum number of answers that a search asks for: the grid's, and 14 halvings.
const KNOWN: usize = POSES_MAX + 2 + 14;

/// The first contact on a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum First {
    /// No pose touches: the bodies pass each other.
    None,
    /// The first pose with a hit (m); 1 mm before it there was none, unless it is where hulls meet.
    At(f64),
}

/// The search for first contact along one path.
#[derive(Clone, Debug, PartialEq)]
pub struct Search {
    /// The grid, ascending.
    grid: Travels,
    /// What is known, ascending by travel, no travel twice.
    known: SmallVec<[(f64, bool); KNOWN]>,
}

/// What is settled so far.
enum Stage {
    /// Grid poses `0..below` may still turn out to be first.
    Grid { below: usize },
    /// Contact begins after the first and not after the second.
    Between(f64, f64),
    /// Settled.
    Done(First),
}

impl Search {
    /// Nothing known yet.
    #[must_use]
    pub fn new(path: &Path) -> Self {
        Self { grid: path.travels.clone(), known: SmallVec::new() }
    }

    /// The travels at which to ask now whether the bodies touch, ascending; empty when settled.
    #[must_use]
    pub fn wanted(&self) -> Travels {
        match self.stage() {
            Stage::Grid { below } => {
                self.grid[..below].iter().copied().filter(|s| self.touches(*s).is_none()).collect()
            }
            Stage::Between(apart, touching) => smallvec![0.5 * (apart + touching)],
            Stage::Done(_) => Travels::new(),
        }
    }

    /// Whether the answer at this travel can still change the outcome. Work that was begun for a
    /// later grid pose may be dropped once an earlier one touches.
    #[must_use]
    pub fn is_needed(&self, travel_m: f64) -> bool {
        self.wanted().iter().any(|s| s.to_bits() == travel_m.to_bits())
    }

    /// Takes an answer, in any order and any number of times. One hit at a travel is enough: it
    /// overrides answers without one.
    pub fn learn(&mut self, travel_m: f64, touches: bool) {
        match self.known.binary_search_by(|(s, _)| s.total_cmp(&travel_m)) {
            Ok(at) => self.known[at].1 |= touches,
            Err(at) => self.known.insert(at, (travel_m, touches)),
        }
    }

    /// The first contact, once it is settled.
    #[must_use]
    pub fn outcome(&self) -> Option<First> {
        match self.stage() {
            Stage::Done(first) => Some(first),
            Stage::Grid { .. } | Stage::Between(..) => None,
        }
    }

    /// Whether some pose is known to touch, wherever the first one will be.
    #[must_use]
    pub fn has_touched(&self) -> bool {
        self.grid.iter().any(|s| self.touches(*s) == Some(true))
    }

    /// Between which travels the first contact lies, if there is one (m).
    #[must_use]
    pub fn bracket(&self) -> (f64, f64) {
        let first = self.grid.first().copied().unwrap_or(0.0);
        let last = self.grid.last().copied().unwrap_or(0.0);
        match self.stage() {
            Stage::Grid { below } => {
                let unknown = self.grid[..below].iter().position(|s| self.touches(*s).is_none());
                // Before the first unanswered pose nothing touches on the grid, so contact begins
                // after the pose before it.
                let from = unknown.map_or(last, |k| self.grid[k.saturating_sub(1)]);
                (from, self.grid.get(below).copied().unwrap_or(last))
            }
            Stage::Between(apart, touching) => (apart, touching),
            Stage::Done(First::At(at)) => (at, at),
            Stage::Done(First::None) => (first, last),
        }
    }

    fn touches(&self, travel_m: f64) -> Option<bool> {
        let at = self.known.binary_search_by(|(s, _)| s.total_cmp(&travel_m)).ok()?;
        Some(self.known[at].1)
    }

    fn stage(&self) -> Stage {
        let below = self
            .grid
            .iter()
            .position(|s| self.touches(*s) == Some(true))
            .unwrap_or(self.grid.len());
        if self.grid[..below].iter().any(|s| self.touches(*s).is_none()) {
            return Stage::Grid { below };
        }
        let Some(&hit) = self.grid.get(below) else { return Stage::Done(First::None) };
        let Some(before) = below.checked_sub(1) else { return Stage::Done(First::At(hit)) };
        let (mut apart, mut touching) = (self.grid[before], hit);
        // Steps are at most 10 m long, so 14 halvings reach 1 mm.
        while touching - apart > FIRST_CONTACT_M {
            let mid = 0.5 * (apart + touching);
            match self.touches(mid) {
                Some(true) => touching = mid,
                Some(false) => apart = mid,
                None => return Stage::Between(apart, touching),
            }
        }
        Stage::Done(First::At(touching))
    }
}

#[cfg(test)]
mod tests;
