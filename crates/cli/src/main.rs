//! `trolley`: ranks unavoidable collisions by harm, and says how certain the ranking is.
//!
//! One binary plays every role: the command line for people, the coordinator of a request, and, as
//! `trolley worker`, each of its workers. Results go to stdout; logs, progress and errors to
//! stderr. Exit codes are those of [`trolley::FailureKind`].

mod answer_args;
mod args;
mod course_table;
mod doctor;
mod engine_args;
mod help;
mod init;
mod intersect;
#[cfg(feature = "lab")]
mod lab;
mod model;
mod named;
mod output;
mod policy;
mod print;
mod progress;
mod query;
mod rank;
mod ranking_table;
mod record;
mod reference_args;
mod report;
mod serve;
#[cfg(feature = "study")]
mod study;
mod table;
mod top;
mod traffic;

use args::{Args, Command};
use clap::{CommandFactory as _, Parser as _};
use std::process::ExitCode;
use trolley::Failure;

/// Counts the allocations of a request, at the cost of one increment each.
#[global_allocator]
static HEAP: trolley::CountingAllocator = trolley::CountingAllocator;

fn main() -> ExitCode {
    trolley::explain_aborts();
    let done = match Args::try_parse() {
        Ok(args) => {
            start_logging(&args);
            run(&args)
        }
        // Usage errors go to stderr, with exit code 2.
        Err(usage) if usage.use_stderr() => usage.exit(),
        // Help and version are output like any other: a full disk is an error.
        Err(asked) => print::out_bytes(asked.render().to_string().as_bytes()),
    };
    match done {
        Ok(code) => code,
        Err(failure) => {
            print::err(&format!("error: {failure}"));
            failure.kind().into()
        }
    }
}

fn run(args: &Args) -> Result<ExitCode, Failure> {
    match &args.command {
        Command::Demo { answer, options } => rank::demo(answer, options, &args.output()),
        Command::Rank(asked) => rank::rank(asked, &args.output()),
        Command::Scenario { verb } => traffic::run(verb, &args.output()),
        Command::Policy { verb } => policy::run(verb, &args.output()),
        Command::Record { verb } => record::run(verb, &args.output()),
        #[cfg(feature = "lab")]
        Command::Simulate { verb } => lab::simulate::run(verb, args.verbose, &args.output()),
        #[cfg(feature = "lab")]
        Command::Inject(options) => lab::inject::run(options, &args.output()),
        Command::Report(asked) => report::run(asked, &args.output()),
        Command::Intersect(options) => intersect::run(options, &args.output()),
        #[cfg(feature = "lab")]
        Command::Measure(options) => lab::measure::run(options, &args.output()),
        #[cfg(feature = "lab")]
        Command::Certify { verb } => lab::certify::run(verb, &args.output()),
        #[cfg(feature = "lab")]
        Command::Validate(options) => lab::validate::run(options, &args.output()),
        #[cfg(feature = "lab")]
        Command::Calibrate(options) => lab::calibrate::run(options),
        #[cfg(feature = "study")]
        Command::Study { verb } => study::run(verb, &args.output()),
        Command::Model { verb } => model::run(verb, &args.output()),
        Command::Serve(options) => serve::run(options, &args.output()),
        Command::Query(options) => query::run(options, &args.output()),
        Command::Top(options) => top::run(options, &args.output()),
        Command::Doctor(asked) => doctor::run(asked, &args.output()),
        Command::Schema { report: true } => print::out(::report::document::schema().trim_end()),
        Command::Schema { report: false } => print::out(&scenario::schema()),
        Command::Completions { shell } => {
            let mut text = Vec::new();
            clap_complete::generate(*shell, &mut Args::command(), "trolley", &mut text);
            print::out_bytes(&text)
        }
        Command::Man(asked) => help::manual(Args::command(), asked, &args.output()),
        Command::Help { words } => help::run(Args::command(), words),
        Command::Init(asked) => init::run(asked, &args.output()),
        Command::Worker { word } => {
            trolley::run_worker(word)?;
            Ok(ExitCode::SUCCESS)
        }
    }
}

fn start_logging(args: &Args) {
    let level = match (args.quiet, args.verbose) {
        (true, _) => tracing::Level::ERROR,
        #[cfg(feature = "lab")] // Thousands of injected faults: only the report lists them.
        (false, 0) if matches!(args.command, Command::Inject(_)) => tracing::Level::ERROR,
        (false, 0) => tracing::Level::WARN,
        (false, 1) => tracing::Level::INFO,
        (false, _) => tracing::Level::DEBUG,
    };
    tracing_subscriber::fmt()
        .with_max_level(level)
        .with_writer(std::io::stderr)
        .with_ansi(print::is_colourful())
        .without_time()
        .with_target(false)
        .init();
}
