//! Every shipped client, against one live service: Rust, C++ and Python rank like `trolley rank`,
//! to the last digit. Also checks what integrators install.
//!
//! A client whose tools are missing is skipped, with a visible message.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use crate::support::service::{ranked, serve, shipped};
use crate::support::{self, Place, run, skipped, text, trolley};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// Names and work of a ranking that an example printed: "1 wall, frontal 0.1 0.2".
fn printed(output: &Output) -> Vec<(String, [u64; 2])> {
    assert!(output.status.success(), "{}", text(&output.stderr));
    let row = |line: &str| {
        let mut words = line.rsplitn(3, ' ');
        let mut number = || words.next()?.parse::<f64>().ok();
        let (hi, lo) = (number().unwrap(), number().unwrap());
        let name = words.next().unwrap().split_once(' ').unwrap().1;
        (name.to_owned(), [lo.to_bits(), hi.to_bits()])
    };
    text(&output.stdout).lines().map(row).collect()
}

/// Builds a part of this workspace as the tests were built; returns the output folder.
///
/// Of the whole workspace: for one package alone, features of its dependencies may differ, and all
/// of them would be compiled once more.
fn build(args: &[&str]) -> PathBuf {
    let folder = Path::new(env!("CARGO_BIN_EXE_trolley")).parent().unwrap().to_owned();
    let mut cargo = Command::new(env!("CARGO"));
    cargo.args(["build", "--workspace"]).args(args).current_dir(shipped("."));
    cargo.env("CARGO_TARGET_DIR", folder.parent().unwrap());
    if folder.ends_with("release") {
        cargo.arg("--release");
    }
    let output = cargo.output().unwrap();
    assert!(output.status.success(), "{}", text(&output.stderr));
    folder
}

fn has(program: &str) -> bool {
    Command::new(program).arg("--version").output().is_ok_and(|output| output.status.success())
}

#[test]
fn all_clients_see_the_ranking_of_rank() {
    let three = shipped("config/scenarios/wall-or-pole.toml");
    let rank = run(&["rank", three.to_str().unwrap(), "--json"]);
    let work = |(name, [lo, hi, _, _]): (String, [u64; 4])| (name, [lo, hi]);
    let expected: Vec<_> = ranked(&rank).into_iter().map(work).collect();
    let serving = serve(&shipped("config/deployments/minimal.toml"), &[]);
    let instance = serving.instance.clone();

    let folder = build(&["--example", "planner"]);
    let rust = Command::new(folder.join("examples/planner")).args(["3", &instance]).output();
    assert_eq!(printed(&rust.unwrap()), expected, "Rust");

    if has("g++") {
        let place = Place::new();
        let planner = place.path().join("planner");
        let folder = build(&["--lib"]);
        let compiled = Command::new("g++")
            .args(["-std=c++17", "-Wall", "-Wextra", "-Werror", "-I"])
            .arg(shipped("crates/client-c/include"))
            .arg(shipped("crates/client-c/examples/planner.cpp"))
            .arg("-L")
            .arg(&folder)
            .args(["-ltrolley_client", "-o"])
            .arg(&planner)
            .output()
            .unwrap();
        assert!(compiled.status.success(), "{}", text(&compiled.stderr));
        let mut asked = Command::new(&planner);
        asked.arg(&instance).env("LD_LIBRARY_PATH", &folder);
        assert_eq!(printed(&asked.output().unwrap()), expected, "C++");
        // Without a service it reports that, and does not crash.
        let nobody = Command::new(&planner)
            .arg("nobody-here")
            .env("LD_LIBRARY_PATH", &folder)
            .output()
            .unwrap();
        assert_eq!(nobody.status.code(), Some(75));
        assert!(text(&nobody.stderr).contains("no service is running"));
    } else {
        skipped("the C++ client: there is no g++");
    }

    if has("python3") {
        let folder = build(&["--lib"]);
        let asked = Command::new("python3")
            .arg(shipped("tools/clients/planner.py"))
            .arg(&instance)
            .env("LD_LIBRARY_PATH", &folder)
            .output();
        assert_eq!(printed(&asked.unwrap()), expected, "Python");
    } else {
        skipped("the Python client: there is no python3");
    }

    let top = trolley()
        .args(["top", serving.deployment.to_str().unwrap(), "--instance", &instance])
        .args(["--times", "1", "--json"])
        .output()
        .unwrap();
    let top = support::json(&top);
    assert_eq!(top["condition"], "ready", "{top}");
    assert!(top["answers"][0][1].as_u64().unwrap() >= 4, "{top}");
    serving.end();
}

