//! The pictures of a map: a field of cells for each claim, and the paper's figures over depth.

use super::super::figure::{Figure, Line, draw};
use super::cells::Cell;
use super::found::Map;
use super::grid::{BUFFER, CORES};
use super::machine::{Machine, PAPER_BYTE_NS, SCHEMES};
use super::panels::{Panels, Tile};
use super::table::{Beyond, Point, SheetKey, Subject};
use super::verdict::{CLAIMS, is_out, pays};
use scenario::Scheme;
use trolley::Failure;

/// The machines that copy, which have a memory and a cost of a byte; and whether each contact is a
/// request.
const COPYING: [(Machine, bool); 3] =
    [(Machine::Paper, true), (Machine::Paper, false), (Machine::Copying, false)];

/// A column of fields: machine and requests, and a size where a claim tells sizes apart.
type Column = ((Machine, bool), Option<u32>);

/// The maps, with the names of their files.
pub(super) fn maps(map: &Map) -> Vec<(String, String)> {
    let mut all: Vec<(String, String)> = CLAIMS
        .iter()
        .map(|(claim, words)| (format!("claim-{claim}.svg"), of_claim(map, *claim, words)))
        .collect();
    all.push(("pays.svg".to_owned(), of_pays(map)));
    all
}

fn labels(map: &Map) -> (Vec<String>, Vec<String>) {
    let x = map.grid.bytes.iter().map(f64::to_string).collect();
    let y = map.grid.memories.iter().map(u32::to_string).collect();
    (x, y)
}

/// A row of fields: contact and what happens beyond memory, where a claim tells them apart.
type Row = (Option<bool>, Option<Beyond>);

fn row_words(row: &Row) -> String {
    let contact = match row.0 {
        Some(true) => "deep contact",
        Some(false) => "scratch",
        None => "both contacts",
    };
    let beyond = match row.1 {
        Some(Beyond::Swap) => "beyond M: swap",
        Some(Beyond::Evict) => "beyond M: evict",
        None => "",
    };
    format!("{contact}\n{beyond}")
}

fn of_claim(map: &Map, claim: char, words: &str) -> String {
    let (x, y) = labels(map);
    let contacts: &[Option<bool>] = if claim == 'c' { &[None] } else { &[Some(true), Some(false)] };
    let beyond: &[Beyond] = if claim == 'e' { &[Beyond::Swap] } else { &Beyond::ALL };
    let rows: Vec<Row> = contacts
        .iter()
        .flat_map(|contact| beyond.iter().map(move |beyond| (*contact, Some(*beyond))))
        .collect();
    let sizes: Vec<Option<u32>> = if claim == 'd' {
        vec![None]
    } else {
        map.grid.sizes.iter().map(|size| Some(*size)).collect()
    };
    let columns: Vec<Column> =
        COPYING.iter().flat_map(|group| sizes.iter().map(move |size| (*group, *size))).collect();
    let title = format!("({claim}) {words}");
    let panels = Panels {
        title: &title,
        key: "Blue +: holds. Orange –: does not hold. Grey: nobody can tell.\nFour cores, buffer \
              16. \"single\": each contact is a request.",
        rows: rows.iter().map(row_words).collect(),
        columns: columns.iter().map(column_words).collect(),
        x,
        y,
    };
    let shown = |cell: &&Cell| {
        cell.claim == claim
            && cell.cores == CORES
            && cell.buffer.is_none_or(|buffer| buffer == BUFFER)
    };
    let cells: Vec<&Cell> = map.cells.iter().filter(shown).collect();
    panels.draw(|row, column, x, y| {
        let ((is_deep, beyond), (group, size)) = (rows[row], columns[column]);
        let (byte, memory) = (map.grid.bytes[x], map.grid.memories[y]);
        let is_it = |cell: &&&Cell| {
            ((cell.machine, cell.is_single), cell.size, cell.is_deep) == (group, size, is_deep)
                && (cell.beyond, cell.memory, cell.byte_ns) == (beyond, Some(memory), Some(byte))
        };
        cells.iter().find(is_it).map(|cell| Tile::of_verdict(cell.verdict))
    })
}

fn column_words((group, size): &Column) -> String {
    let name = match group {
        (Machine::Paper, true) => "paper's, single",
        (Machine::Paper, false) => "paper's",
        (Machine::Copying, _) => "this, copying",
        (Machine::Sealed, _) => "ours",
    };
    match size {
        Some(size) => format!("{name}\n2 × {size}"),
        None => format!("{name}\ngrowing bodies"),
    }
}

fn of_pays(map: &Map) -> String {
    let (x, y) = labels(map);
    let rows: Vec<Row> = [true, false]
        .into_iter()
        .flat_map(|deep| Beyond::ALL.map(|beyond| (Some(deep), Some(beyond))))
        .collect();
    let columns: Vec<Column> = COPYING
        .iter()
        .flat_map(|group| map.grid.sizes.iter().map(move |size| (*group, Some(*size))))
        .collect();
    let panels = Panels {
        title: "What placing work by what a core already holds pays",
        key: "Speed-up of Best Match-Load over Random Match (mean of 16 seeds), each at its own \
              best depth, in percent.\nFour cores, buffer 16. \"single\": each contact is a \
              request.",
        rows: rows.iter().map(row_words).collect(),
        columns: columns.iter().map(column_words).collect(),
        x,
        y,
    };
    panels.draw(|row, column, x, y| {
        let ((deep, beyond), ((machine, is_single), size)) = (rows[row], columns[column]);
        let subject = Subject { size: size?, is_deep: deep? };
        let key = SheetKey { is_single, ..usual(machine, subject) };
        let sheet = map.sheets.get(&key)?;
        let gain = pays(&sheet.curves(x, Some((beyond?, y))))?;
        Some(Tile::of_gain(gain.mean - 1.0))
    })
}

