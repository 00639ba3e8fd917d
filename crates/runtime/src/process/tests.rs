//! Children get what they are given, are watched, and are never left behind.

use super::*;
use std::io::Read as _;
use std::os::unix::net::UnixStream;

fn sh(script: &str) -> Spawn<'static> {
    let args: &'static [String] = vec!["-c".to_owned(), script.to_owned()].leak();
    Spawn { program: Path::new("/bin/sh"), name: "sh", args, fds: &[], core: None }
}

const LONG: u64 = 20_000_000_000;

#[test]
fn a_child_is_watched_to_its_end() {
    let mut child = spawn(&sh("exit 7")).unwrap();
    assert_eq!(child.wait_ns(LONG).unwrap(), Some(Exit::Code(7)));
    let mut child = spawn(&sh("exec sleep 60")).unwrap();
    assert_eq!(child.wait_ns(1).unwrap(), None);
    assert!(stat(child.pid()).is_some());
    child.kill();
    assert_eq!(child.wait_ns(LONG).unwrap(), Some(Exit::Signal(9)));
    assert_eq!(stat(child.pid()), None, "reaped");
}

#[test]
fn a_dropped_child_is_gone() {
    let child = spawn(&sh("exec sleep 60")).unwrap();
    let pid = child.pid();
    drop(child);
    assert_eq!(stat(pid), None);
}

#[test]
fn a_child_dies_with_the_thread_that_started_it() {
    let start = || {
        let child = spawn(&sh("exec sleep 60")).unwrap();
        (child.pid(), child)
    };
    let (pid, mut child) = std::thread::spawn(start).join().unwrap();
    assert_eq!(child.wait_ns(LONG).unwrap(), Some(Exit::Signal(9)), "{pid}");
}

#[test]
fn descriptors_arrive_under_their_numbers_even_when_they_overlap() {
    let (mut ours, theirs) = UnixStream::pair().unwrap();
    let (mut ours_too, theirs_too) = UnixStream::pair().unwrap();
    let swapped =
        [(theirs.as_fd(), theirs_too.as_raw_fd()), (theirs_too.as_fd(), theirs.as_raw_fd())];
    let script = format!("echo a >&{}; echo b >&{}", theirs_too.as_raw_fd(), theirs.as_raw_fd());
    let mut child = spawn(&Spawn { fds: &swapped, ..sh(&script) }).unwrap();
    assert_eq!(child.wait_ns(LONG).unwrap(), Some(Exit::Code(0)));
    drop((theirs, theirs_too));
    let (mut text, mut text_too) = (String::new(), String::new());
    ours.read_to_string(&mut text).unwrap();
    ours_too.read_to_string(&mut text_too).unwrap();
    assert_eq!((text.as_str(), text_too.as_str()), ("a\n", "b\n"));
}

#[test]
fn a_child_stays_on_its_core_and_a_core_that_is_not_there_is_an_error() {
    let core = *crate::affinity::allowed_cores().unwrap().last().unwrap();
    let script = format!("grep -q 'Cpus_allowed_list:.{core}$' /proc/self/status");
    let mut child = spawn(&Spawn { core: Some(core), ..sh(&script) }).unwrap();
    assert_eq!(child.wait_ns(LONG).unwrap(), Some(Exit::Code(0)));
    assert!(spawn(&Spawn { core: Some(1023), ..sh("true") }).is_err());
}
