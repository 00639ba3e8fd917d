//! Where the last descents of a request's bodies ended, kept from pose to pose and from request to
//! request.

use crate::request::Request;
use bvh::Cut;
use std::collections::BTreeMap;

/// Per pair of bodies, and for the first, second, ... candidate between the same two: a [`Cut`].
///
/// It must not be kept for other bodies, or another depth: it knows neither.
#[derive(Clone, Debug, Default)]
pub struct Cuts(BTreeMap<(u32, u32, usize), Cut>);

impl Cuts {
    /// The cut of a candidate.
    pub(crate) fn of(&mut self, request: &Request, case: usize) -> &mut Cut {
        let candidate = &request.candidates[case];
        let pair = (candidate.model_a, candidate.model_b);
        let before = request.candidates[..case].iter();
        let before = before.filter(|other| (other.model_a, other.model_b) == pair).count();
        self.0.entry((pair.0, pair.1, before)).or_default()
    }
}
