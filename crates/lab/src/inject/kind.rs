//! The kinds of faults that can be injected, by the names of plans and reports.
//!
//! | what they strike | kinds |
//! |---|---|
//! | workers of a pool, by signals | `kill` to `slow`; `kill-at-call`: at a call of their start |
//! | workers of a pool, by orders | `abort` to `loan-exhausted` |
//! | messages and the status page | `garble-batch` to `flip-status` |
//! | whole runs | `flip-payload`, `flip-queue`, `coordinator-kill` to `stale-memory` |
//! | a service and its clients | `flip-management`, `flip-public`, `full-shm`, `strangers-files` |
//!
//! `full-shm`, `small-shm` and `clock-shift` need namespaces, the kinds at a system call need
//! ptrace(2), and `strangers-files` the rights of root: what this machine does not permit is
//! reported as not injected.

use protocol::InjectedFault;

macro_rules! kinds {
    ($($name:ident = $text:literal,)*) => {
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
        pub(crate) enum Kind { $($name,)* }

        impl Kind {
            pub(crate) const ALL: &[Self] = &[$(Self::$name),*];

            pub(crate) fn name(self) -> &'static str {
                match self { $(Self::$name => $text,)* }
            }
        }
    };
}

kinds! {
    Kill = "kill",
    KillIdle = "kill-idle",
    KillAtStart = "kill-at-start",
    KillAtCall = "kill-at-call",
    KillAll = "kill-all",
    StopBeforeExec = "stop-before-exec",
    Stop = "stop",
    StopContinue = "stop-continue",
    Slow = "slow",
    Abort = "abort",
    Segfault = "segfault",
    StackOverflow = "stack-overflow",
    OutOfMemory = "out-of-memory",
    Quit = "quit",
    Panic = "panic",
    Hang = "hang",
    Stall = "stall",
    Poison = "poison",
    GarbleResult = "garble-result",
    WrongLength = "wrong-length",
    Masquerade = "masquerade",
    RepeatResult = "repeat-result",
    LoseResult = "lose-result",
    LoanExhausted = "loan-exhausted",
    GarbleBatch = "garble-batch",
    QueueFull = "queue-full",
    FlipStatus = "flip-status",
    FlipPayload = "flip-payload",
    FlipQueue = "flip-queue",
    FlipManagement = "flip-management",
    FlipPublic = "flip-public",
    CoordinatorKill = "coordinator-kill",
    CoordinatorKillAtCall = "coordinator-kill-at-call",
    KillInStop = "kill-in-stop",
    VersionSkew = "version-skew",
    SmallShm = "small-shm",
    FullShm = "full-shm",
    StrangersFiles = "strangers-files",
    FewFiles = "few-files",
    ClockShift = "clock-shift",
    StaleMemory = "stale-memory",
}

impl Kind {
    pub(crate) fn from_name(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|kind| kind.name() == name)
    }

    /// All names, for messages.
    pub(super) fn names() -> String {
        Self::ALL.iter().map(|kind| kind.name()).collect::<Vec<_>>().join(", ")
    }

    /// Whether it affects all workers at once.
    pub(super) fn takes_all(self) -> bool {
        matches!(self, Self::KillAll | Self::Poison)
    }

    /// Whether it takes a whole run, not one of many requests to one worker pool.
    pub(crate) fn is_whole_run(self) -> bool {
        matches!(
            self,
            Self::FlipPayload
                | Self::FlipQueue
                | Self::FlipManagement
                | Self::FlipPublic
                | Self::CoordinatorKill
                | Self::CoordinatorKillAtCall
                | Self::KillInStop
                | Self::VersionSkew
                | Self::SmallShm
                | Self::FullShm
                | Self::StrangersFiles
                | Self::FewFiles
                | Self::ClockShift
                | Self::StaleMemory
        )
    }

    /// Whether it strikes a service and its clients.
    pub(crate) fn is_of_service(self) -> bool {
        let of_service =
            [Self::FlipManagement, Self::FlipPublic, Self::FullShm, Self::StrangersFiles];
        of_service.contains(&self)
    }

    /// Whether it needs ptrace(2).
    pub(crate) fn traces(self) -> bool {
        matches!(self, Self::KillAtCall | Self::CoordinatorKillAtCall)
    }

    /// The order that makes a worker fail this way.
    pub(crate) fn commanded(self) -> Option<InjectedFault> {
        Some(match self {
            Self::Abort => InjectedFault::Abort,
            Self::Segfault => InjectedFault::Segfault,
            Self::StackOverflow => InjectedFault::Overflow,
            Self::OutOfMemory => InjectedFault::Exhaust,
            Self::Quit => InjectedFault::Quit,
            Self::Panic => InjectedFault::Panic,
            Self::Hang => InjectedFault::Hang,
            Self::Stall => InjectedFault::Stall,
            Self::Poison => InjectedFault::Poison,
            Self::GarbleResult => InjectedFault::Garble,
            Self::WrongLength => InjectedFault::Lie,
            Self::Masquerade => InjectedFault::Masquerade,
            Self::RepeatResult => InjectedFault::Repeat,
            Self::LoseResult => InjectedFault::Withhold,
            Self::LoanExhausted => InjectedFault::HoldLoan,
            _ => return None,
        })
    }

    /// Whether its worker may survive, or not be affected at all.
    pub(crate) fn may_be_survived(self) -> bool {
        matches!(
            self,
            Self::StopContinue
                | Self::Slow
                | Self::Panic
                | Self::GarbleResult
                | Self::WrongLength
                | Self::RepeatResult
                | Self::LoseResult
                | Self::GarbleBatch
                | Self::QueueFull
                | Self::FlipStatus
        )
    }
}
