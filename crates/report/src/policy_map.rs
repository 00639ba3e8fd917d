//! The picture of a map of policies: who wins over two numbers, one panel for each policy and set
//! of curves, as SVG or as a page.
//!
//! A colour is a candidate, the same in all panels; every cell is one ranking, and a dark line lies
//! where the winner flips. The cross is the scene as it is given.

use crate::html::{escape, framed};
use std::collections::BTreeSet;
use std::fmt::Write as _;
use trolley::policy::map::{MapAxis, MapCell, MapRow, PolicyMap};

/// Colours that differ in grey, too (Okabe and Ito, Color Universal Design, 2008).
const COLOURS: [&str; 8] =
    ["#56b4e9", "#e69f00", "#009e73", "#cc79a7", "#0072b2", "#f0e442", "#d55e00", "#999999"];
/// Panels beside each other.
const ACROSS: usize = 3;
/// Length of a panel's side.
const SIDE: f64 = 240.0;
/// Space for the axis at the left of a panel, and at the right, above and below.
const MARGIN: [f64; 4] = [66.0, 22.0, 46.0, 54.0];
/// Height of a line of the legend.
const LINE: f64 = 22.0;
/// Width of an average character at 13 px.
const CHARACTER: f64 = 7.0;

const STYLE: &str = "text{font:13px sans-serif;fill:#222}.title{font-weight:bold;font-size:15px}\
    .name{font-weight:bold}.flip{stroke:#222;stroke-width:1.6}.frame{fill:none;stroke:#222}\
    .cross{stroke:#000;stroke-width:2.2}.halo{stroke:#fff;stroke-width:5}";
/// Fills for who is no candidate: nobody, and not known.
const PATTERNS: &str = "<pattern id=\"nobody\" width=\"8\" height=\"8\" \
    patternUnits=\"userSpaceOnUse\" patternTransform=\"rotate(45)\"><rect width=\"8\" height=\"8\" \
    fill=\"#fff\"/><rect width=\"3\" height=\"8\" fill=\"#c44\"/></pattern><pattern id=\"unknown\" \
    width=\"6\" height=\"6\" patternUnits=\"userSpaceOnUse\"><rect width=\"6\" height=\"6\" \
    fill=\"#eee\"/><circle cx=\"3\" cy=\"3\" r=\"1.1\" fill=\"#777\"/></pattern>";

/// The map as one picture.
#[must_use]
pub fn svg(map: &PolicyMap) -> String {
    let panels: Vec<&MapRow> = map.rows.iter().filter(|row| !row.cells.is_empty()).collect();
    let width = MARGIN[0] + SIDE + MARGIN[1];
    let height = MARGIN[2] + SIDE + MARGIN[3];
    let across = panels.len().clamp(1, ACROSS);
    let whole = width * across as f64;
    let (title, mut y) = (format!("Who wins: {}", map.scenario.trim_end_matches('.')), 44.0);
    let mut inside = text(14.0, 26.0, "start", "title", &title);
    if let Some(axes) = map.axes {
        for (number, row) in panels.iter().enumerate() {
            let (column, line) = (number % ACROSS, number / ACROSS);
            let at = [width * column as f64, y + height * line as f64];
            panel(&mut inside, row, axes, at);
        }
        y += height * panels.len().div_ceil(ACROSS) as f64;
    }
    let used: BTreeSet<MapCell> = panels.iter().flat_map(|row| row.cells.concat()).collect();
    y = legend(&mut inside, map, &used, y, whole);
    let y = y + 8.0;
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {whole:.0} {y:.0}\" \
         width=\"{whole:.0}\" height=\"{y:.0}\" \
         role=\"img\" aria-label=\"{0}\"><title>{0}</title><style>{STYLE}</style>\
         <defs>{PATTERNS}</defs><rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>{inside}</svg>",
        escape(&title)
    )
}

