//! Every claim at every cell of the map, and in which region it holds.

use super::grid::{BUFFER, Grid};
use super::machine::Machine;
use super::table::{Beyond, Curves, Sheet, SheetKey, Subject};
use super::verdict::{self, Verdict};
use std::collections::BTreeMap;

/// All sheets of a map.
pub(crate) type Sheets = BTreeMap<SheetKey, Sheet>;

/// Where a claim was judged. What a claim does not distinguish is `None`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Cell {
    pub(crate) claim: char,
    pub(crate) machine: Machine,
    pub(crate) is_single: bool,
    pub(crate) size: Option<u32>,
    pub(crate) is_deep: Option<bool>,
    pub(crate) cores: u8,
    pub(crate) buffer: Option<u32>,
    pub(crate) beyond: Option<Beyond>,
    /// Percent of both bodies.
    pub(crate) memory: Option<u32>,
    /// Cost of a byte (ns).
    pub(crate) byte_ns: Option<f64>,
    pub(crate) verdict: Verdict,
}

/// A cost of a byte and a memory, by their numbers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Setting {
    pub(crate) byte: usize,
    pub(crate) short: Option<(Beyond, usize)>,
}

/// All settings of a machine's sheets.
pub(crate) fn settings(grid: &Grid, machine: Machine) -> Vec<Setting> {
    if !machine.copies() {
        return vec![Setting { byte: 0, short: None }];
    }
    let mut settings = Vec::new();
    for byte in 0..grid.bytes.len() {
        for beyond in Beyond::ALL {
            let memories = 0..grid.memories.len();
            settings.extend(memories.map(|memory| Setting { byte, short: Some((beyond, memory)) }));
        }
    }
    settings
}

/// Judges all claims at all cells.
pub(crate) fn judge(sheets: &Sheets, grid: &Grid) -> Vec<Cell> {
    let mut cells = Vec::new();
    // Every kind of sheet once, whatever its subject.
    let mut kinds: Vec<(Machine, bool, u8, u32)> =
        sheets.keys().map(|key| (key.machine, key.is_single, key.cores, key.buffer)).collect();
    kinds.sort_unstable();
    kinds.dedup();
    for (machine, is_single, cores, buffer) in kinds {
        let kind = Kind { sheets, grid, machine, is_single, cores, buffer };
        if grid.buffers.contains(&buffer) {
            for setting in settings(grid, machine) {
                kind.judge(setting, &mut cells);
            }
        }
        if buffer == BUFFER {
            for setting in settings(grid, machine) {
                kind.judge_buffers(setting, &mut cells);
            }
        }
    }
    cells
}

struct Kind<'k> {
    sheets: &'k Sheets,
    grid: &'k Grid,
    machine: Machine,
    is_single: bool,
    cores: u8,
    buffer: u32,
}

