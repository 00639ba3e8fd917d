//! The state of one contact: the poses at which it is surveyed, and what was found there.

use crate::bound::Open;
use crate::gather::{Gathered, SetSummary, Union};
use crate::request::{Candidate, Wanted};
use body::{BodyView, Zones};
use bvh::Witness;
use damage::{Evidence, Seen, Stop, survey};
use geometry::Supports;
use protocol::WireQuestion;

/// The triangles that touch first, and what harm needs of them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FirstContact {
    pub(crate) witness: Witness,
    /// Zones of A's triangle and of B's.
    pub(crate) zones: [Zones; 2],
    /// The point where they touch, as supports in A's frame.
    pub(crate) supports: Supports,
}

/// A finished pose of the survey.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Surveyed {
    pub(crate) sets: SetSummary,
    pub(crate) pairs: u64,
    pub(crate) hash: u64,
    pub(crate) seen: Seen,
}

/// One candidate while its request is worked on.
#[derive(Clone, Debug)]
pub(crate) struct CandidateState {
    /// The first contact; `None`: the bodies overlap from the start, and there is nothing to ask.
    first: Option<FirstContact>,
    /// What the survey is to find.
    wanted: Wanted,
    /// The poses of the survey, and what was found at those that are done.
    pub(crate) stops: Vec<(Stop, Option<Surveyed>)>,
    /// Of the zones that are wanted, those that were hit so far, at any stop.
    found: [u16; 2],
    /// The number of the first stop's task; the others follow.
    first_task: u32,
    /// Triangles hit at any depth.
    pub(crate) hit: Union,
}

impl CandidateState {
    pub(crate) fn new(candidate: &Candidate) -> Self {
        Self::with_buffers(candidate, Union::default(), Vec::new())
    }

    /// The state of another candidate, in the buffers of this one.
    pub(crate) fn reset_for(self, candidate: &Candidate) -> Self {
        let Self { mut hit, mut stops, .. } = self;
        hit.clear();
        stops.clear();
        Self::with_buffers(candidate, hit, stops)
    }

    fn with_buffers(
        candidate: &Candidate,
        hit: Union,
        mut stops: Vec<(Stop, Option<Surveyed>)>,
    ) -> Self {
        let first = (!candidate.is_stuck).then_some(candidate.first);
        let wanted = candidate.wanted;
        if first.is_some() && wanted != Wanted::NOTHING {
            stops.extend(survey(&candidate.approach).into_iter().map(|stop| (stop, None)));
            if wanted != Wanted::Everything {
                // The deepest is most likely to show that all of them are hit.
                stops.reverse();
                stops.iter_mut().for_each(|(stop, _)| stop.patch = false);
            }
        }
        Self { first, wanted, stops, found: [0; 2], first_task: 0, hit }
    }

    /// Asks for all poses of the survey; its tasks are numbered from `task` on.
    pub(crate) fn begin(&mut self, task: u32, asked: &mut Vec<(usize, f64, WireQuestion)>) {
        self.first_task = task;
        for (number, (stop, _)) in self.stops.iter().enumerate() {
            let question = if stop.patch { WireQuestion::Pairs } else { WireQuestion::Sets };
            asked.push((number, stop.travel_m, question));
        }
    }

    /// Notes zones that were hit.
    pub(crate) fn note(&mut self, zones: [u16; 2]) {
        let zones = self.wanted.of(zones);
        self.found.iter_mut().zip(zones).for_each(|(found, zones)| *found |= zones);
    }

    /// Whether nothing that is left to do can show anything that is wanted.
    pub(crate) fn is_obsolete(&self) -> bool {
        matches!(self.wanted, Wanted::Zones(wanted) if wanted.map(|zones| zones.0) == self.found)
    }

    pub(crate) fn surveyed(
        &mut self,
        number: usize,
        found: &Gathered,
        (a, b): (&BodyView<'_>, &BodyView<'_>),
    ) {
        let Some((stop, surveyed)) = self.stops.get_mut(number) else { return };
        let zones = self.wanted.of([found.zones_a, found.zones_b]);
        let seen = seen(stop, &found.supports, zones);
        let mut sets = SetSummary::default();
        if self.wanted == Wanted::Everything {
            sets = found.summary(a, b);
            self.hit.include(found);
        }
        *surveyed = Some(Surveyed { sets, pairs: found.pairs, hash: found.hash, seen });
    }

    /// What is known of the contact so far. `open` gives, for a stop whose task is not done, what
    /// it has found and what it may still find.
    pub(crate) fn evidence(&self, mut open: impl FnMut(u32, &Stop) -> Open) -> Evidence {
        let Some(FirstContact { witness, zones: [zones_a, zones_b], supports }) = self.first else {
            return Evidence::none();
        };
        let mut evidence = Evidence::none();
        // Contact may be so slight, or so brief, that no pose of the survey meets it.
        let seen = Seen { patch: supports, zones_a, zones_b };
        evidence.add_hits(witness.travel_m, &seen);
        if self.is_obsolete() {
            let [zones_a, zones_b] = self.found.map(Zones);
            evidence.add_hits(witness.travel_m, &Seen { zones_a, zones_b, ..Seen::NOTHING });
            return evidence;
        }
        for (number, (stop, surveyed)) in self.stops.iter().enumerate() {
            if let Some(surveyed) = surveyed {
                evidence.add_hits(stop.travel_m, &surveyed.seen);
                continue;
            }
            let Open { found, reach } = open(self.first_task + number as u32, stop);
            evidence.add_hits(stop.travel_m, &found);
            evidence.add_open(stop.travel_m, &reach);
        }
        evidence
    }
}

/// Hits or reach at a stop, as far as they count there.
pub(crate) fn seen(stop: &Stop, supports: &Supports, zones: [u16; 2]) -> Seen {
    let [zones_a, zones_b] = zones.map(Zones);
    Seen { patch: if stop.patch { *supports } else { Supports::EMPTY }, zones_a, zones_b }
}
