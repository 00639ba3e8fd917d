//! Generated bodies: closed, vehicle-shaped or person-shaped, with the same bits on every machine.
//!
//! ```text
//! Shape, seed --draft--> Blueprint (components: tubes, tori, pads over control nets)
//! Blueprint --fit--> nominal size --plan(triangles)--> cells per component --sample--> Mesh
//! ```
//!
//! A shape is a set of smooth surfaces; the triangle count only sets how finely they are sampled,
//! so meshes of 25,000 and 100,000 triangles represent the same body.
//!
//! # Invariants (`tests.rs`)
//!
//! - Each component is closed: every edge is shared by exactly two of its triangles, in opposite
//!   directions, counter-clockwise seen from outside. Components overlap where a wheel meets a
//!   body; they are not united.
//! - The count is the requested one if it is even, else one less: a closed triangle mesh has an
//!   even number of triangles.
//! - No triangle has zero area, none occurs twice, the lowest point has z = 0.
//! - Equal arguments give equal bits: f64 sums, products and square roots, sines from `libm`, one
//!   rounding to f32 at the end.

mod barrier;
mod bicycle;
mod blueprint;
mod bus;
mod car;
mod figure;
mod motorcycle;
mod net;
mod ruler;
mod sedan;
mod solids;
mod soup;
mod surface;
mod suv;
#[cfg(test)]
mod tests;
mod truck;
mod variation;

use blueprint::{Blueprint, Component, Fit};
use body::{Mesh, Shape};
use diagnostic::{Diagnostic, FailureKind};
use geometry::DVec3;
use soup::{Soup, Splits};
use std::borrow::Cow;
use std::fmt;
use surface::{Cells, Rulers};
use variation::Variation;

/// Minimum number of triangles of a generated body.
pub const TRIANGLES_MIN: u32 = 500;
/// Maximum number of triangles of a generated body.
pub const TRIANGLES_MAX: u32 = 1_000_000;
/// The triangle count at which a shape is measured before it is fitted to its size.
const REFERENCE: u32 = 20_000;
/// Maximum relative deviation of the size of a seeded body from the nominal one.
const SPREAD: f64 = 0.03;

/// The error of generating a body. As text: the problem and, after a colon, the remedy.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum GenerateError {
    /// The count is out of range.
    Count {
        /// The requested shape.
        shape: Shape,
        /// The requested count.
        triangles: u32,
    },
}

impl Diagnostic for GenerateError {
    fn kind(&self) -> FailureKind {
        FailureKind::Input
    }

    fn what(&self) -> String {
        let Self::Count { shape, triangles } = self;
        format!("a generated {shape} cannot have {triangles} triangles")
    }

    fn remedy(&self) -> Option<Cow<'_, str>> {
        Some(format!("ask for {TRIANGLES_MIN} to {TRIANGLES_MAX}").into())
    }
}

impl fmt::Display for GenerateError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.what())?;
        self.remedy().map_or(Ok(()), |remedy| write!(f, ": {remedy}"))
    }
}

impl std::error::Error for GenerateError {}

/// The call that generates a body, as text: the value of `Meta::origin` for a generated body.
#[must_use]
pub fn call(shape: Shape, triangles: u32, seed: u64) -> String {
    format!("generate {shape} triangles={triangles} seed={seed}")
}

/// Generates a body in metres, x forward, y left, z up, with the origin on the ground in the middle
/// of the plan.
///
/// `triangles` lies in [`TRIANGLES_MIN`]..=[`TRIANGLES_MAX`]; an odd count gives one triangle less.
/// Seed 0 is the nominal body of [`Shape::size_m`]; other seeds vary size and proportions by a few
/// per cent. Parts are named.
///
/// # Errors
///
/// [`GenerateError::Count`] if the count is out of range.
pub fn generate(shape: Shape, triangles: u32, seed: u64) -> Result<Mesh, GenerateError> {
    if !(TRIANGLES_MIN..=TRIANGLES_MAX).contains(&triangles) {
        return Err(GenerateError::Count { shape, triangles });
    }
    let blueprint = fitted(shape, seed);
    let plan = Plan::new(&blueprint, triangles);
    let (soup, ends) = plan.sample(&blueprint);
    Ok(mesh(&blueprint, &soup, &ends))
}

fn draft(shape: Shape, variation: &mut Variation) -> Blueprint {
    match shape {
        Shape::Sedan => sedan::draft(variation),
        Shape::Suv => suv::draft(variation),
        Shape::Truck => truck::draft(variation),
        Shape::Bus => bus::draft(variation),
        Shape::Motorcycle => motorcycle::draft(variation),
        Shape::Cyclist => bicycle::draft(variation),
        Shape::Pedestrian => figure::draft(variation),
        Shape::Wall => barrier::wall(variation),
        Shape::Pole => barrier::pole(variation),
    }
}

