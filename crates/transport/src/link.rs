//! The two channels between the coordinator and one incarnation of one worker.
//!
//! The coordinator creates and holds both services before it starts the worker; the worker only
//! opens them. So a worker that is killed during start-up breaks nothing, and its successor gets
//! services with new names and no messages of the dead worker.

use crate::domain::{self, Domain};
use crate::error::OpenError;
use crate::ipc::Ipc;
use crate::receiver::Receiver;
use crate::sender::Sender;
use crate::wire::{Input, Output, Service, Wire};
use iceoryx2::node::Node;
use iceoryx2::prelude::{
    AllocationStrategy, AttributeSpecifier, AttributeVerifier, BackpressureStrategy,
    MessagingPattern, ServiceName,
};
use iceoryx2::service::Service as _;
use iceoryx2::service::attribute::{AttributeKey, AttributeValue};
use iceoryx2::service::builder::publish_subscribe::{Builder, PublishSubscribeOpenError};
use protocol::Incarnation;
use std::fs::{self, DirBuilder};
use std::os::unix::fs::DirBuilderExt as _;
use std::path::PathBuf;

/// How much a link can hold; both ends must be given the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sizes {
    /// Maximum number of words of a job message.
    pub job_words: usize,
    /// Maximum number of waiting job messages.
    pub job_queue: usize,
    /// Maximum number of words of a result message.
    pub result_words: usize,
    /// Maximum number of waiting result messages.
    pub result_queue: usize,
}

impl Sizes {
    /// Bytes of shared memory that the chunks of one link take, within some kilobytes.
    ///
    /// A pool has a chunk for each waiting message, one being read, and one being written.
    #[must_use]
    pub fn pool_bytes(&self) -> usize {
        let pool = |words: usize, queue: usize| {
            (queue + 2).saturating_mul(words.saturating_mul(8).saturating_add(192))
        };
        pool(self.job_words, self.job_queue)
            .saturating_add(pool(self.result_words, self.result_queue))
    }
}

/// The coordinator's end.
#[derive(Debug)]
pub struct CoordinatorLink {
    /// To the worker.
    pub jobs: Sender,
    /// From the worker.
    pub results: Receiver,
    /// Held, so that the worker's death does not remove them, and dropped after the ports.
    _services: [Service; 2],
    _node: Node<Ipc>,
    names: [String; 2],
    #[cfg_attr(not(test), expect(dead_code, reason = "removed when it is dropped"))]
    root: LinkRoot,
}

/// iceoryx2's root for one incarnation, removed when the coordinator is done with it.
#[derive(Debug)]
struct LinkRoot {
    path: PathBuf,
    _domain: Domain,
}

impl LinkRoot {
    fn create(domain: &Domain, peer: Incarnation) -> Result<Self, OpenError> {
        let path = domain.root_of(peer);
        let shown = path.display().to_string();
        DirBuilder::new().mode(0o700).create(&path).map_err(OpenError::at("create", &shown))?;
        Ok(Self { path, _domain: domain.clone() })
    }
}

impl Drop for LinkRoot {
    fn drop(&mut self) {
        if let Err(error) = fs::remove_dir_all(&self.path) {
            // A worker that lives a moment longer made something there.
            tracing::debug!(path = %self.path.display(), %error, "stays until the domain ends");
        }
    }
}

impl CoordinatorLink {
    /// Creates both services and this end of the channels.
    ///
    /// `build` names the program; a worker with another one is refused.
    ///
    /// # Errors
    ///
    /// If there is such a link already, or file descriptors or shared memory ran out.
    pub fn create(
        domain: &Domain,
        peer: Incarnation,
        sizes: &Sizes,
        build: &str,
    ) -> Result<Self, OpenError> {
        let names = names(peer);
        let [job, result] = &names;
        // Made first, so that a failure below removes it.
        let root = LinkRoot::create(domain, peer)?;
        let node = domain::node(&root.path, "coordinator")?;
        let jobs = create(&node, job, sizes.job_queue, build)?;
        let results = create(&node, result, sizes.result_queue, build)?;
        Ok(Self {
            jobs: Sender::new(output(&jobs, job, sizes.job_words)?, sizes.job_words),
            results: Receiver::new(input(&results, result)?, domain.boot(), peer),
            _services: [jobs, results],
            _node: node,
            names,
            root,
        })
    }

    /// iceoryx2's root.
    #[cfg(test)]
    fn root(&self) -> &std::path::Path {
        &self.root.path
    }

    /// Connects to the ports that the worker has opened, so that this does not happen inside a
    /// request. Call it once the worker has greeted.
    ///
    /// # Errors
    ///
    /// If shared memory ran out, or the worker's ports are invalid.
    pub fn connect(&self) -> Result<(), OpenError> {
        let [job, result] = &self.names;
        self.jobs.connect(job)?;
        self.results.connect(result)
    }
}

/// The worker's end.
#[derive(Debug)]
pub struct WorkerLink {
    /// From the coordinator.
    pub jobs: Receiver,
    /// To the coordinator.
    pub results: Sender,
    _services: [Service; 2],
    _node: Node<Ipc>,
    _domain: Domain,
}

