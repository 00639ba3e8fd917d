//! On what terms a request is worked on: how far, by when, in which order, in how large pieces.

use crate::strategy::Pursuit;

/// When to stop.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Until {
    /// When all work is done.
    #[default]
    Complete,
    /// When no open work can change the order.
    Ordered,
    /// When no open work can change the winner.
    Certified,
}

/// The terms. None changes a complete answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Terms {
    /// How much must be certain.
    pub until: Until,
    /// When the answer is due whatever is known by then: so long after the request was accepted
    /// (ns); `None`: never.
    pub deadline_ns: Option<u64>,
    /// Whose job goes out next.
    pub pursuit: Pursuit,
    /// Most tests of boxes and triangles that one job may take.
    pub budget: u64,
    /// Whether every descent begins at the roots, and not where the last one ended.
    pub is_cold: bool,
}

impl Default for Terms {
    fn default() -> Self {
        Self {
            until: Until::default(),
            deadline_ns: None,
            pursuit: Pursuit::default(),
            budget: u64::MAX,
            is_cold: false,
        }
    }
}