/// The shape, stretched to its size and moved to its origin.
fn fitted(shape: Shape, seed: u64) -> Blueprint {
    let mut variation = Variation::new(seed);
    let goal = shape.size_m().map(|size| size * (1.0 + variation.next(SPREAD)));
    let mut blueprint = draft(shape, &mut variation);
    let plan = Plan::new(&blueprint, REFERENCE);
    let (soup, ends) = plan.sample(&blueprint);
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let mut first = 0;
    for (component, end) in blueprint.components.iter().zip(&ends) {
        if component.fit != Fit::Beside {
            for point in &soup.vertices[first..end.vertices] {
                (low, high) = (low.min(*point), high.max(*point));
            }
        }
        first = end.vertices;
    }
    let origin = DVec3::new(0.5 * (low.x + high.x), 0.5 * (low.y + high.y), low.z);
    let size = high - low;
    let scale = if shape.is_stretched() {
        DVec3::new(goal[0] / size.x, goal[1] / size.y, goal[2] / size.z)
    } else {
        DVec3::splat(goal[2] / size.z)
    };
    for component in &mut blueprint.components {
        let centre = component.surface.centre();
        let round = component.fit == Fit::Round;
        component.surface = component.surface.map(|p| {
            if round {
                (centre - origin) * scale + (p - centre) * scale.z
            } else {
                (p - origin) * scale
            }
        });
    }
    blueprint
}

/// The sampling density of each component.
struct Plan {
    rulers: Vec<Rulers>,
    cells: Vec<Cells>,
    splits: Splits,
}

/// Where a component ends in the soup.
struct End {
    vertices: usize,
    triangles: usize,
}

impl Plan {
    /// Creates the finest plan with at most `triangles`; the remainder is spread over split quads.
    fn new(blueprint: &Blueprint, triangles: u32) -> Self {
        let quads_max = u64::from(triangles / 2);
        let parts = &blueprint.components;
        let rulers: Vec<Rulers> = parts.iter().map(|part| part.surface.rulers()).collect();
        let cells = |fineness: f64| -> Vec<Cells> {
            let pairs = rulers.iter().zip(parts);
            pairs.map(|(ruler, part)| ruler.cells(fineness, part.least)).collect()
        };
        let quads = |cells: &[Cells]| -> u64 {
            rulers.iter().zip(cells).map(|(ruler, cells)| ruler.quads(*cells)).sum()
        };
        // Cells only grow with fineness, so halving the range 48 times finds the finest plan that
        // fits.
        let (mut low, mut high) = (0.0, 10_000.0);
        for _ in 0..48 {
            let middle = 0.5 * (low + high);
            if quads(&cells(middle)) <= quads_max { low = middle } else { high = middle }
        }
        let cells = cells(low);
        let quads = quads(&cells);
        Self { rulers, cells, splits: Splits::new(quads, quads_max.saturating_sub(quads)) }
    }

    /// Samples all components; returns where each ends.
    fn sample(&self, blueprint: &Blueprint) -> (Soup, Vec<End>) {
        let mut soup = Soup::new(self.splits);
        let parts = blueprint.components.iter().zip(&self.rulers).zip(&self.cells);
        let ends = parts
            .map(|((part, rulers), cells)| {
                part.surface.sample(rulers, *cells, &mut soup);
                End { vertices: soup.vertices.len(), triangles: soup.triangles.len() }
            })
            .collect();
        (soup, ends)
    }
}

/// Rounds to f32 and moves the lowest point to the ground.
fn mesh(blueprint: &Blueprint, soup: &Soup, ends: &[End]) -> Mesh {
    let ground = soup.vertices.iter().fold(f64::INFINITY, |low, p| low.min(p.z));
    let rounded: Vec<[f32; 3]> =
        soup.vertices.iter().map(|p| [p.x, p.y, p.z - ground].map(|x| x as f32 + 0.0)).collect();
    let corners = soup.triangles.iter().map(|t| t.map(|v| rounded[v as usize])).collect();
    let mut parts: Vec<String> = Vec::new();
    let mut part_of = Vec::with_capacity(soup.triangles.len());
    for (Component { part, .. }, end) in blueprint.components.iter().zip(ends) {
        let number = parts.iter().position(|known| known == part).unwrap_or_else(|| {
            parts.push(part.clone());
            parts.len() - 1
        });
        part_of.resize(end.triangles, number as u16);
    }
    let source_ids = (0..soup.triangles.len() as u32).collect();
    Mesh { corners, source_ids, part_of, parts, dropped: Vec::new(), degenerate: 0 }
}
