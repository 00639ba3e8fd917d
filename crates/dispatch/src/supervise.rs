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

/// The observed state of a process that was started and has not greeted yet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StartPulse {
    /// CPU time that the process has used (ns).
    pub cpu_ns: u64,
    /// Whether the system reports it as stopped (state T or t).
    pub stopped: bool,
    /// Whether it runs, waits for its core, or waits for a disk (state R or D).
    pub runnable: bool,
}

/// How long a start may take.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StartPatience {
    /// Stopped by a signal (ns).
    pub stopped_ns: u64,
    /// Without visible progress: neither CPU time, nor waiting for a core or a disk (ns).
    pub still_ns: u64,
    /// In all, whatever else is observed (ns).
    pub longest_ns: u64,
}

impl Default for StartPatience {
    /// 100 ms stopped, 800 ms without progress: two such starts are over within 2 s. A loaded
    /// machine may take 20 s.
    fn default() -> Self {
        Self { stopped_ns: 100_000_000, still_ns: 800_000_000, longest_ns: 20_000_000_000 }
    }
}

/// The state of one start.
#[derive(Clone, Copy, Debug)]
pub struct StartWatch {
    begun_ns: u64,
    /// When it last made progress (ns), and its CPU time then.
    moved_ns: u64,
    cpu_ns: u64,
    /// Since when it is stopped (ns).
    stopped_ns: Option<u64>,
}

impl StartWatch {
    /// A start at `now` [ns, monotonic].
    #[must_use]
    pub fn new(now: u64) -> Self {
        Self { begun_ns: now, moved_ns: now, cpu_ns: 0, stopped_ns: None }
    }

    /// Evaluates a pulse at `now` [ns, monotonic].
    pub fn look(&mut self, pulse: StartPulse, now: u64, patience: &StartPatience) -> Liveness {
        if pulse.runnable || pulse.cpu_ns > self.cpu_ns {
            (self.moved_ns, self.cpu_ns) = (now, pulse.cpu_ns);
        }
        self.stopped_ns = pulse.stopped.then(|| self.stopped_ns.unwrap_or(now));
        let is_over = |since: u64, most: u64| now.saturating_sub(since) >= most;
        if self.stopped_ns.is_some_and(|since| is_over(since, patience.stopped_ns)) {
            Liveness::Stopped
        } else if is_over(self.begun_ns, patience.longest_ns) {
            Liveness::Hung
        } else if is_over(self.moved_ns, patience.still_ns) {
            Liveness::Silent
        } else {
            Liveness::Alive
        }
    }
}

#[cfg(test)]
mod tests;
