//! The largest share equals what walking up from every deeper pair counts.

use super::*;
use proptest::prelude::*;
use std::collections::BTreeMap;

/// Levels of a full binary tree; its nodes are numbered in preorder.
const LEVELS: u32 = 6;

/// The node that a way from the root (bits, first turn lowest) reaches after `depth` turns.
fn node(way: u32, depth: u32) -> u32 {
    let size = |level: u32| (1 << (LEVELS - level)) - 1;
    (0..depth).map(|level| 1 + ((way >> level) & 1) * size(level + 1)).sum()
}

proptest! {
    #[test]
    fn the_largest_job_has_as_many_deeper_pairs_as_lie_below_it(
        ways in prop::collection::btree_set((0_u32..32, 0_u32..32), 1..60), depth in 0_u32..=5,
    ) {
        let below = |depth: u32| -> Vec<[u32; 2]> {
            let mut pairs: Vec<_> =
                ways.iter().map(|(a, b)| [node(*a, depth), node(*b, depth)]).collect();
            pairs.sort_unstable();
            pairs.dedup();
            pairs
        };
        let (jobs, deepest) = (below(depth), below(5));
        prop_assert_eq!(deepest.len(), ways.len());
        let mut counts = BTreeMap::new();
        for (a, b) in &ways {
            *counts.entry([node(*a, depth), node(*b, depth)]).or_insert(0_u32) += 1;
        }
        let most = f64::from(counts.into_values().max().unwrap());
        let found = Descent::new(depth, 7, &jobs, &deepest);
        prop_assert_eq!(found.largest, most / ways.len() as f64);
        prop_assert_eq!((found.depth, found.nb, found.jobs), (depth, 7, jobs.len() as u64));
    }
}

#[test]
fn where_nothing_overlaps_one_job_would_have_everything() {
    assert_eq!(Descent::new(4, 1, &[], &[]), Descent { depth: 4, nb: 1, jobs: 0, largest: 1.0 });
}
