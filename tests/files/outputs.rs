//! No command replaces what is no regular file: a device of everybody, a pipe, a socket, a folder.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use crate::support::service::shipped;
use crate::support::{Place, instance, text, trolley, ways};
use crate::traffic::crossing;
use rustix::fs::{CWD, FileType, Mode, mknodat};
use std::os::unix::fs::{MetadataExt as _, symlink};
use std::os::unix::net::UnixListener;
use std::path::Path;

/// Each command line that writes a file; `?` is the file.
const COMMANDS: &[&str] = &[
    "report RECORD --out ?",
    "report RECORD --glb ?",
    "report RECORD --png ?",
    "rank SIX.toml --in-process --record ?",
    "rank CROSSING.xml --in-process --report ?",
    "scenario import CROSSING.xml -o ?",
    "model generate pole --triangles 600 -o ?",
    "model import MESH.obj --kind pole -o ?",
    "model export POLE.trolley --format stl -o ?",
    "measure --scenario SIX.toml --workers 1 --job-log ?",
    "measure --quick --out ?",
    "calibrate --out ?",
    "certify share --requests 1 --out ?",
    "inject PLAN.toml --junit ?",
];

/// They write into folders, and so may name one.
const INTO_FOLDERS: [&str; 4] = ["--glb ?", "--png ?", "--record ?", "--quick --out ?"];

/// What is at a path, without following it.
fn identity(path: &Path) -> (u64, std::fs::FileType) {
    let about = std::fs::symlink_metadata(path).unwrap();
    (about.ino(), about.file_type())
}

/// Runs a command line; words in capitals are files of the place.
fn said(place: &Place, line: &str, out: &str) -> (Option<i32>, String) {
    let word = |word: &str| match word {
        "?" => out.to_owned(),
        _ if word.starts_with(|c: char| c.is_uppercase()) => {
            place.path().join(word).to_str().unwrap().to_owned()
        }
        _ => word.to_owned(),
    };
    let args: Vec<String> = line.split(' ').map(word).collect();
    let output = trolley().args(&args).output().unwrap();
    (output.status.code(), text(&output.stdout) + &text(&output.stderr))
}

#[test]
fn no_command_replaces_what_is_no_regular_file() {
    let place = Place::new();
    place.write("SIX.toml", &ways(600));
    place.write("CROSSING.xml", &crossing(0.5, "parkedVehicle"));
    place.write("MESH.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 5\nf 1 2 3\nf 1 2 4\nf 1 3 4\n");
    let plan = std::fs::read_to_string(shipped("config/faults/quick.toml")).unwrap();
    place.write("PLAN.toml", &plan.replace("../scenarios/small.toml", "SIX.toml"));
    for line in [
        "model generate pole --triangles 600 -o POLE.trolley",
        &format!("rank SIX.toml --in-process --record RECORDS --instance {}", instance()),
    ] {
        let (code, said) = said(&place, line, "");
        assert_eq!(code, Some(0), "{said}");
    }
    std::fs::rename(place.path().join("RECORDS/000000.record"), place.path().join("RECORD"))
        .unwrap();

    let named = |name: &str| place.path().join(name);
    let mode = Mode::RUSR | Mode::WUSR;
    mknodat(CWD, named("pipe"), FileType::Fifo, mode, 0).unwrap();
    let _listens = UnixListener::bind(named("socket")).unwrap();
    std::fs::create_dir(named("folder")).unwrap();
    symlink("/dev/null", named("to-null")).unwrap();
    let mut all = vec!["pipe", "socket", "folder", "to-null"];
    // A /dev/null of our own, where this user may make one.
    let null = rustix::fs::makedev(1, 3);
    let device = mknodat(CWD, named("null"), FileType::CharacterDevice, mode, null);
    all.extend(device.is_ok().then_some("null"));
    for name in all {
        let path = named(name);
        let before = identity(&path);
        for line in COMMANDS {
            if name == "folder" && INTO_FOLDERS.iter().any(|end| line.ends_with(end)) {
                continue;
            }
            let (code, said) = said(&place, line, path.to_str().unwrap());
            assert_eq!(code, Some(71), "{line}, {name}: {said}");
            assert!(said.contains(path.to_str().unwrap()), "{line}, {name}: {said}");
            assert!(said.contains("help: "), "{line}, {name}: {said}");
            assert!(identity(&path) == before, "{line}: {name} is another now");
        }
    }
}
