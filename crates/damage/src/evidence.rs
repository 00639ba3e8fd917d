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
use serde::Serialize;

/// Whether the bodies touch.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Touch {
    /// All poses are done and none has a hit.
    No,
    /// There is a hit.
    Yes,
    /// No hit yet, and work is open.
    Unknown,
}

/// What hits, or open work, cover: supports of the patch and of the last pose, and zones.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seen {
    /// The patch, poses f..r.
    pub patch: Supports,
    /// The pose e alone; empty where it was not asked for.
    pub end: Supports,
    /// Zones of A hit, poses f..e.
    pub zones_a: Zones,
    /// Zones of B hit, poses f..e.
    pub zones_b: Zones,
}

/// What is known of the contact of one candidate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Evidence {
    inner: Seen,
    outer: Seen,
    is_open: bool,
    is_patch_open: bool,
    has_touched: bool,
    first_m: (f64, f64),
}

impl Seen {
    /// Nothing.
    pub const NOTHING: Self =
        Self { patch: Supports::EMPTY, end: Supports::EMPTY, zones_a: Zones(0), zones_b: Zones(0) };

    fn merge(&mut self, other: &Self) {
        self.patch.merge(&other.patch);
        self.end.merge(&other.end);
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
        Self { patch: moved(&self.patch), end: moved(&self.end), ..*self }
    }
}

impl Evidence {
    /// No hit, no open work; first contact, if any, at a travel between these two (m). This is the
    /// evidence of bodies that do not touch.
    #[must_use]
    pub fn none(first_m: (f64, f64)) -> Self {
        Self {
            inner: Seen::NOTHING,
            outer: Seen::NOTHING,
            is_open: false,
            is_patch_open: false,
            has_touched: false,
            first_m,
        }
    }

    /// Notes that some pose is known to touch, before its patch is known.
    pub fn touched(&mut self) {
        self.has_touched = true;
    }

    /// Adds hits at a pose, in A's frame at that pose. Only for poses that count wherever the first
    /// contact turns out to be.
    pub fn add_hits(&mut self, travel_m: f64, hits: &Seen) {
        let hits = hits.half_way(travel_m);
        self.inner.merge(&hits);
        self.outer.merge(&hits);
        self.has_touched |= has_points(&hits.patch);
    }

    /// Adds what a piece of open work at a pose can reach at most, in A's frame at that pose.
    pub fn add_open(&mut self, travel_m: f64, reach: &Seen) {
        self.outer.merge(&reach.half_way(travel_m));
        self.is_open = true;
        self.is_patch_open |= reach.patch != Supports::EMPTY;
    }

    /// Notes that open work may find contact anywhere that the hulls allow, in any zone: for work
    /// that is not cut into jobs yet, or whose bounds are lost.
    pub fn add_open_everywhere(&mut self) {
        let zones = Zones(u16::MAX);
        let anywhere = Supports([f64::INFINITY; DIRECTIONS]);
        let all = Seen { patch: anywhere, end: anywhere, zones_a: zones, zones_b: zones };
        self.outer.merge(&all);
        self.is_open = true;
        self.is_patch_open = true;
    }

    /// Includes all that `other` knows. Both must know the same bracket of the first contact, or
    /// the narrower one counts.
    pub fn merge(&mut self, other: &Self) {
        self.inner.merge(&other.inner);
        self.outer.merge(&other.outer);
        self.is_open |= other.is_open;
        self.is_patch_open |= other.is_patch_open;
        self.has_touched |= other.has_touched;
        let (from, to) = (self.first_m.0.max(other.first_m.0), self.first_m.1.min(other.first_m.1));
        self.first_m = (from, to.max(from));
    }

    /// Whether the bodies touch.
    #[must_use]
    pub fn touch(&self) -> Touch {
        match (self.has_touched, self.is_open) {
            (true, _) => Touch::Yes,
            (false, true) => Touch::Unknown,
            (false, false) => Touch::No,
        }
    }

    /// Whether work is still open.
    #[must_use]
    pub fn is_open(&self) -> bool {
        self.is_open
    }

    /// Whether open work may still change the patch, and with it a figure that ranks by the work
    /// interval; zones and depth alone cannot.
    #[must_use]
    pub fn is_patch_open(&self) -> bool {
        self.is_patch_open
    }

    /// Between which travels the first contact lies (m).
    #[must_use]
    pub fn first_m(&self) -> (f64, f64) {
        self.first_m
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
    pub(crate) fn middle(&self, plus: usize, minus: usize, reach: &Supports) -> Interval {
        let ([in_plus, in_minus], [out_plus, out_minus]) =
            self.ends(|seen| &seen.patch, plus, minus, reach);
        if in_plus.is_finite() && in_minus.is_finite() {
            return Interval::new(0.5 * (in_plus - out_minus), 0.5 * (out_plus - in_minus));
        }
        Interval::new(-out_minus, out_plus)
    }

    /// The length of the patch between two opposed directions (m).
    pub(crate) fn span(&self, plus: usize, minus: usize, reach: &Supports) -> Interval {
        self.length(|seen| &seen.patch, plus, minus, reach)
    }

    /// The length of the hits at the last pose between two opposed directions (m).
    pub(crate) fn end_span(&self, plus: usize, minus: usize, reach: &Supports) -> Interval {
        if !self.is_open && !has_points(&self.inner.end) {
            return Interval::ZERO;
        }
        self.length(|seen| &seen.end, plus, minus, reach)
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
