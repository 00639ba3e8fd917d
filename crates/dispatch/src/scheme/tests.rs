//! Laws of the schemes: only eligible cores, and each end of α is what it says.

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

fn matched(view: &CoreView) -> u32 {
    u32::from(view.has_a) + u32::from(view.has_b)
}

proptest! {
    #[test]
    fn an_eligible_core_is_chosen_whenever_there_is_one(cores in views(), alpha in 0.0..=1.0) {
        let chosen = BestMatchLoad { alpha }.choose(&cores, 64);
        prop_assert_eq!(chosen.is_some(), cores.iter().any(|core| core.eligible));
        prop_assert!(chosen.is_none_or(|core| cores[core].eligible));
    }

    #[test]
    fn alpha_zero_is_least_loaded_and_alpha_one_is_best_match(cores in views()) {
        let eligible = || cores.iter().filter(|core| core.eligible);
        if let Some(core) = (BestMatchLoad { alpha: 0.0 }).choose(&cores, 64) {
            let least = eligible().map(|core| core.queued).min();
            prop_assert_eq!(Some(cores[core].queued), least);
        }
        if let Some(core) = (BestMatchLoad { alpha: 1.0 }).choose(&cores, 64) {
            let most = eligible().map(matched).max();
            prop_assert_eq!(Some(matched(&cores[core])), most);
            let tied = eligible().filter(|core| Some(matched(core)) == most);
            prop_assert_eq!(Some(cores[core].queued), tied.map(|core| core.queued).min());
        }
    }
}
