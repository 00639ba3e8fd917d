//! Words mean what they say in every crate, and the suggestion is the nearest word.

use super::*;
use proptest::prelude::*;
use serde::de::DeserializeOwned;
use std::fmt::Debug;

/// The least number of edits, by trying them all: the definition, without a table.
fn distance_by_trying(a: &[char], b: &[char]) -> usize {
    let (Some((x, a_rest)), Some((y, b_rest))) = (a.split_first(), b.split_first()) else {
        return a.len() + b.len();
    };
    let change = distance_by_trying(a_rest, b_rest) + usize::from(x != y);
    let plain =
        change.min(distance_by_trying(a_rest, b) + 1).min(distance_by_trying(a, b_rest) + 1);
    match (a, b) {
        ([p, q, a_rest @ ..], [r, s, b_rest @ ..]) if p == s && q == r => {
            plain.min(distance_by_trying(a_rest, b_rest) + 1)
        }
        _ => plain,
    }
}

proptest! {
    #[test]
    fn distance_is_the_least_number_of_edits(a in "[abc]{0,5}", b in "[abc]{0,5}") {
        let letters = |s: &str| s.chars().collect::<Vec<char>>();
        prop_assert_eq!(distance(&a, &b), distance_by_trying(&letters(&a), &letters(&b)));
    }

    #[test]
    fn no_name_escapes_its_quotes(name in any::<String>()) {
        let shown = quoted(&name);
        prop_assert!(shown.starts_with('"') && shown.ends_with('"'));
        prop_assert!(!shown.chars().any(char::is_control));
        // An escaped character is at most as long as \u{10ffff}.
        prop_assert!(shown.chars().count() <= 2 + 41 * 10);
    }
}

fn words_agree_with_the_model<T: Named + Debug + PartialEq + DeserializeOwned>() {
    for thing in T::ALL {
        assert_eq!(meaning::<T>("x", thing.word()), Ok(*thing));
        let read: T = toml::Value::String(thing.word().to_owned()).try_into().unwrap();
        assert_eq!(read, *thing);
    }
}

#[test]
fn a_word_means_here_what_it_means_in_model_files() {
    words_agree_with_the_model::<Shape>();
    words_agree_with_the_model::<Seat>();
    words_agree_with_the_model::<Build>();
}

#[test]
fn a_near_word_is_suggested_and_a_far_one_is_not() {
    let known = ["ego", "suv", "pole", "pedestrian"];
    let suggested = |written| nearest(&known, written);
    assert_eq!(suggested("suvv"), Some("suv"));
    assert_eq!(suggested("SUV"), Some("suv"));
    assert_eq!(suggested("peol"), None);
    assert_eq!(suggested("ploe"), Some("pole"));
    assert_eq!(suggested("pedestrain"), Some("pedestrian"));
    assert_eq!(suggested("tram"), None);
    assert_eq!(suggested(""), None);
    assert_eq!(nearest(&[], "suv"), None);
}
