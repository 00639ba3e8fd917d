//! The invariant: it is a set of the numbers of a range, even where leaves overlap its ends.

use super::*;
use proptest::collection::{btree_set, vec};
use proptest::prelude::*;
use std::collections::BTreeSet;

proptest! {
    #[test]
    fn what_is_put_in_is_there_and_new_once(
        start in 0_u32..1000,
        len in 1_u32..400,
        leaves in vec((0.0..1.0_f64, btree_set(0..ROOM, 0..20)), 0..9),
    ) {
        let range = start..start + len;
        let mut hits = Hits::with_room(len as usize);
        // The contents from before the range changed are gone.
        hits.clear(&(0..len));
        hits.insert(len - 1);
        hits.clear(&range);
        let mut expected = BTreeSet::new();
        // A leaf has a triangle of the range, so it begins less than its own size before it.
        let (least, most) = (start.saturating_sub(ROOM as u32 - 1), range.end - 1);
        for (at, of) in leaves {
            let first = least + (f64::from(most - least) * at) as u32;
            let named = |place: &usize| first + *place as u32;
            let (mut places, mut fresh) = (Places::default(), Places::default());
            for place in of.iter().filter(|place| range.contains(&named(place))) {
                places.insert(*place);
                if expected.insert(named(place)) {
                    fresh.insert(*place);
                }
            }
            prop_assert_eq!(hits.insert_places(first, &places), fresh);
            let mut seen = Places::default();
            let known = |place: &usize| expected.contains(&named(place));
            (0..ROOM).filter(known).for_each(|place| seen.insert(place));
            prop_assert_eq!(hits.places(first), seen);
        }
        for triangle in range {
            prop_assert_eq!(hits.has(triangle), expected.contains(&triangle));
            prop_assert_eq!(hits.insert(triangle), expected.insert(triangle));
        }
    }
}
