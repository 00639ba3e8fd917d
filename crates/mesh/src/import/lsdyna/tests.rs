//! Shells and solids in every way that cards write them; what is wrong is named with its line.

use super::super::{Format, Frame, LengthUnit};
use super::*;
use proptest::prelude::*;

const NODES: &str = "*KEYWORD\n$ a comment\n*NODE
       1             0.0             0.0             0.0       0       0
       2             1.0             0.0             0.0
       3           1.0E0           1.0+0             0.0
4, 0.0, 1.0, 0.0
       5             0.0             0.0             1.0
       6             1.0             0.0             1.0
       7             1.0             1.0             1.0
       8             0.0             1.0             1.0
";

fn with_side(text: &str, side: &[(&str, &str)]) -> Result<Collector<'static>, ImportError> {
    let frame = Frame::new(Format::LsDyna, LengthUnit::METRE, None, None).expect("orthogonal");
    let mut into = Collector::new("a.k", frame);
    let mut resolve = |name: &str| {
        let found = side.iter().find(|(known, _)| *known == name);
        found.map(|(_, text)| text.as_bytes().to_vec()).ok_or_else(|| "not found".to_owned())
    };
    read(text.as_bytes(), &mut resolve, &mut into)?;
    Ok(into)
}

fn collect(cards: &str) -> Result<Collector<'static>, ImportError> {
    with_side(&format!("{NODES}{cards}"), &[])
}

fn fault(cards: &str) -> String {
    collect(cards).err().expect("refused").to_string()
}

#[test]
fn shells_are_read_in_every_form() {
    for cards in [
        "*ELEMENT_SHELL\n       1       7       1       2       3       4\n",
        "*ELEMENT_SHELL\n1,7,1,2,3,4\n*END\n*ELEMENT_NONSENSE\n",
        "*ELEMENT_SHELL_THICKNESS\n       1       7       1       2       3       4\n  1.0  1.0\n",
        "*ELEMENT_SHELL_THICKNESS_OFFSET\n1,7,1,2,3,4\n1.,1.,1.,1.\n0.5\n",
        "*ELEMENT_SHELL_THICKNESS_BETA\n1,7,1,2,3,4\n1.,1.,1.,1.,45.\n",
        "*Element_Shell\n       1       7       1       2       3       4       0       0\n",
    ] {
        let read = collect(cards).unwrap_or_else(|e| panic!("{cards}: {e}"));
        assert_eq!(read.corners.len(), 2, "{cards}");
        assert_eq!(read.parts[0].name, "part 7");
    }
    // The fourth corner of a triangle repeats the third.
    let triangle = collect("*ELEMENT_SHELL\n1,7,1,2,3,3\n").expect("valid");
    assert_eq!(triangle.corners, [[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0]]]);
}

#[test]
fn parts_have_the_names_of_the_deck() {
    let cards = "*PART\nfront door\n         7         1         1\nroof\n         8         1\n\
                 *ELEMENT_SHELL\n1,7,1,2,3,4\n2,8,5,6,7,8\n";
    let read = collect(cards).expect("valid");
    let names: Vec<&str> = read.parts.iter().map(|part| part.name.as_str()).collect();
    assert_eq!(names, ["front door", "roof"]);
    assert!(read.parts[1].is_named("8"));
}

#[test]
fn solids_show_their_outer_faces_alone() {
    let cube = collect("*ELEMENT_SOLID\n1,3,1,2,3,4,5,6,7,8\n").expect("valid");
    assert_eq!(cube.corners.len(), 12);
    let two_lines = collect("*ELEMENT_SOLID\n       1       3\n1,2,3,4,5,6,7,8\n").expect("valid");
    assert_eq!(two_lines.corners, cube.corners);
    let tetrahedron = collect("*ELEMENT_SOLID\n1,3,1,2,3,5,5,5,5,5\n").expect("valid");
    assert_eq!(tetrahedron.corners.len(), 4);
    // Two tetrahedra share the face 1 2 3.
    let cards = "*ELEMENT_SOLID\n1,3,1,2,3,5,5,5,5,5\n2,3,1,3,2,4,4,4,4,4\n";
    let both = collect(cards).expect("valid");
    assert_eq!(both.corners.len(), 6);
    assert!(both.notes.iter().any(|note| note == "1 faces between solids left out"));
}

#[test]
fn what_has_no_surface_is_counted_and_named() {
    let cards = "*ELEMENT_BEAM\n1,2,3,4\n2,2,3,4\n*ELEMENT_SHELL\n1,7,1,2,3,4\n";
    let read = collect(cards).expect("valid");
    assert_eq!(read.notes, ["2 lines of *ELEMENT_BEAM left out: they have no surface"]);
}

