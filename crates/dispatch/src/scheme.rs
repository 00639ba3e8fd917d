//! Match schemes: which core gets the next job (Wiseman and Grinberg 2018).

/// What a scheme sees of one core when it places one job.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CoreView {
    /// Whether it lives and has a free queue slot.
    pub eligible: bool,
    /// Jobs it holds and has not answered.
    pub queued: u32,
    /// Whether the job's section of body A is resident there.
    pub has_a: bool,
    /// Whether the job's section of body B is resident there.
    pub has_b: bool,
}

/// A match scheme.
pub trait Scheme {
    /// The core for the next job, among the eligible ones; `None` if there is none, and then the
    /// job waits. `capacity` is the queue size of a core, in jobs.
    fn choose(&mut self, cores: &[CoreView], capacity: u32) -> Option<usize>;
}

/// Best Match-Load: the greatest score α·match/2 − (1−α)·load; ties to the lower load, then the
/// lower core. match counts the resident sections, load = queued / capacity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BestMatchLoad {
    /// Weight of the match against the load, in [0, 1].
    pub alpha: f64,
}

impl Scheme for BestMatchLoad {
    fn choose(&mut self, cores: &[CoreView], capacity: u32) -> Option<usize> {
        let mut best: Option<(f64, u32, usize)> = None;
        for (core, view) in cores.iter().enumerate().filter(|(_, view)| view.eligible) {
            let matched = f64::from(u8::from(view.has_a) + u8::from(view.has_b));
            let load = f64::from(view.queued) / f64::from(capacity.max(1));
            let score = self.alpha * matched / 2.0 - (1.0 - self.alpha) * load;
            let better = best.is_none_or(|(top, queued, _)| {
                score > top || (score == top && view.queued < queued)
            });
            if better {
                best = Some((score, view.queued, core));
            }
        }
        best.map(|(_, _, core)| core)
    }
}

#[cfg(test)]
mod tests;
