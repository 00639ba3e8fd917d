//! What another user of the machine can plant where this program shares its files.
//!
//! The stranger is a user of this test's own, without an account, and needs root to become that;
//! without, these are skipped.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use crate::support::{self, Place, instance, json, skipped, text, trolley};
use std::os::unix::fs::PermissionsExt as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::time::Duration;

/// The first of a thousand user ids that neither useradd nor systemd gives away.
const STRANGERS: u32 = 60_000;
/// What a refusal may take: far more than it needs, far less than forever.
const PATIENCE: Duration = Duration::from_secs(5);

/// A folder in which every user may make files, as in /dev/shm itself, on a tmpfs.
struct Open(tempfile::TempDir);

impl Open {
    fn new() -> Self {
        let folder = tempfile::Builder::new().prefix("o").tempdir_in("/dev/shm").unwrap();
        std::fs::set_permissions(folder.path(), std::fs::Permissions::from_mode(0o1777)).unwrap();
        Self(folder)
    }

    fn path(&self) -> &Path {
        self.0.path()
    }

    /// What a stranger makes there.
    fn plant(&self, script: &str) {
        let planted =
            as_stranger().args(["/bin/sh", "-c", script]).current_dir(self.path()).output();
        let planted = planted.unwrap();
        assert!(planted.status.success(), "{script}: {}", text(&planted.stderr));
    }
}

fn stranger() -> String {
    strangers().next().expect("a user id without an account")
}

/// Ids of users and groups that no account has, and no other test process.
pub(crate) fn strangers() -> impl Iterator<Item = String> {
    let accounts = ["/etc/passwd", "/etc/group"]
        .map(|file| std::fs::read_to_string(file).unwrap_or_default())
        .concat();
    let first = std::process::id() % 1_000;
    let ids = (0..1_000).map(move |number| (STRANGERS + (first + number) % 1_000).to_string());
    ids.filter(move |id| !accounts.contains(&format!(":{id}:")))
}

fn as_stranger() -> Command {
    as_user(&stranger(), None)
}

/// A command that another one is added to, which then runs as this user, in this group besides
/// their own.
pub(crate) fn as_user(id: &str, group: Option<&str>) -> Command {
    let mut command = Command::new("setpriv");
    command.args(["--reuid", id, "--regid", id]);
    match group {
        Some(group) => command.args(["--groups", group]),
        None => command.arg("--clear-groups"),
    };
    command
}

pub(crate) fn is_possible() -> bool {
    let possible = as_stranger().arg("/bin/true").output().is_ok_and(|done| done.status.success());
    if !possible {
        skipped("strangers: this user may not become another one");
    }
    possible
}

/// Runs the program with its default folder in this one. A run that hangs is killed.
fn run_in(folder: &Path, args: &[&str]) -> Output {
    let mut command = Command::new("timeout");
    command.args(["--signal=KILL", &PATIENCE.as_secs().to_string()]);
    command.arg(env!("CARGO_BIN_EXE_trolley")).args(args).env("XDG_RUNTIME_DIR", folder);
    command.env_remove("RUNTIME_DIRECTORY");
    command.output().unwrap()
}

fn minimal() -> String {
    support::service::shipped("config/scenarios/minimal.toml").display().to_string()
}

/// Everything that can stand under a name.
const PLANTS: [(&str, &str); 5] = [
    ("mkfifo NAME; chmod 666 NAME", "a pipe"),
    ("ln -s precious NAME", "a link"),
    ("mkdir -m 777 NAME", "belongs to user STRANGER"),
    ("mkdir -m 700 NAME", "belongs to user STRANGER"),
    ("echo x > NAME; chmod 666 NAME", "a file"),
];

#[test]
fn what_strangers_plant_under_the_folder_of_all_is_refused_with_its_name() {
    if !is_possible() {
        return;
    }
    let alone =
        json(&trolley().args(["rank", &minimal(), "--in-process", "--json"]).output().unwrap());
    for (plant, what) in PLANTS {
        let what = &what.replace("STRANGER", &stranger());
        let open = Open::new();
        let precious = open.path().join("precious");
        let kept = precious.join("trolley.victim.0000000000000001");
        std::fs::create_dir_all(&kept).unwrap();
        open.plant(&plant.replace("NAME", "trolley"));
        let refused = run_in(open.path(), &["rank", &minimal(), "--instance", &instance()]);
        let said = text(&refused.stderr);
        assert_eq!(refused.status.code(), Some(78), "{plant}: {said}");
        let name = open.path().join("trolley");
        assert!(said.contains(name.to_str().unwrap()) && said.contains(what), "{plant}: {said}");
        assert!(said.contains("remove it"), "a remedy: {said}");
        assert!(kept.exists(), "{plant}: nothing is removed through a link");
        // Without workers it shares nothing, and looks at no shared name.
        let output = run_in(open.path(), &["rank", &minimal(), "--in-process", "--json"]);
        assert_eq!(json(&output)["ranking"], alone["ranking"], "{plant}");
        std::fs::remove_dir_all(&precious).unwrap();
    }
}

