//! The two kinds of interval that every figure carries, as two types, so that they cannot be mixed.
//!
//! [`Interval`] is a proven bound: nominal parameters, and whatever the unfinished jobs may still
//! find. Its width is 0 when all jobs are done; it alone decides the order and how finished an
//! answer is. [`Range`] is an expert judgement of the model: parameters and curves at the worst end
//! of the open work. It proves nothing; it alone decides whether a difference is certain or a tie.
//!
//! Both are closed, ordered and free of NaN and of −0.0. Neither knows its unit: the field does.

use schemars::JsonSchema;
use serde::Serialize;

/// The work interval `[lo, hi]`: holds the value that the finished run will have.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, JsonSchema)]
#[serde(into = "[f64; 2]")]
// JSON has no infinity: an end without bound is null.
#[schemars(with = "[Option<f64>; 2]")]
pub struct Interval {
    lo: f64,
    hi: f64,
}

/// The model range `[low, high]`: an expert range around a work interval.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, JsonSchema)]
#[serde(into = "[f64; 2]")]
// JSON has no infinity: an end without bound is null.
#[schemars(with = "[Option<f64>; 2]")]
pub struct Range {
    low: f64,
    high: f64,
}

/// Orders two ends, turns NaN into the widest end and −0.0 into +0.0.
fn ends(a: f64, b: f64) -> (f64, f64) {
    let lo = if a.is_nan() { f64::NEG_INFINITY } else { a };
    let hi = if b.is_nan() { f64::INFINITY } else { b };
    (lo.min(hi) + 0.0, lo.max(hi) + 0.0)
}

impl Interval {
    /// Exactly zero.
    pub const ZERO: Self = Self { lo: 0.0, hi: 0.0 };

    /// The interval between two ends, in any order.
    #[must_use]
    pub fn new(a: f64, b: f64) -> Self {
        let (lo, hi) = ends(a, b);
        Self { lo, hi }
    }

    /// One value, certain.
    #[must_use]
    pub fn exactly(value: f64) -> Self {
        Self::new(value, value)
    }

    /// The lower end.
    #[must_use]
    pub fn lo(self) -> f64 {
        self.lo
    }

    /// The upper end.
    #[must_use]
    pub fn hi(self) -> f64 {
        self.hi
    }

    /// Whether no open work can move the value.
    #[must_use]
    pub fn is_settled(self) -> bool {
        self.lo.to_bits() == self.hi.to_bits()
    }

    /// Whether `value` lies inside.
    #[must_use]
    pub fn contains(self, value: f64) -> bool {
        self.lo <= value && value <= self.hi
    }

    /// The least interval that holds both.
    #[must_use]
    pub fn hull(self, other: Self) -> Self {
        Self { lo: self.lo.min(other.lo), hi: self.hi.max(other.hi) }
    }

    /// Whether `other` lies wholly inside.
    #[must_use]
    pub fn holds(self, other: Self) -> bool {
        self.lo <= other.lo && other.hi <= self.hi
    }

    /// Both ends through a function that never falls.
    #[must_use]
    pub fn map(self, rising: impl Fn(f64) -> f64) -> Self {
        Self::new(rising(self.lo), rising(self.hi))
    }

    /// This interval as a probability: capped at 1.
    #[must_use]
    pub fn below_one(self) -> Self {
        self.map(|x| x.min(1.0))
    }

    /// `|x − y|` over all x in this and y in the other interval.
    #[must_use]
    pub fn distance(self, other: Self) -> Self {
        let least = (self.lo - other.hi).max(other.lo - self.hi).max(0.0);
        Self::new(least, (self.hi - other.lo).max(other.hi - self.lo))
    }
}

impl Range {
    /// Exactly zero.
    pub const ZERO: Self = Self { low: 0.0, high: 0.0 };

    /// The range between two ends, in any order.
    #[must_use]
    pub fn new(a: f64, b: f64) -> Self {
        let (low, high) = ends(a, b);
        Self { low, high }
    }

    /// The lower end.
    #[must_use]
    pub fn low(self) -> f64 {
        self.low
    }

    /// The upper end.
    #[must_use]
    pub fn high(self) -> f64 {
        self.high
    }

    /// This range, widened where needed so that it contains `work`, as it must.
    #[must_use]
    pub fn around(self, work: Interval) -> Self {
        Self { low: self.low.min(work.lo), high: self.high.max(work.hi) }
    }
}

impl From<Interval> for [f64; 2] {
    fn from(work: Interval) -> Self {
        [work.lo, work.hi]
    }
}

impl From<Range> for [f64; 2] {
    fn from(range: Range) -> Self {
        [range.low, range.high]
    }
}

#[cfg(test)]
mod tests;
