//! A group of clients: its members may ask, others may not, and neither sees what workers share.
//!
//! The service and its clients are users of this test's own, without accounts. That needs root;
//! without, these are skipped.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use super::strangers::{as_user, is_possible, strangers};
use crate::support::service::{Serving, deployment, of_ways, ranking, serve_by};
use crate::support::{Place, instance, skipped, text, wait_for, ways};
use std::fs::{self, Permissions};
use std::os::unix::fs::{MetadataExt as _, PermissionsExt as _, chown};
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

/// Of each body.
const TRIANGLES: u32 = 600;

/// Becomes a command that sees its own user's processes alone.
const HIDE: &str = "mount -t proc -o hidepid=2 proc /proc && exec \"$@\"";

/// The folders of a service with a group of clients, and who takes part.
struct Scene {
    above: tempfile::TempDir,
    place: Place,
    server: String,
    member: String,
    stranger: String,
    group: String,
    instance: String,
}

impl Scene {
    fn new() -> Self {
        let mut ids = strangers();
        let mut id = || ids.next().unwrap();
        let (server, member, stranger, group) = (id(), id(), id(), id());
        let above = tempfile::Builder::new().prefix("g").tempdir_in("/dev/shm").unwrap();
        let place = Place::new();
        for open in [above.path(), place.path()] {
            fs::set_permissions(open, Permissions::from_mode(0o755)).unwrap();
        }
        let scene = Self { above, place, server, member, stranger, group, instance: instance() };
        let id = scene.server.parse().unwrap();
        fs::create_dir(scene.folder()).unwrap();
        chown(scene.folder(), Some(id), Some(id)).unwrap();
        scene.open_to(0o711);
        fs::write(scene.scenario(), ways(TRIANGLES)).unwrap();
        // The build may lie where its owner alone can go.
        fs::copy(env!("CARGO_BIN_EXE_trolley"), scene.program()).unwrap();
        scene
    }

    /// The folder of shared files, as systemd makes one.
    fn folder(&self) -> PathBuf {
        self.above.path().join("f")
    }

    fn open_to(&self, mode: u32) {
        fs::set_permissions(self.folder(), Permissions::from_mode(mode)).unwrap();
    }

    fn scenario(&self) -> PathBuf {
        self.place.path().join("scenario.toml")
    }

    fn program(&self) -> PathBuf {
        self.place.path().join("trolley")
    }

    /// A deployment for the scenario, with this group.
    fn deployment(&self, group: &str) -> PathBuf {
        let file = deployment(&self.place, 1, &of_ways(TRIANGLES));
        let keys = format!("folder = {:?}\ngroup = {group}\n[engine]", self.folder());
        let text = fs::read_to_string(&file).unwrap().replacen("[engine]", &keys, 1);
        self.place.write("deployment.toml", &text)
    }

    fn trolley(&self, user: &str, group: Option<&str>) -> Command {
        let mut command = as_user(user, group);
        command.arg(self.program());
        command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        command
    }

    fn member(&self) -> Command {
        self.trolley(&self.member, Some(&self.group))
    }

    fn serve(&self, deployment: &Path) -> Serving {
        let server = self.trolley(&self.server, Some(&self.group));
        serve_by(server, deployment, &self.instance, &[])
    }

    /// As [`Scene::serve`], without seeing processes of other users, as the unit of systemd has it.
    fn serve_behind_proc(&self, deployment: &Path) -> Serving {
        let probe = Command::new("unshare").args(["-m", "sh", "-c", HIDE, "sh", "true"]).output();
        if !probe.is_ok_and(|probe| probe.status.success()) {
            skipped("hidden processes: this user may not mount /proc");
            return self.serve(deployment);
        }
        let inner = self.trolley(&self.server, Some(&self.group));
        let mut server = Command::new("unshare");
        server.args(["-m", "sh", "-c", HIDE, "sh"]).arg(inner.get_program()).args(inner.get_args());
        server.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        serve_by(server, deployment, &self.instance, &[])
    }

    /// What a client that asks gets.
    fn query(&self, mut client: Command, deployment: &Path) -> Output {
        let client = client.arg("query").arg(deployment).arg(self.scenario());
        let common = ["--json", "--deadline-ms", "20000", "--instance", &self.instance];
        client.args(common).output().unwrap()
    }

    /// What `trolley serve` says when it refuses.
    fn refusal(&self, deployment: &Path) -> String {
        let mut server = self.trolley(&self.server, Some(&self.group));
        let refused =
            server.arg("serve").arg(deployment).args(["--instance", &self.instance]).output();
        let refused = refused.unwrap();
        let said = text(&refused.stderr);
        assert_eq!(refused.status.code(), Some(78), "{said}");
        assert!(said.contains("help: "), "{said}");
        said
    }

