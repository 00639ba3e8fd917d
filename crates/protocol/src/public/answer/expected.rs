//! What members say of a candidate.

#[cfg(doc)]
use super::flag;
use bytemuck::{Pod, Zeroable};
use core::mem::offset_of;

/// Parties that a candidate meets in some members that an answer has room for: the most probable.
const MET: usize = 8;

/// What members say of a candidate. Two are equal if all their bits are.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct WireExpected {
    /// The share of members in which it meets anybody; where some are open, the least share.
    /// Without members NaN, as the next.
    pub contact: f64,
    /// How many persons are expected to be injured at the policy's level, over open work: lo, hi.
    pub injured: [f64; 2],
    /// Sampling error of the mean of the leading measure, with [`flag::SPREAD`]; else NaN, as the
    /// next three.
    pub error: f64,
    /// What the leading measure is below in 5, 50 and 95 % of the members.
    pub quantiles: [f64; 3],
    /// The share of members in which the candidate is best; where several are equally good, each
    /// has its part.
    pub best: f64,
    /// How much more its leading measure is than that of the best of each member, in the mean.
    pub regret: f64,
    /// The share of worlds that it wins, with [`flag::WORLDS`] of the answer; else NaN.
    pub worlds: f64,
    /// How many members are not followed to their end.
    pub open: u32,
    /// In how many members it was not decided whether the ego and a party lie inside each other at
    /// the start.
    pub undecided: u32,
    /// How many parties it meets in some member; the most probable eight are listed below.
    pub met_count: u32,
    /// 0.
    pub spare: u32,
    /// Whom it meets, the most probable first.
    pub meets: [WireMet; MET],
}

/// A party that a candidate meets in some members.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct WireMet {
    /// Which.
    pub party: u32,
    /// 0.
    pub spare: u32,
    /// The share of members in which it is met; where some are open, the least share.
    pub probability: f64,
    /// The earliest time of contact among them (s).
    pub from_s: f64,
}

impl WireExpected {
    /// Nothing is known: no members were drawn.
    pub const UNKNOWN: Self = Self {
        contact: f64::NAN,
        injured: [f64::NAN; 2],
        error: f64::NAN,
        quantiles: [f64::NAN; 3],
        best: f64::NAN,
        regret: f64::NAN,
        worlds: f64::NAN,
        open: 0,
        undecided: 0,
        met_count: 0,
        spare: 0,
        meets: [WireMet { party: 0, spare: 0, probability: 0.0, from_s: 0.0 }; MET],
    };

    /// The parties that are listed, the most probable first.
    #[must_use]
    pub fn listed(&self) -> &[WireMet] {
        self.meets.get(..self.met_count as usize).unwrap_or(&self.meets)
    }
}

equal_in_every_bit!(WireExpected);

const _: () = {
    assert!(size_of::<WireMet>() == 24 && size_of::<WireExpected>() == 288);
    assert!(offset_of!(WireExpected, open) == 80 && offset_of!(WireExpected, meets) == 96);
};
