//! Maps as pictures: small fields of cells side by side, memory over the cost of a byte.
//!
//! Cells are told apart by colour and by a sign, so that they can be read in grey.

use super::verdict::Verdict;
use std::fmt::Write as _;

/// A cell's colour, and its sign or number.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Tile {
    pub(crate) colour: String,
    pub(crate) sign: String,
    pub(crate) is_dark: bool,
}

impl Tile {
    pub(crate) fn of_verdict(verdict: Verdict) -> Self {
        let (colour, sign, is_dark) = match verdict {
            Verdict::Holds => ("#0072B2", "+", true),
            Verdict::Fails => ("#F0A060", "–", false),
            Verdict::Open => ("#E6E6E6", "", false),
        };
        Self { colour: colour.to_owned(), sign: sign.to_owned(), is_dark }
    }

    /// A gain in percent: blue where it is one, orange where it is a loss.
    pub(crate) fn of_gain(gain: f64) -> Self {
        let percent = 100.0 * gain;
        let share = (percent.abs() / 40.0).clamp(0.0, 1.0);
        let [from, to] = if percent >= 0.0 {
            [[235.0, 243.0, 250.0], [0.0, 90.0, 160.0]]
        } else {
            [[252.0, 240.0, 228.0], [213.0, 94.0, 0.0]]
        };
        let mix = |number: usize| from[number] + share * (to[number] - from[number]);
        let colour = format!("rgb({:.0},{:.0},{:.0})", mix(0), mix(1), mix(2));
        let rounded = if percent.abs() < 0.5 { 0.0 } else { percent };
        Self { colour, sign: format!("{rounded:.0}"), is_dark: share > 0.6 }
    }
}

/// A picture of fields in rows and columns.
pub(crate) struct Panels<'p> {
    pub(crate) title: &'p str,
    pub(crate) key: &'p str,
    pub(crate) rows: Vec<String>,
    pub(crate) columns: Vec<String>,
    /// Labels of the cells of a field: costs of a byte, memories from the bottom up.
    pub(crate) x: Vec<String>,
    pub(crate) y: Vec<String>,
}

const CELL: [f64; 2] = [22.0, 17.0];
/// The least width, for title and key.
const WIDTH: f64 = 620.0;
const LEFT: f64 = 132.0;
const TOP: f64 = 112.0;
const GAP: f64 = 16.0;

