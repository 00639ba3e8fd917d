//! The counts of a request, and why parts were rejected.

/// Rejected parts, by reason.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Fence {
    /// It belongs to another request.
    pub stale: u64,
    /// The job is closed, or leased to another worker or attempt.
    pub not_leased: u64,
    /// The part was received before.
    pub repeated: u64,
    /// A part before it is missing.
    pub gap: u64,
}

impl Fence {
    /// The total.
    #[must_use]
    pub fn sum(&self) -> u64 {
        let Self { stale, not_leased, repeated, gap } = self;
        stale + not_leased + repeated + gap
    }
}

/// The counts of a request.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Jobs in total.
    pub jobs: u64,
    /// Jobs done.
    pub done: u64,
    /// Jobs cut because they could not matter.
    pub cut: u64,
    /// Jobs abandoned.
    pub abandoned: u64,
    /// Jobs that were open when the time was up.
    pub late: u64,
    /// Leases that ended without a result.
    pub reissued: u64,
    /// Batches sent.
    pub batches: u64,
    /// Parts rejected.
    pub fence: Fence,
}
