//! Public bodies import at their size; what is implausible is refused in words; bent bytes of
//! files never panic.

mod shared_data;

use super::*;
use diagnostic::Diagnostic as _;
use proptest::prelude::*;
use std::path::Path;

/// Meshes that are part of this project.
const SHIPPED: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data");

fn import(path: &Path, options: &ImportOptions) -> Result<ImportedMesh, ImportError> {
    let bytes = std::fs::read(path).expect("readable");
    let file = path.file_name().expect("a file").to_string_lossy().into_owned();
    let folder = path.parent().expect("a folder");
    let mut resolve = |name: &str| std::fs::read(folder.join(name)).map_err(|e| e.to_string());
    let format = Format::detect(&file, &bytes)?;
    read(format, &bytes, &mut resolve, &ImportOptions { file, ..options.clone() })
}

fn options([unit, up, forward]: [&str; 3], kind: Option<BodyKind>) -> ImportOptions {
    ImportOptions {
        unit: Some(unit.parse().expect("a unit")),
        up: Some(up.parse().expect("an axis")),
        forward: Some(forward.parse().expect("an axis")),
        kind,
        ..ImportOptions::default()
    }
}

#[test]
fn shipped_bodies_have_their_size() {
    let no_frame = ImportOptions { kind: Some(BodyKind::Wall), ..ImportOptions::default() };
    let in_inches = options(["inch", "+z", "-y"], Some(BodyKind::Sedan));
    for (file, options, [in_file, kept], degenerate, parts, size, looks) in [
        ("hatchback.obj", in_inches, [788, 788], 0, 4, [4.0, 2.14, 1.57], "a car"),
        // COLLADA states unit and up axis.
        ("jersey_barrier.dae", no_frame, [432, 430], 4, 1, [4.07, 0.81, 1.14], "a wall or barrier"),
    ] {
        let it = import(&Path::new(SHIPPED).join(file), &options).expect(file);
        let report = &it.report;
        assert_eq!([report.triangles_in_file, report.triangles], [in_file, kept], "{file}");
        assert_eq!((report.degenerate, report.parts.len()), (degenerate, parts), "{file}");
        assert_eq!(report.guess.looks_like, Some(looks), "{file}");
        for (found, size) in report.guess.size_m.iter().zip(size) {
            assert!((found - size).abs() < 0.006, "{file}: {}", report.guess);
        }
        let left = report.triangles_selected - report.duplicates;
        assert_eq!((left, it.mesh.corners.len()), (kept, kept), "{file}");
    }
}

#[test]
fn a_car_of_4500_metres_is_refused_with_its_size_and_unit() {
    let text = "v 0 0 0\nv 4500 0 0\nv 0 1800 0\nv 0 0 1400\nf 1 2 3\nf 1 2 4\n";
    let file = "a/b/car.obj".to_owned();
    let options = ImportOptions { file, kind: Some(BodyKind::Sedan), ..ImportOptions::default() };
    let mut none = |_: &str| Err(String::new());
    let fault = read(Format::Obj, text.as_bytes(), &mut none, &options).expect_err("long");
    assert_eq!(
        fault.to_string(),
        "a/b/car.obj: 4500.00 × 1800.00 × 1400.00 m is not a plausible sedan: its greatest length \
         should be 1 to 30 m"
    );
    assert_eq!(fault.remedy().as_deref(), Some("is its unit mm? then import it with --unit mm"));
    let options = ImportOptions { unit: Some("mm".parse().expect("a unit")), ..options };
    let it = read(Format::Obj, text.as_bytes(), &mut none, &options).expect("plausible");
    assert_eq!(it.report.name, "car");
    assert_eq!(it.report.origin, "car.obj, unit mm, up +z, forward +x");
    assert_eq!(it.mesh.corners[0][1], [4.5, 0.0, 0.0]);
}

#[test]
fn parallel_axes_and_oversized_files_are_refused() {
    let options = ImportOptions { up: "+x".parse().ok(), ..ImportOptions::default() };
    let mut none = |_: &str| Err(String::new());
    let fault = read(Format::Stl, b"", &mut none, &options).expect_err("parallel");
    assert!(
        fault
            .to_string()
            .ends_with("up +x and forward +x are parallel: state both --up and --forward")
    );
}

type Bends = Vec<(prop::sample::Index, u8)>;

/// Bytes that are replaced, and by what.
fn bends() -> impl Strategy<Value = Bends> {
    prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6)
}

/// Where a file is cut off, if it is.
fn cuts() -> impl Strategy<Value = Option<prop::sample::Index>> {
    any::<Option<prop::sample::Index>>()
}

/// A file with bytes replaced loads, or is refused in words.
fn load_bent(
    path: &Path,
    bends: Bends,
    cut: Option<prop::sample::Index>,
) -> Result<(), TestCaseError> {
    let mut bytes = std::fs::read(path).expect("readable");
    for (at, byte) in bends {
        let at = at.index(bytes.len());
        bytes[at] = byte;
    }
    if let Some(cut) = cut {
        bytes.truncate(cut.index(bytes.len()));
    }
    let ends = |format: &Format| path.extension().is_some_and(|end| end == format.extension());
    let format = Format::ALL.into_iter().find(ends).expect("a format");
    let mut side = |_: &str| Ok(vec![0; 648]);
    match read(format, &bytes, &mut side, &ImportOptions::default()) {
        Ok(it) => {
            let mut points = it.mesh.corners.as_flattened().iter().flatten();
            prop_assert!(!it.mesh.corners.is_empty() && points.all(|x| x.is_finite()));
        }
        Err(fault) => prop_assert!(
            fault.to_string().len() > 10 && fault.remedy().is_some_and(|help| help.len() > 10)
        ),
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(100))]

    /// A panic here would be a crash of the importing child.
    #[test]
    fn bent_files_never_panic(obj in any::<bool>(), bends in bends(), cut in cuts()) {
        let name = if obj { "hatchback.obj" } else { "jersey_barrier.dae" };
        load_bent(&Path::new(SHIPPED).join(name), bends, cut)?;
    }
}
