//! A picture in the making: lines, rings and labels that do not cover each other.

use noto_sans_mono_bitmap::{FontWeight, RasterHeight, get_raster, get_raster_width};

/// A picture this wide (pixels) is shown at half its size, and has larger letters.
const LARGE: usize = 1000;
/// What shows through around letters.
const HALO: [f64; 3] = [255.0, 255.0, 255.0];
/// Letters of a label, at most.
const LETTERS_MAX: usize = 24;
/// What is drawn for a letter that the font lacks.
const UNKNOWN: char = '?';

/// Pixels, and the rectangles that labels have taken: left, top, right, bottom.
pub(super) struct Canvas {
    size: [usize; 2],
    pixels: Vec<[f64; 3]>,
    /// Whether a pixel shows what is looked at: labels lie beside it where they can.
    is_shown: Vec<bool>,
    taken: Vec<[f64; 4]>,
    /// Those of `taken` that labels have, which no line to another label crosses.
    labels: Vec<[f64; 4]>,
    /// Those that lines to labels have, which others had better not cross.
    leads: Vec<[f64; 4]>,
    letters: RasterHeight,
}

impl Canvas {
    pub(super) fn new(size: [usize; 2], pixels: Vec<[f64; 3]>, is_shown: Vec<bool>) -> Self {
        debug_assert_eq!(pixels.len(), is_shown.len());
        let letters = if size[0] < LARGE { RasterHeight::Size20 } else { RasterHeight::Size32 };
        Self {
            size,
            pixels,
            is_shown,
            taken: Vec::new(),
            labels: Vec::new(),
            leads: Vec::new(),
            letters,
        }
    }

    /// How large marks are, beside those of a small picture.
    pub(super) fn scale(&self) -> f64 {
        self.letters.val() as f64 / RasterHeight::Size20.val() as f64
    }

    /// Three bytes a pixel.
    pub(super) fn bytes(self) -> Vec<u8> {
        self.pixels.into_iter().flatten().map(|part| part.round().clamp(0.0, 255.0) as u8).collect()
    }

    /// Lays a colour over a pixel, as strong as `share`.
    fn mix(&mut self, [x, y]: [i64; 2], colour: [f64; 3], share: f64) {
        let (Ok(x), Ok(y)) = (usize::try_from(x), usize::try_from(y)) else { return };
        if x < self.size[0] && y < self.size[1] {
            let pixel = &mut self.pixels[y * self.size[0] + x];
            *pixel = [0, 1, 2].map(|c| pixel[c] + share * (colour[c] - pixel[c]));
        }
    }

    /// Keeps labels away from a line.
    pub(super) fn keep_clear(&mut self, [a, b, _]: [f64; 3], [c, d, _]: [f64; 3]) {
        // So many that there are no gaps, and no more than a picture has pixels.
        let steps = (f64::hypot(c - a, d - b) / 5.0).ceil().clamp(1.0, 20_000.0);
        for step in 0..=steps as u32 {
            let share = f64::from(step) / steps;
            let (x, y) = (a + share * (c - a), b + share * (d - b));
            self.taken.push([x - 5.0, y - 5.0, x + 5.0, y + 5.0]);
        }
    }

