//! Bodies on the command line.

use crate::args::Output;
use crate::failure::Failure;
use clap::Subcommand;
use std::process::ExitCode;

#[derive(Debug, Subcommand)]
pub(crate) enum Verb {}

pub(crate) fn run(verb: &Verb, _output: &Output) -> Result<ExitCode, Failure> {
    match *verb {}
}
