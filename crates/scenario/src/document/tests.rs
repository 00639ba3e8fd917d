//! Places are those of an editor, and every path leads to where its key was written.

use super::*;
use proptest::prelude::*;

proptest! {
    #[test]
    fn a_place_is_what_counting_gives(text in "[aé\n\t𝄞]{0,40}", byte in 0_usize..60) {
        let place = Lines::of(&text).place(byte);
        let (mut line, mut column) = (1, 1);
        let inside = text.is_char_boundary(byte);
        for (start, c) in text.char_indices() {
            if inside && start >= byte {
                break;
            }
            (line, column) = if c == '\n' { (line + 1, 1) } else { (line, column + 1) };
        }
        prop_assert_eq!(place, TextPosition { line, column });
    }
}

const TEXT: &str =
    "a = 1\n[b]\nc = [10, { d = 2 }]\n[b.e.f]\ng = 'x'\n[[h]]\ni = 1\n[[h]]\nj.k = 3\n";

fn path(steps: &[&str]) -> Path {
    steps.iter().fold(Path::default(), |path, step| match step.parse() {
        Ok(index) => path.index(index),
        Err(_) => path.key(step),
    })
}

#[test]
fn values_stand_where_they_were_written() {
    let document = Document::parse(TEXT).unwrap_or_else(|_| panic!("valid"));
    for (steps, line, column) in [
        (&["a"] as &[&str], 1, 5),
        (&["b", "c"], 3, 5),
        (&["b", "c", "0"], 3, 6),
        (&["b", "c", "1", "d"], 3, 16),
        (&["b", "e", "f", "g"], 5, 5),
        (&["h", "0"], 6, 1),
        (&["h", "0", "i"], 7, 5),
        (&["h", "1", "j", "k"], 9, 7),
        // What is missing is looked for where its table begins.
        (&["b", "nothing"], 2, 1),
        (&["h", "1", "nothing"], 8, 1),
        (&["b", "c", "7"], 3, 5),
        (&["nothing"], 1, 1),
        (&[], 1, 1),
    ] {
        assert_eq!(document.place(&path(steps)), TextPosition { line, column }, "{steps:?}");
    }
}

#[test]
fn a_span_leads_back_to_its_path() {
    let document = Document::parse(TEXT).unwrap_or_else(|_| panic!("valid"));
    for (written, steps) in [
        ("10", &["b", "c", "0"] as &[&str]),
        ("'x'", &["b", "e", "f", "g"]),
        ("g", &["b", "e", "f", "g"]),
        ("k", &["h", "1", "j", "k"]),
        ("d", &["b", "c", "1", "d"]),
    ] {
        let start = TEXT.find(written).unwrap();
        assert_eq!(document.path_at(&(start..start + written.len())), path(steps), "{written}");
    }
    assert_eq!(document.path_at(&(3..3)), Path::default());
}
