//! Bodies for tests, with the simplest possible tree.

use crate::meta::{BodyKind, Build, Meta};
use crate::outline::Outlines;
use crate::{Body, Mesh, Node, Wide, Zones};
use geometry::{Aabb, Corners};

/// A body whose tree halves the triangles in source order, with leaves of one or two.
#[must_use]
pub fn body_of(mesh: &Mesh) -> Body {
    let mut nodes = Vec::new();
    let depth = grow(&mesh.corners, 0, mesh.corners.len(), &mut nodes);
    let dropped = mesh.dropped.iter().map(|(gone, kept)| [*gone, *kept]).collect();
    Body {
        meta: Meta {
            name: "test".into(),
            kind: BodyKind::Sedan,
            mass_kg: Some(1000.0),
            centre_m: [0.0; 3],
            gyration_m: 1.0,
            mass_source: "test".into(),
            impact: crate::OwnParameters::default(),
            impact_source: String::new(),
            occupants: None,
            parts: mesh.parts.clone(),
            origin: "test".into(),
            origin_hash: String::new(),
            degenerate: mesh.degenerate,
            build: Build::Paper,
            leaf_size: 2,
            depth,
            outlines: Outlines::default(),
            front_height_m: None,
        },
        wide: Wide::of(&nodes, &mesh.corners),
        nodes,
        corners: mesh.corners.clone(),
        source_ids: mesh.source_ids.clone(),
        part_of: mesh.part_of.clone(),
        zones: vec![Zones(5); mesh.corners.len()],
        dropped,
    }
}

fn grow(corners: &[Corners], first: usize, end: usize, nodes: &mut Vec<Node>) -> u32 {
    let bounds = corners[first..end].iter().map(Aabb::of).fold(Aabb::EMPTY, |a, b| a.union(&b));
    let at = nodes.len();
    if end - first <= 2 {
        nodes.push(Node { bounds, link: first as u32, count: (end - first) as u32 });
        return 1;
    }
    nodes.push(Node { bounds, link: 0, count: 0 });
    let middle = first + (end - first) / 2;
    let left = grow(corners, first, middle, nodes);
    nodes[at].link = nodes.len() as u32;
    let right = grow(corners, middle, end, nodes);
    1 + left.max(right)
}

/// A mesh of the given triangles: one part, ids in order.
#[must_use]
pub fn mesh_of(corners: Vec<Corners>) -> Mesh {
    let count = corners.len();
    Mesh {
        corners,
        source_ids: (0..count as u32).collect(),
        part_of: vec![0; count],
        parts: vec!["all".into()],
        dropped: Vec::new(),
        degenerate: 0,
    }
}

/// `count` small triangles along a line, all different.
#[must_use]
pub fn strip(count: usize) -> Vec<Corners> {
    let step = |i: usize| i as f32 * 0.125;
    (0..count)
        .map(|i| [[step(i), 0.0, 0.5], [step(i) + 0.1, 1.0, 0.0], [step(i), -1.0, step(i) * 0.3]])
        .collect()
}
