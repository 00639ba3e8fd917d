//! Stretches a body to a given size, with its middle on the origin and its lowest point on the
//! ground.
//!
//! Often only the length and width of a road user are known. A body of its kind is stretched to
//! them; its height is kept unless it is given. The caller recomputes everything that depends on
//! the size (mass, gyration, zones).

use crate::{BodyView, Mesh, Meta, is_degenerate};

/// The target size of stretching (m).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fit {
    /// The longer horizontal side; the other in proportion, the height kept.
    Longest(f64),
    /// Length and width; the height kept.
    Plan([f64; 2]),
    /// Length, width and height.
    Whole([f64; 3]),
}

/// Returns the mesh from which a body was made, in source order.
#[must_use]
pub fn mesh_of(meta: &Meta, view: &BodyView<'_>) -> Mesh {
    let mut order: Vec<usize> = (0..view.corners.len()).collect();
    order.sort_by_key(|at| view.source_ids[*at]);
    Mesh {
        corners: order.iter().map(|at| view.corners[*at]).collect(),
        source_ids: order.iter().map(|at| view.source_ids[*at]).collect(),
        part_of: order.iter().map(|at| view.part_of[*at]).collect(),
        parts: meta.parts.clone(),
        dropped: view.dropped.iter().map(|&[dropped, kept]| (dropped, kept)).collect(),
        degenerate: meta.degenerate,
    }
}

impl Fit {
    /// The factors for a box (m), per axis. A box without extent along an axis keeps it.
    fn factors(self, size: [f64; 3]) -> [f64; 3] {
        let factor = |wanted: f64, is: f64| if is > 0.0 { wanted / is } else { 1.0 };
        match self {
            Self::Longest(longest) => {
                let both = factor(longest, size[0].max(size[1]));
                [both, both, 1.0]
            }
            Self::Plan([length, width]) => [factor(length, size[0]), factor(width, size[1]), 1.0],
            Self::Whole(wanted) => [0, 1, 2].map(|axis| factor(wanted[axis], size[axis])),
        }
    }
}

/// Stretches a mesh; f64 products of the stored f32, rounded once, so the same bits everywhere.
#[must_use]
pub fn fitted(mut mesh: Mesh, fit: Fit) -> Mesh {
    let bounds = mesh.bounds();
    let [low, high] = [bounds.min, bounds.max].map(|end| end.map(f64::from));
    let size = [0, 1, 2].map(|axis| high[axis] - low[axis]);
    let origin = [0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1]), low[2]];
    let factors = fit.factors(size);
    for corner in mesh.corners.iter_mut().flatten() {
        *corner = [0, 1, 2]
            .map(|axis| ((f64::from(corner[axis]) - origin[axis]) * factors[axis]) as f32 + 0.0);
    }
    mesh.degenerate = mesh.corners.iter().filter(|corners| is_degenerate(corners)).count() as u32;
    mesh
}
