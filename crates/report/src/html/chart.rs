//! Small charts as inline SVG: labelled, readable in grey.

use super::{TimelineMoment, Worker, escape, percent};
use std::fmt::Write as _;

/// Width of every chart, in its own units.
const WIDTH: f64 = 760.0;
/// Space for names at the left.
const LEFT: f64 = 190.0;
/// Colours that differ in grey, too (Okabe and Ito, Color Universal Design, 2008).
const COLOURS: [&str; 8] =
    ["#0072b2", "#e69f00", "#009e73", "#cc79a7", "#56b4e9", "#d55e00", "#999999", "#f0e442"];

fn svg(height: f64, inside: &str, title: &str) -> String {
    format!(
        "<svg viewBox=\"0 0 {WIDTH} {height:.0}\" role=\"img\" aria-label=\"{0}\"><title>{0}\
         </title>{inside}</svg>",
        escape(title)
    )
}

fn label(x: f64, y: f64, anchor: &str, text: &str) -> String {
    format!("<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\">{}</text>", escape(text))
}

fn cut(name: &str) -> String {
    let cut: String = name.chars().take(28).collect();
    if cut.len() < name.len() { cut + "…" } else { cut }
}

/// Nominal value and range of one candidate; `top` is the greatest of all.
pub(super) fn whisker(work: [f64; 2], range: [f64; 2], top: f64) -> String {
    let x = |share: f64| if top > 0.0 { 4.0 + 152.0 * (share / top).max(0.0).sqrt() } else { 4.0 };
    let (low, high, is) = (x(range[0].min(work[0])), x(range[1].max(work[1])), x(work[1]));
    format!(
        "<svg class=\"whisker\" viewBox=\"0 0 160 16\" role=\"img\" aria-label=\"{0} %, {1} to {2} \
         %\"><rect x=\"{low:.1}\" y=\"5\" width=\"{3:.1}\" height=\"6\" class=\"range\"/>\
         <rect x=\"{4:.1}\" y=\"1\" width=\"3\" height=\"14\" class=\"mark\"/></svg>",
        percent(work[1]),
        percent(range[0]),
        percent(range[1]),
        (high - low).max(1.0),
        is - 1.5,
    )
}

/// Stages one after the other.
pub(super) fn stages(stages: &[(String, f64)]) -> String {
    let total: f64 = stages.iter().map(|(_, ms)| ms).sum();
    let scale = (WIDTH - LEFT - 90.0) / total.max(1e-9);
    let (mut inside, mut at) = (String::new(), 0.0);
    for (row, (name, ms)) in stages.iter().enumerate() {
        let y = 22.0 * row as f64;
        inside += &label(LEFT - 8.0, y + 15.0, "end", name);
        let (x, width) = (LEFT + at * scale, (ms * scale).max(0.5));
        let _w = write!(
            inside,
            "<rect x=\"{x:.1}\" y=\"{:.1}\" width=\"{width:.1}\" height=\"14\" fill=\"{}\"/>",
            y + 4.0,
            COLOURS[0]
        );
        inside += &label(x + width + 5.0, y + 15.0, "start", &format!("{ms:.2} ms"));
        at += ms;
    }
    svg(22.0 * stages.len() as f64 + 4.0, &inside, "Stages of the request and their times")
}

/// Jobs done and not needed, by candidate.
pub(super) fn jobs(jobs: &[(String, u64, u64)]) -> String {
    let most = jobs.iter().map(|(_, done, cut)| done + cut).max().unwrap_or(0).max(1);
    let scale = (WIDTH - LEFT - 190.0) / most as f64;
    let mut inside = String::new();
    for (row, (name, done, not)) in jobs.iter().enumerate() {
        let y = 22.0 * row as f64;
        inside += &label(LEFT - 8.0, y + 15.0, "end", &cut(name));
        let (a, b) = (*done as f64 * scale, *not as f64 * scale);
        let _w = write!(
            inside,
            "<rect x=\"{LEFT}\" y=\"{0:.1}\" width=\"{a:.1}\" height=\"14\" fill=\"{1}\"/>\
             <rect x=\"{2:.1}\" y=\"{0:.1}\" width=\"{b:.1}\" height=\"14\" fill=\"{3}\" \
             opacity=\"0.45\"/>",
            y + 4.0,
            COLOURS[0],
            LEFT + a,
            COLOURS[6],
        );
        let text = match not {
            0 => format!("{done} done"),
            not => format!("{done} done, {not} not needed"),
        };
        inside += &label(LEFT + a + b + 5.0, y + 15.0, "start", &text);
    }
    svg(22.0 * jobs.len() as f64 + 4.0, &inside, "Jobs by candidate")
}

