//! What a worker returns: the hits of one job, in one or several parts.
//!
//! A part contains only hits; the last part ends with the job's [`Summary`] and, for a question
//! about pairs, its supports: a worker writes hits straight into shared memory before it knows
//! which part will be the last. A hit is a triangle in leaf order with its body in the top bit,
//! each at most once per job; two of them share a word.
//!
//! ```text
//! words of a part:      [hit | hit << 32]...
//! words of the last:    [hit | hit << 32]... [Summary] ([f64; SUPPORTS] if pairs were asked for)
//!                       [Summary] [WireSeen] if it was a look at bodies on their ways
//! words of a rest:      [number of the first pair] [node of A | node of B << 32]...
//! ```
//!
//! A job that exhausts its budget reports what it left open, as pairs of nodes, before its last
//! part.

use bytemuck::{Pod, Zeroable};

/// Number of supports that a job on pairs returns: one per direction of measurement.
pub const SUPPORTS: usize = 74;

/// Words of a [`Summary`].
pub const SUMMARY_WORDS: usize = size_of::<Summary>() / 8;

/// Words that must stay free after the hits of a part, so that it can become the last.
pub const TAIL_WORDS: usize = SUMMARY_WORDS + SUPPORTS;

/// The body of a hit triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WireSide {
    /// The ego.
    A,
    /// The opposing body.
    B,
}

/// Statistics of a finished job: 64 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct Summary {
    /// Box-pair tests.
    pub nb: u64,
    /// Triangle-pair tests.
    pub np: u64,
    /// Intersecting pairs (at most one for [`crate::WireQuestion::Touches`]).
    pub pairs: u64,
    /// Wrapping sum of splitmix64(source id in A << 32 | source id in B) over them.
    pub hash: u64,
    /// Time from start to end of the job (ns), monotonic.
    pub wall_ns: u64,
    /// Zones of A's hit triangles.
    pub zones_a: u16,
    /// Zones of B's hit triangles.
    pub zones_b: u16,
    /// How it ended: an [`WireEnd`].
    pub end: u32,
    /// Supports that follow: 0 or [`SUPPORTS`]; or [`SEEN_WORDS`] of a [`WireSeen`].
    pub supports: u32,
    /// Hits in all parts together.
    pub hits: u32,
    /// Pairs of nodes left open, in all parts together; 0 unless it ran out of budget.
    pub rest: u64,
}

const _: () = assert!(size_of::<Summary>() == 64);

/// What a look at bodies on their ways showed: 64 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct WireSeen {
    /// A [`SeenKind`]; of all but contacts the rest is 0.
    pub kind: u32,
    /// 1 if triangles touch at that time; else they come as near as the resolution.
    pub is_certain: u32,
    /// When (s).
    pub time_s: f64,
    /// Nothing touches before (s).
    pub excluded_before_s: f64,
    /// Numbers of the two triangles in leaf order.
    pub triangles: [u32; 2],
    /// Where they touch, in A's frame (m).
    pub point: [f64; 3],
    /// Their source ids.
    pub ids: [u32; 2],
}

/// What was seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum SeenKind {
    /// They never touch in that time.
    Never = 1,
    /// The first contact.
    Contact = 2,
    /// They have touched before, and do so still.
    Still = 3,
    /// They have touched before; no triangle does any more, and one may lie inside the other.
    Hidden = 4,
}

impl SeenKind {
    /// The kind with this number.
    #[must_use]
    pub fn from_number(number: u32) -> Option<Self> {
        let all = [Self::Never, Self::Contact, Self::Still, Self::Hidden];
        all.into_iter().find(|kind| *kind as u32 == number)
    }
}

/// Words of a [`WireSeen`].
pub const SEEN_WORDS: usize = size_of::<WireSeen>() / 8;

const _: () = assert!(size_of::<WireSeen>() == 64 && SEEN_WORDS < SUPPORTS);

/// How a job ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum WireEnd {
    /// Everything that the question requires was tested.
    Complete = 1,
    /// The budget was spent; what is left is open.
    OutOfBudget = 2,
}

impl WireEnd {
    /// The end with this number.
    #[must_use]
    pub fn from_number(number: u32) -> Option<Self> {
        [Self::Complete, Self::OutOfBudget].into_iter().find(|end| *end as u32 == number)
    }
}

/// Encodes a hit triangle for the wire. `triangle` must be below 2³¹.
#[must_use]
pub const fn hit(side: WireSide, triangle: u32) -> u32 {
    match side {
        WireSide::A => triangle,
        WireSide::B => triangle | 1 << 31,
    }
}

/// Decodes the triangle of a hit.
#[must_use]
pub const fn read_hit(hit: u32) -> (WireSide, u32) {
    (if hit >> 31 == 0 { WireSide::A } else { WireSide::B }, hit & 0x7fff_ffff)
}

