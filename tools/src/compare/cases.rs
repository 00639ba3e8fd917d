//! Cases: two mesh files and two poses in a folder, as every driver reads them.
//!
//! `a.stl` and `b.stl` are binary STL; `pose.txt` has the world poses of A and then B, each 3 lines
//! of 4 numbers (R | t), row-major. Cases are made from the scenes of our benchmarks.

mod encounter;
mod scene;

use anyhow::{Context as _, Result, bail};
use check::built;
pub(crate) use encounter::FAMILIES;
use encounter::{Encounter, Family};
use geometry::{Corners, Pose};
use scene::Scene;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

/// Header of a binary STL: an ignored text, and the number of triangles.
const HEADER: usize = 80;

/// A folder with two bodies and their poses.
#[derive(Clone, Debug)]
pub(crate) struct Case {
    /// What it is called: its folder's name.
    pub(crate) name: String,
    /// Where it lies.
    pub(crate) folder: PathBuf,
    /// Triangles of A and B together.
    pub(crate) triangles: u64,
}

/// Makes the scenes of the benchmarks into cases below `folder`, afresh each time.
pub(crate) fn made(folder: &Path, wanted: &dyn Fn(&str) -> bool) -> Result<Vec<Case>> {
    let names = scene::NAMES.iter().filter(|name| wanted(name));
    names.map(|name| make(folder.join(name), &Scene::named(name))).collect()
}

fn make(folder: PathBuf, scene: &Scene) -> Result<Case> {
    fs::create_dir_all(&folder).with_context(|| folder.display().to_string())?;
    let write = |name: &str, bytes: &[u8]| {
        let path = folder.join(name);
        fs::write(&path, bytes).with_context(|| path.display().to_string())
    };
    write("a.stl", &stl(&scene.a))?;
    write("b.stl", &stl(&scene.b))?;
    write("pose.txt", poses(&[scene.pose_a, scene.pose_b]).as_bytes())?;
    Case::at(folder)
}

/// Writes a family of encounters below `folder`: both bodies, and sweeps.txt. Returns its folder,
/// and the names of those that are wanted, and written; `None` if there are none.
pub(crate) fn swept(
    folder: &Path,
    family: &str,
    wanted: &dyn Fn(&str) -> bool,
) -> Result<Option<(PathBuf, Vec<String>)>> {
    let folder = folder.join(family);
    let Family { a, b, mut encounters } = Family::named(family);
    encounters.retain(|of| wanted(&of.name));
    if encounters.is_empty() {
        return Ok(None);
    }
    built::write(&folder.join("sweeps.txt"), &sweeps(&encounters))?;
    for (name, corners) in [("a.stl", &a), ("b.stl", &b)] {
        let path = folder.join(name);
        fs::write(&path, stl(corners)).with_context(|| path.display().to_string())?;
    }
    Ok(Some((folder, encounters.into_iter().map(|of| of.name).collect())))
}

/// A line per motion, as `tools/peers/sweeps.hpp` explains it.
fn sweeps(encounters: &[Encounter]) -> String {
    let mut text = String::new();
    for Encounter { name, pose, direction, travels_m } in encounters {
        let numbers = pose.rotation.as_flattened().iter().chain(&pose.translation);
        let (direction, travels) = (direction.to_array(), travels_m);
        text.push_str(name);
        for number in numbers.chain(&direction).chain(travels) {
            _ = write!(text, " {number}");
        }
        text.push('\n');
    }
    text
}

/// All cases below `folder`, in order of their triangles.
pub(crate) fn given(folder: &Path, wanted: &dyn Fn(&str) -> bool) -> Result<Vec<Case>> {
    let mut cases = Vec::new();
    for entry in fs::read_dir(folder).with_context(|| folder.display().to_string())? {
        let path = entry?.path();
        if path.join("pose.txt").is_file() {
            cases.push(Case::at(fs::canonicalize(path)?)?);
        }
    }
    if cases.is_empty() {
        bail!("{}: no folder in it has a pose.txt", folder.display());
    }
    cases.retain(|case| wanted(&case.name));
    cases.sort_by(|x, y| (x.triangles, &x.name).cmp(&(y.triangles, &y.name)));
    Ok(cases)
}

impl Case {
    fn at(folder: PathBuf) -> Result<Self> {
        let name = folder.file_name().context("a case without a name")?.to_string_lossy().into();
        let triangles = count(&folder.join("a.stl"))? + count(&folder.join("b.stl"))?;
        Ok(Self { name, folder, triangles })
    }

    /// One of its files.
    pub(crate) fn file(&self, name: &str) -> PathBuf {
        self.folder.join(name)
    }
}

/// How many triangles a binary STL says it has.
fn count(stl: &Path) -> Result<u64> {
    use std::io::Read as _;
    let read = || {
        let mut header = [0; HEADER + 4];
        fs::File::open(stl)?.read_exact(&mut header)?;
        Ok(u32::from_le_bytes(std::array::from_fn(|i| header[HEADER + i])))
    };
    let count: std::io::Result<u32> = read();
    Ok(count.with_context(|| stl.display().to_string())?.into())
}

/// Binary STL; normals are 0, so readers compute them if needed.
pub(super) fn stl(triangles: &[Corners]) -> Vec<u8> {
    let mut bytes = vec![0; HEADER];
    bytes.extend((triangles.len() as u32).to_le_bytes());
    for corners in triangles {
        bytes.extend([0; 12]);
        bytes.extend(corners.iter().flatten().flat_map(|x| x.to_le_bytes()));
        bytes.extend([0; 2]);
    }
    bytes
}

/// As many digits as bring back the same numbers.
pub(super) fn poses(poses: &[Pose]) -> String {
    let mut text = String::new();
    for pose in poses {
        for (row, t) in pose.rotation.iter().zip(pose.translation) {
            let [x, y, z] = row;
            _ = writeln!(text, "{x} {y} {z} {t}");
        }
    }
    text
}
