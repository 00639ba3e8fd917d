//! Every way to write a triangle gives that triangle; every number of the file is checked.

use super::super::{Axis, Format, Frame, LengthUnit};
use super::*;
use diagnostic::Diagnostic as _;
use proptest::prelude::*;

/// Reads in glTF's own axes, so that positions come back as they were written.
fn collect(bytes: &[u8], side: &[(&str, &[u8])]) -> Result<Collector<'static>, ImportError> {
    let (up, forward) = (Some(Axis::Z), Some(Axis::X));
    let frame = Frame::new(Format::Gltf, LengthUnit::METRE, up, forward).expect("orthogonal");
    let mut into = Collector::new("a.gltf", frame);
    let mut resolve = |name: &str| {
        let found = side.iter().find(|(known, _)| *known == name);
        found.map(|(_, bytes)| bytes.to_vec()).ok_or_else(|| "not found".to_owned())
    };
    read(bytes, &mut resolve, &mut into)?;
    Ok(into)
}

fn fault(bytes: &[u8]) -> String {
    collect(bytes, &[]).err().expect("refused").to_string()
}

/// Four corners of a unit square as 48 bytes, then indices 0 1 2 3 as u8, u16 and u32.
fn content() -> Vec<u8> {
    let square: [[f32; 3]; 4] =
        [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    let mut bytes = bytemuck::cast_slice(&square).to_vec();
    bytes.extend([0_u8, 1, 2, 3]);
    bytes.extend(bytemuck::cast_slice(&[0_u16, 1, 2, 3]));
    bytes.extend(bytemuck::cast_slice(&[0_u32, 1, 2, 3]));
    assert_eq!(bytes.len(), 76);
    bytes
}

/// A file with the square, the given nodes and primitive, and the buffer's URI.
fn json_with(nodes: &str, primitive: &str, uri: &str) -> String {
    format!(
        r#"{{"asset": {{"version": "2.0"}}, "scene": 0, "scenes": [{{"nodes": [0]}}],
        "nodes": [{nodes}], "materials": [{{"name": "paint"}}],
        "meshes": [{{"name": "plate", "primitives": [{primitive}]}}],
        "accessors": [
          {{"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 4}},
          {{"bufferView": 1, "componentType": 5121, "type": "SCALAR", "count": 3}},
          {{"bufferView": 1, "byteOffset": 4, "componentType": 5123, "type": "SCALAR", "count": 3}},
          {{"bufferView": 1, "byteOffset": 12, "componentType": 5125, "type": "SCALAR",
             "count": 3}},
          {{"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 4, "sparse": {{
             "count": 1, "indices": {{"bufferView": 1, "byteOffset": 1, "componentType": 5121}},
             "values": {{"bufferView": 0, "byteOffset": 24}}}}}}],
        "bufferViews": [{{"buffer": 0, "byteLength": 48}},
                        {{"buffer": 0, "byteOffset": 48, "byteLength": 28}}],
        "buffers": [{{"byteLength": 76{uri}}}]}}"#
    )
}

const SIDE: &str = r#", "uri": "my%20plate.bin""#;
const PLAIN: &str = r#"{"attributes": {"POSITION": 0}, "indices": 1}"#;

fn with_side(nodes: &str, primitive: &str) -> Result<Collector<'static>, ImportError> {
    collect(json_with(nodes, primitive, SIDE).as_bytes(), &[("my plate.bin", &content())])
}

fn glb(json: &str, blob: &[u8]) -> Vec<u8> {
    let mut json = json.as_bytes().to_vec();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut bytes = b"glTF".to_vec();
    let length = 12 + 8 + json.len() + 8 + blob.len();
    for (kind, chunk) in [(*b"JSON", json.as_slice()), (*b"BIN\0", blob)] {
        if bytes.len() == 4 {
            bytes.extend(2_u32.to_le_bytes());
            bytes.extend((length as u32).to_le_bytes());
        }
        bytes.extend((chunk.len() as u32).to_le_bytes());
        bytes.extend(kind);
        bytes.extend(chunk);
    }
    bytes
}

const FIRST: [[f32; 3]; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0]];

