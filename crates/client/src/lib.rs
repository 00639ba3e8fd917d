//! The planner's client: connects to a service, asks with a deadline, gets an answer or a refusal.
//!
//! ```no_run
//! use trolley_client::{Client, Waiting};
//! use trolley_client::public::{Ask, WireParty, WirePath, WirePathKind, WirePathState};
//! use std::time::Duration;
//!
//! let mut client = Client::connect(None, "trolley", Waiting::Spin)?;
//! let mut ask = Ask::new(5.0);
//! ask.ego = ask.add_party(WireParty::of_model(1)).ok_or("too many parties")?;
//! let ahead = WirePathState::at(0.0, [30.0, 0.0], 90.0);
//! let stands = WirePath::of_kind(WirePathKind::Place);
//! ask.add_party_on(WireParty::of_model(2), stands, &[ahead]).ok_or("too many parties")?;
//! let now = WirePathState::at(0.0, [0.0, 0.0], 0.0).with_velocity([10.0, 0.0]);
//! let goes_on = WirePath::of_kind(WirePathKind::Onward);
//! let path = ask.add_path(goes_on, &[now]).ok_or("too many paths")?;
//! ask.add_candidate(path, &[]).ok_or("too many candidates")?;
//! let answer = client.ask(&ask, Duration::from_millis(50));
//! for place in answer.ranking() {
//!     println!("{} {:?}, {} contacts", place.candidate, place.work, place.contact_count);
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! A planner that knows how well it knows things states that, and asks for expected harm:
//!
//! ```
//! use trolley_client::public::{Ask, PartyErrors, WireAnswer, WireParty};
//!
//! let known = PartyErrors { lateral_m: Some(0.3), yaw_deg: Some(1.0), ..PartyErrors::default() };
//! let party = WireParty::of_model(2).with_errors(&known); // all others are the usual ones
//! let mut ask = Ask::new(5.0);
//! ask.set_members(32, 128);
//!
//! fn show(answer: &WireAnswer) {
//!     for place in answer.ranking() {
//!         let Some(of) = place.expected() else { continue }; // nothing was drawn
//!         println!("{} {:?} ± {}, best in {}", place.candidate, place.work, of.error, of.best);
//!     }
//!     println!("lead and its error: {:?}, late: {}", answer.lead(), answer.is_late());
//! }
//! # assert_eq!((party.errors(), ask.members), (known, 32));
//! ```
//!
//! # Invariants
//!
//! - [`Client::ask`] returns by its deadline, whatever happens to the service: a missing answer is
//!   replaced by a refusal, [`Reason::Silence`] or [`Reason::NoService`].
//! - An answer belongs to its request: it carries a number that no other client chooses.
//! - No bit of a request or an answer changes on the way unseen: both carry a checksum, which the
//!   service and this library check on copies of their own. What was changed becomes a refusal,
//!   [`Reason::Corrupt`], at once: a refusal for that belongs to whatever request waits, as nobody
//!   knows the number of a request that was changed.
//! - The client reconnects to a restarted service by itself: `tests/processes/serve.rs` at the top
//!   level.
//!
//! To monitor a service without asking, use a [`Listener`].
//!
//! The crate knows the public structs and the transport, but nothing of bodies, harm or policies.

use core::fmt;
use core::hash::{BuildHasher as _, Hasher as _};
use core::time::Duration;
use protocol::public::{Ask, Health, Reason, WireAnswer, WireState};
use rustix::time::{ClockId, Timespec, clock_gettime};
use std::hash::RandomState;
use std::path::Path;
use transport::{Address, ClientPort as Port, UseError};

pub use protocol::public;
pub use transport::OpenError;

/// How a client waits for its answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Waiting {
    /// Poll continuously, yielding to other threads: an answer is seen at once.
    Spin,
    /// Poll, and sleep this long in between: an answer is seen up to that much later (plus the
    /// kernel's timer slack of 50 µs), and the core is free meanwhile.
    Nap(Duration),
}

/// How often a waiting client looks whether the service still lives (ns).
const LOOK_NS: u64 = 1_000_000;

/// A client of a service. It belongs to one thread.
pub struct Client {
    address: Address,
    waiting: Waiting,
    /// `None` after a failed attempt to reopen.
    port: Option<Port>,
    sequence: u64,
    /// The last request, as it was sent.
    sent: Box<Ask>,
}

