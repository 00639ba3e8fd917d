//! Counting the system calls of a child, and killing it at one of them: for fault injection.
//!
//! The thread that attaches is the one that may control: all of it happens inside one call. Stops
//! are found by asking for them and not by waiting, because any wait of another thread of this
//! process for the same child would take their reports away.

use super::{Held, spawn_stopped};
use crate::clock;
use crate::error::{OsError, Result};
use crate::process::Spawn;
use core::ffi::{c_int, c_uint};
use rustix::io::Errno;
use std::io;
use std::path::Path;

/// `si_code` of a stop for an event has the event above its lowest byte.
const EVENT_SHIFT: c_int = 8;
/// How long a child may take to stop when it is told to (ns).
const STOP_NS: u64 = 1_000_000_000;

/// What became of a traced child.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Traced {
    /// It was killed as it entered the call (ns, monotonic).
    Killed {
        /// When.
        at_ns: u64,
    },
    /// It ended before that, by itself or by another's hand.
    Ended {
        /// Calls that it had made since its exec.
        calls: u64,
    },
    /// It lives, and is not traced any more.
    Released {
        /// Calls that it had made since its exec.
        calls: u64,
    },
}

/// Whether this process may trace its children: some containers and kernels refuse.
#[must_use]
pub fn may_trace() -> bool {
    let what = Spawn { program: Path::new("/bin/true"), args: &[], fds: &[], core: None };
    let Ok(mut child) = spawn_stopped(what) else { return false };
    let end_ns = clock::now_ns() + STOP_NS;
    let traced = trace(child.pid(), None, |_| clock::now_ns() > end_ns);
    let is_reaped = child.wait_ms(STOP_NS / 1_000_000);
    matches!(traced, Ok(Traced::Ended { calls: 1.. })) && matches!(is_reaped, Ok(Some(_)))
}

/// Lets a child of [`spawn_stopped`] go on, counts the system calls of its first thread from exec
/// on, and kills it as it enters the `kill_at`th. Until then `is_over` is asked again and again,
/// with the time since its last stop (ns), whether to let it go.
///
/// # Errors
///
/// If the kernel does not permit to trace it.
pub fn trace(
    pid: u32,
    kill_at: Option<u64>,
    mut is_over: impl FnMut(u64) -> bool,
) -> Result<Traced> {
    let held = Held::of(pid)?;
    let tracee = Tracee(pid.cast_signed());
    tracee.seize().map_err(|source| OsError::new("trace process", pid.to_string(), source))?;
    held.signal(libc::SIGCONT)?;
    let (mut calls, mut has_executed) = (0, false);
    let (mut stopped_ns, mut asked_ns) = (clock::now_ns(), None);
    loop {
        let Some(stop) = tracee.stop() else {
            let now_ns = clock::now_ns();
            if !held.is_alive() {
                return Ok(Traced::Ended { calls });
            }
            match asked_ns {
                None if is_over(now_ns - stopped_ns) => {
                    tracee.interrupt();
                    asked_ns = Some(now_ns);
                }
                // The kernel detaches it when this thread ends.
                Some(asked_ns) if now_ns - asked_ns > STOP_NS => {
                    return Ok(Traced::Released { calls });
                }
                _ => rustix::thread::sched_yield(),
            }
            continue;
        };
        stopped_ns = clock::now_ns();
        if asked_ns.is_some() || is_over(0) {
            tracee.resume(libc::PTRACE_DETACH, stop.signal());
            return Ok(Traced::Released { calls });
        }
        match stop {
            Stop::Entry if has_executed => {
                calls += 1;
                if kill_at == Some(calls) {
                    held.signal(libc::SIGKILL)?;
                    return Ok(Traced::Killed { at_ns: stopped_ns });
                }
            }
            Stop::Event(libc::PTRACE_EVENT_EXEC) => has_executed = true,
            Stop::Entry | Stop::Exit | Stop::Event(_) | Stop::Signal(_) => {}
        }
        tracee.resume(libc::PTRACE_SYSCALL, stop.signal());
    }
}

/// Why a traced child stands still.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stop {
    /// It enters a system call.
    Entry,
    /// It leaves one.
    Exit,
    /// Something that was asked for, or that concerns tracing alone.
    Event(c_int),
    /// It is about to receive this signal.
    Signal(c_int),
}

impl Stop {
    /// What it receives when it goes on. Its own SIGSTOP was for the tracer.
    fn signal(self) -> c_int {
        match self {
            Self::Signal(number) if number != libc::SIGSTOP => number,
            _ => 0,
        }
    }
}

/// A child that is traced, by its process id: it was not reaped when it was seized, and a call for
/// one that this thread does not trace fails.
#[derive(Debug)]
struct Tracee(c_int);

impl Tracee {
    fn seize(&self) -> io::Result<()> {
        let options = libc::PTRACE_O_TRACESYSGOOD | libc::PTRACE_O_TRACEEXEC;
        // SAFETY: no memory is passed.
        match unsafe { libc::ptrace(libc::PTRACE_SEIZE, self.0, 0, options) } {
            0 => Ok(()),
            _ => Err(io::Error::last_os_error()),
        }
    }

    fn interrupt(&self) {
        // SAFETY: no memory is passed. A child that has ended needs no interruption.
        unsafe { libc::ptrace(libc::PTRACE_INTERRUPT, self.0, 0, 0) };
    }

    fn resume(&self, how: c_uint, signal: c_int) {
        // SAFETY: no memory is passed. It fails if the child was killed meanwhile.
        unsafe { libc::ptrace(how, self.0, 0, signal) };
    }

