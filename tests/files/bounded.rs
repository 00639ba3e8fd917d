//! Inputs that are no regular file, or never end, are refused at once by every command that reads
//! one, with their name and a remedy.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use crate::support::service::shipped;
use crate::support::{Place, text, trolley, wait_for, ways};
use std::io::Write as _;
use std::os::unix::fs::PermissionsExt as _;
use std::os::unix::net::UnixListener;
use std::path::{Path, PathBuf};
use std::process::{Output, Stdio};

/// Longer than any limit; it takes no room on the disk.
const ENDLESS: u64 = 3 << 30;

/// Output of a command that must end at once.
fn ended(args: &[&str]) -> Output {
    let mut child = trolley().args(args).spawn().unwrap();
    let in_time = wait_for(20_000, || child.try_wait().unwrap());
    if in_time.is_none() {
        child.kill().unwrap();
    }
    let output = child.wait_with_output().unwrap();
    assert!(in_time.is_some(), "{args:?} does not end: {}", text(&output.stderr));
    output
}

fn utf8(path: &Path) -> &str {
    path.to_str().unwrap()
}

/// What is no input: a pipe, a socket, a device, a folder, and a file without end.
fn no_inputs(place: &Place) -> Vec<PathBuf> {
    let (pipe, socket, long) =
        (place.path().join("pipe"), place.path().join("socket"), place.path().join("long"));
    let mode = rustix::fs::Mode::RUSR | rustix::fs::Mode::WUSR;
    rustix::fs::mknodat(rustix::fs::CWD, &pipe, rustix::fs::FileType::Fifo, mode, 0).unwrap();
    drop(UnixListener::bind(&socket).unwrap());
    std::fs::File::create(&long).unwrap().set_len(ENDLESS).unwrap();
    vec![pipe, socket, "/dev/zero".into(), place.path().join("folder"), long]
}

/// Each command line that reads a file; `?` is the file.
const COMMANDS: &[&str] = &[
    "rank ? --in-process",
    "measure --scenario ? --in-process",
    "measure --pair ?,pole:600,deep --out OUT",
    "measure --pair pole:600,pole:600,? --out OUT",
    "certify budget --body ? --body pole:600 --jobs 1",
    "inject ?",
    "policy check ?",
    "policy check DEFAULT.toml --curves ?",
    "scenario import ?",
    "scenario import CROSSING.xml --bodies ?",
    "scenario import CROSSING.xml --solution ?",
    "record show ?",
    "record replay ?",
    "record verify ?",
    "record verify RECORDS --key ?",
    "record verify RECORDS --head ?",
    "rank SIX.toml --in-process --record RECORDS --sign ?",
    "report ? --out OUT.html",
    "serve ?",
    "top ? --times 1",
    "query ? SIX.toml",
    "query DEPLOYMENT.toml ?",
    "intersect ? MESH.obj --poses POSES",
    "intersect MESH.obj MESH.obj --poses ?",
    "model info ?",
    "model check ?",
    "model export ? -o OUT.stl",
    "model import ? --kind pole -o OUT.trolley",
];

/// Folders are an input of these.
const OF_FOLDERS: [&str; 3] = ["record verify ?", "report ? --out OUT.html", "model check ?"];

/// A place with the files that the commands name.
fn with_files() -> Place {
    let place = Place::new();
    std::fs::create_dir(place.path().join("folder")).unwrap();
    place.write("SIX.toml", &ways(600));
    std::fs::create_dir(place.path().join("RECORDS")).unwrap();
    place.write("POSES", &"1 0 0 0\n0 1 0 0\n0 0 1 0\n".repeat(2));
    place.write("MESH.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    for (name, from) in [
        ("DEFAULT.toml", "config/policies/default.toml"),
        ("DEPLOYMENT.toml", "config/deployments/minimal.toml"),
        ("CROSSING.xml", "config/examples/crossing.xml"),
    ] {
        std::fs::copy(shipped(from), place.path().join(name)).unwrap();
    }
    place
}

/// The words of a command line that reads this file.
fn words(place: &Place, line: &str, file: &Path) -> Vec<String> {
    let word = |word: &str| match word {
        "?" => utf8(file).to_owned(),
        _ if word.contains('?') => word.replace('?', utf8(file)),
        _ if word.starts_with(|c: char| c.is_uppercase()) => {
            utf8(&place.path().join(word)).to_owned()
        }
        _ => word.to_owned(),
    };
    line.split(' ').map(word).collect()
}

