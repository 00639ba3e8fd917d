//! A process is killed at its K-th system call, for every K: a worker, a client and a server while
//! they start and work. What they leave stops nobody, and is removed.
//!
//! This program runs as its own child, under ptrace(2). The child makes a call that does not exist,
//! and its calls are counted from there.

#![expect(unsafe_code, reason = "ptrace has no safe interface")]

use protocol::public::{Ask, Reason, WireAnswer, WireState};
use protocol::{Boot, Head, Incarnation, MessageKind, RequestId};
use std::fs;
use std::io::Write as _;
use std::os::unix::process::CommandExt as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;
use trolley_transport::service::clean;
use trolley_transport::{Address, ClientPort, CoordinatorLink, Domain, Server, Sizes, WorkerLink};

type Outcome<T = ()> = Result<T, Box<dyn std::error::Error>>;

const SIZES: Sizes = Sizes { job_words: 64, job_queue: 4, result_words: 1024, result_queue: 8 };
const PEER: Incarnation = Incarnation { worker: 1, inc: 0 };
const BUILD: &str = "calls-test";
/// The number of no system call.
const MARK: i64 = 0x7ead;
/// What a surviving process may take for all it does after a kill: far more than it needs, far less
/// than forever.
const PATIENCE: Duration = Duration::from_secs(5);
/// More calls than any child makes.
const CALLS_MAX: usize = 4_000;

fn main() -> Outcome {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let text = |at: usize| words.get(at).map_or("", String::as_str);
    match text(0) {
        "worker" => worker(text(1)),
        "client" => client(Path::new(text(1))),
        "server" => server(Path::new(text(1))),
        // What a test runner asks a program.
        "--list" => Ok(()),
        _ if !may_trace() => {
            writeln!(std::io::stdout(), "SKIPPED: this machine does not permit ptrace")?;
            Ok(())
        }
        _ => {
            let mut out = std::io::stdout().lock();
            for (role, with) in
                [("worker", kill_worker as Kill), ("client", kill_client), ("server", kill_server)]
            {
                let calls = each_call(role, with)?;
                writeln!(out, "test {role} killed at each of {calls} calls ... ok")?;
            }
            Ok(())
        }
    }
}

/// A test for one K: returns whether the child was killed, and did not end before.
type Kill = fn(&Path, usize) -> Outcome<bool>;

/// Kills at the first call, the second, and so on, until the child ends by itself.
fn each_call(role: &str, kill: Kill) -> Outcome<usize> {
    for call in 1..CALLS_MAX {
        let folder = tempfile::Builder::new().prefix("c").tempdir_in("/dev/shm")?;
        let begun = now();
        let was_killed =
            kill(folder.path(), call).map_err(|e| format!("{role}, call {call}: {e}"))?;
        assert!(now() - begun < PATIENCE, "{role}, call {call}: {:?}", now() - begun);
        let left: Vec<_> = fs::read_dir(folder.path())?.flatten().map(|e| e.path()).collect();
        assert!(left.is_empty(), "{role}, call {call}: {left:?}");
        if !was_killed {
            return Ok(call);
        }
    }
    Err(format!("{role} makes more than {CALLS_MAX} calls").into())
}

fn numbered(sequence: u64) -> Box<Ask> {
    let mut ask = Ask::new(1.0);
    ask.sequence = sequence;
    ask
}

fn mark() {
    // SAFETY: there is no such call, and it has no arguments.
    unsafe { libc::syscall(MARK) };
}

// --- what the children do ---

fn worker(text: &str) -> Outcome {
    mark();
    let domain = Domain::open(text)?;
    let link = WorkerLink::open(&domain, PEER, &SIZES, BUILD)?;
    let hello = Head::new(domain.boot(), RequestId(0), PEER, MessageKind::Hello);
    link.results.loan()?.send(hello, 0)?;
    Ok(())
}

fn client(folder: &Path) -> Outcome {
    mark();
    let client = ClientPort::open(&address(folder)?)?;
    let pending = client.ask(&numbered(7))?;
    let _nobody_answers = pending.receive()?;
    Ok(())
}

