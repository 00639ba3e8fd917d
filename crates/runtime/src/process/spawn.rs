//! Starting a child: fork, a few system calls, exec.
//!
//! `std::process::Command` is not used, because the file descriptor on which it reports a failed
//! exec may be one of the numbers that a child is to inherit, and would be overwritten unseen.
//!
//! Between fork and exec the child has one thread and a copy of locks that others may have held:
//! it makes system calls and nothing else. No allocation, no lock, no panic.
//!
//! The parent does not wait for exec: a child can be stopped, or wait for a slow disk, on the way.
//! Whether exec failed comes through a pipe that [`Child`] keeps.

use super::Child;
use super::children;
use super::exec::ExecPipe;
use crate::affinity;
use crate::error::{OsError, Result};
use core::ffi::{c_char, c_int};
use core::ptr;
use rustix::io::Errno;
use rustix::process::{Pid, PidfdFlags, Signal};
use rustix::thread::CpuSet;
use std::ffi::{CString, OsString};
use std::fs::File;
use std::io;
use std::os::fd::{AsFd, AsRawFd, BorrowedFd, OwnedFd, RawFd};
use std::os::unix::ffi::OsStrExt;
use std::path::Path;

/// What to start.
#[derive(Clone, Copy, Debug)]
pub struct Spawn<'a> {
    /// The file to run; no search path.
    pub program: &'a Path,
    /// Arguments after the program's name.
    pub args: &'a [String],
    /// File descriptors to inherit, and the number each has in the child. No other one is
    /// inherited but 2: 0 and 1 are /dev/null, unless they are named here.
    pub fds: &'a [(BorrowedFd<'a>, RawFd)],
    /// The core to keep it on.
    pub core: Option<usize>,
}

/// Starts a child process.
///
/// It dies with the calling thread, is alone in its process group (a Ctrl-C at the terminal is for
/// the parent, who decides what becomes of its children), and blocks no signal.
///
/// Returns after the fork, without waiting for the program to run: see [`Child::await_exec`] and
/// [`Child::exec_error`].
///
/// # Errors
///
/// If there can be no child: no process, no file descriptors, no such core.
pub fn spawn(what: Spawn<'_>) -> Result<Child> {
    start(what, None, false)
}

/// [`spawn`], with these variables as the child's whole environment.
///
/// # Errors
///
/// As [`spawn`]; also if a variable contains a zero byte.
pub fn spawn_with_env(what: Spawn<'_>, env: &[(OsString, OsString)]) -> Result<Child> {
    start(what, Some(env), false)
}

/// [`spawn`], but the child stops itself before exec: for fault injection.
///
/// # Errors
///
/// As [`spawn`].
#[cfg(feature = "faults")]
pub fn spawn_stopped(what: Spawn<'_>) -> Result<Child> {
    start(what, None, true)
}

fn start(what: Spawn<'_>, env: Option<&[(OsString, OsString)]>, stops: bool) -> Result<Child> {
    let name = what.program.to_string_lossy().into_owned();
    let plan = Plan::new(what, env, stops)
        .map_err(|source| OsError::new("prepare", name.clone(), source))?;
    let failed = |source: io::Error| OsError::new("start", name.clone(), source);
    let (hear, low) = rustix::pipe::pipe_with(
        rustix::pipe::PipeFlags::CLOEXEC.union(rustix::pipe::PipeFlags::NONBLOCK),
    )
    .map_err(|errno| failed(errno.into()))?;
    // The child's end must not lie on a number that it is about to overwrite.
    let tell =
        rustix::io::fcntl_dupfd_cloexec(&low, plan.above).map_err(|errno| failed(errno.into()))?;
    drop(low);
    let (parent, thread) = (rustix::process::getpid(), rustix::thread::gettid());

    // SAFETY: the child calls `Plan::run` alone, which keeps to what is allowed after a fork.
    let pid = unsafe { libc::fork() };
    if pid == 0 {
        plan.run((parent, thread), tell.as_raw_fd());
    }
    let pid = Pid::from_raw(pid).filter(|_| pid > 0);
    let pid = pid.ok_or_else(|| failed(io::Error::last_os_error()))?;
    // The pipe must end when the child's copy is closed.
    drop(tell);
    // Not reaped yet, so the number is the child's even if it is dead.
    let opened = rustix::process::pidfd_open(pid, PidfdFlags::empty());
    let pidfd = opened.map_err(|errno| {
        let _nobody_to_tell = rustix::process::kill_process(pid, Signal::KILL);
        reap_killed(pid);
        failed(errno.into())
    })?;
    children::note(&pidfd);
    Ok(Child { pid, pidfd, exit: None, exec: ExecPipe::new(name, hear) })
}

