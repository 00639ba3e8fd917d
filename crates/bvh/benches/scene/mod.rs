//! The scenes used by all measurements: two bodies in source order and their poses.
//!
//! Benchmarks, instruction counts and the comparison with other libraries (`cargo x compare`) use
//! the same scenes by the same names. All are generated, with the same bits on every machine.
//!
//! - `cars-N-deep`, `-scratch`, `-miss`: a sedan and an SUV of N triangles each; head-on
//!   and deep, side by side and touching, and just not.
//! - `comb`: two stacks of sheets that cross each other: very many hits.
//! - `bodies-identical`: one sedan twice in the same place: triangles that coincide, share corners,
//!   share edges.
//! - `faces-touching`, `faces-rounded`: two boxes that touch in a plane, all coplanar; and the same
//!   under a pose whose rounding makes them only nearly so.

use body::Shape;
use core::array::from_fn;
use geometry::{Corners, Pose};
use shapes::generate;

/// Two bodies and their poses in the world.
pub(crate) struct Scene {
    /// The body in whose frame they meet.
    pub(crate) a: Vec<Corners>,
    /// The other body.
    pub(crate) b: Vec<Corners>,
    /// The pose of A.
    pub(crate) pose_a: Pose,
    /// The pose of B.
    pub(crate) pose_b: Pose,
}

/// All names, the cheapest of a family first.
pub(crate) const NAMES: &[&str] = &[
    "cars-10k-scratch",
    "cars-10k-deep",
    "cars-100k-miss",
    "cars-100k-scratch",
    "cars-100k-deep",
    "cars-1m-scratch",
    "cars-1m-deep",
    "comb",
    "bodies-identical",
    "faces-touching",
    "faces-rounded",
];

/// The pose of the SUV in the sedan's frame: yaw, pitch, roll (degrees), position (m).
pub(crate) type Stand = (f64, f64, f64, [f64; 3]);

/// Head-on, turned by 26 degrees with a small lateral offset: one corner about a metre deep.
pub(crate) const DEEP: Stand = (154.0, 1.7, -2.3, [3.9, 0.5, 0.05]);
/// Side by side, nose outwards: a few millimetres.
pub(crate) const SCRATCH: Stand = (7.0, 0.9, 1.1, [0.8, 2.14, 0.03]);
/// Side by side with a gap of a few millimetres: boxes overlap, triangles do not.
const MISS: Stand = (7.0, 0.9, 1.1, [0.8, 2.15, 0.03]);

impl Scene {
    /// The scene of this name.
    ///
    /// # Panics
    ///
    /// The name is not in [`NAMES`].
    pub(crate) fn named(name: &str) -> Self {
        match name {
            "cars-10k-scratch" => Self::of_cars(10_000, SCRATCH),
            "cars-10k-deep" => Self::of_cars(10_000, DEEP),
            "cars-100k-miss" => Self::of_cars(100_000, MISS),
            "cars-100k-scratch" => Self::of_cars(100_000, SCRATCH),
            "cars-100k-deep" => Self::of_cars(100_000, DEEP),
            "cars-1m-scratch" => Self::of_cars(1_000_000, SCRATCH),
            "cars-1m-deep" => Self::of_cars(1_000_000, DEEP),
            "comb" => {
                let (sheets, stand) = (sheets(), turned(92.0, 0.3, 0.4, [1.0, 0.0, 0.04]));
                Self::posed(sheets.clone(), sheets, anyhow(), &stand)
            }
            "bodies-identical" => {
                let sedan = body(Shape::Sedan, 10_000);
                Self::posed(sedan.clone(), sedan, QUARTER_TURN, &Pose::IDENTITY)
            }
            "faces-touching" => Self::posed(cube(), cube(), QUARTER_TURN, &ASIDE),
            "faces-rounded" => Self::posed(cube(), cube(), anyhow(), &ASIDE),
            _ => panic!("no scene is called {name}: there are {}", NAMES.join(", ")),
        }
    }

    fn of_cars(triangles: u32, (yaw, pitch, roll, at): Stand) -> Self {
        let (sedan, suv) = (body(Shape::Sedan, triangles), body(Shape::Suv, triangles));
        Self::posed(sedan, suv, anyhow(), &turned(yaw, pitch, roll, at))
    }

    /// B at `stand` in A's frame, A at `pose_a` in the world.
    fn posed(a: Vec<Corners>, b: Vec<Corners>, pose_a: Pose, stand: &Pose) -> Self {
        let (r, s) = (&pose_a.rotation, &stand.rotation);
        let row = |i: usize, v: [f64; 3]| r[i][0] * v[0] + r[i][1] * v[1] + r[i][2] * v[2];
        let pose_b = Pose {
            rotation: from_fn(|i| from_fn(|j| row(i, [s[0][j], s[1][j], s[2][j]]))),
            translation: from_fn(|i| row(i, stand.translation) + pose_a.translation[i]),
        };
        Self { a, b, pose_a, pose_b }
    }
}

/// Turned by 90 degrees about z, exactly: poses relative to it are not rounded.
const QUARTER_TURN: Pose = Pose {
    rotation: [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]],
    translation: [12.5, -7.25, 0.25],
};

/// One metre along x, with a lateral offset of a fraction of an edge: the faces of two cubes touch.
const ASIDE: Pose = Pose { translation: [1.0, 0.03125, 0.0625], ..Pose::IDENTITY };

/// A generic pose: relative poses with it are rounded.
fn anyhow() -> Pose {
    turned(40.0, 3.0, -2.0, [12.5, -7.25, 0.3])
}

fn turned(yaw: f64, pitch: f64, roll: f64, at: [f64; 3]) -> Pose {
    Pose::from_degrees(yaw, pitch, roll, at)
}

fn body(shape: Shape, triangles: u32) -> Vec<Corners> {
    generate(shape, triangles, 0).expect("a count that can be generated").corners
}

/// Two hundred sheets across x, each 1 m long and 0.1 m high: 96,000 triangles.
fn sheets() -> Vec<Corners> {
    let mut triangles = Vec::new();
    for i in 0..200 {
        let x = (i as f32 + 0.5) / 200.0;
        grid([x, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 0.1], [60, 4], &mut triangles);
    }
    triangles
}

/// A cube of 1 m, its faces cut into 24 × 24 squares: 6,912 triangles.
fn cube() -> Vec<Corners> {
    let mut triangles = Vec::new();
    for axis in 0..3 {
        let along = |axis: usize| from_fn(|i| if i == axis % 3 { 1.0 } else { 0.0 });
        for from in [[0.0; 3], along(axis)] {
            grid(from, along(axis + 1), along(axis + 2), [24, 24], &mut triangles);
        }
    }
    triangles
}

/// The parallelogram of `u` and `v` at `from`, cut into cells of two triangles.
fn grid(from: [f32; 3], u: [f32; 3], v: [f32; 3], cells: [u32; 2], out: &mut Vec<Corners>) {
    let point = |i: u32, j: u32| {
        let (s, t) = (i as f32 / cells[0] as f32, j as f32 / cells[1] as f32);
        from_fn(|k| from[k] + s * u[k] + t * v[k])
    };
    for i in 0..cells[0] {
        for j in 0..cells[1] {
            let [a, b, c, d] =
                [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)].map(|(i, j)| point(i, j));
            out.extend([[a, b, c], [a, c, d]]);
        }
    }
}
