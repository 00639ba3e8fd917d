//! How a process ends that the C library aborts, as it does if it gets no memory itself.

#![cfg(target_env = "gnu")]

use std::os::unix::process::ExitStatusExt as _;
use std::process::{Command, Output};
use trolley_runtime::heap::explain_aborts;
use trolley_runtime::process::limit_self;

/// Tells the test [`child`] that it is a child, and how much memory it may have.
const MEMORY: &str = "TROLLEY_ABORT_MEMORY";

/// As a test it does nothing: it is what the tests below start.
#[test]
#[expect(clippy::disallowed_methods, reason = "a test binary has no command line of its own")]
fn child() {
    let Ok(bytes) = std::env::var(MEMORY) else { return };
    explain_aborts();
    limit_self(bytes.parse().expect("a number"), 600).expect("lower than before");
    std::process::abort();
}

fn aborted(bytes: u64) -> Output {
    let this = std::env::current_exe().expect("a path");
    let script = "ulimit -c 0; exec \"$0\" --exact --nocapture child";
    let mut bash = Command::new("bash");
    bash.args(["-c", script]).arg(this).env(MEMORY, bytes.to_string());
    bash.output().expect("bash is there")
}

#[test]
fn without_memory_an_abort_is_an_exit_that_says_so() {
    let ended = aborted(1);
    let error = String::from_utf8_lossy(&ended.stderr);
    assert_eq!(ended.status.code(), Some(69), "{:?} {error}", ended.status);
    assert!(error.contains("error: out of memory"), "{error}");
}

#[test]
fn with_memory_an_abort_stays_one() {
    let ended = aborted(1 << 40);
    let error = String::from_utf8_lossy(&ended.stderr);
    assert_eq!(ended.status.signal(), Some(6), "{:?} {error}", ended.status);
}
