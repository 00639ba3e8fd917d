//! What another user plants where a service shares its files: while it runs, and under its name
//! while it does not.
//!
//! That user is one of this run's own, who has no account, no other files and no other processes:
//! `nobody` may have some. Each object is made here and then given to them, which leaves the same
//! as if they had made it. Without the rights for that the fault is not injected, and the report
//! says so.

use super::kind::Kind;
use super::report::{Report, State};
use super::serving::Serving;
use super::signals::KILL;
use coordinator::Answer;
use geometry::rng::Rng;
use runtime::process::{self, Held, Spawn};
use runtime::{Exit, clock};
use std::fs::{self, Permissions};
use std::os::unix::fs::{MetadataExt as _, PermissionsExt as _, lchown, symlink};
use std::os::unix::net::UnixListener;
use std::path::{Path, PathBuf};
use trolley::{Failure, FailureKind};

/// The first of so many user ids that neither useradd nor systemd gives away.
const STRANGERS: u32 = 60_000;
const STRANGERS_MAX: u32 = 1_000;
/// How long an answer may take (ms).
const PATIENCE_MS: u64 = 1_000;
/// How long a start may take until it is refused (ms): bodies are read and outlined before.
const START_MS: u64 = 5_000;
/// Exit code of what cannot be trusted.
const UNTRUSTED: Exit = Exit::Code(78);
/// Exit code of a client that finds no service.
const NO_SERVICE: Exit = Exit::Code(75);
/// What the stranger tries with the folder in use. None of it may work.
const TAMPER: &str = "rm -rf \"$0\"; mv \"$0\" \"$0.gone\"; : > \"$0/current\"; mkfifo \"$0/pid\"; \
                      ln -s / \"$0/trolley.faulty.0000000000000001\"; chmod 777 \"$0\"; exit 0";

/// What can stand under a name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Plant {
    Pipe,
    /// To a folder with the canary.
    Link,
    /// To nothing.
    DeadLink,
    Socket,
    /// That everybody may write to.
    OpenFolder,
    ClosedFolder,
    Garbage,
}

impl Plant {
    const ALL: [Self; 7] = [
        Self::Pipe,
        Self::Link,
        Self::DeadLink,
        Self::Socket,
        Self::OpenFolder,
        Self::ClosedFolder,
        Self::Garbage,
    ];

    /// Makes it; `false` if the name is taken.
    fn make(self, at: &Path, precious: &Path, stranger: u32) -> Result<bool, Failure> {
        if at.symlink_metadata().is_ok() {
            return Ok(false);
        }
        match self {
            Self::Pipe => {
                run("/usr/bin/mkfifo", &["-m", "666", &at.display().to_string()])?;
            }
            Self::Link => symlink(precious, at).map_err(system)?,
            Self::DeadLink => symlink("/no/such/folder", at).map_err(system)?,
            Self::Socket => drop(UnixListener::bind(at).map_err(system)?),
            Self::OpenFolder | Self::ClosedFolder => fs::create_dir(at).map_err(system)?,
            Self::Garbage => fs::write(at, [0xa5; 4096]).map_err(system)?,
        }
        let mode = match self {
            Self::Link | Self::DeadLink => None,
            Self::ClosedFolder => Some(0o700),
            _ => Some(0o777),
        };
        if let Some(mode) = mode {
            fs::set_permissions(at, Permissions::from_mode(mode)).map_err(system)?;
        }
        lchown(at, Some(stranger), Some(stranger)).map_err(system)?;
        Ok(true)
    }
}

/// Removes what was planted, and nothing through a link.
fn remove(at: &Path) -> Result<(), Failure> {
    let is_folder = at.symlink_metadata().map_err(system)?.is_dir();
    if is_folder { fs::remove_dir(at) } else { fs::remove_file(at) }.map_err(system)
}

