//! The state of one candidate: find first contact, then survey the crush path from there.
//!
//! Which tasks follow depends on what earlier ones found, never on the order in which their jobs
//! were done: first contact is a minimum over all pairs of triangles.

use crate::bound::Open;
use crate::gather::{Gathered, SetSummary, Union};
use crate::request::Candidate;
use body::{BodyView, Zones};
use bvh::Witness;
use damage::{Evidence, Meeting, Seen, Stop};
use geometry::Supports;
use protocol::WireQuestion;

/// What a task is for.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Purpose {
    /// When do the bodies first touch, and where?
    FirstContact,
    /// What is hit at this stop of the survey?
    Survey { stop: usize },
}

/// What is known of the travel at first contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bracket {
    /// Before this travel nothing touches (m).
    pub(crate) from_m: f64,
    /// After it first contact is not (m): something touches then, or the path ends.
    pub(crate) to_m: f64,
    /// Whether something is known to touch.
    pub(crate) has_touched: bool,
}

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

/// How far the search of a candidate has come.
#[derive(Clone, Debug)]
#[expect(clippy::large_enum_variant, reason = "a box would come from the heap on every request")]
pub(crate) enum SearchStage {
    /// Nothing to search: the hulls never meet, or overlap from the start.
    Settled,
    /// First contact is sought; `is_asked`: there is a task for it.
    Searching { bracket: Bracket, is_asked: bool },
    /// First contact is known, or known not to exist. `task` is the number of the first stop's
    /// task; the others follow.
    Surveying {
        first: Option<FirstContact>,
        bracket: Bracket,
        stops: Vec<(Stop, Option<Surveyed>)>,
        task: u32,
    },
}

/// One candidate while its request is worked on.
#[derive(Clone, Debug)]
pub(crate) struct CandidateState {
    pub(crate) stage: SearchStage,
    /// Triangles hit from first contact to e.
    pub(crate) hit: Union,
    /// The list of stops of an earlier request, reused for this one.
    spare: Vec<(Stop, Option<Surveyed>)>,
}

impl CandidateState {
    pub(crate) fn new(candidate: &Candidate) -> Self {
        Self::with_buffers(candidate, Union::default(), Vec::new())
    }

    /// The state of another candidate, in the buffers of this one.
    pub(crate) fn reset_for(self, candidate: &Candidate) -> Self {
        let Self { stage, mut hit, mut spare } = self;
        hit.clear();
        if let SearchStage::Surveying { stops, .. } = stage {
            spare = stops;
            spare.clear();
        }
        Self::with_buffers(candidate, hit, spare)
    }

    fn with_buffers(
        candidate: &Candidate,
        hit: Union,
        spare: Vec<(Stop, Option<Surveyed>)>,
    ) -> Self {
        let stage = match &candidate.meeting {
            Meeting::Path(path) => {
                let (from_m, to_m) = (path.from_m, path.to_m);
                let bracket = Bracket { from_m, to_m, has_touched: false };
                SearchStage::Searching { bracket, is_asked: false }
            }
            Meeting::Never(_) | Meeting::AlreadyOverlapping => SearchStage::Settled,
        };
        Self { stage, hit, spare }
    }

    /// The tasks that are needed first, if they were not asked for yet; they are numbered from
    /// `task` on.
    pub(crate) fn begin(
        &mut self,
        candidate: &Candidate,
        task: u32,
        purposes: &mut Vec<(Purpose, f64, WireQuestion)>,
    ) {
        if candidate.first.is_some() {
            return self.settle(candidate, candidate.first.as_ref(), task, purposes);
        }
        let SearchStage::Searching { is_asked, .. } = &mut self.stage else { return };
        let Meeting::Path(path) = &candidate.meeting else { return };
        if !core::mem::replace(is_asked, true) {
            purposes.push((Purpose::FirstContact, path.from_m, WireQuestion::FirstContact));
        }
    }

    /// Notes what is known of the first contact while it is sought. Never widens it.
    pub(crate) fn narrow(&mut self, from_m: f64, touching_m: Option<f64>) {
        let SearchStage::Searching { bracket, .. } = &mut self.stage else { return };
        if let Some(to_m) = touching_m {
            bracket.to_m = bracket.to_m.min(to_m);
            bracket.has_touched = true;
        }
        bracket.from_m = bracket.from_m.max(from_m.min(bracket.to_m));
    }

