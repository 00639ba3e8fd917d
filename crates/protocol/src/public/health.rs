//! The state of the service: published each second, and when its condition changes.

use crate::WORKERS_MAX;
use bytemuck::{Pod, Zeroable};

/// The condition of the service.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u32)]
pub enum Condition {
    /// It answers, with all of its workers.
    Ready = 1,
    /// It answers, with fewer workers than it should have.
    Short = 2,
    /// It is stopping: no more answers.
    Stopping = 3,
}

impl Condition {
    /// The condition with this number.
    #[must_use]
    pub fn from_number(number: u32) -> Option<Self> {
        [Self::Ready, Self::Short, Self::Stopping].into_iter().find(|c| *c as u32 == number)
    }

    /// The name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Ready => "ready",
            Self::Short => "short of workers",
            Self::Stopping => "stopping",
        }
    }
}

/// The stage that a latency measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[repr(usize)]
pub enum LatencyStage {
    /// From receipt of a request until work began.
    Queue = 0,
    /// Validating it, and following every candidate from contact to contact.
    Plan = 1,
    /// The surveys of contacts: descending, intersecting, folding.
    Work = 2,
    /// What is said besides, harm, ranking, writing the answer.
    Assess = 3,
    /// From receipt until its answer was handed over.
    Total = 4,
}

impl LatencyStage {
    /// All of them, in order.
    pub const ALL: [Self; 5] = [Self::Queue, Self::Plan, Self::Work, Self::Assess, Self::Total];

    /// The name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Queue => "queue",
            Self::Plan => "plan",
            Self::Work => "work",
            Self::Assess => "assess",
            Self::Total => "total",
        }
    }
}

/// The state of the service.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Health {
    /// [`super::VERSION`].
    pub version: u32,
    /// A [`Condition`].
    pub condition: u32,
    /// Process id of the service.
    pub pid: u32,
    /// Worker processes that it should have.
    pub workers: u32,
    /// Worker processes that it has.
    pub alive: u32,
    /// Requests that wait.
    pub waiting: u32,
    /// Requests that may wait.
    pub queue: u32,
    /// Clients that are connected.
    pub clients: u32,
    /// When this was written, on CLOCK_MONOTONIC (ns).
    pub at_ns: u64,
    /// When it started answering, on CLOCK_MONOTONIC (ns).
    pub since_ns: u64,
    /// Answers since then, in the order of [`super::WireState::ALL`].
    pub answers: [u64; 5],
    /// Requests whose client had disconnected or given up: not processed.
    pub withdrawn: u64,
    /// Workers lost since then.
    pub lost: u64,
    /// Page faults during requests, in the service's process, since the hundredth request.
    pub faults: u64,
    /// Heap allocations of the last request, in the service's process; `u64::MAX`: not counted.
    pub allocations: u64,
    /// Messages to and from workers since then.
    pub messages: u64,
    /// Bytes of these.
    pub message_bytes: u64,
    /// p50, p99, p99.9 and greatest of each [`LatencyStage`] (ns).
    pub latency_ns: [[u64; 4]; 5],
    /// The workers.
    pub each: [WorkerHealth; WORKERS_MAX],
    /// The bodies that requests may name.
    pub model_set: super::ModelSet,
}

/// The state of a worker.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct WorkerHealth {
    /// Its process id; 0: there is no such worker.
    pub pid: u32,
    /// The core it is pinned to, plus one; 0: none.
    pub core: u32,
    /// Jobs since the service started.
    pub jobs: u64,
    /// Time that these took (ns).
    pub busy_ns: u64,
    /// How often it was replaced.
    pub replaced: u64,
}

const _: () = {
    use core::mem::offset_of;
    assert!(size_of::<WorkerHealth>() == 32);
    assert!(offset_of!(Health, at_ns) == 32);
    assert!(offset_of!(Health, answers) == 48);
    assert!(offset_of!(Health, latency_ns) == 136);
    assert!(offset_of!(Health, each) == 296);
    assert!(offset_of!(Health, model_set) == 808);
    assert!(size_of::<Health>() == 840 && align_of::<Health>() == 8);
};
