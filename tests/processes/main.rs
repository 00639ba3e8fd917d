//! Real processes that live, die and talk to one another: runs, services, clients, measurements.
//!
//! They run side by side: each names its own runs (`support::instance`), counts what those alone
//! left in shared memory, and ends processes that it started and no others.

#[path = "../support/mod.rs"]
mod support;

mod alone;
mod bounds;
mod clients;
mod footprint;
mod group;
mod guard;
mod inject;
mod kill;
mod measure;
mod members;
mod serve;
mod sign;
mod signals;
mod strangers;
mod supervise;
