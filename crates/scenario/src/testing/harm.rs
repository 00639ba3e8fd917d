//! Texts as people, editors and broken disks change them.

use proptest::prelude::*;

/// One change that a person, an editor or a broken disk could make.
#[derive(Clone, Debug)]
pub(crate) enum Harm {
    Drop(usize, usize),
    Insert(usize, String),
    Repeat(usize, usize),
    Cut(usize),
    Swap(usize, usize),
}

pub(crate) fn harms() -> impl Strategy<Value = Vec<Harm>> {
    let offset = || 0_usize..2000;
    let piece = prop_oneof![
        any::<String>(),
        "[\\[\\]{}=\"'.,#0-9a-z_\n \\-]{1,6}",
        Just("[[".repeat(200)),
        Just("{ a = ".repeat(200)),
        Just("a.".repeat(300)),
        Just("\u{feff}".to_owned()),
        Just("\r\n".to_owned()),
        Just("1e999".to_owned()),
        Just("persons = [{ age = 3 }]".to_owned()),
    ];
    let one = prop_oneof![
        (offset(), 1_usize..30).prop_map(|(start, len)| Harm::Drop(start, len)),
        (offset(), piece).prop_map(|(start, piece)| Harm::Insert(start, piece)),
        (offset(), 1_usize..200).prop_map(|(start, len)| Harm::Repeat(start, len)),
        offset().prop_map(Harm::Cut),
        (offset(), offset()).prop_map(|(a, b)| Harm::Swap(a, b)),
    ];
    proptest::collection::vec(one, 1..4)
}

pub(crate) fn harmed(text: &str, harms: &[Harm]) -> String {
    let mut letters: Vec<char> = text.chars().collect();
    for harm in harms {
        let len = letters.len().max(1);
        let clip = |at: usize, count: usize| {
            let start = (at % len).min(letters.len());
            start..(start + count).min(letters.len())
        };
        match harm {
            Harm::Drop(at, count) => drop(letters.drain(clip(*at, *count))),
            Harm::Insert(at, piece) => {
                let start = clip(*at, 0).start;
                letters.splice(start..start, piece.chars());
            }
            Harm::Repeat(at, count) => {
                let range = clip(*at, *count);
                let again = letters[range.clone()].to_vec();
                letters.splice(range.end..range.end, again);
            }
            Harm::Cut(at) => letters.truncate(at % len),
            Harm::Swap(a, b) => {
                let (a, b) = (clip(*a, 0).start, clip(*b, 0).start);
                if a < letters.len() && b < letters.len() {
                    letters.swap(a, b);
                }
            }
        }
    }
    letters.into_iter().collect()
}
