//! What one task has found so far: the union of its jobs, in any order.

use body::BodyView;
use bvh::{Counters, NodePair};
use geometry::hash::splitmix64;
use geometry::{Supports, support::DIRECTIONS};
use protocol::WireSide;
use protocol::result::{Last, read_hit};
use std::collections::BTreeSet;

/// A set of triangles, one bit each.
#[derive(Clone, Debug, Default)]
struct Hits(Vec<u64>);

impl Hits {
    fn with_room(triangles: usize) -> Self {
        Self(vec![0; triangles.div_ceil(64)])
    }

    /// `false` if there is no such triangle: then the message is invalid.
    fn insert(&mut self, triangle: u32) -> bool {
        let word = self.0.get_mut(triangle as usize / 64);
        word.map(|word| *word |= 1 << (triangle % 64)).is_some()
    }

    fn iter(&self) -> impl Iterator<Item = usize> {
        let used = self.0.iter().enumerate().filter(|(_, word)| **word != 0);
        used.flat_map(|(at, word)| {
            let clear_lowest = |rest: &u64| Some(rest & (rest - 1)).filter(|rest| *rest != 0);
            std::iter::successors(Some(*word), clear_lowest)
                .map(move |rest| at * 64 + rest.trailing_zeros() as usize)
        })
    }
}

/// One part of a result, on its way into a task.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Part<'p> {
    /// Hits of this part.
    pub(crate) hits: &'p [u32],
    /// What its job left open, as far as this part says.
    pub(crate) rest: Rest<'p>,
    /// The rest, if it is the last part.
    pub(crate) last: Option<Last<'p>>,
}

/// What a job left open: pairs of nodes.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Rest<'p> {
    /// All pairs, of a job that ran in this process.
    Pairs(&'p [NodePair]),
    /// The pairs in one message, as encoded.
    Words(&'p [u64]),
}

impl Rest<'_> {
    /// Nothing left open, or listed in another part.
    pub(crate) const NONE: Self = Self::Pairs(&[]);
}

/// The union.
#[derive(Clone, Debug)]
pub(crate) struct Gathered {
    hits_a: Hits,
    hits_b: Hits,
    pub(crate) pairs: u64,
    pub(crate) hash: u64,
    pub(crate) supports: Supports,
    pub(crate) zones_a: u16,
    pub(crate) zones_b: u16,
    pub(crate) touched: bool,
}

/// Hit sets as an answer states them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct SetSummary {
    pub(crate) hits_a: u64,
    pub(crate) hits_b: u64,
    pub(crate) hash_a: u64,
    pub(crate) hash_b: u64,
}

impl Gathered {
    pub(crate) fn with_room(triangles_a: usize, triangles_b: usize) -> Self {
        Self {
            hits_a: Hits::with_room(triangles_a),
            hits_b: Hits::with_room(triangles_b),
            pairs: 0,
            hash: 0,
            supports: Supports::EMPTY,
            zones_a: 0,
            zones_b: 0,
            touched: false,
        }
    }

    /// Resets to nothing found, between other bodies.
    pub(crate) fn reset_for(&mut self, triangles_a: usize, triangles_b: usize) {
        let mut hits_a = std::mem::take(&mut self.hits_a);
        let mut hits_b = std::mem::take(&mut self.hits_b);
        for (hits, triangles) in [(&mut hits_a, triangles_a), (&mut hits_b, triangles_b)] {
            hits.0.clear();
            hits.0.resize(triangles.div_ceil(64), 0);
        }
        *self = Self { hits_a, hits_b, ..Self::with_room(0, 0) };
    }

    /// Includes one part. Sets, maxima and unions may be included again; sums come with the last
    /// part, which is included once. `false` if it names a triangle that does not exist.
    pub(crate) fn fold(&mut self, part: Part<'_>, effort: &mut Counters) -> bool {
        let mut sound = true;
        for hit in part.hits {
            sound &= match read_hit(*hit) {
                (WireSide::A, triangle) => self.hits_a.insert(triangle),
                (WireSide::B, triangle) => self.hits_b.insert(triangle),
            };
        }
        self.touched |= !part.hits.is_empty();
        let Some(last) = part.last else { return sound };
        self.pairs += last.summary.pairs;
        self.hash = self.hash.wrapping_add(last.summary.hash);
        self.zones_a |= last.summary.zones_a;
        self.zones_b |= last.summary.zones_b;
        self.touched |= last.summary.pairs > 0;
        effort.add(&Counters { nb: last.summary.nb, np: last.summary.np });
        if let Some(supports) = last.supports {
            const { assert!(protocol::result::SUPPORTS == DIRECTIONS) };
            self.supports.merge(&Supports(*supports));
        }
        sound
    }

    /// Counts and order-free hashes of both hit sets, over source ids.
    pub(crate) fn summary(&self, a: &BodyView<'_>, b: &BodyView<'_>) -> SetSummary {
        summary([&self.hits_a, &self.hits_b], a, b)
    }
}

/// Triangles hit at any of several poses: of A, of B.
#[derive(Clone, Debug, Default)]
pub(crate) struct Union([Hits; 2]);

impl Union {
    /// Resets to nothing hit.
    pub(crate) fn clear(&mut self) {
        self.0.iter_mut().for_each(|hits| hits.0.clear());
    }

    /// Includes the hits of one pose.
    pub(crate) fn include(&mut self, found: &Gathered) {
        for (all, hits) in self.0.iter_mut().zip([&found.hits_a, &found.hits_b]) {
            all.0.resize(all.0.len().max(hits.0.len()), 0);
            all.0.iter_mut().zip(&hits.0).for_each(|(all, hits)| *all |= hits);
        }
    }

    /// Counts and order-free hashes, over source ids.
    pub(crate) fn summary(&self, a: &BodyView<'_>, b: &BodyView<'_>) -> SetSummary {
        summary([&self.0[0], &self.0[1]], a, b)
    }

    /// Numbers of the triangles hit, ascending.
    pub(crate) fn triangles(&self) -> [Vec<u32>; 2] {
        [0, 1].map(|side| self.0[side].iter().map(|triangle| triangle as u32).collect())
    }

    /// Numbers of the parts that they belong to, ascending.
    pub(crate) fn parts(&self, a: &BodyView<'_>, b: &BodyView<'_>) -> [BTreeSet<u16>; 2] {
        let parts_of = |hits: &Hits, body: &BodyView<'_>| {
            hits.iter().filter_map(|triangle| body.part_of.get(triangle).copied()).collect()
        };
        [parts_of(&self.0[0], a), parts_of(&self.0[1], b)]
    }
}

fn summary(hits: [&Hits; 2], a: &BodyView<'_>, b: &BodyView<'_>) -> SetSummary {
    let sum = |hits: &Hits, body: &BodyView<'_>| {
        hits.iter().fold((0_u64, 0_u64), |(count, hash), triangle| {
            let id = u64::from(body.source_ids[triangle]);
            (count + 1, hash.wrapping_add(splitmix64(id)))
        })
    };
    let ((hits_a, hash_a), (hits_b, hash_b)) = (sum(hits[0], a), sum(hits[1], b));
    SetSummary { hits_a, hits_b, hash_a, hash_b }
}
