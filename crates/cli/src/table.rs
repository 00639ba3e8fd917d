//! Tables and figures, as all commands print them.

use crate::print;
use report::table::{Column, fitted};
use report::text::COLUMNS;
use trolley::Run;
use trolley::run::Kept;

/// The lines of a table that fits the terminal, and below it what it leaves out for that.
pub(crate) fn table(columns: &[Column], rows: &[Vec<String>]) -> String {
    fitted(columns, rows, print::columns().unwrap_or(COLUMNS))
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
