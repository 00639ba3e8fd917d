//! Each client gets the answer to its own request, whichever client held its slot before.

use super::*;
use protocol::public::Ask;
use transport::{Address, ClientPort};

struct Scene {
    _folder: tempfile::TempDir,
    address: Address,
    queue: RequestQueue,
}

impl Scene {
    fn new(number: u32, capacity: usize) -> Self {
        let folder = tempfile::Builder::new().prefix("d").tempdir_in("/dev/shm").unwrap();
        let instance = format!("d{:x}-{number}", std::process::id() & 0xff_ffff);
        let address = Address::new(Some(folder.path()), &instance).unwrap();
        let server = Server::open(&address).unwrap();
        let queue = RequestQueue::new(server, Stats::new().unwrap(), capacity);
        Self { _folder: folder, address, queue }
    }

    fn client(&self) -> ClientPort {
        ClientPort::open(&self.address).unwrap()
    }
}

fn numbered(sequence: u64) -> Box<Ask> {
    let mut ask = Ask::new(1.0);
    ask.sequence = sequence;
    ask
}

fn refused(text: &str) -> WireAnswer {
    WireAnswer::without_ranking(1, WireState::Refused, Reason::Malformed, text).sealed()
}

/// The second client takes the first one's slot in every table of iceoryx2, and both number their
/// requests from the same start.
#[test]
fn nobody_gets_the_answer_of_a_client_that_has_gone() {
    let mut scene = Scene::new(0, 4);
    let first = scene.client();
    let pending = first.ask(&numbered(1)).unwrap();
    scene.queue.drain();
    assert_eq!(scene.queue.next().unwrap().ask.sequence, 1);
    drop((pending, first));

    let second = scene.client();
    let pending = second.ask(&numbered(1)).unwrap();
    scene.queue.drain();
    scene.queue.answer(&refused("to the first"));
    assert_eq!(pending.receive().unwrap(), None);
    assert!(scene.queue.next().is_some(), "its client still waits");
    scene.queue.answer(&refused("to the second"));
    assert_eq!(pending.receive().unwrap(), Some(refused("to the second")));
    assert_eq!(scene.queue.stats.health().withdrawn, 1);
}

#[test]
fn nobody_loses_an_answer_to_one_who_waited_in_its_place() {
    let mut scene = Scene::new(1, 4);
    let busy = scene.client();
    let kept = busy.ask(&numbered(9)).unwrap();
    scene.queue.drain();
    scene.queue.next().unwrap();
    let first = scene.client();
    let pending = first.ask(&numbered(1)).unwrap();
    scene.queue.drain();
    assert_eq!(scene.queue.waiting(), 1);
    drop((pending, first));

    let second = scene.client();
    let pending = second.ask(&numbered(1)).unwrap();
    scene.queue.drain();
    scene.queue.answer(&refused("to the busy one"));
    assert_eq!(kept.receive().unwrap(), Some(refused("to the busy one")));
    assert!(scene.queue.next().is_some());
    scene.queue.answer(&refused("to the second"));
    assert_eq!(pending.receive().unwrap(), Some(refused("to the second")));
    assert!(scene.queue.next().is_none());
}

#[test]
fn beyond_the_queue_the_answer_is_busy() {
    let mut scene = Scene::new(2, 1);
    let clients: Vec<ClientPort> = (0..3).map(|_| scene.client()).collect();
    let ask = |client: &ClientPort| client.ask(&numbered(1)).unwrap();
    let pending: Vec<_> = clients.iter().map(ask).collect();
    scene.queue.drain();
    let verdict = |pending: &transport::Pending| pending.receive().unwrap().map(|a| a.verdict());
    let busy = pending.iter().filter(|pending| verdict(pending) == Some(WireState::Busy)).count();
    assert_eq!((busy, scene.queue.waiting()), (2, 1));
}

/// A client that is told that the service is busy asks again, and is heard in the same turn.
#[test]
fn a_turn_takes_so_many_requests_however_fast_they_come() {
    let mut scene = Scene::new(3, 1);
    let waiting = scene.client();
    let _waits = waiting.ask(&numbered(1)).unwrap();
    scene.queue.drain();
    let eager = scene.client();
    let mut pending = None;
    let mut asked = 0;
    scene.queue.drain_while(|| {
        let is_answered = |pending: &transport::Pending| pending.receive().unwrap().is_some();
        // Without end, as far as a turn can know.
        if asked < 10 * TAKEN_MAX && pending.as_ref().is_none_or(is_answered) {
            asked += 1;
            drop(pending.take());
            pending = Some(eager.ask(&numbered(asked as u64)).unwrap());
        }
    });
    assert_eq!(asked, TAKEN_MAX, "requests in one turn");
}