    /// Takes the first contact, or that there is none. The tasks of the survey, which follow, are
    /// numbered from `task` on.
    pub(crate) fn settle(
        &mut self,
        candidate: &Candidate,
        first: Option<&FirstContact>,
        task: u32,
        purposes: &mut Vec<(Purpose, f64, WireQuestion)>,
    ) {
        let SearchStage::Searching { mut bracket, .. } = self.stage else { return };
        let Meeting::Path(path) = &candidate.meeting else { return };
        let mut stops = std::mem::take(&mut self.spare);
        if let Some(FirstContact { witness, .. }) = first {
            let at_m = witness.travel_m;
            bracket = Bracket { from_m: at_m, to_m: at_m, has_touched: true };
            stops.extend(path.survey(at_m).into_iter().map(|stop| (stop, None)));
        }
        for (number, (stop, _)) in stops.iter().enumerate() {
            let question =
                if stop.patch || stop.depth { WireQuestion::Pairs } else { WireQuestion::Sets };
            purposes.push((Purpose::Survey { stop: number }, stop.travel_m, question));
        }
        self.stage = SearchStage::Surveying { first: first.copied(), bracket, stops, task };
    }

    pub(crate) fn surveyed(
        &mut self,
        number: usize,
        found: &Gathered,
        (a, b): (&BodyView<'_>, &BodyView<'_>),
    ) {
        let SearchStage::Surveying { stops, .. } = &mut self.stage else { return };
        let Some((stop, surveyed)) = stops.get_mut(number) else { return };
        let seen = seen(stop, &found.supports, [found.zones_a, found.zones_b]);
        *surveyed = Some(Surveyed {
            sets: found.summary(a, b),
            pairs: found.pairs,
            hash: found.hash,
            seen,
        });
        if stop.zones {
            self.hit.include(found);
        }
    }

    /// Whether all poses of the survey are done.
    pub(crate) fn is_done(&self) -> bool {
        matches!(&self.stage, SearchStage::Surveying { stops, .. }
            if stops.iter().all(|(_, surveyed)| surveyed.is_some()))
    }

    /// What is known of the contact so far. `open` gives, for a stop whose task is not done, what
    /// it has found and what it may still find.
    pub(crate) fn evidence(&self, mut open: impl FnMut(u32, &Stop) -> Open) -> Evidence {
        let (first, bracket, stops, task) = match &self.stage {
            SearchStage::Settled => return Evidence::none((0.0, 0.0)),
            SearchStage::Searching { bracket, .. } => (&None, bracket, &[][..], None),
            SearchStage::Surveying { first, bracket, stops, task } => {
                (first, bracket, &stops[..], Some(*task))
            }
        };
        let mut evidence = Evidence::none((bracket.from_m, bracket.to_m));
        if bracket.has_touched {
            evidence.touched();
        }
        let Some(task) = task else {
            evidence.add_open_everywhere();
            return evidence;
        };
        // Contact may be so slight, or so brief, that no pose of the survey meets it.
        if let Some(FirstContact { witness, zones: [zones_a, zones_b], supports }) = *first {
            let seen = Seen { patch: supports, zones_a, zones_b, ..Seen::NOTHING };
            evidence.add_hits(witness.travel_m, &seen);
        }
        for (number, (stop, surveyed)) in stops.iter().enumerate() {
            if let Some(surveyed) = surveyed {
                evidence.add_hits(stop.travel_m, &surveyed.seen);
                continue;
            }
            let Open { found, reach } = open(task + number as u32, stop);
            evidence.add_hits(stop.travel_m, &found);
            evidence.add_open(stop.travel_m, &reach);
        }
        evidence
    }
}

/// Hits or reach at a stop, as far as they count there.
pub(crate) fn seen(stop: &Stop, supports: &Supports, zones: [u16; 2]) -> Seen {
    let [zones_a, zones_b] = zones.map(|bits| if stop.zones { Zones(bits) } else { Zones(0) });
    Seen {
        patch: if stop.patch { *supports } else { Supports::EMPTY },
        end: if stop.depth { *supports } else { Supports::EMPTY },
        zones_a,
        zones_b,
    }
}
