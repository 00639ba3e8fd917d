//! Signed records of real runs: whatever somebody without the key does to them is found and named,
//! and whatever ends a writer, the next one goes on.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use crate::support::keys::Keys;
use crate::support::{Place, json, text, trolley, wait_for};
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// Two small bodies: a record of some kilobytes.
const SMALL: &str = "schema = \"trolley.scenario/2\"\nname = \"small\"\n\
    [parties.ego]\ngenerate = { shape = \"sedan\", triangles = 600 }\n\
    [parties.pole]\ngenerate = { shape = \"pole\", triangles = 600 }\n\
    place = { position_m = [10, 0, 0] }\n\
    [[candidates]]\nname = \"middle\"\nstate = { position_m = [0, 0, 0], speed_m_s = 8 }\n";

fn utf8(path: &Path) -> &str {
    path.to_str().unwrap()
}

/// `trolley rank` with a record, signed or not.
fn rank(place: &Place, records: &Path, key: Option<&Path>) -> Command {
    let scenario = place.path().join("small.toml");
    if !scenario.exists() {
        std::fs::write(&scenario, SMALL).unwrap();
    }
    let mut command = trolley();
    command.args(["rank", utf8(&scenario), "--in-process", "--depth", "2"]);
    command.args(["--record", utf8(records)]);
    command.args(key.iter().flat_map(|key| ["--sign", utf8(key)]));
    command
}

fn recorded(place: &Place, records: &Path, key: Option<&Path>) {
    let output = rank(place, records, key).output().unwrap();
    assert!(output.status.success(), "{}", text(&output.stderr));
}

fn verify(path: &Path, extra: &[&str]) -> Output {
    trolley().args(["record", "verify", utf8(path)]).args(extra).output().unwrap()
}

/// The words of a check that passed, on one line.
fn passed(path: &Path, extra: &[&str]) -> String {
    let output = verify(path, extra);
    assert!(output.status.success(), "{}", text(&output.stderr));
    text(&output.stdout).split_whitespace().collect::<Vec<_>>().join(" ")
}

/// The error of a check that failed.
fn found(path: &Path, extra: &[&str]) -> String {
    let output = verify(path, extra);
    let error = text(&output.stderr);
    assert_eq!(output.status.code(), Some(65), "{error}{}", text(&output.stdout));
    assert!(error.contains("help: ") && output.stdout.is_empty(), "{error}");
    error
}

fn record(folder: &Path, number: u64) -> PathBuf {
    folder.join(format!("{number:06}.record"))
}

/// A folder of this many signed records.
fn signed(place: &Place, name: &str, key: &Path, count: usize) -> PathBuf {
    let records = place.path().join(name);
    (0..count).for_each(|_| recorded(place, &records, Some(key)));
    records
}

/// The files of a folder, to put them back.
fn files(folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    entries.map(|path| (path.clone(), std::fs::read(path).unwrap())).collect()
}

fn put_back(folder: &Path, files: &[(PathBuf, Vec<u8>)]) {
    std::fs::remove_dir_all(folder).unwrap();
    std::fs::create_dir(folder).unwrap();
    files.iter().for_each(|(path, bytes)| std::fs::write(path, bytes).unwrap());
}

#[test]
fn what_a_check_shows_is_said_with_and_without_a_key() {
    let place = Place::new();
    let keys = Keys::new(&place);
    let records = place.path().join("records");
    let mut command = rank(&place, &records, Some(&keys.secret));
    let output = command.args(["--instance", "vehicle-7"]).output().unwrap();
    assert!(output.status.success(), "{}", text(&output.stderr));
    let host = std::fs::read_to_string("/proc/sys/kernel/hostname").unwrap();
    let said = passed(&records, &["--key", utf8(&keys.public)]);
    for word in ["1 record is intact", "nothing was changed since", "instance vehicle-7"] {
        assert!(said.contains(word), "{word}: {said}");
    }
    assert!(said.contains(&format!("on {} by build {}", host.trim(), trolley::BUILD)), "{said}");
    assert!(!said.contains("not forgery"), "{said}");
    let document = json(&verify(&records, &["--key", utf8(&keys.public), "--json"]));
    assert_eq!((&document["proof"], &document["records"]), (&"signed".into(), &1.into()));
    assert_eq!(document["signed"]["host"], host.trim());
    let key = document["signed"]["key"].as_str().unwrap();
    assert!(key.starts_with("d75a980182b10ab7"), "{key}");
    // A signature alone shows nothing: whose key it is must be known.
    let said = passed(&records, &[]);
    assert!(said.contains("accidents, not forgery") && said.contains("--key"), "{said}");
    let said = passed(&record(&records, 0), &["--key", utf8(&keys.public)]);
    assert!(said.contains("were not looked at"), "{said}");
    let unsigned = place.path().join("unsigned");
    recorded(&place, &unsigned, None);
    let said = passed(&unsigned, &[]);
    assert!(said.contains("not signed: this shows accidents, not forgery"), "{said}");
    assert!(said.contains("can make the whole chain anew"), "{said}");
    let proof = &json(&verify(&unsigned, &["--json"]))["proof"];
    assert_eq!(proof, "unsigned");
}

