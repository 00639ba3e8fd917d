//! Misdeeds on order, for fault injection alone: of workers, and of the way to them.
//!
//! No answer may depend on it: whoever misbehaves is found out as if nobody had told it to.

use super::Crew;
use core::sync::atomic::Ordering;
use protocol::Order;

/// What is done to a batch on its way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Spoiled {
    /// This bit of it, modulo its length, is flipped after it was sealed.
    Garbled(u32),
    /// It is refused, as if the queue were full.
    Refused,
}

impl Crew {
    /// Tells a worker to misbehave: it must have been started with `obeys`.
    pub fn order(&self, worker: u8, order: Option<Order>) {
        let line = self.status.page().coordinator.get(usize::from(worker));
        if let Some(line) = line {
            line.order.store(order.map_or(0, Order::to_word), Ordering::SeqCst);
        }
    }

    /// When a worker last obeyed (ns, monotonic); 0: never.
    #[must_use]
    pub fn obeyed_ns(&self, worker: u8) -> u64 {
        let line = self.status.page().workers.get(usize::from(worker));
        line.map_or(0, |line| line.obeyed_ns.load(Ordering::SeqCst))
    }

    /// Spoils the next batch to a worker: for fault injection.
    pub fn spoil_next(&mut self, worker: u8, how: Spoiled) {
        if let Some(station) = self.stations.get_mut(usize::from(worker)) {
            station.spoiled = Some(how);
        }
    }
}
