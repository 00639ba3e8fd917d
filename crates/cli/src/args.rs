//! The command line.

use crate::answer_args::AnswerArgs;
use crate::engine_args::EngineArgs;
use crate::output::Output;
use clap::{Parser, Subcommand};

const EXAMPLES: &str = "\
Examples:
  trolley demo                                rank seven crashes between generated bodies
  trolley rank config/scenarios/minimal.toml  rank the crashes that a file describes
  trolley rank FILE --json --workers 2        the same for programs, on two workers
  trolley model import car.obj --unit cm --up z --forward -y --kind sedan -o car.trolley

Exit codes: 0 ok, 2 usage, 3 degraded, 4 refused, 65 input, 69 resources, 70 internal,
71 operating system, 75 try again, 76 version skew, 77 no real time, 78 configuration,
130 interrupted.";

/// Ranks unavoidable collisions by the harm they do, and says how sure that is.
#[derive(Debug, Parser)]
#[command(name = "trolley", version = trolley::BUILD, after_help = EXAMPLES, max_term_width = 100)]
pub(crate) struct Args {
    #[command(subcommand)]
    pub(crate) command: Command,
    /// Print one JSON document on stdout and nothing else.
    #[arg(long, global = true)]
    pub(crate) json: bool,
    /// No progress, and errors only.
    #[arg(short, long, global = true)]
    pub(crate) quiet: bool,
    /// More log lines on stderr; twice for all.
    #[arg(short, long, global = true, action = clap::ArgAction::Count)]
    pub(crate) verbose: u8,
}

impl Args {
    pub(crate) fn output(&self) -> Output {
        Output { json: self.json, quiet: self.quiet }
    }
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Rank seven crashes between bodies that the program generates itself.
    #[command(after_help = "Example:\n  trolley demo --workers 2")]
    Demo {
        #[command(flatten)]
        answer: AnswerArgs,
        #[command(flatten)]
        options: EngineArgs,
    },
    /// Rank the crashes that a scenario file describes.
    #[command(after_help = "Examples:\n  trolley rank config/scenarios/demo.toml\n  \
        trolley rank crash.toml --json --depth 10 | jq .answer.ranking[0].name\n  \
        trolley rank DEU_Gar-1_1_T-1.xml")]
    Rank(Box<crate::rank::RankArgs>),
    /// Answer requests of planners until told to stop: models, workers and all from one file.
    #[command(after_help = crate::serve::EXAMPLES)]
    Serve(crate::serve::ServeArgs),
    /// Ask a running service what a scenario file asks.
    #[command(after_help = crate::query::EXAMPLES)]
    Query(crate::query::QueryArgs),
    /// Show how a running service is: rate, answers, latencies, workers.
    #[command(after_help = crate::top::EXAMPLES)]
    Top(crate::top::TopArgs),
    /// Look at this machine: what the service needs of it, what is missing, what to do about it.
    Doctor,
    /// Scenarios from recorded or written traffic.
    Scenario {
        #[command(subcommand)]
        verb: crate::traffic::Verb,
    },
    /// Policies and injury curves: would they be accepted, and what do they say?
    Policy {
        #[command(subcommand)]
        verb: crate::policy::Verb,
    },
    /// Find the intersecting triangles of two posed bodies: all pairs, exactly.
    #[command(after_help = crate::intersect::EXAMPLES, after_long_help = crate::intersect::HELP)]
    Intersect(crate::intersect::IntersectArgs),
    /// Measure match schemes, depths, buffers and transfer on pairs of bodies: tables and figures.
    #[cfg(feature = "lab")]
    #[command(after_help = crate::lab::measure::EXAMPLES)]
    Measure(Box<crate::lab::measure::MeasureArgs>),
    /// Try bounds, deadlines and budgets on requests of chance: tables, and whether all holds.
    #[cfg(feature = "lab")]
    #[command(after_help = crate::lab::certify::EXAMPLES)]
    Certify {
        #[command(subcommand)]
        verb: crate::lab::certify::Verb,
    },
    /// Print what each step of the work costs on this machine, as JSON, in nanoseconds.
    #[cfg(feature = "lab")]
    Calibrate(crate::lab::calibrate::CalibrateArgs),
    /// Bodies: import, look at, check, generate, export.
    Model {
        #[command(subcommand)]
        verb: crate::model::Verb,
    },
    /// Decision records: look at, check, make again.
    Record {
        #[command(subcommand)]
        verb: crate::record::Verb,
    },
    /// Decide among simulated workers and channels that fail, by seed.
    #[cfg(feature = "lab")]
    Simulate {
        #[command(subcommand)]
        verb: crate::lab::simulate::Verb,
    },
    /// Answer requests while faults are injected into real processes; report what became of them.
    #[cfg(feature = "lab")]
    #[command(after_help = crate::lab::inject::EXAMPLES)]
    Inject(crate::lab::inject::InjectArgs),
    /// Show a decision record or a measurement: one HTML page, .glb, PNG stills.
    #[command(after_help = crate::report::EXAMPLES)]
    Report(crate::report::ReportArgs),
    /// Print the JSON Schema of scenarios.
    Schema,
    /// Print completions for a shell.
    Completions {
        /// Which shell.
        shell: clap_complete::Shell,
    },
    /// Print the manual page.
    Man,
    /// A worker process: started by a coordinator, not by hand.
    #[command(hide = true)]
    Worker {
        /// How it was started.
        word: String,
    },
}
