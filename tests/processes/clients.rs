//! Every shipped client, against one live service: Rust, C++ and Python rank like `trolley rank`,
//! to the last digit. Also checks what integrators install.
//!
//! A client whose tools are missing is skipped, with a visible message.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use crate::support::service::{serve, shipped};
use crate::support::{self, Place, run, skipped, text, trolley};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// What an example printed: "1 wall, frontal: 0.1 0.2" for each candidate, with members what they
/// say after that, and "8 members: 0.1 0.2", the lead. Each with the bits of its figures.
fn printed(output: &Output) -> Vec<(String, Vec<u64>)> {
    assert!(output.status.success(), "{}", text(&output.stderr));
    let row = |line: &str| {
        let (name, figures) = line.split_once(": ").unwrap();
        let bits = |figure: &str| figure.parse::<f64>().unwrap().to_bits();
        (name.to_owned(), figures.split(' ').map(bits).collect())
    };
    text(&output.stdout).lines().map(row).collect()
}

/// The same of `trolley rank --json`.
fn of_rank(output: &Output) -> Vec<(String, Vec<u64>)> {
    let document = support::json(output);
    let answer = &document["answer"];
    let bits = |value: &serde_json::Value| value.as_f64().unwrap().to_bits();
    let row = |(number, row): (usize, &serde_json::Value)| {
        let mut figures = vec![&row["work"][0], &row["work"][1]];
        let of = &row["expected"];
        let mut all: Vec<u64> = Vec::new();
        if of.is_object() {
            let spread = &of["spread"];
            figures.extend([&of["contact"], &of["injured"][0], &of["injured"][1]]);
            figures.push(&spread["error"]);
            figures.extend(spread["quantiles"].as_array().unwrap());
            figures.extend([&spread["best"], &spread["regret"], &of["worlds"]]);
        }
        all.extend(figures.into_iter().map(bits));
        for met in of["meets"].as_array().into_iter().flatten() {
            // The planners number the pole and the wall so.
            let party = if met["party"] == "pole" { 1.0_f64 } else { 2.0 };
            all.extend([party.to_bits(), bits(&met["probability"]), bits(&met["from_s"])]);
        }
        (format!("{} {}", number + 1, row["name"].as_str().unwrap()), all)
    };
    let rows = answer["ranking"].as_array().unwrap().iter().enumerate().map(row);
    let members = &answer["members"];
    let lead = members.is_object().then(|| {
        let figures = [&members["lead"]["mean"], &members["lead"]["error"]].map(bits);
        (format!("{} members", members["count"]), figures.to_vec())
    });
    rows.chain(lead).collect()
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
    let place = Place::new();
    let shipped_text = std::fs::read_to_string(shipped("config/scenarios/wall-or-pole.toml"));
    // What the planners state of the ego and the pole.
    let known = shipped_text
        .unwrap()
        .replacen(
            "ego = { generate = ",
            "ego = { errors = { lateral_m = 0.1, longitudinal_m = 0.5, \
                  correlation = 0.25, yaw_deg = 1.5, speed_share = 0.08 }, generate = ",
            1,
        )
        .replacen(
            "[parties.pole]\n",
            "[parties.pole]\nerrors = { lateral_m = 0.4, longitudinal_m = 0.6, correlation = 0 }\n",
            1,
        );
    assert_eq!(known.matches("errors = ").count(), 2);
    let known = place.write("known.toml", &known);
    let rank = |members: &str| {
        let counts = ["--members", members, "--members-max", members];
        of_rank(&run(&[&["rank", known.to_str().unwrap(), "--json"], &counts[..]].concat()))
    };
    let (stated, drawn) = (rank("1"), rank("8"));
    assert_eq!((stated.len(), drawn.len()), (3, 4), "{drawn:?}");
    assert!(drawn[1].1.len() >= 12 + 3, "{drawn:?}");
    let serving = serve(&shipped("config/deployments/minimal.toml"), &[]);
    let instance = serving.instance.clone();
    let asks_alike = |client: &str, command: &dyn Fn() -> Command| {
        let ask = |members: &str| printed(&command().args(["", members]).output().unwrap());
        assert_eq!(ask("1"), stated, "{client}");
        assert_eq!(ask("8"), drawn, "{client} over members");
    };

    let folder = build(&["--example", "planner"]);
    asks_alike("Rust", &|| {
        let mut planner = Command::new(folder.join("examples/planner"));
        planner.args(["3", &instance]);
        planner
    });

    if has("g++") {
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
        asks_alike("C++", &|| {
            let mut asked = Command::new(&planner);
            asked.arg(&instance).env("LD_LIBRARY_PATH", &folder);
            asked
        });
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
        asks_alike("Python", &|| {
            let mut asked = Command::new("python3");
            asked.arg(shipped("tools/clients/planner.py")).arg(&instance);
            asked.env("LD_LIBRARY_PATH", &folder);
            asked
        });
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
