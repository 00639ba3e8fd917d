//! The command line.

use crate::plan::Distribute;
use clap::{Args as ClapArgs, Parser, Subcommand};
use scenario::WrittenDepth;
use std::path::PathBuf;

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
#[command(name = "trolley", version = crate::BUILD, after_help = EXAMPLES, max_term_width = 100)]
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

/// How results and progress are shown.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Output {
    pub(crate) json: bool,
    pub(crate) quiet: bool,
}

impl Args {
    pub(crate) fn output(&self) -> Output {
        Output { json: self.json, quiet: self.quiet }
    }
}

/// What `rank` is asked.
#[derive(Clone, Debug, ClapArgs)]
pub(crate) struct RankArgs {
    /// Scenario, TOML: see `trolley schema`; or traffic: CommonRoad or OpenSCENARIO, XML.
    pub(crate) scenario: PathBuf,
    #[command(flatten)]
    pub(crate) traffic: crate::traffic::TrafficArgs,
    #[command(flatten)]
    pub(crate) answer: AnswerArgs,
    #[command(flatten)]
    pub(crate) options: EngineArgs,
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
    Rank(Box<RankArgs>),
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
    #[cfg(feature = "lab")]
    /// Measure match schemes, depths, buffers and transfer on pairs of bodies: tables and figures.
    #[command(after_help = crate::measure::EXAMPLES)]
    Measure(crate::measure::MeasureArgs),
    #[cfg(feature = "lab")]
    /// Try bounds, deadlines and budgets on requests of chance: tables, and whether all holds.
    #[command(after_help = crate::certify::EXAMPLES)]
    Certify {
        #[command(subcommand)]
        verb: crate::certify::Verb,
    },
    #[cfg(feature = "lab")]
    /// Print what each step of the work costs on this machine, as JSON, in nanoseconds.
    Calibrate(crate::measure::CalibrateArgs),
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
    #[cfg(feature = "lab")]
    /// Decide among simulated workers and channels that fail, by seed.
    Simulate {
        #[command(subcommand)]
        verb: crate::simulate::Verb,
    },
    #[cfg(feature = "lab")]
    /// Answer requests while faults are injected into real processes; report what became of them.
    #[command(after_help = crate::inject::EXAMPLES)]
    Inject(crate::inject::InjectArgs),
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

/// What is done with an answer, and what may be assumed for it.
#[derive(Clone, Debug, Default, ClapArgs)]
pub(crate) struct AnswerArgs {
    /// Print the chain from contact to rank, with every source, and what would flip the winner.
    #[arg(long)]
    pub(crate) explain: bool,
    /// Take parties of unknown kind as fixed to the ground, with nobody in them; the answer says
    /// so. Without it a scenario that has any is refused.
    #[arg(long, value_name = "unknown=fixed")]
    pub(crate) assume: Option<Assume>,
    /// Add a decision record to this folder: what was asked, decided, and by what.
    #[arg(long, value_name = "DIR")]
    pub(crate) record: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) terms: crate::terms::TermsArgs,
}

/// What may be assumed of what nobody knows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Assume {
    /// Unknown things are fixed to the ground.
    #[value(name = "unknown=fixed")]
    UnknownFixed,
}

/// A depth as a person writes it.
fn depth(text: &str) -> Result<WrittenDepth, String> {
    match (text, text.parse()) {
        (_, Ok(levels)) => Ok(WrittenDepth::Levels(levels)),
        ("auto", _) => Ok(WrittenDepth::Word(text.to_owned())),
        _ => Err("write a whole number of levels, or auto".to_owned()),
    }
}

/// Settings of the engine; each overrides the scenario's. None changes a complete answer.
#[derive(Clone, Debug, Default, ClapArgs)]
pub(crate) struct EngineArgs {
    /// Worker processes, 1 to 16.
    #[arg(long, value_name = "N")]
    pub(crate) workers: Option<i64>,
    /// Core of each worker, as 0,1,2,3; "none": no pinning.
    #[arg(long, value_name = "LIST")]
    pub(crate) cores: Option<String>,
    /// Distribution depth: levels of both trees that the coordinator descends itself; "auto": as
    /// many as dry runs predict to be the quickest.
    #[arg(long, value_name = "D", value_parser = depth)]
    pub(crate) depth: Option<WrittenDepth>,
    /// Whether jobs are spread over the workers; "auto": not where one piece on one worker is
    /// predicted to be quicker.
    #[arg(long, value_name = "WHEN", default_value = "always", conflicts_with = "in_process")]
    pub(crate) distribute: Distribute,
    /// What each step costs, as `trolley calibrate --out FILE` wrote it; for predictions [default:
    /// built in].
    #[arg(long, value_name = "FILE")]
    pub(crate) costs: Option<PathBuf>,
    /// How trees are built: seed, literal or sah.
    #[arg(long)]
    pub(crate) build: Option<String>,
    /// Triangles in a leaf at most.
    #[arg(long, value_name = "N")]
    pub(crate) leaf_size: Option<i64>,
    /// How jobs are matched to workers: best-match-load, best-match, random-match, lowest-match or
    /// round-robin.
    #[arg(long)]
    pub(crate) scheme: Option<String>,
    /// Weight of the match against the load, 0 to 1.
    #[arg(long)]
    pub(crate) alpha: Option<f64>,
    /// Jobs per message.
    #[arg(long, value_name = "N")]
    pub(crate) batch: Option<i64>,
    /// Jobs on their way to one worker at most.
    #[arg(long, value_name = "N")]
    pub(crate) queue: Option<i64>,
    #[command(flatten)]
    pub(crate) transfer: crate::transfer::TransferArgs,
    /// Seed of every choice that is called random.
    #[arg(long, value_name = "N")]
    pub(crate) seed: Option<i64>,
    /// Name of this instance in shared memory: 1 to 12 of a-z, 0-9 and -.
    #[arg(long, value_name = "NAME")]
    pub(crate) instance: Option<String>,
    /// Run all jobs in this process, without workers: for comparison.
    #[arg(long)]
    pub(crate) in_process: bool,
}
