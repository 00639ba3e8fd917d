//! The command line.

use crate::answer_args::AnswerArgs;
use crate::engine_args::EngineArgs;
use crate::output::Output;
use clap::{Parser, Subcommand};

const EXAMPLES: &str = "\
Examples:
  trolley demo                                rank seven crashes between generated bodies
  trolley init crash.toml                     write a scenario to begin with
  trolley rank crash.toml                     rank the crashes that it describes
  trolley rank crash.toml --json --workers 2  as JSON, with two workers
  trolley help tutorial                       from a mesh to a ranking in ten minutes

Exit codes: 0 ok, 2 usage, 3 degraded, 4 refused, 65 input, 69 resources, 70 internal,
71 operating system, 75 try again, 76 version skew, 77 no real time, 78 configuration,
130 interrupted: trolley help exit-codes. Other pages: trolley help topics.";

/// Ranks unavoidable collisions by harm, and says how certain the ranking is.
#[derive(Debug, Parser)]
#[command(name = "trolley", version = trolley::BUILD, after_help = EXAMPLES, max_term_width = 100,
          disable_help_subcommand = true)]
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
        trolley rank config/examples/crash.toml --json --depth 10\n  \
        trolley rank config/scenarios/crossing.toml --report crossing.html\n  \
        trolley rank config/examples/crossing.xml\n  \
        trolley rank - < config/examples/crash.toml")]
    Rank(Box<crate::rank::RankArgs>),
    /// Answer planners' requests until stopped, as one deployment file says.
    #[command(after_help = crate::serve::EXAMPLES)]
    Serve(crate::serve::ServeArgs),
    /// Write a commented scenario that ranks at once, to begin with.
    #[command(after_help = crate::init::EXAMPLES)]
    Init(crate::init::InitArgs),
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
    /// Rank many scenes: recordings and scenarios, swept, under several policies; tables come out.
    #[cfg(feature = "study")]
    #[command(after_help = crate::study::EXAMPLES)]
    Study {
        #[command(subcommand)]
        verb: crate::study::Verb,
    },
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
    /// Print the JSON Schema of scenarios, or of what `--report-json` writes.
    Schema {
        /// Print that of the document that `rank --report-json` and `report --report-json` write.
        #[arg(long)]
        report: bool,
    },
    /// Print shell completions.
    Completions {
        /// Shell to print completions for.
        shell: clap_complete::Shell,
    },
    /// Print a man page: of the program, or of one command.
    #[command(after_help = crate::help::MAN_EXAMPLES)]
    Man(crate::help::ManArgs),
    /// Print the help of a command, or a page: see `trolley help topics`.
    Help {
        /// A command, or a topic.
        #[arg(value_name = "COMMAND | TOPIC")]
        words: Vec<String>,
    },
    /// Run as a worker process; started by a coordinator, not by hand.
    #[command(hide = true)]
    Worker {
        /// Start parameters, as the coordinator encodes them.
        word: String,
    },
}
