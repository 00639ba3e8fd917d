//! `trolley measure`: the seed's experiment on real bodies: schemes, depths, buffers, transfer.
//!
//! ```text
//! pair ──▶ bench: real runs ──▶ calibrate ──▶ Costs ─┐
//!            └── traces ─────────────────────────────┴▶ simulate ──▶ rows ──▶ claims, page
//! ```
//!
//! Every run, in this process or by workers, must find the same triangles, or nothing is written.

mod bench;
mod calibrate;
mod claims;
mod figure;
mod page;
pub(crate) mod pair;
mod row;
mod sweep;
mod swept;

use crate::args::Output;
use crate::progress::Progress;
use crate::transfer::Transfer;
use crate::{print, transfer};
use bench::Bench;
use claims::{Claim, claims, curve};
use clap::Args as ClapArgs;
use diagnostic::{Failure, Kind};
use figure::{Figure, Line, draw};
use pair::PairName;
use row::{Mode, Row};
use scenario::Scheme;
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use sweep::{Plan, sweep};
use swept::Swept;

pub(crate) const EXAMPLES: &str = "\
Examples:
  trolley measure --quick --out results
  trolley measure --pair sedan:100000,suv:100000,deep --pair sedan:100000,suv:100000,scratch
  trolley measure --pair sedan.trolley,suv.trolley,deep --out results

A pair is A,B,POSES: bodies as model files, or shape:triangles for generated ones; poses as a file
(six lines, as for trolley intersect), or deep or scratch: B comes from sixteen directions until it
is 0.5 m, or 0.01 m, into A. The claim about two contacts compares deep and scratch of the same
bodies.";

/// What is measured where nothing is named.
const PAIRS: [&str; 2] = ["sedan:100000,suv:100000,deep", "sedan:100000,suv:100000,scratch"];

#[derive(Debug, ClapArgs)]
pub(crate) struct MeasureArgs {
    /// Fewer depths, buffers and repeats: a minute, and wider margins.
    #[arg(long)]
    quick: bool,
    /// Bodies and poses, A,B,POSES; may be given several times.
    #[arg(long, value_name = "A,B,POSES")]
    pair: Vec<PairName>,
    /// Folder for tables, figures and the page; made if it is not there.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Seed of random match.
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    /// Weight of the match against the load in best-match-load, 0 to 1.
    #[arg(long, default_value_t = 0.5)]
    alpha: f64,
}

#[derive(Debug, ClapArgs)]
pub(crate) struct CalibrateArgs {
    /// Bodies and poses, A,B,POSES, as for trolley measure.
    #[arg(long, value_name = "A,B,POSES", default_value = PAIRS[0])]
    pair: PairName,
    /// How often each run is repeated.
    #[arg(long, value_name = "N", default_value_t = 7,
          value_parser = clap::value_parser!(u16).range(1..=1000))]
    repeat: u16,
    /// Write it to this file besides.
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

/// Prints what each step costs on this machine.
pub(crate) fn calibrate(args: &CalibrateArgs) -> Result<ExitCode, Failure> {
    // Nobody wants to hear after the measurement that its file cannot be written.
    args.out.as_deref().map(transfer::ready).transpose()?;
    let pair = args.pair.load()?;
    let bench = Bench::new(&pair, usize::from(args.repeat))?;
    let costs = calibrate::calibrate(&bench, sweep::FINE)?;
    let text = print::json(&costs)?;
    if let Some(path) = &args.out {
        transfer::write(path, format!("{text}\n").as_bytes())?;
    }
    print::out(&text)
}

#[derive(Serialize)]
struct Document<'d> {
    schema: &'static str,
    machine: &'d str,
    command: &'d str,
    claims: &'d [Claim],
    pairs: &'d [Swept],
}

pub(crate) fn run(args: &MeasureArgs, output: &Output) -> Result<ExitCode, Failure> {
    if !(0.0..=1.0).contains(&args.alpha) {
        let fault = format!("--alpha is {}", args.alpha);
        return Err(Failure::setting(fault).with_remedy("--alpha may be 0 to 1"));
    }
    // Nobody wants to hear after minutes that the folder cannot be written.
    std::fs::create_dir_all(&args.out).map_err(|error| {
        Failure::new(Kind::System, format!("{}: {error}", args.out.display()))
            .with_remedy("name a folder that you may write to")
    })?;
    transfer::write(&args.out.join("rows.csv"), row::csv(&[]).as_bytes())?;
    let plan = plan(args);
    let mut names = args.pair.clone();
    if names.is_empty() {
        let known = PAIRS.iter().map(|text| text.parse());
        names = known.collect::<Result<_, String>>().map_err(Failure::internal)?;
    }
    let command = command(args);
    let bar = Progress::new("measuring", names.len() as u64 * sweep::steps(&plan), output);
    let mut swept = Vec::new();
    for name in &names {
        let pair = name.load()?;
        let bench = Bench::new(&pair, if args.quick { 5 } else { 7 })?;
        swept.push(sweep(&bench, &plan, &bar)?);
        // Whoever stops it here keeps what is finished.
        write_all(&args.out, &swept, &claims(&swept), &command)?;
    }
    drop(bar);
    let claims = claims(&swept);
    if output.json {
        return print::out(&document(&swept, &claims, &command)?);
    }
    print::out(&summary(&args.out, &swept, &claims))
}

