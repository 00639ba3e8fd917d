//! Laws of the search: a naive walk along the same poses, and answers in any order.

use super::*;
use proptest::prelude::*;

fn path(travels: Vec<f64>) -> Path {
    Path { travels: travels.into(), step_m: 0.1, coarse: false, closing_m_s: 10.0 }
}

/// The reference: the grid one by one, then halving.
fn naive(travels: &[f64], touches: &impl Fn(f64) -> bool) -> First {
    let Some(k) = travels.iter().position(|s| touches(*s)) else { return First::None };
    if k == 0 {
        return First::At(travels[0]);
    }
    let (mut lo, mut hi) = (travels[k - 1], travels[k]);
    while hi - lo > 0.001 {
        let mid = 0.5 * (lo + hi);
        if touches(mid) { hi = mid } else { lo = mid }
    }
    First::At(hi)
}

/// Contact between pairs of travels: with gaps, as a body with holes has.
fn holes() -> impl Strategy<Value = Vec<(f64, f64)>> {
    prop::collection::vec((0.0..1.6_f64, 0.0..0.6_f64), 0..3)
}

proptest! {
    #[test]
    fn finds_what_a_naive_walk_finds_in_whatever_order_answers_come(
        holes in holes(), count in 2..16_usize, picks in prop::collection::vec(0..64_usize, 200),
    ) {
        let travels: Vec<f64> = (0..count).map(|k| k as f64 * 0.1).collect();
        let touches = |s: f64| holes.iter().any(|(from, length)| *from <= s && s <= from + length);
        let mut search = Search::new(&path(travels.clone()));
        let mut last = search.bracket();
        let mut picks = picks.into_iter();
        while search.outcome().is_none() {
            let wanted = search.wanted();
            prop_assert!(!wanted.is_empty());
            let s = wanted[picks.next().unwrap_or(0) % wanted.len()];
            prop_assert!(search.is_needed(s));
            search.learn(s, touches(s));
            search.learn(s, touches(s));
            // No travel is asked for twice, and the bracket only narrows.
            prop_assert!(!search.is_needed(s));
            if touches(s) || search.has_touched() {
                let now = search.bracket();
                prop_assert!(now.0 >= last.0 && now.1 <= last.1, "{last:?} {now:?}");
                last = now;
            }
        }
        prop_assert_eq!(search.outcome(), Some(naive(&travels, &touches)));
        prop_assert!(search.wanted().is_empty());
        if let Some(First::At(f)) = search.outcome() {
            prop_assert!(search.has_touched());
            prop_assert_eq!(search.bracket(), (f, f));
        }
    }
}

#[test]
fn poses_after_a_touch_are_no_longer_needed() {
    let mut search = Search::new(&path(vec![0.0, 0.1, 0.2, 0.3]));
    assert_eq!(search.wanted()[..], [0.0, 0.1, 0.2, 0.3]);
    search.learn(0.2, true);
    assert_eq!(search.wanted()[..], [0.0, 0.1]);
    assert!(!search.is_needed(0.3));
    search.learn(0.0, true);
    assert_eq!(search.outcome(), Some(First::At(0.0)));
}
