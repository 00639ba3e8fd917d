//! Files from outside and files for outside: meshes, scenarios, traffic, reports, and bad input.

#[path = "../support/mod.rs"]
mod support;

mod bounded;
mod cast;
mod import;
mod input;
mod intersect;
mod outputs;
mod pasted;
mod plausible;
mod real;
mod references;
mod report;
mod traces;
mod traffic;
mod widths;
mod words;
