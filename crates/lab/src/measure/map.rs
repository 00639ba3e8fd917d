//! The map: where each claim of the paper holds.
//!
//! ```text
//! subject ──▶ traces (plain walk, ours) ──▶ virtual cores: sheets ──▶ cells ──▶ verdicts, regions
//!         └─▶ calibrated costs ─────────────┘    (kept in DIR/sheets)     └──▶ advice
//!         └─▶ real workers that copy ──▶ predicted beside measured
//! ```
//!
//! Every claim is judged on every machine that can show it, at every cell: memory per core, cost
//! of a byte, what happens when memory runs out, cores, buffer, bodies, contact, and over sixteen
//! seeds of random match.

mod advice;
mod cells;
mod data;
mod fitted;
mod found;
mod grid;
mod machine;
mod page;
mod panels;
mod pictures;
mod real;
mod run;
mod table;
mod traced;
mod verdict;

use super::bench::Bench;
use super::calibrate::calibrate;
use super::document::{json, machine};
use super::sweep::FINE;
use crate::pair::{Pair, PairName};
use crate::progress::{Progress, SyncProgress};
use advice::{Advice, advice};
use cells::{Cell, Sheets, judge, region};
pub use found::Map;
use found::{Finding, Variant};
use grid::{BUFFER, CORES, Grid};
use machine::{GROUPS, Machine, PAPER, PAPER_BYTE_NS, SWAP_BYTE_NS};
use real::Checked;
use run::Traces;
use scenario::EngineSettings;
use simulate::Costs;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use table::{SheetKey, Subject};
use trolley::{Failure, FailureKind, files};
use verdict::{CLAIMS, Verdict};

/// What to map, and where to write the results.
#[derive(Clone, Debug)]
pub struct MapOptions {
    /// Use small bodies and few values of each axis: seconds instead of minutes.
    pub quick: bool,
    /// Folder for the page, figures and tables; created if missing. Finished sheets that it has are
    /// taken from there.
    pub out: PathBuf,
}

/// Repeats of every real run, of which the fastest counts.
const REPEATS: usize = 9;

/// Draws the map. `told` is called with the sheets and points done.
///
/// # Errors
///
/// If a body cannot be made, workers cannot be started, or a file cannot be written.
pub fn map(options: &MapOptions, told: SyncProgress<'_>) -> Result<Map, Failure> {
    let MapOptions { quick, out } = options;
    let kept = out.join("sheets");
    std::fs::create_dir_all(&kept).map_err(|error| {
        Failure::new(FailureKind::System, format!("{}: {error}", kept.display()))
            .with_remedy("name a folder that you may write to")
    })?;
    files::check(&out.join("README.md"), None)?;
    let grid = if *quick { Grid::quick() } else { Grid::full() };
    let subjects = grid.subjects();
    let middle = grid.sizes[grid.sizes.len() / 2];
    let is_checked = |subject: &Subject| !quick || (subject.size == middle && subject.is_deep);
    let is_run = subjects.iter().filter(|subject| is_checked(subject)).count();
    let points = real::COUNT * (is_run + grid.larger.len());
    let sheets: usize = subjects.iter().map(|subject| grid.sheets(*subject).len()).sum();
    let variants = VARIANTS.len() * subjects.len();
    let bar = Progress::new((points + sheets + variants) as u64, told);
    let mut map = Map {
        schema: "trolley.map/1",
        machine: machine(),
        command: format!("trolley measure --map{} --out DIR", if *quick { " --quick" } else { "" }),
        findings: Vec::new(),
        advice: Vec::new(),
        checked: Vec::new(),
        costs: BTreeMap::new(),
        plain_costs: [0.0; 4],
        advised: Vec::new(),
        variants: Vec::new(),
        cells: Vec::new(),
        sheets: Sheets::new(),
        grid: grid.clone(),
        out: out.clone(),
    };
    let mut traced: Vec<(Subject, Traces)> = Vec::new();
    // Costs of the first subject, which serve for all of a quick map.
    let mut first = None;
    for subject in subjects {
        let pair = load(subject)?;
        let repeats = match quick {
            true => 2,
            // Short runs can be repeated often.
            false if subject.size == grid.sizes[0] => 4 * REPEATS,
            false => REPEATS,
        };
        let bench = Bench::new(&pair, repeats, false)?;
        let (here, slower) = match first {
            Some(costs) if *quick => costs,
            _ => costs(&bench, subject, &kept)?,
        };
        first.get_or_insert((here, slower));
        if is_checked(&subject) {
            map.checked.extend(checked(&bench, subject, (&here, slower), &kept, &bar)?);
            if subject.is_deep && subject.size == middle {
                map.plain_costs = traced::plain_costs(&bench, &[0, 4, 8]);
            }
        }
        map.costs.insert(format!("{}-{}", subject.size, subject.contact()), here);
        let mut traces = Traces {
            plain: Vec::new(),
            wide: Vec::new(),
            model_bytes: bench.model_bytes(),
            paper: PAPER,
            here,
            swap_byte_ns: SWAP_BYTE_NS,
        };
        for depth in &grid.depths {
            traces.plain.push((*depth, traced::plain(&bench, *depth)));
            traces.wide.push((*depth, bench.trace(*depth)?));
        }
        let keys = grid.sheets(subject);
        let done = run::sheets(&keys, &traces, &grid, Some(&kept), &bar)?;
        map.sheets.extend(keys.into_iter().zip(done));
        traced.push((subject, traces));
    }
    for subject in grid.larger.iter().copied() {
        let (costs, points) = larger(subject, &kept, &bar)?;
        map.checked.extend(points);
        map.costs.insert(format!("{}-{}", subject.size, subject.contact()), costs);
    }
    map.variants = vary(&mut traced, &grid, &bar)?;
    map.cells = judge(&map.sheets, &grid);
    map.findings = findings(&map.cells, &grid);
    let default = (EngineSettings::DEFAULT.scheme, EngineSettings::DEFAULT.depth);
    map.advised = advice(&map.sheets, &grid, default);
    map.advice = map.advised.iter().map(Advice::sentence).collect();
    map.write()?;
    Ok(map)
}

