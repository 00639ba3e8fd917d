//! How much a service shares at most: with every client and listener that it can have.
//!
//! Services and ports are made with the numbers that stand here, and their pools have the sizes
//! that iceoryx2 0.10 computes from them (`service/static_config`).

use super::{DEAD_CHANNELS_MAX, LISTENERS_MAX, NODES_MAX};
use protocol::public::{Ask, CLIENTS_MAX, Health, WireAnswer};

/// Requests of a client that are worked on: one, and one that it gave up.
pub(super) const ACTIVE: usize = 2;
/// Requests of a client that it waits for.
pub(super) const ASKED: usize = 1;
/// Messages that a port writes at a time.
pub(super) const LOANS: usize = 1;
/// Messages that a port reads at a time.
pub(super) const BORROWS: usize = 1;
/// Answers that wait for a client.
pub(super) const ANSWERS: usize = 1;
/// Samples that wait for a listener; then the oldest goes.
pub(super) const SAMPLES: usize = 4;

/// What iceoryx2 adds to a message (bytes), at most.
const HEADER_BYTES: usize = 192;
/// What a node takes besides its pools (bytes), in whole pages: its connections, two at most, and
/// what describes it. Measured: 16 KiB (`service/tests.rs`).
const NODE_BYTES: usize = 32 << 10;
/// Connections of those that have gone, at most. The server keeps its end until it next takes a
/// request or publishes on that topic, and a ranking may be long in coming; meanwhile, others take
/// their places. What it has not seen of these goes with them. Connections of the killed stay, too,
/// until they are [so many](DEAD_CHANNELS_MAX).
const GONE_CONNECTIONS: usize = 2 * CLIENTS_MAX + 2 * LISTENERS_MAX + DEAD_CHANNELS_MAX;
/// What a connection takes (bytes), in whole pages: measured 4 KiB.
const CONNECTION_BYTES: usize = 8 << 10;
/// What the services themselves take (bytes): measured 80 KiB.
const SERVICES_BYTES: usize = 128 << 10;

const fn pool(messages: usize, bytes: usize) -> usize {
    (messages * (bytes + HEADER_BYTES)).next_multiple_of(4096)
}

/// Bytes of shared memory that a service takes at most, with its clients and listeners.
#[must_use]
pub const fn shared_bytes() -> usize {
    // Those that the server holds, and as many that it has not seen yet.
    let requests = 2 * ASKED + LOANS;
    let answers = CLIENTS_MAX * 2 * ACTIVE * (ANSWERS + BORROWS + LOANS);
    let samples = LISTENERS_MAX * (SAMPLES + BORROWS) + LOANS;
    CLIENTS_MAX * pool(requests, size_of::<Ask>())
        + pool(answers, size_of::<WireAnswer>())
        + pool(samples, size_of::<WireAnswer>())
        + pool(samples, size_of::<Health>())
        + NODES_MAX * NODE_BYTES
        + GONE_CONNECTIONS * CONNECTION_BYTES
        + SERVICES_BYTES
}

/// Segments that a service has at most, with its clients and listeners: its pools of answers,
/// rankings and health, what its four services, its bell and its nodes have in common; of each
/// client a pool and two connections, of each listener two connections; and as many connections of
/// those that were there before them, and of the killed.
#[must_use]
pub const fn shared_segments() -> usize {
    3 + 4 + 1 + 1 + 3 * CLIENTS_MAX + 2 * LISTENERS_MAX + GONE_CONNECTIONS
}
