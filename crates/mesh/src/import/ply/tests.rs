//! All encodings give the same triangles; what a header claims is checked before it is believed.

use super::super::{Format, Frame, LengthUnit};
use super::*;
use proptest::prelude::*;
use std::fmt::Write as _;

fn collect(bytes: &[u8]) -> Result<Collector<'static>, ImportError> {
    let frame = Frame::new(Format::Ply, LengthUnit::METRE, None, None).expect("orthogonal");
    let mut into = Collector::new("a.ply", frame);
    read(bytes, &mut into)?;
    Ok(into)
}

fn fault(bytes: &[u8]) -> String {
    collect(bytes).err().expect("refused").to_string()
}

fn header(format: &str, vertices: usize, faces: usize) -> String {
    format!(
        "ply\nformat {format} 1.0\ncomment made here\nelement vertex {vertices}\n\
         property uchar red\nproperty float x\nproperty double y\nproperty float z\n\
         element face {faces}\nproperty list uchar int vertex_indices\nproperty uchar flag\n\
         end_header\n"
    )
}

fn ascii(points: &[[f32; 3]], faces: &[Vec<i32>]) -> Vec<u8> {
    let mut text = header("ascii", points.len(), faces.len());
    for [x, y, z] in points {
        let _written = writeln!(text, "9 {x} {y} {z}");
    }
    for face in faces {
        let _written = write!(text, "{}", face.len());
        face.iter().for_each(|index| text.push_str(&format!(" {index}")));
        text.push_str(" 1\n");
    }
    text.into_bytes()
}

fn binary(points: &[[f32; 3]], faces: &[Vec<i32>], big: bool) -> Vec<u8> {
    let format = if big { "binary_big_endian" } else { "binary_little_endian" };
    let mut bytes = header(format, points.len(), faces.len()).into_bytes();
    let mut push = |mut value: Vec<u8>| {
        if big {
            value.reverse();
        }
        bytes.extend(value);
    };
    for [x, y, z] in points {
        push(vec![9]);
        push(x.to_le_bytes().into());
        push(f64::from(*y).to_le_bytes().into());
        push(z.to_le_bytes().into());
    }
    for face in faces {
        push(vec![face.len() as u8]);
        face.iter().for_each(|index| push(index.to_le_bytes().into()));
        push(vec![1]);
    }
    bytes
}

fn points() -> impl Strategy<Value = Vec<[f32; 3]>> {
    prop::collection::vec(prop::array::uniform3(-1.0e6_f32..1.0e6), 3..20)
}

proptest! {
    #[test]
    fn every_encoding_gives_the_same_bits(
        points in points(),
        picks in prop::collection::vec(any::<[prop::sample::Index; 3]>(), 1..20),
    ) {
        let numbers: Vec<[usize; 3]> =
            picks.iter().map(|pick| pick.map(|index| index.index(points.len()))).collect();
        let faces: Vec<Vec<i32>> =
            numbers.iter().map(|face| face.iter().map(|n| *n as i32).collect()).collect();
        let expected: Vec<[[f32; 3]; 3]> =
            numbers.iter().map(|face| face.map(|n| points[n])).collect();
        let [little, big] = [false, true].map(|big| binary(&points, &faces, big));
        for bytes in [ascii(&points, &faces), little, big] {
            prop_assert_eq!(&collect(&bytes).expect("valid").corners, &expected);
        }
    }

    #[test]
    fn bent_and_cut_bytes_never_panic(
        points in points(),
        at in any::<prop::sample::Index>(),
        byte in any::<u8>(),
        as_text in any::<bool>(),
    ) {
        let faces = vec![vec![0, 1, 2], vec![2, 1, 0, 1]];
        let mut bytes =
            if as_text { ascii(&points, &faces) } else { binary(&points, &faces, false) };
        let at = at.index(bytes.len());
        bytes[at] = byte;
        let _outcome = collect(&bytes).is_ok();
        bytes.truncate(at);
        prop_assert!(collect(&bytes).is_err() || at + 1 >= bytes.len());
    }
}

