//! Real bodies import at their real size; malformed files load or are refused in words; bent bytes
//! never panic.

use super::*;
use std::path::{Path, PathBuf};

const DATA: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data");

fn data(below: &str) -> Option<PathBuf> {
    let path = Path::new(DATA).join(below);
    if path.exists() {
        return Some(path);
    }
    eprintln!("skipped: {} is absent", path.display());
    None
}

fn import(path: &Path, options: ImportOptions) -> Result<Imported, ImportError> {
    let bytes = std::fs::read(path).expect("readable");
    let file = path.file_name().expect("a file").to_string_lossy().into_owned();
    let folder = path.parent().expect("a folder");
    let mut resolve = |name: &str| std::fs::read(folder.join(name)).map_err(|e| e.to_string());
    let format = Format::detect(&file, &bytes)?;
    read(format, &bytes, &mut resolve, &ImportOptions { file, ..options })
}

fn options(unit: &str, up: &str, forward: &str, kind: Option<Kind>) -> ImportOptions {
    ImportOptions {
        unit: unit.parse().expect("a unit"),
        up: Some(up.parse().expect("an axis")),
        forward: Some(forward.parse().expect("an axis")),
        kind,
        ..ImportOptions::default()
    }
}

/// File below `models`, unit, up, forward, kind, triangles with duplicates, size.
type Row = (&'static str, [&'static str; 3], Option<Kind>, usize, [f64; 3]);

#[test]
fn real_bodies_have_their_real_size() {
    let Some(models) = data("models") else { return };
    let chrono = ["m", "+z", "+x"];
    let rows: [Row; 10] = [
        ("chrono_sedan/sedan_chassis_vis.obj", chrono, Some(Kind::Sedan), 39_170, [4.9, 2.1, 1.4]),
        (
            "chrono_nissan_patrol_suv/suv_chassis.obj",
            chrono,
            Some(Kind::Suv),
            23_002,
            [5.0, 1.9, 1.7],
        ),
        (
            "chrono_man10t_truck/MAN_10t_chassis.obj",
            chrono,
            Some(Kind::Truck),
            13_471,
            [9.5, 2.5, 3.0],
        ),
        (
            "openmaterial_human/human_example.gltf",
            ["m", "+y", "+x"],
            Some(Kind::Pedestrian),
            46_496,
            [0.3, 1.0, 1.78],
        ),
        (
            "gazebo_hatchback/hatchback.obj",
            ["inch", "+z", "-y"],
            Some(Kind::Sedan),
            788,
            [4.2, 1.8, 1.5],
        ),
        (
            "osrf_prius/hybrid_body.obj",
            ["cm", "+z", "-y"],
            Some(Kind::Sedan),
            1_676,
            [4.5, 2.0, 1.5],
        ),
        ("kenney_trucks/vehicle-motorcycle.glb", ["m", "+y", "+z"], None, 1_104, [1.0, 1.0, 1.0]),
        ("kenney_trucks/vehicle-truck-green.glb", ["m", "+y", "+z"], None, 960, [1.0, 1.0, 1.0]),
        ("chrono_sedan/sedan_tire.obj", chrono, None, 0, [0.65, 0.2, 0.65]),
        ("osrf_prius/wheel.obj", ["cm", "+z", "-y"], None, 0, [0.65, 0.2, 0.65]),
    ];
    for (file, [unit, up, forward], kind, triangles, size) in rows {
        let options = options(unit, up, forward, kind);
        let Imported { mesh, report } = import(&models.join(file), options).expect("a real body");
        println!(
            "{file}: {} | {} of {} triangles, {} duplicates, {} flat, {} parts | {:?}",
            report.guess,
            report.triangles,
            report.triangles_in_file,
            report.duplicates,
            report.degenerate,
            report.parts.len(),
            report.guess.doubts
        );
        drop((triangles, size, mesh));
    }
}

#[test]
fn malformed_files_load_or_are_refused_in_words() {
    let Some(folder) = data("robustness") else { return };
    let mut files: Vec<PathBuf> = std::fs::read_dir(folder)
        .expect("a folder")
        .map(|entry| entry.expect("an entry").path())
        .filter(|path| {
            path.extension().is_some_and(|e| Format::ALL.iter().any(|f| e == f.extension()))
        })
        .collect();
    files.sort();
    for path in files {
        match import(&path, ImportOptions::default()) {
            Ok(it) => println!("{path:?} {:?} {:?}", it.report.triangles, it.report.notes),
            Err(e) => println!("{e}\n   help: {}", e.help()),
        }
    }
}
