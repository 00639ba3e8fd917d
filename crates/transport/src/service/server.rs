//! The server end of a service.

use super::place::ServicePlace;
use super::wire::{self, read_request};
use super::{Address, Housekeeper, LISTENERS_MAX, NODES_MAX, extent};
use crate::domain;
use crate::error::{OpenError, UseError};
use crate::ipc::Ipc;
use core::fmt;
use iceoryx2::active_request::ActiveRequest;
use iceoryx2::node::Node;
use iceoryx2::port::ReceiveError;
use iceoryx2::port::listener::Listener;
use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::server::Server as Port;
use iceoryx2::prelude::{BackpressureStrategy, FileDescriptorBased, IceoryxSend, ZeroCopySend};
use iceoryx2::service::port_factory::{event, publish_subscribe, request_response};
use protocol::public::{Ask, CLIENTS_MAX, HEALTH, Health, RANK, RANKING, WAKE, WireAnswer};
use std::os::fd::BorrowedFd;

type Service = request_response::PortFactory<Ipc, wire::Ask, (), wire::WireAnswer, ()>;
type Request = ActiveRequest<Ipc, wire::Ask, (), wire::WireAnswer, ()>;

/// Most requests of clients that have gone which are dropped at once: iceoryx2 has room for these.
const GONE_MAX: usize = 128;

/// The one server of a service.
pub struct Server {
    // Dropped in this order: ports, services, node, files.
    port: Port<Ipc, wire::Ask, (), wire::WireAnswer, ()>,
    wake_fd: Listener<Ipc>,
    rankings: Publisher<Ipc, wire::WireAnswer, ()>,
    health: Publisher<Ipc, wire::Health, ()>,
    rank: Service,
    _topics: [Box<dyn core::any::Any>; 3],
    _node: Node<Ipc>,
    place: ServicePlace,
}

impl Server {
    /// Starts serving.
    ///
    /// # Errors
    ///
    /// [`OpenError::Taken`] if another process serves this instance; otherwise if the folder cannot
    /// be written to, or shared memory or file descriptors ran out.
    pub fn open(address: &Address) -> Result<Self, OpenError> {
        let place = ServicePlace::take(address)?;
        let node = domain::node(place.root(), "trolley")?;
        let rank = rank(&node)?;
        let wake = wake(&node)?;
        let ranking = topic::<wire::WireAnswer>(&node, RANKING)?;
        let health = topic::<wire::Health>(&node, HEALTH)?;
        let port = rank
            .server_builder()
            .backpressure_strategy(BackpressureStrategy::DiscardData)
            .max_loaned_responses_per_request(extent::LOANS)
            .create()
            .map_err(OpenError::at("serve", RANK))?;
        let wake_fd = wake.listener_builder().create().map_err(OpenError::at("listen at", WAKE))?;
        let server = Self {
            port,
            wake_fd,
            rankings: publisher(&ranking, RANKING)?,
            health: publisher(&health, HEALTH)?,
            rank,
            _topics: [Box::new(wake), Box::new(ranking), Box::new(health)],
            _node: node,
            place,
        };
        server.place.announce(address.group())?;
        Ok(server)
    }

    /// Takes a request whose client still waits; `None` if there is none. Never waits.
    ///
    /// Requests that are [no longer wanted](TakenRequest::is_wanted) must be dropped first: once a
    /// new client has taken the place of one that has gone, the old one's request may pass for the
    /// new one's.
    ///
    /// # Errors
    ///
    /// [`UseError::Full`] if a client has given up and asked again while too many of its requests
    /// are held here: drop those that are no longer wanted. [`UseError::Broken`] if a client's
    /// channel is corrupt.
    pub fn take(&self) -> Result<Option<TakenRequest>, UseError> {
        for _ in 0..GONE_MAX {
            match self.port.receive() {
                Ok(Some(request)) if request.is_connected() => {
                    // On the heap: a request is larger than a stack likes.
                    let mut ask = bytemuck::allocation::zeroed_box();
                    read_request(request.payload(), &mut ask);
                    let sequence = ask.sequence;
                    return Ok(Some(TakenRequest { request, sequence, ask: Some(ask) }));
                }
                // Its client has gone. Dropping it frees the channel.
                Ok(Some(_)) => {}
                Ok(None) => return Ok(None),
                Err(ReceiveError::ExceedsMaxBorrows) => return Err(UseError::Full),
                Err(ReceiveError::ConnectionFailure(_)) => return Err(UseError::Broken),
            }
        }
        Ok(None)
    }

    /// Publishes an answer to all listeners.
    pub fn publish_ranking(&self, answer: &WireAnswer) {
        if let Err(error) = self.rankings.send_copy(wire::WireAnswer(*answer)) {
            tracing::debug!(?error, "a ranking was not published");
        }
    }

    /// Publishes the health of the service to all listeners.
    pub fn publish_health(&self, health: &Health) {
        if let Err(error) = self.health.send_copy(wire::Health(*health)) {
            tracing::debug!(?error, "health was not published");
        }
    }

