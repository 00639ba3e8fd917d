//! Whether a child's exec worked, without waiting for it.
//!
//! ```text
//! fork ──▶ a pipe, close-on-exec ──▶ its end: the program runs (or the child was killed)
//!                                └─▶ four bytes: exec failed with this error number
//! ```

use super::{Child, Exit};
use crate::clock;
use crate::error::{OsError, Result};
use rustix::event::{PollFd, PollFlags};
use rustix::io::Errno;
use std::io;
use std::os::fd::OwnedFd;

/// How long a killed child is waited for (ms): a process that the kernel cannot end is left to it.
pub(super) const REAP_MS: u64 = 1_000;

/// What is known of the exec of a child.
#[derive(Debug)]
pub(super) struct ExecPipe {
    program: String,
    state: State,
}

#[derive(Debug)]
enum State {
    /// It has not happened yet, as far as was read from this pipe.
    Pending(OwnedFd),
    /// The program runs, or the child ended on the way.
    Done,
    /// This error number.
    Failed(i32),
}

impl ExecPipe {
    /// `hear` must not block.
    pub(super) fn new(program: String, hear: OwnedFd) -> Self {
        Self { program, state: State::Pending(hear) }
    }

    /// Reads what has come. Never blocks.
    fn look(&mut self) {
        let State::Pending(hear) = &self.state else { return };
        let mut errno = [0; 4];
        self.state = match rustix::io::read(hear, &mut errno) {
            Err(Errno::AGAIN | Errno::INTR) => return,
            // A pipe writes four bytes at once or not at all.
            Ok(4) => State::Failed(i32::from_ne_bytes(errno)),
            Ok(_) | Err(_) => State::Done,
        };
    }

    fn error(&self) -> Option<OsError> {
        let State::Failed(errno) = self.state else { return None };
        let source = io::Error::from_raw_os_error(errno);
        Some(OsError::new("start", self.program.clone(), source))
    }
}

impl Child {
    /// Whether the program runs, or the child ended before it did; `false`: exec is still to come.
    pub fn has_executed(&mut self) -> bool {
        self.exec.look();
        !matches!(self.exec.state, State::Pending(_))
    }

    /// Why the program could not be run; `None` if it runs, or if that is not known yet. Such a
    /// child ends with exit code 127.
    pub fn exec_error(&mut self) -> Option<OsError> {
        self.exec.look();
        self.exec.error()
    }

    /// Waits until the program runs, at most `timeout_ms`. Otherwise there is no child any more.
    ///
    /// # Errors
    ///
    /// If the program cannot be run, or the child did not get as far in time: it is killed and
    /// reaped.
    pub fn await_exec(mut self, timeout_ms: u64) -> Result<Self> {
        let end = clock::now_ns().saturating_add(timeout_ms.saturating_mul(1_000_000));
        loop {
            self.exec.look();
            let left_ns = end.saturating_sub(clock::now_ns());
            let hear = match &self.exec.state {
                State::Done => return Ok(self),
                State::Failed(_) => break,
                State::Pending(hear) => hear,
            };
            if left_ns == 0 {
                let why = io::Error::new(
                    io::ErrorKind::TimedOut,
                    format!("it did not run within {timeout_ms} ms: stopped, or a slow disk"),
                );
                return Err(OsError::new("start", self.exec.program.clone(), why));
            }
            let mut fds = [PollFd::new(hear, PollFlags::IN)];
            match rustix::event::poll(&mut fds, Some(&clock::timespec(left_ns))) {
                Ok(_) | Err(Errno::INTR) => {}
                Err(source) => {
                    return Err(OsError::new("start", self.exec.program.clone(), source));
                }
            }
        }
        let _exit: Option<Exit> = self.wait_ms(REAP_MS)?;
        let unknown = || OsError::new("start", self.exec.program.clone(), Errno::IO);
        Err(self.exec.error().unwrap_or_else(unknown))
    }
}
