//! What a deck says of its mass: lumped masses, and densities times volumes.
//!
//! ```text
//! *ELEMENT_MASS                                                     ──▶ a mass
//! *PART ─▶ *SECTION_SHELL: thickness, *MAT_…: density × area        ──▶ a mass
//! *PART ─▶ *MAT_…: density × volume of solids and thick shells      ──▶ a mass
//! ```
//!
//! A deck states no units. Its unit of mass is the one in which its mean density is that of
//! something that is built: units of mass are a thousand apart, solids from foam to lead less than
//! a hundred. The result is offered, and applied by nobody.

use super::super::LengthUnit;
use super::card::{Block, fields, mean, real, whole};
use std::collections::BTreeMap;

/// Densities of what vehicles are built of, in the mean (kg/m³): from wood to steel, with room.
const DENSITY: [f64; 2] = [300.0, 20_000.0];

/// Units of mass that decks are written in (kg).
const MASSES: [(&str, f64); 4] = [("kg", 1.0), ("t", 1000.0), ("g", 0.001), ("mg", 1e-6)];

/// Units of length and mass that decks are written in (m, kg): those of the manual's table of
/// consistent units. No density fits two of them.
const SYSTEMS: [(&str, f64, &str, f64); 5] = [
    ("mm", 0.001, "kg", 1.0),
    ("mm", 0.001, "t", 1000.0),
    ("m", 1.0, "kg", 1.0),
    ("mm", 0.001, "g", 0.001),
    ("cm", 0.01, "g", 0.001),
];

/// The parts of a deck that say what it weighs, in its own units.
#[derive(Default)]
pub(super) struct Masses {
    /// Density by material.
    pub(super) densities: BTreeMap<u64, f64>,
    /// Thickness by section of shells, the mean over corners.
    pub(super) thicknesses: BTreeMap<u64, f64>,
    /// Section and material by part.
    pub(super) parts: BTreeMap<u64, [u64; 2]>,
    /// Total mass by part, where the deck states that.
    pub(super) stated: BTreeMap<u64, f64>,
    /// Sum and number of lumped masses.
    pub(super) lumped: (f64, usize),
}

/// A piece of material: an area of a shell, or the volume of a solid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Piece {
    /// Area, and the thickness if the element states its own.
    Shell { area: f64, thickness: Option<f64> },
    /// Volume.
    Solid { volume: f64 },
}

/// The sum over a deck, in its own units.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Weighed {
    /// Mass of elements that have a density and a volume.
    pub(super) mass: f64,
    /// Volume of these.
    pub(super) volume: f64,
    /// Number of these.
    pub(super) elements: usize,
    /// Number of elements that lack one of the two.
    pub(super) unknown: usize,
    /// Masses that parts state, and the number of these parts.
    pub(super) stated: (f64, usize),
    /// Sum and number of lumped masses.
    pub(super) lumped: (f64, usize),
}

impl Masses {
    /// The density of a material: its first line has its number and that, whatever it is. What is
    /// no number is not needed for the surface, and is left out.
    pub(super) fn material(&mut self, block: &Block<'_>) {
        let first = usize::from(block.keyword.ends_with("_TITLE"));
        let Some((_, card)) = block.cards.get(first) else { return };
        let fields = fields(card, &[10; 8]);
        let density = fields.get(1).and_then(|text| real(text)).filter(|value| *value > 0.0);
        if let Some((id, density)) = whole(fields.first()).zip(density) {
            self.densities.insert(id, density);
        }
    }

    /// Thicknesses of sections of shells, two lines each and more if layers have angles.
    pub(super) fn section(&mut self, block: &Block<'_>) {
        let title = usize::from(block.keyword.ends_with("_TITLE"));
        let mut rest = block.cards.as_slice();
        while let Some([(_, head), (_, card), after @ ..]) = rest.get(title..) {
            let head = fields(head, &[10; 8]);
            let thickness = mean(&fields(card, &[10; 4]));
            if let Some((id, thickness)) = whole(head.first()).zip(thickness) {
                self.thicknesses.insert(id, thickness);
            }
            // ICOMP = 1: an angle for each of NIP points, eight a line.
            let number = |at: usize| head.get(at).and_then(|text| real(text)).unwrap_or(0.0);
            let points = if number(6) == 1.0 { number(3).clamp(0.0, 1e3) as usize } else { 0 };
            rest = after.get(points.div_ceil(8)..).unwrap_or_default();
        }
    }

