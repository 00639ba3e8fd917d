//! A key that stands twice is found with both its places, in whatever table it is; and no other.

use super::*;
use proptest::prelude::*;

/// The key and both lines, of TOML.
fn toml_lines(text: &str) -> Option<(String, Option<usize>, usize)> {
    let error = toml::from_str::<toml::Table>(text).unwrap_err();
    let twice = Twice::in_toml(text, &error)?;
    Some((twice.key.clone(), twice.first_line, line_of(text, twice.second.start)))
}

#[test]
fn both_lines_of_a_key_of_toml_are_found() {
    let cases = [
        ("a = 1\nb = 2\na = 3\n", "a", 1, 3),
        ("[t]\nx = 1\n[u]\nx = 1\n[v]\nx = 1\nx = 2\n", "x", 6, 7),
        ("x = 1\n[t.x]\n[u]\n[t.y]\nx = 1\n[t.x]\n", "x", 2, 6),
        ("[[p]]\na = 1\n[[p]]\na = 1\nb = 1\na = 2\n", "a", 4, 6),
        ("t = { a = 1, b = 2,\n a = 3 }\n", "a", 1, 2),
        ("l = [{ a = 1 }, { a = 1,\n a = 3 }]\n", "a", 1, 2),
        ("a.b = 1\na.c = 1\na.b = 1\n", "b", 1, 3),
        ("\"a b\" = 1\n'a b' = 2\n", "a b", 1, 2),
        ("\"a\" = 1\na = 2\n", "a", 1, 2),
        ("s = \"\"\"\na = 1\n\"\"\"\na = 1\na = 2 # a\n", "a", 4, 5),
        ("[a]\nx = 1\n[b]\n[a]\n", "a", 1, 4),
        ("[a]\nb.c = 1\n[a.b]\nd = 2\n", "b", 2, 3),
        ("a = 1\n[a]\nx = 1\n", "a", 1, 2),
    ];
    for (text, key, first, second) in cases {
        assert_eq!(toml_lines(text), Some((key.to_owned(), Some(first), second)), "{text}");
    }
}

#[test]
fn other_faults_of_toml_are_no_keys_that_stand_twice() {
    for text in ["a = \n", "[a\n", "a = 1 b = 2\n", "a = 1\na.b = 2\n", "\u{0}"] {
        assert_eq!(toml_lines(text), None, "{text}");
    }
}

#[test]
fn the_first_of_two_keys_of_json_is_found() {
    let lines = |text: &str| {
        let twice = Twice::in_json(text)?;
        Some((twice.key.clone(), twice.first_line, line_of(text, twice.second.start)))
    };
    let cases = [
        ("[{\"a\": 1,\n\"b\": {\"a\": 2},\n\"a\": 3}]", "a", 1, 3),
        ("{\"x\": \"a\\\"\",\n\"\\u0061\": 1,\n\"a\" : 2}", "a", 2, 3),
        ("{\"a\": [\"a\", \"a\"],\n\"b\": {}, \"b\": 1}", "b", 2, 2),
    ];
    for (text, key, first, second) in cases {
        assert_eq!(lines(text), Some((key.to_owned(), Some(first), second)), "{text}");
    }
    for text in ["{\"a\": 1, \"b\": \"a\"}", "[{\"a\": 1}, {\"a\": 1}]", "", "{\"a", "]", "\"a\":"]
    {
        assert_eq!(lines(text), None, "{text}");
    }
    assert_eq!(lines(&"[".repeat(100_000)), None);
}

#[test]
fn a_long_key_is_cut() {
    let key = "k".repeat(1_000_000);
    let text = format!("{key} = 1\n{key} = 2\n");
    let error = toml::from_str::<toml::Table>(&text).unwrap_err();
    let twice = Twice::in_toml(&text, &error).unwrap();
    assert_eq!(twice.key.chars().count(), 61);
    assert!(twice.what().ends_with("it is in line 1 already"), "{}", twice.what());
}

proptest! {
    /// A line that is doubled somewhere below is found again, with both its lines.
    #[test]
    fn a_doubled_line_of_toml_is_found(
        tables in prop::collection::vec(prop::collection::btree_set("[a-d]", 1..5), 1..6),
        table in any::<prop::sample::Index>(),
        key in any::<prop::sample::Index>(),
    ) {
        let table = table.index(tables.len());
        let key = key.index(tables[table].len());
        let (mut text, mut line, mut lines) = (String::new(), 0, [0, 0]);
        let mut doubled = String::new();
        for (number, keys) in tables.iter().enumerate() {
            text += &format!("[t{number}]\n");
            line += 1;
            for (place, name) in keys.iter().enumerate() {
                text += &format!("{name} = 1\n");
                line += 1;
                if (number, place) == (table, key) {
                    (lines[0], doubled) = (line, name.clone());
                }
            }
            if number == table {
                text += &format!("{doubled} = 2\n");
                line += 1;
                lines[1] = line;
            }
        }
        prop_assert_eq!(toml_lines(&text), Some((doubled, Some(lines[0]), lines[1])));
    }

    /// Nothing that is written makes the search go on or panic, and JSON without such a key has
    /// none.
    #[test]
    fn any_text_is_searched(text in "[\\[\\]{}\":,a\\\\u0 \n=]{0,40}") {
        let _found = Twice::in_json(&text);
        if let Err(error) = toml::from_str::<toml::Table>(&text) {
            let _found = Twice::in_toml(&text, &error);
        }
        if let Ok(value) = serde_json::from_str::<serde_json::Value>(&text) {
            prop_assert_eq!(Twice::in_json(&value.to_string()), None);
        }
    }
}