    /// A line, two pixels wide.
    pub(super) fn line(&mut self, [a, b, _]: [f64; 3], [c, d, _]: [f64; 3], colour: [f64; 3]) {
        let steps = (2.0 * (c - a).abs().max((d - b).abs())).ceil().clamp(1.0, 20_000.0);
        for step in 0..=steps as u32 {
            let share = f64::from(step) / steps;
            let (x, y) = (a + share * (c - a), b + share * (d - b));
            for (i, j) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
                self.mix([x.floor() as i64 + i, y.floor() as i64 + j], colour, 1.0);
            }
        }
    }

    /// A circle three pixels wide with a light edge.
    pub(super) fn circle(&mut self, [x, y]: [f64; 2], radius: f64, colour: [f64; 3]) {
        let reach = (radius + 5.0).ceil().min(20_000.0) as i64;
        for j in -reach..=reach {
            for i in -reach..=reach {
                let at = [x.floor() as i64 + i, y.floor() as i64 + j];
                let from = f64::hypot(at[0] as f64 + 0.5 - x, at[1] as f64 + 0.5 - y);
                let off = (from - radius).abs();
                // Full within the width, and one pixel of transition.
                self.mix(at, HALO, (3.5 - off).clamp(0.0, 1.0) * 0.8);
                self.mix(at, colour, (2.0 - off).clamp(0.0, 1.0));
                if off < 6.0 {
                    self.show(at);
                }
            }
        }
    }

    /// Keeps labels beside a pixel where they can be.
    fn show(&mut self, [x, y]: [i64; 2]) {
        let (Ok(x), Ok(y)) = (usize::try_from(x), usize::try_from(y)) else { return };
        if x < self.size[0] && y < self.size[1] {
            self.is_shown[y * self.size[0] + x] = true;
        }
    }

    /// How many pixels of a rectangle in the picture show what is looked at.
    fn shown(&self, room: &[f64; 4]) -> usize {
        let [left, top, right, bottom] = room.map(|edge| edge as usize);
        let rows = self.is_shown.chunks(self.size[0].max(1)).take(bottom).skip(top);
        rows.map(|row| row[left..right].iter().filter(|is_shown| **is_shown).count()).sum()
    }

    /// A text beside a point, `by` pixels away, where no other label is, and as little as can be of
    /// what is looked at; its rectangle, which lies in the picture. `None`: there is no room.
    pub(super) fn label(
        &mut self,
        [x, y]: [f64; 2],
        by: f64,
        text: &str,
        colour: [f64; 3],
    ) -> Option<[f64; 4]> {
        let letters: Vec<char> = cut(text);
        let letter = get_raster_width(FontWeight::Regular, self.letters);
        let (width, gap) = ((letters.len() * letter) as f64, letter as f64);
        let height = self.letters.val() as f64;
        let step = 0.8 * height;
        // As far away as half the picture is long.
        let rings = 1 + (0.5 * self.size[0].max(self.size[1]) as f64 / step) as u32;
        let tries = (0..rings).flat_map(|ring| {
            let by = by + step * f64::from(ring);
            [
                [x - 0.5 * width, y - by - height],
                [x - 0.5 * width, y + by],
                [x + by, y - 0.5 * height],
                [x - by - width, y - 0.5 * height],
            ]
        });
        let size = self.size.map(|size| size as f64);
        // A point at the edge of the picture has its label inside.
        let inside = |[left, top]: [f64; 2]| {
            let left = left.clamp(4.0, (size[0] - width - 4.0).max(4.0)).round();
            let top = top.clamp(4.0, (size[1] - height - 4.0).max(4.0)).round();
            [left, top, left + width, top + height]
        };
        let is_free = |room: &[f64; 4]| {
            let apart = |a: &[f64; 4]| {
                a[0] - gap >= room[2] || room[0] >= a[2] + gap || a[1] >= room[3] || room[1] >= a[3]
            };
            room[2] <= size[0] && room[3] <= size[1] && self.taken.iter().all(apart)
        };
        // A line leads from the point to a label that is not beside it, and crosses no other one.
        let lead = |room: &[f64; 4]| {
            let end = [x.clamp(room[0], room[2]), y.clamp(room[1], room[3])];
            let away = f64::hypot(end[0] - x, end[1] - y);
            // It begins where the label would lie if there were room, and ends before its letters.
            let [from, to] = [(by - 8.0) / away, (away - 0.3 * height) / away];
            (away > by + 1.5 * height).then(|| {
                [from, to].map(|share| [x + share * (end[0] - x), y + share * (end[1] - y), 0.0])
            })
        };
        let crosses = |room: &[f64; 4], what: &[[f64; 4]]| {
            lead(room).is_some_and(|[a, b]| {
                let mut points = (0..=64).map(|step| {
                    let share = f64::from(step) / 64.0;
                    [a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])]
                });
                points.any(|[p, q]| {
                    // A line is two pixels wide.
                    let holds = |label: &[f64; 4]| {
                        label[0] - 3.0 <= p
                            && p <= label[2] + 2.0
                            && label[1] - 3.0 <= q
                            && q <= label[3] + 2.0
                    };
                    what.iter().any(holds)
                })
            })
        };
        // The first of those that are equally good is the nearest.
        let free = tries.map(inside).filter(is_free);
        let free = free.filter(|room| !crosses(room, &self.labels));
        // Lines that cross are as bad as a quarter of the label on what is looked at.
        let crossing = (0.25 * width * height) as usize;
        let cost = |room: &[f64; 4]| {
            self.shown(room) + if crosses(room, &self.leads) { crossing } else { 0 }
        };
        let room = free.min_by_key(cost)?;
        self.taken.push(room);
        self.labels.push(room);
        if let Some([from, to]) = lead(&room) {
            self.line(from, to, colour);
            let before = self.taken.len();
            self.keep_clear(from, to);
            self.leads.extend_from_slice(&self.taken[before..]);
        }
        self.write(&letters, [room[0], room[1]], colour);
        Some(room)
    }

    fn write(&mut self, letters: &[char], [left, top]: [f64; 2], colour: [f64; 3]) {
        let mut strokes: Vec<([i64; 2], f64)> = Vec::new();
        for (number, letter) in letters.iter().enumerate() {
            let raster = |c: char| get_raster(c, FontWeight::Regular, self.letters);
            let Some(raster) = raster(*letter).or_else(|| raster(UNKNOWN)) else { continue };
            let x = left as i64 + (number * raster.width()) as i64;
            for (j, row) in raster.rows().enumerate() {
                let marks = row.iter().enumerate().filter(|(_, strength)| **strength > 0);
                strokes.extend(marks.map(|(i, strength)| {
                    ([x + i as i64, top as i64 + j as i64], f64::from(*strength) / 255.0)
                }));
            }
        }
        for ([x, y], strength) in &strokes {
            for (i, j) in [(-1, 0), (1, 0), (0, -1), (0, 1), (-1, -1), (1, 1), (-1, 1), (1, -1)] {
                self.mix([x + i, y + j], HALO, 0.7 * strength);
            }
        }
        for (at, strength) in strokes {
            self.mix(at, colour, strength);
        }
    }
}

