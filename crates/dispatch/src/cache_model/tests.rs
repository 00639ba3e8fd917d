//! Invariants of the ledger: it equals its recomputation from the log, and no core ever exceeds its
//! capacity.

use super::*;
use proptest::prelude::*;

const CORES: usize = 3;

fn weight(section: Section) -> u64 {
    24 + u64::from(section.node) * 36
}

fn caches() -> impl Strategy<Value = Cache> {
    prop_oneof![
        Just(Cache::Unlimited),
        (0_u64..20_000).prop_map(Cache::Recent),
        (0_u64..60_000).prop_map(Cache::Fixed),
    ]
}

/// The content of a core, most recent last: the simplest list that works.
#[derive(Clone, Default)]
struct List(Vec<Section>);

impl List {
    fn bytes(&self) -> u64 {
        self.0.iter().map(|section| weight(*section)).sum()
    }

    /// Returns whether the section was present, and whether it does not fit; evicts others as
    /// needed.
    fn need(&mut self, section: Section, cache: Cache, evicted: &mut u64) -> (bool, bool) {
        let bytes = weight(section);
        if let Some(at) = self.0.iter().position(|held| *held == section) {
            let held = self.0.remove(at);
            self.0.push(held);
            return (true, true);
        }
        let fits = match cache {
            Cache::Unlimited => true,
            Cache::Recent(most) if bytes > most => return (false, true),
            Cache::Recent(most) => {
                while self.bytes() + bytes > most {
                    self.0.remove(0);
                    *evicted += 1;
                }
                true
            }
            Cache::Fixed(most) => self.bytes() + bytes <= most,
        };
        if fits {
            self.0.push(section);
        }
        (false, fits)
    }
}

proptest! {
    #[test]
    fn equals_the_recomputation_from_the_log_and_never_exceeds_capacity(
        cache in caches(),
        log in prop::collection::vec((0..CORES, 0_u32..2, 0_u32..200, 0_u8..20), 0..300),
    ) {
        let mut ledger = CacheModel::new(CORES, cache);
        let (mut lists, mut expected) = (vec![List::default(); CORES], Transfer::default());
        let mut has_thrashed = false;
        for (core, model, node, dice) in log {
            let section = Section { model, node };
            if dice == 0 {
                ledger.lose(core);
                lists[core] = List::default();
                continue;
            }
            let bytes = weight(section);
            let travels = ledger.need(core, section, bytes);
            let (found, fits) = lists[core].need(section, cache, &mut expected.evicted);
            has_thrashed |= !fits;
            expected.unshared_bytes += bytes;
            expected.found += u64::from(found);
            expected.missed += u64::from(!found);
            expected.section_bytes += if found { 0 } else { bytes };
            prop_assert_eq!(travels, !found);
            prop_assert_eq!(ledger.held_bytes(core), lists[core].bytes());
            for held in &lists[core].0 {
                prop_assert!(ledger.holds(core, *held));
            }
            if let Cache::Recent(most) | Cache::Fixed(most) = cache {
                prop_assert!(ledger.held_bytes(core) <= most);
            }
            prop_assert!(ledger.transfer().section_bytes <= ledger.transfer().unshared_bytes);
        }
        prop_assert_eq!(ledger.transfer(), expected);
        prop_assert_eq!(ledger.thrash().is_some(), has_thrashed);
    }
}

/// Found by `cargo mutants`: capacities above are hardly ever those of whole sections.
#[test]
fn a_section_as_large_as_the_cache_is_held() {
    let section = Section { model: 0, node: 1 };
    for cache in [Cache::Recent(100), Cache::Fixed(100)] {
        let mut cache_model = CacheModel::new(1, cache);
        assert!(cache_model.need(0, section, 100) && cache_model.holds(0, section), "{cache:?}");
        assert!(!cache_model.need(0, section, 100) && cache_model.thrash().is_none(), "{cache:?}");
    }
}

/// Found by `cargo mutants`: each one of the test above is new.
#[test]
fn what_begins_again_is_as_a_new_one() {
    let section = |node| Section { model: 0, node };
    for cache in [Cache::Unlimited, Cache::Recent(300), Cache::Fixed(300)] {
        let mut cache_model = CacheModel::new(2, cache);
        let fill = |cache_model: &mut CacheModel| {
            (0..20).map(|node| cache_model.need(0, section(node % 4), 100)).collect::<Vec<_>>()
        };
        let first = fill(&mut cache_model);
        let transfer = cache_model.transfer();
        assert!(cache_model.held_bytes(0) > 0 && transfer.missed > 0);
        cache_model.begin();
        assert_eq!((cache_model.held_bytes(0), cache_model.transfer()), (0, Transfer::default()));
        assert!((0..4).all(|node| !cache_model.holds(0, section(node))));
        assert_eq!(
            (fill(&mut cache_model), cache_model.transfer()),
            (first, transfer),
            "{cache:?}"
        );
    }
}
