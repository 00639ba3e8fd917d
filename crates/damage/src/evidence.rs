//! What is known of the contact of one candidate: from hits, and from the work still open.
//!
//! Inner is what hits have shown; outer is what hits and open work together can still show. Merging
//! takes maxima and unions, so it depends neither on order nor on repetition, and as open work
//! turns into hits the inner grows and the outer shrinks: every interval made from it only nests.
//!
//! Supports of hits at different poses are put together in the frame that stands half way between A
//! and B: at travel s, A's frame is moved by `½·u·s` in it. In A's own frame the same patch would
//! have another length than in B's, and swapping the parties would change the answer.
//!
//! It does not know where the hulls are: [`crate::contact`] combines the two.

use crate::approach::{HORIZONTAL, cosine};
use crate::interval::Interval;
use body::Zones;
use geometry::Supports;
use geometry::support::DIRECTIONS;

/// What hits, or open work, cover: supports of the patch and of the last pose, and zones.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seen {
    /// The patch.
    pub patch: Supports,
    /// Zones of A hit.
    pub zones_a: Zones,
    /// Zones of B hit.
    pub zones_b: Zones,
}

/// What is known of the contact of one candidate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Evidence {
    inner: Seen,
    outer: Seen,
    is_open: bool,
}

impl Seen {
    /// Nothing.
    pub const NOTHING: Self = Self { patch: Supports::EMPTY, zones_a: Zones(0), zones_b: Zones(0) };

    fn merge(&mut self, other: &Self) {
        self.patch.merge(&other.patch);
        self.zones_a.0 |= other.zones_a.0;
        self.zones_b.0 |= other.zones_b.0;
    }

    /// The same supports in the frame half way between A and B.
    fn half_way(&self, travel_m: f64) -> Self {
        let moved = |s: &Supports| {
            let mut s = *s;
            for (i, support) in s.0.iter_mut().enumerate().take(HORIZONTAL) {
                *support += 0.5 * travel_m * cosine(i);
            }
            s
        };
        Self { patch: moved(&self.patch), ..*self }
    }
}

impl Evidence {
    /// No hit, no open work.
    #[must_use]
    pub fn none() -> Self {
        Self { inner: Seen::NOTHING, outer: Seen::NOTHING, is_open: false }
    }

    /// Adds hits at a pose, in A's frame at that pose.
    pub fn add_hits(&mut self, travel_m: f64, hits: &Seen) {
        let hits = hits.half_way(travel_m);
        self.inner.merge(&hits);
        self.outer.merge(&hits);
    }

    /// Adds what a piece of open work at a pose can reach at most, in A's frame at that pose.
    pub fn add_open(&mut self, travel_m: f64, reach: &Seen) {
        self.outer.merge(&reach.half_way(travel_m));
        self.is_open = true;
    }

    /// Notes that open work may find contact anywhere that the hulls allow, in any zone: for work
    /// that is not cut into jobs yet, or whose bounds are lost.
    pub fn add_open_everywhere(&mut self) {
        let zones = Zones(u16::MAX);
        let anywhere = Supports([f64::INFINITY; DIRECTIONS]);
        let all = Seen { patch: anywhere, zones_a: zones, zones_b: zones };
        self.outer.merge(&all);
        self.is_open = true;
    }

    /// Includes all that `other` knows.
    pub fn merge(&mut self, other: &Self) {
        self.inner.merge(&other.inner);
        self.outer.merge(&other.outer);
        self.is_open |= other.is_open;
    }

    /// Whether work is still open.
    #[must_use]
    pub fn is_open(&self) -> bool {
        self.is_open
    }

    /// Zones hit: of A, of B.
    #[must_use]
    pub fn zones(&self) -> [Zones; 2] {
        [self.inner.zones_a, self.inner.zones_b]
    }

    /// Zones that may be hit: of A, of B.
    #[must_use]
    pub fn zones_at_most(&self) -> [Zones; 2] {
        [self.outer.zones_a, self.outer.zones_b]
    }

    /// The middle of the patch between two opposed directions (m), half-way frame.
    ///
    /// `reach` bounds the patch independently of the jobs ([`crate::Approach::reach`]).
    pub(crate) fn middle(&self, plus: usize, minus: usize, reach: &Supports) -> f64 {
        let ([in_plus, in_minus], [out_plus, out_minus]) =
            self.ends(|seen| &seen.patch, plus, minus, reach);
        let [most, least] = if in_plus.is_finite() && in_minus.is_finite() {
            [in_plus, -in_minus]
        } else {
            [out_plus, -out_minus]
        };
        0.5 * (most + least)
    }

    /// The length of the patch between two opposed directions (m).
    pub(crate) fn span(&self, plus: usize, minus: usize, reach: &Supports) -> Interval {
        self.length(|seen| &seen.patch, plus, minus, reach)
    }

    fn length(
        &self,
        of: impl Fn(&Seen) -> &Supports,
        plus: usize,
        minus: usize,
        reach: &Supports,
    ) -> Interval {
        let ([in_plus, in_minus], [out_plus, out_minus]) = self.ends(of, plus, minus, reach);
        let least = in_plus + in_minus;
        let least = if least.is_finite() { least.max(0.0) } else { 0.0 };
        Interval::new(least, (out_plus + out_minus).max(least))
    }

    /// Inner and outer supports in two opposed directions; without open work they are the same
    /// bits.
    fn ends(
        &self,
        of: impl Fn(&Seen) -> &Supports,
        plus: usize,
        minus: usize,
        reach: &Supports,
    ) -> ([f64; 2], [f64; 2]) {
        let inner = [of(&self.inner).0[plus], of(&self.inner).0[minus]];
        if !self.is_open && has_points(of(&self.inner)) {
            return (inner, inner);
        }
        let outer = [plus, minus].map(|i| {
            let (open, hits) = (of(&self.outer).0[i], of(&self.inner).0[i]);
            // A patch without points gives no bound: then the hulls alone bound it.
            let open = if open.is_finite() { open.min(reach.0[i]) } else { reach.0[i] };
            open.max(hits)
        });
        (inner, outer)
    }
}

fn has_points(supports: &Supports) -> bool {
    supports.0.iter().all(|s| s.is_finite())
}

#[cfg(test)]
mod tests;