#[test]
fn every_forgery_is_found_and_named() {
    let place = Place::new();
    let keys = Keys::new(&place);
    let records = signed(&place, "records", &keys.secret, 4);
    let copy = place.path().join("kept.head");
    std::fs::copy(records.join("chain.head"), &copy).unwrap();
    let good = files(&records);
    let key = ["--key", utf8(&keys.public)];
    passed(&records, &key);
    let other = signed(&place, "other", &keys.secret, 4);
    let forged = signed(&place, "forged", &keys.other_secret, 4);
    let bare = place.path().join("bare");
    recorded(&place, &bare, None);
    let copied = |from: &Path, to: &Path| {
        std::fs::copy(from, to).unwrap();
    };
    let error = found(&records, &["--key", utf8(&keys.other_public)]);
    assert!(error.contains("chain.head: it is signed with the key d75a98"), "{error}");
    type Deed<'d> = (&'d str, &'d [&'d str], Box<dyn Fn() + 'd>);
    let remove = |name: String| std::fs::remove_file(records.join(name)).unwrap();
    let cases: Vec<Deed<'_>> = vec![
        ("removed", &["000002.record", "number 2", "1 should come"], {
            Box::new(|| remove("000001.record".into()))
        }),
        ("cut", &["chain.head states 4, and there are 3", "taken away"], {
            Box::new(|| remove("000003.record".into()))
        }),
        ("emptied", &["chain.head states 4, and there are 0"], {
            Box::new(|| (0..4).for_each(|number| remove(format!("{number:06}.record"))))
        }),
        ("without a head", &["chain.head is missing"], {
            Box::new(|| remove("chain.head".into()))
        }),
        ("swapped", &["000001.record: the record in it is number 2"], {
            Box::new(|| {
                copied(&record(&records, 2), &place.path().join("x"));
                copied(&record(&records, 1), &record(&records, 2));
                copied(&place.path().join("x"), &record(&records, 1));
            })
        }),
        ("renamed", &["000009.record: the record in it is number 3"], {
            Box::new(|| std::fs::rename(record(&records, 3), record(&records, 9)).unwrap())
        }),
        ("given another name", &["copy.record: the record in it is number 1"], {
            Box::new(|| copied(&record(&records, 1), &records.join("copy.record")))
        }),
        ("of another chain", &["000002.record: it belongs to another chain"], {
            Box::new(|| copied(&record(&other, 2), &record(&records, 2)))
        }),
        ("with the head of another chain", &["000000.record: it belongs to another chain"], {
            Box::new(|| copied(&other.join("chain.head"), &records.join("chain.head")))
        }),
        ("by another signer", &["000002.record: it is signed with the key"], {
            Box::new(|| copied(&record(&forged, 2), &record(&records, 2)))
        }),
        ("not signed", &["000000.record: it is not signed"], {
            Box::new(|| copied(&record(&bare, 0), &record(&records, 0)))
        }),
        ("all by another signer", &["chain.head: it is signed with the key"], {
            Box::new(|| {
                files(&forged).iter().for_each(|(path, bytes)| {
                    std::fs::write(records.join(path.file_name().unwrap()), bytes).unwrap();
                });
            })
        }),
    ];
    for (deed, says, tamper) in cases {
        tamper();
        let error = found(&records, &key);
        assert!(says.iter().all(|word| error.contains(word)), "{deed}: {error}");
        put_back(&records, &good);
    }
    // Another chain of the same signer, whole: only a copy of the head shows it.
    passed(&other, &key);
    let kept = ["--key", utf8(&keys.public), "--head", utf8(&copy)];
    passed(&records, &kept);
    let error = found(&other, &kept);
    assert!(error.contains("kept.head: it belongs to another chain"), "{error}");
}

/// Changed bytes in a folder of real records; the crate's own tests change every byte.
#[test]
fn each_changed_byte_of_a_real_chain_is_found_and_its_file_named() {
    let place = Place::new();
    let keys = Keys::new(&place);
    let records = signed(&place, "records", &keys.secret, 2);
    let mut state = 7;
    for (path, good) in files(&records) {
        let name = path.file_name().unwrap().to_str().unwrap().to_owned();
        for _ in 0..100 {
            state = geometry::hash::splitmix64(state);
            let mut bad = good.clone();
            bad[state as usize % good.len()] ^= 1 + (state >> 40) as u8 % 255;
            std::fs::write(&path, &bad).unwrap();
            let error = found(&records, &["--key", utf8(&keys.public)]);
            assert!(error.contains(&name), "{name}: {error}");
        }
        std::fs::write(&path, &good).unwrap();
    }
    passed(&records, &["--key", utf8(&keys.public)]);
}

