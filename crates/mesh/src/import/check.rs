//! Steps for every imported mesh after its reader: selection, duplicates, area, size.

use super::collect::Part;
use super::{LengthUnit, MeshDefect};
use body::{BodyKind, Mesh};
use geometry::Corners;

/// Keeps the triangles of the parts with one of the names; all if no name is given.
pub(super) fn select(mesh: &mut Mesh, parts: &[Part], only: &[String]) -> Result<(), MeshDefect> {
    if only.is_empty() {
        return Ok(());
    }
    for name in only {
        if !parts.iter().any(|part| part.is_named(name)) {
            return Err(MeshDefect::NoSuchPart {
                asked: format!("\"{name}\""),
                names: names(parts),
            });
        }
    }
    let keep: Vec<bool> =
        parts.iter().map(|part| only.iter().any(|name| part.is_named(name))).collect();
    retain(mesh, |at, mesh| keep[usize::from(mesh.part_of[at])]);
    Ok(())
}

/// Names of parts for a message: each once, at most thirty.
fn names(parts: &[Part]) -> String {
    let mut names: Vec<&str> = parts
        .iter()
        .flat_map(|part| {
            [part.name.as_str()].into_iter().chain(part.aliases.iter().map(String::as_str))
        })
        .collect();
    names.sort_unstable();
    names.dedup();
    let more = names.len().saturating_sub(30);
    let mut text: Vec<String> = names.iter().take(30).map(|name| format!("\"{name}\"")).collect();
    if more > 0 {
        text.push(format!("and {more} more"));
    }
    text.join(", ")
}

fn retain(mesh: &mut Mesh, keep: impl Fn(usize, &Mesh) -> bool) {
    let kept: Vec<usize> = (0..mesh.corners.len()).filter(|at| keep(*at, mesh)).collect();
    mesh.corners = kept.iter().map(|at| mesh.corners[*at]).collect();
    mesh.source_ids = kept.iter().map(|at| mesh.source_ids[*at]).collect();
    mesh.part_of = kept.iter().map(|at| mesh.part_of[*at]).collect();
}

/// Removes part names without triangles, so that `parts` lists what the body consists of.
pub(super) fn compact_parts(mesh: &mut Mesh) {
    let mut used = vec![false; mesh.parts.len()];
    for part in &mesh.part_of {
        used[usize::from(*part)] = true;
    }
    let mut renumbered = vec![0_u16; mesh.parts.len()];
    let mut next = 0;
    for (new, used) in renumbered.iter_mut().zip(&used) {
        *new = next;
        next += u16::from(*used && next < u16::MAX);
    }
    for part in &mut mesh.part_of {
        *part = renumbered[usize::from(*part)];
    }
    let mut used = used.into_iter();
    mesh.parts.retain(|_| used.next().unwrap_or(false));
}

/// Drops triangles that have the same three positions as an earlier one, in any order, and records
/// them: a contact must not count twice. −0 and +0 are one position.
pub(super) fn drop_duplicates(mesh: &mut Mesh) {
    let mut order: Vec<u32> = (0..mesh.corners.len() as u32).collect();
    let keys: Vec<[[u32; 3]; 3]> = mesh.corners.iter().map(key).collect();
    // Equal keys are adjacent, the earliest first.
    order.sort_unstable_by_key(|at| (keys[*at as usize], *at));
    let mut duplicate = vec![false; mesh.corners.len()];
    let mut dropped = Vec::new();
    for group in order.chunk_by(|a, b| keys[*a as usize] == keys[*b as usize]) {
        let kept = mesh.source_ids[group[0] as usize];
        for at in &group[1..] {
            duplicate[*at as usize] = true;
            dropped.push((mesh.source_ids[*at as usize], kept));
        }
    }
    dropped.sort_unstable();
    mesh.dropped = dropped;
    retain(mesh, |at, _| !duplicate[at]);
}

fn key(corners: &Corners) -> [[u32; 3]; 3] {
    // Adding +0 turns −0 into +0 and leaves everything else unchanged.
    let mut key = corners.map(|corner| corner.map(|x| (x + 0.0).to_bits()));
    key.sort_unstable();
    key
}

/// The least and greatest plausible value of the greatest extent, and the usual range, in metres.
/// The outer limits are wide, so that they catch only wrong units.
fn limits(kind: Option<BodyKind>) -> ([f64; 2], [f64; 2]) {
    match kind {
        None => ([0.05, 500.0], [0.5, 20.0]),
        Some(BodyKind::Sedan | BodyKind::Suv) => ([1.0, 30.0], [2.5, 6.5]),
        Some(BodyKind::Truck | BodyKind::Bus) => ([2.0, 40.0], [4.0, 20.0]),
        Some(BodyKind::Motorcycle) => ([0.8, 8.0], [1.4, 3.0]),
        Some(BodyKind::Cyclist) => ([0.8, 8.0], [1.2, 2.5]),
        Some(BodyKind::Pedestrian) => ([0.3, 2.6], [0.7, 2.2]),
        Some(BodyKind::Wall) => ([0.1, 500.0], [1.0, 50.0]),
        Some(BodyKind::Pole) => ([0.2, 100.0], [1.0, 20.0]),
        Some(BodyKind::Building) => ([0.5, 1000.0], [3.0, 100.0]),
    }
}

/// Rejects a body whose size is implausible for its kind.
pub(super) fn check_size(
    size: [f64; 3],
    kind: Option<BodyKind>,
    unit: LengthUnit,
) -> Result<(), MeshDefect> {
    let greatest = size.into_iter().fold(0.0, f64::max);
    let ([least, most], usual) = limits(kind);
    if (least..=most).contains(&greatest) {
        return Ok(());
    }
    let in_unit = |metres: f64| greatest / unit.metres() * metres;
    let likely = LengthUnit::NAMED.iter().find(|(_, metres)| {
        *metres != unit.metres() && (usual[0]..=usual[1]).contains(&in_unit(*metres))
    });
    Err(MeshDefect::Size {
        size: describe(size),
        kind: kind.map_or("road user or object", BodyKind::name).to_owned(),
        least,
        greatest: most,
        unit: likely.map(|(name, _)| *name),
    })
}

/// A size in words: "4.62 × 2.01 × 1.39 m".
pub(super) fn describe(size: [f64; 3]) -> String {
    let digits = if size.iter().any(|x| *x >= 0.1) { 2 } else { 6 };
    let [x, y, z] = size;
    format!("{x:.digits$} × {y:.digits$} × {z:.digits$} m")
}

#[cfg(test)]
mod tests;
