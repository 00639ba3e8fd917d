//! Bodies of the models folder, chosen by type and scaled to a stated length and width.
//!
//! A mesh is imported once, exported, scaled in plan (height by the mean of both factors), put with
//! its middle on the origin, and imported again: mass, centre and gyration follow from its size.

use crate::built;
use anyhow::{Context as _, Result};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A body that a scene asks for.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Wanted {
    /// Type in the recording, or "ego".
    pub(crate) kind: String,
    /// Length and width (m).
    pub(crate) size: [f64; 2],
}

/// A body that was made.
#[derive(Clone, Debug)]
pub(crate) struct Made {
    /// Its points in plan, a convex outline, counterclockwise (m).
    pub(crate) outline: Vec<[f64; 2]>,
}

/// All that were made so far.
#[derive(Debug)]
pub(crate) struct Bodies {
    program: PathBuf,
    models: PathBuf,
    folder: PathBuf,
    made: BTreeMap<String, Made>,
}

/// The mesh for a type: file, how to read it, and the kind of body.
fn mesh(kind: &str) -> (&'static str, &'static [&'static str], &'static str) {
    const Z_UP: &[&str] = &["--unit", "m", "--up", "+z", "--forward", "+x"];
    const Y_UP: &[&str] = &["--unit", "m", "--up", "+y", "--forward", "+x"];
    const TOY: &[&str] = &["--unit", "m", "--up", "+y", "--forward", "+z"];
    match kind {
        "parkedVehicle" => ("chrono_nissan_patrol_suv/suv_chassis.obj", Z_UP, "suv"),
        "motorcycle" => ("kenney_trucks/vehicle-motorcycle.glb", TOY, "motorcycle"),
        "pedestrian" => ("openmaterial_human/human_example.gltf", Y_UP, "pedestrian"),
        "unknown" => ("chrono_man10t_truck/MAN_10t_chassis.obj", Z_UP, "truck"),
        _ => ("chrono_sedan/sedan_chassis_vis.obj", Z_UP, "sedan"),
    }
}

impl Wanted {
    fn key(&self) -> String {
        let [length, width] = self.size.map(|x| (1000.0 * x).round());
        format!("{}-{length}x{width}", self.kind)
    }
}

impl Bodies {
    pub(crate) fn new(program: &Path, models: &Path, folder: &Path) -> Self {
        let (program, models, folder) = (program.into(), models.into(), folder.into());
        Self { program, models, folder, made: BTreeMap::new() }
    }

    /// The model file of a body, beside the scenario files.
    pub(crate) fn file(&self, wanted: &Wanted) -> String {
        format!("{}.trolley", wanted.key())
    }

    pub(crate) fn get(&self, wanted: &Wanted) -> Option<&Made> {
        self.made.get(&wanted.key())
    }

    /// Makes a body unless it is there.
    pub(crate) fn make(&mut self, wanted: &Wanted) -> Result<()> {
        let key = wanted.key();
        if self.made.contains_key(&key) {
            return Ok(());
        }
        let (mesh, how, kind) = mesh(&wanted.kind);
        let path = |end: &str| self.folder.join(format!("{key}{end}"));
        let (raw, plain, scaled) = (path(".raw.trolley"), path(".raw.obj"), path(".obj"));
        self.trolley(&["model", "import"], &self.models.join(mesh), how, kind, &raw)?;
        let mut export = Command::new(&self.program);
        export.args(["model", "export", "--quiet"]).arg(&raw).arg("-o").arg(&plain);
        built::output(&mut export)?;
        let text = std::fs::read_to_string(&plain)?;
        let (text, outline) = scale(&text, wanted.size)?;
        built::write(&scaled, &text)?;
        let axes = ["--unit", "m", "--up", "+z", "--forward", "+x"];
        self.trolley(&["model", "import"], &scaled, &axes, kind, &path(".trolley"))?;
        self.made.insert(key, Made { outline });
        Ok(())
    }

    fn trolley(
        &self,
        verb: &[&str],
        from: &Path,
        how: &[&str],
        kind: &str,
        to: &Path,
    ) -> Result<()> {
        let mut command = Command::new(&self.program);
        command.args(verb).arg("--quiet").arg(from).args(how).args(["--kind", kind]);
        built::output(command.arg("-o").arg(to)).map(drop)
    }
}

/// The mesh with its box stretched to a size, on the ground and around the origin; and its outline.
fn scale(text: &str, size: [f64; 2]) -> Result<(String, Vec<[f64; 2]>)> {
    let vertex = |line: &str| -> Option<[f64; 3]> {
        let mut numbers = line.strip_prefix("v ")?.split_whitespace().map(str::parse);
        Some([numbers.next()?.ok()?, numbers.next()?.ok()?, numbers.next()?.ok()?])
    };
    let points: Vec<[f64; 3]> = text.lines().filter_map(vertex).collect();
    let end = |axis: usize, pick: fn(f64, f64) -> f64| {
        points.iter().map(|p| p[axis]).reduce(pick).context("a mesh without a vertex")
    };
    let mut from = [0.0; 3];
    let mut factor = [1.0; 3];
    for axis in 0..2 {
        let (low, high) = (end(axis, f64::min)?, end(axis, f64::max)?);
        from[axis] = 0.5 * (low + high);
        factor[axis] = size[axis] / (high - low);
    }
    from[2] = end(2, f64::min)?;
    factor[2] = 0.5 * (factor[0] + factor[1]);
    let mut scaled = String::new();
    let mut plan = Vec::new();
    for line in text.lines() {
        let Some(p) = vertex(line) else {
            scaled.push_str(line);
            scaled.push('\n');
            continue;
        };
        let [x, y, z] = [0, 1, 2].map(|axis| (p[axis] - from[axis]) * factor[axis]);
        let _w = writeln!(scaled, "v {} {} {}", x as f32, y as f32, z as f32);
        plan.push([x, y]);
    }
    Ok((scaled, hull(plan)))
}

/// The convex hull of points, counterclockwise (Andrew's monotone chain, 1979).
pub(crate) fn hull(mut points: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    points.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    points.dedup();
    let turns_left = |a: [f64; 2], b: [f64; 2], c: [f64; 2]| {
        (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]) > 0.0
    };
    let half = |points: &mut dyn Iterator<Item = [f64; 2]>| {
        let mut chain: Vec<[f64; 2]> = Vec::new();
        for point in points {
            while chain.len() > 1
                && !turns_left(chain[chain.len() - 2], chain[chain.len() - 1], point)
            {
                chain.pop();
            }
            chain.push(point);
        }
        chain.pop();
        chain
    };
    let mut outline = half(&mut points.iter().copied());
    outline.extend(half(&mut points.iter().rev().copied()));
    outline
}

#[cfg(test)]
mod tests {
    //! Scaling and hulls on meshes of a few points.

    use super::*;

    #[test]
    fn a_scaled_mesh_has_the_stated_size_around_the_origin() {
        let text = "o part\nv 1 1 5\nv 3 1 5\nv 3 2 6\nv 1 2 5\nv 2 1.5 5\nf 1 2 3\n";
        let (scaled, outline) = scale(text, [4.0, 3.0]).expect("a mesh");
        assert!(scaled.starts_with("o part\nv -2 -1.5 0\n"), "{scaled}");
        assert!(scaled.contains("v 2 1.5 2.5\n") && scaled.ends_with("f 1 2 3\n"), "{scaled}");
        assert_eq!(outline, [[-2.0, -1.5], [2.0, -1.5], [2.0, 1.5], [-2.0, 1.5]]);
        assert!(scale("f 1 2 3\n", [1.0, 1.0]).is_err());
    }
}
