//! From triangles to a tree: builds the nodes and brings every array into leaf order. A body adds
//! the data of a mesh.

use super::thread_pool::BuildPool;
use super::{BuildError, BuildOptions, Hierarchy, grow, hierarchy};
use crate::Tree;
use body::wide::{Laid, LeafRun};
use body::{Body, BodyView, Mesh, Meta, Zones};
use geometry::Corners;

/// Builds a tree over triangles: see [`Tree::build`].
pub(crate) fn assembled(corners: &[Corners], options: &BuildOptions) -> Result<Tree, BuildError> {
    let threads = grow::worth_starting(options.threads, corners.len());
    BuildPool::with(threads, |pool| {
        let no_zones = |order: &[u32]| pool.copies(Zones(0), order.len());
        let (tree, zones) = assembled_by(pool, corners, options, &|_| (), no_zones)?;
        Ok(Tree { zones, ..tree })
    })
}

/// [`assembled`] without zones, on this pool. `beside` receives the order of triangles, and does
/// any other work that needs it, while one thread lays out the wide tree.
fn assembled_by<R: Send>(
    pool: &BuildPool,
    corners: &[Corners],
    options: &BuildOptions,
    progress: &(dyn Fn(u64) + Sync),
    beside: impl FnOnce(&[u32]) -> R + Send,
) -> Result<(Tree, R), BuildError> {
    let Hierarchy { nodes, order, depth } = hierarchy(corners, options, pool, progress)?;
    // The largest array is allocated first, from the memory in which the tree was built.
    let mut in_order = Vec::with_capacity(corners.len());
    // One thread lays out the wide tree before all of them fill it; idle ones bring the arrays into
    // order meanwhile.
    let (laid, rest) = pool.both(
        || Laid::out(&nodes),
        || {
            pool.map(&order, |&from| corners[from as usize], &mut in_order);
            beside(&order)
        },
    );
    let wide = laid.filled(&in_order, pool.threads(), |shares| {
        pool.each(shares, LeafRun::fill);
    });
    let tree = Tree { nodes, wide, corners: in_order, ids: order, zones: Vec::new(), depth };
    Ok((tree, rest))
}

/// Builds the tree of a mesh and brings everything into leaf order.
///
/// `zones` has one entry per triangle in the order of the mesh. Of `meta`, the fields derived from
/// mesh and tree are set: parts, degenerate, build, leaf size, depth.
///
/// # Errors
///
/// As [`super::build`], and [`BuildError::Lengths`] if an array of the mesh is too short or too
/// long.
pub fn body(
    mesh: Mesh,
    meta: Meta,
    zones: Vec<Zones>,
    options: &BuildOptions,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<Body, BuildError> {
    let threads = grow::worth_starting(options.threads, mesh.corners.len());
    BuildPool::with(threads, |pool| body_by(pool, mesh, meta, zones, options, progress))
}

/// Runs [`body()`] on this pool.
fn body_by(
    pool: &BuildPool,
    mesh: Mesh,
    meta: Meta,
    zones: Vec<Zones>,
    options: &BuildOptions,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<Body, BuildError> {
    let triangles = mesh.corners.len();
    belong_together(triangles, mesh.source_ids.len(), mesh.part_of.len(), zones.len())?;
    let beside = |order: &[u32]| {
        let source_ids = permuted(&mesh.source_ids, order, pool);
        let part_of = permuted(&mesh.part_of, order, pool);
        (source_ids, part_of, permuted(&zones, order, pool))
    };
    let (tree, (source_ids, part_of, zones)) =
        assembled_by(pool, &mesh.corners, options, progress, beside)?;
    let Tree { nodes, wide, corners, depth, .. } = tree;
    Ok(Body {
        meta: Meta {
            parts: mesh.parts,
            degenerate: mesh.degenerate,
            build: options.build,
            leaf_size: options.leaf_size,
            depth,
            ..meta
        },
        wide,
        nodes,
        corners,
        source_ids,
        part_of,
        zones,
        dropped: mesh.dropped.iter().map(|&(dropped, kept)| [dropped, kept]).collect(),
    })
}

/// Builds another tree over a body that already has one.
///
/// The triangles are first restored to source order, so the result equals that of [`body()`] with
/// these options, if the mesh was in order of its source ids.
///
/// # Errors
///
/// As [`body()`].
pub fn rebuild(
    view: BodyView<'_>,
    meta: &Meta,
    options: &BuildOptions,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<Body, BuildError> {
    let threads = grow::worth_starting(options.threads, view.corners.len());
    BuildPool::with(threads, |pool| rebuild_by(pool, view, meta, options, progress))
}

/// Runs [`rebuild`] on this pool.
fn rebuild_by(
    pool: &BuildPool,
    view: BodyView<'_>,
    meta: &Meta,
    options: &BuildOptions,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<Body, BuildError> {
    let triangles = view.corners.len();
    belong_together(triangles, view.source_ids.len(), view.part_of.len(), view.zones.len())?;
    let mut order: Vec<u32> = (0..triangles as u32).collect();
    order.sort_by_key(|&triangle| view.source_ids[triangle as usize]);
    let mesh = Mesh {
        corners: permuted(view.corners, &order, pool),
        source_ids: permuted(view.source_ids, &order, pool),
        part_of: permuted(view.part_of, &order, pool),
        parts: meta.parts.clone(),
        dropped: view.dropped.iter().map(|&[dropped, kept]| (dropped, kept)).collect(),
        degenerate: meta.degenerate,
    };
    let zones = permuted(view.zones, &order, pool);
    body_by(pool, mesh, meta.clone(), zones, options, progress)
}

fn belong_together(
    triangles: usize,
    source_ids: usize,
    part_of: usize,
    zones: usize,
) -> Result<(), BuildError> {
    let lengths = [("source ids", source_ids), ("part numbers", part_of), ("zone sets", zones)];
    match lengths.into_iter().find(|(_, entries)| *entries != triangles) {
        Some((array, entries)) => Err(BuildError::Lengths { triangles, array, entries }),
        None => Ok(()),
    }
}

/// `values[order[0]], values[order[1]], ...`
fn permuted<T: Copy + Send + Sync>(values: &[T], order: &[u32], pool: &BuildPool) -> Vec<T> {
    let mut permuted = Vec::with_capacity(order.len());
    pool.map(order, |&from| values[from as usize], &mut permuted);
    permuted
}