/// When each worker was at work.
pub(super) fn workers(workers: &[Worker]) -> String {
    let spans = || workers.iter().flat_map(|worker| &worker.spans);
    let end = spans().map(|span| span.to_ms).fold(0.0, f64::max).max(1e-9);
    let scale = (WIDTH - LEFT - 20.0) / end;
    let mut inside = String::new();
    for (row, worker) in workers.iter().enumerate() {
        let y = 26.0 * row as f64;
        inside += &label(LEFT - 8.0, y + 16.0, "end", &worker.name);
        for (number, span) in worker.spans.iter().enumerate() {
            let _w = write!(
                inside,
                "<rect x=\"{:.2}\" y=\"{:.1}\" width=\"{:.2}\" height=\"18\" fill=\"{}\"/>",
                LEFT + span.from_ms * scale,
                y + 3.0,
                ((span.to_ms - span.from_ms) * scale).max(0.3),
                COLOURS[if number % 2 == 0 { 0 } else { 4 }],
            );
        }
    }
    let y = 26.0 * workers.len() as f64 + 14.0;
    inside += &label(LEFT, y, "start", "0");
    inside += &label(WIDTH - 20.0, y, "end", &format!("{end:.2} ms"));
    svg(y + 6.0, &inside, "Jobs on each worker over time")
}

/// Work intervals over jobs closed, one band per candidate.
pub(super) fn moments(moments: &[TimelineMoment], names: &[String]) -> String {
    let jobs = moments.iter().map(|moment| moment.jobs).max().unwrap_or(1).max(1) as f64;
    let top = moments.iter().flat_map(|moment| &moment.work).map(|work| work[1]);
    let top = top.fold(0.0, f64::max).max(1e-12);
    let (height, right) = (260.0, WIDTH - 180.0);
    let x = |jobs_then: u64| 50.0 + (right - 50.0) * jobs_then as f64 / jobs;
    let y = |share: f64| height - (height - 10.0) * (share / top).max(0.0).sqrt();
    let mut inside = String::new();
    for (number, name) in names.iter().enumerate() {
        let own =
            || moments.iter().filter_map(|m| m.work.get(number).map(|work| (x(m.jobs), *work)));
        let mut upper = String::new();
        let mut lower = Vec::new();
        for (x, work) in own() {
            let _w = write!(upper, "{x:.1},{:.1} ", y(work[1]));
            lower.push(format!("{x:.1},{:.1}", y(work[0])));
        }
        lower.reverse();
        let colour = COLOURS[number % COLOURS.len()];
        let _w = write!(
            inside,
            "<polygon points=\"{upper}{}\" fill=\"{colour}\" opacity=\"0.22\"/>\
             <polyline points=\"{upper}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"1.5\"/>",
            lower.join(" ")
        );
        if let Some((_, work)) = own().next_back() {
            inside += &label(right + 6.0, y(work[1]) + 4.0, "start", &cut(name));
        }
    }
    inside += &label(44.0, 16.0, "end", &format!("{:.1} %", 100.0 * top));
    inside += &label(44.0, height, "end", "0");
    inside += &label(50.0, height + 16.0, "start", "0 jobs closed");
    inside += &label(right, height + 16.0, "end", &format!("{jobs}"));
    svg(height + 24.0, &inside, "Work interval of each candidate while jobs were closed")
}
