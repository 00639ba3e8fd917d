//! A driver for parry3d's `cast_shapes` of two meshes, in the manner of `sweeps.hpp`.
//!
//! Everything is f32: B starts where its motion does, and the time of impact is metres of travel.

mod common;

use anyhow::{Context as _, Result, bail};
use common::{ms_since, now, pose32, read_stl};
use geometry::{Corners, DVec3, RelativePose};
use parry3d::math::{Pose as Pose32, Vector};
use parry3d::query::{ShapeCastOptions, cast_shapes};
use parry3d::shape::TriMesh;
use std::array::from_fn;
use std::path::Path;

/// How often a query is timed at most; the median counts.
const RUNS: usize = 5;
/// No further run once this long was spent (ms).
const ENOUGH_MS: f64 = 300.0;

struct Motion {
    name: String,
    pose: RelativePose,
    direction: DVec3,
    travels_m: [f64; 2],
}

fn main() -> Result<()> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let (folder, limit_ms) = match words.as_slice() {
        [folder] => (Path::new(folder), f64::INFINITY),
        [folder, _, seconds] => (Path::new(folder), 1e3 * seconds.parse::<f64>()?),
        _ => bail!("expected CASE [--seconds S]"),
    };
    let [a, b] = [mesh(&folder.join("a.stl"))?, mesh(&folder.join("b.stl"))?];
    let mut spent_ms = 0.0;
    for motion in read_motions(&folder.join("sweeps.txt"))? {
        if spent_ms < limit_ms {
            spent_ms += cast(&a, &b, &motion)?;
        }
    }
    Ok(())
}

/// Casts B, prints the line, and returns the time of all runs (ms).
fn cast(a: &TriMesh, b: &TriMesh, motion: &Motion) -> Result<f64> {
    let [from_m, to_m] = motion.travels_m;
    let start = pose32(&motion.pose.moved(motion.direction * from_m))?;
    let velocity = Vector::from_array(motion.direction.to_array().map(|x| x as f32));
    let options = ShapeCastOptions::with_max_time_of_impact((to_m - from_m) as f32);
    let mut times = Vec::new();
    let mut hit = None;
    while times.len() < RUNS && times.iter().sum::<f64>() < ENOUGH_MS {
        let begun = now();
        hit = cast_shapes(&Pose32::IDENTITY, Vector::ZERO, a, &start, velocity, b, options)?;
        times.push(ms_since(begun));
    }
    let spent_ms = times.iter().sum();
    times.sort_by(f64::total_cmp);
    let line = serde_json::json!({
        "peer": "parry", "name": motion.name, "query_ms": times[times.len() / 2],
        "first_contact_m": hit.map(|hit| from_m + f64::from(hit.time_of_impact)),
    });
    #[expect(clippy::print_stdout, reason = "this line is what the driver is for")]
    {
        println!("{line}");
    }
    Ok(spent_ms)
}

fn mesh(path: &Path) -> Result<TriMesh> {
    let triangles: Vec<Corners> = read_stl(path)?;
    // Equal corners are stored once.
    let mut corners: Vec<[u32; 3]> =
        triangles.as_flattened().iter().map(|corner| corner.map(|x| (x + 0.0).to_bits())).collect();
    corners.sort_unstable();
    corners.dedup();
    let number_of = |corner: [f32; 3]| {
        let bits = corner.map(|x| (x + 0.0).to_bits());
        corners.binary_search(&bits).map(|at| at as u32).unwrap_or_default()
    };
    let indices = triangles.iter().map(|corners| corners.map(number_of)).collect();
    let points = corners.iter().map(|bits| Vector::from_array(bits.map(f32::from_bits))).collect();
    TriMesh::new(points, indices).with_context(|| path.display().to_string())
}

fn read_motions(path: &Path) -> Result<Vec<Motion>> {
    let text = std::fs::read_to_string(path).with_context(|| path.display().to_string())?;
    let motion = |line: &str| {
        let (name, numbers) = line.split_once(' ').context("a line without numbers")?;
        let numbers: Vec<f64> =
            numbers.split_whitespace().map(str::parse).collect::<Result<_, _>>()?;
        let n: [f64; 17] = numbers.try_into().ok().context("not 17 numbers")?;
        let rotation = from_fn(|i| from_fn(|j| n[3 * i + j]));
        let pose = RelativePose { rotation, translation: [n[9], n[10], n[11]] };
        let direction = DVec3::new(n[12], n[13], n[14]);
        Ok(Motion { name: name.to_owned(), pose, direction, travels_m: [n[15], n[16]] })
    };
    text.lines().map(motion).collect()
}
