//! The paper's experiment on real bodies: schemes, depths, buffers, transfer.
//!
//! ```text
//! pair ──▶ bench: real runs ──▶ calibrate ──▶ Costs ─┐
//!            └── traces ─────────────────────────────┴▶ simulate ──▶ rows ──▶ page
//! ```
//!
//! All runs, in-process or by workers, must find the same triangles, or nothing is written.

mod bench;
mod calibrate;
mod curve;
mod document;
pub(crate) mod figure;
mod map;
mod page;
mod ranking;
mod row;
mod sweep;
mod swept;
mod virtual_cores;

pub use map::{Map, MapOptions, map};
pub use ranking::{RankOptions, RankedRun, rank};
pub use virtual_cores::{VirtualReport, VirtualRow, virtual_cores};

use crate::pair::PairName;
use crate::progress::{Progress, SyncProgress};
use bench::Bench;
use curve::curve;
use document::{json, machine};
use figure::{Figure, Line, draw};
use row::{Mode, Row};
use scenario::{EngineSettings, Scheme};
use serde::Serialize;
use simulate::Costs;
use std::path::{Path, PathBuf};
use sweep::Plan;
use swept::Swept;
use trolley::dispatch_options::{DispatchOptions, TransferMode, log_csv};
use trolley::{Failure, FailureKind, files};

/// Default pairs.
pub const PAIRS: [&str; 2] = ["sedan:100000,suv:100000,deep", "sedan:100000,suv:100000,scratch"];
/// Default weight of the match against the load.
pub const ALPHA: f64 = 0.5;

/// What to sweep, and where to write the results.
#[derive(Clone, Debug)]
pub struct SweepOptions {
    /// Use fewer depths, buffers and repeats: takes a minute, with wider margins.
    pub quick: bool,
    /// Bodies and poses; none: [`PAIRS`].
    pub pairs: Vec<PairName>,
    /// Folder for tables, figures and the page; created if missing.
    pub out: PathBuf,
    /// Schemes; none: all.
    pub schemes: Vec<Scheme>,
    /// Seed of random match.
    pub seed: u64,
    /// Weight of the match against the load in best-match-load, 0 to 1.
    pub alpha: f64,
    /// How workers of measured runs get the bodies; `None`: measure both zero-copy and copying.
    pub transfer: Option<TransferMode>,
    /// How jobs reach the workers of measured runs; its transfer mode is ignored.
    pub dispatch_options: DispatchOptions,
    /// Where to write the job log of the last measured run.
    pub job_log: Option<PathBuf>,
}

/// What to calibrate.
#[derive(Clone, Debug)]
pub struct CalibrateOptions {
    /// Bodies and poses.
    pub pair: PairName,
    /// Number of repeats of each run.
    pub repeat: u16,
    /// File to write the document to as well.
    pub out: Option<PathBuf>,
}

/// The measurements, as a document and as text.
#[derive(Debug, Serialize)]
pub struct Measurement {
    schema: &'static str,
    machine: String,
    command: String,
    pairs: Vec<Swept>,
    #[serde(skip)]
    out: PathBuf,
}

/// Measures what each step costs on this machine (ns).
///
/// # Errors
///
/// If a body or its poses cannot be used, workers cannot be started, or the file cannot be written.
pub fn calibrate(options: &CalibrateOptions) -> Result<Costs, Failure> {
    // Fail before the measurement, not after it, if its file cannot be written.
    options.out.as_deref().map(|path| files::check(path, None)).transpose()?;
    let pair = options.pair.load()?;
    let bench = Bench::new(&pair, usize::from(options.repeat), false)?;
    let costs = calibrate::calibrate(&bench, sweep::FINE)?;
    if let Some(path) = &options.out {
        files::replace(path, format!("{}\n", json(&costs)?).as_bytes())?;
    }
    Ok(costs)
}