#[test]
fn every_index_width_and_container_gives_the_same_triangle() {
    for indices in 1..4 {
        let primitive = format!(r#"{{"attributes": {{"POSITION": 0}}, "indices": {indices}}}"#);
        assert_eq!(with_side(r#"{"mesh": 0}"#, &primitive).expect("valid").corners, [FIRST]);
    }
    let inside = glb(&json_with(r#"{"mesh": 0}"#, PLAIN, ""), &content());
    assert_eq!(collect(&inside, &[]).expect("valid").corners, [FIRST]);
    let digits = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut data = String::new();
    for group in content().chunks(3) {
        let bits =
            group.iter().fold(0_u32, |sum, b| sum << 8 | u32::from(*b)) << (8 * (3 - group.len()));
        for digit in 0..=group.len() {
            data.push(char::from(digits[(bits >> (18 - 6 * digit)) as usize & 63]));
        }
    }
    let uri = format!(r#", "uri": "data:application/octet-stream;base64,{data}==""#);
    let text = json_with(r#"{"mesh": 0}"#, PLAIN, &uri);
    assert_eq!(collect(text.as_bytes(), &[]).expect("valid").corners, [FIRST]);
}

#[test]
fn lists_strips_and_fans_cover_the_same_square() {
    let modes = [(5, [[0, 1, 2], [1, 3, 2]]), (6, [[1, 2, 0], [2, 3, 0]])];
    for (mode, numbers) in modes {
        let primitive = format!(r#"{{"attributes": {{"POSITION": 0}}, "mode": {mode}}}"#);
        let read = with_side(r#"{"mesh": 0}"#, &primitive).expect("valid");
        let square: [[f32; 3]; 4] = bytemuck::pod_read_unaligned(&content()[..48]);
        assert_eq!(read.corners, numbers.map(|t| t.map(|n: usize| square[n])));
    }
    let points = r#"{"attributes": {"POSITION": 0}, "mode": 0}"#;
    let both = format!("{points}, {PLAIN}");
    let read = with_side(r#"{"mesh": 0}"#, &both).expect("valid");
    assert_eq!((read.corners.len(), read.notes.len()), (1, 1));
}

#[test]
fn a_sparse_accessor_replaces_what_it_names() {
    let primitive = r#"{"attributes": {"POSITION": 4}, "indices": 1}"#;
    let read = with_side(r#"{"mesh": 0}"#, primitive).expect("valid");
    assert_eq!(read.corners, [[FIRST[0], FIRST[2], FIRST[2]]]);
}

#[test]
fn transforms_are_applied_from_the_root_down() {
    // A quarter turn about z inside a doubling inside a shift.
    let nodes = r#"{"name": "body", "translation": [10, 0, 0], "children": [1]},
        {"matrix": [2,0,0,0, 0,2,0,0, 0,0,2,0, 0,0,0,1], "children": [2]},
        {"name": "door", "rotation": [0, 0, 0.70710678, 0.70710678], "mesh": 0}"#;
    let read = with_side(nodes, PLAIN).expect("valid");
    let expected = [[10.0, 0.0, 0.0], [10.0, 2.0, 0.0], [8.0, 2.0, 0.0]];
    for (found, expected) in read.corners[0].iter().flatten().zip(expected.iter().flatten()) {
        assert!((found - expected).abs() < 1e-6, "{:?}", read.corners);
    }
    assert_eq!(read.parts[0].name, "door");
    assert!(["door", "body", "plate"].iter().all(|name| read.parts[0].is_named(name)));
}

#[test]
fn several_materials_of_a_mesh_are_several_parts() {
    let painted = r#"{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}"#;
    let read = with_side(r#"{"mesh": 0}"#, &format!("{PLAIN}, {painted}")).expect("valid");
    let names: Vec<&str> = read.parts.iter().map(|part| &*part.name).collect();
    assert_eq!(names, ["plate", "plate:paint"]);
    assert!(read.parts[1].is_named("paint"));
}

#[test]
fn every_number_is_checked() {
    let bend = |from: &str, to: &str| {
        let text = json_with(r#"{"mesh": 0}"#, PLAIN, SIDE);
        assert!(text.contains(from), "{from}");
        let bytes = text.replacen(from, to, 1);
        collect(bytes.as_bytes(), &[("my plate.bin", &content())]).err().expect(to).to_string()
    };
    let cases = [
        (r#""scene": 0"#, r#""scene": 1"#, "scene: index 1"),
        (r#""nodes": [0]"#, r#""nodes": [7]"#, "node 7: index 7"),
        (r#""nodes": [0]"#, r#""nodes": [0, 0]"#, "node 0: the node has two parents"),
        (r#"{"mesh": 0}"#, r#"{"mesh": 3}"#, "node 0: index 3"),
        (r#"{"mesh": 0}"#, r#"{"mesh": 0, "scale": [1, 0, 1]}"#, "node 0: transform is singular"),
        (r#""POSITION": 0"#, r#""POSITION": 9"#, "mesh 0, primitive 0: index 9"),
        (r#""POSITION": 0"#, r#""POSITION": 1"#, "mesh 0, primitive 0: accessor 1: positions"),
        (r#""indices": 1"#, r#""indices": 0"#, "mesh 0, primitive 0: accessor 0: indices"),
        (r#""indices": 1"#, r#""indices": 8"#, "mesh 0, primitive 0: index 8"),
        (r#""count": 4"#, r#""count": 2"#, "mesh 0, primitive 0: index 2 is out of range"),
        (r#""count": 4"#, r#""count": 5"#, "mesh 0, primitive 0: an accessor reaches past"),
        (r#""count": 4"#, r#""count": 99999999999"#, "mesh 0, primitive 0: elements of"),
        (r#""count": 3"#, r#""count": 4"#, "mesh 0, primitive 0: 4 indices are not whole"),
        (r#""bufferView": 0"#, r#""bufferView": 5"#, "mesh 0, primitive 0: index 5"),
        (r#""buffer": 0"#, r#""buffer": 2"#, "mesh 0, primitive 0: index 2"),
        (r#""byteLength": 48"#, r#""byteLength": 480"#, "mesh 0, primitive 0: a buffer view"),
        (
            r#""byteLength": 48"#,
            r#""byteStride": 4, "byteLength": 48"#,
            "mesh 0, primitive 0: stride 4",
        ),
        (r#""byteLength": 76"#, r#""byteLength": 77"#, "buffer 0: it states 77 bytes"),
        (
            r#""componentType": 5126"#,
            r#""componentType": 1"#,
            "mesh 0, primitive 0: an accessor of unknown",
        ),
        (
            "my%20plate.bin",
            "../plate.bin",
            "buffer 0: side file \"../plate.bin\": only files beside",
        ),
        ("my%20plate.bin", "/etc/plate.bin", "buffer 0: side file \"/etc/plate.bin\": only files"),
        ("my%20plate.bin", "a/%2e%2e/b", "buffer 0: side file \"a/%2e%2e/b\": only files beside"),
        ("my%20plate.bin", "http://x/b", "buffer 0: side file \"http://x/b\": only files beside"),
        ("my%20plate.bin", "other.bin", "buffer 0: side file \"other.bin\": not found"),
        ("my%20plate.bin", "data:;base64,A", "buffer 0: its data URI is not base64"),
        (
            r#""scene": 0"#,
            r#""extensionsRequired": ["KHR_draco_mesh_compression"]"#,
            "its triangles are compressed with Draco (KHR_draco_mesh_compression), which is not",
        ),
        (r#""scene": 0,"#, r#""scene": 0"#, "line 1: JSON: "),
    ];
    for (from, to, expected) in cases {
        let found = bend(from, to);
        assert!(found.starts_with(&format!("a.gltf: {expected}")), "{to}: {found}");
    }
    // What is wrong in JSON has its place once.
    let text = json_with(r#"{"mesh": 0}"#, PLAIN, SIDE);
    let said = fault(text.replacen(r#""scene": 0"#, r#""scene": "a""#, 1).as_bytes());
    assert!(said.starts_with("a.gltf: line 1: JSON: invalid type: string \"a\", "), "{said}");
    assert_eq!((said.matches("line").count(), said.matches("column").count()), (1, 1), "{said}");
    // An index may be that of a scene, a node or a buffer.
    let wrong = text.replacen(r#""scene": 0"#, r#""scene": 1"#, 1);
    let side = content();
    let refused = collect(wrong.as_bytes(), &[("my plate.bin", &side)]).err().expect("refused");
    let help = diagnostic::Diagnostic::remedy(&refused).expect("a remedy");
    assert_eq!(help, "correct this number, or export the mesh again");
    let bare = |rest: &str| {
        let head = r#"{"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}]"#;
        fault(format!("{head}, {rest}}}").as_bytes())
    };
    assert_eq!(bare(r#""nodes": [{}]"#), "a.gltf: no triangle: it has no mesh");
    let unused = r#""nodes": [{}], "meshes": [{"primitives": []}]"#;
    assert_eq!(bare(unused), "a.gltf: no triangle: no node of its scene has a mesh");
    let empty = r#""nodes": [{"mesh": 0}], "meshes": [{"primitives": []}]"#;
    assert_eq!(bare(empty), "a.gltf: no triangle: its meshes are points or lines, or empty");
    assert_eq!(fault(b""), "a.gltf: no triangle: the file is empty");
    assert!(fault(b"glTF\x02\0\0\0\x05\0\0\0").starts_with("a.gltf: its header states 5 bytes"));
}

#[test]
fn a_hierarchy_deeper_than_any_model_is_refused() {
    let mut nodes: String = (1..400).map(|child| format!("{{\"children\": [{child}]}},")).collect();
    nodes.push_str(r#"{"mesh": 0}"#);
    let found = with_side(&nodes, PLAIN).err().expect("refused").to_string();
    assert_eq!(found, "a.gltf: node 256: nested nodes: 257 is above the limit of 256");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn bent_and_cut_bytes_never_panic(
        at in any::<prop::sample::Index>(),
        byte in any::<u8>(),
        digit in any::<bool>(),
        cut in any::<bool>(),
    ) {
        let mut bytes = glb(&json_with(r#"{"mesh": 0}"#, PLAIN, ""), &content());
        let at = at.index(bytes.len());
        bytes[at] = if digit { b'0' + byte % 10 } else { byte };
        if cut {
            bytes.truncate(at);
        }
        let outcome = collect(&bytes, &[]);
        prop_assert!(outcome.is_err() || !cut);
    }
}

/// Regression: lists that are objects in glTF 1.0 were taken for faults of JSON.
#[test]
fn a_former_version_and_compression_are_named_with_their_remedies() {
    let refused = |bytes: &[u8]| {
        let error = collect(bytes, &[]).err().expect("refused");
        (error.to_string(), error.remedy().unwrap_or_default().into_owned())
    };
    let former = br#"{"asset": {"version": "1.0"}, "buffers": {"b": {"uri": "b.bin"}}}"#;
    let first = br#"{"accessors": {"a": {}}, "asset": {"version": 1}}"#;
    for bytes in [&former[..], first, b"glTF\x01\0\0\0\x20\0\0\0"] {
        let (said, remedy) = refused(bytes);
        assert_eq!(said, "a.gltf: glTF 1.0 is not supported");
        assert!(remedy.contains("glTF 2.0"), "{remedy}");
    }
    let plain = json_with(r#"{"mesh": 0}"#, PLAIN, SIDE);
    for (name, says) in
        [("KHR_draco_mesh_compression", "Draco"), ("EXT_meshopt_compression", "meshopt")]
    {
        let required = format!(r#"{{"extensionsRequired": ["{name}"], "#);
        let (said, remedy) = refused(plain.replacen('{', &required, 1).as_bytes());
        assert!(said.contains(&format!("compressed with {says} ({name})")), "{said}");
        assert!(remedy.contains("without compression"), "{remedy}");
        let used = format!(r#"{{"extensionsUsed": ["{name}"], "#);
        let used = plain.replacen('{', &used, 1);
        let read = collect(used.as_bytes(), &[("my plate.bin", &content())]).expect("readable");
        assert!(read.notes.iter().any(|note| note.contains(says)), "{:?}", read.notes);
    }
}

#[test]
fn a_skin_is_named_and_not_applied() {
    let read = with_side(r#"{"mesh": 0, "skin": 0}"#, PLAIN).expect("readable");
    assert!(
        read.notes[0].starts_with("1 node has a skin, which is not applied"),
        "{:?}",
        read.notes
    );
    assert!(with_side(r#"{"mesh": 0}"#, PLAIN).expect("readable").notes.is_empty());
}