// verifies REQ-STRANGERS
#[test]
fn what_strangers_plant_under_the_name_of_a_service_is_refused_by_it_and_by_its_clients() {
    if !is_possible() {
        return;
    }
    let place = Place::new();
    let deployment =
        support::service::deployment(&place, 1, &[("sedan", 500, 1), ("wall", 500, 1)]);
    let written = std::fs::read_to_string(&deployment).unwrap();
    for (plant, what) in PLANTS {
        let what = &what.replace("STRANGER", &stranger());
        let open = Open::new();
        std::fs::create_dir(open.path().join("precious")).unwrap();
        let folder = format!("folder = {:?}\n[engine]", open.path());
        let here: PathBuf = place.write("here.toml", &written.replacen("[engine]", &folder, 1));
        let here = here.to_str().unwrap();
        let instance = instance();
        let name = format!("trolley-{instance}");
        open.plant(&plant.replace("NAME", &name));
        for args in [
            vec!["serve", here, "--instance", &instance],
            vec!["top", here, "--times", "1", "--instance", &instance],
        ] {
            let refused = run_in(open.path(), &args);
            let said = text(&refused.stderr);
            assert_eq!(refused.status.code(), Some(78), "{plant}, {args:?}: {said}");
            assert!(said.contains(&name) && said.contains(what), "{plant}, {args:?}: {said}");
        }
    }
}

/// Regression: it served from a folder that another user owns, and can exchange.
#[test]
fn a_service_without_workers_makes_nothing_in_a_folder_of_a_stranger() {
    if !is_possible() {
        return;
    }
    let place = Place::new();
    let bodies = [("sedan", 500, 1), ("wall", 500, 1)];
    let deployment = support::service::deployment(&place, 1, &bodies);
    let open = Open::new();
    open.plant("mkdir -m 755 trolley");
    let instance = instance();
    let args = ["serve", deployment.to_str().unwrap(), "--in-process", "--instance", &instance];
    let refused = run_in(open.path(), &args);
    let said = text(&refused.stderr);
    assert_eq!(refused.status.code(), Some(78), "{said}");
    assert!(
        said.contains(&format!("belongs to user {}", stranger())) && said.contains("remove it"),
        "{said}"
    );
    let left: Vec<_> = std::fs::read_dir(open.path().join("trolley")).unwrap().collect();
    assert!(left.is_empty(), "{left:?}");
}

#[test]
fn no_shared_file_of_a_service_can_be_opened_by_others() {
    let place = Place::new();
    let deployment =
        support::service::deployment(&place, 1, &[("sedan", 500, 1), ("wall", 500, 1)]);
    let serving = support::service::serve(&deployment, &[]);
    let mut folders = vec![trolley::doctor::shared_folder()];
    let mut files = 0;
    while let Some(folder) = folders.pop() {
        let mode = std::fs::metadata(&folder).unwrap().permissions().mode();
        let is_top = folder == trolley::doctor::shared_folder();
        assert!(!is_top || mode & 0o077 == 0, "{}: {mode:o}", folder.display());
        for entry in std::fs::read_dir(&folder).into_iter().flatten().flatten() {
            // Other tests' files come and go.
            let Ok(about) = entry.metadata() else { continue };
            files += 1;
            let mode = about.permissions().mode();
            assert_eq!(mode & 0o022, 0, "{}: {mode:o}", entry.path().display());
            if about.is_dir() && entry.path().to_string_lossy().contains(&serving.instance) {
                folders.push(entry.path());
            }
        }
    }
    assert!(files > 10, "a service has files");
    if is_possible() {
        let folder = trolley::doctor::shared_folder();
        let listed = as_stranger().arg("ls").arg(&folder).output().unwrap();
        assert!(!listed.status.success(), "{}", text(&listed.stdout));
    }
    serving.end();
}