/// The sheet of four cores, the usual buffer, and one request of all contacts.
pub(super) fn usual(machine: Machine, subject: Subject) -> SheetKey {
    SheetKey { machine, subject, is_single: false, cores: CORES, buffer: BUFFER }
}

/// Whether waiting for virtual memory at least doubles the time.
fn thrashes(point: &Point, ample: &Point) -> bool {
    point.time_us.mean > 2.0 * ample.time_us.mean
}

/// The memory (its number) and buffer at which the paper's figures are drawn: where memory runs
/// out, and most nearly as it says, over both contacts of the middle size.
pub(super) fn as_the_paper_says(map: &Map) -> (usize, u32) {
    let byte = map.grid.bytes.iter().position(|ns| *ns == PAPER_BYTE_NS).unwrap_or(0);
    let size = map.grid.sizes[map.grid.sizes.len() / 2];
    let mut found = (i64::MIN, (0, BUFFER));
    for buffer in &map.grid.buffers {
        for memory in 0..map.grid.memories.len() {
            let (mut score, mut runs_out, mut is_cut) = (0, false, false);
            for is_deep in [true, false] {
                let key = SheetKey {
                    buffer: *buffer,
                    is_single: true,
                    ..usual(Machine::Paper, Subject { size, is_deep })
                };
                let Some(sheet) = map.sheets.get(&key) else { continue };
                let curves = sheet.curves(byte, Some((Beyond::Swap, memory)));
                let ample = sheet.curves(byte, None);
                let line = curves.line(Scheme::BestMatchLoad);
                let both = line.iter().zip(ample.line(Scheme::BestMatchLoad));
                let cuts = both.filter(|((_, point), (_, ample))| thrashes(point, ample)).count();
                is_cut |= 2 * cuts > line.len();
                // Depths at which only those run out that the paper names, and only others.
                for (depth, _) in curves.lines[0].iter().filter(|(depth, _)| *depth > 0) {
                    let out = |scheme| curves.at_depth(scheme, *depth).is_some_and(is_out);
                    let named = out(Scheme::RandomMatch) || out(Scheme::LowestMatch);
                    let others = out(Scheme::BestMatch) || out(Scheme::BestMatchLoad);
                    runs_out |= named;
                    score += i64::from(named && !others) - i64::from(others && !named);
                }
            }
            // Of a line that is cut at most depths there is nothing to see.
            if !runs_out || is_cut {
                continue;
            }
            // Of equals, the one with most of its lines uncut.
            if (score, memory) > (found.0, found.1.0) {
                found = (score, (memory, *buffer));
            }
        }
    }
    found.1
}

/// The paper's figures, speed-up and relative transfer over depth: on its machine and on ours.
pub(super) fn lines(map: &Map) -> Result<Vec<(String, Vec<u8>)>, Failure> {
    let size = map.grid.sizes[map.grid.sizes.len() / 2];
    let byte = map.grid.bytes.iter().position(|ns| *ns == PAPER_BYTE_NS).unwrap_or(0);
    let (memory, buffer) = as_the_paper_says(map);
    let percent = map.grid.memories[memory];
    let mut all = Vec::new();
    for is_deep in [true, false] {
        let subject = Subject { size, is_deep };
        for machine in [Machine::Paper, Machine::Sealed] {
            let is_single = machine == Machine::Paper;
            let key = SheetKey { buffer, is_single, ..usual(machine, subject) };
            let Some(sheet) = map.sheets.get(&key) else { continue };
            let (byte, short) = match machine {
                Machine::Sealed => (0, None),
                _ => (byte, Some((Beyond::Swap, memory))),
            };
            let (curves, ample) = (sheet.curves(byte, short), sheet.curves(byte, None));
            let drawn = |value: &dyn Fn(&Point) -> f64, cuts: bool| -> Vec<Line> {
                let line = |scheme: Scheme| {
                    let both = curves.line(scheme).iter().zip(ample.line(scheme));
                    let points = both.map(|((depth, point), (_, ample))| {
                        let shown = (!cuts || !thrashes(point, ample)).then(|| value(point));
                        (f64::from(*depth), shown)
                    });
                    Line {
                        name: scheme.name().to_owned(),
                        scheme: Some(scheme),
                        points: points.collect(),
                    }
                };
                SCHEMES.map(line).into()
            };
            let about = match machine {
                Machine::Sealed => format!(
                    "2 × {size} triangles, {}, four cores, buffer {buffer}",
                    subject.contact()
                ),
                _ => format!(
                    "2 × {size} {}, buffer {buffer}, {PAPER_BYTE_NS} ns a byte, M = {percent} %, \
                     then swap",
                    subject.contact()
                ),
            };
            let on =
                if machine == Machine::Paper { "the paper's machine" } else { "one sealed store" };
            for (kind, title, y, lines) in [
                (
                    "speed-up",
                    format!("Speed-up on {on}"),
                    "speed-up (simulated)",
                    drawn(&|point| curves.alone_us / point.time_us.mean, true),
                ),
                (
                    "transfer",
                    format!("Relative transfer on {on}"),
                    "bytes moved / bytes of both bodies",
                    drawn(&|point| point.moved.mean, false),
                ),
            ] {
                let figure =
                    Figure { title, subtitle: about.clone(), x: "distribution depth", y, lines };
                let name = format!("{kind}-{}-{}.png", subject.contact(), machine.name());
                all.push((name, draw(&figure)?.png));
            }
        }
    }
    Ok(all)
}