/// Sweeps all pairs, and writes tables, figures and a page. `told` is called with the steps done.
///
/// # Errors
///
/// If a setting is out of range or contradicts another, a body or its poses cannot be used, workers
/// cannot be started, or a file cannot be written.
pub fn sweep(options: &SweepOptions, told: SyncProgress<'_>) -> Result<Measurement, Failure> {
    if !(0.0..=1.0).contains(&options.alpha) {
        let fault = format!("--alpha is {}", options.alpha);
        return Err(Failure::setting(fault).with_remedy("--alpha may be 0 to 1"));
    }
    options.dispatch_options.queues(&EngineSettings::DEFAULT)?;
    // Fail now, not after minutes, if the folder cannot be written.
    std::fs::create_dir_all(&options.out).map_err(|error| {
        Failure::new(FailureKind::System, format!("{}: {error}", options.out.display()))
            .with_remedy("name a folder that you may write to")
    })?;
    files::replace(&options.out.join("rows.csv"), row::csv(&[]).as_bytes())?;
    options.job_log.as_deref().map(|path| files::check(path, None)).transpose()?;
    let plan = plan(options);
    let mut names = options.pairs.clone();
    if names.is_empty() {
        let known = PAIRS.iter().map(|text| text.parse());
        names = known.collect::<Result<_, String>>().map_err(Failure::internal)?;
    }
    let bar = Progress::new(names.len() as u64 * sweep::steps(&plan), told);
    let mut measured = Measurement {
        schema: "trolley.measure/1",
        machine: machine(),
        command: command(options),
        pairs: Vec::new(),
        out: options.out.clone(),
    };
    for name in &names {
        let pair = name.load()?;
        let repeats = if options.quick { 5 } else { 7 };
        let bench = Bench::new(&pair, repeats, options.job_log.is_some())?;
        measured.pairs.push(sweep::sweep(&bench, &plan, &bar)?);
        // An interrupted sweep keeps its finished pairs.
        measured.write()?;
        if let (Some(path), Some(swept)) = (&options.job_log, measured.pairs.last()) {
            files::replace(path, log_csv(&swept.log).as_bytes())?;
        }
    }
    Ok(measured)
}

fn plan(options: &SweepOptions) -> Plan {
    let (depths, buffers) = if options.quick {
        (vec![1, 2, 4, 6, 8], vec![4, 16, 64])
    } else {
        (vec![0, 1, 2, 3, 4, 5, 6, 7, 8, 10, 12], vec![1, 2, 4, 8, 16, 32, 64, 128, 256])
    };
    let is_limited =
        options.dispatch_options.cache_bytes.or(options.dispatch_options.memory_budget).is_some();
    Plan {
        depths,
        buffers,
        passes: if options.quick { 1 } else { 2 },
        schemes: match options.schemes.as_slice() {
            [] => Scheme::ALL.to_vec(),
            named => named.to_vec(),
        },
        seed: options.seed,
        alpha: options.alpha,
        dispatch_options: DispatchOptions {
            transfer: options.transfer.unwrap_or_default(),
            ..options.dispatch_options
        },
        copies_too: options.transfer.is_none() && !is_limited,
    }
}

/// The command that repeats the sweep, without the machine's paths.
fn command(options: &SweepOptions) -> String {
    let pairs = options.pairs.iter().map(|pair| format!(" --pair {pair}")).collect::<String>();
    let quick = if options.quick { " --quick" } else { "" };
    let SweepOptions { seed, alpha, .. } = options;
    let mut command = format!("trolley measure{quick}{pairs} --seed {seed} --alpha {alpha}");
    let mut say = |name: &str, value: Option<String>| {
        if let Some(value) = value {
            command.push_str(&format!(" --{name} {value}"));
        }
    };
    let schemes: Vec<&str> = options.schemes.iter().map(|scheme| scheme.name()).collect();
    say("scheme", (!schemes.is_empty()).then(|| schemes.join(",")));
    say("transfer", options.transfer.map(|transfer| transfer.name().to_owned()));
    let DispatchOptions { linger_us, cache_bytes, memory_budget, .. } = options.dispatch_options;
    say("memory-budget", memory_budget.map(|bytes| bytes.to_string()));
    say("cache-bytes", cache_bytes.map(|bytes| bytes.to_string()));
    say("linger", (linger_us > 0).then(|| linger_us.to_string()));
    command + " --out DIR"
}

