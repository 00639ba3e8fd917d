//! Every solid is read, binary and text alike, and every fault has its place.

use super::super::{Format, Frame, LengthUnit};
use super::*;
use geometry::Corners;
use proptest::prelude::*;
use std::fmt::Write as _;

fn collect(bytes: &[u8]) -> Result<Collector<'static>, ImportError> {
    let frame = Frame::new(Format::Stl, LengthUnit::METRE, None, None).expect("orthogonal");
    let mut into = Collector::new("a.stl", frame);
    read(bytes, &mut into)?;
    Ok(into)
}

fn fault(bytes: &[u8]) -> String {
    collect(bytes).err().expect("refused").to_string()
}

fn text(solids: &[(&str, Vec<Corners>)]) -> String {
    let mut text = String::new();
    for (name, triangles) in solids {
        let _written = writeln!(text, "solid {name}");
        for corners in triangles {
            text.push_str("facet normal 0 0 1\n outer loop\n");
            for [x, y, z] in corners {
                let _written = writeln!(text, "  vertex {x} {y} {z:e}");
            }
            text.push_str(" endloop\nendfacet\n");
        }
        let _written = writeln!(text, "endsolid {name}");
    }
    text
}

fn binary(header: &[u8], triangles: &[Corners]) -> Vec<u8> {
    let mut bytes = header.to_vec();
    bytes.resize(80, b' ');
    bytes.extend_from_slice(&(triangles.len() as u32).to_le_bytes());
    for corners in triangles {
        bytes.extend_from_slice(&[0; 12]);
        bytes.extend_from_slice(bytemuck::bytes_of(corners));
        bytes.extend_from_slice(&[0; 2]);
    }
    bytes
}

fn triangles() -> impl Strategy<Value = Vec<Corners>> {
    prop::collection::vec(prop::array::uniform3(prop::array::uniform3(-1.0e6_f32..1.0e6)), 1..20)
}

proptest! {
    #[test]
    fn text_and_binary_give_the_same_bits(a in triangles(), b in triangles()) {
        let both: Vec<Corners> = a.iter().chain(&b).copied().collect();
        let named = text(&[("first", a.clone()), ("", vec![]), ("second one", b)]);
        let named = collect(named.as_bytes());
        let named = named.expect("valid");
        // A header that begins like text does not fool it.
        let plain = collect(&binary(b"solid or not", &both)).expect("valid");
        prop_assert_eq!(&named.corners, &both);
        prop_assert_eq!(&plain.corners, &both);
        let parts: Vec<&str> = named.parts.iter().map(|part| &*part.name).collect();
        prop_assert_eq!(parts, ["first", "second one"]);
        prop_assert_eq!(named.part_of.iter().filter(|part| **part == 0).count(), a.len());
    }

    #[test]
    fn bent_bytes_never_panic(
        a in triangles(),
        at in any::<prop::sample::Index>(),
        byte in any::<u8>(),
        as_text in any::<bool>(),
    ) {
        let mut bytes = if as_text { text(&[("a", a)]).into_bytes() } else { binary(b"", &a) };
        let at = at.index(bytes.len());
        bytes[at] = byte;
        let _outcome = collect(&bytes).is_ok();
        bytes.truncate(at);
        // A text may lose the name behind its last word and still be whole.
        let whole = as_text && bytes.windows(8).any(|word| word == b"endsolid");
        prop_assert!(whole || collect(&bytes).is_err());
    }
}

#[test]
fn every_fault_has_its_place() {
    let one = vec![[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]];
    let good = text(&[("a", one.clone()), ("b", one.clone())]);
    let cases = [
        ("", "a.stl: no triangle: the file is empty"),
        ("solid a\nendsolid\n", "a.stl: no triangle: its solid is empty"),
        ("solid a\n", "a.stl: the file ends inside solid \"a\""),
        ("solid a\nsolid b\n", "a.stl: line 2: a solid begins before the one before it ends"),
        ("solid a\nendsolid\nfacet\n", "a.stl: line 3: \"facet\" stands outside of a solid"),
    ];
    for (text, expected) in cases {
        assert_eq!(fault(text.as_bytes()), expected);
    }
    let bent = good.replacen("vertex 0 1 0", "vertex 0 one 0", 1);
    assert!(fault(bent.as_bytes()).starts_with("a.stl: line 2: in the facet that begins here: "));
    let last = good.rfind("vertex 0 1 0").expect("there");
    let bent = format!("{}vertex 0 inf 0{}", &good[..last], &good[last + 14..]);
    assert!(fault(bent.as_bytes()).starts_with("a.stl: line 11: in the facet that begins here: "));
    let mut cut = binary(b"", &one);
    cut.pop();
    assert_eq!(fault(&cut), "a.stl: it states 1 triangles, 134 bytes, but has 133 bytes");
    let mut bent = binary(b"", &[one[0], one[0]]);
    bent[84 + 50 + 12..][..4].copy_from_slice(&f32::NAN.to_le_bytes());
    assert_eq!(fault(&bent), "a.stl: triangle 1: coordinate NaN is not finite");
    assert_eq!(fault(&binary(b"", &[])), "a.stl: no triangle: it states 0 triangles");
}

#[test]
fn upper_case_and_trailing_bytes_are_read() {
    let one = vec![[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]];
    let loud = text(&[("a", one.clone())]).to_ascii_uppercase();
    assert_eq!(collect(loud.as_bytes()).expect("valid").corners, one);
    let mut long = binary(b"", &one);
    long.extend([0; 7]);
    let read = collect(&long).expect("valid");
    assert_eq!(read.notes, ["7 bytes after the last triangle left out"]);
}