/// Killed at some time of its run, a writer leaves what passes and what the next one continues.
#[test]
fn a_killed_writer_leaves_no_forgery_and_is_followed_by_the_next() {
    let place = Place::new();
    let keys = Keys::new(&place);
    let records = signed(&place, "records", &keys.secret, 1);
    let key = ["--key", utf8(&keys.public)];
    let (mut killed, mut between) = (0, 0);
    for step in 0..24 {
        let count = json(&verify(&records, &["--json"]))["records"].as_u64().unwrap();
        let mut child = rank(&place, &records, Some(&keys.secret)).spawn().unwrap();
        // At some time of its run, or as soon as its record is there: before the head, mostly.
        match step % 2 {
            0 => drop(wait_for(step * 2, || child.try_wait().unwrap())),
            _ => while !record(&records, count).exists() && child.try_wait().unwrap().is_none() {},
        }
        child.kill().unwrap();
        killed += u32::from(child.wait().unwrap().code().is_none());
        between += u32::from(passed(&records, &key).contains("no sign of forgery"));
    }
    assert!(killed > 5 && between > 2, "{killed} of 24 were killed, {between} before the head");
    // The head of the time before: one behind passes.
    recorded(&place, &records, Some(&keys.secret));
    let before = std::fs::read(records.join("chain.head")).unwrap();
    let count = json(&verify(&records, &["--json"]))["records"].as_u64().unwrap();
    recorded(&place, &records, Some(&keys.secret));
    std::fs::write(records.join("chain.head"), &before).unwrap();
    let said = passed(&records, &key);
    assert!(said.contains(&format!("none of the first {count} is missing; 1 more")), "{said}");
    assert!(said.contains("no sign of forgery"), "{said}");
    recorded(&place, &records, Some(&keys.secret));
    let said = passed(&records, &key);
    assert!(said.contains(&format!("none of the first {} is missing. If", count + 2)), "{said}");
    // Two behind is not what a crash leaves.
    std::fs::write(records.join("chain.head"), &before).unwrap();
    let error = found(&records, &key);
    assert!(error.contains("a crash leaves one more at most"), "{error}");
    let refused = rank(&place, &records, Some(&keys.secret)).output().unwrap();
    assert_eq!(refused.status.code(), Some(65), "{}", text(&refused.stderr));
}

#[test]
fn writers_at_the_same_time_make_one_chain() {
    let place = Place::new();
    let keys = Keys::new(&place);
    let records = place.path().join("records");
    let start = |_| rank(&place, &records, Some(&keys.secret)).spawn().unwrap();
    let running: Vec<_> = (0..6).map(start).collect();
    for child in running {
        let output = child.wait_with_output().unwrap();
        assert!(output.status.success(), "{}", text(&output.stderr));
    }
    let said = passed(&records, &["--key", utf8(&keys.public)]);
    assert!(said.contains("6 records are intact"), "{said}");
}

#[test]
fn a_key_that_cannot_sign_and_a_chain_that_must_not_be_mixed_are_refused_before_the_work() {
    let place = Place::new();
    let keys = Keys::new(&place);
    let records = signed(&place, "records", &keys.secret, 1);
    let bare = place.path().join("bare");
    recorded(&place, &bare, None);
    let exposed = place.path().join("exposed.pem");
    std::fs::copy(&keys.secret, &exposed).unwrap();
    std::fs::set_permissions(&exposed, PermissionsExt::from_mode(0o640)).unwrap();
    let absent = place.path().join("absent.pem");
    let empty = place.path().join("empty.pem");
    std::fs::write(&empty, "").unwrap();
    std::fs::set_permissions(&empty, PermissionsExt::from_mode(0o600)).unwrap();
    std::fs::set_permissions(&keys.public, PermissionsExt::from_mode(0o600)).unwrap();
    let (new, ours) = (place.path().join("new"), Some(keys.secret.as_path()));
    let cases: [(&Path, Option<&Path>, i32, &[&str]); 8] = [
        (&new, Some(&exposed), 78, &["exposed.pem", "0640", "chmod 600"]),
        (&new, Some(&absent), 65, &["absent.pem", "no such file"]),
        (&new, Some(&empty), 78, &["empty.pem", "openssl genpkey -algorithm ed25519"]),
        (&new, Some(&keys.public), 78, &["key.pub", "this is a public key"]),
        (&new, Some(Path::new("/dev/zero")), 65, &["/dev/zero", "device"]),
        (&records, None, 78, &["records", "are signed", "--sign KEY"]),
        (&records, Some(&keys.other_secret), 78, &["records", "is signed with the key"]),
        (&bare, ours, 78, &["bare", "not signed", "name another"]),
    ];
    for (folder, key, code, says) in cases {
        let output = rank(&place, folder, key).output().unwrap();
        let error = text(&output.stderr);
        assert_eq!((output.status.code(), output.stdout.is_empty()), (Some(code), true), "{error}");
        assert!(says.iter().all(|word| error.contains(word)), "{error}");
    }
    assert!(!record(&new, 0).exists() && !record(&records, 1).exists());
    let error = text(&verify(&records, &["--key", utf8(&keys.secret)]).stderr);
    assert!(error.contains("this is a secret key") && error.contains("-pubout"), "{error}");
    let error = text(&verify(&records, &["--key", utf8(&empty)]).stderr);
    assert!(error.contains("empty.pem: this is no public"), "{error}");
}
