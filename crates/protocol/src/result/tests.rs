//! Invariants of results: hits survive a round trip, and hostile counts are rejected.

use super::*;
use proptest::prelude::*;

proptest! {
    #[test]
    fn a_part_comes_back_as_it_was_written(
        hits in prop::collection::vec(any::<u32>(), 0..50),
        room in TAIL_WORDS..TAIL_WORDS + 30,
        pairs in any::<bool>(),
    ) {
        let mut words = vec![u64::MAX; room];
        let mut n = 0;
        while n < hits.len() && write_hit(&mut words, n, hits[n]) {
            n += 1;
        }
        prop_assert_eq!(n, hits.len().min(2 * (room - TAIL_WORDS)));
        prop_assert_eq!(read_hits(&words[..n.div_ceil(2)], n as u32), Some(&hits[..n]));

        let supports = [0.5; SUPPORTS];
        let supports = pairs.then_some(&supports);
        let summary = Summary {
            np: 3,
            end: WireEnd::Complete as u32,
            supports: if pairs { 74 } else { 0 },
            ..Summary::zeroed()
        };
        let used = write_last(&mut words, n, &summary, supports);
        let last = read_last(&words[..used], n as u32);
        prop_assert_eq!(last, Some(Last { summary, supports, seen: None, hits: &hits[..n] }));
        prop_assert_eq!(read_last(&words[..used - 1], n as u32), None);
    }

    #[test]
    fn what_a_look_showed_comes_back(time_s in any::<f64>(), ids in any::<[u32; 2]>()) {
        let seen = WireSeen {
            kind: SeenKind::Contact as u32,
            is_certain: 1,
            time_s,
            excluded_before_s: 0.5,
            triangles: [7, 9],
            point: [1.0, -0.0, 2.0],
            ids,
        };
        let mut words = vec![u64::MAX; TAIL_WORDS];
        let summary = Summary { nb: 3, end: WireEnd::Complete as u32, ..Summary::zeroed() };
        let used = write_seen(&mut words, &summary, &seen);
        let last = read_last(&words[..used], 0).expect("it was written whole");
        let bits = |seen: WireSeen| bytemuck::cast::<_, [u64; SEEN_WORDS]>(seen);
        prop_assert_eq!(last.seen.map(bits), Some(bits(seen)));
        prop_assert_eq!((last.summary.nb, last.supports, last.hits.len()), (3, None, 0));
        prop_assert_eq!(read_last(&words[..used - 1], 0), None);
        prop_assert_eq!(read_last(&words[..used], 2), None, "a look has no hits");
    }

    #[test]
    fn side_and_triangle_come_back(triangle in 0_u32..1 << 31, a in any::<bool>()) {
        let side = if a { WireSide::A } else { WireSide::B };
        prop_assert_eq!(read_hit(hit(side, triangle)), (side, triangle));
    }

    #[test]
    fn no_words_make_it_panic(
        words in prop::collection::vec(any::<u64>(), 0..100),
        hits in any::<u32>(),
    ) {
        let _ = (read_last(&words, hits), read_hits(&words, hits));
    }
}