    /// Why it stands still; `None` if it does not.
    fn stop(&self) -> Option<Stop> {
        // SAFETY: every bit pattern is such a struct.
        let mut info: libc::ptrace_syscall_info = unsafe { core::mem::zeroed() };
        let (call, size) = (libc::PTRACE_GET_SYSCALL_INFO, size_of_val(&info));
        // SAFETY: the kernel writes at most `size` bytes, and nothing if the child does not stand
        // still or is not traced here.
        if unsafe { libc::ptrace(call, self.0, size, &raw mut info) } <= 0 {
            return None;
        }
        match info.op {
            libc::PTRACE_SYSCALL_INFO_ENTRY => return Some(Stop::Entry),
            libc::PTRACE_SYSCALL_INFO_EXIT => return Some(Stop::Exit),
            _ => {}
        }
        // SAFETY: every bit pattern is such a struct.
        let mut about: libc::siginfo_t = unsafe { core::mem::zeroed() };
        // SAFETY: the kernel writes one such struct, or nothing.
        let done = unsafe { libc::ptrace(libc::PTRACE_GETSIGINFO, self.0, 0, &raw mut about) };
        let event = about.si_code >> EVENT_SHIFT;
        Some(match done {
            0 if event <= 0 => Stop::Signal(about.si_signo),
            // Killed meanwhile, or stopped without a signal.
            _ => Stop::Event(event),
        })
    }
}

/// A thread of another process that stands still while the others of that process run: as one that
/// waits for a lock, a device or a bug. It goes on when this is dropped.
///
/// It belongs to the thread that made it.
#[derive(Debug)]
pub struct Frozen {
    tracee: Tracee,
    here: core::marker::PhantomData<*const ()>,
}

impl Frozen {
    /// Stops the first thread of a process that this one started, or that its children did.
    ///
    /// # Errors
    ///
    /// If the kernel does not permit to trace it, or it does not stop within 1 s.
    pub fn first_thread(pid: u32) -> Result<Self> {
        let tracee = Tracee(pid.cast_signed());
        tracee.seize().map_err(|source| OsError::new("trace process", pid.to_string(), source))?;
        let frozen = Self { tracee, here: core::marker::PhantomData };
        frozen.tracee.interrupt();
        let end_ns = clock::now_ns() + STOP_NS;
        // The report of the stop is taken, too: the parent of the process waits for its end alone.
        while !frozen.has_reported() {
            if clock::now_ns() > end_ns {
                return Err(OsError::new("stop process", pid.to_string(), Errno::TIMEDOUT));
            }
            rustix::thread::sched_yield();
        }
        Ok(frozen)
    }

    /// Takes the report that it has ended, so that its parent gets it; `false` if it has not.
    ///
    /// Until then a process that was killed stays a zombie. For one whose parent is another
    /// process: a child of this one is reaped by it.
    #[must_use]
    pub fn has_ended(&self) -> bool {
        self.has_reported()
    }

    fn has_reported(&self) -> bool {
        let flags = libc::WNOHANG | libc::__WALL;
        // SAFETY: the status is not asked for.
        unsafe { libc::waitpid(self.tracee.0, core::ptr::null_mut(), flags) == self.tracee.0 }
    }
}

impl Drop for Frozen {
    fn drop(&mut self) {
        self.tracee.resume(libc::PTRACE_DETACH, 0);
    }
}

#[cfg(test)]
mod tests {
    //! Calls are counted the same each time, and the one that is asked for is the last.
    use super::*;
    use crate::process::{Child, Exit};

    fn start(program: &str, args: &[&str]) -> Child {
        let args: Vec<String> = args.iter().map(|&arg| arg.to_owned()).collect();
        let what = Spawn { program: Path::new(program), args: &args, fds: &[], core: None };
        spawn_stopped(what).unwrap()
    }

    #[test]
    fn a_child_is_killed_at_each_of_its_calls() {
        if !may_trace() {
            return;
        }
        let mut child = start("/bin/true", &[]);
        let Traced::Ended { calls } = trace(child.pid(), None, |_| false).unwrap() else {
            panic!("it ends by itself")
        };
        assert_eq!(child.wait_ms(1_000).unwrap(), Some(Exit::Code(0)));
        assert!(calls > 3, "{calls}");
        for call in 1..=calls {
            let mut child = start("/bin/true", &[]);
            let traced = trace(child.pid(), Some(call), |_| false).unwrap();
            assert!(matches!(traced, Traced::Killed { .. }), "{call} of {calls}: {traced:?}");
            assert_eq!(child.wait_ms(1_000).unwrap(), Some(Exit::Signal(libc::SIGKILL)));
        }
        let mut child = start("/bin/true", &[]);
        let traced = trace(child.pid(), Some(calls + 1), |_| false).unwrap();
        assert_eq!(traced, Traced::Ended { calls });
        assert_eq!(child.wait_ms(1_000).unwrap(), Some(Exit::Code(0)));
    }

    #[test]
    fn a_child_that_waits_is_let_go_and_goes_on() {
        if !may_trace() {
            return;
        }
        let mut child = start("/bin/sh", &["-c", "sleep 0.3; exit 7"]);
        let traced = trace(child.pid(), Some(100_000), |idle_ns| idle_ns > 50_000_000).unwrap();
        assert!(matches!(traced, Traced::Released { calls: 4.. }), "{traced:?}");
        assert_eq!(child.wait_ms(5_000).unwrap(), Some(Exit::Code(7)));
    }
}
