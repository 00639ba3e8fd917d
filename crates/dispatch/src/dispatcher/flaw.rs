//! Deliberate flaws, for the tests that must detect them. Behind the feature `faults`: no build for
//! a vehicle has them.

use super::{Closed, Dispatcher, JobSource, State};
use crate::scheme::MatchScheme;
use protocol::{Incarnation, JobId};

/// A flaw that a dispatcher could have.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum DispatcherFlaw {
    /// Accepts a result from any worker, for any attempt.
    NoFence,
    /// Counts the jobs of a dead worker as done, as if they had found nothing.
    SilenceIsHarmless,
    /// Does not reassign the jobs of a dead worker.
    LeaseForgotten,
}

impl DispatcherFlaw {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::NoFence, Self::SilenceIsHarmless, Self::LeaseForgotten];
}

impl<S: MatchScheme> Dispatcher<S> {
    /// Enables this flaw.
    pub fn corrupt(&mut self, flaw: Option<DispatcherFlaw>) {
        self.flaw = flaw;
    }

    pub(super) fn take_unfenced<W: JobSource>(
        &mut self,
        job: JobId,
        last: bool,
        body: W::Part<'_>,
        work: &mut W,
    ) -> bool {
        if self.flaw != Some(DispatcherFlaw::NoFence) {
            return false;
        }
        let Some(slot) = self.slots.get(job.0 as usize).copied() else { return true };
        work.fold(&slot.spec, body);
        match (last, slot.state) {
            (true, State::Closed) => work.close(&slot.spec, Closed::Done),
            (true, _) => {
                self.unlease(job);
                self.pending.retain(|pending| *pending != job);
                self.suspects.retain(|suspect| *suspect != job);
                self.close(job, Closed::Done, work);
            }
            (false, _) => {}
        }
        true
    }

    pub(super) fn reap_badly<W: JobSource>(&mut self, who: Incarnation, work: &mut W) -> bool {
        match self.flaw {
            Some(DispatcherFlaw::LeaseForgotten) => true,
            Some(DispatcherFlaw::SilenceIsHarmless) => {
                for number in 0..self.slots.len() {
                    if self.slots[number].state == State::Leased(who) {
                        let job = JobId(u32::try_from(number).unwrap_or(u32::MAX));
                        self.close(job, Closed::Done, work);
                    }
                }
                true
            }
            Some(DispatcherFlaw::NoFence) | None => false,
        }
    }
}
