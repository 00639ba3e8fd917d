//! How a process ends that the C library aborts, as it does if it gets no memory itself.

#![cfg(target_env = "gnu")]

use std::io::{BufRead as _, BufReader};
use std::os::unix::process::ExitStatusExt as _;
use std::process::{Command, Output, Stdio};
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
    if bytes == WAITS {
        println!("{WAITS}");
        std::thread::sleep(std::time::Duration::from_secs(600));
    }
    limit_self(bytes.parse().expect("a number"), 600).expect("lower than before");
    std::process::abort();
}

/// What a child is told that does not abort, and what it says then.
const WAITS: &str = "waits";

fn started(bytes: &str) -> Command {
    let this = std::env::current_exe().expect("a path");
    let script = "ulimit -c 0; exec \"$0\" --exact --nocapture child";
    let mut bash = Command::new("bash");
    bash.args(["-c", script]).arg(this).env(MEMORY, bytes);
    bash
}

fn aborted(bytes: u64) -> Output {
    started(&bytes.to_string()).output().expect("bash is there")
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

#[test]
fn whoever_is_told_to_abort_ends() {
    let mut child = started(WAITS).stdout(Stdio::piped()).spawn().expect("bash is there");
    let lines = BufReader::new(child.stdout.take().expect("piped")).lines();
    assert!(lines.map_while(Result::ok).any(|line| line.contains(WAITS)));
    let pid = child.id().to_string();
    assert!(Command::new("kill").args(["-ABRT", &pid]).status().expect("a program").success());
    assert_eq!(child.wait().expect("its child").signal(), Some(6));
}
