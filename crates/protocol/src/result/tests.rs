//! Laws of results: hits come back as they were written, and hostile counts are refused.

use super::*;
use proptest::prelude::*;

proptest! {
    #[test]
    fn hits_come_back(hits in prop::collection::vec(any::<u32>(), 0..50), room in 0_usize..30) {
        let mut words = vec![u64::MAX; room];
        let mut writer = HitWriter::new(&mut words);
        let written = hits.iter().take_while(|hit| writer.push(**hit)).count();
        prop_assert_eq!(written, hits.len().min(2 * room));
        let (n, used) = (writer.hits(), writer.words());
        prop_assert_eq!(read_hits(&words[..used], n), Some(&hits[..written]));
    }

    #[test]
    fn side_and_triangle_come_back(triangle in 0_u32..1 << 31, a in any::<bool>()) {
        let side = if a { Side::A } else { Side::B };
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

#[test]
fn the_last_part_is_taken_apart() {
    let summary =
        Summary { np: 3, end: End::Complete as u32, supports: 74, hits: 1, ..Summary::zeroed() };
    let mut words: Vec<u64> = bytemuck::cast_slice(bytemuck::bytes_of(&summary)).to_vec();
    words.extend((0..74_u32).map(|i| f64::from(i).to_bits()));
    words.push(u64::from(hit(Side::B, 8)));
    let last = read_last(&words, 1).unwrap();
    assert_eq!((last.summary, last.supports.unwrap()[73]), (summary, 73.0));
    assert_eq!(last.hits, [1 << 31 | 8]);
    assert_eq!(read_last(&words, 3), None);
    assert_eq!(read_last(&words[..70], 0), None);
}
