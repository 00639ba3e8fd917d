//! What was counted in a request, and why parts were turned away.

/// Why a part was not taken.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Fence {
    /// It belongs to another request.
    pub stale: u64,
    /// The job is closed, or leased to somebody else, or in another attempt.
    pub not_leased: u64,
    /// A part came twice.
    pub repeated: u64,
    /// A part before it is missing.
    pub gap: u64,
}

impl Fence {
    /// All of them.
    #[must_use]
    pub fn sum(&self) -> u64 {
        let Self { stale, not_leased, repeated, gap } = self;
        stale + not_leased + repeated + gap
    }
}

/// What was counted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Jobs there were.
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
    /// Parts turned away.
    pub fence: Fence,
}
