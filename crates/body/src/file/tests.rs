//! Intact files survive a round trip; damaged, truncated or altered ones are rejected.

use super::*;
use crate::Wide;
use crate::meta::{LEAF_SIZE_MAX, Meta};
use crate::testing::{body_of, mesh_of, strip};
use geometry::Corners;
use proptest::prelude::*;

fn sample(count: usize) -> Body {
    let mut mesh = mesh_of(strip(count));
    // Ids with a gap, and a dropped duplicate.
    mesh.source_ids = (0..count as u32).map(|id| id * 2).rev().collect();
    mesh.dropped = vec![(1, 0)];
    body_of(&mesh)
}

fn opened(bytes: &[u8]) -> Result<(Meta, Body), FileError> {
    let aligned = Aligned::copy_of(bytes);
    let (meta, view) = view(aligned.bytes())?;
    let body = Body {
        meta: meta.clone(),
        nodes: view.nodes.to_vec(),
        wide: Wide { nodes: view.wide.to_vec(), of: view.wide_of.to_vec() },
        corners: view.corners.to_vec(),
        source_ids: view.source_ids.to_vec(),
        part_of: view.part_of.to_vec(),
        zones: view.zones.to_vec(),
        dropped: view.dropped.to_vec(),
    };
    Ok((meta, body))
}

/// Writes the correct hash over deliberately altered bytes, so that only the content is checked.
fn rehash(bytes: &mut [u8]) {
    let mut head: Head = bytemuck::pod_read_unaligned(&bytes[..TABLE_AT]);
    head.hash = hash_of(&head, bytes);
    bytes[..TABLE_AT].copy_from_slice(bytemuck::bytes_of(&head));
}

proptest! {
    #[test]
    fn a_body_comes_back_bit_for_bit(corners in prop::collection::vec(any_corners(), 1..60)) {
        let body = body_of(&mesh_of(corners));
        let bytes = encode(&body).expect("valid");
        prop_assert_eq!(bytes.len() % ALIGN, 0);
        let (meta, back) = opened(&bytes).expect("as written");
        prop_assert_eq!(meta, body.meta);
        let bits = |corners: &[Corners]| bytemuck::cast_slice::<_, u8>(corners).to_vec();
        prop_assert_eq!(bits(&back.corners), bits(&body.corners));
        prop_assert_eq!(back.nodes, body.nodes);
        prop_assert_eq!(back.source_ids, body.source_ids);
    }

    /// Without the protection of the hash: altered bytes never cause a panic, and what is accepted
    /// can be traversed.
    #[test]
    fn bent_content_is_refused_or_still_a_tree(
        flips in prop::collection::vec((any::<prop::sample::Index>(), 0_u8..8), 1..4),
    ) {
        let mut bytes = encode(&sample(9)).expect("valid");
        for (at, bit) in flips {
            let at = at.index(bytes.len());
            bytes[at] ^= 1 << bit;
        }
        rehash(&mut bytes);
        if let Ok((meta, body)) = opened(&bytes) {
            prop_assert_eq!(reached(&body), body.corners.len());
            prop_assert!(body.part_of.iter().all(|part| usize::from(*part) < meta.parts.len()));
        }
    }
}

fn any_corners() -> impl Strategy<Value = Corners> {
    prop::array::uniform3(prop::array::uniform3(-1.0e6_f32..1.0e6))
}

/// Number of triangles reached by a traversal from the root.
fn reached(body: &Body) -> usize {
    let mut stack = vec![0];
    let mut count = 0;
    while let Some(at) = stack.pop() {
        let node = body.nodes[at];
        if node.is_leaf() {
            count += body.corners[node.link as usize..][..node.count as usize].len();
        } else {
            stack.extend([at + 1, node.link as usize]);
        }
    }
    count
}

#[test]
fn a_cut_file_is_refused_at_every_byte() {
    let bytes = encode(&sample(7)).expect("valid");
    for cut in 0..bytes.len() {
        let fault = opened(&bytes[..cut]).expect_err("cut");
        let expected = if cut == 0 {
            fault == FileError::Foreign
        } else {
            matches!(fault, FileError::Length { .. })
        };
        assert!(expected, "cut at {cut}: {fault}");
    }
}

