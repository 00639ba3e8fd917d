//! What answers must be, however the work is done. One test program, so that its threads keep all
//! cores busy and it is linked once.

#[path = "../support/mod.rs"]
mod support;

mod deadline;
mod explain;
mod horizon;
mod identical;
mod members;
mod oracle;
mod policy;
mod record;
mod refine;
mod replay;
mod sign;
mod transfer;
mod validate;
