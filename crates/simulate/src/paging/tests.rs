//! Laws of virtual memory: nothing moves while memory lasts, and never more than twice what is
//! needed.

use super::*;
use proptest::prelude::*;
use std::collections::BTreeSet;

const CORES: usize = 2;

fn section(model: u32, node: u32) -> (Section, u64) {
    (Section { model, node }, 10 + 30 * u64::from(node))
}

proptest! {
    #[test]
    fn nothing_moves_while_memory_lasts_and_never_more_than_is_needed(
        memory_bytes in 0_u64..6_000,
        log in prop::collection::vec((0..CORES, 0_u32..20, 0_u32..20), 0..200),
    ) {
        let mut pager = Pager::new(CORES, Paging { memory_bytes, byte_ns: 2.0 });
        let mut held = vec![BTreeSet::new(); CORES];
        let mut needed = 0;
        let mut waited_ns = 0.0;
        for (core, a, b) in log {
            let sections = [section(0, a), section(1, b)];
            let fresh: Vec<Section> =
                sections.into_iter().filter(|s| held[core].insert(*s)).map(|s| s.0).collect();
            needed += sections.iter().map(|(_, bytes)| bytes).sum::<u64>();
            waited_ns += pager.need(core, sections, &fresh);
        }
        let sum = |held: &BTreeSet<(Section, u64)>| -> u64 {
            held.iter().map(|(_, bytes)| bytes).sum()
        };
        let lasts = held.iter().all(|held| sum(held) <= memory_bytes);
        prop_assert_eq!(pager.moved_bytes() == 0, lasts);
        prop_assert!(pager.moved_bytes() <= 2 * needed);
        prop_assert!((pager.moved_ns() - waited_ns).abs() < 1e-6 * (1.0 + waited_ns));
    }
}

#[test]
fn what_is_pushed_out_is_written_once_and_comes_in_when_it_is_needed() {
    let mut pager = Pager::new(1, Paging { memory_bytes: 250, byte_ns: 3.0 });
    let [a, b, c] = [
        (Section { model: 0, node: 1 }, 100),
        (Section { model: 1, node: 1 }, 100),
        (Section { model: 1, node: 2 }, 100),
    ];
    assert_eq!(pager.need(0, [a, b], &[a.0, b.0]), 0.0);
    // C pushes out B, which was needed less recently than A.
    assert_eq!(pager.need(0, [a, c], &[c.0]), 300.0);
    assert_eq!(pager.need(0, [a, b], &[]), 300.0);
    assert_eq!(pager.need(0, [a, b], &[]), 0.0);
    assert_eq!(pager.moved_bytes(), 200);
    // Larger than the memory: it is never in it.
    let whole = (Section { model: 0, node: 0 }, 400);
    assert_eq!(pager.need(0, [whole, b], &[whole.0]), 1200.0);
    assert_eq!(pager.need(0, [whole, b], &[]), 1200.0);
}
