//! Which candidate's job goes out next: replaceable, because it decides how early the winner is
//! certain.
//!
//! A strategy sees, per candidate, what the policy compares over open work. It does not change an
//! answer, only when each part of it is known. Incumbent and challenger are those of LUCB
//! (Kalyanakrishnan, Tewari, Auer and Stone, *PAC Subset Selection in Stochastic Multi-armed
//! Bandits*, ICML 2012), with proven intervals in place of confidence intervals.

use core::fmt::Debug;
use damage::Interval;

/// One candidate, as a strategy sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prospect {
    /// Whether there are jobs to hand out that can change a figure that ranks.
    pub has_work: bool,
    /// Whether it can still win.
    pub is_possible: bool,
    /// What the first undecided step of the policy compares.
    pub compared: Interval,
}

/// A rule that chooses the candidate whose job goes out next.
pub trait Strategy: Debug + Sync {
    /// The candidate whose job goes out next, among those that have work; `None`: the one asked for
    /// first.
    fn choose(&mut self, prospects: &[Prospect], incumbent: usize) -> Option<usize>;

    /// Whether it looks at the candidates at all: one that does not is never asked.
    fn has_preference(&self) -> bool {
        true
    }

    /// Whether it needs bounds: then they are computed after every result.
    fn needs_bounds(&self) -> bool {
        false
    }

    /// Number of jobs handed out before it is asked again.
    fn stride(&self) -> usize {
        4
    }

    /// Whether a candidate's tasks are taken in the order that narrows most, rather than as asked
    /// for.
    fn is_eager(&self) -> bool {
        false
    }
}

/// The strategies by name.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SearchOrder {
    /// In the order asked, whole poses together: the quickest way to finish all work.
    #[default]
    AsAsked,
    /// One candidate after the other.
    Sequential,
    /// Each candidate in turn.
    RoundRobin,
    /// Incumbent and challenger in turn.
    Alternating,
    /// The less known of incumbent and challenger.
    Deciding,
}

impl SearchOrder {
    /// All search orders.
    pub const ALL: [Self; 5] =
        [Self::AsAsked, Self::Sequential, Self::RoundRobin, Self::Alternating, Self::Deciding];

    /// The name in files and on the command line.
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

    /// A new strategy of this order.
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

/// Questions in the order asked, the first ones of all candidates first: the quickest way to finish
/// all work, because whole poses stay together.
#[derive(Clone, Copy, Debug)]
struct AsAsked;

impl Strategy for AsAsked {
    fn choose(&mut self, _: &[Prospect], _: usize) -> Option<usize> {
        None
    }

    fn has_preference(&self) -> bool {
        false
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

/// In turn, the incumbent, which would win by the upper ends, and the challenger, which has the
/// lowest lower end of the others.
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

/// The one of incumbent and challenger that has more left to lose.
#[derive(Clone, Copy, Debug, Default)]
struct Deciding;

impl Strategy for Deciding {
    fn choose(&mut self, prospects: &[Prospect], incumbent: usize) -> Option<usize> {
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

/// The candidate with the lowest lower end among possible winners with work, the incumbent
/// excepted.
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
