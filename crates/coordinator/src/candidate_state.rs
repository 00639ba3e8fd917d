//! The state of one candidate: find first contact, then survey the crush path from there.
//!
//! Which tasks follow depends on what earlier ones found, never on the order in which they were
//! answered: [`damage::Search`] ensures that.

use crate::bound::Open;
use crate::gather::{Gathered, SetSummary, Union};
use crate::request::Candidate;
use body::{BodyView, Zones};
use damage::{Evidence, First, Meeting, Search, Seen, Stop, Stops, Travels};
use geometry::Supports;
use protocol::WireQuestion;

/// What a task is for.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Purpose {
    /// Does it touch at this travel?
    Probe { travel_m: f64 },
    /// What is hit at this stop of the survey?
    Survey { stop: usize },
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
    /// First contact is sought; `asked` are the travels that have a task.
    Searching { search: Search, asked: Travels },
    /// First contact is known, or known not to exist. `task` is the number of the first stop's
    /// task; the others follow.
    Surveying { search: Search, stops: Vec<(Stop, Option<Surveyed>)>, task: u32 },
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
                SearchStage::Searching { search: Search::new(path), asked: Travels::new() }
            }
            Meeting::Never(_) | Meeting::AlreadyOverlapping => SearchStage::Settled,
        };
        Self { stage, hit, spare }
    }

    /// The tasks that are needed now and were not asked for before; they are numbered from `task`
    /// on.
    pub(crate) fn advance(
        &mut self,
        candidate: &Candidate,
        task: u32,
        purposes: &mut Vec<(Purpose, f64, WireQuestion)>,
    ) {
        let SearchStage::Searching { search, asked } = &mut self.stage else { return };
        let Meeting::Path(path) = &candidate.meeting else { return };
        let Some(first) = search.outcome() else {
            for travel_m in search.wanted() {
                if !asked.iter().any(|s| s.to_bits() == travel_m.to_bits()) {
                    asked.push(travel_m);
                    purposes.push((Purpose::Probe { travel_m }, travel_m, WireQuestion::Touches));
                }
            }
            return;
        };
        let stops = match first {
            First::None => Stops::new(),
            First::At(first_m) => path.survey(first_m),
        };
        for (number, stop) in stops.iter().enumerate() {
            let question =
                if stop.patch || stop.depth { WireQuestion::Pairs } else { WireQuestion::Sets };
            purposes.push((Purpose::Survey { stop: number }, stop.travel_m, question));
        }
        let search = search.clone();
        let mut list = std::mem::take(&mut self.spare);
        list.extend(stops.into_iter().map(|stop| (stop, None)));
        self.stage = SearchStage::Surveying { search, stops: list, task };
    }

    /// Whether the answer at a probe can still matter.
    pub(crate) fn needs(&self, purpose: Purpose) -> bool {
        match (purpose, &self.stage) {
            (Purpose::Probe { travel_m }, SearchStage::Searching { search, .. }) => {
                search.is_needed(travel_m)
            }
            (Purpose::Probe { .. }, _) => false,
            (Purpose::Survey { .. }, _) => true,
        }
    }

    pub(crate) fn learn(&mut self, travel_m: f64, touches: bool) {
        if let SearchStage::Searching { search, .. } = &mut self.stage {
            search.learn(travel_m, touches);
        }
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
        let (search, stops, task) = match &self.stage {
            SearchStage::Settled => return Evidence::none((0.0, 0.0)),
            SearchStage::Searching { search, .. } => (search, &[][..], None),
            SearchStage::Surveying { search, stops, task } => (search, &stops[..], Some(*task)),
        };
        let mut evidence = Evidence::none(search.bracket());
        if search.has_touched() {
            evidence.touched();
        }
        let Some(task) = task else {
            evidence.add_open_everywhere();
            return evidence;
        };
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
