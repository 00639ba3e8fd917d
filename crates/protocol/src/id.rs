//! Distinct types for the ids of processes, requests and work.

macro_rules! id {
    ($(#[$doc:meta])* $name:ident($inner:ty)) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub struct $name(pub $inner);
    };
}

id! {
    /// One start of one coordinator: random, so that messages of an earlier run are recognised.
    Boot(u64)
}
id! {
    /// A request, counted up from 1 within a boot.
    RequestId(u64)
}
id! {
    /// A job: its slot in the request's job table.
    JobId(u32)
}
id! {
    /// A task: one question about one pose of one pair of bodies, within a request.
    TaskId(u32)
}

/// One life of one worker: which core it serves, and how often it was started there.
///
/// The last messages of a dead worker carry the old number, so they are not mistaken for its
/// successor's.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Incarnation {
    /// Worker number, below [`crate::WORKERS_MAX`].
    pub worker: u8,
    /// 0 for the first process of this worker, +1 per replacement.
    pub inc: u32,
}

/// A section: the subtree of a body below one node. The unit of match schemes and of the transfer
/// ledger.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Section {
    /// Number of the body in the model store.
    pub model: u32,
    /// Node of its tree.
    pub node: u32,
}
