//! One pass over a text, which counts what the parser would find and stops at the first excess.
//!
//! Where the text is no XML, counts may be wrong: the parser stops there.

use super::{ATTRIBUTES_MAX, DEPTH_MAX, NAMESPACES_MAX};

/// What there is too much of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Excess {
    /// Attributes of one element.
    Attributes,
    /// Elements in each other.
    Depth,
    /// Declarations of namespaces.
    Namespaces,
    /// Elements.
    Elements,
    /// Attributes of all elements.
    AttributesInAll,
}

/// What was counted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Counts {
    pub(crate) elements: usize,
    pub(crate) attributes: usize,
    /// Of the element that has most.
    pub(crate) attributes_of_one: usize,
    /// Elements in each other, at most.
    pub(crate) depth: usize,
    pub(crate) namespaces: usize,
}

/// Counts, or returns the byte at which a limit is exceeded.
pub(crate) fn scan(text: &str, nodes_max: usize) -> Result<Counts, (usize, Excess)> {
    let bytes = text.as_bytes();
    let mut counts = Counts::default();
    let (mut at, mut depth) = (0, 0_usize);
    while let Some(open) = after(text, at, "<").map(|after| after - 1) {
        let rest = &bytes[open..];
        let end = if rest.starts_with(b"<!--") {
            after(text, open + 4, "-->")
        } else if rest.starts_with(b"<![CDATA[") {
            after(text, open + 9, "]]>")
        } else if rest.starts_with(b"<!") {
            // The parser refuses every other declaration.
            None
        } else if rest.starts_with(b"<?") {
            after(text, open + 2, "?>")
        } else if rest.starts_with(b"</") {
            depth = depth.saturating_sub(1);
            after(text, open + 2, ">")
        } else {
            counts.elements += 1;
            if counts.elements > nodes_max {
                return Err((open, Excess::Elements));
            }
            let end = start_tag(bytes, open, nodes_max, &mut counts)?;
            // A tag that ends with /> is closed at once, but is as deep as any other.
            counts.depth = counts.depth.max(depth + 1);
            if depth + 1 > DEPTH_MAX {
                return Err((open, Excess::Depth));
            }
            let is_empty = end.is_some_and(|end| bytes[end - 2] == b'/');
            depth += usize::from(!is_empty);
            end
        };
        let Some(end) = end else { break };
        at = end;
    }
    Ok(counts)
}

/// The byte after the next `what`.
fn after(text: &str, from: usize, what: &str) -> Option<usize> {
    // A comment may be cut short by the end, and a tag by a character of several bytes.
    Some(from + text.get(from..)?.find(what)? + what.len())
}

/// The byte after a start tag, which begins at `open`; `None` if it does not end.
fn start_tag(
    bytes: &[u8],
    open: usize,
    nodes_max: usize,
    counts: &mut Counts,
) -> Result<Option<usize>, (usize, Excess)> {
    let (mut at, mut attributes) = (open + 1, 0);
    while let Some(byte) = bytes.get(at) {
        match byte {
            b'>' => return Ok(Some(at + 1)),
            // Each attribute has one value, and each value is quoted.
            b'"' | b'\'' => {
                attributes += 1;
                counts.attributes += 1;
                counts.attributes_of_one = counts.attributes_of_one.max(attributes);
                if attributes > ATTRIBUTES_MAX {
                    return Err((open, Excess::Attributes));
                }
                if counts.attributes > nodes_max {
                    return Err((open, Excess::AttributesInAll));
                }
                let value = &bytes[at + 1..];
                let Some(length) = value.iter().position(|end| end == byte) else {
                    return Ok(None);
                };
                at += length + 2;
            }
            b'x' if bytes[at - 1].is_ascii_whitespace() && bytes[at..].starts_with(b"xmlns") => {
                counts.namespaces += 1;
                if counts.namespaces > NAMESPACES_MAX {
                    return Err((open, Excess::Namespaces));
                }
                at += 5;
            }
            _ => at += 1,
        }
    }
    Ok(None)
}