/// At most so many letters, and the last one says that some are missing.
fn cut(text: &str) -> Vec<char> {
    let mut letters: Vec<char> = text.chars().take(LETTERS_MAX + 1).collect();
    if letters.len() > LETTERS_MAX {
        letters.truncate(LETTERS_MAX - 2);
        letters.extend(['.', '.']);
    }
    letters
}

#[cfg(test)]
mod tests {
    //! Labels lie in the picture and do not cover each other, whatever they say.

    use super::*;
    use geometry::rng::Rng;

    /// 300 by 200 pixels, of which some show what is looked at.
    fn canvas(is_shown: impl Fn([usize; 2]) -> bool) -> Canvas {
        let shown = (0..300 * 200).map(|at| is_shown([at % 300, at / 300])).collect();
        Canvas::new([300, 200], vec![[250.0; 3]; 300 * 200], shown)
    }

    #[test]
    fn a_label_lies_beside_what_is_looked_at() {
        // Bodies fill the left half but for its lowest part.
        let mut canvas = canvas(|[x, y]| x < 150 && y < 150);
        for text in ["ego", "2 m; grid 1 m"] {
            let [left, top, ..] = canvas.label([70.0, 90.0], 10.0, text, [0.0; 3]).expect("room");
            assert!(left >= 150.0 || top >= 150.0, "{text}: {left}, {top}");
        }
        canvas.circle([225.0, 100.0], 40.0, [0.0; 3]);
        let room = canvas.label([225.0, 75.0], 10.0, "suv", [0.0; 3]).expect("room");
        let crosses = |[x, y]: [f64; 2]| (f64::hypot(x - 225.0, y - 100.0) - 40.0).abs() < 2.0;
        let steps =
            |from: f64, to: f64| (0..=40).map(move |k| from + (to - from) * f64::from(k) / 40.0);
        let mut points =
            steps(room[0], room[2]).flat_map(|x| steps(room[1], room[3]).map(move |y| [x, y]));
        assert!(!points.any(crosses), "{room:?}");
    }

