//! A map as data: every verdict, what placing by match pays, every point.

use super::cells::Cell;
use super::found::Map;
use super::grid::BUFFER;
use super::machine::SCHEMES;
use super::table::{Beyond, contact};
use super::verdict::{Verdict, best_depths, pays};
use columns::{Form, Table, Value};
use scenario::Scheme;
use std::collections::BTreeMap;
use std::fmt::Write as _;

/// Every cell: a line for all memories and costs of a byte, whose verdicts are one sign each.
pub(super) fn verdicts_csv(map: &Map) -> String {
    let join = |values: Vec<String>| values.join(" ");
    let mut text = format!(
        "# verdicts: a group of signs for each memory ({} % of both bodies), in it a sign for each \
         cost of a byte ({} ns); ours has one sign: + holds, - does not hold, . nobody can tell\n\
         claim,machine,requests,triangles,contact,cores,buffer,beyond,verdicts\n",
        join(map.grid.memories.iter().map(u32::to_string).collect()),
        join(map.grid.bytes.iter().map(f64::to_string).collect()),
    );
    let mut lines: BTreeMap<String, String> = BTreeMap::new();
    let mut before = None;
    for cell in in_order(map) {
        let optional = |value: Option<u32>| value.map_or(String::new(), |value| value.to_string());
        let head = format!(
            "{},{},{},{},{},{},{},{}",
            cell.claim,
            cell.machine.name(),
            requests(cell.is_single),
            optional(cell.size),
            cell.is_deep.map_or("", contact),
            cell.cores,
            optional(cell.buffer),
            cell.beyond.map_or("", Beyond::name),
        );
        let signs = lines.entry(head).or_default();
        if !signs.is_empty() && before != cell.memory {
            signs.push(' ');
        }
        before = cell.memory;
        signs.push(match cell.verdict {
            Verdict::Holds => '+',
            Verdict::Fails => '-',
            Verdict::Open => '.',
        });
    }
    for (head, verdicts) in lines {
        // Writing to a String cannot fail.
        let _written = writeln!(text, "{head},{verdicts}");
    }
    text
}

/// All cells, those that differ in memory and cost of a byte alone beside each other.
fn in_order(map: &Map) -> Vec<&Cell> {
    let mut cells: Vec<&Cell> = map.cells.iter().collect();
    cells.sort_by(|a, b| {
        let key = |cell: &Cell| {
            let Cell { claim, machine, is_single, size, is_deep, cores, buffer, .. } = *cell;
            (claim, machine, is_single, size, is_deep, cores, buffer, cell.beyond, cell.memory)
        };
        let bytes = a.byte_ns.unwrap_or(0.0).total_cmp(&b.byte_ns.unwrap_or(0.0));
        key(a).cmp(&key(b)).then(bytes)
    });
    cells
}

fn requests(is_single: bool) -> &'static str {
    if is_single { "single" } else { "sixteen" }
}

const TEXT: Form = Form::Text;
const WHOLE: Form = Form::Whole;
const REAL: Form = Form::Real;

/// Every cell, a row each.
pub(super) fn verdicts_table(map: &Map) -> Table<'static, 11> {
    let mut table = Table::new([
        ("claim", TEXT),
        ("machine", TEXT),
        ("requests", TEXT),
        ("triangles", WHOLE),
        ("contact", TEXT),
        ("cores", WHOLE),
        ("buffer", WHOLE),
        ("beyond", TEXT),
        ("memory", WHOLE),
        ("byte_ns", REAL),
        ("verdict", TEXT),
    ]);
    for cell in in_order(map) {
        let letter = ["a", "b", "c", "d", "e", "f", "g"]
            .into_iter()
            .find(|letter| letter.starts_with(cell.claim));
        table.push([
            Value::text(letter),
            Value::Text(cell.machine.name()),
            Value::Text(requests(cell.is_single)),
            Value::whole(cell.size),
            Value::text(cell.is_deep.map(contact)),
            Value::Whole(cell.cores.into()),
            Value::whole(cell.buffer),
            Value::text(cell.beyond.map(Beyond::name)),
            Value::whole(cell.memory),
            cell.byte_ns.map_or(Value::Empty, |ns| Value::Real(ns, 1)),
            Value::Text(cell.verdict.name()),
        ]);
    }
    table
}

