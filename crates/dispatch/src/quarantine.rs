//! Jobs that killed two workers: later requests skip them for a while.
//!
//! A job is identified by a key derived from its inputs (bodies, pose, sections), since its number
//! is only meaningful within one request. A skipped job is abandoned, which the answer reports;
//! after [`REST_NS`] it is tried again.

use std::collections::BTreeMap;

/// How long a job is skipped (ns).
const REST_NS: u64 = 60_000_000_000;
/// Maximum number of keys; beyond it, the one that expires first is dropped.
const MOST: usize = 1024;

/// Keys of jobs, each with its expiry time.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub(crate) struct Quarantine(BTreeMap<u64, u64>);

impl Quarantine {
    pub(crate) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    pub(crate) fn add(&mut self, key: u64, now_ns: u64) {
        self.0.retain(|_, until_ns| *until_ns > now_ns);
        if self.0.len() >= MOST
            && let Some(first) = self.0.iter().min_by_key(|(_, until_ns)| **until_ns)
        {
            let key = *first.0;
            self.0.remove(&key);
        }
        self.0.insert(key, now_ns.saturating_add(REST_NS));
    }

    pub(crate) fn holds(&self, key: u64, now_ns: u64) -> bool {
        self.0.get(&key).is_some_and(|until_ns| *until_ns > now_ns)
    }
}

#[cfg(test)]
mod tests {
    //! Keys expire, and their number is bounded.
    use super::*;

    #[test]
    fn a_key_is_held_for_its_time_and_their_number_is_bounded() {
        let mut quarantine = Quarantine::default();
        assert!(quarantine.is_empty());
        quarantine.add(9, 0);
        quarantine.add(10, REST_NS);
        assert_eq!(quarantine.0.len(), 1, "what has expired is forgotten");
        assert!(!quarantine.is_empty());
        let mut quarantine = Quarantine::default();
        for key in 0..3 * MOST as u64 {
            quarantine.add(key, key);
        }
        assert_eq!(quarantine.0.len(), MOST);
        let last = 3 * MOST as u64 - 1;
        assert!(quarantine.holds(last, last + REST_NS - 1));
        assert!(!quarantine.holds(last, last + REST_NS));
        assert!(!quarantine.holds(0, 0), "the oldest were forgotten");
    }
}