impl Client {
    /// Connects to the service of this instance in this folder (`None` if the deployment file names
    /// none).
    ///
    /// # Errors
    ///
    /// If there is no such service, shared memory or file descriptors ran out, or it has sixteen
    /// clients already ([`OpenError::Full`]: try again later).
    pub fn connect(
        folder: Option<&Path>,
        instance: &str,
        waiting: Waiting,
    ) -> Result<Self, OpenError> {
        let address = Address::new(folder, instance)?;
        let port = Some(Port::open(&address)?);
        // Random, so that no two clients use the same numbers: an answer to a killed client is then
        // not taken for one to its successor.
        let sequence = RandomState::new().build_hasher().finish();
        Ok(Self { address, waiting, port, sequence, sent: Ask::new(0.0) })
    }

    /// Sends a request, and waits for the answer, at most for `patience`. The client sets sequence
    /// number, deadline and checksum: those of `ask` are ignored.
    ///
    /// Always returns an answer; without a ranking its verdict is *refused* or *busy*.
    #[must_use]
    pub fn ask(&mut self, ask: &Ask, patience: Duration) -> WireAnswer {
        let end_ns = now_ns().saturating_add(nanoseconds(patience));
        self.sequence = self.sequence.wrapping_add(1);
        if self.sent.fill(ask.used()).is_none() {
            let text = "the counts of the request changed while it was read";
            return answer(self.sequence, WireState::Refused, Reason::Malformed, text);
        }
        (self.sent.sequence, self.sent.answer_by_ns) = (self.sequence, end_ns);
        self.sent.seal();
        self.exchange(end_ns)
    }

    fn exchange(&mut self, end_ns: u64) -> WireAnswer {
        let sequence = self.sequence;
        let refused =
            |reason: Reason, text: &str| answer(sequence, WireState::Refused, reason, text);
        let busy = |text: &str| answer(sequence, WireState::Busy, Reason::QueueFull, text);
        // A restarted service has another place.
        self.port.take_if(|port| !port.is_served());
        if self.port.is_none() {
            match Port::open(&self.address) {
                Ok(port) => self.port = Some(port),
                // Others took the places while there was no service to connect to.
                Err(error @ OpenError::Full { .. }) => return busy(&error.to_string()),
                Err(error) => return refused(Reason::NoService, &error.to_string()),
            }
        }
        let Some(port) = &self.port else { return refused(Reason::NoService, "not connected") };
        if !port.is_served() {
            return refused(Reason::NoService, "the service is not running");
        }
        let pending = match port.ask(&self.sent) {
            Ok(pending) => pending,
            Err(UseError::Full) => {
                return busy("the service accepts no more requests at the moment");
            }
            Err(error) => return refused(Reason::NoService, &error.to_string()),
        };
        self.await_answer(sequence, end_ns, || pending.receive(), || port.is_served())
    }

    /// The answer with this number that comes until then, or a refusal.
    fn await_answer(
        &self,
        sequence: u64,
        end_ns: u64,
        receive: impl Fn() -> Result<Option<WireAnswer>, UseError>,
        is_served: impl Fn() -> bool,
    ) -> WireAnswer {
        let refused =
            |reason: Reason, text: &str| answer(sequence, WireState::Refused, reason, text);
        let mut looked_ns = now_ns();
        loop {
            match receive() {
                Ok(Some(answer)) if !answer.is_intact() => {
                    return refused(Reason::Corrupt, "the answer was changed on its way");
                }
                Ok(Some(answer)) if answer.sequence == sequence => return answer,
                // It may have been the number that was changed, so no other answer would come.
                Ok(Some(answer)) if answer.reason() == Reason::Corrupt => {
                    return refused(Reason::Corrupt, answer.text());
                }
                // None, or one to an earlier request that was withdrawn: however many come, the
                // deadline holds.
                Ok(Some(_) | None) => {}
                Err(error) => return refused(Reason::NoService, &error.to_string()),
            }
            let now_ns = now_ns();
            if now_ns >= end_ns {
                return refused(Reason::Silence, "no answer arrived in time");
            }
            let looks = now_ns - looked_ns > LOOK_NS;
            if looks {
                looked_ns = now_ns;
            }
            if looks && !is_served() {
                return refused(Reason::NoService, "the service ended during the request");
            }
            self.wait(end_ns - now_ns);
        }
    }

    fn wait(&self, left_ns: u64) {
        match self.waiting {
            Waiting::Spin => rustix::thread::sched_yield(),
            Waiting::Nap(long) => nap(long.min(Duration::from_nanos(left_ns))),
        }
    }
}

/// An answer that this library gives itself.
fn answer(sequence: u64, verdict: WireState, reason: Reason, text: &str) -> WireAnswer {
    WireAnswer::without_ranking(sequence, verdict, reason, text).sealed()
}

impl fmt::Debug for Client {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Client").field("address", &self.address).finish_non_exhaustive()
    }
}

/// Receives the health that a service publishes each second; sends no requests.
#[derive(Debug)]
pub struct Listener(transport::TopicSubscriber);

