//! Sends signals to workers at given times, from its own thread.

use geometry::rng::Rng;
use runtime::process::Held;
use runtime::{OsError, clock};
use std::fs::OpenOptions;
use std::os::unix::fs::FileExt as _;
use std::path::Path;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread::{Scope, ScopedJoinHandle};
use std::time::Duration;

pub(crate) const KILL: i32 = 9;
const CONTINUE: i32 = 18;
const STOP: i32 = 19;

/// How long a killed process may live (ns).
const ORPHAN_NS: u64 = 1_000_000_000;

/// What to do to a process.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Deed {
    Kill,
    Stop,
    /// Stop it for this long (ns).
    Pause(u64),
    /// Stop it for 9 ms and continue it for 1 ms, this many times.
    Choke(u32),
}

/// A scheduled action.
pub(crate) struct Shot {
    pub(crate) number: usize,
    pub(crate) at: Held,
    pub(crate) after_ns: u64,
    pub(crate) deed: Deed,
}

/// Executes actions in their order.
pub(crate) struct Gunner<'s> {
    shots: Sender<Shot>,
    thread: ScopedJoinHandle<'s, Vec<(usize, u64)>>,
}

impl<'s> Gunner<'s> {
    pub(crate) fn start<'e>(scope: &'s Scope<'s, 'e>) -> Self {
        let (shots, orders) = channel();
        Self { shots, thread: scope.spawn(move || shoot(&orders)) }
    }

    pub(crate) fn add(&self, shot: Shot) {
        // The thread ends only when this end is dropped.
        let _sent = self.shots.send(shot);
    }

    /// Cancels the remaining actions; returns when each was executed (ns, monotonic).
    pub(crate) fn end(self) -> Vec<(usize, u64)> {
        drop(self.shots);
        self.thread.join().unwrap_or_default()
    }
}

/// Waits; `false` if waiting is cancelled.
fn wait(orders: &Receiver<Shot>, ns: u64, later: &mut Vec<Shot>) -> bool {
    let end = clock::now_ns() + ns;
    loop {
        let left = end.saturating_sub(clock::now_ns());
        if left == 0 {
            return true;
        }
        match orders.recv_timeout(Duration::from_nanos(left)) {
            Ok(shot) => later.push(shot),
            Err(RecvTimeoutError::Timeout) => return true,
            Err(RecvTimeoutError::Disconnected) => return false,
        }
    }
}

fn shoot(orders: &Receiver<Shot>) -> Vec<(usize, u64)> {
    let mut done = Vec::new();
    let mut later: Vec<Shot> = Vec::new();
    let begun_ns = clock::now_ns();
    loop {
        let Some(at) = (0..later.len()).min_by_key(|at| later[*at].after_ns) else {
            match orders.recv() {
                Ok(shot) => later.push(shot),
                Err(_) => return done,
            }
            continue;
        };
        let until_ns = begun_ns + later[at].after_ns;
        let known = later.len();
        if !wait(orders, until_ns.saturating_sub(clock::now_ns()), &mut later) {
            return done;
        }
        if later.len() > known {
            // One of these may be due earlier.
            continue;
        }
        let Shot { number, at, deed, .. } = later.swap_remove(at);
        // A process that has ended receives no signal.
        let signal = |number| drop(at.signal(number));
        done.push((number, clock::now_ns()));
        match deed {
            Deed::Kill => signal(KILL),
            Deed::Stop => signal(STOP),
            Deed::Pause(ns) => {
                signal(STOP);
                wait(orders, ns, &mut later);
                signal(CONTINUE);
            }
            Deed::Choke(times) => {
                for _ in 0..times {
                    signal(STOP);
                    let goes_on = wait(orders, 9_000_000, &mut later);
                    signal(CONTINUE);
                    if !goes_on || !wait(orders, 1_000_000, &mut later) {
                        break;
                    }
                }
            }
        }
    }
}

/// Number of processes that still live a while after this moment (ns).
pub(super) fn still_alive(held: &[Held], since_ns: u64) -> u64 {
    loop {
        let alive = held.iter().filter(|held| held.is_alive()).count();
        if alive == 0 || clock::now_ns() - since_ns >= ORPHAN_NS {
            return alive as u64;
        }
        std::thread::yield_now();
    }
}

/// Kills a process, and waits for its end: one that still ends would be taken for a live one, which
/// gets no successor and may be struck again.
pub(super) fn end(held: Held) -> Result<(), OsError> {
    held.signal(KILL)?;
    still_alive(&[held], clock::now_ns());
    Ok(())
}

/// Flips this many bits in each file of shared memory whose name has this end.
pub(crate) fn flip(prefix: &str, suffix: &str, bits: u64, mut rng: Rng) {
    let folder = |path: &Path| std::fs::read_dir(path).into_iter().flatten().flatten();
    let runs = folder(&trolley::doctor::shared_folder())
        .filter(|run| run.file_name().to_string_lossy().starts_with(prefix));
    let roots = runs.flat_map(|run| folder(&run.path()));
    for entry in roots.flat_map(|root| folder(&root.path())).collect::<Vec<_>>() {
        if !entry.file_name().to_string_lossy().ends_with(suffix) {
            continue;
        }
        flip_in(&entry.path(), bits, &mut rng);
    }
}

/// Flips this many bits of a file, which may be gone by now.
pub(crate) fn flip_in(path: &Path, bits: u64, rng: &mut Rng) {
    let Ok(file) = OpenOptions::new().read(true).write(true).open(path) else { return };
    let len = file.metadata().map_or(0, |meta| meta.len());
    for _ in 0..if len > 0 { bits } else { 0 } {
        let (at, mut byte) = (rng.below(len), [0]);
        if file.read_at(&mut byte, at).is_ok() {
            byte[0] ^= 1 << rng.below(8);
            let _gone = file.write_at(&byte, at);
        }
    }
}
