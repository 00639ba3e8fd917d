//! `trolley measure`: the paper's experiment on real bodies (schemes, depths, buffers, transfer),
//! the map of where each of its claims holds, or one ranking with experimental settings.

use super::shown::show;
use crate::answer_args::LimitArgs;
use crate::engine_args::EngineArgs;
use crate::named::named;
use crate::output::Output;
use crate::reference_args::ReferenceArgs;
use ::lab::PairName;
use ::lab::measure::{ALPHA, MapOptions, RankOptions, SweepOptions};
use ::lab::measure::{map, rank, sweep, virtual_cores};
use scenario::{EngineSettings, Overrides, Scheme};
use std::path::PathBuf;
use std::process::ExitCode;
use trolley::dispatch_options::{DispatchOptions, TransferMode};
use trolley::{Failure, Limits, SearchOrder};

pub(crate) const EXAMPLES: &str = "\
Examples:
  trolley measure --quick --out results
  trolley measure --pair sedan:20000,suv:20000,deep --out results
  trolley measure --quick --scheme best-match,round-robin --transfer copy --out results
  trolley measure --map --out map
  trolley measure --scenario config/examples/crash.toml --scheme lowest-match --job-log jobs.csv
  trolley measure --scenario config/scenarios/demo.toml --virtual-cores

A pair is A,B,POSES. Bodies are model files, or shape:triangles for generated ones. Poses are a file
(six lines, as for trolley intersect), or deep or scratch: B approaches from sixteen directions
until it is 0.5 m, or 0.01 m, inside A. The claim about two contacts compares deep and scratch of
the same bodies.";

#[derive(Clone, Debug, clap::Args)]
pub(crate) struct MeasureArgs {
    /// Use fewer depths, buffers and repeats: takes a minute, with wider margins.
    #[arg(long)]
    quick: bool,
    /// Map where each claim of the paper holds: on its machine, on this one made to copy, and on
    /// ours. Takes minutes; an interrupted map goes on.
    #[arg(long, requires = "out", conflicts_with_all = ["pair", "scheme", "alpha", "transfer",
          "memory_budget", "cache_bytes", "linger", "job_log", "scenario", "search_order"])]
    map: bool,
    /// Bodies and poses, A,B,POSES; may be repeated.
    #[arg(long, value_name = "A,B,POSES")]
    pair: Vec<PairName>,
    /// Folder for tables, figures and the page; created if missing.
    #[arg(long, value_name = "DIR", required_unless_present = "scenario")]
    out: Option<PathBuf>,
    /// Measure one ranking of this scenario instead.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["quick", "pair", "out"])]
    scenario: Option<PathBuf>,
    /// With --scenario: simulate one, two and four workers on cores that need not be there.
    #[arg(long, requires = "scenario", conflicts_with_all = ["out", "in_process", "workers",
          "instance", "transfer", "memory_budget", "cache_bytes", "linger", "job_log"])]
    virtual_cores: bool,
    #[command(flatten)]
    references: ReferenceArgs,
    /// How jobs are matched to workers; a list for a sweep [default: all, or the scenario's].
    #[arg(long, value_name = "NAME", value_delimiter = ',',
          value_parser = named(Scheme::ALL, Scheme::name))]
    scheme: Vec<Scheme>,
    /// Weight of the match against the load, 0 to 1 [default: 0.5, or the scenario's].
    #[arg(long)]
    alpha: Option<f64>,
    /// How workers get the bodies [default for a sweep: both, for a ranking: zero-copy].
    #[arg(long, value_name = "MODE", value_parser = named(TransferMode::ALL, TransferMode::name),
          conflicts_with = "in_process")]
    transfer: Option<TransferMode>,
    /// With --transfer copy: bytes of sections that a worker may hold [default: 60 % of all].
    #[arg(long, value_name = "BYTES", conflicts_with = "in_process")]
    memory_budget: Option<u64>,
    /// Bytes of sections that a core may hold by the transfer ledger [default: no limit].
    #[arg(long, value_name = "BYTES", conflicts_with = "in_process")]
    cache_bytes: Option<u64>,
    /// How long an incomplete batch waits for more jobs (µs).
    #[arg(long, value_name = "US", default_value_t = 0, conflicts_with = "in_process")]
    linger: u64,
    /// Write which worker got which job in the last measured run to this file, as CSV.
    #[arg(long, value_name = "FILE", conflicts_with = "in_process")]
    job_log: Option<PathBuf>,
    /// With --scenario: which candidate's job is sent next.
    #[arg(long, alias = "pursuit", value_name = "NAME",
          value_parser = named(SearchOrder::ALL, SearchOrder::name))]
    search_order: Option<SearchOrder>,
    #[command(flatten)]
    limits: LimitArgs,
    #[command(flatten)]
    engine: EngineArgs,
}

