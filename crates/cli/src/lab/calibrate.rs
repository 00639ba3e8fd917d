//! `trolley calibrate`: what each step of the work costs on this machine.

use crate::print;
use ::lab::PairName;
use ::lab::measure::{CalibrateOptions, PAIRS, calibrate};
use std::path::PathBuf;
use std::process::ExitCode;
use trolley::Failure;

#[derive(Clone, Debug, clap::Args)]
pub(crate) struct CalibrateArgs {
    /// Bodies and poses, A,B,POSES, as for trolley measure.
    #[arg(long, value_name = "A,B,POSES", default_value = PAIRS[0])]
    pair: PairName,
    /// Number of runs of each measurement.
    #[arg(long, value_name = "N", default_value_t = 7,
          value_parser = clap::value_parser!(u16).range(1..=1000))]
    repeat: u16,
    /// Also write the document to this file.
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

pub(crate) fn run(args: &CalibrateArgs) -> Result<ExitCode, Failure> {
    let CalibrateArgs { pair, repeat, out } = args.clone();
    print::out(&print::json(&calibrate(&CalibrateOptions { pair, repeat, out })?)?)
}
