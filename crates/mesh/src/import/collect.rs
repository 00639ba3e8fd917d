//! The triangles from every reader: converted to the body frame, checked, counted, tagged with a
//! part.

use super::{FilePosition, Frame, ImportError, MeshDefect, polygon};
use body::file::COORDINATE_MAX_M;
use geometry::Corners;
use std::collections::BTreeMap;

/// Maximum number of triangles of one file.
pub const TRIANGLES_MAX: usize = 4_000_000;

/// Maximum number of parts of one file: `Mesh::part_of` is 16 bits wide.
const PARTS_MAX: usize = 1 << 16;

/// Maximum length of a part's name, in characters; longer ones are truncated.
const NAME_MAX: usize = 80;

/// A named part of a file, and the other names that select it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Part {
    pub(super) name: String,
    pub(super) aliases: Vec<String>,
}

impl Part {
    /// Whether a name given by the user selects this part.
    pub(super) fn is_named(&self, name: &str) -> bool {
        self.name == name || self.aliases.iter().any(|alias| alias == name)
    }
}

/// Triangles in file order; the number of a triangle is its source id.
pub(super) struct Collector<'a> {
    file: &'a str,
    frame: Frame,
    pub(super) corners: Vec<Corners>,
    pub(super) part_of: Vec<u16>,
    pub(super) parts: Vec<Part>,
    numbers: BTreeMap<(String, Vec<String>), u16>,
    triangulator: polygon::Triangulator,
    /// What was noticed and skipped, as text for the user.
    pub(super) notes: Vec<String>,
    /// The hash of the file and its side files.
    pub(super) hasher: blake3::Hasher,
}

impl<'a> Collector<'a> {
    pub(super) fn new(file: &'a str, frame: Frame) -> Self {
        Self {
            file,
            frame,
            corners: Vec::new(),
            part_of: Vec::new(),
            parts: Vec::new(),
            numbers: BTreeMap::new(),
            triangulator: polygon::Triangulator::new(),
            notes: Vec::new(),
            hasher: blake3::Hasher::new(),
        }
    }

    /// The name of the file without its folder.
    pub(super) fn file_name(&self) -> &str {
        super::base(self.file)
    }

    /// Unit of the file's coordinates.
    pub(super) fn unit(&self) -> super::LengthUnit {
        self.frame.unit
    }

    /// Creates an error in this file.
    pub(super) fn fail(&self, place: FilePosition, fault: MeshDefect) -> ImportError {
        ImportError::new(self.file, place, fault)
    }

    /// The index of the part with this name and these aliases; added if there is none.
    pub(super) fn part(&mut self, name: &str, aliases: Vec<String>) -> Result<u16, ImportError> {
        let name = if name.is_empty() { "unnamed" } else { name };
        let name: String = name.chars().take(NAME_MAX).collect();
        let key = (name, aliases);
        if let Some(number) = self.numbers.get(&key) {
            return Ok(*number);
        }
        let Ok(number) = u16::try_from(self.parts.len()) else {
            let max = PARTS_MAX as u64;
            let fault = MeshDefect::TooMany { what: "parts", count: max + 1, max };
            return Err(self.fail(FilePosition::Whole, fault));
        };
        self.parts.push(Part { name: key.0.clone(), aliases: key.1.clone() });
        self.numbers.insert(key, number);
        Ok(number)
    }

    /// Converts a point of the file to its stored form.
    pub(super) fn point(
        &self,
        point: [f64; 3],
        place: impl Fn() -> FilePosition,
    ) -> Result<[f32; 3], ImportError> {
        if let Some(value) = point.into_iter().find(|x| !x.is_finite()) {
            return Err(self.fail(place(), MeshDefect::NotFinite { value }));
        }
        let point = self.frame.point(point);
        let max = f64::from(COORDINATE_MAX_M);
        if let Some(metres) = point.into_iter().find(|x| !(x.abs() <= max)) {
            return Err(self.fail(place(), MeshDefect::TooFar { metres, max }));
        }
        Ok(point.map(|x| x as f32))
    }

    /// Adds one triangle.
    pub(super) fn triangle(&mut self, corners: Corners, part: u16) -> Result<(), ImportError> {
        if self.corners.len() >= TRIANGLES_MAX {
            let max = TRIANGLES_MAX as u64;
            let fault = MeshDefect::TooMany { what: "triangles", count: max + 1, max };
            return Err(self.fail(FilePosition::Whole, fault));
        }
        self.corners.push(corners);
        self.part_of.push(part);
        Ok(())
    }

    /// Adds the triangles of one polygon.
    pub(super) fn polygon(
        &mut self,
        points: &[[f32; 3]],
        part: u16,
        place: impl Fn() -> FilePosition,
    ) -> Result<(), ImportError> {
        if let [a, b, c] = points {
            return self.triangle([*a, *b, *c], part);
        }
        if points.len() < 3 {
            let fault = format!("a face with {} corners is not a surface", points.len());
            return Err(self.fail(place(), MeshDefect::Syntax(fault)));
        }
        if points.len() > polygon::CORNERS_MAX {
            let (count, max) = (points.len() as u64, polygon::CORNERS_MAX as u64);
            return Err(
                self.fail(place(), MeshDefect::TooMany { what: "corners of a face", count, max })
            );
        }
        let wide: Vec<[f64; 3]> = points.iter().map(|point| point.map(f64::from)).collect();
        let mut triangulator =
            core::mem::replace(&mut self.triangulator, polygon::Triangulator::new());
        for [a, b, c] in triangulator.cut(&wide) {
            self.triangle([points[*a], points[*b], points[*c]], part)?;
        }
        self.triangulator = triangulator;
        Ok(())
    }
}
