//! One server, many clients, each of them free to vanish; what is asked is what arrives.

use super::*;
use crate::error::UseError;
use protocol::public::{Ask, CLIENTS_MAX, Health, Reason, WireAnswer, WireState};
use std::sync::atomic::{AtomicU32, Ordering};

/// A folder of its own, and an instance that no other test has.
struct Scene {
    _folder: tempfile::TempDir,
    address: Address,
}

impl Scene {
    fn new() -> Self {
        static NEXT: AtomicU32 = AtomicU32::new(0);
        let number = NEXT.fetch_add(1, Ordering::Relaxed);
        let instance = format!("u{:x}-{number}", std::process::id() & 0xff_ffff);
        let folder = tempfile::Builder::new().prefix("s").tempdir_in("/dev/shm").unwrap();
        let address = Address::new(Some(folder.path()), &instance).unwrap();
        Self { _folder: folder, address }
    }

    /// All files below the root.
    fn left(&self) -> Vec<String> {
        let mut folders = vec![self.address.root().to_owned()];
        let mut files = Vec::new();
        while let Some(folder) = folders.pop() {
            for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
                files.push(entry.path().display().to_string());
                if entry.file_type().unwrap().is_dir() {
                    folders.push(entry.path());
                }
            }
        }
        files
    }
}

fn numbered(sequence: u64) -> Box<Ask> {
    let mut ask = Ask::new(1.0);
    ask.sequence = sequence;
    ask
}

fn refused(sequence: u64) -> WireAnswer {
    WireAnswer::without_ranking(sequence, WireState::Refused, Reason::Malformed, "no")
}

#[test]
fn what_is_asked_arrives_and_its_answer_comes_back() {
    let scene = Scene::new();
    let server = Server::open(&scene.address).unwrap();
    let client = ClientPort::open(&scene.address).unwrap();
    assert!(client.is_served());
    for sequence in 0..100 {
        let mut ask = numbered(sequence);
        ask.state_count = [1, 7168, 9_000][sequence as usize % 3];
        ask.states[0].position_m = [1.0, f64::NEG_INFINITY, -0.0];
        ask.states[7167].t_s = f64::NAN;
        ask.seal();
        let pending = client.ask(&ask).unwrap();
        assert!(pending.receive().unwrap().is_none());
        assert_eq!(client.ask(&ask).unwrap_err(), UseError::Full, "one at a time");
        let mut asked = server.take().unwrap().unwrap();
        assert!(asked.is_wanted());
        let arrived = asked.take_ask().unwrap();
        assert!(arrived.used() == ask.used() && arrived.is_intact() && asked.take_ask().is_none());
        asked.answer(&refused(sequence)).unwrap();
        assert_eq!(pending.receive().unwrap(), Some(refused(sequence)));
        assert!(server.take().unwrap().is_none());
    }
    drop(client);
    drop(server);
    assert_eq!(scene.left(), Vec::<String>::new());
    assert!(!std::path::Path::new(scene.address.root()).exists());
}

#[test]
fn a_second_server_is_refused_and_the_first_goes_on() {
    let scene = Scene::new();
    let server = Server::open(&scene.address).unwrap();
    let error = Server::open(&scene.address).unwrap_err();
    assert!(matches!(error, OpenError::Taken { .. }), "{error}");
    assert!(error.to_string().contains(&std::process::id().to_string()), "{error}");
    let client = ClientPort::open(&scene.address).unwrap();
    let pending = client.ask(&numbered(1)).unwrap();
    server.take().unwrap().unwrap().answer(&refused(1)).unwrap();
    assert!(pending.receive().unwrap().is_some());
}

#[test]
fn without_a_server_there_is_a_clear_error() {
    let scene = Scene::new();
    let error = ClientPort::open(&scene.address).unwrap_err();
    assert!(matches!(error, OpenError::NoService { .. }), "{error}");
    assert!(matches!(
        TopicSubscriber::open(&scene.address).unwrap_err(),
        OpenError::NoService { .. }
    ));
    assert!(!std::path::Path::new(scene.address.root()).exists(), "asking makes nothing");
}

