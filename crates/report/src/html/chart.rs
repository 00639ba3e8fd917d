//! Small charts as inline SVG: labelled, readable in grey.

use super::{escape, percent};
use crate::work::Worker;
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

/// Nominal value and range of one candidate; `top` is the greatest of all.
pub(crate) fn whisker(work: [f64; 2], range: [f64; 2], top: f64) -> String {
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

/// Harm in each member, ascending, coloured by who is met first; `top` is the greatest of all
/// candidates, on a scale of square roots.
pub(crate) fn strip(members: &[(f64, Option<usize>)], top: f64, title: &str) -> String {
    const HIGH: f64 = 28.0;
    let mut ascending = members.to_vec();
    ascending.sort_by(|a, b| a.0.total_cmp(&b.0));
    let width = 160.0 / ascending.len().max(1) as f64;
    let mut inside = String::new();
    for (at, (harm, first)) in ascending.iter().enumerate() {
        let share = if top > 0.0 { (harm / top).max(0.0).sqrt() } else { 0.0 };
        let height = (HIGH * share).max(1.0);
        let colour = first.map_or("#999999", |party| COLOURS[party % COLOURS.len()]);
        let _w = write!(
            inside,
            "<rect x=\"{:.2}\" y=\"{:.2}\" width=\"{:.2}\" height=\"{height:.2}\" \
             fill=\"{colour}\"/>",
            width * at as f64,
            HIGH - height,
            (0.85 * width).max(0.5)
        );
    }
    format!(
        "<svg class=\"whisker\" viewBox=\"0 0 160 {HIGH:.0}\" role=\"img\" \
         aria-label=\"{0}\"><title>{0}</title>\
         {inside}</svg>",
        escape(title)
    )
}

/// A square in the colour of a party in [`strip`].
pub(crate) fn swatch(party: usize) -> String {
    let colour = COLOURS[party % COLOURS.len()];
    format!(
        "<svg class=\"swatch\" viewBox=\"0 0 10 10\" width=\"10\" height=\"10\" \
         aria-hidden=\"true\">\
         <rect width=\"10\" height=\"10\" fill=\"{colour}\"/></svg>"
    )
}

/// Stages one after the other.
pub(crate) fn stages(stages: &[(String, f64)]) -> String {
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

/// When each worker was at work.
pub(crate) fn workers(workers: &[Worker]) -> String {
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