/// Reaps a child without a pidfd that was killed. One that the kernel cannot end is left to it.
fn reap_killed(pid: Pid) {
    for _ in 0..super::exec::REAP_MS {
        match rustix::process::waitpid(Some(pid), rustix::process::WaitOptions::NOHANG) {
            Ok(None) | Err(Errno::INTR) => crate::clock::nap_ns(1_000_000),
            Ok(Some(_)) | Err(_) => return,
        }
    }
}

/// All that the child needs, made before the fork.
struct Plan {
    program: CString,
    /// Owns what `argv` points to.
    _args: Vec<CString>,
    /// Ends with a null pointer, as exec wants it.
    argv: Vec<*const c_char>,
    /// Owns what `envp` points to.
    _env: Vec<CString>,
    /// Ends with a null pointer; `None`: the parent's.
    envp: Option<Vec<*const c_char>>,
    /// Copies of the file descriptors, all with numbers above all targets, so that none is
    /// overwritten before it was copied; and the targets.
    fds: Vec<(OwnedFd, RawFd)>,
    /// Above all targets and the three standard ones.
    above: RawFd,
    core: Option<CpuSet>,
    /// Whether it stops itself before exec.
    stops: bool,
}

impl Plan {
    fn new(what: Spawn<'_>, env: Option<&[(OsString, OsString)]>, stops: bool) -> io::Result<Self> {
        let program = CString::new(what.program.as_os_str().as_bytes())?;
        let mut args = vec![program.clone()];
        for arg in what.args {
            args.push(CString::new(arg.as_bytes())?);
        }
        let argv = args.iter().map(|arg| arg.as_ptr()).chain([ptr::null()]).collect();
        let mut variables = Vec::new();
        for (name, value) in env.unwrap_or_default() {
            let mut variable = name.as_bytes().to_vec();
            variable.push(b'=');
            variable.extend_from_slice(value.as_bytes());
            variables.push(CString::new(variable)?);
        }
        let envp = env.map(|_| {
            variables.iter().map(|variable| variable.as_ptr()).chain([ptr::null()]).collect()
        });
        if what.fds.iter().any(|(_, target)| *target < 0) {
            return Err(io::ErrorKind::InvalidInput.into());
        }
        let above = what.fds.iter().map(|(_, target)| *target).fold(2, RawFd::max) + 1;
        let null = File::options().read(true).write(true).open("/dev/null")?;
        let named = |number: RawFd| what.fds.iter().any(|(_, target)| *target == number);
        let nulls = [0, 1].into_iter().filter(|n| !named(*n)).map(|n| (null.as_fd(), n));
        let fds = nulls
            .chain(what.fds.iter().copied())
            .map(|(fd, target)| Ok((rustix::io::fcntl_dupfd_cloexec(fd, above)?, target)))
            .collect::<io::Result<Vec<_>>>()?;
        let core = what.core.map(affinity::only).transpose()?;
        Ok(Self { program, _args: args, argv, _env: variables, envp, fds, above, core, stops })
    }

    /// The child's code before exec. If anything fails, it reports what and exits.
    fn run(&self, parent: (Pid, Pid), tell: RawFd) -> ! {
        let errno = self.prepare(parent).err().unwrap_or_else(|| self.exec());
        let bytes = errno.raw_os_error().to_ne_bytes();
        // SAFETY: pointer and length are those of `bytes`. If nothing reads them, nothing is lost.
        unsafe { libc::write(tell, bytes.as_ptr().cast(), bytes.len()) };
        exit(127)
    }