/// Polling interval of a listener.
const LOOK: Duration = Duration::from_millis(50);

impl Listener {
    /// Listens to the service of this instance in this folder, as [`Client::connect`] finds it.
    ///
    /// # Errors
    ///
    /// If there is no such service, it has as many listeners as it takes, or shared memory or file
    /// descriptors ran out.
    pub fn connect(folder: Option<&Path>, instance: &str) -> Result<Self, OpenError> {
        Ok(Self(transport::TopicSubscriber::open(&Address::new(folder, instance)?)?))
    }

    /// Waits for the next health message, at most for this long; `None` if there is none.
    #[must_use]
    pub fn health(&self, patience: Duration) -> Option<Health> {
        let end_ns = now_ns().saturating_add(nanoseconds(patience));
        while now_ns() < end_ns {
            if let Some(health) = self.0.health() {
                return Some(health);
            }
            nap(LOOK);
        }
        None
    }
}

/// Sleeps; a signal ends the sleep early.
fn nap(duration: Duration) {
    let ns = nanoseconds(duration);
    let nap =
        Timespec { tv_sec: (ns / 1_000_000_000) as i64, tv_nsec: (ns % 1_000_000_000) as i64 };
    let _early = rustix::thread::nanosleep(&nap);
}

fn nanoseconds(duration: Duration) -> u64 {
    u64::try_from(duration.as_nanos()).unwrap_or(u64::MAX)
}

/// CLOCK_MONOTONIC (ns): the clock of deadlines.
fn now_ns() -> u64 {
    let now = clock_gettime(ClockId::Monotonic);
    now.tv_sec.unsigned_abs() * 1_000_000_000 + now.tv_nsec.unsigned_abs()
}

#[cfg(test)]
mod tests {
    //! What a client gets while answers to others come without end.
    use super::*;

    const MS: u64 = 1_000_000;

    fn client(waiting: Waiting) -> Client {
        let address = Address::new(None, "client").unwrap();
        Client { address, waiting, port: None, sequence: 0, sent: Ask::new(0.0) }
    }

    fn answer_to(sequence: u64) -> WireAnswer {
        answer(sequence, WireState::Refused, Reason::Malformed, "no")
    }

    #[test]
    fn an_answer_that_was_changed_on_its_way_is_refused() {
        let mut changed = answer_to(7);
        changed.places[3].work[1] = 0.25;
        let end_ns = now_ns() + 20_000 * MS;
        let given = client(Waiting::Spin).await_answer(7, end_ns, || Ok(Some(changed)), || true);
        assert_eq!((given.verdict(), given.reason()), (WireState::Refused, Reason::Corrupt));
        assert!(given.is_intact() && given.ranking().is_empty());
    }

    #[test]
    fn a_request_whose_number_was_changed_on_its_way_is_refused_at_once() {
        let changed = answer(6, WireState::Refused, Reason::Corrupt, "the request was changed");
        let end_ns = now_ns() + 20_000 * MS;
        let given = client(Waiting::Spin).await_answer(7, end_ns, || Ok(Some(changed)), || true);
        assert_eq!((given.sequence, given.reason()), (7, Reason::Corrupt));
        assert_eq!(given.text(), "the request was changed");
        assert!(now_ns() < end_ns && given.is_intact());
    }

    #[test]
    fn answers_to_earlier_requests_without_end_do_not_outlast_the_deadline() {
        for waiting in [Waiting::Spin, Waiting::Nap(Duration::from_millis(1))] {
            let begun_ns = now_ns();
            let age_ns = || now_ns() - begun_ns;
            let old = || Ok((age_ns() < 5_000 * MS).then(|| answer_to(6)));
            let answer = client(waiting).await_answer(7, begun_ns + 100 * MS, old, || true);
            let took_ms = age_ns() / MS;
            assert_eq!((answer.sequence, answer.reason()), (7, Reason::Silence));
            assert!((100..4_000).contains(&took_ms), "{took_ms} ms");
        }
    }

    #[test]
    fn answers_to_earlier_requests_hide_neither_the_right_one_nor_the_end_of_the_service() {
        let client = client(Waiting::Spin);
        let (end_ns, left) = (now_ns() + 20_000 * MS, core::cell::Cell::new(100));
        let receive = || {
            left.set(left.get() - 1);
            Ok(Some(answer_to(if left.get() == 0 { 7 } else { 6 })))
        };
        assert_eq!(client.await_answer(7, end_ns, receive, || true), answer_to(7));
        let gone = client.await_answer(7, end_ns, || Ok(Some(answer_to(6))), || false);
        assert_eq!(gone.reason(), Reason::NoService);
    }
}
