//! The page: per case a table of all rows, at rest, moving and with cold caches; then two threads,
//! and growth with size.

use super::cases::Case;
use super::log::{Log, Measured};
use super::row::{Row, Section};
use comfy_table::{CellAlignment, Table, presets};
use std::collections::BTreeMap;
use std::fmt;

/// Everything that the page is made from.
#[derive(Debug)]
pub(crate) struct Page<'a> {
    pub(crate) machine: &'a [(&'static str, String)],
    /// Versions of the installed libraries.
    pub(crate) versions: &'a [(&'static str, String)],
    pub(crate) cases: &'a [Case],
    pub(crate) rows: &'a [Row],
    /// The exact answers, by case; empty without the oracle.
    pub(crate) truths: &'a BTreeMap<String, Measured>,
    pub(crate) log: &'a Log,
    pub(crate) rounds: u32,
    /// What was left out, and why.
    pub(crate) skipped: &'a [String],
}

impl fmt::Display for Page<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.head(f)?;
        for (section, title) in PINNED {
            if self.has(*section) {
                writeln!(f, "\n## {title}")?;
                self.cases.iter().try_for_each(|case| self.case(f, *section, case))?;
            }
        }
        if self.has(Section::Threads) {
            self.threads(f)?;
        }
        self.growth(f)
    }
}

impl Page<'_> {
    /// The rows of ours whose answer is not the exact one, with their cases.
    pub(crate) fn wrong_of_ours(&self) -> Vec<String> {
        let mut wrong = Vec::new();
        for case in self.cases {
            let Some(truth) = self.truths.get(&case.name) else { continue };
            for row in self.rows.iter().filter(|row| row.is_ours()) {
                let measured = self.log.median(row, &case.name);
                if measured.is_some_and(|measured| !measured.agrees(truth)) {
                    wrong.push(format!("{} on {}", row.name, case.name));
                }
            }
        }
        wrong
    }

    fn has(&self, section: Section) -> bool {
        self.rows_of(section)
            .any(|row| self.cases.iter().any(|case| self.log.median(row, &case.name).is_some()))
    }

    fn rows_of(&self, section: Section) -> impl Iterator<Item = &Row> {
        self.rows.iter().filter(move |row| row.section == section)
    }

    fn head(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "# Trolley beside other libraries")?;
        writeln!(f, "\nWritten by `cargo x compare`, {} rounds.", self.rounds)?;
        writeln!(f, "\n{HOW_TO_READ}\n")?;
        let mut table = table(&["measured on", ""]);
        for (name, value) in self.machine.iter().chain(self.versions) {
            table.add_row([*name, value]);
        }
        for column in table.column_iter_mut() {
            column.set_cell_alignment(CellAlignment::Left);
        }
        writeln!(f, "{table}")?;
        if !self.skipped.is_empty() {
            writeln!(f)?;
        }
        self.skipped.iter().try_for_each(|why| writeln!(f, "- {why}"))
    }

    fn case(&self, f: &mut fmt::Formatter<'_>, section: Section, case: &Case) -> fmt::Result {
        let truth = self.truths.get(&case.name);
        let hits = truth.map_or("intersecting pairs unknown".into(), |truth| {
            format!("{} intersecting pairs", grouped(truth.pairs))
        });
        writeln!(f, "\n### {}: {} triangles, {hits}\n", case.name, grouped(case.triangles))?;
        let mut table =
            table(&["", "query ms", "ratio", "new pose ms", "with pose", "build ms", "answer"]);
        let lines: Vec<(&Row, Measured)> = self
            .rows_of(section)
            .filter_map(|row| Some((row, self.log.median(row, &case.name)?)))
            .collect();
        let Some((_, ours)) = lines.iter().find(|(row, _)| row.is_ours()).or(lines.first()) else {
            return writeln!(f, "Nothing ran.");
        };
        let with_pose = |measured: &Measured| measured.pose_ms + measured.query_ms;
        for (row, measured) in &lines {
            table.add_row([
                row.name.clone(),
                figures(measured.query_ms),
                figures(measured.query_ms / ours.query_ms),
                figures(measured.pose_ms),
                figures(with_pose(measured) / with_pose(ours)),
                figures(measured.build_ms),
                answer(measured, truth),
            ]);
        }
        if let Some(truth) = truth.filter(|_| section == Section::Warm) {
            table.add_row([
                "cgal, the oracle, once".to_owned(),
                figures(truth.query_ms),
                figures(truth.query_ms / ours.query_ms),
                String::new(),
                String::new(),
                figures(truth.build_ms),
                "by definition".to_owned(),
            ]);
        }
        writeln!(f, "{table}")
    }

    /// Rows on one thread and on two stand one after the other half of their section.
    fn threads(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "\n## Two threads, not pinned\n")?;
        let mut table = table(&["", "", "1 thread ms", "2 threads ms", "gain", "answer"]);
        let rows: Vec<&Row> = self.rows_of(Section::Threads).collect();
        let (ones, twos) = rows.split_at(rows.len() / 2);
        for case in self.cases {
            for (one, two) in ones.iter().zip(twos) {
                let measured = |row: &Row| self.log.median(row, &case.name);
                let (Some(one), Some(two)) = (measured(one), measured(two)) else { continue };
                table.add_row([
                    case.name.clone(),
                    two.peer.clone(),
                    figures(one.query_ms),
                    figures(two.query_ms),
                    figures(one.query_ms / two.query_ms),
                    answer(&two, self.truths.get(&case.name)),
                ]);
            }
        }
        writeln!(f, "{table}")
    }

    /// Time per triangle and per hit over the sizes of one family of cases.
    fn growth(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut families: BTreeMap<String, Vec<&Case>> = BTreeMap::new();
        for case in self.cases {
            if let Some(family) = family(&case.name) {
                families.entry(family).or_default().push(case);
            }
        }
        families.retain(|_, cases| cases.len() > 1);
        if families.is_empty() {
            return Ok(());
        }
        writeln!(f, "\n## Growth\n\nWarm queries: ns per triangle of both bodies / ns per hit.")?;
        for (family, mut cases) in families {
            cases.sort_by_key(|case| case.triangles);
            let mut head = vec![family.as_str()];
            let sizes: Vec<String> = cases.iter().map(|case| grouped(case.triangles)).collect();
            head.extend(sizes.iter().map(String::as_str));
            let mut table = table(&head);
            for row in self.rows_of(Section::Warm) {
                let per = |case: &&Case| {
                    let Some(measured) = self.log.median(row, &case.name) else {
                        return String::new();
                    };
                    let ns = 1e6 * measured.query_ms;
                    let hits = self.truths.get(&case.name).map(|truth| truth.pairs);
                    let per_hit = hits.filter(|hits| *hits > 0).map(|hits| ns / hits as f64);
                    let per_hit = per_hit.map_or("-".into(), figures);
                    format!("{} / {per_hit}", figures(ns / case.triangles as f64))
                };
                let mut line = vec![row.name.clone()];
                line.extend(cases.iter().map(per));
                table.add_row(line);
            }
            writeln!(f, "\n{table}")?;
        }
        Ok(())
    }
}

