//! The two channels between the coordinator and one incarnation of a worker.

use crate::channel::{Receiver, Sender, Wire};
use crate::{Domain, OpenError};
use iceoryx2::prelude::{
    AllocationStrategy, AttributeSpecifier, AttributeVerifier, BackpressureStrategy, ServiceName,
    ipc,
};
use iceoryx2::service::attribute::{AttributeKey, AttributeValue};
use iceoryx2::service::builder::publish_subscribe::PublishSubscribeOpenError;
use iceoryx2::service::port_factory::publish_subscribe::PortFactory;
use protocol::Incarnation;

type Service = PortFactory<ipc::Service, [u64], Wire>;

/// How large messages are and how many may wait.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sizes {
    /// Words of a job message.
    pub job_words: usize,
    /// Job messages that may wait.
    pub jobs: usize,
    /// Words of a result message.
    pub result_words: usize,
    /// Result messages that may wait.
    pub results: usize,
}

/// The coordinator's end. It holds the services, so that a dying worker cannot break their names.
#[derive(Debug)]
pub struct CoordinatorLink {
    /// Jobs, to the worker.
    pub jobs: Sender,
    /// Results, from the worker.
    pub results: Receiver,
    _services: [Service; 2],
}

/// The worker's end.
#[derive(Debug)]
pub struct WorkerLink {
    /// Jobs, from the coordinator.
    pub jobs: Receiver,
    /// Results, to the coordinator.
    pub results: Sender,
}

const BUILD: &str = "build";

fn names(who: Incarnation) -> [String; 2] {
    ["job", "result"].map(|what| format!("{what}/{}.{}", who.worker, who.inc))
}

/// Every value is written out: the defaults drop old messages silently and block for ever.
macro_rules! service {
    ($domain:expr, $name:expr, $buffer:expr) => {{
        let name = ServiceName::new($name).map_err(OpenError::shown("name", $name))?;
        $domain
            .node()?
            .service_builder(&name)
            .publish_subscribe::<[u64]>()
            .user_header::<Wire>()
            .max_publishers(1)
            .max_subscribers(1)
            .max_nodes(2)
            .history_size(0)
            .subscriber_max_buffer_size($buffer)
            .subscriber_max_borrowed_samples(1)
            .enable_safe_overflow(false)
    }};
}

fn build_attribute(build: &str) -> Result<(AttributeKey, AttributeValue), OpenError> {
    let key = AttributeKey::try_from(BUILD).map_err(OpenError::shown("name", BUILD))?;
    let value = AttributeValue::try_from(build).map_err(OpenError::shown("name", build))?;
    Ok((key, value))
}

fn create(domain: &Domain, name: &str, buffer: usize, build: &str) -> Result<Service, OpenError> {
    let (key, value) = build_attribute(build)?;
    let attributes = AttributeSpecifier::new()
        .define(&key, &value)
        .map_err(OpenError::shown("describe", name))?;
    service!(domain, name, buffer)
        .create_with_attributes(&attributes)
        .map_err(OpenError::shown("create channel", name))
}

fn open(domain: &Domain, name: &str, buffer: usize, build: &str) -> Result<Service, OpenError> {
    let (key, value) = build_attribute(build)?;
    let attributes = AttributeVerifier::new()
        .require(&key, &value)
        .map_err(OpenError::shown("describe", name))?;
    let opened = service!(domain, name, buffer).open_with_attributes(&attributes);
    opened.map_err(|error| match error {
        PublishSubscribeOpenError::IncompatibleAttributes
        | PublishSubscribeOpenError::IncompatibleTypes => {
            OpenError::Skew { name: name.to_owned(), build: build.to_owned() }
        }
        error => OpenError::shown("open channel", name)(error),
    })
}

fn sender(service: &Service, name: &str, words: usize) -> Result<Sender, OpenError> {
    let port = service
        .publisher_builder()
        .initial_max_slice_len(words)
        .allocation_strategy(AllocationStrategy::Static)
        .max_loaned_samples(1)
        .backpressure_strategy(BackpressureStrategy::DiscardData)
        .create()
        .map_err(OpenError::shown("send on", name))?;
    Ok(Sender::new(port, words))
}

fn receiver(
    service: &Service,
    name: &str,
    domain: &Domain,
    who: Incarnation,
) -> Result<Receiver, OpenError> {
    let port =
        service.subscriber_builder().create().map_err(OpenError::shown("receive on", name))?;
    Ok(Receiver::new(port, domain.boot(), who))
}

impl CoordinatorLink {
    /// Creates both channels of a worker that is about to be started.
    ///
    /// # Errors
    ///
    /// If they exist already, or there is not enough shared memory.
    pub fn create(
        domain: &Domain,
        who: Incarnation,
        sizes: &Sizes,
        build: &str,
    ) -> Result<Self, OpenError> {
        let [job, result] = names(who);
        let jobs = create(domain, &job, sizes.jobs, build)?;
        let results = create(domain, &result, sizes.results, build)?;
        let link = Self {
            jobs: sender(&jobs, &job, sizes.job_words)?,
            results: receiver(&results, &result, domain, who)?,
            _services: [jobs, results],
        };
        domain.commit()?;
        Ok(link)
    }
}

impl WorkerLink {
    /// Opens both channels of this worker.
    ///
    /// # Errors
    ///
    /// If they are not there, or were made by another build.
    pub fn open(
        domain: &Domain,
        who: Incarnation,
        sizes: &Sizes,
        build: &str,
    ) -> Result<Self, OpenError> {
        let [job, result] = names(who);
        let jobs = open(domain, &job, sizes.jobs, build)?;
        let results = open(domain, &result, sizes.results, build)?;
        let link = Self {
            jobs: receiver(&jobs, &job, domain, who)?,
            results: sender(&results, &result, sizes.result_words)?,
        };
        domain.commit()?;
        Ok(link)
    }
}

#[cfg(test)]
pub(crate) mod tests;
