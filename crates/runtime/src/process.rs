//! Processes: children that cannot outlive their parent, and what the kernel reports of any
//! process.
//!
//! A child is held by a pidfd, so a signal can never reach a stranger that got its number. It dies
//! with the *thread* that spawned it (PR_SET_PDEATHSIG is per thread): spawn from a thread that
//! lives as long as the process. It is reaped by [`Child::try_wait`], [`Child::wait_ms`] or drop.

pub(crate) mod children;
mod exec;
mod spawn;
mod stat;
#[cfg(feature = "faults")]
mod trace;

#[cfg(feature = "faults")]
pub use spawn::spawn_stopped;
pub use spawn::{Spawn, spawn, spawn_with_env};
pub use stat::{ProcStat, stat};
#[cfg(feature = "faults")]
pub use trace::{Frozen, Traced, may_trace, trace};

use crate::clock;
use crate::error::{OsError, Result};
use core::fmt;
use rustix::event::{PollFd, PollFlags};
use rustix::io::Errno;
use rustix::process::{Pid, PidfdFlags, Resource, Rlimit, Signal, WaitOptions};
use std::os::fd::{AsFd, BorrowedFd, FromRawFd, OwnedFd, RawFd};
use std::path::Path;

/// How a process ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exit {
    /// By itself, with this code.
    Code(i32),
    /// By this signal.
    Signal(i32),
}

impl fmt::Display for Exit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Code(code) => write!(f, "exit code {code}"),
            Self::Signal(number) => match signal_name(*number) {
                Some(name) => write!(f, "{name}"),
                None => write!(f, "signal {number}"),
            },
        }
    }
}

fn signal_name(number: i32) -> Option<&'static str> {
    Some(match number {
        libc::SIGABRT => "SIGABRT",
        libc::SIGBUS => "SIGBUS",
        libc::SIGFPE => "SIGFPE",
        libc::SIGHUP => "SIGHUP",
        libc::SIGILL => "SIGILL",
        libc::SIGINT => "SIGINT",
        libc::SIGKILL => "SIGKILL",
        libc::SIGPIPE => "SIGPIPE",
        libc::SIGQUIT => "SIGQUIT",
        libc::SIGSEGV => "SIGSEGV",
        libc::SIGSYS => "SIGSYS",
        libc::SIGTERM => "SIGTERM",
        libc::SIGTRAP => "SIGTRAP",
        libc::SIGXCPU => "SIGXCPU",
        _ => return None,
    })
}

/// A child process. Dropping it kills and reaps it.
#[derive(Debug)]
pub struct Child {
    pid: Pid,
    pidfd: OwnedFd,
    exit: Option<Exit>,
    exec: exec::ExecPipe,
}

impl Child {
    /// Its number. Only for people and for [`stat`]: signals go through the pidfd.
    #[must_use]
    pub fn pid(&self) -> u32 {
        self.pid.as_raw_nonzero().get().unsigned_abs()
    }

    /// Becomes readable when it ends.
    #[must_use]
    pub fn pidfd(&self) -> BorrowedFd<'_> {
        self.pidfd.as_fd()
    }

    /// Sends SIGKILL. Nothing happens if it has ended already.
    ///
    /// # Errors
    ///
    /// If the kernel refuses: the child has become another user's.
    pub fn kill(&self) -> Result<()> {
        self.send(Signal::KILL)
    }

    /// Sends a signal by its number. Nothing happens if it has ended already.
    ///
    /// # Errors
    ///
    /// If there is no such signal, or the kernel refuses.
    pub fn signal(&self, number: i32) -> Result<()> {
        let signal = Signal::from_named_raw(number)
            .ok_or_else(|| OsError::new("send signal", number.to_string(), Errno::INVAL))?;
        self.send(signal)
    }

    fn send(&self, signal: Signal) -> Result<()> {
        match rustix::process::pidfd_send_signal(&self.pidfd, signal) {
            Ok(()) | Err(Errno::SRCH) => Ok(()),
            Err(source) => Err(OsError::new("send a signal to", self.pid().to_string(), source)),
        }
    }

    /// How it ended; `None` while it is alive. Does not wait. Once it has ended, every call returns
    /// the same.
    ///
    /// # Errors
    ///
    /// If it was reaped elsewhere.
    pub fn try_wait(&mut self) -> Result<Option<Exit>> {
        self.reap()
    }

    /// Waits until it ends, at most `timeout_ms`.
    ///
    /// # Errors
    ///
    /// If it was reaped elsewhere.
    pub fn wait_ms(&mut self, timeout_ms: u64) -> Result<Option<Exit>> {
        let end = clock::now_ns().saturating_add(timeout_ms.saturating_mul(1_000_000));
        loop {
            if let Some(exit) = self.try_wait()? {
                return Ok(Some(exit));
            }
            let now = clock::now_ns();
            if now >= end {
                return Ok(None);
            }
            let mut fds = [PollFd::new(&self.pidfd, PollFlags::IN)];
            match rustix::event::poll(&mut fds, Some(&clock::timespec(end - now))) {
                Ok(_) | Err(Errno::INTR) => {}
                Err(source) => {
                    return Err(OsError::new("wait for", self.pid().to_string(), source));
                }
            }
        }
    }

    fn reap(&mut self) -> Result<Option<Exit>> {
        while self.exit.is_none() {
            match rustix::process::waitpid(Some(self.pid), WaitOptions::NOHANG) {
                Ok(None) => return Ok(None),
                Ok(Some((_, status))) => {
                    self.exit = match (status.exit_status(), status.terminating_signal()) {
                        (Some(code), _) => Some(Exit::Code(code)),
                        (None, Some(number)) => Some(Exit::Signal(number)),
                        // Stopped or continued: not asked for, and not an end.
                        (None, None) => return Ok(None),
                    };
                }
                Err(Errno::INTR) => {}
                Err(source) => return Err(OsError::new("reap", self.pid().to_string(), source)),
            }
        }
        Ok(self.exit)
    }
}

