//! Winner maps: who wins over two sweeps, of one input under one policy, as SVG.
//!
//! A colour is a candidate, the same in all maps of one input.

use super::gather::{Gathered, NOBODY};
use crate::plan::{Plan, Sweep};
use report::escape;
use std::fmt::Write as _;

/// Colours that differ in grey, too (Okabe and Ito, Color Universal Design, 2008), and lighter
/// ones of the same.
const COLOURS: [&str; 16] = [
    "#56b4e9", "#e69f00", "#009e73", "#cc79a7", "#0072b2", "#f0e442", "#d55e00", "#999999",
    "#abd9f4", "#f2cf80", "#80ceb9", "#e6bcd3", "#80b8d8", "#f8f2a0", "#eaae80", "#cccccc",
];
const SIDE: f64 = 168.0;
const LEFT: f64 = 44.0;
const ABOVE: f64 = 22.0;
const BELOW: f64 = 38.0;

/// The colour of a candidate.
pub(super) fn colour(code: u8) -> &'static str {
    if code == NOBODY { "#fff" } else { COLOURS[usize::from(code) % COLOURS.len()] }
}

/// Which two sweeps a map is over: those with the most values, others at what is given.
pub(super) fn axes(plan: &Plan) -> Option<[usize; 2]> {
    let sweeps = &plan.file().sweeps;
    let mut order: Vec<usize> = (0..sweeps.len()).collect();
    order.sort_by_key(|number| std::cmp::Reverse(sweeps[*number].values.len()));
    let [first, second] = [*order.first()?, *order.get(1)?];
    (sweeps[second].values.len() > 1).then(|| [first.min(second), first.max(second)])
}

/// The number of the value of a sweep that is nearest to the scene as given.
pub(super) fn given(sweep: &Sweep) -> usize {
    let off = |value: &f64| (value - sweep.knob.given()).abs();
    let near = sweep.values.iter().enumerate().min_by(|(_, a), (_, b)| off(a).total_cmp(&off(b)));
    near.map_or(0, |(number, _)| number)
}

/// The winners of a map: rows from below, each from left to right.
pub(super) fn cells(
    plan: &Plan,
    gathered: &Gathered,
    (input, judge): (usize, usize),
    [x, y]: [usize; 2],
) -> Vec<Vec<u8>> {
    let sweeps = &plan.file().sweeps;
    let judges = gathered.judged.len();
    let scene = |right: usize, up: usize| {
        let mut scene = input * plan.file().parameters.len().max(1);
        for (number, sweep) in sweeps.iter().enumerate() {
            let digit = match number {
                _ if number == x => right,
                _ if number == y => up,
                _ => given(sweep),
            };
            scene = scene * sweep.values.len() + digit;
        }
        scene
    };
    let across = 0..sweeps[x].values.len();
    (0..sweeps[y].values.len())
        .map(|up| {
            let winner = |right: usize| gathered.winners[scene(right, up) * judges + judge];
            across.clone().map(winner).collect()
        })
        .collect()
}

/// One map.
pub(super) fn svg(plan: &Plan, title: &str, cells: &[Vec<u8>], [x, y]: [usize; 2]) -> String {
    let sweeps = &plan.file().sweeps;
    let [across, up] = [sweeps[x].values.len(), sweeps[y].values.len()];
    let [width, height] = [SIDE / across as f64, SIDE / up as f64];
    let (whole, tall) = (LEFT + SIDE + 10.0, ABOVE + SIDE + BELOW);
    let mut inside = String::new();
    for (row, line) in cells.iter().enumerate() {
        let top = ABOVE + SIDE - height * (row + 1) as f64;
        let mut begin = 0;
        while begin < line.len() {
            let same = line[begin..].iter().take_while(|code| **code == line[begin]).count();
            let _w = write!(
                inside,
                "<rect x=\"{:.1}\" y=\"{top:.1}\" width=\"{:.1}\" height=\"{:.1}\" fill=\"{}\"/>",
                LEFT + width * begin as f64,
                width * same as f64 + 0.3,
                height + 0.3,
                colour(line[begin])
            );
            begin += same;
        }
    }
    let ends = |sweep: &Sweep| {
        let ends = [sweep.values.first(), sweep.values.last()];
        ends.map(|end| end.map_or(String::new(), |end| number(*end)))
    };
    let [x_from, x_to] = ends(&sweeps[x]);
    let [y_from, y_to] = ends(&sweeps[y]);
    let [foot, right] = [ABOVE + SIDE, LEFT + SIDE];
    let mut said = |x: f64, y: f64, anchor: &str, text: &str| {
        let _w = write!(
            inside,
            "<text x=\"{x:.0}\" y=\"{y:.0}\" text-anchor=\"{anchor}\">{}</text>",
            escape(text)
        );
    };
    said(LEFT, 14.0, "start", title);
    said(LEFT, foot + 14.0, "start", &x_from);
    said(right, foot + 14.0, "end", &x_to);
    said(LEFT + SIDE / 2.0, foot + 30.0, "middle", sweeps[x].knob.says());
    said(LEFT - 4.0, foot, "end", &y_from);
    said(LEFT - 4.0, ABOVE + 10.0, "end", &y_to);
    let (turn_x, turn_y) = (12.0, ABOVE + SIDE / 2.0);
    let _w = write!(
        inside,
        "<text transform=\"rotate(-90 {turn_x} {turn_y})\" x=\"{turn_x}\" y=\"{turn_y}\" \
         text-anchor=\"middle\">{}</text><rect x=\"{LEFT}\" y=\"{ABOVE}\" width=\"{SIDE}\" \
         height=\"{SIDE}\" fill=\"none\" stroke=\"#444\"/>",
        escape(sweeps[y].knob.says())
    );
    format!(
        "<svg class=\"map\" viewBox=\"0 0 {whole:.0} {tall:.0}\" width=\"{whole:.0}\" \
         role=\"img\" aria-label=\"{}\">{inside}</svg>",
        escape(title)
    )
}

/// A number in as few digits as it needs.
pub(super) fn number(value: f64) -> String {
    let text = format!("{value:.3}");
    text.trim_end_matches('0').trim_end_matches('.').replace('-', "−")
}