impl Panels<'_> {
    /// Draws it (SVG). `tile` is called with row, column, x, y; `None` leaves a cell empty.
    pub(crate) fn draw(&self, tile: impl Fn(usize, usize, usize, usize) -> Option<Tile>) -> String {
        let [wide, high] = CELL;
        let field = [wide * self.x.len() as f64, high * self.y.len() as f64];
        let step = [field[0] + GAP, field[1] + GAP];
        let width = (LEFT + step[0] * self.columns.len() as f64 + 8.0).max(WIDTH);
        let height = TOP + step[1] * self.rows.len() as f64 + 42.0;
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width:.0}\" \
             height=\"{height:.0}\" viewBox=\"0 0 {width:.0} {height:.0}\" \
             font-family=\"Helvetica, Arial, sans-serif\" font-size=\"11\">\n\
             <rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n"
        );
        put(&mut svg, 12.0, 22.0, "start", " font-size=\"15\" font-weight=\"bold\"", self.title);
        for (number, line) in self.key.split('\n').enumerate() {
            let y = 42.0 + 15.0 * number as f64;
            put(&mut svg, 12.0, y, "start", " fill=\"#444444\"", line);
        }
        for (column, name) in self.columns.iter().enumerate() {
            let middle = LEFT + step[0] * column as f64 + field[0] / 2.0;
            for (number, line) in name.split('\n').enumerate() {
                let weight = if number == 0 { " font-weight=\"bold\"" } else { "" };
                let y = TOP - 22.0 + 14.0 * number as f64;
                put(&mut svg, middle, y, "middle", weight, line);
            }
            let foot = TOP + step[1] * self.rows.len() as f64 - GAP + 13.0;
            for (number, label) in self.x.iter().enumerate() {
                let x = LEFT + step[0] * column as f64 + wide * (number as f64 + 0.5);
                put(&mut svg, x, foot, "middle", " font-size=\"9\"", label);
            }
            put(&mut svg, middle, foot + 15.0, "middle", " fill=\"#444444\"", "ns a byte");
        }
        // Each kind of cell is written once, and used by number.
        let mut kinds: Vec<Tile> = Vec::new();
        for (row, name) in self.rows.iter().enumerate() {
            let top = TOP + step[1] * row as f64;
            for (number, line) in name.split('\n').enumerate() {
                let weight = if number == 0 { " font-weight=\"bold\"" } else { "" };
                put(&mut svg, 12.0, top + 14.0 + 14.0 * number as f64, "start", weight, line);
            }
            let lines = name.split('\n').count() as f64;
            put(
                &mut svg,
                12.0,
                top + 16.0 + 14.0 * lines,
                "start",
                " fill=\"#444444\"",
                "memory (%)",
            );
            for (number, label) in self.y.iter().enumerate() {
                let y = top + field[1] - high * (number as f64 + 0.5) + 3.5;
                put(&mut svg, LEFT - 5.0, y, "end", " font-size=\"9\"", label);
            }
            for column in 0..self.columns.len() {
                let left = LEFT + step[0] * column as f64;
                for (x, y) in (0..self.x.len()).flat_map(|x| (0..self.y.len()).map(move |y| (x, y)))
                {
                    let Some(tile) = tile(row, column, x, y) else { continue };
                    let (cx, cy) =
                        (left + wide * x as f64, top + field[1] - high * (y as f64 + 1.0));
                    let kind = kinds.iter().position(|known| *known == tile).unwrap_or_else(|| {
                        kinds.push(tile);
                        kinds.len() - 1
                    });
                    // Writing to a String cannot fail.
                    let _written =
                        writeln!(svg, "<use href=\"#t{kind}\" x=\"{cx:.0}\" y=\"{cy:.0}\"/>");
                }
            }
        }
        svg.push_str("<defs>\n");
        for (kind, Tile { colour, sign, is_dark }) in kinds.iter().enumerate() {
            let ink = if *is_dark { "#ffffff" } else { "#222222" };
            let _written = writeln!(
                svg,
                "<g id=\"t{kind}\"><rect width=\"{wide}\" height=\"{high}\" fill=\"{colour}\" \
                 stroke=\"#ffffff\"/><text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\" \
                 font-size=\"9\" fill=\"{ink}\">{sign}</text></g>",
                wide / 2.0,
                high / 2.0 + 3.2,
            );
        }
        svg.push_str("</defs>\n");
        svg.push_str("</svg>\n");
        svg
    }
}

/// Writes words at a place; `more` are further attributes.
fn put(svg: &mut String, x: f64, y: f64, anchor: &str, more: &str, words: &str) {
    // Writing to a String cannot fail.
    let _written = writeln!(
        svg,
        "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\"{more}>{}</text>",
        escaped(words)
    );
}

fn escaped(words: &str) -> String {
    words.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

#[cfg(test)]
mod tests {
    //! A picture has every cell that it is given, and words stay words.

    use super::*;

    #[test]
    fn every_cell_is_drawn_once_and_words_are_no_markup() {
        let panels = Panels {
            title: "a < b & c",
            key: "+ holds",
            rows: vec!["deep\nswap".to_owned()],
            columns: vec!["1".to_owned(), "2".to_owned()],
            x: vec!["0".to_owned(), "1".to_owned(), "2".to_owned()],
            y: vec!["5".to_owned(), "100".to_owned()],
        };
        let svg = panels.draw(|_, column, x, _| {
            (column == 0 || x < 2).then(|| Tile::of_verdict(Verdict::Holds))
        });
        assert_eq!(svg.matches("href=\"#t0\"").count(), 3 * 2 + 2 * 2);
        assert_eq!(svg.matches("#0072B2").count(), 1);
        assert!(svg.contains("a &lt; b &amp; c") && svg.ends_with("</svg>\n"));
        assert_eq!(Tile::of_gain(0.001).sign, "0");
        assert_eq!(Tile::of_gain(-0.001).sign, "0");
        assert_eq!(
            (Tile::of_gain(0.31).sign, Tile::of_gain(-0.2).sign),
            ("31".into(), "-20".into())
        );
    }
}
