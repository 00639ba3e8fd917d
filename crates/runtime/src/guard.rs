//! The end of a process within 2 s of the first ending signal, whatever hangs in it.
//!
//! ```text
//! 0 s     SIGTERM, SIGINT, SIGQUIT or SIGHUP: every poller of the process reports it
//! 1.6 s   still there: children are killed, own files removed, exit code 128 + signal
//! 1.9 s   still there: the kernel's timer sends SIGKILL
//! ```
//!
//! A thread of its own waits for the signals, which are blocked in all others. What it does uses no
//! lock that another thread could hold: it must work while any of them stands still. A second
//! signal, more than 100 ms after the first, ends the process at once, as does one that comes
//! before any poller [listens](crate::Poller::catch_signals).

use crate::clock;
use crate::error::{OsError, Result};
use crate::process::children;
use crate::realtime;
use crate::wait::event::EventFd;
use crate::wait::signals::{Signals, ending, take};
use core::mem::MaybeUninit;
use core::ptr;
use core::sync::atomic::{AtomicBool, AtomicI32, AtomicU8, Ordering};
use rustix::event::{PollFd, PollFlags};
use rustix::io::Errno;
use std::io;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::sync::{Arc, OnceLock};
use std::thread::JoinHandle;

/// How many times as long an end may take: 1, but for a program that is built with
/// `TROLLEY_SLOWNESS`, as `cargo x aarch64` builds one that is tried under an emulator. No setting
/// of a program that is built changes it.
const SLOWNESS: u64 = match option_env!("TROLLEY_SLOWNESS") {
    None => 1,
    Some(text) => match u64::from_str_radix(text, 10) {
        Ok(times) => times,
        Err(_) => panic!("TROLLEY_SLOWNESS is no number"),
    },
};
/// How long a process may take to end in order (ns).
const PATIENCE_NS: u64 = 1_600_000_000;
/// When the kernel ends it, whatever the guard itself does (ns).
const KILL_NS: u64 = 1_900_000_000;
/// Signals so soon after the first (ns) are the same wish: a terminal that closes sends two.
const SAME_NS: u64 = 100_000_000;
/// What the thread needs, and more: locked memory counts all of it.
const STACK_BYTES: usize = 128 << 10;
/// The highest fixed priority.
const PRIORITY_MAX: i32 = 99;

/// No guard is in charge.
const OFF: u8 = 0;
/// One is.
const ON: u8 = 1;
/// It ends the process; nobody else does any more.
const FORCED: u8 = 2;

static STATE: AtomicU8 = AtomicU8::new(OFF);
/// The first signal that came; 0: none.
static SIGNAL: AtomicI32 = AtomicI32::new(0);
/// Whether a poller listens.
static IS_HEARD: AtomicBool = AtomicBool::new(false);
/// Readable once a signal came. Never drained, and never closed.
static TOLD: OnceLock<EventFd> = OnceLock::new();

/// The file descriptor that a poller watches in place of the signals, if there is a guard.
pub(crate) fn listen() -> Option<BorrowedFd<'static>> {
    if STATE.load(Ordering::Acquire) == OFF {
        return None;
    }
    let told = TOLD.get()?;
    IS_HEARD.store(true, Ordering::Release);
    Some(told.fd())
}

/// The signal that came.
pub(crate) fn told() -> Option<i32> {
    Some(SIGNAL.load(Ordering::Acquire)).filter(|number| *number != 0)
}

/// The thread that owns the ending signals.
///
/// Dropping it gives them back, unless one has come: then the process is to end, and the guard goes
/// on until it does.
#[derive(Debug)]
pub struct Guard {
    _signals: Signals,
    disarm: Arc<EventFd>,
    thread: Option<JoinHandle<()>>,
}

impl Guard {
    /// Blocks the ending signals in this thread and in those that it starts from now on, and starts
    /// the thread that waits for them. A thread that was started before still dies of them.
    ///
    /// `clean` removes the files of this process at a forced end. It runs while other threads may
    /// hold any lock, so it must wait for none, and has 0.3 s.
    ///
    /// # Errors
    ///
    /// If this process has a guard already, or descriptors, timers or threads ran out.
    pub fn start(clean: fn()) -> Result<Self> {
        let told = EventFd::create()?;
        let turned = STATE.compare_exchange(OFF, ON, Ordering::AcqRel, Ordering::Relaxed);
        if turned.is_err() {
            return Err(OsError::new("guard", "this process a second time", Errno::BUSY));
        }
        // The same one for as long as the process lives: pollers have it.
        let _first = TOLD.set(told);
        Self::start_thread(clean).inspect_err(|_| STATE.store(OFF, Ordering::Release))
    }

    fn start_thread(clean: fn()) -> Result<Self> {
        let signals = Signals::catch(&ending())?;
        let copied = signals.fd().try_clone_to_owned();
        let fd = copied.map_err(OsError::at("copy", "signalfd"))?;
        let timer = KillTimer::create()?;
        let disarm = Arc::new(EventFd::create()?);
        let theirs = disarm.clone();
        let thread = std::thread::Builder::new()
            .name("trolley-guard".to_owned())
            .stack_size(STACK_BYTES)
            .spawn(move || watch(&fd, &theirs, &timer, clean))
            .map_err(OsError::at("start thread", "trolley-guard"))?;
        Ok(Self { _signals: signals, disarm, thread: Some(thread) })
    }
}

