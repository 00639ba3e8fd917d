//! What is written is read back as the same triangles in the same order, bit for bit.

use super::*;
use crate::import::{self, Format, ImportOptions};
use body::testing::{body_of, mesh_of};
use body::{Body, Mesh};
use proptest::prelude::*;

fn bits(corners: &[Corners]) -> Vec<[[u32; 3]; 3]> {
    corners.iter().map(|corners| corners.map(|corner| corner.map(f32::to_bits))).collect()
}

/// A body whose leaves stand in another order than its source, without duplicates.
fn shuffled(corners: Vec<Corners>, turn: usize) -> (Body, Mesh) {
    let mut mesh = mesh_of(corners);
    mesh.parts = vec!["left door".into(), "roof".into()];
    mesh.part_of = (0..mesh.corners.len()).map(|at| u16::from(at % 3 == 0)).collect();
    let sorted = mesh.clone();
    let turn = turn % mesh.corners.len();
    mesh.corners.rotate_left(turn);
    mesh.source_ids.rotate_left(turn);
    mesh.part_of.rotate_left(turn);
    (body_of(&mesh), sorted)
}

fn back(body: &Body, format: ExportFormat, twin: Format) -> Mesh {
    let bytes = write(format, &body.meta, &body.view());
    let file = format!("a.{}", format.name());
    assert_eq!(Format::detect(&file, &bytes), Ok(twin));
    let options = ImportOptions { file, ..ImportOptions::default() };
    let mut none = |_: &str| Err("there is none".to_owned());
    import::read(twin, &bytes, &mut none, &options).expect("as written").mesh
}

const TWINS: [(ExportFormat, Format); 3] = [
    (ExportFormat::Stl, Format::Stl),
    (ExportFormat::Ply, Format::Ply),
    (ExportFormat::Obj, Format::Obj),
];

/// Any f32 that a body may hold, so tiny and negative zero too.
fn coordinate() -> impl Strategy<Value = f32> {
    prop_oneof![
        4 => -100.0_f32..100.0,
        1 => any::<u32>().prop_map(f32::from_bits).prop_filter("in range", |x| x.abs() <= 100.0),
        1 => Just(-0.0_f32),
    ]
}

fn triangle() -> impl Strategy<Value = Corners> {
    prop::array::uniform3(prop::array::uniform3(coordinate()))
}

proptest! {
    #[test]
    fn every_format_comes_back_bit_for_bit(
        corners in prop::collection::vec(triangle(), 1..30),
        turn in any::<usize>(),
    ) {
        // One large triangle keeps the size plausible.
        let mut corners = corners;
        corners.push([[0.0, 0.0, 0.0], [7.0, 0.0, 0.0], [0.0, 7.0, 7.25]]);
        let mut sorted: Vec<_> = bits(&corners);
        sorted.iter_mut().for_each(|triangle| triangle.sort_unstable());
        sorted.sort_unstable();
        sorted.dedup();
        prop_assume!(sorted.len() == corners.len());
        let (body, source) = shuffled(corners, turn);
        for (format, twin) in TWINS {
            let mesh = back(&body, format, twin);
            if mesh.dropped.is_empty() {
                prop_assert_eq!(bits(&mesh.corners), bits(&source.corners), "{}", format.name());
                prop_assert_eq!(&mesh.source_ids, &source.source_ids);
            } else {
                // Triangles that differ in the sign of a zero alone are one on import.
                prop_assert!(mesh.corners.len() + mesh.dropped.len() == source.corners.len());
            }
        }
    }
}

#[test]
fn parts_of_an_obj_come_back_as_parts() {
    let corners = body::testing::strip(10);
    let (body, source) = shuffled(corners, 4);
    let mesh = back(&body, ExportFormat::Obj, Format::Obj);
    let names = |mesh: &Mesh| -> Vec<String> {
        mesh.part_of.iter().map(|part| mesh.parts[usize::from(*part)].clone()).collect()
    };
    assert_eq!(names(&mesh), names(&source));
}

#[test]
fn a_name_cannot_break_the_file() {
    let (mut body, _) = shuffled(body::testing::strip(6), 1);
    body.meta.name = "a\nf 1 1 1\\".into();
    body.meta.parts = vec!["x\r\nv nonsense".into(), "\\".into()];
    for (format, twin) in TWINS {
        assert_eq!(back(&body, format, twin).corners.len(), 6, "{}", format.name());
    }
}

#[test]
fn positions_that_triangles_share_are_written_once() {
    let square = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    let [a, b, c, d] = square;
    let body = body_of(&mesh_of(vec![[a, b, c], [a, c, d]]));
    let text = String::from_utf8(write(ExportFormat::Obj, &body.meta, &body.view())).expect("text");
    assert_eq!(text.lines().filter(|line| line.starts_with("v ")).count(), 4);
    assert!(text.contains("f 1 2 3\nf 1 3 4\n"), "{text}");
}

#[test]
fn an_stl_has_unit_normals_or_none() {
    assert_eq!(normal(&[[0.0; 3], [2.0, 0.0, 0.0], [0.0, 3.0, 0.0]]), [0.0, 0.0, 1.0]);
    assert_eq!(normal(&[[0.0; 3], [2.0, 0.0, 0.0], [1.0, 0.0, 0.0]]), [0.0; 3]);
}

/// A body with duplicates, through every format and back.
fn goes_round(file: &str, dropped: usize) {
    let bytes = std::fs::read(file).expect("readable");
    let mut none = |_: &str| Err("there is none".to_owned());
    let it = import::read(Format::Obj, &bytes, &mut none, &ImportOptions::default());
    let mesh = it.expect("a real body").mesh;
    assert_eq!(mesh.dropped.len(), dropped);
    let body = body_of(&mesh);
    for (format, twin) in TWINS {
        let again = back(&body, format, twin);
        assert_eq!(bits(&again.corners), bits(&mesh.corners), "{}", format.name());
        assert_eq!((again.dropped.len(), again.degenerate), (0, mesh.degenerate));
    }
}

#[test]
fn a_body_of_a_file_comes_back_bit_for_bit() {
    goes_round(concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/hatchback.obj"), 2);
}

mod shared_data {
    use super::goes_round;

    #[test]
    #[ignore = "needs ../shared/data: real bodies"]
    fn a_real_body_comes_back_bit_for_bit() {
        let file = concat!(
            env!("CARGO_MANIFEST_DIR"),
            "/../../../shared/data/models/chrono_man10t_truck/MAN_10t_chassis.obj"
        );
        goes_round(file, 9);
    }
}
