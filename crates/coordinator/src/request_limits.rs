//! The limits of a request: how far it is worked on, by when, in which order, in pieces of what
//! size.

use crate::strategy::SearchOrder;
use core::time::Duration;
use record::RecordedUntil;

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

impl Until {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Complete, Self::Ordered, Self::Certified];

    /// The name on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Complete => "complete",
            Self::Ordered => "ordered",
            Self::Certified => "certified",
        }
    }
}

impl From<Until> for RecordedUntil {
    fn from(until: Until) -> Self {
        match until {
            Until::Complete => Self::Complete,
            Until::Ordered => Self::Ordered,
            Until::Certified => Self::Certified,
        }
    }
}

impl From<RecordedUntil> for Until {
    fn from(until: RecordedUntil) -> Self {
        match until {
            RecordedUntil::Complete => Self::Complete,
            RecordedUntil::Ordered => Self::Ordered,
            RecordedUntil::Certified => Self::Certified,
        }
    }
}

/// The limits. None changes a complete answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RequestLimits {
    /// What must be certain before work stops.
    pub until: Until,
    /// Time after acceptance at which the answer is due, whatever is known by then (ns); `None`:
    /// never.
    pub deadline_ns: Option<u64>,
    /// Which candidate's job goes out next.
    pub search_order: SearchOrder,
    /// Maximum number of box and triangle tests per job.
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
    /// Default budget of a job where there is a deadline: a millisecond or two.
    pub const BUDGET: u64 = 1 << 18;
    /// Time reserved before the deadline for putting the answer together.
    pub const GUARD: Duration = Duration::from_millis(3);

    /// How long work may last (ns) so that its answer is in time.
    #[must_use]
    pub fn guarded(deadline: Duration) -> u64 {
        let work = deadline - Self::GUARD.min(deadline / 10);
        u64::try_from(work.as_nanos()).unwrap_or(u64::MAX)
    }

    /// The default limits of an answer with this deadline.
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
