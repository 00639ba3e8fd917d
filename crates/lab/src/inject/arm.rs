//! How each fault is prepared, before the request in which it strikes.

use super::calls::Trace;
use super::kind::Kind;
use super::live_pool::Live;
use super::report::Report;
use super::signals::{self, Deed, Shot};
use coordinator::Corruption;
use core::sync::atomic::{AtomicBool, Ordering};
use geometry::rng::Rng;
use protocol::{FaultCommand, Incarnation, InjectedFault};
use runtime::clock;
use runtime::process::{Held, Traced, trace};
use trolley::Failure;

/// What happens while a request runs.
#[derive(Default)]
pub(super) struct Planned {
    pub(super) shots: Vec<Shot>,
    pub(super) traces: Vec<Trace>,
}

impl Live<'_> {
    /// Prepares a fault.
    pub(super) fn arm(
        &mut self,
        kind: Kind,
        who: Incarnation,
        pid: u32,
        planned: &mut Planned,
        report: &mut Report,
    ) -> Result<(), Failure> {
        let number = self.open.len() - 1;
        let within_ns = self.rng.below(self.usual_ns);
        let mut shoot = |after_ns: u64, deed: Deed| {
            // A worker that has ended by itself cannot be signalled.
            if let Ok(at) = Held::of(pid) {
                planned.shots.push(Shot { number, at, after_ns, deed });
            }
        };
        match kind {
            Kind::Kill | Kind::KillAll => shoot(within_ns, Deed::Kill),
            Kind::KillIdle => {
                if let Ok(held) = Held::of(pid) {
                    self.open[number].struck_ns = Some(clock::now_ns());
                    signals::end(held)?;
                }
            }
            Kind::KillAtStart => {
                // Its replacement is killed before it greets, or shortly after.
                let after_ns = self.rng.below(20_000_000);
                if let Some((next, pid)) = self.successor(who, pid, 0, report)? {
                    self.open[number].who = next;
                    if let Ok(at) = Held::of(pid) {
                        planned.shots.push(Shot { number, at, after_ns, deed: Deed::Kill });
                    }
                }
            }
            Kind::StopBeforeExec => {
                // Its replacement stops on its way from fork to exec.
                if let Some((next, _)) = self.successor(who, pid, 1, report)? {
                    self.open[number].who = next;
                    self.open[number].struck_ns = Some(clock::now_ns());
                }
            }
            Kind::KillAtCall => {
                let Some(calls) = self.calls_of_start(who, pid, report)? else { return Ok(()) };
                // Measuring took its place.
                let (who, pid) = self.pool().roster()[usize::from(who.worker)];
                let call = 1 + self.rng.below(calls);
                if let Some((next, pid)) = self.successor(who, pid, 1, report)? {
                    self.open[number].who = next;
                    planned.traces.push(Trace { number, pid, call });
                }
            }
            Kind::Stop => shoot(within_ns, Deed::Stop),
            Kind::StopContinue => {
                let ns = 1_000_000 + self.rng.below(250_000_000);
                shoot(within_ns, Deed::Pause(ns));
            }
            Kind::Slow => shoot(within_ns / 2, Deed::Choke(20)),
            Kind::GarbleBatch | Kind::QueueFull => {
                let bit = self.rng.bits() as u32;
                let how = if kind == Kind::QueueFull {
                    Corruption::Refused
                } else {
                    Corruption::Garbled(bit)
                };
                self.pool().corrupt_next(who.worker, how);
                self.open[number].struck_ns = Some(clock::now_ns());
            }
            Kind::FlipStatus => {
                let bit = self.rng.bits();
                self.pool().flip_status(who.worker, bit);
                self.open[number].struck_ns = Some(clock::now_ns());
            }
            _ => {
                let Some(fault) = kind.commanded() else { return Ok(()) };
                self.sequence = self.sequence.wrapping_add(1).max(1);
                let share = self.jobs / u64::from(self.stage.plan.workers) / 2;
                let argument = match fault {
                    // All get the same job.
                    InjectedFault::Poison => {
                        (Rng::new(self.usual_ns ^ u64::from(self.sequence / 16)).bits() % self.jobs)
                            as u32
                    }
                    _ => self.rng.bits() as u32,
                };
                let after = self.rng.below(share.clamp(1, 20)) as u8;
                let order = FaultCommand { sequence: self.sequence, fault, after, argument };
                self.pool().command_fault(who.worker, Some(order));
            }
        }
        Ok(())
    }

    /// Kills a worker, and starts a successor, which stops before exec if `stopped` is 1; `None` if
    /// there is none.
    fn successor(
        &mut self,
        who: Incarnation,
        pid: u32,
        stopped: u32,
        report: &mut Report,
    ) -> Result<Option<(Incarnation, u32)>, Failure> {
        // Otherwise another worker's successor might be the one that stops.
        self.mend(false, report)?;
        if let Ok(held) = Held::of(pid) {
            signals::end(held)?;
            report.note_end(who);
        }
        self.pool().stop_next_starts(stopped);
        let mended = self.mend_pool()?;
        self.pool().stop_next_starts(0);
        let next = mended.started.into_iter().find(|next| next.worker == who.worker);
        Ok(next.map(|next| (next, self.pool().roster()[usize::from(next.worker)].1)))
    }

    /// Number of system calls that a successor makes until it has greeted, measured once.
    fn calls_of_start(
        &mut self,
        who: Incarnation,
        pid: u32,
        report: &mut Report,
    ) -> Result<Option<u64>, Failure> {
        if self.calls_of_start.is_none() {
            let Some((next, pid)) = self.successor(who, pid, 1, report)? else {
                return Ok(None);
            };
            let has_greeted = AtomicBool::new(false);
            let counted = std::thread::scope(|scope| {
                let over = |_| has_greeted.load(Ordering::SeqCst);
                let tracer = scope.spawn(move || trace(pid, None, over));
                let rallied = self.pool().rally();
                has_greeted.store(true, Ordering::SeqCst);
                rallied.map(|()| tracer.join())
            })?;
            self.calls_of_start = match counted {
                Ok(Ok(Traced::Released { calls: calls @ 1.. })) => Some(calls),
                // The coordinator took it to be stuck: next time.
                _ => None,
            };
            report.note_end(next);
        }
        Ok(self.calls_of_start)
    }
}
