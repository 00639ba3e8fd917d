//! When a supervisor gives its service up, and what it does then: decisions without processes and
//! clocks. They are those of `tools/systemd/trolley.service`.

use diagnostic::FailureKind;
use runtime::Exit;
use std::collections::VecDeque;
use transport::service::Notice;

/// Exit codes after which another start would not help: usage, input, versions, rights, settings.
const FINAL: [i32; 5] = [
    2,
    FailureKind::Input as i32,
    FailureKind::Skew as i32,
    FailureKind::NoRealtime as i32,
    FailureKind::Configuration as i32,
];

/// How long a supervisor waits, and how often it tries.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limits {
    /// For a service to be ready (ns).
    pub(super) start_ns: u64,
    /// For the next sign of its answering thread (ns).
    pub(super) silence_ns: u64,
    /// Before it is started again (ns).
    pub(super) pause_ns: u64,
    /// Maximum number of starts within the next time.
    pub(super) starts_max: usize,
    /// That time (ns).
    pub(super) starts_in_ns: u64,
}

/// Longest start of a service (ns), as `TimeoutStartSec` of the unit.
const START_NS: u64 = 60_000_000_000;
/// Longest silence of a service (ns). The unit has 500 ms for a machine that does nothing else.
const SILENCE_NS: u64 = 2_000_000_000;
/// Pause before a start that follows another (ns), as `RestartSec`.
const PAUSE_NS: u64 = 100_000_000;
/// Starts within the following time (ns), as `StartLimitBurst` and `StartLimitIntervalSec`.
const STARTS_MAX: usize = 10;
const STARTS_IN_NS: u64 = 60_000_000_000;

impl Limits {
    pub(super) const USUAL: Self = Self {
        start_ns: START_NS,
        silence_ns: SILENCE_NS,
        pause_ns: PAUSE_NS,
        starts_max: STARTS_MAX,
        starts_in_ns: STARTS_IN_NS,
    };
}

/// How a service ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Ending {
    /// By itself, or by somebody else's hand.
    Ended(Exit),
    /// By its supervisor, because it was silent.
    Silent,
}

/// What to do after a service has ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Next {
    /// Start it again, not before this time (ns).
    Start {
        /// When.
        at_ns: u64,
    },
    /// End with its exit code.
    PassOn(u8),
    /// It was started too often.
    GiveUp,
}

/// What a supervisor knows of its service.
#[derive(Debug)]
pub(super) struct Watch {
    limits: Limits,
    /// When it was started (ns), at most `starts_max` times.
    starts: VecDeque<u64>,
    is_ready: bool,
    /// When the next sign of life is due (ns).
    due_ns: u64,
}

impl Watch {
    pub(super) fn new(limits: Limits) -> Self {
        Self { limits, starts: VecDeque::new(), is_ready: false, due_ns: 0 }
    }

    /// The service was started.
    pub(super) fn started(&mut self, now_ns: u64) {
        if self.starts.len() == self.limits.starts_max {
            self.starts.pop_front();
        }
        self.starts.push_back(now_ns);
        self.is_ready = false;
        self.due_ns = now_ns + self.limits.start_ns;
    }

    /// It said something.
    pub(super) fn heard(&mut self, notice: Notice, now_ns: u64) {
        match notice {
            Notice::Ready => self.is_ready = true,
            // Before it is ready, a ping shows no thread that answers.
            Notice::Alive if !self.is_ready => return,
            // It has as long to end as it has between two pings.
            Notice::Alive | Notice::Stopping => {}
            Notice::Other => return,
        }
        self.due_ns = now_ns + self.limits.silence_ns;
    }

    /// When it must have said something (ns).
    pub(super) fn due_ns(&self) -> u64 {
        self.due_ns
    }

    /// Whether it has been silent for too long.
    pub(super) fn is_overdue(&self, now_ns: u64) -> bool {
        now_ns >= self.due_ns
    }

    /// What is next, once it has ended.
    pub(super) fn after(&self, how: Ending, now_ns: u64) -> Next {
        match how {
            // Somebody told it to end, and it did so in order.
            Ending::Ended(Exit::Code(0)) => return Next::PassOn(0),
            Ending::Ended(Exit::Code(code)) if FINAL.contains(&code) => {
                return Next::PassOn(u8::try_from(code).unwrap_or(1));
            }
            Ending::Ended(_) | Ending::Silent => {}
        }
        let at_ns = now_ns + self.limits.pause_ns;
        match self.starts.front() {
            Some(first_ns)
                if self.starts.len() >= self.limits.starts_max
                    && at_ns - first_ns < self.limits.starts_in_ns =>
            {
                Next::GiveUp
            }
            _ => Next::Start { at_ns },
        }
    }
}