/// The decoded last part of a result.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Last<'a> {
    /// Statistics of the job.
    pub summary: Summary,
    /// Supports, for a question about pairs.
    pub supports: Option<&'a [f64; SUPPORTS]>,
    /// What a look showed.
    pub seen: Option<WireSeen>,
    /// Hits of this part.
    pub hits: &'a [u32],
}

/// Decodes the last part of a result; `None` if counts and words do not match.
#[must_use]
pub fn read_last(words: &[u64], hits: u32) -> Option<Last<'_>> {
    let (hit_words, rest) = words.split_at_checked((hits as usize).div_ceil(2))?;
    let (summary, rest) = rest.split_at_checked(SUMMARY_WORDS)?;
    let summary: Summary = bytemuck::pod_read_unaligned(bytemuck::cast_slice(summary));
    WireEnd::from_number(summary.end)?;
    let (mut supports, mut seen) = (None, None);
    match (summary.supports as usize, rest.len()) {
        (0, 0) => {}
        (SUPPORTS, SUPPORTS) => {
            let words: &[f64] = bytemuck::try_cast_slice(rest).ok()?;
            supports = Some(words.try_into().ok()?);
        }
        (SEEN_WORDS, SEEN_WORDS) => {
            seen = Some(bytemuck::pod_read_unaligned(bytemuck::cast_slice(rest)));
        }
        _ => return None,
    }
    Some(Last { summary, supports, seen, hits: read_hits(hit_words, hits)? })
}

/// The hits of a part; `None` if they do not match the number of words.
#[must_use]
pub fn read_hits(words: &[u64], hits: u32) -> Option<&[u32]> {
    let halves: &[u32] = bytemuck::try_cast_slice(words).ok()?;
    let hits = hits as usize;
    (words.len() == hits.div_ceil(2)).then(|| halves.get(..hits)).flatten()
}

/// Writes pairs of nodes as a rest, from number `first` on, as many as fit. Returns their number;
/// they take one word each, plus one.
pub fn write_rest(
    words: &mut [u64],
    first: usize,
    pairs: impl IntoIterator<Item = (u32, u32)>,
) -> usize {
    let Some((number, room)) = words.split_first_mut() else { return 0 };
    *number = first as u64;
    let mut count = 0;
    for (word, (a, b)) in room.iter_mut().zip(pairs) {
        *word = u64::from(a) | u64::from(b) << 32;
        count += 1;
    }
    count
}

/// Decodes the number of the first pair of a rest, and its pairs of nodes; `None` if their number
/// does not match.
#[must_use]
pub fn read_rest(
    words: &[u64],
    count: u32,
) -> Option<(u64, impl Iterator<Item = (u32, u32)> + Clone)> {
    let (first, pairs) = words.split_first()?;
    let read = |word: &u64| ((word & 0xffff_ffff) as u32, (word >> 32) as u32);
    (pairs.len() == count as usize).then(|| (*first, pairs.iter().map(read)))
}

/// Writes hit number `at` of a part, counted from 0; hits are written in order.
///
/// Returns `false`, writing nothing, if it does not fit with [`TAIL_WORDS`] left free.
pub fn write_hit(words: &mut [u64], at: usize, hit: u32) -> bool {
    if at / 2 + 1 + TAIL_WORDS > words.len() {
        return false;
    }
    if at.is_multiple_of(2) {
        words[at / 2] = u64::from(hit);
    } else {
        words[at / 2] |= u64::from(hit) << 32;
    }
    true
}

/// Turns a part of `hits` hits into the last one; returns its total number of words.
///
/// # Panics
///
/// [`TAIL_WORDS`] were not left free: [`write_hit`] ensures it.
pub fn write_last(
    words: &mut [u64],
    hits: usize,
    summary: &Summary,
    supports: Option<&[f64; SUPPORTS]>,
) -> usize {
    let at = hits.div_ceil(2);
    let summary =
        Summary { supports: supports.map_or(0, |supports| supports.len() as u32), ..*summary };
    words[at..at + SUMMARY_WORDS].copy_from_slice(bytemuck::cast_slice(&[summary]));
    let at = at + SUMMARY_WORDS;
    let Some(supports) = supports else { return at };
    words[at..at + SUPPORTS].copy_from_slice(bytemuck::cast_slice(supports));
    at + SUPPORTS
}

/// Writes the only part of a look, which has no hits; returns its number of words.
///
/// # Panics
///
/// [`TAIL_WORDS`] do not fit.
pub fn write_seen(words: &mut [u64], summary: &Summary, seen: &WireSeen) -> usize {
    let summary = Summary { supports: SEEN_WORDS as u32, ..*summary };
    words[..SUMMARY_WORDS].copy_from_slice(bytemuck::cast_slice(&[summary]));
    let end = SUMMARY_WORDS + SEEN_WORDS;
    words[SUMMARY_WORDS..end].copy_from_slice(bytemuck::cast_slice(&[*seen]));
    end
}

#[cfg(test)]
mod tests;
