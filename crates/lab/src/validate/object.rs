//! The bodies of crash tests: a generated car of the size of the tested one, and what it hits.

use body::fit::{Fit, fitted};
use body::{BodyKind, Mesh, Shape, defaults};
use core::f64::consts::TAU;
use geometry::Corners;
use trolley::Failure;
use trolley::bodies::with_tree;
use trolley::model::BuildOptions;

/// Triangles of a car: enough for its outline, few enough for hundreds of scenes.
const TRIANGLES: u32 = 6000;

/// Steps of a quarter of a turn at a rounded edge.
const STEPS: usize = 8;

/// What is hit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Object {
    /// A flat face whose edges have a radius (m).
    Wall {
        /// Radius (m).
        edge_m: f64,
    },
    /// A pole of a diameter (m).
    Pole {
        /// Diameter (m).
        diameter_m: f64,
    },
    /// A long barrier.
    Barrier,
}

/// Width of a wall and thickness of a wall or barrier (m), length of a barrier (m).
pub(super) const WALL_M: [f64; 2] = [2.0, 1.0];
/// Length of a barrier (m).
pub(super) const BARRIER_M: f64 = 40.0;

impl Object {
    /// What the words of a test say: "50.8 cm pole", "Flat steel wall 5 cm rad", "Flat 150 barrier"
    /// (its edge in mm).
    pub(super) fn of_words(words: &str) -> Option<Self> {
        let lower = words.to_lowercase();
        let mut numbers = lower.split_whitespace().filter_map(|word| word.parse::<f64>().ok());
        let number = numbers.next();
        if lower.contains("pole") {
            return Some(Self::Pole { diameter_m: number? / 100.0 });
        }
        let is_flat = ["wall", "barrier", "face"].iter().any(|word| lower.contains(word));
        is_flat.then(|| {
            let edge_m = match number {
                Some(mm) if lower.contains("barrier") => mm / 1000.0,
                Some(cm) => cm / 100.0,
                // As the others of these tests.
                None => 0.15,
            };
            Self::Wall { edge_m: edge_m.clamp(0.005, 0.29) }
        })
    }

    /// Half of its width across the way of the car (m).
    pub(super) fn half_width_m(self) -> f64 {
        match self {
            Self::Wall { .. } => 0.5 * WALL_M[0],
            Self::Pole { diameter_m } => 0.5 * diameter_m,
            Self::Barrier => 0.5 * BARRIER_M,
        }
    }

    /// Half of its depth along the way of the car (m).
    pub(super) fn half_depth_m(self) -> f64 {
        match self {
            Self::Wall { .. } | Self::Barrier => 0.5 * WALL_M[1],
            Self::Pole { diameter_m } => 0.5 * diameter_m,
        }
    }

    pub(super) fn shape(self) -> Shape {
        match self {
            Self::Wall { .. } | Self::Barrier => Shape::Wall,
            Self::Pole { .. } => Shape::Pole,
        }
    }

    /// Its body: upright, with its width along y, or a barrier along x.
    pub(super) fn body(self) -> Result<body::Body, Failure> {
        let outline = match self {
            Self::Pole { diameter_m } => round(0.5 * diameter_m),
            Self::Wall { edge_m } => rounded(WALL_M[1], WALL_M[0], edge_m),
            Self::Barrier => rounded(BARRIER_M, WALL_M[1], 0.02),
        };
        made(prism(&outline, 1.6), self.shape().kind(), "object")
    }
}

fn round(radius: f64) -> Vec<[f64; 2]> {
    let point = |k: usize| {
        let angle = TAU * k as f64 / (8 * STEPS) as f64;
        [radius * angle.cos(), radius * angle.sin()]
    };
    (0..8 * STEPS).map(point).collect()
}

/// A rectangle along x and y with rounded corners.
fn rounded(length: f64, width: f64, radius: f64) -> Vec<[f64; 2]> {
    let corner = |quarter: usize, k: usize| {
        let angle = TAU * (quarter as f64 + k as f64 / STEPS as f64) / 4.0;
        let (x, y) = match quarter {
            0 => (1.0, 1.0),
            1 => (-1.0, 1.0),
            2 => (-1.0, -1.0),
            _ => (1.0, -1.0),
        };
        [
            x * (0.5 * length - radius) + radius * angle.cos(),
            y * (0.5 * width - radius) + radius * angle.sin(),
        ]
    };
    (0..4).flat_map(|quarter| (0..=STEPS).map(move |k| corner(quarter, k))).collect()
}

/// An upright prism from the ground to a height.
fn prism(outline: &[[f64; 2]], height: f64) -> Vec<Corners> {
    let corner_at = |[x, y]: [f64; 2], z: f64| [x as f32, y as f32, z as f32];
    let count = outline.len();
    let mut corners = Vec::new();
    for (k, p) in outline.iter().enumerate() {
        let q = outline[(k + 1) % count];
        corners.push([corner_at(*p, 0.0), corner_at(q, 0.0), corner_at(q, height)]);
        corners.push([corner_at(*p, 0.0), corner_at(q, height), corner_at(*p, height)]);
        if (1..count - 1).contains(&k) {
            corners.push([
                corner_at(outline[0], height),
                corner_at(*p, height),
                corner_at(q, height),
            ]);
            corners.push([corner_at(outline[0], 0.0), corner_at(q, 0.0), corner_at(*p, 0.0)]);
        }
    }
    corners
}

fn made(corners: Vec<Corners>, kind: BodyKind, name: &str) -> Result<body::Body, Failure> {
    let count = corners.len();
    let mesh = Mesh {
        corners,
        source_ids: (0..count as u32).collect(),
        part_of: vec![0; count],
        parts: vec![name.to_owned()],
        dropped: Vec::new(),
        degenerate: 0,
    };
    let origin = defaults::Origin { name, kind, origin: "a crash test", hash: "" };
    let meta = defaults::assemble(origin, &mesh);
    with_tree(mesh, meta, &BuildOptions::default(), &|_| {})
}

/// A generated car whose length and width without mirrors are these (m).
pub(super) fn car(shape: Shape, size_m: [f64; 2]) -> Result<body::Body, Failure> {
    let mesh = shapes(shape)?;
    let [length, width, _] = mesh.size_m();
    let bare = body::Outlines::of(&mesh, shape.kind()).size_m().unwrap_or([length, width]);
    let whole = [length * size_m[0] / bare[0], width * size_m[1] / bare[1]];
    let mesh = fitted(mesh, Fit::Plan(whole));
    let origin =
        defaults::Origin { name: "car", kind: shape.kind(), origin: "a crash test", hash: "" };
    let meta = defaults::assemble(origin, &mesh);
    with_tree(mesh, meta, &BuildOptions::default(), &|_| {})
}

/// The triangles of a generated shape.
fn shapes(shape: Shape) -> Result<Mesh, Failure> {
    let made = trolley::bodies::generate(shape, TRIANGLES, 0, &BuildOptions::default(), &|_| {})?;
    Ok(body::fit::mesh_of(&made.meta, &made.view()))
}