fn plan(args: &MeasureArgs) -> Plan {
    let (depths, buffers) = if args.quick {
        (vec![1, 2, 4, 6, 8], vec![4, 16, 64])
    } else {
        (vec![0, 1, 2, 3, 4, 5, 6, 7, 8, 10, 12], vec![1, 2, 4, 8, 16, 32, 64, 128, 256])
    };
    let passes = if args.quick { 1 } else { 2 };
    Plan { depths, buffers, passes, seed: args.seed, alpha: args.alpha }
}

/// The command as it can be given again, without the machine's paths.
fn command(args: &MeasureArgs) -> String {
    let pairs = args.pair.iter().map(|pair| format!(" --pair {pair}")).collect::<String>();
    let quick = if args.quick { " --quick" } else { "" };
    format!("trolley measure{quick}{pairs} --seed {} --alpha {} --out DIR", args.seed, args.alpha)
}

/// The machine in one sentence.
fn machine() -> String {
    let text = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = text.lines().find(|line| line.starts_with("model name"));
    let model = model.and_then(|line| line.split_once(": ")).map_or("unknown processor", |m| m.1);
    let cores = runtime::affinity::allowed_cores().len();
    format!(
        "Machine: {model}, {cores} cores granted; workers pinned to cores in turn, the coordinator \
         wherever there is room. Hardware counters: {}.",
        hardware()
    )
}

/// Whether this machine counts instructions and cache misses.
fn hardware() -> String {
    match runtime::counters::Counters::of(std::process::id()) {
        Ok(_) => "available, see `run.workers` of `trolley rank --json`".to_owned(),
        Err(error) => match coordinator::Hardware::from(error) {
            coordinator::Hardware::NotAvailable(why) => {
                format!("{why}; transfer is counted by the ledger and by the channels")
            }
            coordinator::Hardware::Counted { .. } => String::new(),
        },
    }
}

fn document(swept: &[Swept], claims: &[Claim], command: &str) -> Result<String, Failure> {
    let machine = &machine();
    let document = Document { schema: "trolley.measure/1", machine, command, claims, pairs: swept };
    print::json(&document)
}

fn write_all(out: &Path, swept: &[Swept], claims: &[Claim], command: &str) -> Result<(), Failure> {
    let rows: Vec<Row> = swept.iter().flat_map(|pair| pair.rows.clone()).collect();
    transfer::write(&out.join("rows.csv"), row::csv(&rows).as_bytes())?;
    transfer::write(&out.join("measure.json"), document(swept, claims, command)?.as_bytes())?;
    let page = page::page(swept, claims, &machine(), command);
    transfer::write(&out.join("README.md"), page.as_bytes())?;
    for pair in swept {
        for (kind, figure) in figures(pair) {
            let drawn = draw(&figure)?;
            let name = |end: &str| out.join(format!("{}-{kind}.{end}", pair.pair));
            transfer::write(&name("svg"), drawn.svg.as_bytes())?;
            transfer::write(&name("png"), &drawn.png)?;
        }
    }
    Ok(())
}

/// Speed-up when copying, speed-up without, and transfer.
fn figures(pair: &Swept) -> [(&'static str, Figure); 3] {
    let line = |scheme: Scheme, transfer: Transfer, value: fn(&Row) -> Option<f64>| {
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
    let copying = Scheme::ALL.map(|scheme| line(scheme, Transfer::Copy, speed));
    let mut shared: Vec<Line> =
        Scheme::ALL.map(|scheme| line(scheme, Transfer::ZeroCopy, speed)).into();
    let measured = pair.rows.iter().filter(|row| {
        (row.mode, row.workers, row.queue) == (Mode::Measured, 2, calibrate::QUEUES.capacity)
            && (row.scheme, row.transfer) == (Scheme::BestMatchLoad, Transfer::ZeroCopy)
    });
    shared.push(Line {
        name: "measured, 2 workers".to_owned(),
        scheme: None,
        points: measured.map(|row| (f64::from(row.depth), row.speed_up)).collect(),
    });
    let moved =
        Scheme::ALL.map(|scheme| line(scheme, Transfer::ZeroCopy, |row| row.relative_to_models));
    [
        (
            "speed-up",
            figure("Four virtual cores that copy sections", "speed-up (simulated)", copying.into()),
        ),
        ("zero-copy", figure("Four virtual cores on one sealed store", "speed-up", shared)),
        (
            "transfer",
            figure(
                "Section transfer on four virtual cores",
                "bytes moved / bytes of both bodies",
                moved.into(),
            ),
        ),
    ]
}

/// What the person at the terminal reads.
fn summary(out: &Path, swept: &[Swept], claims: &[Claim]) -> String {
    let mut lines = Vec::new();
    for pair in swept {
        let of = |mode, workers| {
            page::best(pair, mode, workers).map_or(String::from("–"), |(value, depth)| {
                format!("{value:.2} at depth {depth}")
            })
        };
        lines.push(format!(
            "{}: alone {:.2} ms; 1 worker {}, 2 workers {}; 4 virtual cores {} (predictions: \
             median error {:.0} %, worst {:.0} %)",
            pair.pair,
            pair.alone_ms,
            of(Mode::Measured, 1),
            of(Mode::Measured, 2),
            of(Mode::SimulatedOwnCore, sweep::CORES),
            100.0 * page::middle(&pair.checks),
            100.0 * page::worst(&pair.checks)
        ));
    }
    lines.push(String::new());
    for claim in claims {
        let verdict = match claim.holds {
            Some(true) => "holds",
            Some(false) => "does not hold",
            None => "cannot tell",
        };
        lines.push(format!("({}) {}: {verdict}", claim.letter, claim.claim));
    }
    lines.push(format!(
        "\nWritten to {}: README.md, rows.csv, measure.json, figures",
        out.display()
    ));
    lines.join("\n")
}
