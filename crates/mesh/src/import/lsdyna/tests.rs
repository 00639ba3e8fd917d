//! Shells and solids in every way that cards write them; what is wrong is named with its line.

use super::super::{Format, Frame, LengthUnit};
use super::*;
use diagnostic::Diagnostic as _;
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
    let chain: Vec<(String, String)> =
        (0..12).map(|i| (format!("c{i}.k"), format!("*INCLUDE\nc{}.k\n", i + 1))).collect();
    let side: Vec<(&str, &str)> = chain.iter().map(|(name, text)| (&**name, &**text)).collect();
    let said = with_side("*INCLUDE\nc0.k\n", &side).err().expect("refused").to_string();
    assert!(said.contains("decks that include decks"), "{said}");
    let bad = format!("{NODES}*ELEMENT_SHELL\n9,7,1,2,3,99\n");
    let said = with_side("*INCLUDE\nb.k\n", &[("b.k", &bad)]).err().expect("refused").to_string();
    assert!(said.contains("b.k, line 13, element 9: index 99"), "{said}");
}

/// Regression: a circle was said to be too deep, and a missing deck to be a file of the mesh; both
/// without the line, and with remedies for other formats.
#[test]
fn circles_and_missing_decks_are_named_with_line_and_remedy() {
    for (main, side, says) in [
        ("*KEYWORD\n*INCLUDE\na.k\n", vec![], "a.k: line 3: the deck includes itself: a.k → a.k"),
        (
            "*INCLUDE\nb.k\n",
            vec![("b.k", "$\n*INCLUDE\n./a.k\n")],
            "b.k, line 3: the deck includes itself: a.k → b.k → ./a.k",
        ),
        (
            "*INCLUDE\nb.k\n",
            vec![("b.k", "*INCLUDE\nc.k\n"), ("c.k", "*INCLUDE\nb.k\n")],
            "c.k, line 2: the deck includes itself: b.k → c.k → b.k",
        ),
    ] {
        let error = with_side(main, &side).err().expect("refused");
        assert!(error.to_string().contains(says), "{error}");
        assert!(error.remedy().unwrap_or_default().contains("closes the circle"));
    }
    let error = with_side("*KEYWORD\n*INCLUDE\nno.k\n", &[]).err().expect("refused");
    assert_eq!(error.to_string(), "a.k: line 3: *INCLUDE of \"no.k\": not found");
    let remedy = error.remedy().unwrap_or_default().into_owned();
    assert!(remedy.contains("the included deck") && !remedy.contains("glb"), "{remedy}");
}

#[test]
fn a_deck_says_what_it_weighs() {
    let weighed = |cards: &str| {
        let read = collect(cards).unwrap_or_else(|error| panic!("{error}"));
        read.notes.into_iter().filter(|note| note.contains("weigh")).collect::<Vec<_>>()
    };
    let part = "*PART\nplate\n         7         3         5\n*MAT_ELASTIC_TITLE\n\n         5    \
                7850.0     2.1E11\n";
    let section =
        "*SECTION_SHELL_TITLE\nthin\n         3         2\n     0.002     0.002     0.002\n";
    // The plate is 1 m², 2 mm thick.
    let shell = "*ELEMENT_SHELL\n1,7,1,2,3,4\n";
    let notes = weighed(&format!("{part}{section}{shell}"));
    assert_eq!(notes.len(), 1);
    let says = "the deck weighs 15.700 kg, if its units are m and kg as its densities suggest: 1 \
                elements with a density; to use it, write mass_kg = 15.700 into a side file";
    assert_eq!(notes[0], says);
    // An element's own thickness comes first; a lumped mass is added.
    let own = "*ELEMENT_SHELL_THICKNESS\n1,7,1,2,3,4\n0.004,0.004,0.004,0.004\n\
               *ELEMENT_MASS\n       9       1            100.\n";
    let notes = weighed(&format!("{part}{section}{own}"));
    assert!(notes[0].contains("weighs 131 kg") && notes[0].contains("1 lines of *ELEMENT_MASS"));
    // Solids by their volume: a cube of 1 m³, and the tetrahedron of a sixth.
    let cube = weighed(&format!("{part}*ELEMENT_SOLID\n1,7,1,2,3,4,5,6,7,8\n"));
    assert!(cube[0].contains("weighs 7850 kg"), "{cube:?}");
    let tetrahedron = weighed(&format!("{part}*ELEMENT_SOLID\n1,7,1,2,4,5,5,5,5,5\n"));
    assert!(tetrahedron[0].contains("weighs 1308 kg"), "{tetrahedron:?}");
    // What a part states holds for all of it.
    let stated = part.replacen("*PART\n", "*PART_INERTIA\n", 1);
    let stated = stated.replacen("*MAT", "0.0,0.0,0.0,42.5,0,0\n*MAT", 1);
    let notes = weighed(&format!("{stated}{section}{shell}"));
    assert!(notes[0].contains("42.5") && notes[0].contains("parts that state"), "{notes:?}");
    // Without a thickness nothing is known, and nothing is said of the whole.
    assert_eq!(weighed(&format!("{part}{shell}")), Vec::<String>::new());
    let both = weighed(&format!("{part}{shell}*ELEMENT_SOLID\n2,7,1,2,3,4,5,6,7,8\n"));
    assert_eq!(both[1], "1 elements without density or thickness not weighed");
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
