//! Each strategy does what its name says; none picks a candidate without work.

use super::*;
use proptest::prelude::*;

fn prospect(lo: f64, width: f64, has_work: bool, is_possible: bool) -> Prospect {
    let compared = Interval::new(lo, lo + width);
    Prospect { has_work, is_possible, compared }
}

proptest! {
    #[test]
    fn whoever_is_chosen_has_work(
        all in prop::collection::vec(
            (0.0..1.0_f64, 0.0..1.0_f64, any::<bool>(), any::<bool>()),
            1..8,
        ),
        incumbent in any::<prop::sample::Index>(), rounds in 1..5_usize,
    ) {
        let prospects: Vec<Prospect> =
            all.iter().map(|(lo, width, work, can)| prospect(*lo, *width, *work, *can)).collect();
        let incumbent = incumbent.index(prospects.len());
        for search_order in SearchOrder::ALL {
            let mut strategy = search_order.strategy();
            for _ in 0..rounds {
                if let Some(k) = strategy.choose(&prospects, incumbent) {
                    prop_assert!(prospects[k].has_work, "{search_order:?} chose {k}");
                }
            }
        }
    }
}

#[test]
fn each_goes_its_way() {
    let prospect_over = |lo, width| prospect(lo, width, true, true);
    let prospects = [
        prospect_over(0.2, 0.1),
        prospect_over(0.1, 0.9),
        prospect_over(0.05, 0.3),
        prospect(0.0, 0.0, true, false),
    ];
    let picks = |search_order: SearchOrder| {
        let mut strategy = search_order.strategy();
        [0; 4].map(|_| strategy.choose(&prospects, 0))
    };
    assert_eq!(picks(SearchOrder::AsAsked), [None; 4]);
    assert_eq!(picks(SearchOrder::Sequential), [Some(0); 4]);
    assert_eq!(picks(SearchOrder::RoundRobin), [0, 1, 2, 3].map(Some));
    // The challenger is the possible one with the lowest lower end.
    assert_eq!(picks(SearchOrder::Alternating), [2, 0, 2, 0].map(Some));
    // It has more to lose than the incumbent.
    assert_eq!(picks(SearchOrder::Deciding), [Some(2); 4]);
}