impl Measurement {
    fn write(&self) -> Result<(), Failure> {
        let Self { out, pairs, machine, command, .. } = self;
        let rows: Vec<Row> = pairs.iter().flat_map(|pair| pair.rows.clone()).collect();
        files::replace(&out.join("rows.csv"), row::csv(&rows).as_bytes())?;
        files::replace(&out.join("measure.json"), json(self)?.as_bytes())?;
        let page = page::page(pairs, machine, command);
        files::replace(&out.join("README.md"), page.as_bytes())?;
        for pair in pairs {
            for (kind, figure) in figures(pair) {
                let drawn = draw(&figure)?;
                let name = |end: &str| out.join(format!("{}-{kind}.{end}", pair.pair));
                files::replace(&name("svg"), drawn.svg.as_bytes())?;
                files::replace(&name("png"), &drawn.png)?;
            }
        }
        Ok(())
    }

    /// The summary for the terminal.
    #[must_use]
    pub fn text(&self) -> String {
        summary(&self.out, &self.pairs)
    }
}

/// Figures of the speed-up with and without copying, and of the transfer.
fn figures(pair: &Swept) -> [(&'static str, Figure); 3] {
    let line = |scheme: Scheme, transfer: TransferMode, value: fn(&Row) -> Option<f64>| {
        let points = curve(pair, scheme, transfer, value);
        Line {
            name: scheme.name().to_owned(),
            scheme: Some(scheme),
            points: points.into_iter().map(|(depth, value)| (f64::from(depth), value)).collect(),
        }
    };
    let about = format!(
        "{}: {} + {} triangles, {} poses, queue {}, batch {}",
        pair.pair,
        pair.triangles[0],
        pair.triangles[1],
        pair.poses,
        calibrate::QUEUES.capacity,
        calibrate::QUEUES.batch
    );
    let speed = |row: &Row| row.speed_up;
    let figure = |title: &str, y, lines| Figure {
        title: title.to_owned(),
        subtitle: about.clone(),
        x: "distribution depth",
        y,
        lines,
    };
    let copying = Scheme::ALL.map(|scheme| line(scheme, TransferMode::Copy, speed));
    let mut shared: Vec<Line> =
        Scheme::ALL.map(|scheme| line(scheme, TransferMode::ZeroCopy, speed)).into();
    let measured = pair.rows.iter().filter(|row| {
        (row.mode, row.workers, row.queue) == (Mode::Measured, 2, calibrate::QUEUES.capacity)
            && (row.scheme, row.transfer) == (Scheme::BestMatchLoad, TransferMode::ZeroCopy)
    });
    shared.push(Line {
        name: "measured, 2 workers".to_owned(),
        scheme: None,
        points: measured.map(|row| (f64::from(row.depth), row.speed_up)).collect(),
    });
    let moved = Scheme::ALL
        .map(|scheme| line(scheme, TransferMode::ZeroCopy, |row| row.relative_to_models));
    [
        (
            "speed-up",
            figure("Simulated: four virtual cores that copy sections", "speed-up", copying.into()),
        ),
        (
            "zero-copy",
            figure("Simulated: four virtual cores on one sealed store", "speed-up", shared),
        ),
        (
            "transfer",
            figure(
                "Simulated: section transfer on four virtual cores",
                "bytes moved / bytes of both bodies",
                moved.into(),
            ),
        ),
    ]
}

fn summary(out: &Path, swept: &[Swept]) -> String {
    let mut lines = Vec::new();
    for pair in swept {
        let best_speed_up = |mode, workers| {
            page::best(pair, mode, workers).map_or(String::from("–"), |(value, depth)| {
                format!("{value:.2} at depth {depth}")
            })
        };
        let predicted = page::errors(&pair.checks).map_or(String::new(), |[half, most]| {
            format!(" (predictions: median error {half:.0} %, worst {most:.0} %)")
        });
        lines.push(format!(
            "{}: alone {:.2} ms; 1 worker {}, 2 workers {}; 4 virtual cores {}{predicted}",
            pair.pair,
            pair.alone_ms,
            best_speed_up(Mode::Measured, 1),
            best_speed_up(Mode::Measured, 2),
            best_speed_up(Mode::SimulatedOwnCore, sweep::CORES),
        ));
    }
    lines.push(format!(
        "\nWritten to {}: README.md, rows.csv, measure.json, figures",
        out.display()
    ));
    lines.join("\n")
}
