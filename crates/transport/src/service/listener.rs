//! A subscriber to rankings and health, which asks nothing.

use super::server::topic;
use super::wire::{self, read_once};
use super::{Address, LISTENERS_MAX, lend_node, place};
use crate::domain;
use crate::error::OpenError;
use crate::ipc::Ipc;
use crate::place::Place;
use core::fmt;
use iceoryx2::node::Node;
use iceoryx2::port::subscriber::{Subscriber, SubscriberCreateError};
use iceoryx2::service::port_factory::publish_subscribe;
use protocol::public::{HEALTH, Health, RANKING, WireAnswer};

/// A listener of both topics.
pub struct TopicSubscriber {
    // Dropped in this order: ports, services, node.
    rankings: Subscriber<Ipc, wire::WireAnswer, ()>,
    health: Subscriber<Ipc, wire::Health, ()>,
    _ranking_topic: publish_subscribe::PortFactory<Ipc, wire::WireAnswer, ()>,
    _health_topic: publish_subscribe::PortFactory<Ipc, wire::Health, ()>,
    _node: Node<Ipc>,
    place: Place,
}

impl TopicSubscriber {
    /// Starts listening.
    ///
    /// # Errors
    ///
    /// [`OpenError::NoService`] if nothing was ever served there; [`OpenError::Full`] if it has the
    /// maximum number of listeners; otherwise if shared memory or file descriptors ran out.
    pub fn open(address: &Address) -> Result<Self, OpenError> {
        let place = address.enter()?;
        let node = domain::node(place.root(), "listener")?;
        lend_node(place.root(), &node)?;
        let ranking = topic::<wire::WireAnswer>(&node, RANKING)?;
        let health = topic::<wire::Health>(&node, HEALTH)?;
        // Once more: it now has tags of the services.
        lend_node(place.root(), &node)?;
        let instance = || address.instance().to_owned();
        let failed = |topic: &'static str| {
            move |error| match error {
                SubscriberCreateError::ExceedsMaxSupportedSubscribers => {
                    OpenError::Full { instance: instance(), most: LISTENERS_MAX, whom: "listeners" }
                }
                other => OpenError::at("listen to", topic)(other),
            }
        };
        let rankings = ranking.subscriber_builder().create();
        let healths = health.subscriber_builder().create();
        Ok(Self {
            rankings: rankings.map_err(failed(RANKING))?,
            health: healths.map_err(failed(HEALTH))?,
            _ranking_topic: ranking,
            _health_topic: health,
            _node: node,
            place,
        })
    }

    /// Whether its server lives. If not, another one is found only by opening a new subscriber.
    #[must_use]
    pub fn is_served(&self) -> bool {
        !place::is_dead(self.place.root())
    }

    /// The next unseen ranking, if any.
    #[must_use]
    pub fn ranking(&self) -> Option<WireAnswer> {
        let sample = self.rankings.receive().ok().flatten()?;
        Some(read_once(&sample.payload().0))
    }

    /// The latest unseen health, if any.
    #[must_use]
    pub fn health(&self) -> Option<Health> {
        let mut latest = None;
        // Bounded: what the buffer holds, and one that came meanwhile.
        for _ in 0..8 {
            let Some(sample) = self.health.receive().ok().flatten() else { break };
            latest = Some(read_once(&sample.payload().0));
        }
        latest
    }
}

impl fmt::Debug for TopicSubscriber {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Listener").finish_non_exhaustive()
    }
}
