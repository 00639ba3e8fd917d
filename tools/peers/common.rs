//! What both drivers for parry3d share: meshes, poses and the clock.

use anyhow::{Context as _, Result, bail};
use geometry::{Corners, RelativePose};
use parry3d::math::{Mat3, Pose as Pose32, Rotation, Vector};
use std::path::Path;
use std::time::Instant;

/// The triangles of a binary STL.
pub(crate) fn read_stl(path: &Path) -> Result<Vec<Corners>> {
    /// Header: an ignored text, and the number of triangles.
    const HEADER: usize = 80 + 4;
    /// An ignored normal, three corners, two spare bytes.
    const RECORD: usize = 50;
    let bytes = std::fs::read(path).with_context(|| path.display().to_string())?;
    let records = bytes.get(HEADER..).unwrap_or_default().chunks_exact(RECORD);
    let float = |bytes: &[u8], at: usize| {
        f32::from_le_bytes(std::array::from_fn(|byte| bytes[12 + 4 * at + byte]))
    };
    let corners =
        |record: &[u8]| std::array::from_fn(|k| std::array::from_fn(|c| float(record, 3 * k + c)));
    Ok(records.map(corners).collect())
}

/// A pose in f32.
pub(crate) fn pose32(pose: &RelativePose) -> Result<Pose32> {
    let column = |j: usize| Vector::from_array(pose.rotation.map(|row| row[j] as f32));
    let rotation = Rotation::from_mat3(&Mat3::from_cols(column(0), column(1), column(2)));
    let translation = Vector::from_array(pose.translation.map(|t| t as f32));
    if !translation.is_finite() {
        bail!("the pose is not finite");
    }
    Ok(Pose32::from_parts(translation, rotation))
}

#[expect(clippy::disallowed_methods, reason = "a measuring aid: nothing is decided by it")]
pub(crate) fn now() -> Instant {
    Instant::now()
}

pub(crate) fn ms_since(start: Instant) -> f64 {
    start.elapsed().as_secs_f64() * 1e3
}
