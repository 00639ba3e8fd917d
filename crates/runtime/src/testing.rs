//! For tests: the test binary plays its own child.
//!
//! A test starts itself again with a file descriptor under [`MARK`]; by that the child knows that
//! it is one. The number is beyond what a test process ever opens.

use crate::process::{self, Child, Exit, Spawn};
use std::os::fd::{BorrowedFd, OwnedFd, RawFd};

/// Number of the file descriptor that makes a test the child.
pub(crate) const MARK: RawFd = 900;

/// What the parent handed over, if this is the child.
pub(crate) fn handed_over() -> Option<OwnedFd> {
    process::inherited(MARK).ok()
}

/// Starts the test of this name again, as its own child.
pub(crate) fn again(test: &str, hand_over: BorrowedFd<'_>) -> Child {
    let args = ["--exact", test, "--nocapture", "--test-threads=1"].map(str::to_owned);
    let fds = [(hand_over, MARK)];
    let spawn = Spawn { program: process::self_exe(), args: &args, fds: &fds, core: None };
    process::spawn(spawn).unwrap()
}

/// The child's test must pass.
pub(crate) fn must_pass(mut child: Child) {
    assert_eq!(child.wait_ms(20_000).unwrap(), Some(Exit::Code(0)));
}
