//! Real children: what they inherit, how they end, and that none is left.

use super::*;
use crate::affinity;
use crate::testing;
use std::io::Read;
use std::os::fd::AsRawFd;
use std::sync::mpsc;

fn shell_on(core: Option<usize>, script: &str, fds: &[(BorrowedFd<'_>, RawFd)]) -> Child {
    let args = ["-c", script].map(str::to_owned);
    spawn(Spawn { program: Path::new("/bin/sh"), args: &args, fds, core })
        .and_then(|child| child.await_exec(30_000))
        .unwrap()
}

fn shell(script: &str, fds: &[(BorrowedFd<'_>, RawFd)]) -> Child {
    shell_on(None, script, fds)
}

/// What a script writes to its standard output.
fn output(core: Option<usize>, script: &str, fds: &[(BorrowedFd<'_>, RawFd)]) -> String {
    let (mut read, write) = std::io::pipe().unwrap();
    let fds: Vec<_> = fds.iter().copied().chain([(write.as_fd(), 1)]).collect();
    let child = shell_on(core, script, &fds);
    drop(fds);
    drop(write);
    let mut text = String::new();
    read.read_to_string(&mut text).unwrap();
    testing::must_pass(child);
    text
}

fn memory(text: &str) -> crate::SealedMemory {
    crate::SealedMemory::create("test", text.len(), |bytes| bytes.copy_from_slice(text.as_bytes()))
        .unwrap()
}

#[test]
fn a_child_says_how_it_ended() {
    let mut child = shell("exit 7", &[]);
    assert_eq!(child.wait_ms(30_000).unwrap(), Some(Exit::Code(7)));
    assert_eq!(child.try_wait().unwrap(), Some(Exit::Code(7)), "and says it again");
    child.kill().unwrap();

    let mut child = shell("kill -SEGV $$", &[]);
    let exit = child.wait_ms(30_000).unwrap().unwrap();
    assert_eq!(exit, Exit::Signal(libc::SIGSEGV));
    assert_eq!(exit.to_string(), "SIGSEGV");
    assert_eq!(Exit::Code(76).to_string(), "exit code 76");
    assert_eq!(Exit::Signal(40).to_string(), "signal 40");
}

#[test]
fn a_child_is_killed_however_it_resists() {
    let mut child = shell("trap '' TERM; kill -STOP $$; while :; do :; done", &[]);
    assert_eq!(child.wait_ms(20).unwrap(), None);
    child.signal(libc::SIGTERM).unwrap();
    assert_eq!(child.try_wait().unwrap(), None);
    child.kill().unwrap();
    assert_eq!(child.wait_ms(30_000).unwrap(), Some(Exit::Signal(libc::SIGKILL)));
}

#[test]
fn a_dropped_child_is_dead_and_reaped() {
    let child = shell("exec sleep 1000", &[]);
    let pid = child.pid();
    assert!(stat(pid).is_some());
    drop(child);
    assert_eq!(stat(pid), None);
}

#[test]
fn a_stopped_child_is_seen_as_stopped() {
    let child = shell("exec sleep 1000", &[]);
    child.signal(libc::SIGSTOP).unwrap();
    let end = clock::now_ns() + 30_000_000_000;
    while stat(child.pid()).unwrap().state != 'T' {
        assert!(clock::now_ns() < end);
        std::thread::yield_now();
    }
}

#[test]
fn descriptors_arrive_under_their_numbers() {
    let (a, b) = (memory("alpha"), memory("beta"));
    let fds = [(a.fd(), 30), (b.fd(), 10)];
    assert_eq!(output(None, "cat /dev/fd/30 /dev/fd/10", &fds), "alphabeta");
    // Each number is the other's source: one must not be overwritten before it was copied.
    let (a_number, b_number) = (a.fd().as_raw_fd(), b.fd().as_raw_fd());
    let fds = [(a.fd(), b_number), (b.fd(), a_number)];
    let script = format!("cat /dev/fd/{b_number} /dev/fd/{a_number}");
    assert_eq!(output(None, &script, &fds), "alphabeta");
    // The number that a descriptor has already.
    let script = format!("cat /dev/fd/{a_number}");
    assert_eq!(output(None, &script, &[(a.fd(), a_number)]), "alpha");
}

#[test]
fn nothing_else_is_inherited() {
    // As a careless library would: not close-on-exec. The number is above what a shell itself uses.
    let (memory, null) = (memory("x"), std::fs::File::open("/dev/null").unwrap());
    let leak = rustix::io::fcntl_dupfd_cloexec(&null, 500).unwrap();
    rustix::io::fcntl_setfd(&leak, rustix::io::FdFlags::empty()).unwrap();
    let script = "for f in /proc/$$/fd/*; do echo ${f##*/}; done";
    let listed = output(None, script, &[(memory.fd(), 400)]);
    let mut numbers: Vec<i32> = listed.lines().map(|line| line.parse().unwrap()).collect();
    numbers.retain(|number| *number < 3 || *number >= 100);
    numbers.sort_unstable();
    assert_eq!(numbers, [0, 1, 2, 400]);
    assert!(leak.as_raw_fd() >= 500);
}

#[test]
fn a_child_blocks_no_signal_and_has_its_own_group() {
    let mut poller = crate::wait::Poller::new().unwrap();
    poller.catch_signals().unwrap();
    let blocked = |text: String| {
        let line = text.lines().find(|line| line.starts_with("SigBlk:")).unwrap().to_owned();
        u64::from_str_radix(line.trim_start_matches("SigBlk:").trim(), 16).unwrap()
    };
    assert_ne!(blocked(std::fs::read_to_string("/proc/thread-self/status").unwrap()), 0);
    assert_eq!(blocked(output(None, "cat /proc/self/status", &[])), 0);

    let child = shell("exec sleep 1000", &[]);
    let group = rustix::process::getpgid(Some(child.pid)).unwrap();
    assert_eq!(group, child.pid, "a Ctrl-C is not for it");
}

#[test]
fn a_child_is_kept_on_its_core() {
    for core in affinity::allowed_cores() {
        let text = output(Some(core), "grep Cpus_allowed_list /proc/self/status", &[]);
        assert_eq!(text.split_whitespace().last(), Some(core.to_string().as_str()));
    }
}

#[test]
fn what_cannot_be_started_is_an_error_and_leaves_nobody() {
    let absent = Path::new("/absent/program");
    let fds = [];
    let what = Spawn { program: absent, args: &[], fds: &fds, core: None };
    let error = spawn(what).unwrap().await_exec(30_000).unwrap_err();
    assert_eq!(error.io_kind(), std::io::ErrorKind::NotFound);
    assert!(error.to_string().contains("/absent/program"), "{error}");
    // Who does not wait finds the same.
    let mut child = spawn(what).unwrap();
    assert_eq!(child.wait_ms(30_000).unwrap(), Some(Exit::Code(127)));
    assert!(child.has_executed());
    assert_eq!(child.exec_error().unwrap().to_string(), error.to_string());

    let shell = Path::new("/bin/sh");
    for core in [1_000, usize::MAX] {
        let what = Spawn { program: shell, args: &[], fds: &fds, core: Some(core) };
        let error = spawn(what).and_then(|child| child.await_exec(30_000)).unwrap_err();
        assert_eq!(error.io_kind(), std::io::ErrorKind::InvalidInput);
    }
    let nul = ["a\0b".to_owned()];
    assert!(spawn(Spawn { program: shell, args: &nul, fds: &fds, core: None }).is_err());
    let memory = memory("x");
    let fds = [(memory.fd(), -1)];
    assert!(spawn(Spawn { program: shell, args: &[], fds: &fds, core: None }).is_err());
}

/// PR_SET_PDEATHSIG is about the thread: the child must die although its process goes on.
#[test]
fn a_child_dies_with_the_thread_that_started_it() {
    let (send, receive) = mpsc::channel();
    std::thread::spawn(move || send.send(shell("exec sleep 1000", &[])).unwrap()).join().unwrap();
    let mut child = receive.recv().unwrap();
    assert_eq!(child.wait_ms(30_000).unwrap(), Some(Exit::Signal(libc::SIGKILL)));
}

/// Grandparent (this test), parent (this test again), child (a shell): kill the parent.
#[test]
fn a_child_dies_with_its_killed_parent() {
    if let Some(fd) = testing::handed_over() {
        let child = shell("exec sleep 1000", &[]);
        rustix::io::write(&fd, &child.pid().to_ne_bytes()).unwrap();
        loop {
            std::thread::park();
        }
    }
    let (read, write) = std::io::pipe().unwrap();
    let mut parent =
        testing::again("process::tests::a_child_dies_with_its_killed_parent", write.as_fd());
    drop(write);
    let mut pid = [0; 4];
    (&read).read_exact(&mut pid).unwrap();
    let pid = u32::from_ne_bytes(pid);
    assert!(stat(pid).is_some_and(|stat| stat.state != 'Z'));
    parent.kill().unwrap();
    assert_eq!(parent.wait_ms(30_000).unwrap(), Some(Exit::Signal(libc::SIGKILL)));
    let end = clock::now_ns() + 30_000_000_000;
    // The process that adopted it may reap it late.
    while stat(pid).is_some_and(|stat| stat.state != 'Z') {
        assert!(clock::now_ns() < end, "an orphan lives");
        std::thread::yield_now();
    }
}

#[test]
fn a_limited_process_runs_out_of_memory_and_time_alone() {
    if testing::handed_over().is_some() {
        limit_self(256 << 20, 1).unwrap();
        assert!(Vec::<u8>::new().try_reserve_exact(512 << 20).is_err());
        assert!(Vec::<u8>::new().try_reserve_exact(16 << 20).is_ok());
        loop {
            core::hint::spin_loop();
        }
    }
    let memory = memory("x");
    let name = "process::tests::a_limited_process_runs_out_of_memory_and_time_alone";
    let mut child = testing::again(name, memory.fd());
    assert_eq!(child.wait_ms(60_000).unwrap(), Some(Exit::Signal(libc::SIGXCPU)));
}

#[test]
fn what_was_not_inherited_is_not_there() {
    assert!(inherited(901).is_err());
    assert!(inherited(-1).is_err());
}

#[test]
fn a_child_has_the_environment_it_was_given_and_no_other() {
    let (mut read, write) = std::io::pipe().unwrap();
    let fds = [(write.as_fd(), 1)];
    let what = Spawn { program: Path::new("/usr/bin/env"), args: &[], fds: &fds, core: None };
    let env = [("WORD".into(), "a=b".into())];
    let child = spawn_with_env(what, &env).unwrap().await_exec(30_000).unwrap();
    drop(write);
    let mut text = String::new();
    read.read_to_string(&mut text).unwrap();
    testing::must_pass(child);
    assert_eq!(text, "WORD=a=b\n");
}

#[cfg(feature = "faults")]
#[test]
fn a_child_that_stops_before_exec_holds_nobody_up() {
    let begun_ns = clock::now_ns();
    let args = ["1000".to_owned()];
    let what = Spawn { program: Path::new("/bin/sleep"), args: &args, fds: &[], core: None };
    let mut child = spawn_stopped(what).unwrap();
    let pid = child.pid();
    while stat(pid).unwrap().state != 'T' {
        assert!(clock::now_ns() - begun_ns < 10_000_000_000);
        std::thread::yield_now();
    }
    assert!(!child.has_executed() && child.exec_error().is_none());
    let error = child.await_exec(50).unwrap_err();
    assert_eq!(error.io_kind(), std::io::ErrorKind::TimedOut);
    assert_eq!(stat(pid), None, "killed and reaped");
    // One that goes on runs.
    let child = spawn_stopped(what).unwrap();
    while stat(child.pid()).unwrap().state != 'T' {
        std::thread::yield_now();
    }
    child.signal(libc::SIGCONT).unwrap();
    let child = child.await_exec(30_000).unwrap();
    child.kill().unwrap();
}