#[test]
fn included_decks_are_read_and_named() {
    let main = "*KEYWORD\n*INCLUDE\nnodes.k\n*ELEMENT_SHELL\n1,7,1,2,3,4\n";
    let read = with_side(main, &[("nodes.k", NODES)]).expect("valid");
    assert_eq!(read.corners.len(), 2);
    for (name, says) in
        [("/etc/nodes.k", "leads out"), ("../n.k", "leads out"), ("no.k", "not found")]
    {
        let text = main.replace("nodes.k", name);
        let said = with_side(&text, &[]).err().expect("refused").to_string();
        assert!(said.contains(says), "{said}");
    }
    let own = "*INCLUDE\na.k\n";
    let said = with_side(own, &[("a.k", own)]).err().expect("refused").to_string();
    assert!(said.contains("decks that include decks"), "{said}");
    let bad = format!("{NODES}*ELEMENT_SHELL\n9,7,1,2,3,99\n");
    let said = with_side("*INCLUDE\nb.k\n", &[("b.k", &bad)]).err().expect("refused").to_string();
    assert!(said.contains("b.k, line 13, element 9: index 99"), "{said}");
}

#[test]
fn what_is_wrong_is_named_with_line_and_element() {
    for (cards, says) in [
        ("*ELEMENT_SHELL_COMPOSITE\n1,7,1,2,3,4\n", "line 12: *ELEMENT_SHELL with COMPOSITE"),
        ("*ELEMENT_SHELL_SOURCE_SINK\n1,7,1,2,3,4\n", "*ELEMENT_SHELL with SOURCE"),
        ("*ELEMENT_BLOB\n1,7,1,2,3,4\n", "line 12: *ELEMENT_BLOB"),
        ("*ELEMENT_SOLID_H20\n1,7,1,2,3,4\n", "*ELEMENT_SOLID_H20"),
        ("*ELEMENT_SHELL\n5,7,1,2,3,99\n", "line 13, element 5: index 99"),
        ("*ELEMENT_SHELL\n5,7,1,2,x,4\n", "line 13, element 5: \"x\" is not a whole number"),
        ("*ELEMENT_SHELL\n5,7,1,1,1,1\n", "a shell with 1 different corners"),
        ("*ELEMENT_SHELL\n5\n", "line 13: an element without a part"),
        ("*ELEMENT_SHELL_THICKNESS\n5,7,1,2,3,4\n", "1 more lines belong to it"),
        ("*NODE\n1,0,0,0\n", "node 1 is defined twice"),
        ("*NODE\n9,zero,0,0\n", "\"zero\" is not a number"),
        ("*NODE_TRANSFORM\n1,2\n", "*NODE_TRANSFORM"),
        ("*INCLUDE_TRANSFORM\nb.k\n", "*INCLUDE_TRANSFORM"),
        ("*KEYWORD LONG=Y\n", "the long format"),
        ("", "8 nodes, no shells or solids"),
    ] {
        let said = fault(cards);
        assert!(said.starts_with("a.k: ") && said.contains(says), "{says}: {said}");
    }
}

#[test]
fn numbers_are_read_as_fortran_writes_them() {
    for (text, value) in [("1.5", 1.5), ("-1.5E+2", -150.0), ("1.5D-1", 0.15), ("2.5-3", 0.0025)] {
        assert_eq!(real(text), Some(value), "{text}");
    }
    assert!(real("").is_none() && real("1.2.3").is_none() && real("-").is_none());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1_000))]

    #[test]
    fn bent_decks_never_panic(
        bends in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
    ) {
        let text = format!(
            "{NODES}*PART\ndoor\n7\n*ELEMENT_SHELL_THICKNESS\n1,7,1,2,3,4\n1,1,1,1\n\
             *ELEMENT_SOLID\n       1       3       1       2       3       4       5       6\n"
        );
        let mut bytes = text.into_bytes();
        for (at, byte) in bends {
            let at = at.index(bytes.len());
            bytes[at] = byte;
        }
        let frame = Frame::new(Format::LsDyna, LengthUnit::METRE, None, None).expect("orthogonal");
        let mut into = Collector::new("a.k", frame);
        let mut resolve = |_: &str| Err("none".to_owned());
        if let Err(error) = read(&bytes, &mut resolve, &mut into) {
            prop_assert!(error.to_string().len() > 5);
        }
    }
}
