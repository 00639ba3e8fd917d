//! Faults that a worker commits on command, so that their effects can be observed.
//!
//! Commands are obeyed only if the coordinator started this worker for it: see `protocol::command`.
//! All of this is behind the feature `faults`.

use crate::answer::Outlet;
use core::hint::black_box;
use core::sync::atomic::{AtomicU32, Ordering};
use protocol::{FaultCommand, Head, InjectedFault, WireJob};
use runtime::{clock, futex, process};
use transport::{OpenMessage, UseError};

/// SIGSEGV.
const SEGV: i32 = 11;
/// Address space of a worker that is commanded to run out of it (bytes).
const MEMORY_BYTES: u64 = 1 << 30;

/// The fault commands that one worker has seen.
#[derive(Debug, Default)]
pub(crate) struct FaultCommands {
    seen: u16,
    armed: Option<FaultCommand>,
}

impl FaultCommands {
    /// Commits the fault that is due at the start of this job. Returns only if the fault is
    /// survivable.
    pub(crate) fn obey(&mut self, outlet: &Outlet<'_>, job: &WireJob) -> Result<(), UseError> {
        self.due(outlet, job).map_or(Ok(()), |command| commit(command, outlet))
    }

    fn due(&mut self, outlet: &Outlet<'_>, job: &WireJob) -> Option<FaultCommand> {
        let word = outlet.coordinator.fault_command.load(Ordering::Relaxed);
        if let Some(command) =
            FaultCommand::from_word(word).filter(|command| command.sequence != self.seen)
        {
            self.seen = command.sequence;
            self.armed = Some(command);
        }
        let armed = self.armed.as_mut()?;
        if armed.fault == InjectedFault::Poison {
            return (armed.argument == job.job).then_some(*armed).inspect(|_| obey(outlet));
        }
        if armed.after > 0 {
            armed.after -= 1;
            return None;
        }
        obey(outlet);
        self.armed.take()
    }
}

fn obey(outlet: &Outlet<'_>) {
    outlet.line.obeyed_ns.store(clock::now_ns(), Ordering::SeqCst);
}

/// A corruption of the next result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Corruption {
    Garble(u32),
    Lie,
    Masquerade,
    Repeat,
    Withhold,
}

impl Corruption {
    /// The head of the message before it is sealed.
    fn before(self, head: Head) -> Head {
        match self {
            Self::Masquerade => Head { worker: head.worker ^ 1, ..head },
            _ => head,
        }
    }

    /// Changes the message after it is sealed.
    fn after(self, head: &mut Head, words: &mut [u64]) {
        match self {
            Self::Garble(bit) => {
                let bit = bit as usize % (words.len().max(1) * 64);
                match words.get_mut(bit / 64) {
                    Some(word) => *word ^= 1 << (bit % 64),
                    None => head.hits ^= 1,
                }
            }
            Self::Lie => head.len = head.len.wrapping_add(7),
            Self::Masquerade | Self::Repeat | Self::Withhold => {}
        }
    }
}

/// Sends a message, corrupted if so commanded.
pub(crate) fn send(
    corruption: Option<Corruption>,
    message: OpenMessage<'_>,
    head: Head,
    used: usize,
) -> Result<(), UseError> {
    let head = corruption.map_or(head, |corruption| corruption.before(head));
    message.send_corrupted(head, used, |head, words| {
        if let Some(corruption) = corruption {
            corruption.after(head, words);
        }
    })
}

/// What to send of a finished last part: nothing if it is to be withheld; if it is to be repeated,
/// it has been sent once already.
pub(crate) fn last<'w>(
    outlet: &Outlet<'w>,
    mut message: OpenMessage<'w>,
    head: Head,
    used: usize,
) -> Result<Option<OpenMessage<'w>>, UseError> {
    match outlet.corruption.get() {
        Some(Corruption::Withhold) => {
            outlet.corruption.take();
            Ok(None)
        }
        Some(Corruption::Repeat) => {
            outlet.corruption.take();
            let words = message.words()[..used].to_vec();
            outlet.send(message, head, used)?;
            let mut again = outlet.open()?;
            if let Some(again) = &mut again {
                again.words()[..used].copy_from_slice(&words);
            }
            Ok(again)
        }
        _ => Ok(Some(message)),
    }
}

fn commit(command: FaultCommand, outlet: &Outlet<'_>) -> Result<(), UseError> {
    let corrupt = |corruption| outlet.corruption.set(Some(corruption));
    match command.fault {
        InjectedFault::Abort | InjectedFault::Poison => std::process::abort(),
        InjectedFault::Quit => std::process::exit(1),
        InjectedFault::Segfault => process::die_of(SEGV),
        InjectedFault::Overflow => {
            black_box(dig(0));
        }
        InjectedFault::Exhaust => exhaust(),
        // Bypasses the hook that would print it.
        InjectedFault::Panic => std::panic::resume_unwind(Box::new("commanded to panic")),
        InjectedFault::Hang => loop {
            core::hint::spin_loop();
        },
        InjectedFault::Stall => {
            let word = AtomicU32::new(0);
            loop {
                let _woken = futex::wait(&word, 0, None);
            }
        }
        InjectedFault::Garble => corrupt(Corruption::Garble(command.argument)),
        InjectedFault::Lie => corrupt(Corruption::Lie),
        InjectedFault::Masquerade => corrupt(Corruption::Masquerade),
        InjectedFault::Repeat => corrupt(Corruption::Repeat),
        InjectedFault::Withhold => corrupt(Corruption::Withhold),
        InjectedFault::HoldLoan => {
            let _held = outlet.sender.loan()?;
            // There is only one loan, so this fails, and a worker that cannot send ends.
            outlet.sender.loan().map(drop)?;
        }
    }
    Ok(())
}

/// Endless recursion; the array makes each step large.
fn dig(depth: u64) -> u64 {
    let room = black_box([depth; 64]);
    if room[black_box(7)] == u64::MAX { depth } else { dig(depth + 1) + room[3] }
}

fn exhaust() {
    if process::limit_self(MEMORY_BYTES, 60).is_err() {
        std::process::abort();
    }
    let mut hoard: Vec<Vec<u8>> = Vec::new();
    loop {
        hoard.push(black_box(vec![1; 16 << 20]));
    }
}
