//! Faces are the triangles that the text says, and every fault has its line.

use super::super::{Format, Frame, LengthUnit};
use super::*;
use proptest::prelude::*;

fn collect(text: &str) -> Result<Collector<'static>, ImportError> {
    let frame = Frame::new(Format::Obj, LengthUnit::METRE, None, None).expect("orthogonal");
    let mut into = Collector::new("a.obj", frame);
    read(text.as_bytes(), &mut into)?;
    Ok(into)
}

fn fault(text: &str) -> String {
    collect(text).err().expect("refused").to_string()
}

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

#[derive(Clone, Debug)]
enum Line {
    Vertex([f32; 3]),
    /// Corners as numbers of vertices before this line; whether to count backwards.
    Face([prop::sample::Index; 3], bool, &'static str),
    Group(u8),
    Remark,
}

fn line() -> impl Strategy<Value = Line> {
    prop_oneof![
        3 => prop::array::uniform3(-1.0e6_f32..1.0e6).prop_map(Line::Vertex),
        3 => (any::<[prop::sample::Index; 3]>(), any::<bool>(),
              prop::sample::select(vec!["", "/", "/7", "//9", "/1/2"]))
            .prop_map(|(corners, backwards, tail)| Line::Face(corners, backwards, tail)),
        1 => (0_u8..3).prop_map(Line::Group),
        1 => Just(Line::Remark),
    ]
}

proptest! {
    /// Positions to the bit, in order, with the group in force, for all ways to write an index.
    #[test]
    fn faces_are_what_the_text_says(
        lines in prop::collection::vec(line(), 0..60),
        last in any::<prop::sample::Index>(),
    ) {
        let mut text = String::new();
        let (mut vertices, mut expected, mut group) = (Vec::new(), Vec::new(), String::new());
        // A vertex and a face at least: a file without is another law's.
        let least = [Line::Vertex([1.5, -0.0, 3.0]), Line::Face([last; 3], true, "")];
        for line in least.into_iter().chain(lines)
        {
            match line {
                Line::Vertex([x, y, z]) => {
                    vertices.push([x, y, z]);
                    text.push_str(&format!("v {x} {y} {z}\n"));
                }
                Line::Face(corners, backwards, tail) => {
                    let count = vertices.len();
                    let numbers = corners.map(|corner| corner.index(count));
                    let named = if group.is_empty() { "unnamed" } else { &group };
                    expected.push((numbers.map(|n| vertices[n]), named.to_owned()));
                    let written = numbers.map(|n| {
                        if backwards { n as i64 - count as i64 } else { n as i64 + 1 }
                    });
                    let [a, b, c] = written;
                    text.push_str(&format!("f {a}{tail} {b}{tail} {c}{tail}\n"));
                }
                Line::Group(number) => {
                    group = format!("group{number}");
                    text.push_str(&format!("g {group}\n"));
                }
                Line::Remark => text.push_str("# v f\nvt 0 0\nvn 1 1 1\ns off\n\n"),
            }
        }
        let read = collect(&text).expect("valid");
        let found: Vec<_> = read.corners.iter().zip(&read.part_of)
            .map(|(corners, part)| (*corners, read.parts[usize::from(*part)].name.clone()))
            .collect();
        prop_assert_eq!(found, expected);
    }

    #[test]
    fn no_bytes_make_it_panic(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        let letters = b"vfgo 0123-/.e\n\\";
        let letter = |byte: &u8| char::from(letters[usize::from(*byte) % letters.len()]);
        let text: String = bytes.iter().map(letter).collect();
        let _outcome = collect(&text).is_ok();
    }
}

#[test]
fn every_fault_has_its_line() {
    let cases = [
        ("f 1 2\n", "a.obj: line 5: a face with 2 corners is not a surface"),
        ("\nf 1 2 0\n", "a.obj: line 6: index 0 is out of range: OBJ counts vertices from 1"),
        ("f 1 2 9\nf 1 2 3\n", "a.obj: line 5: index 9 is out of range: the file has 4 vertices"),
        (
            "f 1 2 -5\n",
            "a.obj: line 5: index -5 is out of range: there are 4 vertices before \
                        this line",
        ),
        ("f 1 2 x\n", "a.obj: line 5: \"x\" is not a vertex index"),
        ("v 1 2\nf 1 2 3\n", "a.obj: line 5: a vertex has 3 coordinates, this one 2"),
        ("v 1 2 3e\nf 1 2 3\n", "a.obj: line 5: \"3e\" is not a number"),
        ("v 1 2 nan\nf 1 2 3\n", "a.obj: line 5: coordinate NaN is not finite"),
        ("v 1 2 1e39\nf 1 2 3\n", "a.obj: line 5: coordinate inf is not finite"),
        ("v 1 2 3e6\nf 1 2 3\n", "a.obj: line 5: coordinate 3000000 m is beyond 1000000 m"),
        ("v 1 2 3 0\nf 1 2 3\n", "a.obj: line 5: the vertex has weight 0"),
        ("l 1 2\n", "a.obj: no triangle: 1 line without faces"),
        ("", "a.obj: no triangle: a point cloud of 4 vertices without faces"),
    ];
    for (tail, expected) in cases {
        assert_eq!(fault(&format!("{SQUARE}{tail}")), expected);
    }
    assert_eq!(fault(""), "a.obj: no triangle: the file is empty");
    assert_eq!(
        fault("P 0.3 0.3 0.4 10 1 1558\n"),
        "a.obj: no triangle: no line of it is a vertex (v) or a face (f) of Wavefront OBJ"
    );
    assert_eq!(fault("v 0 0 0\0\n"), "a.obj: it is not text: it contains zero bytes");
}

#[test]
fn a_face_may_name_vertices_that_come_later() {
    let read = collect(&format!("f 1 2 3\n{SQUARE}")).expect("valid");
    assert_eq!(read.corners, [[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0]]]);
}