fn server(folder: &Path) -> Outcome {
    mark();
    let server = Server::open(&address(folder)?)?;
    let _nobody_asks = server.take()?;
    Ok(())
}

fn address(folder: &Path) -> Outcome<Address> {
    Ok(Address::new(Some(folder), "calls")?)
}

// --- what is left for the others ---

/// The coordinator ends the incarnation, and starts the next one.
fn kill_worker(folder: &Path, call: usize) -> Outcome<bool> {
    let domain = Domain::create(Some(folder), "calls", Boot(call as u64))?;
    let link = CoordinatorLink::create(&domain, PEER, &SIZES, BUILD)?;
    let was_killed = run_to("worker", domain.text(), call)?;
    let mut scratch = Vec::new();
    while link.results.take(&mut scratch)?.is_some() {}
    drop(link);
    let next = Incarnation { inc: 1, ..PEER };
    let link = CoordinatorLink::create(&domain, next, &SIZES, BUILD)?;
    let entered = Domain::open(domain.text())?;
    let successor = WorkerLink::open(&entered, next, &SIZES, BUILD)?;
    let hello = Head::new(domain.boot(), RequestId(0), next, MessageKind::Hello);
    successor.results.loan()?.send(hello, 0)?;
    link.results.take(&mut scratch)?.ok_or("no hello")??;
    Ok(was_killed)
}

/// The server serves others, at once and after cleaning up.
fn kill_client(folder: &Path, call: usize) -> Outcome<bool> {
    let address = address(folder)?;
    let server = Server::open(&address)?;
    let was_killed = run_to("client", &folder.display().to_string(), call)?;
    ask_and_answer(&server, &address)?;
    let housekeeper = server.housekeeper();
    if let Some(place) = housekeeper.needs_cleaning() {
        clean(place);
    }
    if let Some(place) = housekeeper.needs_cleaning() {
        let nodes: Vec<_> =
            fs::read_dir(place.join("nodes"))?.flatten().map(|e| e.path()).collect();
        return Err(format!("a dead node is still there: {nodes:?}").into());
    }
    ask_and_answer(&server, &address)?;
    assert_eq!(server.clients(), 0);
    // Now that the server has seen that all have gone.
    assert!(server.take()?.is_none());
    let place = place_of(folder).ok_or("the server has no place")?;
    clean(&place);
    let left = connections(&place)?;
    assert!(left.is_empty(), "channels of nobody: {left:?}");
    Ok(was_killed)
}

/// Where the one server of a folder has its files.
fn place_of(folder: &Path) -> Option<PathBuf> {
    let root = folder.join("trolley-calls");
    let name = fs::read_to_string(root.join("current")).ok()?;
    Some(root.join(name.trim()))
}

/// Files of channels between clients and the server.
fn connections(place: &Path) -> Outcome<Vec<PathBuf>> {
    let files = fs::read_dir(place)?.flatten().map(|entry| entry.path());
    Ok(files.filter(|path| path.extension().is_some_and(|end| end == "connection")).collect())
}

/// The next server takes over.
fn kill_server(folder: &Path, call: usize) -> Outcome<bool> {
    let address = address(folder)?;
    let was_killed = run_to("server", &folder.display().to_string(), call)?;
    ClientPort::open(&address).err().ok_or("a client found a dead server")?;
    let server = Server::open(&address)?;
    ask_and_answer(&server, &address)?;
    Ok(was_killed)
}

fn ask_and_answer(server: &Server, address: &Address) -> Outcome {
    let client = ClientPort::open(address)?;
    let pending = client.ask(&numbered(1))?;
    // A dead client's request may come first.
    while let Some(taken) = server.take()? {
        let sequence = taken.sequence();
        let refusal =
            WireAnswer::without_ranking(sequence, WireState::Refused, Reason::Stopping, "test");
        let _dead_perhaps = taken.answer(&refusal);
    }
    let answer = pending.receive()?.ok_or("no answer")?;
    (answer.sequence == 1).then_some(()).ok_or_else(|| "another's answer".into())
}

