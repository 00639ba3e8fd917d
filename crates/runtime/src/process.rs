//! Child processes that cannot outlive us, and limits for ourselves.

use crate::{Doing as _, OsError, clock};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::process::{Pid, PidfdFlags, Signal, pidfd_open, pidfd_send_signal};
use std::fmt;
use std::os::fd::{AsFd, AsRawFd as _, BorrowedFd, OwnedFd, RawFd};
use std::os::unix::process::{CommandExt as _, ExitStatusExt as _};
use std::path::Path;
use std::process::{Command, ExitStatus};

/// This program, as the kernel knows it: a worker started from here cannot be of another version.
pub const SELF_EXE: &str = "/proc/self/exe";

/// What to start, and what it inherits.
#[derive(Debug)]
pub struct Spawn<'a> {
    /// Program file.
    pub program: &'a Path,
    /// Name that process listings show.
    pub name: &'a str,
    /// Arguments.
    pub args: &'a [String],
    /// Descriptors to inherit, each with its number there; numbers are below 64.
    pub fds: &'a [(BorrowedFd<'a>, RawFd)],
    /// The core to stay on.
    pub core: Option<usize>,
}

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
            Self::Signal(signal) => write!(f, "signal {signal}"),
        }
    }
}

impl From<ExitStatus> for Exit {
    fn from(status: ExitStatus) -> Self {
        match status.code() {
            Some(code) => Self::Code(code),
            None => Self::Signal(status.signal().unwrap_or(0)),
        }
    }
}

/// A child process. Dropped, it is killed and reaped: neither orphan nor zombie is left.
#[derive(Debug)]
pub struct Child {
    inner: std::process::Child,
    pidfd: OwnedFd,
    exit: Option<Exit>,
}

/// Starts a process that dies with the calling **thread**: call from one that lives long enough.
///
/// # Errors
///
/// If the program cannot be started, pinned, or handed its descriptors.
pub fn spawn(spec: &Spawn<'_>) -> Result<Child, OsError> {
    let doing = || format!("start {} {}", spec.name, spec.args.first().map_or("", String::as_str));
    // Moved out of the way first, so that no target number is in use as a source.
    let mut moved = Vec::new();
    for (fd, target) in spec.fds {
        let source = rustix::io::fcntl_dupfd_cloexec(fd, 64).doing(doing)?;
        moved.push((source, *target));
    }
    let parent = rustix::process::getpid();
    let core = spec.core;
    let mut command = Command::new(spec.program);
    command.arg0(spec.name).args(spec.args).stdin(std::process::Stdio::null());
    let before_exec = move || -> std::io::Result<()> {
        rustix::process::set_parent_process_death_signal(Some(Signal::KILL))?;
        // The parent may have died before that took effect.
        if rustix::process::getppid() != Some(parent) {
            return Err(std::io::Error::other("the parent is gone"));
        }
        for (source, target) in &moved {
            // SAFETY: a system call on two numbers; the target is not in use in the fresh child.
            if unsafe { libc::dup2(source.as_raw_fd(), *target) } < 0 {
                return Err(std::io::Error::last_os_error());
            }
        }
        if let Some(core) = core {
            let mut set = rustix::thread::CpuSet::new();
            if core < rustix::thread::CpuSet::MAX_CPU {
                set.set(core);
            }
            rustix::thread::sched_setaffinity(None, &set)?;
        }
        Ok(())
    };
    // SAFETY: between fork and exec only system calls are made; nothing allocates or locks.
    unsafe { command.pre_exec(before_exec) };
    let inner = command.spawn().doing(doing)?;
    let pid = Pid::from_child(&inner);
    let pidfd = pidfd_open(pid, PidfdFlags::empty()).doing(|| "watch a child process".to_owned());
    match pidfd {
        Ok(pidfd) => Ok(Child { inner, pidfd, exit: None }),
        Err(error) => {
            let mut inner = inner;
            let _killed = inner.kill();
            let _reaped = inner.wait();
            Err(error)
        }
    }
}

