//! Shrinks a failure: fewer kinds of faults, then fewer faults, then fewer requests.

use super::kind::SimulatedFault;
use super::world::{FaultLimits, Violation, run};

/// The smallest world found that still fails.
#[derive(Clone, Debug)]
pub struct Shrunk {
    /// What may strike in it.
    pub limits: FaultLimits,
    /// How it fails.
    pub violation: Violation,
    /// How many worlds were tried.
    pub tried: u64,
}

/// Shrinks a world that fails under `limits`; `None` if it does not fail.
#[must_use]
pub fn shrink(seed: u64, limits: &FaultLimits) -> Option<Shrunk> {
    let violation = run(seed, limits, None).err()?;
    let mut best = Shrunk { limits: *limits, violation, tried: 1 };
    let attempt = |best: &mut Shrunk, limits: FaultLimits| {
        best.tried += 1;
        if let Err(violation) = run(seed, &limits, None) {
            (best.limits, best.violation) = (limits, violation);
        }
    };
    for fault in SimulatedFault::ALL {
        let limits = FaultLimits { kinds: best.limits.kinds.without(*fault), ..best.limits };
        if best.limits.kinds.has(*fault) {
            attempt(&mut best, limits);
        }
    }
    best.limits.requests = best.violation.request;
    // Fewer of those that struck: halves first, then one by one.
    let mut step = best.violation.struck.iter().sum::<u64>().max(1);
    while step > 0 {
        let most = best.violation.struck.iter().sum::<u64>();
        if most >= step && most > 0 {
            let limits = FaultLimits { most: most - step, ..best.limits };
            let had = best.limits;
            attempt(&mut best, limits);
            if best.limits != had {
                continue;
            }
        }
        step /= 2;
    }
    Some(best)
}
