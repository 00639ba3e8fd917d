//! From a mesh to a body: the tree is built, and every array brought into leaf order.

use super::{BuildError, BuildOptions, Tree, build};
use model::{Body, BodyView, Mesh, Meta, Zones};

/// Builds the tree of a mesh and brings everything into leaf order.
///
/// `zones` has one entry per triangle in the order of the mesh. Of `meta`, the fields that follow
/// from mesh and tree are set: parts, degenerate, build, leaf size, depth.
///
/// # Errors
///
/// As [`build`], and [`BuildError::Lengths`] if an array of the mesh is too short or too long.
pub fn body(
    mesh: Mesh,
    meta: Meta,
    zones: Vec<Zones>,
    options: &BuildOptions,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<Body, BuildError> {
    let triangles = mesh.corners.len();
    let lengths = [
        ("source ids", mesh.source_ids.len()),
        ("part numbers", mesh.part_of.len()),
        ("zone sets", zones.len()),
    ];
    for (array, entries) in lengths {
        if entries != triangles {
            return Err(BuildError::Lengths { triangles, array, entries });
        }
    }
    let Tree { nodes, order, depth } = build(&mesh.corners, options, progress)?;
    Ok(Body {
        meta: Meta {
            parts: mesh.parts,
            degenerate: mesh.degenerate,
            build: options.build,
            leaf_size: options.leaf_size,
            depth,
            ..meta
        },
        nodes,
        corners: permuted(&mesh.corners, &order),
        source_ids: permuted(&mesh.source_ids, &order),
        part_of: permuted(&mesh.part_of, &order),
        zones: permuted(&zones, &order),
        dropped: mesh.dropped.iter().map(|&(dropped, kept)| [dropped, kept]).collect(),
    })
}

/// Builds another tree over a body that already has one.
///
/// The triangles are first brought back into source order, so the result is the one that [`body`]
/// would have given with these options, if the mesh was in order of its source ids.
///
/// # Errors
///
/// As [`body`].
pub fn rebuild(
    view: BodyView<'_>,
    meta: &Meta,
    options: &BuildOptions,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<Body, BuildError> {
    let mut order: Vec<u32> = (0..view.source_ids.len().min(view.corners.len()) as u32).collect();
    order.sort_by_key(|&triangle| view.source_ids[triangle as usize]);
    let mesh = Mesh {
        corners: permuted(view.corners, &order),
        source_ids: permuted(view.source_ids, &order),
        part_of: permuted(view.part_of, &order),
        parts: meta.parts.clone(),
        dropped: view.dropped.iter().map(|&[dropped, kept]| (dropped, kept)).collect(),
        degenerate: meta.degenerate,
    };
    body(mesh, meta.clone(), permuted(view.zones, &order), options, progress)
}

/// `values[order[0]], values[order[1]], ...`
fn permuted<T: Copy>(values: &[T], order: &[u32]) -> Vec<T> {
    order.iter().filter_map(|&triangle| values.get(triangle as usize).copied()).collect()
}