impl Drop for Guard {
    fn drop(&mut self) {
        if told().is_some() {
            return;
        }
        if STATE.compare_exchange(ON, OFF, Ordering::AcqRel, Ordering::Relaxed).is_err() {
            // It ends the process at this moment.
            return;
        }
        self.disarm.notify();
        if let Some(thread) = self.thread.take() {
            let _panicked = thread.join();
        }
        IS_HEARD.store(false, Ordering::Release);
    }
}

/// What the thread does.
fn watch(fd: &OwnedFd, disarm: &EventFd, timer: &KillTimer, clean: fn()) {
    // The heap gives each thread a region of its own at its first use. Later, the lock for that may
    // be held by a thread that stands still.
    drop(core::hint::black_box(Vec::<u8>::with_capacity(4096)));
    first_of_all();
    let Some(number) = wait(fd, disarm, None) else { return };
    let first_ns = clock::now_ns();
    timer.arm(SLOWNESS * KILL_NS);
    SIGNAL.store(number, Ordering::Release);
    if let Some(told) = TOLD.get() {
        told.notify();
    }
    let end_ns = first_ns + SLOWNESS * PATIENCE_NS;
    while IS_HEARD.load(Ordering::Acquire) {
        let now_ns = clock::now_ns();
        if now_ns >= end_ns || wait(fd, disarm, Some(end_ns - now_ns)).is_none() {
            break;
        }
        if clock::now_ns() - first_ns > SAME_NS {
            break;
        }
    }
    force(number, clean);
}

/// Asks for the highest priority that this process may have: a service with a fixed priority that
/// never sleeps, on the only core, would keep this thread from running.
fn first_of_all() {
    let limit = rustix::process::getrlimit(rustix::process::Resource::Rtprio).current;
    let limit = limit.and_then(|limit| i32::try_from(limit).ok()).unwrap_or(PRIORITY_MAX);
    let granted = [PRIORITY_MAX, limit.min(PRIORITY_MAX)];
    let _refused = granted.iter().any(|priority| realtime::fifo(0, *priority).is_ok());
}

/// Waits for a signal, at most so long (ns); `None`: none came, or the guard was disarmed.
fn wait(fd: &OwnedFd, disarm: &EventFd, timeout_ns: Option<u64>) -> Option<i32> {
    let end_ns = timeout_ns.map(|ns| clock::now_ns() + ns);
    loop {
        let left_ns = end_ns.map(|end_ns| end_ns.saturating_sub(clock::now_ns()));
        let disarm = disarm.fd();
        let mut fds = [PollFd::new(fd, PollFlags::IN), PollFd::new(&disarm, PollFlags::IN)];
        match rustix::event::poll(&mut fds, left_ns.map(clock::timespec).as_ref()) {
            Ok(0) => return None,
            Ok(_) if !fds[1].revents().is_empty() => return None,
            Ok(_) => {
                if let Some(number) = take(fd.as_fd()) {
                    return Some(number);
                }
            }
            Err(Errno::INTR) => {}
            Err(_) => return None,
        }
    }
}

/// Ends the process; returns only if the guard was disarmed first.
fn force(number: i32, clean: fn()) {
    if STATE.compare_exchange(ON, FORCED, Ordering::AcqRel, Ordering::Relaxed).is_err() {
        return;
    }
    children::kill_all();
    // What panics cannot be waited for either.
    let _panicked = std::panic::catch_unwind(clean);
    say(b"error: ended by force after a signal\n");
    // SAFETY: it has no preconditions. What `exit` would flush and tear down may hang.
    unsafe { libc::_exit(128 + number) }
}

/// Writes to stderr if that does not block.
fn say(text: &[u8]) {
    let stderr = io::stderr();
    let stderr = stderr.as_fd();
    let mut fds = [PollFd::new(&stderr, PollFlags::OUT)];
    let ready = rustix::event::poll(&mut fds, Some(&clock::timespec(0)));
    if matches!(ready, Ok(1)) && fds[0].revents() == PollFlags::OUT {
        let _nobody_reads = rustix::io::write(stderr, text);
    }
}

/// A timer of the kernel that ends the process by SIGKILL.
struct KillTimer(libc::timer_t);

// SAFETY: the kernel's number of the timer, which any thread of the process may use.
unsafe impl Send for KillTimer {}

impl KillTimer {
    fn create() -> Result<Self> {
        // SAFETY: all zeros is such a struct.
        let mut event: libc::sigevent = unsafe { MaybeUninit::zeroed().assume_init() };
        event.sigev_notify = libc::SIGEV_SIGNAL;
        event.sigev_signo = libc::SIGKILL;
        let mut timer = ptr::null_mut();
        // SAFETY: both are valid, and the second may be written.
        let made =
            unsafe { libc::timer_create(libc::CLOCK_MONOTONIC, &raw mut event, &raw mut timer) };
        match made {
            0 => Ok(Self(timer)),
            _ => Err(OsError::new("create", "timer", io::Error::last_os_error())),
        }
    }

    fn arm(&self, after_ns: u64) {
        let zero = libc::timespec { tv_sec: 0, tv_nsec: 0 };
        let tv_sec = (after_ns / 1_000_000_000) as libc::time_t;
        let tv_nsec = (after_ns % 1_000_000_000) as libc::c_long;
        let once =
            libc::itimerspec { it_interval: zero, it_value: libc::timespec { tv_sec, tv_nsec } };
        // SAFETY: the timer lives as long as `self`; the old setting is not asked for.
        unsafe { libc::timer_settime(self.0, 0, &raw const once, ptr::null_mut()) };
    }
}

impl Drop for KillTimer {
    fn drop(&mut self) {
        // SAFETY: made in `create`, and deleted here alone.
        unsafe { libc::timer_delete(self.0) };
    }
}
