//! What `trolley doctor --deployment` computes holds for services that are asked as much as may be.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use crate::support::footprint::{Taken, folder, largest_request};
use crate::support::service::{serve, shipped};
use crate::support::{Place, children, json, text, trolley, wait_for};
use serde_json::Value;
use std::path::Path;
use std::process::Stdio;

const MEMBERS: u32 = 4;

/// Two bodies, a folder of its own, members that are bounded.
fn deployment(place: &Place, folder: &Path) -> String {
    let text = format!(
        "schema = \"trolley.deployment/1\"\ninstance = \"test\"\nfolder = {folder:?}\nmembers = 2\n\
         members_max = {MEMBERS}\nmembers_limit = {MEMBERS}\n[engine]\nworkers = 2\n\
         [realtime]\npriority = 0\nworker_priority = 0\nlock_memory = false\nheap_mib = 16\n\
         [[models]]\nid = 1\nname = \"ego\"\ngenerate = {{ shape = \"sedan\", triangles = 2000 }}\n\
         [[models]]\nid = 2\nname = \"suv\"\ngenerate = {{ shape = \"suv\", triangles = 2000 }}\n"
    );
    place.write("deployment.toml", &text).to_str().unwrap().to_owned()
}

fn computed(file: &str) -> Value {
    let words = ["doctor", "--deployment", file, "--jobs", "0", "--json"];
    let output = trolley().args(words).output().unwrap();
    // Whatever this machine lacks besides.
    json(&output)["deployment"]["footprint"].clone()
}

#[track_caller]
fn assert_within(what: &str, measured: u64, computed: &Value, times: u64) {
    let bound = computed.as_u64().unwrap();
    assert!(measured <= bound, "{what}: {measured}, computed {bound}");
    assert!(bound <= times * measured, "{what}: {measured}, computed {bound}: says nothing");
}

// verifies REQ-BOUNDED-RESOURCES
#[test]
fn a_service_at_its_limits_takes_no_more_than_is_computed_and_not_far_less() {
    let place = Place::new();
    let shared = tempfile::Builder::new().prefix("f").tempdir_in("/dev/shm").unwrap();
    let file = deployment(&place, shared.path());
    let footprint = computed(&file);
    let serving = serve(Path::new(&file), &[]);
    let pid = serving.child.id();
    let alone = folder(shared.path()).0;
    let scenario = place.write("largest.toml", &largest_request(2000, MEMBERS));
    let arguments = |verb: &str| {
        let mut command = trolley();
        command.args([verb, &file]).stdout(Stdio::null()).stderr(Stdio::null());
        command
    };
    let ended = ["--instance", &serving.instance];
    let mut others: Vec<_> = (0..15)
        .map(|_| {
            let mut query = arguments("query");
            query.arg(&scenario).args(ended).args(["--members", "1", "--deadline-ms", "60000"]);
            query.spawn().unwrap()
        })
        .chain((0..16).map(|_| arguments("top").args(ended).spawn().unwrap()))
        .collect();
    let (mut service, mut worker) = (Taken::default(), Taken::default());
    let (mut segments, mut bytes) = (0, 0);
    // Of a client a pool and two connections, of a listener two connections.
    let connected = alone + 15 * 3 + 16 * 2;
    let mut look = || {
        service.look(pid);
        children(pid).iter().for_each(|pid| worker.look(*pid));
        let found = folder(shared.path());
        (segments, bytes) = (segments.max(found.0), bytes.max(found.1));
        segments
    };
    // All but one client, which asks now. Some may have had their answers by then.
    wait_for(3_000, || (look() + 5 >= connected).then_some(()));
    // Complete, degraded at its deadline, or one too many on a busy machine: each takes memory.
    let output = serving.query(&scenario, &["--json"]);
    let code = output.status.code();
    assert!(matches!(code, Some(0 | 3 | 75)), "{code:?}: {}", text(&output.stdout));
    look();
    for other in &mut others {
        let _ended = other.kill();
        let _reaped = other.wait();
    }
    serving.end();

    let [of_service, of_worker] = [0, 1].map(|process| &footprint["processes"][process]);
    assert_within("segments", segments, &footprint["segments"], 4);
    assert!(bytes <= footprint["folder_bytes"].as_u64().unwrap());
    assert_within("descriptors", service.descriptors, &of_service["descriptors"], 3);
    assert_within("threads", service.threads, &of_service["threads"], 100);
    assert_within("memory", service.own_bytes, &of_service["own_bytes"], 4);
    assert_within("program", service.program_bytes, &of_service["program_bytes"], 10);
    assert_within("descriptors", worker.descriptors, &of_worker["descriptors"], 2);
    assert_within("threads", worker.threads, &of_worker["threads"], 1);
    assert_within("memory", worker.own_bytes, &of_worker["own_bytes"], 8);
}

/// What `cargo x bounds` wrote of the deployments that ship is what is computed now: limits that
/// change are measured anew.
#[test]
fn the_page_says_what_is_computed() {
    let page = std::fs::read_to_string(shipped("tools/results/bounds.md")).unwrap();
    for name in ["minimal", "dual-core", "quad-core"] {
        let file = shipped(&format!("config/deployments/{name}.toml"));
        let footprint = computed(file.to_str().unwrap());
        let descriptors = &footprint["processes"][0]["descriptors"];
        let numbers = ["request_bytes", "folder_bytes", "unnamed_bytes", "segments"];
        let numbers: Vec<String> = numbers.map(|key| footprint[key].to_string()).into();
        let row = format!("| {name} | {descriptors} | {} |", numbers.join(" | "));
        assert!(page.contains(&row), "tools/results/bounds.md lacks {row}\n  cargo x bounds");
    }
}

// verifies REQ-BOUNDED-RESOURCES
#[test]
fn more_members_than_the_deployment_allows_are_refused() {
    let place = Place::new();
    let shared = tempfile::Builder::new().prefix("f").tempdir_in("/dev/shm").unwrap();
    let serving = serve(Path::new(&deployment(&place, shared.path())), &[]);
    let scenario = place.write("largest.toml", &largest_request(2000, MEMBERS + 1));
    let refused = serving.query(&scenario, &[]);
    assert_eq!(refused.status.code(), Some(4));
    let said = text(&refused.stderr);
    assert!(said.contains("this service follows 4 at most"), "{said}");
    serving.end();
}