    /// Lumped masses: number, node or set of nodes, mass.
    pub(super) fn lumped(&mut self, block: &Block<'_>, words: &[&str]) {
        // Those of parts are non-structural mass, spread as the card says.
        if words.contains(&"PART") {
            return;
        }
        for (_, card) in &block.cards {
            let mass = fields(card, &[8, 8, 16, 8]).get(2).and_then(|text| real(text));
            if let Some(mass) = mass.filter(|mass| *mass > 0.0) {
                self.lumped.0 += mass;
                self.lumped.1 += 1;
            }
        }
    }

    /// Adds up all pieces, each of a part.
    pub(super) fn weigh(&self, pieces: impl Iterator<Item = (u64, Piece)>) -> Weighed {
        let mut sum = Weighed { lumped: self.lumped, ..Weighed::default() };
        sum.stated = (self.stated.values().sum(), self.stated.len());
        for (part, piece) in pieces.filter(|(part, _)| !self.stated.contains_key(part)) {
            let [section, material] = self.parts.get(&part).copied().unwrap_or_default();
            let volume = match piece {
                Piece::Solid { volume } => Some(volume),
                Piece::Shell { area, thickness } => {
                    let usual = self.thicknesses.get(&section).copied();
                    thickness.or(usual).map(|thickness| area * thickness)
                }
            };
            match volume.zip(self.densities.get(&material)) {
                Some((volume, density)) if volume > 0.0 && *density > 0.0 => {
                    sum.mass += volume * density;
                    sum.volume += volume;
                    sum.elements += 1;
                }
                _ => sum.unknown += 1,
            }
        }
        sum
    }
}

impl Weighed {
    /// What is offered, in whole sentences; none if the deck says nothing of its mass. `unit` is
    /// the length of one unit of the deck.
    pub(super) fn notes(&self, unit: LengthUnit) -> Vec<String> {
        let total = self.mass + self.stated.0 + self.lumped.0;
        if !(total > 0.0 && total.is_finite()) {
            return Vec::new();
        }
        let mut of = Vec::new();
        let counted = [
            (self.elements, "elements with a density"),
            (self.lumped.1, "lines of *ELEMENT_MASS"),
            (self.stated.1, "parts that state their mass"),
        ];
        of.extend(counted.iter().filter(|(n, _)| *n > 0).map(|(n, what)| format!("{n} {what}")));
        let of = of.join(", ");
        let mut notes = Vec::new();
        match self.system(unit) {
            Some((length, mass, kg)) => {
                let kilograms = total * kg;
                let shown = rounded(kilograms);
                let found = format!(
                    "the deck weighs {shown} kg, if its units are {length} and {mass} as its \
                     densities suggest: {of}"
                );
                notes.push(format!("{found}; to use it, write mass_kg = {shown} into a side file"));
            }
            None => notes.push(format!(
                "the deck weighs {} in its own unit of mass, which its densities do not tell: {of}",
                rounded(total)
            )),
        }
        if self.unknown > 0 {
            let elements = self.unknown;
            notes.push(format!("{elements} elements without density or thickness not weighed"));
        }
        notes
    }

    /// Names of the units of length and mass in which the mean density is one of solids, and the
    /// unit of mass (kg): with this unit of length, or else in a usual system.
    fn system(&self, unit: LengthUnit) -> Option<(String, &'static str, f64)> {
        let is_of_solids = |metres: f64, kg: f64| {
            let density = self.mass / self.volume * kg / (metres * metres * metres);
            (DENSITY[0]..=DENSITY[1]).contains(&density)
        };
        let metres = unit.metres();
        if let Some((name, kg)) = MASSES.into_iter().find(|(_, kg)| is_of_solids(metres, *kg)) {
            return Some((unit.to_string(), name, kg));
        }
        let mut systems = SYSTEMS.into_iter();
        let found = systems.find(|(_, metres, _, kg)| is_of_solids(*metres, *kg));
        found.map(|(length, _, mass, kg)| (length.to_owned(), mass, kg))
    }
}