    fn prepare(&self, (parent, thread): (Pid, Pid)) -> core::result::Result<(), Errno> {
        rustix::process::set_parent_process_death_signal(Some(Signal::KILL))?;
        // If the parent, or its thread, died before that call, the signal is never sent.
        if rustix::process::getppid() != Some(parent) || !is_alive(parent, thread) {
            exit(127);
        }
        rustix::process::setpgid(None, None)?;
        if let Some(core) = &self.core {
            rustix::thread::sched_setaffinity(None, core)?;
        }
        close_on_exec_from(3);
        for (fd, target) in &self.fds {
            // SAFETY: both are plain numbers to the kernel; the child owns all of its descriptors,
            // and no Rust object here relies on what `target` was.
            if unsafe { libc::dup2(fd.as_raw_fd(), *target) } < 0 {
                return Err(last_errno());
            }
        }
        // The Rust runtime ignores SIGPIPE, and exec would hand that on.
        // SAFETY: no handler is installed, and the child has one thread.
        unsafe { libc::signal(libc::SIGPIPE, libc::SIG_DFL) };
        unblock_signals()?;
        if self.stops {
            rustix::process::kill_process(rustix::process::getpid(), Signal::STOP)?;
        }
        Ok(())
    }

    /// Returns only if it failed.
    fn exec(&self) -> Errno {
        let (program, argv) = (self.program.as_ptr(), self.argv.as_ptr());
        match &self.envp {
            // SAFETY: `program` and all of `argv` but its last are strings that `self` owns, and
            // the last is null.
            None => unsafe { libc::execv(program, argv) },
            // SAFETY: as above, and `envp` is like `argv`.
            Some(envp) => unsafe { libc::execve(program, argv, envp.as_ptr()) },
        };
        last_errno()
    }
}

/// Whether a process has this thread. Does not allocate.
fn is_alive(process: Pid, thread: Pid) -> bool {
    let (process, thread) = (process.as_raw_nonzero().get(), thread.as_raw_nonzero().get());
    // SAFETY: signal 0 is none: the kernel only looks for the thread.
    unsafe { libc::syscall(libc::SYS_tgkill, process, thread, 0) == 0 }
}

/// Marks what other libraries left open across exec, from this number on. Kernels before 5.11
/// cannot, and then only what was opened close-on-exec is closed.
fn close_on_exec_from(first: c_int) {
    // SAFETY: changes a flag of descriptors that this process, a child before exec, owns.
    unsafe {
        libc::syscall(libc::SYS_close_range, first, c_int::MAX, libc::CLOSE_RANGE_CLOEXEC);
    }
}

fn unblock_signals() -> core::result::Result<(), Errno> {
    let mut none = core::mem::MaybeUninit::<libc::sigset_t>::uninit();
    // SAFETY: `none` is a place for a set, and this call writes all of it.
    unsafe { libc::sigemptyset(none.as_mut_ptr()) };
    // SAFETY: `none` was written above; the old set is not asked for.
    let done = unsafe { libc::sigprocmask(libc::SIG_SETMASK, none.as_ptr(), ptr::null_mut()) };
    if done == 0 { Ok(()) } else { Err(last_errno()) }
}

/// Does not allocate.
fn last_errno() -> Errno {
    Errno::from_io_error(&io::Error::last_os_error()).unwrap_or(Errno::IO)
}

/// Ends at once: what `exit` would flush and tear down is the parent's.
fn exit(code: c_int) -> ! {
    // SAFETY: it has no preconditions.
    unsafe { libc::_exit(code) }
}

#[cfg(test)]
mod tests {
    //! A child that does not end is not waited for.
    use super::*;
    use std::sync::mpsc;
    use std::time::Duration;

    /// As the kernel leaves one for which killing is not enough.
    #[test]
    fn a_child_without_a_pidfd_that_does_not_end_is_given_up() {
        let mut child = std::process::Command::new("/bin/sleep").arg("60").spawn().unwrap();
        let pid = Pid::from_child(&child);
        let (done, is_done) = mpsc::channel();
        let begun_ns = crate::clock::now_ns();
        std::thread::spawn(move || {
            reap_killed(pid);
            done.send(crate::clock::now_ns() - begun_ns)
        });
        let took = is_done.recv_timeout(Duration::from_secs(20));
        let is_alive = child.try_wait().unwrap().is_none();
        child.kill().unwrap();
        child.wait().unwrap();
        assert!(is_alive, "it was not ended meanwhile");
        let took_ms = took.expect("it gives up") / 1_000_000;
        assert!(took_ms >= super::super::exec::REAP_MS, "{took_ms} ms");
    }
}