impl WorkerLink {
    /// Opens both channels, and connects them.
    ///
    /// # Errors
    ///
    /// [`OpenError::Skew`] if the coordinator is another build or has other layouts; otherwise if
    /// there is no such link, or file descriptors or shared memory ran out.
    pub fn open(
        domain: &Domain,
        peer: Incarnation,
        sizes: &Sizes,
        build: &str,
    ) -> Result<Self, OpenError> {
        let [job, result] = &names(peer);
        let node = domain::node(&domain.root_of(peer), "worker")?;
        let jobs = open(&node, job, sizes.job_queue, build)?;
        let results = open(&node, result, sizes.result_queue, build)?;
        let link = Self {
            jobs: Receiver::new(input(&jobs, job)?, domain.boot(), peer),
            results: Sender::new(output(&results, result, sizes.result_words)?, sizes.result_words),
            _services: [jobs, results],
            _node: node,
            _domain: domain.clone(),
        };
        link.jobs.connect(job)?;
        link.results.connect(result)?;
        Ok(link)
    }
}

/// Job and result service of an incarnation.
fn names(peer: Incarnation) -> [String; 2] {
    ["job", "result"].map(|kind| format!("{kind}/{}.{}", peer.worker, peer.inc))
}

const BUILD: &str = "build";
const LAYOUT: &str = "layout";

/// Creates or opens a service with every quality of service set explicitly: the defaults overwrite
/// old messages and block senders.
fn service(
    node: &Node<Ipc>,
    name: &str,
    queue: usize,
) -> Result<Builder<[u64], Wire, Ipc>, OpenError> {
    let name = ServiceName::new(name).map_err(OpenError::at("name", name))?;
    Ok(node
        .service_builder(&name)
        .publish_subscribe::<[u64]>()
        .user_header::<Wire>()
        .max_publishers(1)
        .max_subscribers(1)
        .max_nodes(2)
        .history_size(0)
        .subscriber_max_buffer_size(queue)
        .subscriber_max_borrowed_samples(1)
        .enable_safe_overflow(false))
}

fn create(node: &Node<Ipc>, name: &str, queue: usize, build: &str) -> Result<Service, OpenError> {
    let mut attributes = AttributeSpecifier::new();
    for (key, value) in attributes_of(name, build)? {
        attributes =
            attributes.define(&key, &value).map_err(OpenError::at("mark the build of", name))?;
    }
    service(node, name, queue)?
        .create_with_attributes(&attributes)
        .map_err(OpenError::at("create channel", name))
}

fn open(node: &Node<Ipc>, name: &str, queue: usize, build: &str) -> Result<Service, OpenError> {
    let mut required = AttributeVerifier::new();
    for (key, value) in attributes_of(name, build)? {
        required =
            required.require(&key, &value).map_err(OpenError::at("check the build of", name))?;
    }
    let opened = service(node, name, queue)?.open_with_attributes(&required);
    opened.map_err(|error| match error {
        PublishSubscribeOpenError::IncompatibleAttributes
        | PublishSubscribeOpenError::IncompatibleTypes => OpenError::Skew {
            channel: name.to_owned(),
            ours: build.to_owned(),
            theirs: build_of(node, name).unwrap_or_else(|| "unknown".to_owned()),
        },
        other => OpenError::at("open channel", name)(other),
    })
}

fn attributes_of(
    name: &str,
    build: &str,
) -> Result<[(AttributeKey, AttributeValue); 2], OpenError> {
    let pair = |key: &str, value: &str| {
        let key = AttributeKey::try_from(key).map_err(OpenError::at("mark the build of", name))?;
        let value =
            AttributeValue::try_from(value).map_err(OpenError::at("mark the build of", name))?;
        Ok((key, value))
    };
    Ok([pair(BUILD, build)?, pair(LAYOUT, &protocol::LAYOUT.to_string())?])
}

/// The build id that the creator of a service stored with it.
fn build_of(node: &Node<Ipc>, name: &str) -> Option<String> {
    let name = ServiceName::new(name).ok()?;
    let pattern = MessagingPattern::PublishSubscribe;
    let details = Ipc::details(&name, node.config(), pattern).ok()??;
    let key = AttributeKey::try_from(BUILD).ok()?;
    let build = details.static_details.attributes().key_value(&key, 0)?;
    Some(build.to_string())
}

fn output(service: &Service, name: &str, words: usize) -> Result<Output, OpenError> {
    service
        .publisher_builder()
        .initial_max_slice_len(words)
        .allocation_strategy(AllocationStrategy::Static)
        .max_loaned_samples(1)
        .backpressure_strategy(BackpressureStrategy::DiscardData)
        .create()
        .map_err(OpenError::at("create the sending end of", name))
}

fn input(service: &Service, name: &str) -> Result<Input, OpenError> {
    service
        .subscriber_builder()
        .create()
        .map_err(OpenError::at("create the receiving end of", name))
}

#[cfg(test)]
mod tests;
