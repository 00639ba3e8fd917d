//! What answers must be, whatever way the work was done: one program of tests, so that its threads
//! keep all cores busy and it is linked once.

#[path = "../support/mod.rs"]
mod support;

mod deadline;
mod explain;
mod identical;
mod ledger;
mod oracle;
mod policy;
mod record;
mod refine;
