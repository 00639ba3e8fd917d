//! Law of the ledger: it equals the recomputation from the log of what was booked.

use super::*;
use proptest::prelude::*;
use std::collections::BTreeSet;

proptest! {
    #[test]
    fn equals_the_recomputation_from_the_log(
        log in prop::collection::vec((0_usize..3, 0_u32..2, 0_u32..200, 0_u8..20), 0..300),
    ) {
        let mut ledger = Ledger::new(3);
        let (mut held, mut expected) = (BTreeSet::new(), Transfer::default());
        for (core, model, node, dice) in log {
            let section = Section { model, node };
            let bytes = 24 + u64::from(node) * 36;
            if dice == 0 {
                ledger.lose(core);
                held.retain(|(c, _)| *c != core);
                continue;
            }
            prop_assert_eq!(ledger.holds(core, section), held.contains(&(core, section)));
            ledger.need(core, section, bytes);
            expected.unshared_bytes += bytes;
            if held.insert((core, section)) {
                expected.section_bytes += bytes;
                expected.missed += 1;
            } else {
                expected.found += 1;
            }
        }
        prop_assert_eq!(ledger.transfer(), expected);
    }
}
