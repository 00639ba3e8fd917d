//! `trolley scenario import`, and `trolley rank FILE.xml`: traffic files as scenarios.

use crate::output::Output;
use crate::print;
use crate::reference_args::ReferenceArgs;
use clap::{Args as ClapArgs, Subcommand};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use trolley::traffic::{ImportedTraffic, TrafficOptions};
use trolley::{Failure, References};

const EXAMPLES: &str = "\
Examples:
  trolley scenario import config/examples/crossing.xml -o crossing.toml
  trolley rank crossing.toml
  trolley scenario import config/examples/crossing.xml --at 0.5 --brakes 0,8 --laterals=-4,0,4
  trolley scenario import config/examples/crossing.osi --at 1 -o crossing.toml
  trolley rank config/examples/merge.mcap
  trolley rank config/examples/junction.csv --ego Oncoming
  trolley rank config/examples/crossing.xml --solution config/examples/braking.xml

Reads CommonRoad 2018b and 2020a, and traces of simulators: ASAM OSI 3 (.osi, .mcap) with ground
truth, and what esmini writes with --csv_logger (.csv). An OpenSCENARIO script is to be played
first. Without -o, prints the scenario.";

#[derive(Debug, Subcommand)]
pub(crate) enum Verb {
    /// Make a scenario from a CommonRoad file or a trace of a simulator.
    #[command(after_help = EXAMPLES)]
    Import(ImportArgs),
}

#[derive(Debug, ClapArgs)]
pub(crate) struct ImportArgs {
    /// Traffic file: .xml, .osi, .mcap or .csv.
    file: PathBuf,
    #[command(flatten)]
    traffic: TrafficArgs,
    #[command(flatten)]
    references: ReferenceArgs,
    /// Scenario to write. It names models of --bodies where they are: to rank it from another
    /// folder, use --allow-outside there.
    #[arg(short, long, value_name = "OUT.toml")]
    out: Option<PathBuf>,
}

/// How to read a traffic file, and which manoeuvres to try.
#[derive(Clone, Debug, Default, ClapArgs)]
#[command(next_help_heading = "Traffic files (CommonRoad, OSI, esmini)")]
pub(crate) struct TrafficArgs {
    /// The obstacle, planning problem, object or entity that is the ego, if the file leaves that
    /// open.
    #[arg(long, value_name = "ID")]
    ego: Option<String>,
    /// Leave this obstacle out; may be repeated.
    #[arg(long, value_name = "ID")]
    without: Vec<String>,
    /// When manoeuvres begin, after the ego's start (s); until then it moves as recorded.
    #[arg(long, value_name = "S", value_parser = within::<0, 3600>)]
    at: Option<f64>,
    /// How far ahead to look (s; default: 3).
    #[arg(long, value_name = "S", value_parser = within::<0, 60>)]
    horizon: Option<f64>,
    /// Decelerations to try (m/s²; default: 8,4,0); of equals the first wins.
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = within::<0, 20>)]
    brakes: Option<Vec<f64>>,
    /// Lateral accelerations to try, left positive (m/s²; default: 0,-3,3,-6,6).
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = within::<-20, 20>,
        allow_hyphen_values = true)]
    laterals: Option<Vec<f64>>,
    /// Total acceleration that the tyres allow (m/s²; default: 9).
    #[arg(long, value_name = "A", value_parser = within::<1, 20>)]
    grip: Option<f64>,
    /// Library of bodies by type (default: generated ones, config/bodies/default.toml).
    #[arg(long, value_name = "FILE")]
    bodies: Option<PathBuf>,
    /// Solution of a CommonRoad planner: its way is a candidate, called like the file; may be
    /// repeated.
    #[arg(long, value_name = "FILE")]
    solution: Vec<PathBuf>,
}

/// A number in a range.
fn within<const LEAST: i32, const MOST: i32>(text: &str) -> Result<f64, String> {
    let range = f64::from(LEAST)..=f64::from(MOST);
    match text.trim().parse::<f64>() {
        Ok(value) if range.contains(&value) => Ok(value + 0.0),
        _ => Err(format!("write a number, {LEAST} to {MOST}")),
    }
}

/// Reads a traffic file and makes a scenario's text.
pub(crate) fn import(
    path: &Path,
    args: &TrafficArgs,
    references: References,
) -> Result<ImportedTraffic, Failure> {
    let args = args.clone();
    let options = TrafficOptions {
        ego: args.ego,
        without: args.without,
        at_s: args.at,
        horizon_s: args.horizon,
        brakes_m_s2: args.brakes,
        laterals_m_s2: args.laterals,
        grip_m_s2: args.grip,
        bodies: args.bodies,
        solutions: args.solution,
        references,
    };
    trolley::traffic::import(path, &options)
}

pub(crate) fn run(verb: &Verb, output: &Output) -> Result<ExitCode, Failure> {
    let Verb::Import(args) = verb;
    let out = args.out.as_deref();
    out.map(|out| trolley::files::check(out, Some(&args.file))).transpose()?;
    let imported = import(&args.file, &args.traffic, args.references.references())?;
    if let Some(out) = &args.out {
        trolley::files::replace(out, imported.text.as_bytes())?;
    }
    if output.json {
        return print::out(&print::json(&imported.document(&args.file))?);
    }
    if !output.quiet {
        print::err(&imported.summary());
    }
    let Some(out) = &args.out else { return print::out(&imported.text) };
    print::err(&format!("written: {}", out.display()));
    Ok(ExitCode::SUCCESS)
}