#[test]
fn doctor_names_what_it_found_and_a_remedy_for_whatever_is_not_well() {
    let output = trolley().args(["doctor", "--json"]).output().unwrap();
    let document = support::json(&output);
    assert_eq!(document["schema"], "trolley.doctor/1");
    let findings = document["findings"].as_array().unwrap();
    assert!(findings.len() >= 10);
    let level = |finding: &serde_json::Value| finding["level"].as_str().unwrap().to_owned();
    for finding in findings {
        let is_well = level(finding) == "ok";
        assert_eq!(finding["remedy"].as_str().unwrap().is_empty(), is_well, "{finding}");
    }
    let has_problem = findings.iter().any(|finding| level(finding) == "problem");
    assert_eq!(output.status.code(), Some(i32::from(has_problem)));
    let people = text(&trolley().arg("doctor").output().unwrap().stdout);
    for subject in ["cores", "memory", "fixed priority", "leftovers", "versions"] {
        assert!(people.contains(subject), "{people}");
    }
}

#[test]
fn the_unit_is_one_that_systemd_accepts() {
    if !has("systemd-analyze") {
        return skipped("the systemd unit: there is no systemd-analyze");
    }
    let place = Place::new();
    let unit = std::fs::read_to_string(shipped("tools/systemd/trolley.service")).unwrap();
    let installed = "/usr/local/bin/trolley";
    assert!(unit.contains(installed));
    let unit_here = unit.replace(installed, env!("CARGO_BIN_EXE_trolley"));
    let here = place.write("trolley.service", &unit_here);
    let verified = Command::new("systemd-analyze").arg("verify").arg(&here).output().unwrap();
    assert!(verified.status.success(), "{}", text(&verified.stderr));
    // Settings that would break the service must not creep in.
    for broken in ["PrivateTmp=yes", "RemoveIPC=yes", "RestrictRealtime=yes", "PrivateIPC=yes"] {
        assert!(!unit.lines().any(|line| line == broken), "{broken}");
    }
}

#[test]
fn the_install_script_puts_everything_in_its_place() {
    let place = Place::new();
    let root = place.path().join("root");
    let folder = Path::new(env!("CARGO_BIN_EXE_trolley")).parent().unwrap();
    if !folder.ends_with("release") {
        // It installs release builds: pass this program off as one.
        let release = place.path().join("target/release");
        std::fs::create_dir_all(&release).unwrap();
        std::fs::copy(env!("CARGO_BIN_EXE_trolley"), release.join("trolley")).unwrap();
    }
    let target = if folder.ends_with("release") {
        folder.parent().unwrap().to_owned()
    } else {
        place.path().join("target")
    };
    let install = || {
        Command::new("bash")
            .arg(shipped("tools/systemd/install"))
            .env("DESTDIR", &root)
            .env("CARGO_TARGET_DIR", &target)
            .output()
            .unwrap()
    };
    let output = install();
    assert!(output.status.success(), "{}", text(&output.stderr));
    let program = Command::new(root.join("usr/local/bin/trolley")).arg("--version").output();
    assert!(program.unwrap().status.success());
    assert!(root.join("etc/systemd/system/trolley.service").is_file());
    // Manual changes are kept.
    let deployment = root.join("etc/trolley/deployment.toml");
    std::fs::write(&deployment, "mine").unwrap();
    assert!(install().status.success());
    assert_eq!(std::fs::read_to_string(&deployment).unwrap(), "mine");
}