impl Drop for Child {
    /// Leaves neither an orphan nor a zombie. SIGKILL cannot be refused, so the wait is short; a
    /// process that the kernel itself cannot end, as one that waits for a dead disk, is left to it.
    fn drop(&mut self) {
        children::forget(&self.pidfd);
        if self.exit.is_some() {
            return;
        }
        match self.kill().and_then(|()| self.wait_ms(exec::REAP_MS)) {
            Ok(Some(_)) => {}
            Ok(None) => tracing::warn!(pid = self.pid(), "a killed child does not end"),
            Err(error) => tracing::warn!(pid = self.pid(), %error, "a child may be left"),
        }
    }
}

/// The running program, even if its file was replaced or removed: parent and child cannot differ.
#[must_use]
pub fn self_exe() -> &'static Path {
    Path::new("/proc/self/exe")
}

/// A file descriptor that the parent put under this number, as this process's own.
///
/// It is a copy: the number itself stays open, so asking twice does no harm.
///
/// # Errors
///
/// If nothing was inherited under this number.
pub fn inherited(number: RawFd) -> Result<OwnedFd> {
    // SAFETY: the kernel looks the number up; nothing happens to what it finds.
    let copy = unsafe { libc::fcntl(number, libc::F_DUPFD_CLOEXEC, 3) };
    if copy < 0 {
        let error = std::io::Error::last_os_error();
        return Err(OsError::new("inherit file descriptor", number.to_string(), error));
    }
    // SAFETY: the kernel has just made this descriptor, and nothing else owns it.
    Ok(unsafe { OwnedFd::from_raw_fd(copy) })
}

/// Gives the calling thread a name that `ps` and `top` show; only 15 bytes of it count.
pub fn set_name(name: &str) {
    if let Ok(name) = std::ffi::CString::new(name)
        && let Err(error) = rustix::thread::set_name(&name)
    {
        tracing::debug!(%error, "the thread keeps its old name");
    }
}

/// Ends the calling process by this signal, as if the kernel had sent it: for fault injection.
#[cfg(feature = "faults")]
pub fn die_of(number: i32) {
    if let Some(signal) = Signal::from_named_raw(number) {
        // The first may only take away a handler, which waits for the fault to happen again.
        for _ in 0..3 {
            let _returned = rustix::process::kill_process(rustix::process::getpid(), signal);
        }
    }
}

/// A process started elsewhere, held so that its id cannot be reused by another.
#[derive(Debug)]
pub struct Held(OwnedFd);

impl Held {
    /// Takes hold of a process that is known to be unreaped.
    ///
    /// # Errors
    ///
    /// If there is none, or file descriptors ran out.
    pub fn of(pid: u32) -> Result<Self> {
        let number = i32::try_from(pid).ok().and_then(Pid::from_raw);
        let opened = number
            .ok_or(Errno::SRCH)
            .and_then(|pid| rustix::process::pidfd_open(pid, PidfdFlags::empty()));
        let pidfd = opened.map_err(OsError::at("take hold of process", &pid.to_string()))?;
        Ok(Self(pidfd))
    }

    /// Whether it has not ended yet.
    #[must_use]
    pub fn is_alive(&self) -> bool {
        let mut fds = [PollFd::new(&self.0, PollFlags::IN)];
        !matches!(rustix::event::poll(&mut fds, Some(&clock::timespec(0))), Ok(1))
    }

    /// Sends a signal by its number. Nothing happens if the process has ended.
    ///
    /// # Errors
    ///
    /// If there is no such signal, or the kernel refuses.
    pub fn signal(&self, number: i32) -> Result<()> {
        let sent = Signal::from_named_raw(number)
            .ok_or(Errno::INVAL)
            .and_then(|signal| rustix::process::pidfd_send_signal(&self.0, signal));
        match sent {
            Ok(()) | Err(Errno::SRCH) => Ok(()),
            Err(errno) => Err(OsError::new("send signal", number.to_string(), errno)),
        }
    }
}

/// Bounds this process permanently: address space in bytes, and CPU time in seconds.
///
/// Beyond the first, allocations fail; beyond the second it gets SIGXCPU, and SIGKILL a second
/// later. For a child that reads what a stranger wrote.
///
/// # Errors
///
/// If a limit is already lower.
pub fn limit_self(memory_bytes: u64, cpu_seconds: u64) -> Result<()> {
    let memory = Rlimit { current: Some(memory_bytes), maximum: Some(memory_bytes) };
    rustix::process::setrlimit(Resource::As, memory)
        .map_err(OsError::at("limit", "address space"))?;
    let cpu = Rlimit { current: Some(cpu_seconds), maximum: Some(cpu_seconds.saturating_add(1)) };
    rustix::process::setrlimit(Resource::Cpu, cpu).map_err(OsError::at("limit", "CPU time"))
}

#[cfg(test)]
mod tests;
