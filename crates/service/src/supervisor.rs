//! A parent process that watches a service where systemd does not: `trolley serve --supervise`.
//!
//! ```text
//! supervisor --starts--> service --pings of the thread that answers--> supervisor
//!   no ping for 2 s, or not ready within 60 s:  SIGABRT, then SIGKILL
//!   ended by a fault, or by the supervisor:     started again after 0.1 s, 10 times a minute
//!   ended with 0, 2, 65, 76, 77 or 78:          the supervisor ends with that code
//!   SIGTERM, SIGINT, SIGQUIT or SIGHUP:         the service is told, and both end within 2 s
//! ```
//!
//! The supervisor shares nothing with its service but a socket that has no name, calls nothing of
//! iceoryx2, and opens nothing that the service wrote. The service dies with it.

mod decide;

use core::time::Duration;
use decide::{Ending, Limits, Next, Watch};
use diagnostic::{Diagnostic, FailureKind};
use runtime::process::spawn_with_env;
use runtime::{Child, Exit, Guard, OsError, Poller, Spawn, Wake, clock};
use std::borrow::Cow;
use std::ffi::OsString;
use std::os::fd::AsFd as _;
use std::path::Path;
use std::sync::OnceLock;
use transport::service::{NotifySocket, remove_dead_service};
use transport::{Address, OpenError};

/// The number under which the service inherits the file of its socket.
const SOCKET_FD: i32 = 3;
/// Most notices that are taken between two looks at the clock.
const NOTICES_MAX: usize = 64;
/// How long a service may take to die of SIGABRT (ms): a core may have to be written.
const ABORT_MS: u64 = 500;
/// How long a killed one is waited for (ms).
const KILL_MS: u64 = 200;
/// How long a service that was told to end may take in order (ms), and then by force.
const STOP_MS: u64 = 1_200;
const FORCE_MS: u64 = 300;
/// How often to look whether killed processes have let go of their files, 1 ms apart.
const LOOKS: usize = 200;
/// Variables that are the supervisor's own.
const OWN: [&str; 3] = ["NOTIFY_SOCKET", "WATCHDOG_USEC", "WATCHDOG_PID"];
const SIGABRT: i32 = 6;
const SIGTERM: i32 = 15;
const SIGCONT: i32 = 18;

/// Whose files go at the end, however that comes.
static ADDRESS: OnceLock<Address> = OnceLock::new();