#[test]
fn lines_are_joined_weights_divide_and_colours_are_left_out() {
    let text = "v 2 4 6 2\nv 1 0 0 0.5 0.5 0.5 # red\nv 0 1 \\\n0\nf 1 \\\n2 \\\n3 # end\n";
    let read = collect(text).expect("valid");
    assert_eq!(read.corners, [[[1.0, 2.0, 3.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]]);
}

#[test]
fn a_byte_order_mark_is_no_fault() {
    assert_eq!(collect(&format!("\u{feff}{SQUARE}f 1 2 3\n")).expect("valid").corners.len(), 1);
}

#[test]
fn a_part_is_a_group_else_an_object_with_its_material() {
    let text = format!(
        "{SQUARE}f 1 2 3\no car\nf 1 2 3\nusemtl glass\nf 1 2 3\ng front door\nf 1 2 3\n\
         usemtl door\ng door\nf 1 2 3\no car\nf 1 2 3\ng\nusemtl glass\nf 1 2 3\n"
    );
    let read = collect(&text).expect("valid");
    let names: Vec<&str> =
        read.part_of.iter().map(|p| &*read.parts[usize::from(*p)].name).collect();
    let expected =
        ["unnamed", "car", "car:glass", "front door:glass", "door", "car:door", "car:glass"];
    assert_eq!(names, expected);
    let by = |name: &str| {
        read.part_of.iter().filter(|p| read.parts[usize::from(**p)].is_named(name)).count()
    };
    assert_eq!([by("car"), by("glass"), by("door"), by("front"), by("wheel")], [6, 3, 3, 1, 0]);
}

#[test]
fn polygons_are_numbered_in_the_order_of_the_file() {
    let read = collect(&format!("{SQUARE}f 1 2 3 4\nf 4 3 2 1\n")).expect("valid");
    assert_eq!(read.corners.len(), 4);
    assert_eq!(read.corners[1], [[0.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]);
}