#[test]
fn sixteen_clients_find_room_and_a_place_that_is_given_up_is_taken_again() {
    let scene = Scene::new();
    let server = Server::open(&scene.address).unwrap();
    let mut clients: Vec<ClientPort> =
        (0..16).map(|_| ClientPort::open(&scene.address).unwrap()).collect();
    assert_eq!(server.clients(), 16);
    let error = ClientPort::open(&scene.address).unwrap_err();
    assert!(matches!(error, OpenError::Full { most: 16, whom: "clients", .. }), "{error}");
    assert_eq!(diagnostic::Diagnostic::kind(&error), diagnostic::FailureKind::TryAgain);
    clients.pop();
    clients.push(ClientPort::open(&scene.address).unwrap());
    let ask =
        |(number, client): (usize, &ClientPort)| client.ask(&numbered(number as u64)).unwrap();
    let pending: Vec<Pending> = clients.iter().enumerate().map(ask).collect();
    for _ in 0..16 {
        let asked = server.take().unwrap().unwrap();
        let sequence = asked.sequence();
        asked.answer(&refused(sequence)).unwrap();
    }
    assert!(server.take().unwrap().is_none());
    for (number, pending) in pending.iter().enumerate() {
        assert_eq!(pending.receive().unwrap().unwrap().sequence, number as u64);
    }
}

#[test]
fn a_client_that_gave_up_is_not_wanted_and_does_no_harm() {
    let scene = Scene::new();
    let server = Server::open(&scene.address).unwrap();
    let client = ClientPort::open(&scene.address).unwrap();
    drop(client.ask(&numbered(1)).unwrap());
    if let Some(asked) = server.take().unwrap() {
        assert!(!asked.is_wanted());
        let _nobody_listens = asked.answer(&refused(1));
    }
    let pending = client.ask(&numbered(2)).unwrap();
    let asked = server.take().unwrap().unwrap();
    drop(client);
    let _nobody_listens = asked.answer(&refused(2));
    drop(pending);
}

#[test]
fn a_client_that_gives_up_again_and_again_is_heard_once_the_server_lets_go() {
    let scene = Scene::new();
    let server = Server::open(&scene.address).unwrap();
    let client = ClientPort::open(&scene.address).unwrap();
    let mut held = Vec::new();
    for sequence in 0..5 {
        drop(client.ask(&numbered(sequence)).unwrap());
        match server.take() {
            Ok(asked) => held.extend(asked),
            Err(error) => {
                assert_eq!(error, UseError::Full);
                held.clear();
            }
        }
    }
    held.retain(TakenRequest::is_wanted);
    assert!(held.is_empty());
    let pending = client.ask(&numbered(9)).unwrap();
    let asked = core::iter::from_fn(|| server.take().unwrap()).last().unwrap();
    asked.answer(&refused(9)).unwrap();
    assert_eq!(pending.receive().unwrap(), Some(refused(9)));
}

/// iceoryx2 has 128 channels that it never gives back: a client that left a request behind must
/// leave nothing else.
#[test]
fn clients_that_ask_and_go_before_they_are_heard_leave_nothing() {
    let scene = Scene::new();
    let server = Server::open(&scene.address).unwrap();
    let kept = scene.left().len();
    for sequence in 0..300 {
        let client = ClientPort::open(&scene.address).unwrap();
        assert!(server.take().unwrap().is_none(), "the server knows it");
        let pending = client.ask(&numbered(sequence)).unwrap();
        drop(client);
        drop(pending);
        assert!(server.take().unwrap().is_none(), "nobody wants it");
        assert!(server.take().unwrap().is_none());
        assert_eq!(scene.left().len(), kept, "after {sequence}");
    }
}

#[test]
fn a_client_sees_that_its_server_has_gone_and_finds_the_next_one() {
    let scene = Scene::new();
    let server = Server::open(&scene.address).unwrap();
    let old = ClientPort::open(&scene.address).unwrap();
    drop(server);
    assert!(!old.is_served());
    let error = ClientPort::open(&scene.address).unwrap_err();
    assert!(matches!(error, OpenError::NoService { .. }), "{error}");
    let server = Server::open(&scene.address).unwrap();
    assert!(!old.is_served(), "its place is another one");
    let client = ClientPort::open(&scene.address).unwrap();
    let pending = client.ask(&numbered(3)).unwrap();
    server.take().unwrap().unwrap().answer(&refused(3)).unwrap();
    assert_eq!(pending.receive().unwrap(), Some(refused(3)));
    // What the old client holds goes with it, at the next look.
    let held = scene.left().len();
    drop(old);
    assert!(server.housekeeper().needs_cleaning().is_none());
    assert!(scene.left().len() < held);
    drop((pending, client, server));
    assert_eq!(scene.left(), Vec::<String>::new());
}