#[cfg(test)]
mod tests {
    //! A service is replaced when it must be, and not for ever.
    use super::*;
    use proptest::prelude::*;

    const S: u64 = 1_000_000_000;
    const KILLED: Ending = Ending::Ended(Exit::Signal(9));

    fn watch() -> Watch {
        Watch::new(Limits::USUAL)
    }

    #[test]
    fn a_service_has_a_minute_to_start_and_then_two_seconds_for_each_ping() {
        let mut watch = watch();
        watch.started(S);
        watch.heard(Notice::Alive, 2 * S);
        assert_eq!(watch.due_ns(), 61 * S, "a ping is no readiness");
        assert!(!watch.is_overdue(61 * S - 1) && watch.is_overdue(61 * S));
        watch.heard(Notice::Ready, 5 * S);
        assert_eq!(watch.due_ns(), 7 * S);
        watch.heard(Notice::Alive, 6 * S);
        assert_eq!(watch.due_ns(), 8 * S);
        watch.heard(Notice::Other, 7 * S);
        assert_eq!(watch.due_ns(), 8 * S);
        watch.started(100 * S);
        assert_eq!(watch.due_ns(), 160 * S, "each start has its minute");
    }

    #[test]
    fn faults_are_answered_by_a_start_and_refusals_passed_on() {
        let mut watch = watch();
        watch.started(0);
        let at_ns = S + PAUSE_NS;
        for code in [1, 3, 4, 69, 70, 71, 75, 101, 127, 134, 143] {
            let next = watch.after(Ending::Ended(Exit::Code(code)), S);
            assert_eq!(next, Next::Start { at_ns }, "{code}");
        }
        for how in [KILLED, Ending::Ended(Exit::Signal(6)), Ending::Silent] {
            assert_eq!(watch.after(how, S), Next::Start { at_ns });
        }
        for code in [0, 2, 65, 76, 77, 78] {
            let next = watch.after(Ending::Ended(Exit::Code(code)), S);
            assert_eq!(next, Next::PassOn(code as u8));
        }
    }

    #[test]
    fn the_limits_are_those_of_the_unit() {
        let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tools/systemd/trolley.service");
        let unit = std::fs::read_to_string(file).unwrap();
        let setting = |key: &str| {
            let line = unit.lines().find_map(|line| line.strip_prefix(key)?.strip_prefix('='));
            line.unwrap_or_else(|| panic!("no {key}")).to_owned()
        };
        let codes: Vec<String> = FINAL.iter().map(ToString::to_string).collect();
        assert_eq!(setting("RestartPreventExitStatus"), codes.join(" "));
        assert_eq!(setting("StartLimitBurst"), STARTS_MAX.to_string());
        assert_eq!(setting("StartLimitIntervalSec"), (STARTS_IN_NS / S).to_string());
        assert_eq!(setting("RestartSec"), format!("{}ms", PAUSE_NS / 1_000_000));
        assert_eq!(setting("TimeoutStartSec"), format!("{}s", START_NS / S));
    }

    proptest! {
        /// Whenever it ends: no eleventh start within a minute, and no refusal without ten.
        #[test]
        fn ten_starts_a_minute_and_no_more(lives in prop::collection::vec(0..20 * S, 1..60)) {
            let (mut watch, mut now_ns, mut starts) = (watch(), 0, Vec::new());
            for life_ns in lives {
                watch.started(now_ns);
                starts.push(now_ns);
                now_ns += life_ns;
                let due_ns = now_ns + PAUSE_NS;
                let recent = starts.iter().filter(|at_ns| due_ns - **at_ns < STARTS_IN_NS).count();
                match watch.after(KILLED, now_ns) {
                    Next::Start { at_ns } => {
                        prop_assert_eq!(at_ns, due_ns);
                        prop_assert!(recent < STARTS_MAX);
                        now_ns = at_ns;
                    }
                    next => {
                        prop_assert_eq!(next, Next::GiveUp);
                        prop_assert!(recent >= STARTS_MAX);
                        return Ok(());
                    }
                }
            }
        }
    }
}