/// The sections with a table per case.
const PINNED: &[(Section, &str)] = &[
    (Section::Warm, "One core, warm caches\n\nThe same query again and again."),
    (
        Section::Moving,
        "One core, a moving body\n\n\
         B stands up to 4 mm before or behind its pose for each query: Embree rebuilds before it.\n\
         Faces that are in one plane at its pose are not elsewhere.",
    ),
    (Section::Cold, "One core, cold caches\n\n64 MiB are written before each query."),
];

const HOW_TO_READ: &str = "\
All intersecting triangle pairs of two posed bodies (or, where it says so, the sets of triangles
hit, or whether any is). Times are medians in milliseconds over the rounds, in which all rows took
turns; trust the ratios, not the absolutes. `ratio` is the query against the first row; `with pose`
is the same with what a new pose costs before it can be queried: a rebuild of B for Embree, next to
nothing for the others. `build` is of both trees. No column includes reading files. Embree and parry
find candidates only: Embree's are decided by a test in plain doubles, parry's by our exact one.
A processor learns the branches of a query that is only repeated, and a moving body never repeats
one: hence a section for each.";

pub(super) fn table(head: &[&str]) -> Table {
    let mut table = Table::new();
    table.load_style(presets::ASCII_MARKDOWN).set_header(head);
    for column in table.column_iter_mut().skip(1) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table
}

fn answer(measured: &Measured, truth: Option<&Measured>) -> String {
    match truth {
        None => "unchecked".into(),
        Some(truth) if measured.agrees(truth) => "right".into(),
        Some(_) if measured.question == "sets" => "WRONG".into(),
        Some(_) => format!("WRONG: {} pairs", grouped(measured.pairs)),
    }
}

/// The family of a case: its name without the part that is a size, such as 10k or 1m.
pub(super) fn family(name: &str) -> Option<String> {
    let is_size = |part: &str| {
        let digits = part.strip_suffix(['k', 'm']);
        digits.is_some_and(|d| !d.is_empty() && d.bytes().all(|byte| byte.is_ascii_digit()))
    };
    let parts: Vec<&str> = name.split('-').filter(|part| !is_size(part)).collect();
    let family = parts.join("-");
    (family != name).then_some(family)
}

/// A number as people compare it: three significant digits, no more than four decimals.
pub(super) fn figures(x: f64) -> String {
    match x.abs() {
        x if x >= 100.0 => format!("{x:.0}"),
        x if x >= 10.0 => format!("{x:.1}"),
        x if x >= 1.0 => format!("{x:.2}"),
        x if x >= 0.1 => format!("{x:.3}"),
        0.0 => "0".into(),
        x => format!("{x:.4}"),
    }
}

/// With a comma between thousands.
pub(super) fn grouped(n: u64) -> String {
    let digits = n.to_string();
    let mut text = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}