pub(crate) fn run(args: &MeasureArgs, output: &Output) -> Result<ExitCode, Failure> {
    match (&args.scenario, &args.out) {
        (Some(scenario), _) => ranked(args, scenario.clone(), output),
        (None, Some(out)) if args.map => mapped(args, out.clone(), output),
        (None, Some(out)) => swept(args, out.clone(), output),
        (None, None) => Err(Failure::internal("neither a scenario nor a folder")),
    }
}

impl MeasureArgs {
    fn dispatch_options(&self) -> DispatchOptions {
        DispatchOptions {
            linger_us: self.linger,
            cache_bytes: self.cache_bytes,
            transfer: self.transfer.unwrap_or_default(),
            memory_budget: self.memory_budget,
            log: self.job_log.is_some(),
            virtual_cores: None,
        }
    }
}

/// Refuses settings that a sweep or a map chooses itself; returns the seed.
fn plain_seed(args: &MeasureArgs) -> Result<u64, Failure> {
    let overrides = args.engine.overrides()?;
    let seed_alone = Overrides { seed: overrides.seed, ..Overrides::default() };
    let is_plain = args.engine.instance.is_none() && !args.engine.in_process;
    let is_plain = is_plain && args.search_order.is_none();
    if !is_plain || overrides != seed_alone || args.limits.limits()? != Limits::default() {
        let fault = "a sweep chooses workers, depths, buffers and limits itself";
        return Err(Failure::setting(fault)
            .with_remedy("name a scenario to be ranked with these settings: --scenario FILE"));
    }
    Ok(EngineSettings::DEFAULT.apply(&overrides)?.seed)
}

/// The map of where each claim holds.
fn mapped(args: &MeasureArgs, out: PathBuf, output: &Output) -> Result<ExitCode, Failure> {
    if plain_seed(args)? != EngineSettings::DEFAULT.seed {
        return Err(Failure::setting("a map has seeds of its own").with_remedy("leave --seed out"));
    }
    let progress = output.progress("mapping");
    let options = MapOptions { quick: args.quick, out };
    let map = map(&options, &|done, total| progress.set(done, total))?;
    drop(progress);
    show(&map, || map.text(), output)
}

/// Tables, figures and a page over pairs of bodies.
fn swept(args: &MeasureArgs, out: PathBuf, output: &Output) -> Result<ExitCode, Failure> {
    let seed = plain_seed(args)?;
    let progress = output.progress("measuring");
    let options = SweepOptions {
        quick: args.quick,
        pairs: args.pair.clone(),
        out,
        schemes: args.scheme.clone(),
        seed,
        alpha: args.alpha.unwrap_or(ALPHA),
        transfer: args.transfer,
        dispatch_options: args.dispatch_options(),
        job_log: args.job_log.clone(),
    };
    let measured = sweep(&options, &|done, total| progress.set(done, total))?;
    drop(progress);
    show(&measured, || measured.text(), output)
}

/// One ranking of a scenario.
fn ranked(args: &MeasureArgs, scenario: PathBuf, output: &Output) -> Result<ExitCode, Failure> {
    if args.scheme.len() > 1 {
        return Err(Failure::setting("one ranking has one scheme")
            .with_remedy("name one with --scheme, or leave --scenario out"));
    }
    let scheme = args.scheme.first().map(|one| one.name().to_owned());
    let own = args.limits.limits()?;
    let limits = args.search_order.map_or(own, |order| own.with_search_order(order));
    let options = RankOptions {
        scenario,
        references: args.references.references(),
        overrides: Overrides { scheme, alpha: args.alpha, ..args.engine.overrides()? },
        dispatch_options: args.dispatch_options(),
        limits,
        instance: args.engine.instance.clone(),
        in_process: args.engine.in_process,
        job_log: args.job_log.clone(),
    };
    if args.virtual_cores {
        let progress = output.progress("ranking in turns");
        let report = virtual_cores(&options, &|done, total| progress.set(done, total))?;
        drop(progress);
        return show(&report, || report.text(), output);
    }
    let progress = output.progress("building bodies: triangles");
    let ranked = rank(&options, &|done, total| progress.set(done, total))?;
    drop(progress);
    show(&ranked, || ranked.text(), output)
}
