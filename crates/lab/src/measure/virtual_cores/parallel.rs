//! What the cores of this machine do together: they may be threads of one core, or somebody else's
//! for a part of the time, and then no program can gain what their number says.

use core::hint::black_box;
use runtime::affinity::{allowed_cores, pin_self};
use runtime::clock;
use std::sync::Barrier;
use std::thread;

/// Numbers that are worked on at once, so that no core waits for a result.
const LANES: usize = 64;

/// Passes over all numbers: some hundredths of a second.
const PASSES: usize = 2_000_000;

/// How long the same arithmetic takes (ns).
#[derive(Clone, Copy, Debug)]
pub(super) struct Parallel {
    /// On one core after the other, in the mean.
    alone_ns: f64,
    /// On all of them at once, in the mean.
    at_once_ns: f64,
    cores: usize,
}

impl Parallel {
    /// Measures with at most so many cores.
    pub(super) fn measure(most: usize) -> Self {
        let cores: Vec<usize> = allowed_cores().into_iter().take(most.max(1)).collect();
        let at_once = |cores: &[usize]| -> f64 {
            let all = Barrier::new(cores.len());
            let on = |core: usize| {
                // Where it cannot be pinned, the system finds a place for it.
                let _anywhere = pin_self(core);
                all.wait();
                arithmetic_ns()
            };
            let on = &on;
            let took_ns: Vec<f64> = thread::scope(|scope| {
                let threads: Vec<_> =
                    cores.iter().map(|core| scope.spawn(move || on(*core))).collect();
                threads.into_iter().filter_map(|thread| thread.join().ok()).collect()
            });
            took_ns.iter().sum()
        };
        let count = cores.len().max(1) as f64;
        let alone: f64 = cores.iter().map(|core| at_once(&[*core])).sum();
        Self { alone_ns: alone / count, at_once_ns: at_once(&cores) / count, cores: cores.len() }
    }

    /// How many times as much all cores do at once as one does alone.
    pub(super) fn gain(&self) -> f64 {
        self.cores as f64 * self.alone_ns / self.at_once_ns
    }
}

/// How long some arithmetic takes that needs no memory (ns).
fn arithmetic_ns() -> f64 {
    let mut numbers: [f64; LANES] = core::array::from_fn(|k| 1.0 + k as f64);
    let begun_ns = clock::now_ns();
    for _ in 0..PASSES {
        for number in &mut numbers {
            *number = *number * 0.999_999 + 1e-6;
        }
    }
    black_box(numbers);
    (clock::now_ns() - begun_ns) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_core_does_what_one_core_does() {
        let parallel = Parallel { alone_ns: 3.0, at_once_ns: 3.0, cores: 1 };
        assert!((parallel.gain() - 1.0).abs() < 1e-12);
        // Two threads of one core: each takes as long as both one after the other.
        let parallel = Parallel { alone_ns: 3.0, at_once_ns: 6.0, cores: 2 };
        assert!((parallel.gain() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn it_measures_something() {
        let parallel = Parallel::measure(2);
        assert!(parallel.alone_ns > 0.0 && parallel.at_once_ns > 0.0, "{parallel:?}");
        assert!(parallel.gain() > 0.0 && parallel.gain().is_finite());
    }
}
