//! Where a key of TOML first stands that the reader found a second time.

use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// What the reader says of a key or table that stands twice.
pub(crate) const DUPLICATE: &str = "duplicate key";
/// Most keys of the same name that are tried, from the nearest on.
const TRIED: usize = 64;

/// Where the key at `second` stood before, in the same table; `None` if it is not found.
///
/// The text before the second key has the first one, and no key twice. If several tables before it
/// have a key of this name, the right one is that without which the reader has no objection: each
/// is renamed in turn, from the nearest on.
pub(crate) fn first(text: &str, second: &Range<usize>) -> Option<Range<usize>> {
    let (before, _cut_short) = DeTable::parse_recoverable(text.get(..second.start)?);
    let name = name(text.get(second.clone())?);
    let mut found = Vec::new();
    let mut open = vec![before.get_ref()];
    let mut values = Vec::new();
    // Ends: the tree is finite, and each table and value is opened once.
    while let Some(table) = open.pop() {
        for (key, value) in table {
            if *key.get_ref() == name {
                found.push(key.span());
            }
            values.push(value);
        }
        while let Some(value) = values.pop() {
            match value.get_ref() {
                DeValue::Table(table) => open.push(table),
                DeValue::Array(items) => values.extend(items.iter()),
                _ => {}
            }
        }
    }
    found.sort_unstable_by_key(|span| std::cmp::Reverse(span.start));
    if let [only] = found.as_slice() {
        return Some(only.clone());
    }
    found.into_iter().take(TRIED).find(|first| is_first(text, first, second))
}

/// The key that a text means, without its quotes.
fn name(written: &str) -> String {
    let line = format!("{} = 0", written.trim());
    let read = DeTable::parse(&line).ok();
    let key = read.as_ref().map(Spanned::get_ref).and_then(|table| table.keys().next());
    key.map_or_else(|| written.trim().to_owned(), |key| key.get_ref().to_string())
}

/// Whether the reader has nothing against the second key if the one at `first` has another name.
fn is_first(text: &str, first: &Range<usize>, second: &Range<usize>) -> bool {
    /// No key of a person is this one, and none is a prefix of it.
    const OTHER: &str = "\"\\u0001 renamed\"";
    let (Some(head), Some(tail)) = (text.get(..first.start), text.get(first.end..)) else {
        return false;
    };
    let renamed = format!("{head}{OTHER}{tail}");
    let moved = second.start - first.end + head.len() + OTHER.len();
    let (_, faults) = DeTable::parse_recoverable(&renamed);
    let is_there = |fault: &toml::de::Error| fault.span().is_some_and(|at| at.start == moved);
    !faults.iter().any(|fault| fault.message() == DUPLICATE && is_there(fault))
}