/// The bodies of a subject, and their poses.
fn load(subject: Subject) -> Result<Pair, Failure> {
    let name = format!("sedan:{0},suv:{0},{1}", subject.size, subject.contact());
    name.parse::<PairName>().map_err(Failure::internal)?.load()
}

/// Costs and points of a contact that is not simulated.
fn larger(
    subject: Subject,
    kept: &Path,
    bar: &Progress<'_>,
) -> Result<(Costs, Vec<Checked>), Failure> {
    let pair = load(subject)?;
    // What is long cannot be repeated often, and what disturbs it is a smaller part.
    let bench = Bench::new(&pair, 2, false)?;
    let (here, slower) = costs(&bench, subject, kept)?;
    let points = checked(&bench, subject, (&here, slower), kept, bar)?;
    Ok((here, points))
}

/// This machine's costs, and how much longer its kernel takes in a worker: those of an interrupted
/// map, or measured and kept.
fn costs(bench: &Bench<'_>, subject: Subject, kept: &Path) -> Result<(Costs, f64), Failure> {
    let path = kept.join(format!("costs-{}-{}.json", subject.size, subject.contact()));
    let known = std::fs::read_to_string(&path).ok();
    if let Some(costs) = known.and_then(|text| serde_json::from_str(&text).ok()) {
        return Ok(costs);
    }
    let found = fitted::fitted(bench, &calibrate(bench, FINE)?)?;
    files::replace(&path, json(&found)?.as_bytes())?;
    Ok(found)
}

/// The points that real workers ran: those of an interrupted map, or run and kept.
fn checked(
    bench: &Bench<'_>,
    subject: Subject,
    costs: (&Costs, f64),
    kept: &Path,
    bar: &Progress<'_>,
) -> Result<Vec<Checked>, Failure> {
    let path = kept.join(format!("checked-{}-{}.json", subject.size, subject.contact()));
    let known = std::fs::read_to_string(&path).ok();
    if let Some(points) = known.and_then(|text| serde_json::from_str::<Vec<Checked>>(&text).ok())
        && points.len() == real::COUNT
    {
        bar.add(real::COUNT as u64);
        return Ok(points);
    }
    let points = real::check(bench, subject, costs, &|| bar.add(1))?;
    files::replace(&path, json(&points)?.as_bytes())?;
    Ok(points)
}

/// Changes of the costs of the paper's machine: what they are, tests, messages, swap.
const VARIANTS: [(&str, [f64; 3]); 7] = [
    ("as it stands", [1.0, 1.0, 1.0]),
    ("tests × ½", [0.5, 1.0, 1.0]),
    ("tests × 2", [2.0, 1.0, 1.0]),
    ("messages × ½", [1.0, 0.5, 1.0]),
    ("messages × 2", [1.0, 2.0, 1.0]),
    ("a byte beyond memory × ½", [1.0, 1.0, 0.5]),
    ("a byte beyond memory × 2", [1.0, 1.0, 2.0]),
];

