//! Bodies of others import at their real size; malformed files load or are refused in words; bent
//! bytes never panic. None of these files is part of this project.

use super::*;
use diagnostic::Diagnostic as _;
use std::path::PathBuf;

const DATA: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data");

fn data(below: &str) -> PathBuf {
    Path::new(DATA).join(below)
}

/// What is known of a real body: file, frame, kind, part to keep; triangles in the file and kept,
/// zero-area ones, parts, size.
struct Known {
    file: &'static str,
    frame: [&'static str; 3],
    kind: Option<BodyKind>,
    only: Option<&'static str>,
    triangles: [usize; 2],
    degenerate: u32,
    parts: usize,
    size: [f64; 3],
    looks: Option<&'static str>,
}

const fn known(
    file: &'static str,
    frame: [&'static str; 3],
    kind: Option<BodyKind>,
    triangles: [usize; 2],
    parts: usize,
    size: [f64; 3],
    looks: Option<&'static str>,
) -> Known {
    Known { file, frame, kind, only: None, triangles, degenerate: 0, parts, size, looks }
}

const CHRONO: [&str; 3] = ["m", "+z", "+x"];
const GLTF: [&str; 3] = ["m", "+y", "+z"];
const PRIUS: [&str; 3] = ["cm", "+z", "-y"];
const CAR: Option<&str> = Some("a car");

const KNOWN: [Known; 20] = [
    Known {
        degenerate: 182,
        ..known(
            "chrono_sedan/sedan_chassis_vis.obj",
            CHRONO,
            Some(BodyKind::Sedan),
            [39_170, 39_170],
            12,
            [4.89, 1.85, 1.47],
            CAR,
        )
    },
    known("chrono_sedan/sedan_rim.obj", CHRONO, None, [1_812; 2], 1, [0.41, 0.21, 0.41], None),
    known("chrono_sedan/sedan_tire.obj", CHRONO, None, [7_224; 2], 1, [0.68, 0.20, 0.68], None),
    known(
        "chrono_nissan_patrol_suv/suv_chassis.obj",
        CHRONO,
        Some(BodyKind::Suv),
        [23_002; 2],
        7,
        [5.33, 2.24, 1.91],
        CAR,
    ),
    known(
        "chrono_nissan_patrol_suv/suv_rim.obj",
        CHRONO,
        None,
        [120; 2],
        1,
        [0.51, 0.02, 0.51],
        None,
    ),
    known(
        "chrono_nissan_patrol_suv/suv_tire.obj",
        CHRONO,
        None,
        [3_000; 2],
        1,
        [0.88, 0.31, 0.88],
        None,
    ),
    Known {
        degenerate: 1,
        ..known(
            "chrono_man10t_truck/MAN_10t_chassis.obj",
            CHRONO,
            Some(BodyKind::Truck),
            [13_471, 13_462],
            9,
            [9.72, 2.47, 2.59],
            Some("a truck or bus"),
        )
    },
    known("chrono_man10t_truck/MAN_rim.obj", CHRONO, None, [1_319; 2], 1, [0.56, 0.30, 0.56], None),
    known(
        "chrono_man10t_truck/MAN_tire.obj",
        CHRONO,
        None,
        [3_711; 2],
        1,
        [1.26, 0.35, 1.26],
        None,
    ),
    known(
        "openmaterial_human/human_example.gltf",
        ["m", "+y", "+x"],
        Some(BodyKind::Pedestrian),
        [46_496; 2],
        15,
        [0.37, 1.09, 1.78],
        Some("a person"),
    ),
    Known {
        only: Some("body"),
        ..known(
            "makehuman_base/base.obj",
            ["dm", "+y", "+z"],
            Some(BodyKind::Pedestrian),
            [36_972, 26_756],
            1,
            [0.42, 0.99, 1.67],
            Some("a person"),
        )
    },
    known(
        "gazebo_hatchback/hatchback.obj",
        ["0.0254", "+z", "-y"],
        Some(BodyKind::Sedan),
        [788; 2],
        4,
        [4.00, 2.14, 1.57],
        CAR,
    ),
    known(
        "osrf_prius/hybrid_body.obj",
        PRIUS,
        Some(BodyKind::Sedan),
        [1_676; 2],
        3,
        [4.62, 2.01, 1.39],
        CAR,
    ),
    Known {
        degenerate: 1,
        ..known(
            "gazebo_pickup/pickup.dae",
            ["inch", "+z", "+y"],
            Some(BodyKind::Suv),
            [1_084, 1_082],
            2,
            [5.66, 2.47, 1.87],
            Some("a truck or bus"),
        )
    },
    Known {
        degenerate: 4,
        ..known(
            "gazebo_jersey_barrier/jersey_barrier.dae",
            ["inch", "+z", "+x"],
            Some(BodyKind::Wall),
            [432, 430],
            1,
            [4.07, 0.81, 1.14],
            Some("a wall or barrier"),
        )
    },
    // Its maker scales it by three.
    known(
        "gazebo_lamp_post/lamp_post.dae",
        ["0.0762", "+z", "+x"],
        Some(BodyKind::Pole),
        [270; 2],
        1,
        [0.49, 3.18, 9.27],
        None,
    ),
    known("osrf_prius/wheel.obj", PRIUS, None, [76; 2], 1, [0.61, 0.27, 0.61], None),
    known("osrf_prius/steering_wheel.obj", PRIUS, None, [196; 2], 1, [0.13, 0.36, 0.35], None),
    known(
        "kenney_trucks/vehicle-motorcycle.glb",
        GLTF,
        Some(BodyKind::Motorcycle),
        [960; 2],
        4,
        [2.44, 1.09, 1.27],
        Some("a motorcycle or bicycle"),
    ),
    Known {
        degenerate: 23,
        ..known(
            "kenney_trucks/vehicle-truck-green.glb",
            GLTF,
            None,
            [1_104, 1_094],
            6,
            [2.90, 1.50, 1.40],
            CAR,
        )
    },
];

#[test]
#[ignore = "needs ../shared/data: real bodies"]
fn real_bodies_have_their_real_size() {
    let models = data("models");
    for known in KNOWN {
        let only = known.only.iter().map(|name| (*name).to_owned()).collect();
        let options = ImportOptions { only, ..options(known.frame, known.kind) };
        let ImportedMesh { mesh, report } =
            import(&models.join(known.file), &options).expect(known.file);
        let file = known.file;
        assert_eq!([report.triangles_in_file, report.triangles], known.triangles, "{file}");
        assert_eq!(
            (report.degenerate, report.parts.len()),
            (known.degenerate, known.parts),
            "{file}"
        );
        assert_eq!(report.guess.looks_like, known.looks, "{file}");
        for (found, size) in report.guess.size_m.iter().zip(known.size) {
            assert!((found - size).abs() < 0.006, "{file}: {}", report.guess);
        }
        let left = report.triangles_selected - report.duplicates;
        assert_eq!((left, mesh.corners.len()), (report.triangles, report.triangles), "{file}");
        let of_parts: usize = report.parts.iter().map(|(_, count)| count).sum();
        assert_eq!(of_parts, report.triangles, "{file}");
        assert!(mesh.source_ids.is_sorted_by(|a, b| a < b), "{file}");
    }
}

#[test]
#[ignore = "needs ../shared/data: real bodies"]
fn every_real_body_is_known_here() {
    let models = data("models");
    let folders = std::fs::read_dir(models).expect("a folder");
    let mut found: Vec<PathBuf> =
        folders.flat_map(|entry| meshes(&entry.expect("one").path())).collect();
    found.sort();
    let ends = |path: &Path| KNOWN.iter().any(|known| path.ends_with(known.file));
    assert!(found.iter().all(|path| ends(path)) && found.len() == KNOWN.len(), "{found:?}");
}

/// Bodies for pictures are seldom closed: shells, and open edges, of each of [`KNOWN`].
const SURFACES: [[usize; 2]; 20] = [
    [18, 870],
    [1, 532],
    [1, 84],
    [63, 1_090],
    [1, 0],
    [1, 0],
    [68, 3_105],
    [2, 215],
    [1, 415],
    [12, 326],
    [1, 0],
    [7, 8],
    [14, 156],
    [7, 24],
    [1, 6],
    [3, 10],
    [1, 0],
    [4, 20],
    [15, 16],
    [33, 200],
];

#[test]
#[ignore = "needs ../shared/data: real bodies"]
fn few_real_bodies_are_watertight() {
    let models = data("models");
    for (known, surface) in KNOWN.iter().zip(SURFACES) {
        let only = known.only.iter().map(|name| (*name).to_owned()).collect();
        let options = ImportOptions { only, ..options(known.frame, known.kind) };
        let report = import(&models.join(known.file), &options).expect(known.file).report;
        assert_eq!([report.shells, report.open_edges], surface, "{}", known.file);
    }
}

/// Files of a folder whose extension is that of a format.
fn meshes(folder: &Path) -> Vec<PathBuf> {
    let is_mesh = |path: &PathBuf| {
        path.extension()
            .is_some_and(|end| Format::ALL.iter().any(|format| end == format.extension()))
    };
    let entries = std::fs::read_dir(folder).expect("a folder");
    entries.map(|entry| entry.expect("an entry").path()).filter(is_mesh).collect()
}

#[test]
#[ignore = "needs ../shared/data: real bodies"]
fn parts_of_real_bodies_can_be_chosen_by_their_names() {
    let models = data("models");
    let count = |file: &str, name: &str| {
        let options = ImportOptions { only: vec![name.to_owned()], ..ImportOptions::default() };
        import(&models.join(file), &options).map(|it| it.report.triangles)
    };
    let truck = "chrono_man10t_truck/MAN_10t_chassis.obj";
    assert_eq!(count(truck, "SOLID7"), Ok(6_242));
    assert!(count(truck, "Material_Seat.007").is_ok_and(|seats| seats > 0));
    assert_eq!(count("gazebo_hatchback/hatchback.obj", "Wheels_Rear"), Ok(152));
    assert_eq!(count("osrf_prius/hybrid_body.obj", "Hybrid_Windows"), Ok(70));
    let fault = count(truck, "Sofa").expect_err("there is none");
    let words = fault.to_string();
    assert!(words.starts_with("MAN_10t_chassis.obj: no part is named \"Sofa\"; the names are "));
    assert!(
        words.contains("\"Material_Cabin.005\"") && !fault.remedy().unwrap_or_default().is_empty(),
        "{words}"
    );
}

#[test]
#[ignore = "needs ../shared/data: malformed files"]
fn malformed_files_load_or_are_refused_in_words() {
    let folder = data("robustness");
    let expected = [
        (
            "AllIndicesOutOfRange.gltf",
            "mesh 0, primitive 0: index 65535 is out of range: the \
                                       primitive has 24 vertices, from 0",
        ),
        ("BoxWithInfinites.glb", "mesh 0, primitive 0, vertex 0: coordinate -inf is not finite"),
        ("RecursiveNodes.gltf", "node 0: the node has two parents or is its own ancestor"),
        ("Spider_ascii.stl", "1332 triangles"),
        ("Spider_binary.stl", "1332 triangles"),
        ("Wuson.ply", "3732 triangles, header line 3 left out"),
        ("box_UTF16BE.obj", "named OBJ, but its content looks like UTF-16 text"),
        ("box_longline.obj", "14 triangles"),
        ("concave_polygon.obj", "64 triangles"),
        ("cube_binary.ply", "12 triangles"),
        ("empty.obj", "no triangle: the file is empty"),
        ("malformed.obj", "line 28: index 0 is out of range: OBJ counts vertices from 1"),
        ("number_formats.obj", "line 11: \"3.1+e2\" is not a number"),
        ("point_cloud.obj", "no triangle: a point cloud of 3 vertices without faces"),
        ("testline.obj", "no triangle: 6 lines without faces"),
        ("triangle_with_empty_solid.stl", "1 triangles, solid \"emptySolid\" is empty"),
    ];
    let mut files = meshes(&folder);
    files.sort();
    assert_eq!(files.len(), expected.len());
    for (path, (name, outcome)) in files.iter().zip(expected) {
        let found = match import(path, &ImportOptions::default()) {
            Ok(it) => {
                let notes: String =
                    it.report.notes.iter().map(|note| format!(", {note}")).collect();
                format!("{name}: {} triangles{notes}", it.report.triangles)
            }
            Err(fault) => {
                assert!(!fault.remedy().unwrap_or_default().is_empty());
                fault.to_string()
            }
        };
        println!("{found}");
        assert_eq!(found, format!("{name}: {outcome}"));
    }
}

/// The two spiders are one body: text and binary agree to the text's six digits.
#[test]
#[ignore = "needs ../shared/data: malformed files"]
fn the_same_body_in_two_encodings_is_the_same_body() {
    let folder = data("robustness");
    let load = |name: &str| import(&folder.join(name), &ImportOptions::default()).expect(name).mesh;
    let (a, b) = (load("Spider_ascii.stl"), load("Spider_binary.stl"));
    assert_eq!(a.corners.len(), b.corners.len());
    let pairs =
        a.corners.as_flattened().iter().flatten().zip(b.corners.as_flattened().iter().flatten());
    for (x, y) in pairs {
        assert!((x - y).abs() <= 2e-6 * x.abs().max(1.0), "{x} {y}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    /// A panic here would be a crash of the importing child.
    #[test]
    #[ignore = "needs ../shared/data: malformed files"]
    fn bent_real_files_never_panic(which in 0_usize..4, bends in bends(), cut in cuts()) {
        let name = ["malformed.obj", "triangle_with_empty_solid.stl", "cube_binary.ply",
            "AllIndicesOutOfRange.gltf"][which];
        load_bent(&data("robustness").join(name), bends, cut)?;
    }
}
