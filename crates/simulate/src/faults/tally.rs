//! What was counted in one world or in many.

use super::kind::SimulatedFault;

/// What was counted.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Tally {
    /// Requests.
    pub requests: u64,
    /// Requests in which a fault struck.
    pub disturbed: u64,
    /// Jobs.
    pub jobs: u64,
    /// Complete answers.
    pub complete: u64,
    /// Degraded answers.
    pub degraded: u64,
    /// Refusals.
    pub refused: u64,
    /// Faults that struck, in the order of [`SimulatedFault::ALL`].
    pub struck: Vec<u64>,
    /// Leases that ended without a result.
    pub reissued: u64,
    /// Jobs given up because they took workers down or failed.
    pub abandoned: u64,
    /// Parts rejected by the fence.
    pub fenced: u64,
    /// Workers that died of any cause.
    pub deaths: u64,
    /// Workers that were killed by the coordinator.
    pub killed: u64,
}

impl Default for Tally {
    fn default() -> Self {
        Self {
            requests: 0,
            disturbed: 0,
            jobs: 0,
            complete: 0,
            degraded: 0,
            refused: 0,
            struck: vec![0; SimulatedFault::ALL.len()],
            reissued: 0,
            abandoned: 0,
            fenced: 0,
            deaths: 0,
            killed: 0,
        }
    }
}

impl Tally {
    /// All faults that struck.
    #[must_use]
    pub fn faults(&self) -> u64 {
        self.struck.iter().sum()
    }

    /// Includes another one.
    pub fn add(&mut self, other: &Self) {
        let pairs = [
            (&mut self.requests, other.requests),
            (&mut self.disturbed, other.disturbed),
            (&mut self.jobs, other.jobs),
            (&mut self.complete, other.complete),
            (&mut self.degraded, other.degraded),
            (&mut self.refused, other.refused),
            (&mut self.reissued, other.reissued),
            (&mut self.abandoned, other.abandoned),
            (&mut self.fenced, other.fenced),
            (&mut self.deaths, other.deaths),
            (&mut self.killed, other.killed),
        ];
        for (sum, more) in pairs {
            *sum += more;
        }
        for (sum, more) in self.struck.iter_mut().zip(&other.struck) {
            *sum += more;
        }
    }
}
