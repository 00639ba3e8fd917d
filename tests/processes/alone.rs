//! A run without workers shares nothing: nowhere that shared files could lie does it open, make or
//! even list anything. A run with workers does, which shows that it would have been seen.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use crate::support::{self, instance, skipped, text, trolley};
use core::mem::MaybeUninit;
use rustix::fs::inotify::{CreateFlags, Reader, WatchFlags, add_watch, init};
use std::os::fd::OwnedFd;
use std::path::Path;
use std::process::{Command, Stdio};

/// Becomes a command to which its first argument is /dev/shm.
const BIND: &str = "mount --bind \"$0\" /dev/shm && exec \"$@\"";

/// Where a run looks for a place for its shared files.
const VARIABLES: [&str; 2] = ["RUNTIME_DIRECTORY", "XDG_RUNTIME_DIR"];

/// All that happens to the entries of a folder, and to itself.
struct Watch(OwnedFd);

impl Watch {
    fn new(folder: &Path) -> Self {
        let watch = init(CreateFlags::NONBLOCK | CreateFlags::CLOEXEC).unwrap();
        let all = WatchFlags::ALL_EVENTS;
        add_watch(&watch, folder, all).unwrap();
        Self(watch)
    }

    /// What has happened since the last call.
    fn events(&self) -> Vec<String> {
        let mut buffer = [MaybeUninit::uninit(); 4096];
        let mut reader = Reader::new(&self.0, &mut buffer);
        let mut events = Vec::new();
        while let Ok(event) = reader.next() {
            events.push(format!("{:?} {:?}", event.file_name(), event.events()));
        }
        events
    }
}

/// Ranks with these arguments, with nothing but this folder to share files in.
fn rank(mut program: Command, variable: Option<(&str, &Path)>, args: &[&str]) {
    for name in VARIABLES {
        program.env_remove(name);
    }
    program.envs(variable);
    let scenario = support::service::shipped("config/scenarios/minimal.toml");
    let ranked = program.arg("rank").arg(scenario).args(args).output().unwrap();
    assert!(ranked.status.success(), "{variable:?}, {args:?}: {}", text(&ranked.stderr));
}

/// Ranks in this process alone, which nobody must notice, and with workers, which somebody must.
fn compare(folder: &Path, program: impl Fn() -> Command, variable: Option<(&str, &Path)>) {
    let watch = Watch::new(folder);
    rank(program(), variable, &["--in-process", "--json"]);
    assert_eq!(watch.events(), Vec::<String>::new(), "{variable:?}");
    rank(program(), variable, &["--workers", "1", "--instance", &instance()]);
    assert!(!watch.events().is_empty(), "{variable:?}: workers share files");
    // The folder itself may be gone: its last user removes one that is named to it.
    let left = std::fs::read_dir(folder).into_iter().flatten().count();
    assert_eq!(left, 0, "{variable:?}: and leave none");
}

fn folder() -> tempfile::TempDir {
    tempfile::Builder::new().prefix("a").tempdir_in("/dev/shm").unwrap()
}

#[test]
fn a_run_without_workers_touches_no_folder_for_shared_files() {
    for name in VARIABLES {
        let folder = folder();
        compare(folder.path(), trolley, Some((name, folder.path())));
    }
}

#[test]
fn a_run_without_workers_touches_nothing_in_dev_shm() {
    let folder = folder();
    let bound = |program: &Path| {
        let mut command = Command::new("unshare");
        command.args(["-m", "sh", "-c", BIND]).arg(folder.path()).arg(program);
        command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        command
    };
    if !bound("true".as_ref()).output().is_ok_and(|probe| probe.status.success()) {
        skipped("/dev/shm: this user may not mount another one");
        return;
    }
    compare(folder.path(), || bound(env!("CARGO_BIN_EXE_trolley").as_ref()), None);
}