const TRIANGLE: [[f32; 3]; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

#[test]
fn faces_may_stand_before_their_vertices() {
    let text = "ply\nformat ascii 1.0\nelement face 1\nproperty list uchar int vertex_indices\n\
                element vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
                end_header\n3 0 1 2\n0 0 0\n1 0 0\n0 1 0\n";
    let read = collect(text.as_bytes()).expect("valid");
    assert_eq!(read.corners, [TRIANGLE]);
}

#[test]
fn every_fault_has_its_place() {
    let good = String::from_utf8(ascii(&TRIANGLE, &[vec![0, 1, 2]])).expect("text");
    let bend = |from: &str, to: &str| fault(good.replacen(from, to, 1).as_bytes());
    assert_eq!(fault(b""), "a.ply: no triangle: the file is empty");
    let short = fault(good.trim_end().trim_end_matches("3 0 1 2 1").as_bytes());
    assert!(short.starts_with("a.ply: line 16: unexpected end of file while reading"), "{short}");
    assert!(!short.ends_with('.'), "{short}");
    assert_eq!(fault(b"plx\n"), "a.ply: line 1: a PLY file begins with \"ply\"");
    assert_eq!(fault(b"ply\nformat"), "a.ply: the header has no line \"end_header\"");
    assert_eq!(
        bend("3 0 1 2", "3 0 1 3"),
        "a.ply: face 0: index 3 is out of range: the file has 3 vertices, from 0"
    );
    assert_eq!(
        bend("3 0 1 2", "3 0 1 -1"),
        "a.ply: face 0: index -1 is out of range: the file has 3 vertices, from 0"
    );
    assert_eq!(bend("3 0 1 2", "2 0 1"), "a.ply: face 0: a face with 2 corners is not a surface");
    assert_eq!(
        bend("9 1 0 0", "9 1 2000000 0"),
        "a.ply: vertex 1: coordinate 2000000 m is beyond 1000000 m"
    );
    assert_eq!(bend("face 1", "face 0"), "a.ply: no triangle: 3 vertices without faces");
    assert_eq!(
        bend("element face", "element edge"),
        "a.ply: no triangle: the header has no element \"face\""
    );
    assert_eq!(bend("float z", "float w"), "a.ply: element vertex has no property z");
    assert_eq!(
        bend("vertex_indices", "corners"),
        "a.ply: element face has no property list vertex_indices"
    );
    assert_eq!(
        bend("vertex 3", "vertex 999999999"),
        "a.ply: vertices: 999999999 is above the limit of 12000000"
    );
    assert_eq!(
        bend("vertex 3", "vertex 9999999"),
        "a.ply: it states 9999999 elements \"vertex\" in 252 bytes"
    );
    let cut = bend("9 0 1 0\n", "");
    // The face is taken for the third vertex, and then there is no face.
    assert!(cut.starts_with("a.ply: line 16: ") && cut.contains("face"), "{cut}");
    let bent = bend("9 0 1 0", "9 0 one 0");
    assert!(bent.starts_with("a.ply: line 15: "), "{bent}");
}

#[test]
fn a_signature_in_the_header_is_left_out_and_noted() {
    let good = String::from_utf8(ascii(&TRIANGLE, &[vec![0, 1, 2]])).expect("text");
    let signed = good.replacen("comment made", "Created by hand, made", 1);
    let read = collect(signed.as_bytes()).expect("valid");
    assert_eq!((read.corners.len(), &*read.notes[0]), (1, "header line 3 left out"));
    let broken = signed.replacen("9 0 1 0", "9 0 one 0", 1);
    assert!(fault(broken.as_bytes()).starts_with("a.ply: line 15: "), "counts the line left out");
}

#[test]
fn carriage_returns_end_header_lines_of_binary_files_too() {
    let bytes = binary(&TRIANGLE, &[vec![0, 1, 2]], false);
    let end = bytes.windows(11).position(|w| w == b"end_header\n").expect("there") + 11;
    let head = String::from_utf8(bytes[..end].to_vec()).expect("text").replace('\n', "\r\n");
    let crlf = [head.as_bytes(), &bytes[end..]].concat();
    assert_eq!(collect(&crlf).expect("valid").corners, [TRIANGLE]);
}