impl Kind<'_> {
    fn curves(&self, subject: Subject, buffer: u32, setting: Setting) -> Option<Curves> {
        let Self { machine, is_single, cores, .. } = *self;
        let key = SheetKey { machine, subject, is_single, cores, buffer };
        Some(self.sheets.get(&key)?.curves(setting.byte, setting.short))
    }

    /// A cell of a claim without a subject.
    fn cell(&self, claim: char, setting: Setting, verdict: Verdict) -> Cell {
        let copies = self.machine.copies();
        Cell {
            claim,
            machine: self.machine,
            is_single: self.is_single,
            size: None,
            is_deep: None,
            cores: self.cores,
            buffer: Some(self.buffer),
            beyond: setting.short.map(|(beyond, _)| beyond),
            memory: setting.short.map(|(_, memory)| self.grid.memories[memory]),
            byte_ns: copies.then(|| self.grid.bytes[setting.byte]),
            verdict,
        }
    }

    fn judge(&self, setting: Setting, cells: &mut Vec<Cell>) {
        let of_subject =
            |size, is_deep| self.curves(Subject { size, is_deep }, self.buffer, setting);
        for size in &self.grid.sizes {
            let both = [true, false].map(|is_deep| of_subject(*size, is_deep));
            for (curves, is_deep) in both.iter().zip([true, false]) {
                let Some(curves) = curves else { continue };
                let mut say = |claim, verdict| {
                    let cell = self.cell(claim, setting, verdict);
                    cells.push(Cell { size: Some(*size), is_deep: Some(is_deep), ..cell });
                };
                say('a', verdict::less_travels(curves));
                say('b', verdict::interior(curves));
                say('g', verdict::faster(curves));
                // Who runs out does not depend on what happens then.
                if setting.short.is_some_and(|(beyond, _)| beyond == Beyond::Swap) {
                    say('e', verdict::runs_out(curves));
                }
            }
            if let [Some(deep), Some(scratch)] = &both {
                let cell = self.cell('c', setting, verdict::deeper(deep, scratch));
                cells.push(Cell { size: Some(*size), ..cell });
            }
        }
        for is_deep in [true, false] {
            let sizes = self.grid.sizes.iter();
            let all: Option<Vec<Curves>> = sizes.map(|size| of_subject(*size, is_deep)).collect();
            if let Some(all) = all {
                let cell = self.cell('d', setting, verdict::grows(&all));
                cells.push(Cell { is_deep: Some(is_deep), ..cell });
            }
        }
    }

    fn judge_buffers(&self, setting: Setting, cells: &mut Vec<Cell>) {
        for subject in self.grid.subjects() {
            let usual = self.curves(subject, BUFFER, setting);
            let Some(depth) = usual.as_ref().and_then(verdict::best_depth) else { continue };
            let buffers = self.grid.all_buffers().into_iter();
            let all: Option<Vec<Curves>> =
                buffers.map(|buffer| self.curves(subject, buffer, setting)).collect();
            let Some(all) = all else { continue };
            cells.push(Cell {
                size: Some(subject.size),
                is_deep: Some(subject.is_deep),
                buffer: None,
                ..self.cell('f', setting, verdict::saturates(&all, depth))
            });
        }
    }
}

/// How many cells have each verdict.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Shares {
    pub(crate) holds: usize,
    pub(crate) fails: usize,
    pub(crate) open: usize,
}

impl Shares {
    pub(crate) fn over<'c>(cells: impl IntoIterator<Item = &'c Cell>) -> Self {
        let mut shares = Self::default();
        for cell in cells {
            match cell.verdict {
                Verdict::Holds => shares.holds += 1,
                Verdict::Fails => shares.fails += 1,
                Verdict::Open => shares.open += 1,
            }
        }
        shares
    }

    pub(crate) fn all(&self) -> usize {
        self.holds + self.fails + self.open
    }

    /// The verdict on a machine as a whole. What one cell in fifty says is not taken for a region.
    pub(crate) fn verdict(&self) -> &'static str {
        let few = self.all() / 50;
        match (self.holds > few, self.fails > few) {
            (true, true) => "depends",
            (true, false) => "holds",
            (false, true) => "does not hold",
            (false, false) => "nobody can tell",
        }
    }

    /// Shares in percent: holds, does not hold, nobody can tell.
    pub(crate) fn percent(&self) -> String {
        let percent = |part: usize| 100.0 * part as f64 / self.all().max(1) as f64;
        let [holds, fails, open] = [self.holds, self.fails, self.open].map(percent);
        format!("{holds:.0} / {fails:.0} / {open:.0} %")
    }
}

/// A condition on a cell, in words.
struct Condition {
    words: String,
    is_met: Box<dyn Fn(&Cell) -> bool>,
}

