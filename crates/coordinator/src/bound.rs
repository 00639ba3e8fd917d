//! What the open jobs of one pose may still find: the outer bound of an unfinished task.
//!
//! Where jobs of the pose are done, what they found is the inner bound, and the boxes of the open
//! ones are the outer bound. Where none is done, or too many are open to be examined one by one,
//! the hulls are the outer bound: they hold every possible contact. Bounds depend on which jobs are
//! done, never on when: a replay of the same jobs makes the same bounds.

use crate::gather::Gathered;
use crate::request::Candidate;
use body::BodyView;
use bvh::{NodePair, reach};
use damage::approach::ROUNDING_M;
use damage::{Seen, Stop};
use geometry::{RelativePose, Supports};

/// Maximum number of open jobs of a pose whose boxes are examined one by one.
const BOXES_MAX: usize = 512;

/// A pose that is not done.
pub(crate) struct Open {
    /// What its done jobs have found.
    pub(crate) found: Seen,
    /// What its open jobs may still find.
    pub(crate) reach: Seen,
}

/// What the hulls alone say.
pub(crate) fn hulls(candidate: &Candidate, stop: &Stop, zones: [u16; 2]) -> Seen {
    crate::candidate_state::seen(stop, &candidate.approach.reach_at(stop.travel_m), zones)
}

impl Open {
    /// Nothing found and nothing to be found: not a bound.
    #[cfg(test)]
    pub(crate) fn nothing() -> Self {
        Self { found: Seen::NOTHING, reach: Seen::NOTHING }
    }

    /// A pose of which no job is done.
    pub(crate) fn whole(candidate: &Candidate, stop: &Stop, zones: [u16; 2]) -> Self {
        Self { found: Seen::NOTHING, reach: hulls(candidate, stop, zones) }
    }

    /// A pose of which some jobs are done, and these are open.
    pub(crate) fn partly(
        candidate: &Candidate,
        stop: &Stop,
        (found, open): (&Gathered, &Supports),
        zones: [u16; 2],
    ) -> Self {
        let mut supports = candidate.approach.reach_at(stop.travel_m);
        for (support, most) in supports.0.iter_mut().zip(&open.0) {
            *support = support.min(*most);
        }
        let found_zones = [found.zones_a, found.zones_b];
        Self {
            found: crate::candidate_state::seen(stop, &found.supports, found_zones),
            reach: crate::candidate_state::seen(stop, &supports, zones),
        }
    }
}

/// Supports of what is below open pairs, in A's frame; unbounded where there are too many.
pub(crate) fn boxes(
    candidate: &Candidate,
    bodies: (&BodyView<'_>, &BodyView<'_>),
    pose: &RelativePose,
    count: usize,
    open: impl Iterator<Item = NodePair>,
) -> Supports {
    if count > BOXES_MAX {
        return Supports([f64::INFINITY; geometry::support::DIRECTIONS]);
    }
    let mut supports = Supports::EMPTY;
    for pair in open {
        reach(bodies, pose, pair, &candidate.approach.directions, ROUNDING_M, &mut supports);
    }
    supports
}
