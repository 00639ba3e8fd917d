//! The page: who is wrong and how slow in total, the gates, and all encounters.

use super::{HALVING, Line, OURS};
use crate::compare::page::{figures, grouped, table};
use comfy_table::CellAlignment;
use std::collections::BTreeMap;
use std::fmt;

/// Farther from ours than this is wrong (m): the resolution of halving.
const RIGHT_M: f64 = 1e-3;

/// Everything that the page is made from.
pub(super) struct Page<'a> {
    pub(super) command: String,
    pub(super) machine: &'a [(&'static str, String)],
    pub(super) versions: &'a [(&'static str, String)],
    /// The names of the encounters of each family.
    pub(super) families: &'a BTreeMap<&'static str, Vec<String>>,
    pub(super) lines: &'a [Line],
    /// Rows of cars that turn, as the bench printed them; may be empty.
    pub(super) motions: &'a str,
    /// What was left out, and why.
    pub(super) skipped: &'a [String],
}

impl fmt::Display for Page<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "# First contact beside other libraries\n\nWritten by `{}`.", self.command)?;
        writeln!(f, "\n{HOW_TO_READ}\n")?;
        let mut head = table(&["measured on", ""]);
        for (name, value) in self.machine.iter().chain(self.versions) {
            head.add_row([*name, value]);
        }
        for column in head.column_iter_mut() {
            column.set_cell_alignment(CellAlignment::Left);
        }
        writeln!(f, "{head}\n")?;
        self.skipped.iter().try_for_each(|why| writeln!(f, "- {why}"))?;
        self.checks(f)?;
        self.totals(f)?;
        self.families.iter().try_for_each(|(family, names)| self.family(f, family, names))?;
        match self.motions {
            "" => Ok(()),
            rows => write!(f, "\n## Cars that drive and turn for 3 s\n\n{MOTIONS}\n\n{rows}"),
        }
    }
}

impl Page<'_> {
    fn of(&self, peer: &str, name: &str) -> Option<&Line> {
        self.lines.iter().find(|line| line.peer == peer && line.name == name)
    }

    /// All but ours, in the order in which they ran.
    fn peers(&self) -> Vec<&str> {
        let mut peers: Vec<&str> = Vec::new();
        for line in self.lines {
            if line.peer != OURS && !peers.contains(&line.peer.as_str()) {
                peers.push(&line.peer);
            }
        }
        peers
    }

    /// Lines of a peer with ours of the same encounter.
    fn pairs(&self, peer: &str) -> Vec<(&Line, &Line)> {
        let theirs = self.lines.iter().filter(|line| line.peer == peer);
        theirs.filter_map(|line| Some((self.of(OURS, &line.name)?, line))).collect()
    }

    fn checks(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ours = || self.lines.iter().filter(|line| line.peer == OURS);
        let sum = |of: fn(&Line) -> Option<u64>| ours().filter_map(of).sum::<u64>();
        let brute: Vec<bool> = ours().filter_map(|line| line.effort.brute_force).collect();
        writeln!(
            f,
            "\nOf our {} answers, {} exact poses before first contact, or along the whole way \
             where there is none, were tried: {} touch. In {} encounters every triangle was held \
             against every other: the same bits in {}.",
            ours().count(),
            grouped(sum(|line| line.effort.poses)),
            sum(|line| line.effort.touching),
            brute.len(),
            brute.iter().filter(|equals| **equals).count()
        )
    }

    fn totals(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "\n## In total\n")?;
        let mut table = table(&[
            "",
            "contacts",
            "missed",
            "early",
            "at most mm",
            "late",
            "at most mm",
            "times slower",
            "passes",
            "false",
            "times slower",
        ]);
        for peer in self.peers() {
            let all = self.pairs(peer);
            let is_contact = |pair: &&(&Line, &Line)| pair.0.first_contact_m.is_some();
            let contacts: Vec<_> = all.iter().filter(is_contact).collect();
            let passes: Vec<_> = all.iter().filter(|pair| !is_contact(pair)).collect();
            let offs: Vec<f64> =
                contacts.iter().filter_map(|(ours, line)| off(ours, line)).collect();
            let early = offs.iter().filter(|off| **off < -RIGHT_M);
            let late = offs.iter().filter(|off| **off > RIGHT_M);
            let most = |sign: f64| offs.iter().map(|off| sign * off).fold(0.0_f64, f64::max);
            let missed = contacts.len() - offs.len();
            let invented = passes.iter().filter(|(_, line)| line.first_contact_m.is_some());
            table.add_row([
                peer.to_owned(),
                contacts.len().to_string(),
                missed.to_string(),
                early.count().to_string(),
                figures(1e3 * most(-1.0)),
                late.count().to_string(),
                figures(1e3 * most(1.0)),
                slower(&contacts),
                passes.len().to_string(),
                invented.count().to_string(),
                slower(&passes),
            ]);
        }
        writeln!(f, "{table}")
    }

    fn family(&self, f: &mut fmt::Formatter<'_>, family: &str, names: &[String]) -> fmt::Result {
        writeln!(f, "\n## {family}\n")?;
        let peers = self.peers();
        let mut head = vec!["", "first contact m", "µs", "boxes", "pairs", "exact", "tests"];
        head.extend(&peers);
        let mut table = table(&head);
        for name in names {
            let Some(ours) = self.of(OURS, name) else { continue };
            let short = name.strip_prefix(family).unwrap_or(name).trim_start_matches('-');
            let number = |n: Option<u64>| n.map_or(String::new(), grouped);
            let tests = |line: &Line| Some(line.effort.boxes? + line.effort.pairs?);
            let share = self
                .of(HALVING, name)
                .and_then(|old| Some(tests(ours)? as f64 / tests(old)?.max(1) as f64));
            let mut row = vec![
                short.to_owned(),
                ours.first_contact_m.map_or("never".into(), |travel| format!("{travel:.6}")),
                figures(1e3 * ours.query_ms),
                number(ours.effort.boxes),
                number(ours.effort.pairs),
                number(ours.effort.exact_tests),
                share.map_or(String::new(), figures),
            ];
            row.extend(peers.iter().map(|peer| cell(ours, self.of(peer, name))));
            table.add_row(row);
        }
        writeln!(f, "{table}")
    }
}