    #[test]
    fn a_line_to_a_label_crosses_no_other_label() {
        // All of the picture but its upper edge is looked at, so labels gather there.
        let (mut rng, mut count) = (Rng::new(7), 0);
        for _ in 0..50 {
            let mut canvas = canvas(|[_, y]| y > 60);
            let mut rooms = Vec::new();
            let mut colours = Vec::new();
            for (number, text) in ["oncoming", "ego", "contact"].into_iter().enumerate() {
                let at = [rng.between(100.0, 200.0), rng.between(110.0, 190.0)];
                let colour = [10.0 + number as f64, 0.0, 0.0];
                let Some(room) = canvas.label(at, 10.0, text, colour) else { continue };
                rooms.push(room);
                colours.push(colour);
            }
            for (number, room) in rooms.iter().enumerate() {
                let of_others = colours.iter().enumerate().filter(|(k, _)| *k != number);
                for (_, colour) in of_others {
                    let inside = (0..300 * 200).filter(|at| {
                        let [x, y] = [(at % 300) as f64, (at / 300) as f64];
                        room[0] <= x && x < room[2] && room[1] <= y && y < room[3]
                    });
                    let strokes = inside.filter(|at| canvas.pixels[*at] == *colour).count();
                    assert_eq!(strokes, 0, "{rooms:?}");
                }
            }
            count += rooms.len();
        }
        assert!(count > 100, "{count}");
    }

    #[test]
    fn a_line_to_a_label_does_not_cross_another_line() {
        // A body, and little of it at its upper edge: that label would have the shortest line.
        let mut canvas = canvas(|[x, y]| (60..240).contains(&x) && (70..190).contains(&y));
        canvas.label([150.0, 150.0], 10.0, "ego", [1.0, 0.0, 0.0]).expect("room");
        assert!(!canvas.leads.is_empty(), "a line leads to it");
        let before = canvas.pixels.clone();
        canvas.label([170.0, 110.0], 10.0, "car 203", [2.0, 0.0, 0.0]).expect("room");
        let is_line = |pixel: &[f64; 3]| *pixel == [1.0, 0.0, 0.0];
        let lost = before.iter().zip(&canvas.pixels).filter(|(a, b)| is_line(a) && a != b);
        assert_eq!(lost.count(), 0, "nothing is drawn over the first line");
    }

    #[test]
    fn no_label_lies_on_a_line_however_long_it_is() {
        let mut canvas = canvas(|_| false);
        let (from, to) = ([10.0, 190.0, 0.0], [290.0, 30.0, 0.0]);
        canvas.line(from, to, [0.0; 3]);
        canvas.keep_clear(from, to);
        for k in 0..12 {
            let x = 20.0 + 20.0 * f64::from(k);
            let at = [x, 190.0 - (x - 10.0) * 160.0 / 280.0];
            let Some(room) = canvas.label(at, 6.0, "2 m", [0.0; 3]) else { continue };
            for step in 0..=300 {
                let share = f64::from(step) / 300.0;
                let [p, q] = [10.0 + 280.0 * share, 190.0 - 160.0 * share];
                let is_on = room[0] < p && p < room[2] && room[1] < q && q < room[3];
                assert!(!is_on, "{room:?} at {p}, {q}");
            }
        }
    }

    #[test]
    fn labels_lie_inside_and_apart() {
        let mut rng = Rng::new(5);
        for _ in 0..50 {
            let mut canvas = canvas(|_| false);
            let mut kept: Vec<[f64; 4]> = Vec::new();
            for text in ["suv", "a very long name of somebody who is met", "\u{4e09}\u{202e}", ""] {
                let at = [rng.between(-50.0, 350.0), rng.between(-50.0, 250.0)];
                let Some(room) = canvas.label(at, 10.0, text, [0.0; 3]) else { continue };
                assert!(room[0] >= 0.0 && room[1] >= 0.0, "{room:?}");
                assert!(room[2] <= 300.0 && room[3] <= 200.0, "{room:?}");
                let apart = |a: &[f64; 4]| {
                    a[0] >= room[2] || room[0] >= a[2] || a[1] >= room[3] || room[1] >= a[3]
                };
                assert!(kept.iter().all(apart), "{kept:?} {room:?}");
                kept.push(room);
            }
            assert!(kept.len() >= 2);
            assert_eq!(canvas.bytes().len(), 300 * 200 * 3);
        }
    }
}
