//! Match schemes: which core gets the next job (Wiseman and Grinberg 2018, section "Best Match").
//!
//! match(c, (a, b)) = [a resident on c] + [b resident on c]; load = queued / capacity. Only
//! eligible cores are considered: in a contact nearly everything is connected, and without that
//! rule Best Match would send every job to one core.

use core::fmt::Debug;

/// The view of one core for the placement of one job.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CoreView {
    /// Whether it is alive and has a free queue slot.
    pub eligible: bool,
    /// Unanswered jobs it holds.
    pub queued: u32,
    /// Whether the job's section of body A is resident there.
    pub has_a: bool,
    /// Whether the job's section of body B is resident there.
    pub has_b: bool,
}

impl CoreView {
    /// Number of the job's two sections that are resident here.
    #[must_use]
    pub fn matched(&self) -> u8 {
        u8::from(self.has_a) + u8::from(self.has_b)
    }
}

/// A match scheme.
pub trait MatchScheme: Debug {
    /// Chooses the core for the next job among the eligible ones; `None` if there is none, and the
    /// job waits. `capacity` is the queue size of a core, in jobs.
    fn choose(&mut self, cores: &[CoreView], capacity: u32) -> Option<usize>;
}

impl MatchScheme for Box<dyn MatchScheme> {
    fn choose(&mut self, cores: &[CoreView], capacity: u32) -> Option<usize> {
        self.as_mut().choose(cores, capacity)
    }
}

/// The schemes by name, with their settings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Matching {
    /// [`BestMatchLoad`] with this α.
    BestMatchLoad(f64),
    /// The most resident sections: [`BestMatchLoad`] with α = 1.
    BestMatch,
    /// [`RandomMatch`] with this seed.
    RandomMatch(u64),
    /// [`LowestMatch`].
    LowestMatch,
    /// [`RoundRobin`].
    RoundRobin,
}

impl Matching {
    /// Creates the scheme in its initial state.
    #[must_use]
    pub fn scheme(self) -> Box<dyn MatchScheme> {
        match self {
            Self::BestMatchLoad(alpha) => Box::new(BestMatchLoad { alpha }),
            Self::BestMatch => Box::new(BestMatchLoad { alpha: 1.0 }),
            Self::RandomMatch(seed) => Box::new(RandomMatch { state: seed }),
            Self::LowestMatch => Box::new(LowestMatch),
            Self::RoundRobin => Box::new(RoundRobin::default()),
        }
    }
}

/// Best Match-Load: the greatest score α·match/2 − (1−α)·load; ties to the lower load, then the
/// lower core. α = 1 is Best Match, α = 0 is least loaded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BestMatchLoad {
    /// Weight of the match against the load, in [0, 1].
    pub alpha: f64,
}

impl MatchScheme for BestMatchLoad {
    fn choose(&mut self, cores: &[CoreView], capacity: u32) -> Option<usize> {
        greatest(cores, |view| {
            let load = f64::from(view.queued) / f64::from(capacity.max(1));
            self.alpha * f64::from(view.matched()) / 2.0 - (1.0 - self.alpha) * load
        })
    }
}

/// Lowest Match: the fewest resident sections; ties as in [`BestMatchLoad`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LowestMatch;

impl MatchScheme for LowestMatch {
    fn choose(&mut self, cores: &[CoreView], _: u32) -> Option<usize> {
        greatest(cores, |view| -f64::from(view.matched()))
    }
}

/// Random Match: any eligible core with equal probability; equal seeds give equal choices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RandomMatch {
    /// State of the generator; initially the seed.
    pub state: u64,
}

impl MatchScheme for RandomMatch {
    fn choose(&mut self, cores: &[CoreView], _: u32) -> Option<usize> {
        let eligible = cores.iter().filter(|view| view.eligible).count() as u64;
        if eligible == 0 {
            return None;
        }
        // splitmix64 (Steele, Lea and Flood, OOPSLA 2014); the product takes the top bits.
        self.state = self.state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.state;
        z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        let drawn = (u128::from(z ^ z >> 31) * u128::from(eligible)) >> 64;
        let mut left = cores.iter().enumerate().filter(|(_, view)| view.eligible);
        left.nth(drawn as usize).map(|(core, _)| core)
    }
}

/// The next eligible core after the last one chosen, cyclically; ignores residency and load.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RoundRobin {
    next: usize,
}

impl MatchScheme for RoundRobin {
    fn choose(&mut self, cores: &[CoreView], _: u32) -> Option<usize> {
        let around = (0..cores.len()).map(|step| (self.next + step) % cores.len());
        let chosen = around.clone().find(|core| cores[*core].eligible)?;
        self.next = chosen + 1;
        Some(chosen)
    }
}

/// The eligible core with the greatest score; ties to the lower load, then the lower number.
fn greatest(cores: &[CoreView], score: impl Fn(&CoreView) -> f64) -> Option<usize> {
    let mut best: Option<(f64, u32, usize)> = None;
    for (core, view) in cores.iter().enumerate().filter(|(_, view)| view.eligible) {
        let score = score(view);
        let better = best
            .is_none_or(|(top, queued, _)| score > top || (score == top && view.queued < queued));
        if better {
            best = Some((score, view.queued, core));
        }
    }
    best.map(|(_, _, core)| core)
}

#[cfg(test)]
mod tests;