#[test]
fn a_lengthened_file_is_refused() {
    let mut bytes = encode(&sample(7)).expect("valid");
    bytes.extend([0; 64]);
    assert!(matches!(opened(&bytes), Err(FileError::Length { .. })));
}

#[test]
fn every_single_flipped_bit_is_refused() {
    let bytes = encode(&sample(5)).expect("valid");
    for at in 0..bytes.len() {
        for bit in 0..8 {
            let mut bent = bytes.clone();
            bent[at] ^= 1 << bit;
            assert!(opened(&bent).is_err(), "byte {at}, bit {bit}");
        }
    }
}

#[test]
fn another_version_is_named() {
    let mut bytes = encode(&sample(3)).expect("valid");
    bytes[8] = 9;
    assert_eq!(opened(&bytes).err(), Some(FileError::Version(9)));
}

#[test]
fn bytes_off_alignment_are_refused_and_not_copied() {
    let bytes = encode(&sample(3)).expect("valid");
    let aligned = Aligned::copy_of(&[&[0_u8; 4], bytes.as_slice()].concat());
    assert_eq!(quick_view(&aligned.bytes()[4..]).err(), Some(FileError::Unaligned));
}

#[test]
fn the_quick_way_gives_the_same_arrays() {
    let body = sample(20);
    let aligned = Aligned::copy_of(&encode(&body).expect("valid"));
    let (meta, view) = quick_view(aligned.bytes()).expect("as written");
    assert_eq!((meta, view.nodes, view.corners), (body.meta.clone(), &*body.nodes, &*body.corners));
    assert_eq!((view.zones, view.dropped), (&*body.zones, &*body.dropped));
}

#[test]
fn a_body_that_breaks_a_rule_is_neither_written_nor_accepted() {
    type Bend = fn(&mut Body);
    let bends: [(&str, Bend); 19] = [
        ("no triangles", |b| {
            b.corners.clear();
        }),
        ("not a number", |b| b.corners[2][1][0] = f32::NAN),
        ("too far", |b| b.corners[2][1][0] = 2.0e6),
        ("a short array", |b| {
            b.zones.pop();
        }),
        ("an id twice", |b| b.source_ids[1] = b.source_ids[0]),
        ("no such part", |b| b.part_of[0] = 1),
        ("dropped but there", |b| b.dropped[0] = [2, 0]),
        ("dropped for nothing", |b| b.dropped[0] = [1, 3]),
        ("dropped twice", |b| b.dropped.push([1, 0])),
        ("a child before its parent", |b| b.nodes[0].link = 0),
        ("a child of two", |b| b.nodes[0].link = 2),
        ("a child beyond the end", |b| b.nodes[0].link = 99),
        ("a leaf that overlaps the next", |b| b.nodes.last_mut().expect("one").link -= 1),
        ("a leaf beyond the end", |b| b.nodes.last_mut().expect("one").count += 1),
        ("a box too small", |b| b.nodes[0].bounds.max[0] -= 0.01),
        ("a wrong depth", |b| b.meta.depth += 1),
        ("leaves larger than said", |b| b.meta.leaf_size = 1),
        ("larger leaves than there may be", |b| b.meta.leaf_size = LEAF_SIZE_MAX + 1),
        ("a negative mass", |b| b.meta.mass_kg = Some(-1.0)),
    ];
    assert!(encode(&sample(9)).is_ok());
    for (name, bend) in bends {
        let mut body = sample(9);
        bend(&mut body);
        assert!(check_body(&body.meta, &body.view()).is_err(), "{name}");
        assert!(encode(&body).is_err(), "{name}");
    }
}

#[test]
fn the_content_hash_is_the_files_identity() {
    let bytes = encode(&sample(4)).expect("valid");
    let hash = content_hash(&bytes).expect("header");
    assert_eq!(hash.len(), 64);
    assert_ne!(content_hash(&encode(&sample(5)).expect("valid")), Ok(hash));
}