/// A mass with its digits that matter.
fn rounded(mass: f64) -> String {
    if mass < 100.0 { format!("{mass:.3}") } else { format!("{mass:.0}") }
}

/// Area of a triangle or quadrangle.
pub(super) fn area(corners: &[[f64; 3]]) -> f64 {
    // Half the product of the diagonals, which for a triangle is that of two sides.
    let [a, b, c, d] = match *corners {
        [a, b, c] => [a, b, c, a],
        [a, b, c, d] => [a, b, c, d],
        _ => return 0.0,
    };
    let (p, q) =
        if corners.len() == 3 { (minus(b, a), minus(c, a)) } else { (minus(c, a), minus(d, b)) };
    let [x, y, z] = cross(p, q);
    0.5 * (x * x + y * y + z * z).sqrt()
}

/// Volume inside of faces that close a body, each with three or four corners: the sum of the
/// tetrahedra over a corner of the body.
pub(super) fn volume<'f>(faces: impl Iterator<Item = &'f [[f64; 3]]>) -> f64 {
    let mut apex = None;
    let mut sum = 0.0;
    for face in faces {
        let apex = *apex.get_or_insert(face[0]);
        for i in 2..face.len() {
            let [a, b, c] = [face[0], face[i - 1], face[i]].map(|corner| minus(corner, apex));
            let [x, y, z] = cross(b, c);
            sum += a[0] * x + a[1] * y + a[2] * z;
        }
    }
    (sum / 6.0).abs()
}

fn minus(p: [f64; 3], q: [f64; 3]) -> [f64; 3] {
    [p[0] - q[0], p[1] - q[1], p[2] - q[2]]
}

fn cross(p: [f64; 3], q: [f64; 3]) -> [f64; 3] {
    [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]]
}

#[cfg(test)]
mod tests {
    //! Areas and volumes are those of known bodies; units are told by densities.
    use super::*;

    #[test]
    fn areas_and_volumes_of_known_bodies() {
        let square = [[0.0, 0.0, 1.0], [2.0, 0.0, 1.0], [2.0, 2.0, 1.0], [0.0, 2.0, 1.0]];
        assert_eq!(area(&square), 4.0);
        assert_eq!(area(&square[..3]), 2.0);
        let tip = [5.0, 7.0, 4.0];
        let sides = [0, 1, 2, 3].map(|i| vec![square[i], square[(i + 1) % 4], tip]);
        let base: Vec<[f64; 3]> = square.iter().rev().copied().collect();
        let faces = sides.iter().chain([&base]).map(Vec::as_slice);
        assert!((volume(faces) - 4.0).abs() < 1e-12, "a third of 4 × 3");
    }

    #[test]
    fn the_unit_of_mass_is_told_by_the_density() {
        let steel = |density: f64| Weighed {
            mass: density,
            volume: 1.0,
            elements: 1,
            ..Weighed::default()
        };
        let unit = |name: &str| name.parse::<LengthUnit>().expect("a unit");
        for (length, density, system) in [
            ("m", 7850.0, ("m", "kg")),
            ("mm", 7.85e-6, ("mm", "kg")),
            ("mm", 7.85e-9, ("mm", "t")),
            ("cm", 7.85, ("cm", "g")),
            ("mm", 7.85e-3, ("mm", "g")),
            // As it stands, or with a wrong unit.
            ("m", 7.85e-9, ("mm", "t")),
            ("m", 7.85e-6, ("mm", "kg")),
        ] {
            let found = steel(density).system(unit(length));
            let found = found.as_ref().map(|(length, mass, _)| (length.as_str(), *mass));
            assert_eq!(found, Some(system), "{length}, {density}");
        }
        assert_eq!(steel(1e30).system(unit("m")), None);
        let notes = steel(1e30).notes(unit("m"));
        assert!(notes[0].contains("which its densities do not tell"), "{notes:?}");
        assert_eq!(Weighed::default().notes(unit("m")), Vec::<String>::new());
    }
}
