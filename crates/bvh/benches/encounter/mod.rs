//! Encounters: bodies that move along straight lines until they touch, or pass each other.
//!
//! Benchmarks, instruction counts and `cargo x compare --first-contact` use the same ones by the
//! same names. All are in A's frame, and generated; sines of the platform make some of their
//! numbers, so last bits may differ between machines.
//!
//! - `deep`, `scratch`: the cars of the scenes of these names. B comes from eight sides, all round,
//!   and goes 2 m beyond where it stands in the scene.
//! - `pass`: B passes A with a gap of 10 cm, 1 cm and 1 mm between all that lies beside the line of
//!   motion. It stands as an oncoming car or turned by 26 degrees from that, and moves parallel to
//!   A or over 3 degrees.
//! - `slanted`: the same passes of an oncoming car, but the bodies are turned by 33 degrees in A's
//!   frame, so that no box along its axes tells the flanks apart.
//! - `tori`: two rings, linked or not, from eight sides.

use super::scene::{self, Scene, Stand};
use core::f64::consts::TAU;
use geometry::{Corners, DVec3, Pose, RelativePose};

/// The families of bodies, the cheapest first; each has encounters of its own.
pub(crate) const FAMILIES: &[&str] =
    &["cars-10k", "cars-100k", "cars-100k-slanted", "cars-1m", "tori-200k"];

/// Two bodies, and how they meet.
pub(crate) struct Family {
    /// The body in whose frame they meet.
    pub(crate) a: Vec<Corners>,
    /// The body that moves.
    pub(crate) b: Vec<Corners>,
    /// How.
    pub(crate) encounters: Vec<Encounter>,
}

/// One motion.
#[derive(Clone, Debug)]
pub(crate) struct Encounter {
    /// What it is called, among those of all families.
    pub(crate) name: String,
    /// The pose of B at travel 0.
    pub(crate) pose: RelativePose,
    /// Where B moves, of length 1.
    pub(crate) direction: DVec3,
    /// The travels that it covers (m).
    pub(crate) travels_m: [f64; 2],
}

impl Family {
    /// The family of this name.
    ///
    /// # Panics
    ///
    /// The name is not in [`FAMILIES`].
    pub(crate) fn named(name: &str) -> Self {
        if name == "tori-200k" {
            let torus = torus(500, 200);
            let pose = relative((17.0, 6.0, 93.0, [0.97, 0.06, 0.05]));
            let encounters = from_eight_sides(name, &pose, [-5.0, 1.0]);
            return Self { a: torus.clone(), b: torus, encounters };
        }
        if let Some(upright) = name.strip_suffix("-slanted") {
            let Scene { a, b, .. } = Scene::named(&format!("{upright}-deep"));
            let slant = relative((SLANT, 0.0, 0.0, [0.0; 3]));
            let turn = |corners: &Corners| {
                slant.triangle(corners).0.map(|corner| corner.to_array().map(|x| x as f32))
            };
            let a: Vec<Corners> = a.iter().map(turn).collect();
            let oncoming = relative((180.0 + SLANT, 0.0, 0.0, [0.0; 3]));
            let encounters = passes(name, [&a, &b], "oncoming", &oncoming, SLANT);
            return Self { a, b, encounters };
        }
        let Scene { a, b, .. } = Scene::named(&format!("{name}-deep"));
        let (deep, scratch) = (relative(scene::DEEP), relative(scene::SCRATCH));
        let reach_m = [-10.0, 2.0];
        let mut encounters = from_eight_sides(&format!("{name}-deep"), &deep, reach_m);
        encounters.extend(from_eight_sides(&format!("{name}-scratch"), &scratch, reach_m));
        let oncoming = relative((180.0, 0.0, 0.0, [0.0; 3]));
        encounters.extend(passes(name, [&a, &b], "oncoming", &oncoming, 0.0));
        encounters.extend(passes(name, [&a, &b], "turned", &deep, 0.0));
        Self { a, b, encounters }
    }
}

/// How far the bodies of slanted encounters are turned in A's frame (degrees).
const SLANT: f64 = 33.0;

/// B so in A's frame.
fn relative((yaw, pitch, roll, at): Stand) -> RelativePose {
    RelativePose::between(&Pose::IDENTITY, &Pose::from_degrees(yaw, pitch, roll, at))
}

/// Passes along A, which points so far to the left (degrees), and over 3 degrees.
fn passes(
    of: &str,
    bodies: [&[Corners]; 2],
    stand: &str,
    pose: &RelativePose,
    left: f64,
) -> Vec<Encounter> {
    let gaps = [("10cm", 0.1), ("1cm", 0.01), ("1mm", 0.001)];
    let ways = [("parallel", 0.0), ("3deg", 3.0)];
    let all = ways.iter().flat_map(|way| gaps.iter().map(move |gap| (way, gap)));
    all.map(|((way, degrees), (gap, gap_m))| {
        pass(format!("{of}-pass-{stand}-{way}-{gap}"), bodies, pose, left + degrees, *gap_m)
    })
    .collect()
}

fn from_eight_sides(of: &str, pose: &RelativePose, travels_m: [f64; 2]) -> Vec<Encounter> {
    let towards = |k: u32| {
        // Along no axis exactly, as real directions are.
        let angle = TAU * (f64::from(k) / 8.0) + 0.03;
        let (direction, pose) = (DVec3::new(angle.cos(), angle.sin(), 0.0), *pose);
        Encounter { name: format!("{of}-{:03}", 45 * k), pose, direction, travels_m }
    };
    (0..8).map(towards).collect()
}

/// B passes on A's left, against its sense of driving.
fn pass(
    name: String,
    [a, b]: [&[Corners]; 2],
    pose: &RelativePose,
    degrees: f64,
    gap_m: f64,
) -> Encounter {
    let angle = degrees.to_radians();
    let direction = DVec3::new(-angle.cos(), -angle.sin(), 0.0);
    let left = DVec3::new(-angle.sin(), angle.cos(), 0.0);
    let stored = |corner: &[f32; 3]| DVec3::from_array(corner.map(f64::from));
    let of_a = a.as_flattened().iter().map(|corner| left.dot(stored(corner)));
    let of_b = b.as_flattened().iter().map(|corner| left.dot(pose.point(*corner)));
    let beside = of_a.fold(f64::NEG_INFINITY, f64::max) - of_b.fold(f64::INFINITY, f64::min);
    // Level with A at travel 0.
    let ahead = direction.dot(DVec3::from_array(pose.translation));
    let pose = pose.moved(left * (beside + gap_m) - direction * ahead);
    Encounter { name, pose, direction, travels_m: [-8.0, 8.0] }
}

/// A torus of radii 1 m and 0.45 m with waves, cut into 2·u·v triangles.
fn torus(u: u32, v: u32) -> Vec<Corners> {
    let point = |i: u32, j: u32| {
        let (a, b) = (TAU * f64::from(i % u) / f64::from(u), TAU * f64::from(j % v) / f64::from(v));
        let radius = 0.45 * (1.0 + 0.003 * (31.0 * a).sin() * (17.0 * b).sin());
        let across = 1.0 + radius * b.cos();
        [across * a.cos(), across * a.sin(), radius * b.sin()].map(|x| x as f32)
    };
    let cell = |i: u32, j: u32| {
        let [p, q, r, s] =
            [[i, j], [i + 1, j], [i + 1, j + 1], [i, j + 1]].map(|[i, j]| point(i, j));
        [[p, q, r], [p, r, s]]
    };
    let cells = (0..u).flat_map(|i| (0..v).map(move |j| (i, j)));
    cells.flat_map(|(i, j)| cell(i, j)).collect()
}