fn conditions(grid: &Grid) -> Vec<Condition> {
    let mut all: Vec<Condition> = Vec::new();
    let mut add = |words: String, is_met: Box<dyn Fn(&Cell) -> bool>| {
        all.push(Condition { words, is_met });
    };
    for &bound in grid.bytes.iter().skip(1) {
        let met = move |cell: &Cell| cell.byte_ns.is_some_and(|ns| ns >= bound);
        add(format!("a byte costs {bound} ns or more"), Box::new(met));
        let met = move |cell: &Cell| cell.byte_ns.is_some_and(|ns| ns < bound);
        add(format!("a byte costs less than {bound} ns"), Box::new(met));
    }
    for &bound in grid.memories.iter().skip(1) {
        let met = move |cell: &Cell| cell.memory.is_some_and(|memory| memory >= bound);
        add(format!("memory is {bound} % or more"), Box::new(met));
        let met = move |cell: &Cell| cell.memory.is_some_and(|memory| memory < bound);
        add(format!("memory is less than {bound} %"), Box::new(met));
    }
    for &bound in grid.sizes.iter().skip(1) {
        let met = move |cell: &Cell| cell.size.is_some_and(|size| size >= bound);
        add(format!("bodies have {bound} triangles or more"), Box::new(met));
        let met = move |cell: &Cell| cell.size.is_some_and(|size| size < bound);
        add(format!("bodies have fewer than {bound} triangles"), Box::new(met));
    }
    for &bound in grid.cores.iter().skip(1) {
        let met = move |cell: &Cell| cell.cores >= bound;
        add(format!("there are {bound} cores or more"), Box::new(met));
        let met = move |cell: &Cell| cell.cores < bound;
        add(format!("there are fewer than {bound} cores"), Box::new(met));
    }
    for &bound in grid.buffers.iter().skip(1) {
        let met = move |cell: &Cell| cell.buffer.is_some_and(|buffer| buffer >= bound);
        add(format!("the buffer is {bound} or more"), Box::new(met));
        let met = move |cell: &Cell| cell.buffer.is_some_and(|buffer| buffer < bound);
        add(format!("the buffer is less than {bound}"), Box::new(met));
    }
    add("the contact is deep".to_owned(), Box::new(|cell| cell.is_deep == Some(true)));
    add("the contact is a scratch".to_owned(), Box::new(|cell| cell.is_deep == Some(false)));
    let swaps = |cell: &Cell| cell.beyond == Some(Beyond::Swap);
    add("memory that runs out swaps".to_owned(), Box::new(swaps));
    let evicts = |cell: &Cell| cell.beyond == Some(Beyond::Evict);
    add("memory that runs out evicts".to_owned(), Box::new(evicts));
    add("each contact is a request".to_owned(), Box::new(|cell| cell.is_single));
    add("sixteen contacts are a request".to_owned(), Box::new(|cell| !cell.is_single));
    all
}

/// A region: the condition, or two, that tells best where a verdict is given.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Region {
    pub(crate) words: String,
    /// Share of the cells in it that have the verdict.
    pub(crate) inside: f64,
    /// Share of all cells with the verdict that are in it.
    pub(crate) covered: f64,
}

/// The region of a verdict: of all single conditions and pairs, the one with the most cells told
/// right. `None` if none tells more than taking all or no cells would.
pub(crate) fn region(cells: &[&Cell], verdict: Verdict, grid: &Grid) -> Option<Region> {
    let conditions = conditions(grid);
    let truth: Vec<bool> = cells.iter().map(|cell| cell.verdict == verdict).collect();
    let with = truth.iter().filter(|has| **has).count();
    let met: Vec<Vec<bool>> = conditions
        .iter()
        .map(|condition| cells.iter().map(|cell| (condition.is_met)(cell)).collect())
        .collect();
    // Two in a hundred cells more than everywhere or nowhere would tell.
    let mut most = with.max(cells.len() - with) + cells.len() / 50;
    let mut found = None;
    for (first, one) in met.iter().enumerate() {
        for (second, two) in met.iter().enumerate().skip(first) {
            let (mut inside, mut hit) = (0, 0);
            for ((one, two), has) in one.iter().zip(two).zip(&truth) {
                let is_in = *one && *two;
                inside += usize::from(is_in);
                hit += usize::from(is_in && *has);
            }
            // Right: cells inside that have it, and cells outside that have not.
            let right = hit + (cells.len() - inside) - (with - hit);
            // A second condition must be worth a hundredth.
            let worth = right.saturating_sub(if first == second { 0 } else { cells.len() / 100 });
            if inside > 0 && worth > most {
                most = worth;
                found = Some((first, second, inside, hit));
            }
        }
    }
    let (first, second, inside, hit) = found?;
    let mut words = conditions[first].words.clone();
    if second != first {
        words = format!("{words} and {}", conditions[second].words);
    }
    let share = |part: usize, whole: usize| part as f64 / whole.max(1) as f64;
    Some(Region { words, inside: share(hit, inside), covered: share(hit, with) })
}

#[cfg(test)]
mod tests;
