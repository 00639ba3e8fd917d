//! The invariant: places behave as sets of numbers.

use super::*;
use proptest::collection::btree_set;
use proptest::prelude::*;
use std::collections::BTreeSet;

fn places(of: &BTreeSet<usize>) -> Places {
    let mut places = Places::default();
    of.iter().for_each(|place| places.insert(*place));
    places
}

proptest! {
    #[test]
    fn places_are_a_set(
        p in btree_set(0..ROOM, 0..40),
        q in btree_set(0..ROOM, 0..40),
        count in 0..=ROOM,
    ) {
        let (of_p, of_q) = (places(&p), places(&q));
        let bit = |place: &usize| of_p.words()[place / BITS] >> (place % BITS) & 1 == 1;
        prop_assert_eq!((0..ROOM).filter(bit).collect::<BTreeSet<_>>(), p.clone());
        prop_assert_eq!(Places::of(of_p.words()), of_p);
        prop_assert_eq!(of_p.is_empty(), p.is_empty());
        let both: BTreeSet<_> = p.intersection(&q).copied().collect();
        prop_assert_eq!(of_p.and(&of_q), places(&both));
        let one: BTreeSet<_> = p.difference(&q).copied().collect();
        prop_assert_eq!(of_p.without(&of_q), places(&one));
        prop_assert_eq!(of_p.is_within(&of_q), p.is_subset(&q));
        prop_assert!(places(&both).is_within(&of_q));
        prop_assert_eq!(Places::first(count), places(&(0..count).collect()));
    }

    #[test]
    fn bits_of_a_word_are_put_from_a_place_on(
        word in 0..WORDS, place in 0..=BITS - 32, bits: u32, more in btree_set(0..ROOM, 0..9),
    ) {
        let mut found = places(&more);
        found.insert_from(word, place, bits.into());
        let put = (0..32).filter(|i| bits >> i & 1 == 1).map(|i| word * BITS + place + i);
        prop_assert_eq!(found, places(&more.into_iter().chain(put).collect()));
    }
}