/// The map as a page: the picture, and who wins as things are.
#[must_use]
pub fn page(map: &PolicyMap) -> String {
    let title = format!("Who wins: {}", map.scenario.trim_end_matches('.'));
    let mut body = format!("<h1>{}</h1>{}", escape(&title), svg(map));
    body.push_str("<table><tr><th>Policy</th><th>Curves</th><th>Wins</th><th>Last</th></tr>");
    for row in &map.rows {
        let winner = match (&row.winner, &row.fault) {
            (Some(winner), _) => winner.as_str(),
            (None, Some(fault)) => fault,
            (None, None) => "nobody",
        };
        let cells = [&row.policy, &row.curves, winner, row.last.as_deref().unwrap_or("–")];
        let cells = cells.map(|cell| format!("<td>{}</td>", escape(cell))).concat();
        let _w = write!(body, "<tr>{cells}</tr>");
        for note in &row.notes {
            let _w = write!(body, "<tr><td></td><td colspan=\"3\">{}</td></tr>", escape(note));
        }
    }
    body.push_str("</table>");
    framed(&title, &body, "", "")
}

fn text(x: f64, y: f64, anchor: &str, class: &str, said: &str) -> String {
    format!(
        "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\" class=\"{class}\">{}</text>",
        escape(said)
    )
}

/// At most so many characters.
fn short(said: &str, most: usize) -> String {
    if said.chars().count() <= most {
        return said.to_owned();
    }
    let kept: String = said.chars().take(most.saturating_sub(1)).collect();
    format!("{}…", kept.trim_end())
}

fn fill(cell: MapCell) -> String {
    match cell {
        MapCell::Winner(number) => COLOURS[number % COLOURS.len()].to_owned(),
        MapCell::Nobody => "url(#nobody)".to_owned(),
        MapCell::Unknown => "url(#unknown)".to_owned(),
    }
}

/// One policy with one set of curves; `at` is the corner of its space at the top left.
fn panel(inside: &mut String, row: &MapRow, [x, y]: [MapAxis; 2], at: [f64; 2]) {
    let [left, _, above, _] = MARGIN;
    let (x0, y0) = (at[0] + left, at[1] + above);
    let count = row.cells.len();
    let size = SIDE / count as f64;
    *inside += &text(x0, y0 - 24.0, "start", "name", &short(&row.policy, 34));
    *inside += &text(x0, y0 - 8.0, "start", "", &short(&format!("curves {}", row.curves), 34));
    // The cell of this column and row from below, as a rectangle's top left.
    let corner =
        |column: usize, up: usize| (x0 + size * column as f64, y0 + SIDE - size * (up + 1) as f64);
    for (up, cells) in row.cells.iter().enumerate() {
        for (column, cell) in cells.iter().enumerate() {
            let (cx, cy) = corner(column, up);
            let _w = write!(
                inside,
                "<rect x=\"{cx:.2}\" y=\"{cy:.2}\" width=\"{0:.2}\" height=\"{0:.2}\" fill=\"{1}\" \
                 shape-rendering=\"crispEdges\"/>",
                // Over its edge, so that no gap shines through.
                size + 0.4,
                fill(*cell)
            );
        }
    }
    flips(inside, row, size, &corner);
    let _w = write!(
        inside,
        "<rect x=\"{x0:.1}\" y=\"{y0:.1}\" width=\"{SIDE}\" height=\"{SIDE}\" class=\"frame\"/>"
    );
    // Values are those at the middles of cells.
    let place = |share: f64| size / 2.0 + share * (SIDE - size);
    for value in ticks(x) {
        let at = x0 + place(x.share(value));
        let _w = write!(
            inside,
            "<path d=\"M{at:.1} {0:.1}v5\" class=\"frame\"/>{1}",
            y0 + SIDE,
            text(at, y0 + SIDE + 19.0, "middle", "", &shown(x, value))
        );
    }
    for value in ticks(y) {
        let at = y0 + SIDE - place(y.share(value));
        let _w = write!(
            inside,
            "<path d=\"M{x0:.1} {at:.1}h-5\" class=\"frame\"/>{}",
            text(x0 - 9.0, at + 4.5, "end", "", &shown(y, value))
        );
    }
    *inside += &text(x0 + SIDE / 2.0, y0 + SIDE + 38.0, "middle", "", x.knob.says());
    let (turn_x, turn_y) = (at[0] + 16.0, y0 + SIDE / 2.0);
    let _w = write!(
        inside,
        "<g transform=\"rotate(-90 {turn_x:.1} {turn_y:.1})\">{}</g>",
        text(turn_x, turn_y, "middle", "", y.knob.says())
    );
    let is_inside = |share: &f64| (0.0..=1.0).contains(share);
    if let Some([gx, gy]) = row.given {
        let shares = [x.share(gx), y.share(gy)];
        if shares.iter().all(is_inside) {
            let (cx, cy) = (x0 + place(shares[0]), y0 + SIDE - place(shares[1]));
            for class in ["halo", "cross"] {
                let path = format!("M{:.1} {cy:.1}h14M{cx:.1} {:.1}v14", cx - 7.0, cy - 7.0);
                let _w = write!(inside, "<path d=\"{path}\" class=\"{class}\"/>");
            }
        }
    }
}

