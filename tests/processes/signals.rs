//! SIGINT is as it was inherited: ignored where the parent ignores it, as what a script starts with
//! `&`; else Ctrl-C ends the program with its documented code, and nothing stays in shared memory.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use crate::support::service::{deployment, left_behind, of_ways, serve_by};
use crate::support::{
    Place, heavy, instance, left_in_shm, signal, text, trolley, wait_for, workers_at_work,
};
use rustix::process::Signal;
use std::os::unix::process::ExitStatusExt as _;
use std::process::{Child, Command, Output, Stdio};

/// The program, started by the words of a command that becomes the one named after them.
fn started_by(words: &[&str]) -> Command {
    let mut command = Command::new(words[0]);
    command.args(&words[1..]).arg(trolley().get_program());
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

/// The program, with SIGINT ignored.
fn deaf() -> Command {
    started_by(&["sh", "-c", "trap '' INT; exec \"$0\" \"$@\""])
}

/// The program, with SIGINT as a terminal gives it, also where these tests were started with `&`.
fn hearing() -> Command {
    started_by(&["env", "--default-signal=INT"])
}

/// How a command that works with two workers ends that is interrupted in the middle. `command`
/// gives one that begins anew.
fn interrupted(command: impl Fn() -> Command, args: &[&str]) -> Output {
    let place = Place::new();
    for triangles in [10_000, 20_000, 40_000, 80_000, 160_000] {
        let path = place.write("heavy.toml", &heavy(triangles));
        let path = path.to_str().unwrap();
        let instance = instance();
        let args = args.iter().map(|word| if *word == "?" { path } else { word });
        let mut child: Child = command()
            .args(args)
            .args(["--json", "--workers", "2", "--instance", &instance])
            .spawn()
            .unwrap();
        let is_at_work = workers_at_work(&mut child, 2).is_some();
        if is_at_work {
            signal(child.id(), Signal::INT);
        }
        let output = child.wait_with_output().unwrap();
        assert_eq!(left_in_shm(&instance), Vec::<String>::new());
        // One whose work ended before the signal came did not hear it: it succeeds, or ends by the
        // signal itself once all is cleaned up.
        let is_deaf = command().get_program() == "sh";
        let has_heard = !output.status.success() && output.status.signal().is_none();
        if is_at_work && (is_deaf || has_heard) {
            return output;
        }
    }
    panic!("no run took long enough to be interrupted");
}

const COMMANDS: [&[&str]; 2] = [&["rank", "?"], &["measure", "--scenario", "?"]];

#[test]
fn ctrl_c_ends_a_run_with_130_and_leaves_nothing() {
    for args in COMMANDS {
        let output = interrupted(hearing, args);
        assert_eq!(output.status.code(), Some(130), "{args:?}: {}", text(&output.stderr));
        assert!(text(&output.stderr).contains("interrupted"), "{}", text(&output.stderr));
    }
}

#[test]
fn a_run_that_was_started_deaf_to_ctrl_c_answers() {
    for args in COMMANDS {
        let output = interrupted(deaf, args);
        assert_eq!(output.status.code(), Some(0), "{args:?}: {}", text(&output.stderr));
        assert!(text(&output.stdout).contains("\"ranking\""), "{}", text(&output.stderr));
    }
}

#[test]
fn a_service_hears_ctrl_c_unless_it_was_started_deaf() {
    let place = Place::new();
    let bodies = of_ways(600);
    let scenario = place.write("ways.toml", &crate::support::ways(600));

    let mut serving = serve_by(hearing(), &deployment(&place, 2, &bodies), &instance(), &[]);
    signal(serving.child.id(), Signal::INT);
    let status = wait_for(20_000, || serving.child.try_wait().unwrap()).expect("it ends");
    assert_eq!(status.code(), Some(0));
    assert_eq!(left_behind(&serving.instance), Vec::<String>::new());

    let mut serving = serve_by(deaf(), &deployment(&place, 2, &bodies), &instance(), &[]);
    signal(serving.child.id(), Signal::INT);
    let answer = serving.query(&scenario, &[]);
    assert!(answer.status.success(), "{}", text(&answer.stderr));
    assert!(serving.child.try_wait().unwrap().is_none(), "it goes on");
    serving.end();
}

/// Folders that a campaign of this process id made.
fn folders_of(pid: u32) -> Vec<String> {
    let begin = format!("i{pid:x}.");
    let entries = std::fs::read_dir("/dev/shm").into_iter().flatten().flatten();
    let names = entries.map(|entry| entry.file_name().to_string_lossy().into_owned());
    names.filter(|name| name.starts_with(&begin)).collect()
}

/// Regression: a campaign that was told to end left the folder of its service.
#[test]
fn a_campaign_that_is_told_to_end_leaves_no_folder() {
    let place = Place::new();
    place.write("ways.toml", &crate::support::ways(600));
    let plan = "schema = \"trolley.faults/1\"\nscenario = \"ways.toml\"\nasked = \"ways.toml\"\n\
                workers = 2\ndepth = 4\nat_once = 1\n[faults]\nflip-management = 1000\n";
    let plan = place.write("plan.toml", plan);
    for end in [Signal::TERM, Signal::INT] {
        let mut child = hearing().arg("inject").arg(&plan).spawn().unwrap();
        let pid = child.id();
        let made = wait_for(60_000, || {
            let is_over = child.try_wait().unwrap().is_some();
            (is_over || !folders_of(pid).is_empty()).then_some(())
        });
        assert!(made.is_some() && !folders_of(pid).is_empty(), "no service was started");
        signal(pid, end);
        let output = child.wait_with_output().unwrap();
        assert_eq!(folders_of(pid), Vec::<String>::new(), "{end:?}");
        assert_eq!(output.status.code(), Some(130), "{end:?}: {}", text(&output.stderr));
        let said = text(&output.stdout);
        assert!(said.contains("interrupted: the plan was not finished"), "{end:?}: {said}");
    }
}