/// Plants things beside the files of a running service, then under their folder's name, and asks.
pub(super) fn strike(
    serving: &mut Serving,
    mut rng: Rng,
    reference: &Answer,
    report: &mut Report,
) -> Result<(), Failure> {
    let open = serving.open_to_strangers()?;
    let stranger = match stranger() {
        Some(id) if may_act(id, &open)? => id,
        _ => {
            let why = "this user may not become another one without an account";
            tracing::warn!(kind = Kind::StrangersFiles.name(), why, "a fault is not injected");
            report.skip(Kind::StrangersFiles, why);
            return Ok(());
        }
    };
    let precious = open.with_file_name("precious");
    let canary = precious.join("trolley.victim.0000000000000001").join("canary");
    fs::create_dir_all(canary.with_file_name("")).map_err(system)?;
    fs::write(&canary, "alive").map_err(system)?;
    fs::set_permissions(&precious, Permissions::from_mode(0o777)).map_err(system)?;
    if !serving.starts(reference, report)? {
        return Ok(());
    }
    let struck_ns = clock::now_ns();
    let mut worst = State::Complete;
    let mut note = |is_right: bool, report: &mut Report| {
        let state = if is_right { State::Complete } else { State::Wrong };
        report.requests += 1;
        report.count(state);
        worst = worst.max(state);
    };
    let pid = serving.pid().unwrap_or_default();
    let beside = ["trolley.faulty.0000000000000001", "trolley-faulty", "trolley.faulty"];
    let mut names: Vec<PathBuf> = beside.iter().map(|name| open.join(name)).collect();
    names.push(open.join(format!(".trolley-new.{pid}.trolley-faulty")));
    names.push(open.join(".trolley-new.999999.trolley-faulty"));
    let mut planted = Vec::new();
    for name in names {
        let plant = Plant::ALL[rng.below(Plant::ALL.len() as u64) as usize];
        if plant.make(&name, &precious, stranger)? {
            planted.push(name);
        }
    }
    let folder = serving.folder();
    run_as(stranger, TAMPER, &folder)?;
    let workers = serving.workers();
    for _ in 0..3 {
        if let Some(worker) = workers.get(rng.below(workers.len().max(1) as u64) as usize) {
            Held::of(*worker).and_then(|held| held.signal(KILL)).unwrap_or(());
        }
        let told = serving.ask(PATIENCE_MS)?.told(reference)?;
        report.hangs += u64::from(told.exit.is_none());
        note(told.state == State::Complete, report);
    }
    report.hangs += u64::from(!serving.end()?);
    // Now its name is free, and somebody is quicker than its next start.
    let plant = Plant::ALL[rng.below(Plant::ALL.len() as u64) as usize];
    if plant.make(&folder, &precious, stranger)? {
        serving.start()?;
        let ended = serving.await_end(START_MS)?;
        report.hangs += u64::from(ended.is_none());
        note(ended.is_none() || ended == Some(UNTRUSTED), report);
        let told = serving.ask(PATIENCE_MS)?.told(reference)?;
        report.hangs += u64::from(told.exit.is_none());
        // Behind a link, or in another's folder, there is no service.
        let is_clear = [None, Some(UNTRUSTED), Some(NO_SERVICE)].contains(&told.exit);
        note(is_clear, report);
        serving.end()?;
        remove(&folder)?;
    }
    let seen_ns = clock::now_ns() - struck_ns;
    serving.start()?;
    note(serving.is_serving(reference)?, report);
    report.hangs += u64::from(!serving.end()?);
    note(fs::read(&canary).is_ok_and(|kept| kept == b"alive"), report);
    // A folder of this user's is left for the next start.
    let _made_by_the_service = fs::remove_dir(&folder);
    planted.iter().try_for_each(|at| remove(at))?;
    report.left_behind += serving.left() + u64::from(folder.symlink_metadata().is_ok());
    report.add(Kind::StrangersFiles, worst, Some(seen_ns), clock::now_ns() - struck_ns);
    Ok(())
}

/// A user id without an account, which no other run on this machine is likely to pick.
fn stranger() -> Option<u32> {
    let accounts = ["/etc/passwd", "/etc/group"]
        .map(|file| fs::read_to_string(file).unwrap_or_default())
        .concat();
    let first = std::process::id() % STRANGERS_MAX;
    let mut ids = (0..STRANGERS_MAX).map(|number| STRANGERS + (first + number) % STRANGERS_MAX);
    ids.find(|id| !accounts.contains(&format!(":{id}:")))
}

/// Whether this process can become that user, who then can make files in a folder for all.
fn may_act(stranger: u32, open: &Path) -> Result<bool, Failure> {
    let probe = open.join("probe");
    run_as(stranger, ": > \"$0\"", &probe)?;
    let is_theirs = probe.symlink_metadata().is_ok_and(|made| made.uid() == stranger);
    if is_theirs {
        fs::remove_file(&probe).map_err(system)?;
    }
    Ok(is_theirs)
}

/// Runs a script as the stranger, with a path as its `$0`.
fn run_as(stranger: u32, script: &str, path: &Path) -> Result<(), Failure> {
    let (user, path) = (stranger.to_string(), path.display().to_string());
    let become_user = ["--reuid", &user, "--regid", &user, "--clear-groups"];
    let line: Vec<&str> = become_user.into_iter().chain(["/bin/sh", "-c", script, &path]).collect();
    run("/usr/bin/setpriv", &line)
}

/// Runs a program of the system, silently. Whether it exists is seen in what it leaves.
fn run(program: &str, args: &[&str]) -> Result<(), Failure> {
    let args: Vec<String> = args.iter().map(|&arg| arg.to_owned()).collect();
    let null = fs::File::options().write(true).open("/dev/null").map_err(system)?;
    use std::os::fd::AsFd as _;
    let fds = [(null.as_fd(), 1), (null.as_fd(), 2)];
    let what = Spawn { program: Path::new(program), args: &args, fds: &fds, core: None };
    process::spawn(what)?.wait_ms(5_000)?;
    Ok(())
}

fn system(error: std::io::Error) -> Failure {
    Failure::new(FailureKind::System, error.to_string())
}
