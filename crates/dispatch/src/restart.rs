//! How often a core gets a new worker: a crash loop must not use up the machine.
//!
//! The intensity of a supervisor (Armstrong, *Making reliable distributed systems in the presence
//! of software errors*, 2003): after too many deaths in a window, restarts stop. A core, or all of
//! them, gets a worker again once enough of its deaths lie outside the window.

use std::collections::VecDeque;

/// Maximum number of deaths in a time window.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Intensity {
    /// Deaths of one core.
    pub core_deaths: usize,
    /// Window for one core (ns).
    pub core_ns: u64,
    /// Deaths of all cores.
    pub all_deaths: usize,
    /// Window for all cores (ns).
    pub all_ns: u64,
}

impl Default for Intensity {
    /// 5 in 10 s of a core, 10 in 60 s of all.
    fn default() -> Self {
        Self { core_deaths: 5, core_ns: 10_000_000_000, all_deaths: 10, all_ns: 60_000_000_000 }
    }
}

impl Intensity {
    /// No limit: for tests that kill workers on purpose.
    pub const UNLIMITED: Self =
        Self { core_deaths: usize::MAX, core_ns: 0, all_deaths: usize::MAX, all_ns: 0 };
}

/// Whether a core may have a new worker.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Leave {
    /// It may.
    Granted,
    /// Its workers died too often.
    CoreOff,
    /// Workers of all cores together died too often.
    AllOff,
}

/// The deaths that still count.
#[derive(Clone, Debug)]
pub struct Restarts {
    intensity: Intensity,
    deaths: VecDeque<(u64, u8)>,
}

impl Restarts {
    /// Creates a record without deaths.
    #[must_use]
    pub fn new(intensity: Intensity) -> Self {
        Self { intensity, deaths: VecDeque::new() }
    }

    /// Records the death of a worker of this core.
    pub fn note(&mut self, core: u8, now_ns: u64) {
        let longest = self.intensity.core_ns.max(self.intensity.all_ns);
        while self.deaths.front().is_some_and(|(at, _)| now_ns.saturating_sub(*at) >= longest) {
            self.deaths.pop_front();
        }
        self.deaths.push_back((now_ns, core));
    }

    /// Whether this core may have a new worker now.
    #[must_use]
    pub fn leave(&self, core: u8, now_ns: u64) -> Leave {
        let Intensity { core_deaths, core_ns, all_deaths, all_ns } = self.intensity;
        let within = |ns: u64| {
            let recent = move |at: u64| now_ns.saturating_sub(at) < ns;
            self.deaths.iter().filter(move |(at, _)| recent(*at))
        };
        if within(all_ns).count() >= all_deaths {
            Leave::AllOff
        } else if within(core_ns).filter(|(_, of)| *of == core).count() >= core_deaths {
            Leave::CoreOff
        } else {
            Leave::Granted
        }
    }
}

#[cfg(test)]
mod tests {
    //! A crash loop is stopped, a rare crash is not, and deaths expire.
    use super::*;

    const S: u64 = 1_000_000_000;

    #[test]
    fn a_core_that_dies_often_rests_and_the_others_do_not() {
        let mut restarts = Restarts::new(Intensity::default());
        for death in 0..5 {
            assert_eq!(restarts.leave(2, death * S), Leave::Granted);
            restarts.note(2, death * S);
        }
        assert_eq!(restarts.leave(2, 5 * S), Leave::CoreOff);
        assert_eq!(restarts.leave(1, 5 * S), Leave::Granted);
        assert_eq!(restarts.leave(2, 10 * S), Leave::Granted, "the first is 10 s ago");
    }

    #[test]
    fn when_all_die_nobody_is_restarted() {
        let mut restarts = Restarts::new(Intensity::default());
        for death in 0..10 {
            restarts.note((death % 4) as u8, death * S);
        }
        assert_eq!(restarts.leave(3, 10 * S), Leave::AllOff);
        assert_eq!(restarts.leave(3, 60 * S), Leave::Granted);
    }

    #[test]
    fn without_limit_there_is_none() {
        let mut restarts = Restarts::new(Intensity::UNLIMITED);
        for death in 0..1000 {
            restarts.note(0, death);
            assert_eq!(restarts.leave(0, death), Leave::Granted);
        }
        assert!(restarts.deaths.len() <= 1, "what does not count is not kept");
    }
}
