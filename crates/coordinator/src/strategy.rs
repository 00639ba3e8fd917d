//! Which candidate's job goes out next: replaceable, because it decides how early the winner is
//! certain.
//!
//! A strategy sees, per candidate, what the policy compares over open work. It changes no answer:
//! only when which part of it is known. Incumbent and challenger are those of LUCB
//! (Kalyanakrishnan, Tewari, Auer and Stone, *PAC Subset Selection in Stochastic Multi-armed
//! Bandits*, ICML 2012), with proven intervals in the place of confidence.

use core::fmt::Debug;
use damage::Interval;
use damage::evidence::Touch;

/// One candidate, as a strategy sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prospect {
    /// There are jobs to hand out that can change a figure that ranks.
    pub has_work: bool,
    /// It can still win.
    pub is_possible: bool,
    /// Whether its bodies touch.
    pub touch: Touch,
    /// What the policy compares first that is undecided.
    pub compared: Interval,
    /// Jobs handed out so far.
    pub jobs: u64,
}

/// A way to choose.
pub trait Strategy: Debug {
    /// The candidate whose job goes out next, among those that have work; `None`: whichever was
    /// asked for first.
    fn choose(&mut self, prospects: &[Prospect], incumbent: usize) -> Option<usize>;

    /// Whether it looks at bounds: then they are made after every result.
    fn needs_bounds(&self) -> bool {
        false
    }

    /// Jobs handed out before it is asked again.
    fn stride(&self) -> usize {
        4
    }

    /// Whether a candidate's own tasks are taken in the order that narrows most, and not as they
    /// were asked for.
    fn is_eager(&self) -> bool {
        false
    }
}

/// The strategies by name.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SearchOrder {
    /// As they were asked, whole poses together: the quickest way to the end of all work.
    #[default]
    AsAsked,
    /// One candidate after the other.
    Sequential,
    /// Each candidate in turn.
    RoundRobin,
    /// Incumbent and challenger in turn.
    Alternating,
    /// One hit per candidate first, then whichever of incumbent and challenger is less known.
    Deciding,
}

impl SearchOrder {
    /// All of them.
    pub const ALL: [Self; 5] =
        [Self::AsAsked, Self::Sequential, Self::RoundRobin, Self::Alternating, Self::Deciding];

    /// The name as people write it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::AsAsked => "as-asked",
            Self::Sequential => "sequential",
            Self::RoundRobin => "round-robin",
            Self::Alternating => "alternating",
            Self::Deciding => "deciding",
        }
    }

    /// The strategy, at its start.
    #[must_use]
    pub fn strategy(self) -> Box<dyn Strategy> {
        match self {
            Self::AsAsked => Box::new(AsAsked),
            Self::Sequential => Box::new(Sequential),
            Self::RoundRobin => Box::new(RoundRobin::default()),
            Self::Alternating => Box::new(Alternating::default()),
            Self::Deciding => Box::new(Deciding),
        }
    }
}

/// Questions in the order in which they were asked, all candidates' first ones first: the quickest
/// way to the end of all work, because whole poses stay together.
#[derive(Clone, Copy, Debug)]
struct AsAsked;

impl Strategy for AsAsked {
    fn choose(&mut self, _: &[Prospect], _: usize) -> Option<usize> {
        None
    }

    fn stride(&self) -> usize {
        usize::MAX
    }
}

/// One candidate after the other.
#[derive(Clone, Copy, Debug)]
struct Sequential;

impl Strategy for Sequential {
    fn choose(&mut self, prospects: &[Prospect], _: usize) -> Option<usize> {
        prospects.iter().position(|prospect| prospect.has_work)
    }
}

/// Each candidate in turn.
#[derive(Clone, Copy, Debug, Default)]
struct RoundRobin {
    next: usize,
}

impl Strategy for RoundRobin {
    fn choose(&mut self, prospects: &[Prospect], _: usize) -> Option<usize> {
        let around = (0..prospects.len()).map(|step| (self.next + step) % prospects.len());
        let chosen = around.into_iter().find(|k| prospects[*k].has_work)?;
        self.next = chosen + 1;
        Some(chosen)
    }
}

/// The incumbent, who would win by the upper ends, and the challenger, who has the lowest lower end
/// of the others: in turn.
#[derive(Clone, Copy, Debug, Default)]
struct Alternating {
    is_challengers: bool,
}

impl Strategy for Alternating {
    fn choose(&mut self, prospects: &[Prospect], incumbent: usize) -> Option<usize> {
        let challenger = challenger(prospects, incumbent);
        let incumbent = Some(incumbent).filter(|k| prospects[*k].has_work);
        self.is_challengers = !self.is_challengers;
        let (first, second) =
            if self.is_challengers { (challenger, incumbent) } else { (incumbent, challenger) };
        first.or(second)
    }

    fn needs_bounds(&self) -> bool {
        true
    }
}

/// First one hit per candidate that may touch, because contact itself parts candidates most and
/// costs least; then whichever of incumbent and challenger has more left to lose.
#[derive(Clone, Copy, Debug, Default)]
struct Deciding;

impl Strategy for Deciding {
    fn choose(&mut self, prospects: &[Prospect], incumbent: usize) -> Option<usize> {
        let untouched = |k: &usize| {
            let prospect = &prospects[*k];
            prospect.has_work && prospect.is_possible && prospect.touch == Touch::Unknown
        };
        // A candidate that passes by is asked at every pose: the others' turn comes between.
        let by_jobs = |k: &usize| prospects[*k].jobs;
        if let Some(k) = (0..prospects.len()).filter(untouched).min_by_key(by_jobs) {
            return Some(k);
        }
        let challenger = challenger(prospects, incumbent);
        let incumbent = Some(incumbent).filter(|k| prospects[*k].has_work);
        let width = |k: usize| prospects[k].compared.hi() - prospects[k].compared.lo();
        match (incumbent, challenger) {
            (Some(i), Some(c)) if width(i) >= width(c) => Some(i),
            (i, c) => c.or(i),
        }
    }

    fn needs_bounds(&self) -> bool {
        true
    }

    fn stride(&self) -> usize {
        2
    }

    fn is_eager(&self) -> bool {
        true
    }
}

/// Of the possible winners but the incumbent that have work, the one with the lowest lower end.
fn challenger(prospects: &[Prospect], incumbent: usize) -> Option<usize> {
    let others = prospects
        .iter()
        .enumerate()
        .filter(|(k, prospect)| *k != incumbent && prospect.is_possible && prospect.has_work);
    let by_end = |a: &(usize, &Prospect), b: &(usize, &Prospect)| {
        a.1.compared.lo().total_cmp(&b.1.compared.lo()).then(a.0.cmp(&b.0))
    };
    others.min_by(by_end).map(|(k, _)| k)
}

#[cfg(test)]
mod tests;
