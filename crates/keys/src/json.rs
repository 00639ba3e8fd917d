//! The first key that stands twice in one object of a JSON text.

use std::collections::BTreeMap;
use std::ops::Range;

/// Most objects and lists in each other; the reader's own limit is 128.
const DEPTH_MAX: usize = 128;

/// Both places of the key, with its quotes; `None` if no key stands twice before the text ends or
/// is none of JSON.
pub(crate) fn twice(text: &str) -> Option<[Range<usize>; 2]> {
    let bytes = text.as_bytes();
    // For each open object its keys; `None` for a list.
    let mut open: Vec<Option<BTreeMap<String, Range<usize>>>> = Vec::new();
    let mut at = 0;
    while let Some(&byte) = bytes.get(at) {
        match byte {
            b'{' | b'[' if open.len() == DEPTH_MAX => return None,
            b'{' => open.push(Some(BTreeMap::new())),
            b'[' => open.push(None),
            b'}' | b']' => {
                open.pop()?;
            }
            b'"' => {
                let span = at..string_end(bytes, at)?;
                at = span.end;
                let is_key = bytes[at..].iter().find(|byte| !byte.is_ascii_whitespace());
                if is_key == Some(&b':')
                    && let Some(Some(keys)) = open.last_mut()
                    && let Some(first) = keys.insert(name(text.get(span.clone())?), span.clone())
                {
                    return Some([first, span]);
                }
                continue;
            }
            _ => {}
        }
        at += 1;
    }
    None
}

/// The byte after the closing quote of the string that begins at `start`.
fn string_end(bytes: &[u8], start: usize) -> Option<usize> {
    let mut at = start + 1;
    loop {
        match bytes.get(at)? {
            b'"' => return Some(at + 1),
            b'\\' => at += 2,
            _ => at += 1,
        }
    }
}

/// The key that a string means: with escapes of the usual letters, "\u0061" is "a".
fn name(written: &str) -> String {
    let inner = written.get(1..written.len() - 1).unwrap_or_default();
    let mut name = String::with_capacity(inner.len());
    let mut rest = inner.chars();
    while let Some(c) = rest.next() {
        if c != '\\' {
            name.push(c);
            continue;
        }
        match rest.next() {
            Some('u') => {
                let digits: String = rest.by_ref().take(4).collect();
                let unit = u32::from_str_radix(&digits, 16).ok().and_then(char::from_u32);
                // Half of a pair stays as it is written: equal halves are equal keys all the same.
                match unit {
                    Some(c) => name.push(c),
                    None => name.extend(["\\u", &digits]),
                }
            }
            Some('n') => name.push('\n'),
            Some('r') => name.push('\r'),
            Some('t') => name.push('\t'),
            Some('b') => name.push('\u{8}'),
            Some('f') => name.push('\u{c}'),
            Some(c) => name.push(c),
            None => {}
        }
    }
    name
}
