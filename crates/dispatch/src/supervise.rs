//! Silence: distinguishing a hung worker from one that merely waits for its core.
//!
//! Wall time is unreliable on a busy machine: healthy workers that share cores stand still for 20
//! to 50 ms. So a beat that does not move is compared with the process's own CPU time and run
//! state, and only as a last resort with wall time.

/// The observed state of a worker at one moment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pulse {
    /// Its beat.
    pub beat: u64,
    /// CPU time that the process has used (ns).
    pub cpu_ns: u64,
    /// Whether the system reports it as stopped (state T).
    pub stopped: bool,
    /// Whether it holds jobs.
    pub busy: bool,
}

/// How long a busy worker may stand still.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Patience {
    /// Stopped by a signal (ns).
    pub stopped_ns: u64,
    /// Running, by its own CPU time (ns).
    pub hung_cpu_ns: u64,
    /// By wall time, whatever else is observed (ns).
    pub silent_ns: u64,
}

impl Default for Patience {
    /// 100 ms stopped, 500 ms of own CPU time, 2 s of wall time (the longest gap of a healthy
    /// worker observed on a machine with twice as many busy workers as cores was 0.2 s).
    fn default() -> Self {
        Self { stopped_ns: 100_000_000, hung_cpu_ns: 500_000_000, silent_ns: 2_000_000_000 }
    }
}

/// The conclusion from a pulse.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Liveness {
    /// It works, has nothing to do, or waits for its core.
    Alive,
    /// It was stopped and has jobs: kill it.
    Stopped,
    /// It uses CPU time without progress: kill it.
    Hung,
    /// It has not moved for too long: kill it.
    Silent,
}

impl Liveness {
    /// The name used in records and reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Alive => "alive",
            Self::Stopped => "stopped",
            Self::Hung => "hung",
            Self::Silent => "silent",
        }
    }
}

/// The state of one watched worker.
#[derive(Clone, Copy, Debug, Default)]
pub struct Watch {
    seen: Option<(Pulse, u64)>,
}

impl Watch {
    /// Evaluates a pulse at `now` [ns, monotonic].
    pub fn look(&mut self, pulse: Pulse, now: u64, patience: &Patience) -> Liveness {
        let Some((last, since)) = self.seen else {
            self.seen = Some((pulse, now));
            return Liveness::Alive;
        };
        if !pulse.busy || !last.busy || pulse.beat != last.beat {
            self.seen = Some((pulse, now));
            return Liveness::Alive;
        }
        let still = now.saturating_sub(since);
        if pulse.stopped && still >= patience.stopped_ns {
            Liveness::Stopped
        } else if pulse.cpu_ns.saturating_sub(last.cpu_ns) >= patience.hung_cpu_ns {
            Liveness::Hung
        } else if still >= patience.silent_ns {
            Liveness::Silent
        } else {
            Liveness::Alive
        }
    }
}

#[cfg(test)]
mod tests;
