//! What the cores of this machine do together: they may share a cache, be threads of one core, or
//! somebody else's for a part of the time, and then no program can gain what their number says.

use super::kind::Kind;
use runtime::affinity::pin_self;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::Scope;
use trolley::{Answer, Failure, Limits, Scenario};

/// One ranking on each of some cores at once, each by itself.
pub(super) struct Separate {
    rankers: Vec<Ranker>,
    /// How long a ranking took in each turn: the mean of all cores (ns).
    pub(super) took_ns: Vec<f64>,
}

/// A thread that ranks whenever it is told to, and what it says then: the answer, and how long it
/// took (ns).
struct Ranker {
    begin: Sender<()>,
    done: Receiver<Result<(Answer, f64), Failure>>,
}

impl Separate {
    /// A thread for each of these cores. What it ranks with is made there, at its first ranking.
    pub(super) fn of<'scope>(
        scope: &'scope Scope<'scope, '_>,
        cores: &[usize],
        make: &'scope (impl Fn() -> Result<Kind, Failure> + Sync),
        asked: (&'scope Scenario, &'scope Limits),
    ) -> Self {
        let start = |core: &usize| {
            let core = *core;
            let (begin, begun) = channel();
            let (tell, done) = channel();
            scope.spawn(move || {
                // Where it cannot be pinned, the system finds a place for it.
                let _anywhere = pin_self(core);
                let mut kind = None;
                for () in begun {
                    if tell.send(ranked(&mut kind, make, asked)).is_err() {
                        return;
                    }
                }
            });
            Ranker { begin, done }
        };
        Self { rankers: cores.iter().map(start).collect(), took_ns: Vec::new() }
    }

    /// Ranks once on each core.
    pub(super) fn rank(&mut self) -> Result<Vec<Answer>, Failure> {
        let gone = || Failure::internal("a thread that ranks has ended");
        for ranker in &self.rankers {
            ranker.begin.send(()).ok().ok_or_else(gone)?;
        }
        let (mut answers, mut sum_ns) = (Vec::new(), 0.0);
        for ranker in &self.rankers {
            let (answer, took_ns) = ranker.done.recv().ok().ok_or_else(gone)??;
            answers.push(answer);
            sum_ns += took_ns;
        }
        self.took_ns.push(sum_ns / self.rankers.len().max(1) as f64);
        Ok(answers)
    }
}

fn ranked(
    kind: &mut Option<Kind>,
    make: impl Fn() -> Result<Kind, Failure>,
    (scenario, limits): (&Scenario, &Limits),
) -> Result<(Answer, f64), Failure> {
    let kind = match kind {
        Some(kind) => kind,
        None => kind.insert(make()?),
    };
    let answer = kind.rank(scenario, limits)?;
    Ok((answer, kind.took_ns.pop().unwrap_or(f64::NAN)))
}