/// What placing by match pays at every cell of the usual buffer, and the best depths there.
pub(super) fn pays_table(map: &Map) -> Table<'static, 12> {
    let mut table = Table::new([
        ("machine", TEXT),
        ("triangles", WHOLE),
        ("contact", TEXT),
        ("cores", WHOLE),
        ("beyond", TEXT),
        ("memory", WHOLE),
        ("byte_ns", REAL),
        ("best_match_load_over_random", REAL),
        ("standard_error", REAL),
        ("best_depth", WHOLE),
        ("best_depth_of_random", WHOLE),
        ("speed_up", REAL),
    ]);
    let usual = map.sheets.iter().filter(|(key, _)| !key.is_single && key.buffer == BUFFER);
    for (key, sheet) in usual {
        for setting in super::cells::settings(&map.grid, key.machine) {
            let curves = sheet.curves(setting.byte, setting.short);
            let best = |scheme| best_depths(curves.line(scheme)).map(|(depth, _)| depth);
            let (Some(gain), Some(depth)) = (pays(&curves), best(Scheme::BestMatchLoad)) else {
                continue;
            };
            let point = curves.at_depth(Scheme::BestMatchLoad, depth);
            let speed_up = point.map(|point| point.time_us.under(curves.alone_us).mean);
            let byte_ns = key.machine.copies().then(|| map.grid.bytes[setting.byte]);
            table.push([
                Value::Text(key.machine.name()),
                Value::Whole(key.subject.size.into()),
                Value::Text(key.subject.contact()),
                Value::Whole(key.cores.into()),
                Value::text(setting.short.map(|(beyond, _)| beyond.name())),
                Value::whole(setting.short.map(|(_, memory)| map.grid.memories[memory])),
                byte_ns.map_or(Value::Empty, |ns| Value::Real(ns, 1)),
                Value::Real(gain.mean, 4),
                Value::Real(gain.error(), 4),
                Value::Whole(depth.into()),
                Value::whole(best(Scheme::RandomMatch)),
                speed_up.map_or(Value::Empty, |speed_up| Value::Real(speed_up, 3)),
            ]);
        }
    }
    table
}

/// Every simulated point, a row each: what `sheets` has, in one file.
pub(super) fn points_table(map: &Map) -> Table<'static, 20> {
    let mut table = Table::new([
        ("machine", TEXT),
        ("requests", TEXT),
        ("triangles", WHOLE),
        ("contact", TEXT),
        ("cores", WHOLE),
        ("buffer", WHOLE),
        ("scheme", TEXT),
        ("depth", WHOLE),
        ("byte_ns", REAL),
        ("beyond", TEXT),
        ("memory", WHOLE),
        ("seeds", WHOLE),
        ("time_us", REAL),
        ("time_sd", REAL),
        ("moved", REAL),
        ("moved_sd", REAL),
        ("swapped", REAL),
        ("out", REAL),
        ("peak", REAL),
        ("alone_us", REAL),
    ]);
    for (key, sheet) in &map.sheets {
        for (place, point) in &sheet.points {
            let byte_ns = key.machine.copies().then(|| map.grid.bytes[place.byte]);
            table.push([
                Value::Text(key.machine.name()),
                Value::Text(requests(key.is_single)),
                Value::Whole(key.subject.size.into()),
                Value::Text(key.subject.contact()),
                Value::Whole(key.cores.into()),
                Value::Whole(key.buffer.into()),
                Value::Text(SCHEMES[place.scheme].name()),
                Value::Whole(place.depth.into()),
                byte_ns.map_or(Value::Empty, |ns| Value::Real(ns, 1)),
                Value::text(place.short.map(|(beyond, _)| beyond.name())),
                Value::whole(place.short.map(|(_, memory)| map.grid.memories[memory])),
                Value::Whole(point.time_us.count.into()),
                Value::Real(point.time_us.mean, 1),
                Value::Real(point.time_us.deviation, 1),
                Value::Real(point.moved.mean, 4),
                Value::Real(point.moved.deviation, 4),
                Value::Real(point.swapped, 4),
                Value::Real(point.out, 3),
                Value::Real(point.peak, 4),
                Value::Real(sheet.alone_us, 1),
            ]);
        }
    }
    table
}
