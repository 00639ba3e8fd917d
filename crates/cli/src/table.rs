//! Tables and figures, as all commands print them.

use comfy_table::{CellAlignment, ContentArrangement, Table, presets};
use report::text::COLUMNS;
use trolley::Run;
use trolley::run::Kept;

/// A table without lines, at most as wide as a terminal.
pub(crate) fn plain(header: &[&str]) -> Table {
    let mut table = Table::new();
    table.load_style(presets::NOTHING);
    table.set_content_arrangement(ContentArrangement::Dynamic);
    table.set_width(COLUMNS);
    table.set_header(header);
    table
}

/// The lines of a table whose columns of these numbers are aligned to the right.
pub(crate) fn lines(mut table: Table, right: &[usize]) -> String {
    for (number, column) in table.column_iter_mut().enumerate() {
        column.set_padding((u16::from(number > 0), 0));
        if right.contains(&number) {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    let table = table.to_string();
    let lines: Vec<&str> = table.lines().map(str::trim_end).collect();
    lines.join("\n")
}

/// "8 bodies · 412k triangles · 4 workers on cores 0, 1".
pub(crate) fn circumstances(run: &Run) -> String {
    let thousand = (run.triangles + 500) / 1000;
    let size = format!("{} bodies · {thousand}k triangles", run.bodies);
    if run.workers.is_empty() {
        return format!("{size} · in this process, without workers");
    }
    let mut cores: Vec<usize> = run.workers.iter().filter_map(|worker| worker.core).collect();
    cores.sort_unstable();
    cores.dedup();
    let place = match cores.as_slice() {
        [] => "not pinned".to_owned(),
        [one] => format!("on core {one}"),
        [first, .., last] if last - first + 1 == cores.len() => {
            format!("on cores {first}–{last}")
        }
        _ => format!("on cores {cores:?}"),
    };
    format!("{size} · {} workers {place}", run.workers.len())
}

/// A share in percent, without the sign; an exact zero has no decimals.
pub(crate) fn percent(value: f64) -> String {
    if value == 0.0 { "0".to_owned() } else { format!("{:.2}", 100.0 * value) }
}

/// Whether the answer came in time.
pub(crate) fn kept(kept: &Kept) -> String {
    let Kept { due_ms, answered_ms, late_ms } = kept;
    if *late_ms > 0.0 {
        return format!("Due at {due_ms} ms, answered {late_ms:.1} ms late.");
    }
    format!("Due at {due_ms} ms, answered at {answered_ms:.1} ms.")
}
