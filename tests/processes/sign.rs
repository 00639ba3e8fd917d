//! The decisions that a real service signs.

use crate::serve::{WALL, connect, into_a_wall};
use crate::support::keys::Keys;
use crate::support::service::{Serving, deployment, serve, serve_as};
use crate::support::{self, Place, json, patience, text, trolley};
use client::public::WireState;
use std::path::Path;

/// Signed, killed and started again, a service leaves one chain, which is checked with the key.
#[test]
fn decisions_are_signed_with_time_host_and_deployment_and_survive_a_kill() {
    let place = Place::new();
    let keys = Keys::new(&place);
    let file = deployment(&place, 1, WALL);
    let plain = std::fs::read_to_string(&file).unwrap();
    let key = keys.secret.to_str().unwrap();
    let args = ["serve", file.to_str().unwrap(), "--sign", key, "--instance", "unsigned"];
    let refused = trolley().args(args).output().unwrap();
    let error = text(&refused.stderr);
    assert_eq!(refused.status.code(), Some(78), "{error}");
    assert!(error.contains("keeps no decisions") && error.contains("[decisions]"), "{error}");
    let kept = plain
        .replace("[engine]", "[decisions]\nfolder = \"kept\"\nper_file = 4\nfiles = 100\n[engine]");
    std::fs::write(&file, &kept).unwrap();
    let folder = place.path().join("kept");
    let verify = |key: &Path| {
        let (folder, key) = (folder.to_str().unwrap(), key.to_str().unwrap());
        trolley().args(["record", "verify", folder, "--key", key, "--json"]).output().unwrap()
    };
    let ask = |serving: &Serving, count: u64| {
        let mut client = connect(&serving.instance);
        for _ in 0..count {
            assert_eq!(client.ask(&into_a_wall(), patience()).verdict(), WireState::Complete);
        }
    };
    let serving = serve(&file, &["--sign", key]);
    let instance = serving.instance.clone();
    ask(&serving, 6);
    serving.end();
    let found = json(&verify(&keys.public));
    let (of, records, proof) = (&found["of"], &found["records"], &found["proof"]);
    assert_eq!((of, records, proof), (&"decision".into(), &6.into(), &"signed".into()));
    let signed = &found["signed"];
    assert_eq!(signed["deployment"], instance.as_str());
    let hash = blake3::hash(kept.as_bytes()).to_hex().to_string();
    assert_eq!(signed["deployment_hash"], hash.as_str());
    let host = std::fs::read_to_string("/proc/sys/kernel/hostname").unwrap();
    assert_eq!(signed["build"], trolley::BUILD);
    assert_eq!(signed["host"], host.trim());
    assert!(found["shows"].as_str().unwrap().contains("none of the first 6 is missing. If"));
    // Killed at some time, it leaves decisions after the head, or half a one; the next goes on.
    let mut serving = serve(&file, &["--sign", key]);
    ask(&serving, 3);
    serving.child.kill().unwrap();
    serving.child.wait().unwrap();
    let killed = json(&verify(&keys.public));
    let count = killed["records"].as_u64().unwrap();
    assert!((6..=9).contains(&count) && killed["proof"] == "signed", "{killed}");
    // The same instance, which removes what the killed one left.
    let serving = serve_as(&file, &serving.instance, &["--sign", key]);
    ask(&serving, 1);
    serving.end();
    let found = json(&verify(&keys.public));
    assert_eq!(found["records"], count + 1, "{found}");
    // Another key, or none: found by the check, and refused by the service.
    let error = text(&verify(&keys.other_public).stderr);
    assert!(error.contains("decisions.head: it is signed with the key d75a98"), "{error}");
    for (extra, says) in [
        (&[][..], "add --sign KEY"),
        (&["--sign", keys.other_secret.to_str().unwrap()][..], "sign with the key of this chain"),
    ] {
        let args = ["serve", file.to_str().unwrap(), "--instance", &support::instance()];
        let refused = trolley().args(args).args(extra).output().unwrap();
        let error = text(&refused.stderr);
        assert_eq!(refused.status.code(), Some(78), "{error}");
        assert!(error.contains(says) && error.contains("kept"), "{error}");
    }
    // A decision of the middle, changed.
    let path = folder.join("decisions-00000000.bin");
    let mut bytes = std::fs::read(&path).unwrap();
    let at = bytes.len() / 2;
    bytes[at] ^= 4;
    std::fs::write(&path, bytes).unwrap();
    let error = text(&verify(&keys.public).stderr);
    assert!(error.contains("decisions-00000000.bin: decision 1 of this file was"), "{error}");
}