    /// Becomes readable when a client rings.
    #[must_use]
    pub fn wake_fd(&self) -> BorrowedFd<'_> {
        // SAFETY: it is not closed here.
        let number = unsafe { self.wake_fd.file_descriptor().native_handle() };
        // SAFETY: the listener owns the descriptor, and lives as long as what is returned.
        unsafe { BorrowedFd::borrow_raw(number) }
    }

    /// Clears all pending rings.
    pub fn drain(&self) {
        if let Err(error) = self.wake_fd.try_wait(|_| {}) {
            tracing::debug!(?error, "the bell cannot be read");
        }
    }

    /// Number of connected clients.
    #[must_use]
    pub fn clients(&self) -> usize {
        use iceoryx2::prelude::PortFactory as _;
        self.rank.dynamic_config().number_of_clients()
    }

    /// Tells, in any thread, what to clean up after dead clients, so that new ones can connect.
    #[must_use]
    pub fn housekeeper(&self) -> Housekeeper {
        let place = self.place.root().to_owned();
        let root = place.parent().unwrap_or(&place).to_owned();
        Housekeeper { root, place }
    }
}

impl fmt::Debug for Server {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Server").field("place", &self.place).finish_non_exhaustive()
    }
}

/// A request that was taken.
pub struct TakenRequest {
    request: Request,
    sequence: u64,
    ask: Option<Box<Ask>>,
}

impl TakenRequest {
    /// The client's number of it.
    #[must_use]
    pub fn sequence(&self) -> u64 {
        self.sequence
    }

    /// What is asked: a private copy, handed over once. Whether it is what was sent, its checksum
    /// says.
    pub fn take_ask(&mut self) -> Option<Box<Ask>> {
        self.ask.take()
    }

    /// Whether its client still waits, as far as known: a killed one is not noticed here.
    #[must_use]
    pub fn is_wanted(&self) -> bool {
        self.request.is_connected()
    }

    /// Answers it.
    ///
    /// # Errors
    ///
    /// [`UseError::Broken`] if the client has gone.
    pub fn answer(self, answer: &WireAnswer) -> Result<(), UseError> {
        match self.request.send_copy(wire::WireAnswer(*answer)) {
            Ok(_) => Ok(()),
            Err(_) => Err(UseError::Broken),
        }
    }
}

impl fmt::Debug for TakenRequest {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Asked").field("sequence", &self.sequence).finish_non_exhaustive()
    }
}

/// The request–response service; the first process creates it.
pub(super) fn rank(node: &Node<Ipc>) -> Result<Service, OpenError> {
    let name = RANK.try_into().map_err(OpenError::at("name", RANK))?;
    node.service_builder(&name)
        .request_response::<wire::Ask, wire::WireAnswer>()
        .max_servers(1)
        .max_clients(CLIENTS_MAX)
        .max_nodes(NODES_MAX)
        .max_active_requests_per_client(extent::ACTIVE)
        .max_loaned_requests(extent::LOANS)
        .max_response_buffer_size(extent::ANSWERS)
        .max_borrowed_responses_per_pending_response(extent::BORROWS)
        .enable_safe_overflow_for_requests(false)
        .enable_safe_overflow_for_responses(false)
        // Fire-and-forget requests are not used here, and are dropped. But without this option
        // iceoryx2 0.10 never returns a request whose client has gone, and keeps its channel
        // forever.
        .enable_fire_and_forget_requests(true)
        .open_or_create()
        .map_err(OpenError::at("open", RANK))
}

/// The event service that wakes the server.
pub(super) fn wake(node: &Node<Ipc>) -> Result<event::PortFactory<Ipc>, OpenError> {
    let name = WAKE.try_into().map_err(OpenError::at("name", WAKE))?;
    node.service_builder(&name)
        .event()
        .max_listeners(1)
        .max_notifiers(CLIENTS_MAX)
        .max_nodes(NODES_MAX)
        .open_or_create()
        .map_err(OpenError::at("open", WAKE))
}

/// A topic of which every listener sees the latest sample.
pub(super) fn topic<T>(
    node: &Node<Ipc>,
    name: &'static str,
) -> Result<publish_subscribe::PortFactory<Ipc, T, ()>, OpenError>
where
    T: fmt::Debug + ZeroCopySend + IceoryxSend,
{
    let service = name.try_into().map_err(OpenError::at("name", name))?;
    node.service_builder(&service)
        .publish_subscribe::<T>()
        .max_publishers(1)
        .max_subscribers(LISTENERS_MAX)
        .max_nodes(NODES_MAX)
        .history_size(0)
        .subscriber_max_buffer_size(extent::SAMPLES)
        .subscriber_max_borrowed_samples(extent::BORROWS)
        // A slow listener misses the oldest samples; the publisher never waits.
        .enable_safe_overflow(true)
        .open_or_create()
        .map_err(OpenError::at("open", name))
}

fn publisher<T>(
    topic: &publish_subscribe::PortFactory<Ipc, T, ()>,
    name: &'static str,
) -> Result<Publisher<Ipc, T, ()>, OpenError>
where
    T: fmt::Debug + ZeroCopySend + IceoryxSend,
{
    topic
        .publisher_builder()
        .max_loaned_samples(extent::LOANS)
        .backpressure_strategy(BackpressureStrategy::DiscardData)
        .create()
        .map_err(OpenError::at("publish", name))
}