/// Lines between cells with other winners.
fn flips(
    inside: &mut String,
    row: &MapRow,
    size: f64,
    corner: &dyn Fn(usize, usize) -> (f64, f64),
) {
    let mut path = String::new();
    for (up, cells) in row.cells.iter().enumerate() {
        for (column, cell) in cells.iter().enumerate() {
            let (x, y) = corner(column, up);
            if cells.get(column + 1).is_some_and(|right| right != cell) {
                let _w = write!(path, "M{:.2} {y:.2}v{size:.2}", x + size);
            }
            let over = row.cells.get(up + 1).and_then(|above| above.get(column));
            if over.is_some_and(|above| above != cell) {
                let _w = write!(path, "M{x:.2} {y:.2}h{size:.2}");
            }
        }
    }
    let _w = write!(inside, "<path d=\"{path}\" class=\"flip\"/>");
}

/// Values that an axis names: of odds those between which there are factors of ten, two and five;
/// otherwise round ones.
fn ticks(axis: MapAxis) -> Vec<f64> {
    let is_inside = |value: &f64| axis.from * (1.0 - 1e-9) <= *value && *value <= axis.to + 1e-9;
    if axis.knob.is_odds() {
        let decades: Vec<f64> =
            (-3..=3).map(|power| libm::pow(10.0, f64::from(power))).filter(is_inside).collect();
        if decades.len() >= 3 {
            return decades;
        }
        let more = (-3..=3).flat_map(|power| {
            [1.0, 2.0, 5.0].map(|digit| digit * libm::pow(10.0, f64::from(power)))
        });
        return more.filter(is_inside).collect();
    }
    let span = axis.to - axis.from;
    let steps = (-4..=0)
        .flat_map(|power| [1.0, 2.0, 5.0].map(|digit| digit * libm::pow(10.0, f64::from(power))));
    let step = steps.into_iter().find(|step| span / step <= 6.0 + 1e-9).unwrap_or(span);
    let first = (axis.from / step - 1e-9).ceil() as i64;
    let last = (axis.to / step + 1e-9).floor() as i64;
    (first..=last).map(|k| k as f64 * step).collect()
}

/// A value of an axis as it is written: odds and speeds as factors, shares in percent.
fn shown(axis: MapAxis, value: f64) -> String {
    let is_factor = axis.knob.is_odds() || axis.knob.name() == "speed";
    let value = if is_factor { value } else { 100.0 * value };
    let text = format!("{value:.4}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// Who has which colour, of those who win anywhere; the height at which it ends.
fn legend(
    inside: &mut String,
    map: &PolicyMap,
    used: &BTreeSet<MapCell>,
    mut y: f64,
    whole: f64,
) -> f64 {
    let mut x = 14.0;
    let most = ((whole - 60.0) / CHARACTER) as usize;
    for cell in used {
        let said = match cell {
            MapCell::Winner(number) => {
                map.candidates.get(*number).map_or("?", String::as_str).to_owned()
            }
            MapCell::Nobody => "nobody: no way is acceptable".to_owned(),
            MapCell::Unknown => "not known".to_owned(),
        };
        let said = short(&said, most);
        let width = 34.0 + CHARACTER * said.chars().count() as f64 + 14.0;
        if x + width > whole && x > 14.0 {
            (x, y) = (14.0, y + LINE);
        }
        let _w = write!(
            inside,
            "<rect x=\"{x:.1}\" y=\"{:.1}\" width=\"24\" height=\"15\" fill=\"{}\" stroke=\"#222\" \
             stroke-width=\"0.6\"/>{}",
            y + 2.0,
            fill(*cell),
            text(x + 31.0, y + 14.0, "start", "", &said)
        );
        x += width;
    }
    let said = "Cross: as given. Every cell is one ranking; lines are where the winner flips.";
    *inside += &text(14.0, y + LINE + 14.0, "start", "", &short(said, most));
    y + 2.0 * LINE
}

#[cfg(test)]
mod tests;
