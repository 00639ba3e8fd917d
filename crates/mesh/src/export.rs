//! A body as a mesh file for other programs: STL, PLY or OBJ.
//!
//! Triangles are in the order of their source ids, so that importing the file again gives the same
//! triangles in the same order, bit for bit, numbered from 0. Lengths are metres, x forward, y
//! left, z up: import without options.

use body::{BodyView, Meta};
use geometry::Corners;
use std::fmt::Write as _;

/// A format that can be written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ExportFormat {
    /// Binary STL.
    Stl,
    /// Binary little-endian PLY.
    Ply,
    /// OBJ, with parts as groups.
    Obj,
}

impl ExportFormat {
    /// Every format.
    pub const ALL: [Self; 3] = [Self::Stl, Self::Ply, Self::Obj];

    /// The extension, which is also the name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Stl => "stl",
            Self::Ply => "ply",
            Self::Obj => "obj",
        }
    }
}

/// The text is not the name of an [`ExportFormat`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("\"{0}\" cannot be written: one of stl, ply, obj")]
pub struct UnknownExportFormat(pub String);

impl core::str::FromStr for ExportFormat {
    type Err = UnknownExportFormat;

    fn from_str(text: &str) -> Result<Self, UnknownExportFormat> {
        let found = Self::ALL.into_iter().find(|format| format.name() == text);
        found.ok_or_else(|| UnknownExportFormat(text.to_owned()))
    }
}

/// Encodes a mesh file with all triangles of a body.
#[must_use]
pub fn write(format: ExportFormat, meta: &Meta, body: &BodyView<'_>) -> Vec<u8> {
    let order = source_order(body);
    match format {
        ExportFormat::Stl => stl(&order, body),
        ExportFormat::Ply => ply(&order, meta, body),
        ExportFormat::Obj => obj(&order, meta, body),
    }
}

/// Indices of triangles, ascending by source id.
fn source_order(body: &BodyView<'_>) -> Vec<usize> {
    let mut order: Vec<usize> = (0..body.corners.len()).collect();
    order.sort_unstable_by_key(|at| body.source_ids[*at]);
    order
}

fn stl(order: &[usize], body: &BodyView<'_>) -> Vec<u8> {
    let facets: Vec<stl_io::Triangle> = order
        .iter()
        .map(|at| stl_io::Triangle {
            normal: stl_io::Normal::new(normal(&body.corners[*at])),
            vertices: body.corners[*at].map(stl_io::Vertex::new),
        })
        .collect();
    let mut bytes = Vec::with_capacity(84 + 50 * facets.len());
    // Writing to a vector cannot fail.
    let written = stl_io::write_stl(&mut bytes, facets.iter());
    debug_assert!(written.is_ok());
    bytes
}

/// Unit normal by the right-hand rule; zero for a triangle without area, as the format allows.
fn normal(corners: &Corners) -> [f32; 3] {
    let [a, b, c] = corners.map(|corner| corner.map(f64::from));
    let (u, v) = ([0, 1, 2].map(|i| b[i] - a[i]), [0, 1, 2].map(|i| c[i] - a[i]));
    let n = [0, 1, 2].map(|i| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        u[j] * v[k] - u[k] * v[j]
    });
    let length = (n[0] * n[0] + n[1] * n[1] + n[2] * n[2]).sqrt();
    if length > 0.0 { n.map(|x| (x / length) as f32) } else { [0.0; 3] }
}

/// Positions without repetition, in the order of first use, and three indices per triangle.
/// Positions are equal if their bits are: −0 stays −0.
fn indexed(order: &[usize], body: &BodyView<'_>) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    let all: Vec<[f32; 3]> = order.iter().flat_map(|at| body.corners[*at]).collect();
    let mut sorted: Vec<u32> = (0..all.len() as u32).collect();
    let bits = |at: u32| all[at as usize].map(f32::to_bits);
    sorted.sort_unstable_by_key(|at| (bits(*at), *at));
    let mut first = vec![0_u32; all.len()];
    for group in sorted.chunk_by(|a, b| bits(*a) == bits(*b)) {
        for at in group {
            first[*at as usize] = group[0];
        }
    }
    let mut points = Vec::new();
    let mut number = vec![0_u32; all.len()];
    for (at, first) in first.iter().enumerate() {
        if *first as usize == at {
            number[at] = points.len() as u32;
            points.push(all[at]);
        } else {
            // The first occurrence comes earlier, so it has its number.
            number[at] = number[*first as usize];
        }
    }
    let (triangles, _) = number.as_chunks::<3>();
    (points, triangles.to_vec())
}

fn ply(order: &[usize], meta: &Meta, body: &BodyView<'_>) -> Vec<u8> {
    let (points, triangles) = indexed(order, body);
    let mut bytes = format!(
        "ply\nformat binary_little_endian 1.0\ncomment {}\n\
         comment metres, x forward, y left, z up\n\
         element vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
         element face {}\nproperty list uchar uint vertex_indices\nend_header\n",
        one_line(&meta.name),
        points.len(),
        triangles.len()
    )
    .into_bytes();
    bytes.extend_from_slice(bytemuck::cast_slice(&points));
    for triangle in &triangles {
        bytes.push(3);
        bytes.extend_from_slice(bytemuck::cast_slice(triangle));
    }
    bytes
}

fn obj(order: &[usize], meta: &Meta, body: &BodyView<'_>) -> Vec<u8> {
    let (points, triangles) = indexed(order, body);
    let mut text = format!("# {}: metres, x forward, y left, z up\n", one_line(&meta.name));
    for [x, y, z] in &points {
        // The shortest decimals that give the same f32 back. Writing to a string cannot fail.
        let _written = writeln!(text, "v {x} {y} {z}");
    }
    let mut part = None;
    for (at, triangle) in order.iter().zip(&triangles) {
        let own = body.part_of[*at];
        if part != Some(own) {
            part = Some(own);
            let name = meta.parts.get(usize::from(own)).map_or("", String::as_str);
            let _written = writeln!(text, "g {}", one_line(name));
        }
        let [a, b, c] = triangle.map(|index| index + 1);
        let _written = writeln!(text, "f {a} {b} {c}");
    }
    text.into_bytes()
}

/// A name without line breaks.
fn one_line(name: &str) -> String {
    let plain: String = name.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    // A backslash at the end would join the next line.
    plain.trim_end_matches(['\\', ' ']).to_owned()
}

#[cfg(test)]
mod tests;