    /// Entries of the shared folder.
    fn names(&self) -> Vec<String> {
        let entries = fs::read_dir(self.folder()).unwrap().flatten();
        entries.map(|entry| entry.file_name().into_string().unwrap()).collect()
    }
}

#[test]
fn members_of_the_group_are_answered_and_others_are_refused() {
    if !is_possible() {
        return;
    }
    let scene = Scene::new();
    let deployment = scene.deployment(&scene.group);
    let serving = scene.serve(&deployment);
    let own = scene.query(scene.trolley(&scene.server, None), &deployment);
    for _ in 0..3 {
        let answered = scene.query(scene.member(), &deployment);
        assert!(answered.status.success(), "{}", text(&answered.stderr));
        assert_eq!(ranking(&answered), ranking(&own));
    }
    let mut top = scene.member();
    let top = top.arg("top").arg(&deployment).args(["--times", "1", "--json"]);
    let heard = top.args(["--instance", &scene.instance]).output().unwrap();
    assert!(heard.status.success(), "{}", text(&heard.stderr));

    let refused = scene.query(scene.trolley(&scene.stranger, None), &deployment);
    let said = text(&refused.stderr);
    assert!(!refused.status.success() && said.contains(&scene.instance), "{said}");
    // No file is open to all, and those of workers are in a folder that no member can enter.
    let mut folders = vec![scene.folder()];
    let mut lent = 0;
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
            let Ok(about) = entry.metadata() else { continue };
            let (path, mode) = (entry.path(), about.mode());
            let name = entry.file_name().into_string().unwrap();
            assert_eq!(mode & 0o007, 0, "{}: {mode:o}", path.display());
            if name.starts_with("trolley.") {
                assert_eq!(mode & 0o077, 0, "{}: {mode:o}", path.display());
                continue;
            }
            assert_eq!(about.gid().to_string(), scene.group, "{}", path.display());
            lent += u32::from(mode & 0o040 != 0);
            if about.is_dir() {
                folders.push(path);
            }
        }
    }
    assert!(lent > 10, "a service lends files: {lent}");
    assert!(scene.names().iter().any(|name| name.starts_with("trolley.")), "there are workers");
    serving.end();
    assert_eq!(scene.names(), Vec::<String>::new());
}

#[test]
fn a_member_that_is_killed_leaves_nothing() {
    if !is_possible() {
        return;
    }
    let scene = Scene::new();
    let deployment = scene.deployment(&scene.group);
    let serving = scene.serve_behind_proc(&deployment);
    let root = scene.folder().join(format!("trolley-{}", scene.instance));
    let name = fs::read_to_string(root.join("current")).unwrap();
    let nodes = root.join(name.trim()).join("nodes");
    let of_member = || {
        let entries = fs::read_dir(&nodes).unwrap().flatten();
        let owners = entries.filter_map(|entry| Some(entry.metadata().ok()?.uid().to_string()));
        owners.filter(|owner| *owner == scene.member).count()
    };
    let mut top = scene.member();
    let top = top.arg("top").arg(&deployment).args(["--json", "--times", "1000"]);
    let mut listener = top.args(["--instance", &scene.instance]).spawn().unwrap();
    wait_for(10_000, || (of_member() > 0).then_some(())).expect("it listens");
    // Longer than the service takes to notice dead clients: this one lives.
    wait_for(1_500, || None::<()>);
    assert!(of_member() > 0 && listener.try_wait().unwrap().is_none());
    listener.kill().unwrap();
    listener.wait().unwrap();
    wait_for(10_000, || (of_member() == 0).then_some(())).expect("the service cleans up");
    let answered = scene.query(scene.member(), &deployment);
    assert!(answered.status.success(), "{}", text(&answered.stderr));
    serving.end();
    assert_eq!(scene.names(), Vec::<String>::new());
}

#[test]
fn a_group_that_does_not_fit_is_refused_with_a_remedy() {
    if !is_possible() {
        return;
    }
    let scene = Scene::new();
    let said = scene.refusal(&scene.deployment("\"no-such-group\""));
    assert!(said.contains("deployment.toml: group: there is no group"), "{said}");
    let said = scene.refusal(&scene.deployment(&scene.stranger));
    assert!(said.contains("deployment.toml: group: the user of the service is not in"), "{said}");
    scene.open_to(0o700);
    let said = scene.refusal(&scene.deployment(&scene.group));
    assert!(said.contains("is closed to group") && said.contains("chgrp"), "{said}");
    scene.open_to(0o711);
    // Whoever is first makes it, and clients could not tell.
    fs::set_permissions(scene.above.path(), Permissions::from_mode(0o1777)).unwrap();
    let said = scene.refusal(&scene.deployment(&scene.group));
    assert!(said.contains("strangers could make"), "{said}");
    assert_eq!(scene.names(), Vec::<String>::new());
}