// --- ptrace ---

/// Runs a child, and kills it when it enters its K-th call after the mark. Returns whether it came
/// so far.
fn run_to(role: &str, argument: &str, call: usize) -> Outcome<bool> {
    let mut command = Command::new(std::env::current_exe()?);
    command.args([role, argument]).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    // SAFETY: one system call, between fork and exec.
    unsafe { command.pre_exec(be_traced) };
    let mut child = command.spawn()?;
    let pid = child.id().cast_signed();
    let options = libc::PTRACE_O_EXITKILL | libc::PTRACE_O_TRACESYSGOOD;
    let stopped = wait(pid)?;
    assert!(libc::WIFSTOPPED(stopped), "it stops at exec");
    // SAFETY: `pid` is a stopped child that is traced here.
    unsafe { libc::ptrace(libc::PTRACE_SETOPTIONS, pid, 0, options) };
    let (mut is_marked, mut calls, mut signal) = (false, 0, 0);
    loop {
        // SAFETY: as above.
        unsafe { libc::ptrace(libc::PTRACE_SYSCALL, pid, 0, signal) };
        signal = 0;
        let status = wait(pid)?;
        if !libc::WIFSTOPPED(status) {
            // It ended by itself, and was reaped.
            return Ok(false);
        }
        if libc::WSTOPSIG(status) != libc::SIGTRAP | 0x80 {
            signal = libc::WSTOPSIG(status);
            continue;
        }
        let Some(number) = entered(pid) else { continue };
        calls += usize::from(is_marked);
        is_marked |= number == MARK.cast_unsigned();
        if is_marked && calls == call {
            child.kill()?;
            child.wait()?;
            return Ok(true);
        }
    }
}

/// Whether children may be traced here.
fn may_trace() -> bool {
    let mut command = Command::new("/bin/true");
    // SAFETY: one system call, between fork and exec.
    unsafe { command.pre_exec(be_traced) };
    let Ok(child) = command.spawn() else { return false };
    let pid = child.id().cast_signed();
    let is_stopped = wait(pid).is_ok_and(|status| libc::WIFSTOPPED(status));
    // SAFETY: `pid` is a stopped child that is traced here.
    unsafe { libc::ptrace(libc::PTRACE_CONT, pid, 0, 0) };
    let _ended = wait(pid);
    is_stopped
}

fn be_traced() -> std::io::Result<()> {
    // SAFETY: it has no other arguments.
    match unsafe { libc::ptrace(libc::PTRACE_TRACEME) } {
        0 => Ok(()),
        _ => Err(std::io::Error::last_os_error()),
    }
}

/// Time since the machine was started.
fn now() -> Duration {
    let now = rustix::time::clock_gettime(rustix::time::ClockId::Monotonic);
    Duration::new(now.tv_sec.unsigned_abs(), now.tv_nsec as u32)
}

fn wait(pid: i32) -> std::io::Result<i32> {
    let mut status = 0;
    // SAFETY: the status is writable.
    match unsafe { libc::waitpid(pid, &raw mut status, 0) } {
        -1 => Err(std::io::Error::last_os_error()),
        _ => Ok(status),
    }
}

/// The call that a stopped child enters; `None` if it leaves one.
fn entered(pid: i32) -> Option<u64> {
    // SAFETY: every bit pattern is such a struct.
    let mut info: libc::ptrace_syscall_info = unsafe { core::mem::zeroed() };
    let size = size_of_val(&info);
    // SAFETY: `pid` is a stopped child that is traced here; the kernel writes at most `size` bytes.
    let got = unsafe { libc::ptrace(libc::PTRACE_GET_SYSCALL_INFO, pid, size, &raw mut info) };
    if got <= 0 || info.op != libc::PTRACE_SYSCALL_INFO_ENTRY {
        return None;
    }
    // SAFETY: at an entry, this is the part that was written.
    Some(unsafe { info.u.entry.nr })
}