/// How much later than ours (m), if both touch.
fn off(ours: &Line, line: &Line) -> Option<f64> {
    Some(line.first_contact_m? - ours.first_contact_m?)
}

/// How many times slower: median, least and most.
fn slower(pairs: &[&(&Line, &Line)]) -> String {
    let mut ratios: Vec<f64> =
        pairs.iter().map(|(ours, line)| line.query_ms / ours.query_ms).collect();
    ratios.sort_by(f64::total_cmp);
    let (Some(least), Some(most)) = (ratios.first(), ratios.last()) else { return "-".into() };
    let median = ratios[ratios.len() / 2];
    format!("{} ({} to {})", figures(median), figures(*least), figures(*most))
}

/// An answer and its time beside ours.
fn cell(ours: &Line, line: Option<&Line>) -> String {
    let Some(line) = line else { return "not run".into() };
    let answer = match (ours.first_contact_m, line.first_contact_m) {
        (None, None) => "never".to_owned(),
        (None, Some(_)) => "FALSE".to_owned(),
        (Some(_), None) => "MISSED".to_owned(),
        (Some(ours), Some(theirs)) => format!("{:+.3}", 1e3 * (theirs - ours)),
    };
    format!("{answer}, {}", figures(line.query_ms / ours.query_ms))
}

const MOTIONS: &str = "\
Two cars, each on an arc, known every tenth of a second and moving steadily in between; contact
to 1 mm. At some time B is 12 to 25 m beside A (`far`), would stand within it (`contact`), or
passes as an oncoming car with some decimetres between (`near`); or it stays centimetres from
A's flank, turned by 7 degrees (`slide`). Times are medians of nine runs of a query on one core;
`tests` are of boxes and of triangles.";

const HOW_TO_READ: &str = "\
When a body that moves along a straight line first touches another one. A column of another
program has how many millimetres later than ours its contact is (negative: earlier), MISSED where
it finds none and FALSE where there is none, and how many times as long it takes. Up to a
millimetre off counts as right. `tests` is our number of tests, of boxes and pairs, over that of
`halving`: 16 poses and halvings down to 1 mm, as this project sought contact before. Times are
medians of runs of one query, of 25 for us and `halving` in turns, of up to five for other
programs, on one core, one program after the other, without building trees; `not run` is what did
not fit in the time for a family. parry3d computes in f32 and stops short of contact by a margin of
its own; FCL's solvers run as they come, but for 1,000 iterations; ipctk answers with a safe step,
so earlier is right for it. The names of passes say how wide the gap is.";
