//! The way of one candidate: find first contact, then survey the crush path from there.
//!
//! Which tasks follow depends on what earlier ones found, never on the order in which they were
//! answered: [`damage::Search`] sees to that.

use crate::gather::{Gathered, SetSummary, Union};
use crate::request::Candidate;
use damage::{Evidence, First, Meeting, Search, Seen, Stop};
use geometry::Supports;
use model::{BodyView, Zones};
use protocol::Question;

/// What a task is for.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Aim {
    /// Does it touch at this travel?
    Probe { travel_m: f64 },
    /// What is hit at this stop of the survey?
    Survey { stop: usize },
}

/// A pose of the survey, done.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Surveyed {
    pub(crate) sets: SetSummary,
    pub(crate) pairs: u64,
    pub(crate) hash: u64,
    pub(crate) seen: Seen,
}

/// How far a candidate is.
#[derive(Clone, Debug)]
pub(crate) enum Stage {
    /// Nothing to find out: the hulls never meet, or always did.
    Settled,
    /// First contact is sought; `asked` are the travels that have a task.
    Searching { search: Search, asked: Vec<f64> },
    /// First contact is known, or known not to be.
    Surveying { search: Search, stops: Vec<(Stop, Option<Surveyed>)> },
}

/// One candidate at work.
#[derive(Clone, Debug)]
pub(crate) struct Case {
    pub(crate) stage: Stage,
    /// A job was abandoned: what it would have found is not known.
    pub(crate) is_unknown: bool,
    /// Triangles hit from first contact to e.
    pub(crate) hit: Union,
}

impl Case {
    pub(crate) fn new(candidate: &Candidate) -> Self {
        let stage = match &candidate.meeting {
            Meeting::Path(path) => {
                Stage::Searching { search: Search::new(path), asked: Vec::new() }
            }
            Meeting::Never(_) | Meeting::AlreadyOverlapping => Stage::Settled,
        };
        Self { stage, is_unknown: false, hit: Union::default() }
    }

    /// The tasks that have to be done now and were not asked for before.
    pub(crate) fn advance(&mut self, candidate: &Candidate, aims: &mut Vec<(Aim, f64, Question)>) {
        let Stage::Searching { search, asked } = &mut self.stage else { return };
        let Meeting::Path(path) = &candidate.meeting else { return };
        let Some(first) = search.outcome() else {
            for travel_m in search.wanted() {
                if !asked.iter().any(|s| s.to_bits() == travel_m.to_bits()) {
                    asked.push(travel_m);
                    aims.push((Aim::Probe { travel_m }, travel_m, Question::Touches));
                }
            }
            return;
        };
        let stops = match first {
            First::None => Vec::new(),
            First::At(first_m) => path.survey(first_m),
        };
        for (number, stop) in stops.iter().enumerate() {
            let question = if stop.patch || stop.depth { Question::Pairs } else { Question::Sets };
            aims.push((Aim::Survey { stop: number }, stop.travel_m, question));
        }
        let search = search.clone();
        let stops = stops.into_iter().map(|stop| (stop, None)).collect();
        self.stage = Stage::Surveying { search, stops };
    }

    /// Whether the answer at a probe can still matter.
    pub(crate) fn needs(&self, aim: Aim) -> bool {
        match (aim, &self.stage) {
            (Aim::Probe { travel_m }, Stage::Searching { search, .. }) => {
                search.is_needed(travel_m)
            }
            (Aim::Probe { .. }, _) => false,
            (Aim::Survey { .. }, _) => true,
        }
    }

    pub(crate) fn learn(&mut self, travel_m: f64, touches: bool) {
        if let Stage::Searching { search, .. } = &mut self.stage {
            search.learn(travel_m, touches);
        }
    }

    pub(crate) fn surveyed(
        &mut self,
        number: usize,
        found: &Gathered,
        (a, b): (&BodyView<'_>, &BodyView<'_>),
    ) {
        let Stage::Surveying { stops, .. } = &mut self.stage else { return };
        let Some((stop, surveyed)) = stops.get_mut(number) else { return };
        let zones = |bits: u16| if stop.zones { Zones(bits) } else { Zones(0) };
        let seen = Seen {
            patch: if stop.patch { found.supports } else { Supports::EMPTY },
            end: if stop.depth { found.supports } else { Supports::EMPTY },
            zones_a: zones(found.zones_a),
            zones_b: zones(found.zones_b),
        };
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
        matches!(&self.stage, Stage::Surveying { stops, .. }
            if stops.iter().all(|(_, surveyed)| surveyed.is_some()))
    }

    /// What is known of the contact by now.
    pub(crate) fn evidence(&self) -> Evidence {
        let (search, stops) = match &self.stage {
            Stage::Settled => return Evidence::none((0.0, 0.0)),
            Stage::Searching { search, .. } => (search, &[][..]),
            Stage::Surveying { search, stops } => (search, &stops[..]),
        };
        let mut evidence = Evidence::none(search.bracket());
        if search.has_touched() {
            evidence.touched();
        }
        for (stop, surveyed) in stops {
            if let Some(surveyed) = surveyed {
                evidence.add_hits(stop.travel_m, &surveyed.seen);
            }
        }
        if self.is_unknown || !self.is_done() {
            evidence.add_open_everywhere();
        }
        evidence
    }
}
