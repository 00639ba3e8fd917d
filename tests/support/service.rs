//! A running service for one test, and checks of what it leaves behind.

use super::{Place, instance, left_in_shm, patience, signal, text, trolley, wait_for};
use rustix::process::Signal;
use std::io::{BufRead as _, BufReader, Read as _};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStderr, Command, Output};

/// A service, ended and checked by [`Serving::end`].
pub(crate) struct Serving {
    pub(crate) instance: String,
    pub(crate) deployment: PathBuf,
    pub(crate) child: Child,
    stderr: BufReader<ChildStderr>,
}

/// A file of the project.
pub(crate) fn shipped(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(name)
}

/// Starts a service and waits until it answers.
pub(crate) fn serve(deployment: &Path, extra: &[&str]) -> Serving {
    serve_as(deployment, &instance(), extra)
}

/// As [`serve`], in the place of an instance that was killed.
pub(crate) fn serve_as(deployment: &Path, instance: &str, extra: &[&str]) -> Serving {
    serve_by(trolley(), deployment, instance, extra)
}

/// As [`serve`], by a command to which the arguments of the program are added.
pub(crate) fn serve_by(
    mut command: Command,
    deployment: &Path,
    instance: &str,
    extra: &[&str],
) -> Serving {
    let instance = instance.to_owned();
    let mut child = command
        .args(["serve", deployment.to_str().unwrap(), "--instance", &instance])
        .args(extra)
        .spawn()
        .unwrap();
    let mut stderr = BufReader::new(child.stderr.take().unwrap());
    let mut said = String::new();
    loop {
        let mut line = String::new();
        stderr.read_line(&mut line).unwrap();
        said += &line;
        if line.contains("serving as") {
            return Serving { instance, deployment: deployment.to_owned(), child, stderr };
        }
        if line.is_empty() {
            break;
        }
    }
    let end = child.wait().unwrap();
    panic!("it ended before it served ({end}): {said}");
}

impl Serving {
    /// `trolley query` of a scenario file.
    pub(crate) fn query(&self, scenario: &Path, extra: &[&str]) -> Output {
        let files = [&self.deployment, scenario].map(|path| path.to_str().unwrap().to_owned());
        let deadline_ms = patience().as_millis().to_string();
        trolley()
            .arg("query")
            .args(files)
            .args(["--instance", &self.instance, "--deadline-ms", &deadline_ms])
            .args(extra)
            .output()
            .unwrap()
    }

    /// Ends it as systemd would, and checks what it left; returns its output.
    pub(crate) fn end(mut self) -> String {
        // A reaped process has no id any more.
        if self.child.try_wait().unwrap().is_none() {
            signal(self.child.id(), Signal::TERM);
        }
        let status = wait_for(20_000, || self.child.try_wait().unwrap()).expect("it ends");
        let mut said = String::new();
        self.stderr.read_to_string(&mut said).unwrap();
        assert!(status.success(), "{status}: {said}");
        assert_eq!(left_behind(&self.instance), Vec::<String>::new());
        said
    }
}

impl Drop for Serving {
    /// After a failed test. A service killed at once would leave its files in /dev/shm.
    fn drop(&mut self) {
        // A reaped process has no id any more.
        if matches!(self.child.try_wait(), Ok(None)) {
            signal(self.child.id(), Signal::TERM);
            // The test may have stopped it.
            signal(self.child.id(), Signal::CONT);
            let _in_time = wait_for(5_000, || self.child.try_wait().ok().flatten());
        }
        let _ended = self.child.kill();
        let _reaped = self.child.wait();
    }
}

/// What a service and its workers have in shared memory.
pub(crate) fn left_behind(instance: &str) -> Vec<String> {
    let entries =
        std::fs::read_dir(trolley::doctor::shared_folder()).into_iter().flatten().flatten();
    let names = entries.map(|entry| entry.file_name().to_string_lossy().into_owned());
    let public = format!("trolley-{instance}");
    let is_public = |name: &String| {
        name.strip_prefix(&public).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
    };
    names.filter(is_public).chain(left_in_shm(instance)).collect()
}

/// A deployment with these shapes and triangles, ids from 1, in its own folder.
pub(crate) fn deployment(place: &Place, workers: u32, bodies: &[(&str, u32, u32)]) -> PathBuf {
    let mut file = format!(
        "schema = \"trolley.deployment/1\"\ninstance = \"test\"\nmembers = 1\n\
         [engine]\nworkers = {workers}\n[realtime]\npriority = 0\nworker_priority = 0\n\
         lock_memory = false\nheap_mib = 8\n"
    );
    for (number, (shape, triangles, seed)) in bodies.iter().enumerate() {
        file += &format!(
            "[[models]]\nid = {0}\nname = \"m{0}\"\n\
             generate = {{ shape = \"{shape}\", triangles = {triangles}, seed = {seed} }}\n",
            number + 1
        );
    }
    place.write("deployment.toml", &file)
}

