//! Invariants of the schemes: only eligible cores are chosen, and each scheme matches its name.

use super::*;
use proptest::prelude::*;

fn views() -> impl Strategy<Value = Vec<CoreView>> {
    prop::collection::vec((any::<bool>(), 0_u32..64, any::<bool>(), any::<bool>()), 1..9).prop_map(
        |cores| {
            let view =
                |(eligible, queued, has_a, has_b)| CoreView { eligible, queued, has_a, has_b };
            cores.into_iter().map(view).collect()
        },
    )
}

fn matchings() -> impl Strategy<Value = Matching> {
    prop_oneof![
        (0.0..=1.0).prop_map(Matching::BestMatchLoad),
        Just(Matching::BestMatch),
        any::<u64>().prop_map(Matching::RandomMatch),
        Just(Matching::LowestMatch),
        Just(Matching::RoundRobin),
    ]
}

/// The core with the least key, computed by hand: the first of the eligible ones in order.
fn first_by<K: Ord>(cores: &[CoreView], key: impl Fn(&CoreView) -> K) -> Option<usize> {
    let mut eligible: Vec<usize> = (0..cores.len()).filter(|c| cores[*c].eligible).collect();
    eligible.sort_by_key(|core| (key(&cores[*core]), *core));
    eligible.first().copied()
}

/// How many of a job's two sections are there.
fn matched(view: &CoreView) -> i64 {
    [view.has_a, view.has_b].into_iter().filter(|is_there| *is_there).count() as i64
}

proptest! {
    #[test]
    fn an_eligible_core_is_chosen_whenever_there_is_one(cores in views(), matching in matchings()) {
        let chosen = matching.scheme().choose(&cores, 64);
        prop_assert_eq!(chosen.is_some(), cores.iter().any(|core| core.eligible));
        prop_assert!(chosen.is_none_or(|core| cores[core].eligible));
    }

    #[test]
    fn each_end_of_alpha_and_the_lowest_match_are_what_they_say(cores in views()) {
        let choose = |mut scheme: Box<dyn MatchScheme>| scheme.choose(&cores, 64);
        let best = first_by(&cores, |view| (2 - matched(view), view.queued));
        prop_assert_eq!(choose(Matching::BestMatchLoad(1.0).scheme()), best);
        prop_assert_eq!(choose(Matching::BestMatch.scheme()), best);
        let least = first_by(&cores, |view| view.queued);
        prop_assert_eq!(choose(Matching::BestMatchLoad(0.0).scheme()), least);
        let lowest = first_by(&cores, |view| (matched(view), view.queued));
        prop_assert_eq!(choose(Matching::LowestMatch.scheme()), lowest);
    }

    /// α in eighths and queues of 64 jobs: scores are whole numbers of 1024ths.
    #[test]
    fn between_its_ends_alpha_weighs_match_against_load(cores in views(), eighths in 0_i64..=8) {
        let least = first_by(&cores, |view| {
            let queued = i64::from(view.queued);
            (2 * (8 - eighths) * queued - 64 * eighths * matched(view), queued)
        });
        let mut scheme = BestMatchLoad { alpha: eighths as f64 / 8.0 };
        prop_assert_eq!(scheme.choose(&cores, 64), least);
    }

    #[test]
    fn round_robin_serves_every_eligible_core_before_any_twice(cores in views()) {
        let eligible = cores.iter().filter(|core| core.eligible).count();
        let mut scheme = RoundRobin::default();
        let mut turn: Vec<_> = (0..eligible).filter_map(|_| scheme.choose(&cores, 64)).collect();
        turn.sort_unstable();
        turn.dedup();
        prop_assert_eq!(turn.len(), eligible);
    }

    #[test]
    fn equal_seeds_draw_equally(cores in views(), seed in any::<u64>()) {
        let (mut one, mut two) = (RandomMatch { state: seed }, RandomMatch { state: seed });
        for _ in 0..20 {
            prop_assert_eq!(one.choose(&cores, 64), two.choose(&cores, 64));
        }
    }
}

#[test]
fn random_match_is_even() {
    let view = CoreView { eligible: true, queued: 0, has_a: false, has_b: true };
    let cores = [view, CoreView { eligible: false, ..view }, view, view];
    let (mut scheme, mut drawn) = (RandomMatch { state: 1 }, [0_u32; 4]);
    for _ in 0..30_000 {
        drawn[scheme.choose(&cores, 64).unwrap()] += 1;
    }
    // Five standard deviations around 10,000 are 408.
    assert!([0, 2, 3].iter().all(|core| drawn[*core].abs_diff(10_000) < 408), "{drawn:?}");
}

/// The first numbers of the generator's authors for this seed: their top bytes among 256 cores.
#[test]
fn random_match_draws_what_splitmix64_does() {
    let cores = [CoreView { eligible: true, queued: 0, has_a: false, has_b: false }; 256];
    let mut scheme = RandomMatch { state: 1_234_567 };
    let numbers = [
        6_457_827_717_110_365_317_u64,
        3_203_168_211_198_807_973,
        9_817_491_932_198_370_423,
        4_593_380_528_125_082_431,
        16_408_922_859_458_223_821,
    ];
    for number in numbers {
        assert_eq!(scheme.choose(&cores, 64), Some((number >> 56) as usize));
    }
}