/// The paper's machine with other costs, at its own cost of a byte.
fn vary(
    traced: &mut [(Subject, Traces)],
    grid: &Grid,
    bar: &Progress<'_>,
) -> Result<Vec<Variant>, Failure> {
    let grid = Grid {
        bytes: vec![PAPER_BYTE_NS],
        cores: vec![CORES],
        buffers: vec![BUFFER],
        more_buffers: Vec::new(),
        ..grid.clone()
    };
    let mut variants = Vec::new();
    for (words, [tests, messages, swap]) in VARIANTS {
        let mut sheets = Sheets::new();
        for (subject, traces) in traced.iter_mut() {
            traces.swap_byte_ns = SWAP_BYTE_NS * swap;
            traces.paper = Costs {
                job_ns: PAPER.job_ns * tests,
                box_ns: PAPER.box_ns * tests,
                triangle_ns: PAPER.triangle_ns * tests,
                hit_ns: PAPER.hit_ns * tests,
                descent_ns: PAPER.descent_ns * tests,
                send_ns: PAPER.send_ns * messages,
                batch_ns: PAPER.batch_ns * messages,
                place_ns: PAPER.place_ns * messages,
                take_ns: PAPER.take_ns * messages,
                flight_ns: PAPER.flight_ns * messages,
                section_ns: PAPER.section_ns * messages,
                ship_section_ns: PAPER.ship_section_ns * messages,
                ..PAPER
            };
            let is_asked = |key: &SheetKey| key.machine == Machine::Paper && key.is_single;
            let keys: Vec<SheetKey> = grid.sheets(*subject).into_iter().filter(is_asked).collect();
            let done = run::sheets(&keys, traces, &grid, None, bar)?;
            sheets.extend(keys.into_iter().zip(done));
        }
        variants.push(Variant { words, cells: judge(&sheets, &grid) });
    }
    Ok(variants)
}

fn findings(cells: &[Cell], grid: &Grid) -> Vec<Finding> {
    let mut findings = Vec::new();
    for (claim, _) in CLAIMS {
        for (machine, is_single) in GROUPS {
            let is_asked = |cell: &&Cell| {
                (cell.claim, cell.machine, cell.is_single) == (claim, machine, is_single)
            };
            let cells: Vec<&Cell> = cells.iter().filter(is_asked).collect();
            let shares = cells::Shares::over(cells.iter().copied());
            if shares.all() == 0 {
                continue;
            }
            let mut regions = Vec::new();
            for (verdict, words) in [
                (Verdict::Holds, "It holds"),
                (Verdict::Fails, "It does not hold"),
                (Verdict::Open, "Nobody can tell"),
            ] {
                if let Some(found) = region(&cells, verdict, grid) {
                    regions.push(format!(
                        "{words} where {}: in {:.0} % of the cells there, which are {:.0} % of all \
                         such cells.",
                        found.words,
                        100.0 * found.inside,
                        100.0 * found.covered
                    ));
                }
            }
            findings.push(Finding {
                claim,
                machine,
                is_single,
                verdict: shares.verdict(),
                cells: shares.all(),
                holds: shares.holds,
                fails: shares.fails,
                open: shares.open,
                regions,
            });
        }
    }
    findings
}

impl Map {
    fn write(&self) -> Result<(), Failure> {
        let write = |name: &str, bytes: &[u8]| files::replace(&self.out.join(name), bytes);
        write("verdicts.csv", data::verdicts_csv(self).as_bytes())?;
        write("verdicts.parquet", &data::verdicts_table(self).parquet()?)?;
        let pays = data::pays_table(self);
        write("pays.csv", pays.csv().as_bytes())?;
        write("pays.parquet", &pays.parquet()?)?;
        write("points.parquet", &data::points_table(self).parquet()?)?;
        write("map.json", json(self)?.as_bytes())?;
        for (name, svg) in pictures::maps(self) {
            write(&name, svg.as_bytes())?;
        }
        for (name, png) in pictures::lines(self)? {
            write(&name, &png)?;
        }
        write("README.md", page::page(self).as_bytes())
    }

    /// The summary for the terminal.
    #[must_use]
    pub fn text(&self) -> String {
        let mut lines = Vec::new();
        for (claim, words) in CLAIMS {
            lines.push(format!("({claim}) {words}"));
            for finding in self.findings.iter().filter(|finding| finding.claim == claim) {
                lines.push(format!("    {}: {}", finding.title(), finding.verdict));
            }
        }
        lines.push(String::new());
        let advised = self.advised.iter().zip(&self.advice);
        lines.extend(advised.map(|(advice, said)| format!("{}: {said}", advice.machine.title())));
        if let (Some(time), Some(bytes)) =
            (real::errors(&self.checked, 0), real::errors(&self.checked, 1))
        {
            lines.push(format!(
                "\nPredicted against measured, {} points: time {:.0} % in the median, {:.0} % at \
                 worst; bytes {:.1} %, {:.0} %",
                self.checked.len(),
                100.0 * time[0],
                100.0 * time[1],
                100.0 * bytes[0],
                100.0 * bytes[1]
            ));
        }
        lines.push(format!("Written to {}: README.md, figures, tables", self.out.display()));
        lines.join("\n")
    }
}