/// The bodies of [`ways`](super::ways).
pub(crate) fn of_ways(triangles: u32) -> Vec<(&'static str, u32, u32)> {
    let scenario = scenario::Scenario::parse("ways.toml", &super::ways(triangles)).unwrap();
    let body = |party: &scenario::Party| match party.source {
        scenario::Source::Generate { shape, triangles, seed } => {
            (shape.name(), triangles, seed as u32)
        }
        scenario::Source::File(_) => panic!("generated bodies alone"),
    };
    scenario.parties.iter().map(body).collect()
}

/// `wall-or-pole.toml` over members, with parties that are known better or worse than usual.
pub(crate) fn with_members(scenario: &str, members: u32, members_max: u32) -> String {
    let head = "schema = \"trolley.scenario/2\"\n";
    let counts = format!("{head}members = {members}\nmembers_max = {members_max}\n");
    let own = "{ lateral_m = 0.1, longitudinal_m = 0.5, correlation = 0.6, yaw_deg = 1, \
               speed_share = 0.08 }";
    let changes = [
        (head, counts),
        ("ego = { ", format!("ego = {{ errors = {own}, ")),
        (
            "[parties.pole]\n",
            "[parties.pole]\nerrors = { lateral_m = 0.3, longitudinal_m = 0 }\n".to_owned(),
        ),
    ];
    changes.iter().fold(scenario.to_owned(), |text, (from, to)| {
        assert!(text.contains(from), "{from}");
        text.replacen(from, to, 1)
    })
}

/// What an answer over members says, in every bit: of `trolley rank --json` as of `query --json`.
pub(crate) fn expected_harm(output: &Output) -> String {
    let document = super::json(output);
    let answer = document.get("answer").unwrap_or(&document);
    assert!(answer["members"].is_object(), "{}", text(&output.stderr));
    let only = |value: &serde_json::Value, keys: &[&str]| {
        keys.iter().map(|key| format!("\"{key}\": {} ", value[*key])).collect::<String>()
    };
    let row = |row: &serde_json::Value| {
        let keys = ["contact", "meets", "injured", "open", "undecided", "spread", "worlds"];
        only(row, &["name", "work", "range"]) + &only(&row["expected"], &keys) + "\n"
    };
    let rows: String = answer["ranking"].as_array().unwrap().iter().map(row).collect();
    let all = ["count", "most", "replaced", "lead", "is_late"];
    rows + &only(&answer["members"], &all)
}

/// The ranking of `trolley query --json`: names, work and range.
pub(crate) fn ranking(output: &Output) -> Vec<(String, [u64; 4])> {
    rows(&super::json(output)["ranking"], output)
}

/// The ranking of `trolley rank --json`.
pub(crate) fn ranked(output: &Output) -> Vec<(String, [u64; 4])> {
    rows(&super::json(output)["answer"]["ranking"], output)
}

fn rows(ranking: &serde_json::Value, output: &Output) -> Vec<(String, [u64; 4])> {
    let ranking = ranking.as_array().unwrap_or_else(|| panic!("{}", text(&output.stderr)));
    let bits = |row: &serde_json::Value, key: &str, end: usize| {
        row[key][end].as_f64().unwrap_or(f64::NAN).to_bits()
    };
    let row = |row: &serde_json::Value| {
        let ends = [("work", 0), ("work", 1), ("range", 0), ("range", 1)];
        (row["name"].as_str().unwrap().to_owned(), ends.map(|(key, end)| bits(row, key, end)))
    };
    ranking.iter().map(row).collect()
}

/// The signals that end a program by default and are not ignored here: under nohup(1) SIGHUP is,
/// and stays so in what a test starts.
pub(crate) fn heard_signals() -> impl Iterator<Item = rustix::process::Signal> {
    use rustix::process::Signal;
    let status = std::fs::read_to_string("/proc/self/status").unwrap();
    let ignored = status.lines().find_map(|line| line.strip_prefix("SigIgn:")).unwrap();
    let ignored = u64::from_str_radix(ignored.trim(), 16).unwrap();
    let is_heard = move |signal: &Signal| ignored >> (signal.as_raw() - 1) & 1 == 0;
    [Signal::HUP, Signal::INT, Signal::QUIT, Signal::TERM].into_iter().filter(is_heard)
}