/// The service could not be watched.
#[derive(Debug, thiserror::Error)]
pub enum SupervisorError {
    /// Something else watches already.
    #[error("NOTIFY_SOCKET is set: systemd, or another manager, watches this service")]
    Managed,
    /// It ended again and again.
    #[error("the service was started {starts} times within {seconds} s; the last one {how}")]
    TooOften {
        /// How often.
        starts: usize,
        /// Within this time.
        seconds: u64,
        /// What became of the last one.
        how: String,
    },
    /// Its socket could not be made.
    #[error(transparent)]
    Open(#[from] OpenError),
    /// The operating system refused.
    #[error(transparent)]
    System(#[from] OsError),
}

impl Diagnostic for SupervisorError {
    fn kind(&self) -> FailureKind {
        match self {
            Self::Managed => FailureKind::Configuration,
            Self::TooOften { .. } => FailureKind::TryAgain,
            Self::Open(error) => error.kind(),
            Self::System(error) => error.kind(),
        }
    }

    fn remedy(&self) -> Option<Cow<'_, str>> {
        match self {
            Self::Managed => Some("leave out --supervise: the manager restarts the service".into()),
            Self::TooOften { .. } => Some("what it said before says why".into()),
            Self::Open(error) => error.remedy(),
            Self::System(error) => error.remedy(),
        }
    }
}

/// Runs a service in a child process, and starts it again whenever it dies or falls silent.
///
/// `program` and `args` start the service alone; `address` is where it will serve. Returns the exit
/// code to end with, after a signal or when another start would not help.
///
/// # Errors
///
/// If this process has a manager already, the service was started too often, or the operating
/// system refuses a process or a socket.
pub fn supervise(
    address: &Address,
    program: &Path,
    args: &[String],
) -> Result<u8, SupervisorError> {
    if std::env::var_os(OWN[0]).is_some_and(|path| !path.is_empty()) {
        return Err(SupervisorError::Managed);
    }
    let _one_per_process = ADDRESS.set(address.clone());
    let _guard = Guard::start(remove_files)?;
    let mut poller = Poller::new()?;
    poller.catch_signals()?;
    let mut watch = Watch::new(Limits::USUAL);
    let ended = turn(&mut poller, &mut watch, address, || start(address, program, args));
    remove_files();
    ended
}

/// One service after the other.
fn turn(
    poller: &mut Poller,
    watch: &mut Watch,
    address: &Address,
    mut start: impl FnMut() -> Result<(Child, NotifySocket), SupervisorError>,
) -> Result<u8, SupervisorError> {
    // Ends with a signal, or when another start would not help or came too often.
    loop {
        let (mut child, socket) = start()?;
        watch.started(clock::now_ns());
        poller.add_fd(socket.fd(), 0)?;
        poller.add_process(&child, 0)?;
        let how = match attend(poller, watch, &mut child, &socket)? {
            Some(how) => how,
            None => return stop(child),
        };
        let said = match how {
            Ending::Ended(exit) => format!("ended by {exit}"),
            Ending::Silent => {
                abort(&mut child)?;
                "fell silent and was killed".to_owned()
            }
        };
        poller.remove_process(0);
        drop(child);
        let at_ns = match watch.after(how, clock::now_ns()) {
            Next::PassOn(code) => return Ok(code),
            Next::Start { at_ns } => at_ns,
            Next::GiveUp => {
                let Limits { starts_max: starts, starts_in_ns, .. } = Limits::USUAL;
                let seconds = Duration::from_nanos(starts_in_ns).as_secs();
                return Err(SupervisorError::TooOften { starts, seconds, how: said });
            }
        };
        tracing::warn!(instance = address.instance(), "the service {said}, and is started again");
        if pause(poller, at_ns)? {
            return Ok(0);
        }
    }
}

/// Starts the service, with a socket of its own.
fn start(
    address: &Address,
    program: &Path,
    args: &[String],
) -> Result<(Child, NotifySocket), SupervisorError> {
    let socket = NotifySocket::create(address)?;
    let kept = std::env::vars_os().filter(|(name, _)| !OWN.iter().any(|own| name == own));
    let silence_us = Limits::USUAL.silence_ns / 1_000;
    let own = [(OWN[0], NotifySocket::path_for(SOCKET_FD)), (OWN[1], silence_us.to_string())];
    let own = own.map(|(name, value)| (OsString::from(name), OsString::from(value)));
    let env: Vec<_> = kept.chain(own).collect();
    let stdout = std::io::stdout();
    let fds = [(stdout.as_fd(), 1), (socket.file(), SOCKET_FD)];
    let child = spawn_with_env(Spawn { program, args, fds: &fds, core: None }, &env)?;
    Ok((child, socket))
}

/// Watches a service until it has ended or is overdue; `None`: a signal came.
fn attend(
    poller: &mut Poller,
    watch: &mut Watch,
    child: &mut Child,
    socket: &NotifySocket,
) -> Result<Option<Ending>, OsError> {
    // Ends when the service does, or is overdue.
    loop {
        let left_ns = watch.due_ns().saturating_sub(clock::now_ns());
        let mut wakes = poller.wait(Some(left_ns))?;
        if wakes.any(|wake| matches!(wake, Wake::Signal(_))) {
            return Ok(None);
        }
        if let Some(exit) = child.try_wait()? {
            return Ok(Some(Ending::Ended(exit)));
        }
        // What it said counts first: this process may have been stopped itself.
        for notice in core::iter::from_fn(|| socket.take()).take(NOTICES_MAX) {
            watch.heard(notice, clock::now_ns());
        }
        if watch.is_overdue(clock::now_ns()) {
            return Ok(Some(Ending::Silent));
        }
    }
}

/// Waits until a time (ns); whether a signal came.
fn pause(poller: &mut Poller, until_ns: u64) -> Result<bool, OsError> {
    // Ends at that time.
    while clock::now_ns() < until_ns {
        let left_ns = until_ns.saturating_sub(clock::now_ns());
        let mut wakes = poller.wait(Some(left_ns))?;
        if wakes.any(|wake| matches!(wake, Wake::Signal(_))) {
            return Ok(true);
        }
    }
    Ok(false)
}

/// Ends a service that is silent: with a core, if the machine keeps them and that is quick.
fn abort(child: &mut Child) -> Result<(), OsError> {
    child.signal(SIGABRT)?;
    if child.wait_ms(ABORT_MS)?.is_none() {
        child.kill()?;
        if child.wait_ms(KILL_MS)?.is_none() {
            tracing::warn!(pid = child.pid(), "a killed service does not end");
        }
    }
    Ok(())
}

/// Ends a service because this process was told to end; returns the exit code.
fn stop(mut child: Child) -> Result<u8, SupervisorError> {
    // One that somebody stopped goes on, and ends in order.
    child.signal(SIGTERM)?;
    child.signal(SIGCONT)?;
    let mut exit = child.wait_ms(STOP_MS)?;
    if exit.is_none() {
        // A second signal ends it by force: it kills its workers and removes its files.
        child.signal(SIGTERM)?;
        exit = child.wait_ms(FORCE_MS)?;
    }
    if exit.is_none() {
        child.kill()?;
        exit = child.wait_ms(KILL_MS)?;
    }
    Ok(match exit {
        Some(Exit::Code(code)) => u8::try_from(code).unwrap_or(1),
        Some(Exit::Signal(number)) => u8::try_from(128 + number).unwrap_or(1),
        None => 128 + SIGTERM as u8,
    })
}

/// Removes what a service left that was killed: its folder, and the runs of its workers.
fn remove_files() {
    let Some(address) = ADDRESS.get() else { return };
    for look in 0..LOOKS {
        if look > 0 {
            clock::nap_ns(1_000_000);
        }
        if remove_dead_service(address) {
            break;
        }
    }
    let folder = address.root().parent().unwrap_or(address.root());
    let _removed = transport::sweep_leftovers(folder);
}
