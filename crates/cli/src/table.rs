//! The table of a ranking: the request, the result, how certain it is, and why.

use comfy_table::{CellAlignment, ContentArrangement, Table, presets};
use report::text::{COLUMNS, wrap};
use scenario::Scenario;
use trolley::run::{Certain, Kept};
use trolley::{Answer, AnswerState, PersonRow, Row, Run, Touch};

/// The ranking as text: a table between sentences, at most 100 columns wide.
pub(crate) fn ranking(scenario: &Scenario, answer: &Answer, run: &Run) -> String {
    let mut table = plain(&[
        "#",
        "candidate",
        "contact",
        "depth",
        "ΔV ego/other",
        "worst-off person",
        "harm %",
        "range %",
    ]);
    for (at, row) in answer.ranking.iter().enumerate() {
        table.add_row([
            (at + 1).to_string(),
            row.name.clone(),
            contact(row),
            depth(row),
            delta_v(row),
            worst_off(row),
            harm(row),
            format!("{}–{}", percent(row.range.low()), percent(row.range.high())),
        ]);
    }
    let rows = lines(table, &[0, 3, 6]);
    let head = format!("{}. Which does least harm?", scenario.name.trim_end_matches('.'));
    let mut text = format!("{head}\n{}\n\n", circumstances(run));
    text.push_str(&rows);
    text.push_str("\n\n");
    text.push_str(&verdict(answer, run));
    text
}

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

fn contact(row: &Row) -> String {
    match row.contact.touch {
        Touch::Yes => row.sides.clone(),
        Touch::No if row.contact.hull_gap_m > 0.0 => {
            format!("none: {:.2} m", row.contact.hull_gap_m)
        }
        Touch::No => "none".to_owned(),
        Touch::Unknown => "unknown".to_owned(),
    }
}

fn depth(row: &Row) -> String {
    let patch = row.contact.patch.as_ref();
    patch.map_or("–".to_owned(), |patch| format!("{:.2} m", patch.depth_m.hi()))
}

fn delta_v(row: &Row) -> String {
    if row.contact.touch == Touch::No {
        return "– / –".to_owned();
    }
    let [ego, other] = row.delta_v_m_s.map(|delta| delta.work.hi());
    let other = if row.is_other_fixed { "–".to_owned() } else { format!("{other:.1}") };
    format!("{ego:.1} / {other}")
}

fn worst_off(row: &Row) -> String {
    let worst = row.persons.iter().max_by(|a, b| a.work.hi().total_cmp(&b.work.hi()));
    match worst {
        Some(person) if person.work.hi() > 0.0 => {
            format!("{} {:.1} %", who(person), 100.0 * person.work.hi())
        }
        _ => "–".to_owned(),
    }
}

fn who(person: &PersonRow) -> String {
    match person.seat {
        Some("front-left") => format!("{} driver", person.party),
        Some("rider") => format!("{} rider", person.party),
        Some(seat) => format!("{} {}", person.party, seat.replace('-', " ")),
        None => person.party.clone(),
    }
}

fn harm(row: &Row) -> String {
    let (lo, hi) = (row.work.lo(), row.work.hi());
    if lo.to_bits() == hi.to_bits() {
        return percent(hi);
    }
    format!("{}–{}", percent(lo), percent(hi))
}

/// A share in percent, without the sign; an exact zero has no decimals.
pub(crate) fn percent(value: f64) -> String {
    if value == 0.0 { "0".to_owned() } else { format!("{:.2}", 100.0 * value) }
}

fn verdict(answer: &Answer, run: &Run) -> String {
    let Some(first) = answer.ranking.first() else { return String::new() };
    let mut lines = Vec::new();
    let state = match answer.state {
        AnswerState::Complete => "COMPLETE: all work is done",
        AnswerState::Certified => "CERTIFIED: no open work can change the winner",
        AnswerState::Degraded => "DEGRADED: open work could change the winner",
        AnswerState::Refused => "REFUSED: no candidate has a bound",
    };
    lines.push(format!(
        "Least harm: {}. {state} ({} jobs in {:.1} ms; policy \"{}\").",
        first.name, run.jobs, run.stages.work_ms, answer.policy
    ));
    lines.extend(run.winner_certain.as_ref().and_then(|certain| early(answer, certain)));
    lines.extend(run.deadline.as_ref().map(kept));
    if first.contact.touch == Touch::No {
        lines.push(
            "It touches nothing: not one triangle of either body, anywhere on its way.".to_owned(),
        );
    }
    lines.extend(first.why.iter().map(|why| format!("Why: {why}.")));
    if answer.tie_class.len() > 1 {
        let others: Vec<&str> = answer
            .tie_class
            .iter()
            .filter(|name| **name != first.name)
            .map(String::as_str)
            .collect();
        lines.push(format!(
            "Within the range of the model it is indistinguishable from: {}.",
            others.join(", ")
        ));
    }
    lines.extend(answer.assumptions.iter().map(|assumed| format!("Assumed: {assumed}.")));
    if !answer.missing.is_empty() {
        lines.push(format!("Not fully known: {}.", answer.missing.join("; ")));
    }
    let near: Vec<&str> = answer
        .ranking
        .iter()
        .filter(|row| row.contact.near_miss)
        .map(|row| row.name.as_str())
        .collect();
    if !near.is_empty() {
        lines.push(format!("Near misses, closer than poses are known: {}.", near.join(", ")));
    }
    lines.extend(run.remarks.iter().map(|remark| format!("Note: {remark}.")));
    for worker in run.workers.iter().filter(|worker| worker.lost.is_some()) {
        let how = worker.lost.as_deref().unwrap_or_default();
        lines.push(format!("Note: worker {} was lost ({how}).", worker.worker));
    }
    let wrapped: Vec<String> = lines.iter().map(|line| wrap(line)).collect();
    wrapped.join("\n")
        + "\nNext: trolley demo --explain · trolley rank --help · trolley model --help\n"
}

/// How early the winner was certain, where that was before the end.
fn early(answer: &Answer, certain: &Certain) -> Option<String> {
    let Certain { share, ms, .. } = certain;
    let is_early = answer.state == AnswerState::Complete && *share < 0.95;
    is_early.then(|| {
        format!("The winner was certain after {:.0} % of the work, at {ms:.1} ms.", 100.0 * share)
    })
}

/// Whether the answer came in time.
pub(crate) fn kept(kept: &Kept) -> String {
    let Kept { due_ms, answered_ms, late_ms } = kept;
    if *late_ms > 0.0 {
        return format!("Due at {due_ms} ms, answered {late_ms:.1} ms late.");
    }
    format!("Due at {due_ms} ms, answered at {answered_ms:.1} ms.")
}
