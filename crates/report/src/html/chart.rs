//! Small charts as inline SVG: labelled, readable in grey.

use super::{escape, percent};
use crate::work::Worker;
use std::fmt::Write as _;

/// Width of every chart, in its own units.
const WIDTH: f64 = 760.0;
/// Space for names at the left.
const LEFT: f64 = 190.0;
/// Colours that differ in grey, too (Okabe and Ito, Color Universal Design, 2008). The blue of the
/// ego is none, and a brown is there for the yellow, which cannot be seen on paper.
const COLOURS: [&str; OWN_COLOURS] =
    ["#e69f00", "#009e73", "#d55e00", "#56b4e9", "#cc79a7", "#7a4f1d", "#8e8cd8"];
/// Bars of times.
const BARS: [&str; 2] = ["#0072b2", "#56b4e9"];
/// How many parties have a colour of their own.
pub(crate) const OWN_COLOURS: usize = 7;
/// The colour of all other parties.
const OTHERS: &str = "#55514a";
/// The colour where nobody is met.
pub(crate) const NOBODY: &str = "#c4c4be";

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

/// Left edge, top and height of the bars of a strip, and its whole height.
const STRIP: [f64; 4] = [74.0, 10.0, 84.0, 102.0];
/// Least distance between labels of an axis: a line of text on a narrow screen.
const AXIS: f64 = 22.0;

/// Harm in each member, ascending, each with its colour; `mean` is a line, and `top` the greatest
/// of all candidates, on a scale of square roots. The title is markup.
pub(crate) fn strip(members: &[(f64, &str)], mean: f64, top: f64, title: &str) -> String {
    let [left, upper, high, whole] = STRIP;
    let share = |harm: f64| if top > 0.0 { (harm / top).clamp(0.0, 1.0).sqrt() } else { 0.0 };
    let y = |harm: f64| upper + high * (1.0 - share(harm));
    let mut inside = String::new();
    for at in axis(top, high) {
        let _w = write!(
            inside,
            "<path class=\"grid\" d=\"M{left} {0:.1}H{WIDTH}\"/><text class=\"axis\" \
             x=\"{1:.1}\" y=\"{2:.1}\" text-anchor=\"end\">{3} %</text>",
            y(at),
            left - 8.0,
            y(at) + 5.0,
            round(at)
        );
    }
    let mut ascending = members.to_vec();
    ascending.sort_by(|a, b| a.0.total_cmp(&b.0));
    let width = (WIDTH - left) / ascending.len().max(1) as f64;
    for (at, (harm, colour)) in ascending.iter().enumerate().filter(|(_, (harm, _))| *harm > 0.0) {
        // Harm that is not nothing is seen.
        let height = (high * share(*harm)).max(1.5);
        let _w = write!(
            inside,
            "<rect x=\"{:.2}\" y=\"{:.2}\" width=\"{:.2}\" height=\"{height:.2}\" \
             fill=\"{colour}\"/>",
            left + width * at as f64,
            upper + high - height,
            (0.85 * width).max(0.5)
        );
    }
    let _w = write!(inside, "<path class=\"mean\" d=\"M{left} {0:.1}H{WIDTH}\"/>", y(mean));
    format!(
        "<svg class=\"strip\" viewBox=\"0 0 {WIDTH} {whole}\" role=\"img\" \
         aria-label=\"{title}\"><title>{title}</title>{inside}</svg>"
    )
}

/// A value of an axis in percent: it has one digit that is not 0.
fn round(share: f64) -> String {
    let percent = 100.0 * share;
    let digits = if percent > 0.0 { -libm::floor(libm::log10(1.000_001 * percent)) } else { 0.0 };
    format!("{percent:.*}", digits.clamp(0.0, 12.0) as usize)
}

/// Values on an axis of square roots, `high` long, whose labels do not touch: 0, and 1, 2 or 5
/// times powers of ten up to `top`, from above.
fn axis(top: f64, high: f64) -> Vec<f64> {
    let mut said = vec![0.0];
    if !(top > 0.0 && top.is_finite()) {
        return said;
    }
    let place = |value: f64| high * (value / top).sqrt();
    let mut power = 10_f64.powi(libm::floor(libm::log10(top)) as i32);
    let mut last = f64::INFINITY;
    // Below a hundredth of the top the axis has less than a tenth of its length.
    for _ in 0..4 {
        for value in [5.0 * power, 2.0 * power, power] {
            if value <= top && last - place(value) >= AXIS && place(value) >= AXIS {
                last = place(value);
                said.push(value);
            }
        }
        power /= 10.0;
    }
    said
}

/// The colour of a party by its number among those that have one; `None`: of all others.
pub(crate) fn colour_of(party: Option<usize>) -> &'static str {
    party.and_then(|party| COLOURS.get(party)).copied().unwrap_or(OTHERS)
}

/// A square in a colour.
pub(crate) fn swatch(colour: &str) -> String {
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
            BARS[0]
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
                BARS[number % 2],
            );
        }
    }
    let y = 26.0 * workers.len() as f64 + 14.0;
    inside += &label(LEFT, y, "start", "0");
    inside += &label(WIDTH - 20.0, y, "end", &format!("{end:.2} ms"));
    svg(y + 6.0, &inside, "Jobs on each worker over time")
}

#[cfg(test)]
mod tests {
    //! Labels of an axis do not touch, whatever the scale.

    use super::*;
    use geometry::rng::Rng;

    #[test]
    fn labels_of_an_axis_are_a_line_apart_and_lie_on_it() {
        let mut rng = Rng::new(11);
        for _ in 0..500 {
            let top = 10_f64.powf(rng.between(-7.0, 0.0));
            let said = axis(top, STRIP[2]);
            let mut places: Vec<f64> =
                said.iter().map(|value| STRIP[2] * (value / top).sqrt()).collect();
            places.sort_by(f64::total_cmp);
            assert!(places.len() >= 2, "{top}: {said:?}");
            assert!(places.windows(2).all(|pair| pair[1] - pair[0] >= AXIS), "{top}: {places:?}");
            assert!(places.iter().all(|place| (0.0..=STRIP[2]).contains(place)));
        }
    }
}
