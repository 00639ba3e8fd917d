//! What a body looks like from its size, and doubts about its unit and axes.
//!
//! A guess is shown to the user; nothing depends on it.

use super::LengthUnit;
use super::check::describe;
use body::Mesh;

/// What a body looks like.
#[derive(Clone, Debug, PartialEq)]
pub struct Guess {
    /// Length, width and height in metres.
    pub size_m: [f64; 3],
    /// "a car", "a person", ...; `None` if it looks like nothing known.
    pub looks_like: Option<&'static str>,
    /// Possible problems, in whole sentences; empty if there are none.
    pub doubts: Vec<String>,
}

impl core::fmt::Display for Guess {
    /// "4.62 × 2.01 × 1.39 m: a car".
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let looks = self.looks_like.unwrap_or("no road user or roadside object that is known");
        write!(f, "{}: {looks}", describe(self.size_m))
    }
}

/// A name and the usual length, width and height, each as least and greatest `[m]`.
type Shape = (&'static str, [[f64; 2]; 3]);

/// In the order in which they are tried. Widths include mirrors, heights include roof racks.
const SHAPES: [Shape; 7] = [
    ("a car", [[2.4, 6.0], [1.3, 2.4], [1.0, 2.3]]),
    ("a truck or bus", [[4.0, 20.0], [1.8, 3.3], [1.8, 4.5]]),
    ("a motorcycle or bicycle", [[1.3, 2.9], [0.3, 1.2], [0.8, 2.2]]),
    ("a person", [[0.1, 1.3], [0.25, 2.2], [0.8, 2.2]]),
    ("a pole or tree", [[0.02, 1.6], [0.02, 1.6], [2.0, 20.0]]),
    ("a wall or barrier", [[0.02, 1.2], [2.0, 100.0], [0.3, 5.0]]),
    ("a wall or barrier", [[2.0, 100.0], [0.02, 1.2], [0.3, 5.0]]),
];

pub(super) fn shape(size: [f64; 3]) -> Option<&'static str> {
    let fits = |ranges: &[[f64; 2]; 3]| {
        ranges.iter().zip(size).all(|([least, most], x)| (*least..=*most).contains(&x))
    };
    // A wheel is as high as a child, but also as long as it is high.
    let is_wheel = |name: &str| name == "a person" && size[2] < 1.4 * size[0];
    let shape = SHAPES.iter().find(|(name, ranges)| fits(ranges) && !is_wheel(name));
    shape.map(|(name, _)| *name)
}

/// Guesses what a body is; if it looks like nothing known, suggests what would change that.
#[must_use]
pub fn guess(mesh: &Mesh) -> Guess {
    let size = mesh.size_m();
    let looks_like = shape(size);
    let mut doubts = Vec::new();
    if looks_like.is_none() {
        doubts.extend(turned(size));
        doubts.extend(scaled(size));
        if doubts.is_empty() {
            doubts.push("check unit and axes: it has the size of nothing known".to_owned());
        }
    }
    doubts.extend(looks_like.and_then(|name| lies_on_its_side(name, size)).map(str::to_owned));
    Guess { size_m: size, looks_like, doubts }
}

/// Ranges overlap, so a car on its side still has the size of a car; its proportions differ.
fn lies_on_its_side(name: &str, [_, width, height]: [f64; 3]) -> Option<&'static str> {
    match name {
        "a car" if height > 1.2 * width => Some("it is taller than wide: check --up"),
        "a person" if width > 1.3 * height => Some("it is wider than tall: check --up"),
        _ => None,
    }
}

/// The first permutation of the axes that gives a known shape.
fn turned([x, y, z]: [f64; 3]) -> Option<String> {
    let ways = [
        ([y, x, z], "forward is probably the file's other horizontal axis"),
        ([x, z, y], "up is probably another axis: check --up"),
        ([z, x, y], "up and forward are probably other axes: check --up and --forward"),
        ([y, z, x], "up and forward are probably other axes: check --up and --forward"),
        ([z, y, x], "up and forward are probably other axes: check --up and --forward"),
    ];
    ways.iter().find_map(|(size, what)| {
        shape(*size).map(|name| format!("turned, it would look like {name}: {what}"))
    })
}

/// Every unit that gives a known shape, assuming the file was read in metres.
fn scaled(size: [f64; 3]) -> impl Iterator<Item = String> {
    let [_, units @ ..] = LengthUnit::NAMED;
    units.into_iter().filter_map(move |(unit, metres)| {
        shape(size.map(|x| x * metres))
            .map(|name| format!("in {unit} instead of metres, it would look like {name}"))
    })
}

#[cfg(test)]
mod tests;
