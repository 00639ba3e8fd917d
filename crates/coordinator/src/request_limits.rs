//! On what limits a request is worked on: how far, by when, in which order, in how large pieces.

use crate::strategy::SearchOrder;
use core::time::Duration;

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

/// The limits. None changes a complete answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RequestLimits {
    /// How much must be certain.
    pub until: Until,
    /// When the answer is due whatever is known by then: so long after the request was accepted
    /// (ns); `None`: never.
    pub deadline_ns: Option<u64>,
    /// Whose job goes out next.
    pub search_order: SearchOrder,
    /// Most tests of boxes and triangles that one job may take.
    pub budget: u64,
}

impl Default for RequestLimits {
    fn default() -> Self {
        Self {
            until: Until::default(),
            deadline_ns: None,
            search_order: SearchOrder::default(),
            budget: u64::MAX,
        }
    }
}

impl RequestLimits {
    /// Most tests of a job where there is a deadline and nothing else was said: a millisecond or
    /// two.
    pub const BUDGET: u64 = 1 << 18;
    /// The answer is put together for so long at most before its deadline.
    pub const GUARD: Duration = Duration::from_millis(3);

    /// How long work may last (ns) so that an answer made of it is in time.
    #[must_use]
    pub fn guarded(deadline: Duration) -> u64 {
        let work = deadline - Self::GUARD.min(deadline / 10);
        u64::try_from(work.as_nanos()).unwrap_or(u64::MAX)
    }

    /// The limits within which an answer that is due after so long is usually made.
    #[must_use]
    pub fn due_in(deadline: Duration) -> Self {
        Self {
            deadline_ns: Some(Self::guarded(deadline)),
            search_order: SearchOrder::Deciding,
            budget: Self::BUDGET,
            ..Self::default()
        }
    }
}
