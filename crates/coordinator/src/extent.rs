//! How much memory a request may take, from its limits.
//!
//! The numbers of things come from the limits in the code. What one of each takes was measured,
//! with a margin: `cargo x bounds` holds the sums against running services.

use crate::course::PART_MAX;
use crate::work::SLOTS_MAX;

/// Limits of what is asked for, and the largest bodies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RequestExtent {
    /// Candidates of a request.
    pub candidates: usize,
    /// Its parties, the ego among them.
    pub parties: usize,
    /// States of all of its paths.
    pub states: usize,
    /// Members that it is followed in.
    pub members: usize,
    /// Triangles of the largest body.
    pub triangles: usize,
}

/// A course of a candidate in a member, with its contacts (bytes): it has its flags, its harm and,
/// at most, a contact with each party. Measured: 20 to 30 KiB with its encounters, of 31.
const COURSE_BYTES: usize = 16 << 10;
/// What a course knows of another party (bytes): measured about 1 KiB.
const ENCOUNTER_BYTES: usize = 2 << 10;
/// A state of a path as a member has it (bytes).
const STATE_BYTES: usize = 96;
/// A job that was not handed out, or one that was (bytes): two pairs of nodes, in lists that double
/// as they grow, and the coordinator's record of it.
const JOB_BYTES: usize = 48;
/// Poses at which a contact is surveyed at the same time.
const POSES: usize = 8;

impl RequestExtent {
    /// Bytes of the heap that a request takes at most.
    #[must_use]
    pub fn heap_bytes(&self) -> usize {
        let Self { candidates, parties, states, members, triangles } = *self;
        // The scene as stated is followed besides its members.
        let followed = if members == 1 { 1 } else { members + 1 };
        let course = COURSE_BYTES + parties.saturating_sub(1) * ENCOUNTER_BYTES;
        // Of each contact that is surveyed, a bit for each triangle of both bodies and each pose.
        let surveys = PART_MAX * POSES * 2 * triangles.div_ceil(8);
        followed * (candidates * course + states * STATE_BYTES) + SLOTS_MAX * JOB_BYTES + surveys
    }
}

#[cfg(test)]
mod tests {
    //! More of anything takes more.
    use super::*;

    #[test]
    fn every_limit_counts() {
        let least =
            RequestExtent { candidates: 1, parties: 2, states: 2, members: 1, triangles: 500 };
        let more = [
            RequestExtent { candidates: 2, ..least },
            RequestExtent { parties: 3, ..least },
            RequestExtent { states: 3, ..least },
            RequestExtent { members: 2, ..least },
            RequestExtent { triangles: 600, ..least },
        ];
        assert!(more.iter().all(|more| more.heap_bytes() > least.heap_bytes()));
        assert!(least.heap_bytes() > SLOTS_MAX * JOB_BYTES);
    }
}
