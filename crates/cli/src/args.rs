//! The command line.

use crate::answer_args::AnswerArgs;
use crate::engine_args::EngineArgs;
use crate::output::Output;
use clap::{Parser, Subcommand};

const EXAMPLES: &str = "\
Examples:
  trolley demo                                rank seven crashes between generated bodies
  trolley rank config/scenarios/minimal.toml  rank the crashes that a file describes
  trolley rank FILE --json --workers 2        as JSON, with two workers
  trolley model import car.obj --unit cm --up z --forward -y --kind sedan -o car.trolley

Exit codes: 0 ok, 2 usage, 3 degraded, 4 refused, 65 input, 69 resources, 70 internal,
71 operating system, 75 try again, 76 version skew, 77 no real time, 78 configuration,
130 interrupted.";

/// Ranks unavoidable collisions by harm, and says how certain the ranking is.
#[derive(Debug, Parser)]
#[command(name = "trolley", version = trolley::BUILD, after_help = EXAMPLES, max_term_width = 100)]
pub(crate) struct Args {
    #[command(subcommand)]
    pub(crate) command: Command,
    /// Print one JSON document on stdout and nothing else.
    #[arg(long, global = true)]
    pub(crate) json: bool,
    /// Show no progress, and log errors only.
    #[arg(short, long, global = true)]
    pub(crate) quiet: bool,
    /// Log more to stderr; twice for debug messages.
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
    /// Rank seven crashes between generated bodies.
    #[command(after_help = "Example:\n  trolley demo --workers 2")]
    Demo {
        #[command(flatten)]
        answer: AnswerArgs,
        #[command(flatten)]
        options: EngineArgs,
    },
    /// Rank the crashes described by a scenario file.
    #[command(after_help = "Examples:\n  trolley rank config/scenarios/demo.toml\n  \
        trolley rank crash.toml --json --depth 10 | jq .answer.ranking[0].name\n  \
        trolley rank config/scenarios/crossing.toml --report crossing.html\n  \
        trolley rank DEU_Gar-1_1_T-1.xml")]
    Rank(Box<crate::rank::RankArgs>),
    /// Answer planners' requests until stopped, as one deployment file says.
    #[command(after_help = crate::serve::EXAMPLES)]
    Serve(crate::serve::ServeArgs),
    /// Send the request of a scenario file to a running service.
    #[command(after_help = crate::query::EXAMPLES)]
    Query(crate::query::QueryArgs),
    /// Show the state of a running service: rate, answers, latencies, workers.
    #[command(after_help = crate::top::EXAMPLES)]
    Top(crate::top::TopArgs),
    /// Check this machine for what the service needs, and say how to fix what is missing.
    Doctor,
    /// Import scenarios from recorded or written traffic.
    Scenario {
        #[command(subcommand)]
        verb: crate::traffic::Verb,
    },
    /// Check policies and injury curves, and map which candidate wins under which of them.
    Policy {
        #[command(subcommand)]
        verb: crate::policy::Verb,
    },
    /// Find all pairs of intersecting triangles of two posed bodies, exactly.
    #[command(after_help = crate::intersect::EXAMPLES, after_long_help = crate::intersect::HELP)]
    Intersect(crate::intersect::IntersectArgs),
    /// Measure schemes, depths, buffers and transfer on pairs of bodies: tables and figures.
    #[cfg(feature = "lab")]
    #[command(after_help = crate::lab::measure::EXAMPLES)]
    Measure(Box<crate::lab::measure::MeasureArgs>),
    /// Check bounds, deadlines and budgets on random requests, and print tables.
    #[cfg(feature = "lab")]
    #[command(after_help = crate::lab::certify::EXAMPLES)]
    Certify {
        #[command(subcommand)]
        verb: crate::lab::certify::Verb,
    },
    /// Hold changes of velocity against crash tests, and answers against orderings.
    #[cfg(feature = "lab")]
    #[command(after_help = crate::lab::validate::EXAMPLES)]
    Validate(crate::lab::validate::ValidateArgs),
    /// Measure what each step of the work costs on this machine (JSON, nanoseconds).
    #[cfg(feature = "lab")]
    Calibrate(crate::lab::calibrate::CalibrateArgs),
    /// Import, inspect, check, generate and export bodies.
    Model {
        #[command(subcommand)]
        verb: crate::model::Verb,
    },
    /// Show, verify and replay decision records.
    Record {
        #[command(subcommand)]
        verb: crate::record::Verb,
    },
    /// Simulate workers and channels that fail, from a seed.
    #[cfg(feature = "lab")]
    Simulate {
        #[command(subcommand)]
        verb: crate::lab::simulate::Verb,
    },
    /// Inject faults into real processes while they answer requests, and report the outcomes.
    #[cfg(feature = "lab")]
    #[command(after_help = crate::lab::inject::EXAMPLES)]
    Inject(crate::lab::inject::InjectArgs),
    /// Turn a decision record or a measurement into an HTML page, .glb files or PNG stills.
    #[command(after_help = crate::report::EXAMPLES)]
    Report(crate::report::ReportArgs),
    /// Print the JSON Schema of scenarios.
    Schema,
    /// Print shell completions.
    Completions {
        /// Shell to print completions for.
        shell: clap_complete::Shell,
    },
    /// Print the man page.
    Man,
    /// Run as a worker process; started by a coordinator, not by hand.
    #[command(hide = true)]
    Worker {
        /// Start parameters, as the coordinator encodes them.
        word: String,
    },
}