/// Contents that no command expects, by their name.
fn odd_contents() -> Vec<(&'static str, Vec<u8>)> {
    let noise = |i: u32| (i.wrapping_mul(2_654_435_761) >> 23) as u8;
    let utf_16 = "schema = \"a\"\n".encode_utf16().flat_map(u16::to_le_bytes);
    vec![
        ("empty", Vec::new()),
        ("a line feed", b"\n".to_vec()),
        ("zeros", vec![0; 5_000]),
        ("noise", (0..5_000).map(noise).collect()),
        ("a byte order mark", b"\xEF\xBB\xBF".to_vec()),
        ("UTF-16", [0xFF, 0xFE].into_iter().chain(utf_16).collect()),
        ("Latin-1", b"name = \"caf\xE9\"\n".to_vec()),
        ("one long line", vec![b'x'; 200_000]),
        ("nested lists", [b"a = ".to_vec(), vec![b'['; 100_000]].concat()),
        ("nested JSON", vec![b'['; 100_000]),
        ("an open string", b"name = \"never closed".to_vec()),
        ("a key twice", b"a = 1\na = 2\n".to_vec()),
        ("a mesh", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n".to_vec()),
        ("a program", b"\x7FELF\x02\x01\x01\0\0\0\0\0\0\0\0\0".to_vec()),
    ]
}

/// Whatever a file holds, the command that reads it says which file it is, and what would help.
#[test]
fn every_command_names_the_file_whose_contents_are_odd() {
    let place = with_files();
    let mut files: Vec<PathBuf> = vec![place.path().join("missing"), "/dev/null".into()];
    for (number, (_, content)) in odd_contents().iter().enumerate() {
        let path = place.path().join(format!("odd-{number}"));
        std::fs::write(&path, content).unwrap();
        files.push(path);
    }
    // Whoever may read everything may read this, too.
    let closed = place.path().join("closed");
    std::fs::write(&closed, "a = 1\n").unwrap();
    std::fs::set_permissions(&closed, std::fs::Permissions::from_mode(0o0)).unwrap();
    files.extend(std::fs::read(&closed).is_err().then_some(closed));
    let mut faults = Vec::new();
    for file in &files {
        for line in COMMANDS {
            let args = words(&place, line, file);
            let args: Vec<&str> = args.iter().map(String::as_str).collect();
            let output = ended(&args);
            let said = text(&output.stdout) + &text(&output.stderr);
            let names = said.contains(utf8(file)) && said.contains("help: ");
            let is_refused = matches!(output.status.code(), Some(65 | 78));
            if !names || !is_refused || said.contains("panicked") {
                let said: String = said.chars().take(400).collect();
                faults.push(format!(
                    "{:?} {line} {}\n{said}",
                    output.status.code(),
                    file.display()
                ));
            }
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n\n"));
}

// verifies REQ-INPUT
#[test]
fn every_command_refuses_at_once_what_is_no_regular_file_or_too_long() {
    let place = with_files();
    for file in &no_inputs(&place) {
        for line in COMMANDS {
            if file.is_dir() && OF_FOLDERS.contains(line) {
                continue;
            }
            let args = words(&place, line, file);
            let args: Vec<&str> = args.iter().map(String::as_str).collect();
            let output = ended(&args);
            let said = text(&output.stdout) + &text(&output.stderr);
            assert_eq!(output.status.code(), Some(65), "{args:?}: {said}");
            assert!(said.contains(utf8(file)) && said.contains("help: "), "{args:?}: {said}");
        }
    }
}

#[test]
fn what_a_file_names_is_read_with_the_same_care() {
    let place = Place::new();
    std::fs::create_dir(place.path().join("folder")).unwrap();
    let minimal = std::fs::read_to_string(shipped("config/deployments/minimal.toml")).unwrap();
    let ego = "generate = { shape = \"sedan\", triangles = 600 }";
    for file in &no_inputs(&place) {
        // A device is outside of the scenario's folder, and a link to it leads there.
        let (more, name) = match file.file_name().unwrap().to_str().unwrap() {
            "zero" => (Some("--allow-outside"), "/dev/zero"),
            name => (None, name),
        };
        let key = |key: &str| format!("{key} = \"{name}\"\n[parties.ego]");
        for (number, scenario) in [
            ways(600).replacen("[parties.ego]", &key("policy"), 1),
            ways(600).replacen("[parties.ego]", &key("curves"), 1),
            ways(600).replacen(ego, &format!("file = \"{name}\""), 1),
        ]
        .iter()
        .enumerate()
        {
            let scenario = place.write("scenario.toml", scenario);
            let args = ["rank", utf8(&scenario), "--in-process"];
            let output = ended(&[&args[..], more.as_slice()].concat());
            let said = text(&output.stderr);
            assert_eq!(output.status.code(), Some(65), "{number}: {said}");
            for part in ["scenario.toml:", name, "help: "] {
                assert!(said.contains(part), "{number}: {said}");
            }
        }
        for (from, to) in [
            ("[engine]", format!("policy = \"{name}\"\n[engine]")),
            ("[engine]", format!("curves = \"{name}\"\n[engine]")),
            ("generate = { shape = \"wall\", triangles = 2000 }", format!("model = \"{name}\"")),
        ] {
            assert!(minimal.contains(from));
            let deployment = place.write("deployment.toml", &minimal.replacen(from, &to, 1));
            let output = ended(&[&["serve", utf8(&deployment)][..], more.as_slice()].concat());
            let said = text(&output.stderr);
            assert_eq!(output.status.code(), Some(65), "{to}: {said}");
            assert!(said.contains(name) && said.contains("help: "), "{to}: {said}");
        }
    }
}

#[test]
fn stdin_is_read_up_to_the_limit_whatever_it_is() {
    let check = |stdin: Stdio| {
        let mut child = trolley();
        child.args(["policy", "check", "/dev/stdin"]).stdin(stdin).spawn().unwrap()
    };
    let policy = std::fs::read(shipped("config/policies/default.toml")).unwrap();
    let mut piped = check(Stdio::piped());
    let mut pipe = piped.stdin.take().unwrap();
    pipe.write_all(&policy).unwrap();
    drop(pipe);
    let output = piped.wait_with_output().unwrap();
    assert!(output.status.success(), "{}", text(&output.stderr));
    let file = std::fs::File::open(shipped("config/policies/default.toml")).unwrap();
    let output = check(file.into()).wait_with_output().unwrap();
    assert!(output.status.success(), "{}", text(&output.stderr));

    let zero = std::fs::File::open("/dev/zero").unwrap();
    let output = check(zero.into()).wait_with_output().unwrap();
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(65), "{said}");
    assert!(said.contains("/dev/stdin: more than 1048576 bytes"), "{said}");
}