#[test]
fn whoever_listens_hears_the_latest() {
    let scene = Scene::new();
    let server = Server::open(&scene.address).unwrap();
    let health = |pid| Health { pid, ..bytemuck::Zeroable::zeroed() };
    let listener = TopicSubscriber::open(&scene.address).unwrap();
    assert_eq!(listener.health(), None);
    for pid in 7..20 {
        server.publish_health(&health(pid));
    }
    server.publish_ranking(&refused(9));
    assert_eq!(listener.health().map(|health| health.pid), Some(19));
    assert_eq!(listener.ranking(), Some(refused(9)));
    assert_eq!((listener.ranking(), listener.health()), (None, None));
}

#[test]
fn the_seventeenth_listener_is_told_to_try_again() {
    let scene = Scene::new();
    let _server = Server::open(&scene.address).unwrap();
    let mut listeners: Vec<TopicSubscriber> =
        (0..16).map(|_| TopicSubscriber::open(&scene.address).unwrap()).collect();
    let error = TopicSubscriber::open(&scene.address).unwrap_err();
    assert!(matches!(error, OpenError::Full { most: 16, whom: "listeners", .. }), "{error}");
    listeners.pop();
    TopicSubscriber::open(&scene.address).unwrap();
}

#[test]
fn instances_and_folders_that_do_not_fit_are_refused() {
    for name in ["", "A", "a.b", "a/b", "..", "abcdefghijklm"] {
        assert!(Address::new(None, name).is_err(), "{name}");
    }
    let long = "/".to_owned() + &"x".repeat(40);
    assert!(matches!(
        Address::new(Some(Path::new(&long)), "a"),
        Err(OpenError::RootTooLong { .. })
    ));
    assert_eq!(
        Address::new(Some(Path::new("/run/trolley/")), "a").unwrap().root(),
        Path::new("/run/trolley/trolley-a")
    );
}

/// Regression: what did not fit in the server's queue counted as sent, and then as refused.
#[test]
fn a_request_that_finds_no_room_is_not_sent() {
    let scene = Scene::new();
    let server = Server::open(&scene.address).unwrap();
    let client = ClientPort::open(&scene.address).unwrap();
    let refusal = (0..8).find_map(|sequence| client.ask(&numbered(sequence)).map(drop).err());
    assert_eq!(refusal, Some(UseError::Full));
    while server.take().unwrap().is_some() {}
    let pending = client.ask(&numbered(9)).unwrap();
    server.take().unwrap().unwrap().answer(&refused(9)).unwrap();
    assert_eq!(pending.receive().unwrap(), Some(refused(9)));
}

/// What the service computes for a deployment is what there is when everybody is connected, and
/// those before them have gone unnoticed.
// verifies REQ-BOUNDED-RESOURCES
#[test]
fn a_service_shares_what_is_computed_with_every_client_and_listener() {
    use std::os::unix::fs::MetadataExt as _;
    let scene = Scene::new();
    let server = Server::open(&scene.address).unwrap();
    let everybody = || {
        let clients = (0..CLIENTS_MAX).map(|_| ClientPort::open(&scene.address).unwrap());
        let clients: Vec<_> = clients.collect();
        let listeners = (0..LISTENERS_MAX).map(|_| TopicSubscriber::open(&scene.address).unwrap());
        let listeners: Vec<_> = listeners.collect();
        // Only with a request of each are all channels open at both ends.
        let asked = clients.iter().map(|client| client.ask(&numbered(1)).unwrap());
        (asked.collect::<Vec<_>>(), clients, listeners)
    };
    let look = || {
        while server.take().unwrap().is_some() {}
        server.publish_ranking(&refused(0));
        server.publish_health(&bytemuck::Zeroable::zeroed());
    };
    let taken = || {
        let files = scene.left();
        let blocks = |file: &String| std::fs::symlink_metadata(file).map_or(0, |at| at.blocks());
        let endings = [".data", ".connection", ".dynamic", ".event_mgmt", ".global_mgmt"];
        let is_segment = |file: &&String| endings.iter().any(|ending| file.ends_with(ending));
        let bytes = files.iter().map(blocks).sum::<u64>() * 512;
        (files.iter().filter(is_segment).count(), bytes)
    };
    let first = everybody();
    look();
    let connected = taken().0;
    drop(first);
    // Whoever comes and goes while the server does not look leaves nothing more.
    for _ in 0..3 {
        let unseen = everybody();
        let (segments, bytes) = taken();
        let bound = shared_bytes() as u64;
        assert!(bytes <= bound && bound <= bytes + bytes / 4, "{bytes} bytes of {bound}");
        // Channels of killed clients are another test's.
        assert_eq!(segments + DEAD_CHANNELS_MAX, shared_segments());
        drop(unseen);
    }
    let last = everybody();
    look();
    assert_eq!(taken().0, connected);
    drop((last, server));
}