impl Child {
    /// Process id.
    #[must_use]
    pub fn pid(&self) -> u32 {
        self.inner.id()
    }

    /// Kills it, if it lives.
    pub fn kill(&self) {
        self.signal(Signal::KILL);
    }

    /// Asks it to end.
    pub fn terminate(&self) {
        self.signal(Signal::TERM);
    }

    fn signal(&self, signal: Signal) {
        // By descriptor, so a number that was given away again is never hit. Fails only when the
        // process is gone.
        let _gone = pidfd_send_signal(&self.pidfd, signal);
    }

    /// How it ended, if it has; reaps it.
    ///
    /// # Errors
    ///
    /// If the system does not say.
    pub fn try_wait(&mut self) -> Result<Option<Exit>, OsError> {
        if self.exit.is_none() {
            let status = self.inner.try_wait().doing(|| "ask after a child".to_owned())?;
            self.exit = status.map(Exit::from);
        }
        Ok(self.exit)
    }

    /// Waits for its end, at most so long.
    ///
    /// # Errors
    ///
    /// If the system does not say.
    pub fn wait_ns(&mut self, timeout_ns: u64) -> Result<Option<Exit>, OsError> {
        let end = clock::now_ns().saturating_add(timeout_ns);
        loop {
            if let Some(exit) = self.try_wait()? {
                return Ok(Some(exit));
            }
            let left = end.saturating_sub(clock::now_ns());
            if left == 0 {
                return Ok(None);
            }
            let left = Timespec {
                tv_sec: (left / 1_000_000_000) as i64,
                tv_nsec: (left % 1_000_000_000) as _,
            };
            let mut fds = [PollFd::new(&self.pidfd, PollFlags::IN)];
            match poll(&mut fds, Some(&left)) {
                Ok(_) | Err(rustix::io::Errno::INTR) => {}
                Err(error) => return Err(OsError::new("wait for a child", error)),
            }
        }
    }
}

impl AsFd for Child {
    /// The pidfd: readable once the process has ended.
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.pidfd.as_fd()
    }
}

impl Drop for Child {
    fn drop(&mut self) {
        if self.exit.is_none() {
            self.kill();
            let _reaped = self.inner.wait();
        }
    }
}

/// What the system says of a process.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ProcStat {
    /// R running, S sleeping, T stopped, Z zombie, ...
    pub state: char,
    /// CPU time used, user and system [ns], in steps of a clock tick.
    pub cpu_ns: u64,
}

/// Reads `/proc/PID/stat`; `None` if there is no such process.
#[must_use]
pub fn stat(pid: u32) -> Option<ProcStat> {
    let text = std::fs::read_to_string(format!("/proc/{pid}/stat")).ok()?;
    // The name is in parentheses and may contain anything, spaces and parentheses too.
    let mut fields = text.rsplit_once(") ")?.1.split(' ');
    let state = fields.next()?.chars().next()?;
    let mut ticks = || fields.next().and_then(|field| field.parse::<u64>().ok());
    for _ in 0..10 {
        ticks();
    }
    let cpu = ticks()? + ticks()?;
    let per_second = rustix::param::clock_ticks_per_second().max(1);
    Some(ProcStat { state, cpu_ns: cpu * (1_000_000_000 / per_second) })
}

/// Limits this process, for work on untrusted input: address space and CPU time.
///
/// # Errors
///
/// If the system refuses.
pub fn limit_self(memory_bytes: u64, cpu_seconds: u64) -> Result<(), OsError> {
    use rustix::process::{Resource, Rlimit, setrlimit};
    let set = |what, most| {
        setrlimit(what, Rlimit { current: Some(most), maximum: Some(most) })
            .doing(|| "limit this process".to_owned())
    };
    set(Resource::As, memory_bytes)?;
    set(Resource::Cpu, cpu_seconds)?;
    set(Resource::Core, 0)
}

#[cfg(test)]
mod tests;
