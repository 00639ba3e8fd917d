//! The client end of a service.

use super::server::{rank, wake};
use super::wire::{self, read_once, write_used};
use super::{Address, extent, lend_node, place};
use crate::domain;
use crate::error::{OpenError, UseError};
use crate::ipc::Ipc;
use crate::place::Place;
use core::fmt;
use iceoryx2::node::Node;
use iceoryx2::pending_response::PendingResponse;
use iceoryx2::port::client::{Client as Port, RequestSendError};
use iceoryx2::port::notifier::{Notifier, NotifierCreateError};
use iceoryx2::port::{LoanError, SendError};
use iceoryx2::prelude::{BackpressureStrategy, PortFactory as _};
use iceoryx2::service::port_factory::client::ClientCreateError;
use iceoryx2::service::port_factory::{event, request_response};
use protocol::public::{Ask, CLIENTS_MAX, RANK, WAKE, WireAnswer};

/// One client of a service. It belongs to one thread, and asks one thing at a time.
pub struct ClientPort {
    // Dropped in this order: ports, services, node.
    port: Port<Ipc, wire::Ask, (), wire::WireAnswer, ()>,
    notifier: Notifier<Ipc>,
    rank: request_response::PortFactory<Ipc, wire::Ask, (), wire::WireAnswer, ()>,
    _wake: event::PortFactory<Ipc>,
    _node: Node<Ipc>,
    place: Place,
}

impl ClientPort {
    /// Connects to the server that runs.
    ///
    /// # Errors
    ///
    /// [`OpenError::NoService`] if none does; [`OpenError::Full`] if it has the maximum number of
    /// clients; otherwise if shared memory or file descriptors ran out.
    pub fn open(address: &Address) -> Result<Self, OpenError> {
        let place = address.enter()?;
        let node = domain::node(place.root(), "client")?;
        lend_node(place.root(), &node)?;
        let instance = || address.instance().to_owned();
        let full = || OpenError::Full { instance: instance(), most: CLIENTS_MAX, whom: "clients" };
        let rank = rank(&node)?;
        let wake = wake(&node)?;
        // Once more: it now has tags of the services.
        lend_node(place.root(), &node)?;
        let port = rank
            .client_builder()
            .backpressure_strategy(BackpressureStrategy::DiscardData)
            .max_active_requests(extent::ASKED)
            .create()
            .map_err(|error| match error {
                ClientCreateError::ExceedsMaxSupportedClients => full(),
                other => OpenError::at("ask at", RANK)(other),
            })?;
        let notifier = wake.notifier_builder().create().map_err(|error| match error {
            NotifierCreateError::ExceedsMaxSupportedNotifiers => full(),
            other => OpenError::at("ring at", WAKE)(other),
        })?;
        Ok(Self { port, notifier, rank, _wake: wake, _node: node, place })
    }

    /// Whether its server lives. If not, another one is found only by opening a new port.
    #[must_use]
    pub fn is_served(&self) -> bool {
        self.rank.dynamic_config().number_of_servers() > 0 && !place::is_dead(self.place.root())
    }

    /// Sends the bytes of a request that count, and wakes the server if it sleeps.
    ///
    /// # Errors
    ///
    /// [`UseError::Full`] if another request is open, or the server takes no more;
    /// [`UseError::Broken`] if its channel is corrupt.
    pub fn ask(&self, ask: &Ask) -> Result<Pending, UseError> {
        let full = |error| match error {
            RequestSendError::ExceedsMaxActiveRequests
            | RequestSendError::SendError(
                SendError::UnableToDeliver
                | SendError::LoanError(LoanError::ExceedsMaxLoans | LoanError::OutOfMemory),
            ) => UseError::Full,
            RequestSendError::SendError(_) => UseError::Broken,
        };
        let lent = |error| full(RequestSendError::SendError(SendError::LoanError(error)));
        let mut request = self.port.loan_uninit().map_err(lent)?;
        write_used(request.payload_mut(), ask);
        // SAFETY: the bytes that count were written; the others are those of a mapped file, so they
        // have values, and every one is a valid one.
        let request = unsafe { request.assume_init() };
        let pending = request.send().map_err(full)?;
        // Its queue is full, of requests that were given up and that it has not seen yet.
        if pending.number_of_server_connections() == 0 {
            return Err(UseError::Full);
        }
        if let Err(error) = self.notifier.notify() {
            // The server also polls, a little later.
            tracing::debug!(?error, "cannot wake the server");
        }
        Ok(Pending(pending))
    }
}

impl fmt::Debug for ClientPort {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Client").field("is_served", &self.is_served()).finish_non_exhaustive()
    }
}

/// A request that was sent. Dropping it withdraws the request.
#[must_use = "a dropped request is withdrawn"]
pub struct Pending(PendingResponse<Ipc, wire::Ask, (), wire::WireAnswer, ()>);

impl Pending {
    /// The answer; `None` if it has not come yet. Never waits.
    ///
    /// # Errors
    ///
    /// [`UseError::Broken`] if the channel is corrupt.
    pub fn receive(&self) -> Result<Option<WireAnswer>, UseError> {
        match self.0.receive() {
            Ok(Some(response)) => Ok(Some(read_once(&response.payload().0))),
            Ok(None) => Ok(None),
            Err(_) => Err(UseError::Broken),
        }
    }
}

impl fmt::Debug for Pending {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Pending").finish_non_exhaustive()
    }
}
