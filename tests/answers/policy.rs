//! `trolley policy check`: the shipped files are sound; each kind of fault is reported with place
//! and remedy.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use crate::support::{Place, text, trolley};
use std::path::{Path, PathBuf};

fn config(folder: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config").join(folder)
}

fn check(path: &Path) -> (Option<i32>, String, String) {
    let args = ["policy", "check", path.to_str().unwrap()];
    let output = trolley().args(args).output().unwrap();
    (output.status.code(), text(&output.stdout), text(&output.stderr))
}

#[test]
fn every_shipped_file_is_sound() {
    let mut checked = 0;
    for folder in ["policies", "curves"] {
        for entry in std::fs::read_dir(config(folder)).unwrap() {
            let path = entry.unwrap().path();
            let (code, out, error) = check(&path);
            assert_eq!(code, Some(0), "{}: {error}", path.display());
            assert!(out.contains("is sound"), "{out}");
            checked += 1;
        }
    }
    assert!(checked >= 8, "{checked} files are too few");
}

/// A change to a shipped file, and what the error must say.
const BAD: &[(&str, (&str, &str), &str)] = &[
    ("curves/default.toml", ("unit = \"m/s\"\n", ""), "unit"),
    ("curves/default.toml", ("source = \"Rosen et al., ESV 09-0132\"", "source = \"\""), "empty"),
    ("curves/default.toml", ("a = -4.457", "a = nan"), "not a number"),
    ("curves/default.toml", ("b = 0.177", "b = -0.177"), "slope"),
    ("curves/levels.toml", ("a = -8.9819", "a = -1.0"), "likelier"),
    ("curves/default.toml", ("sample = \"pedestrians\"", "sample = \"p\"\nage = 4"), "age"),
    ("policies/weighted.toml", ("weight = 0.5", "weight = -0.5"), "weight"),
    ("policies/weighted.toml", ("weight = 0.5", "weight = 0.0"), "sum to"),
    ("policies/default.toml", ("\"bayes\"", "\"utility\""), "utility"),
    ("policies/default.toml", ("outcome = \"mais3+\"", "outcome = \"fatal\""), "no curve"),
    ("policies/default.toml", ("[[level]]", "[[level]]\nsex = 1"), "never weighed by sex"),
    ("policies/default.toml", ("[[level]]", "[[level]]\ncondition = 1"), "never weighed by"),
];

#[test]
fn each_fault_is_named_with_its_place_and_remedy() {
    let place = Place::new();
    for (file, (from, to), says) in BAD {
        let good = std::fs::read_to_string(config(file)).unwrap();
        assert!(good.contains(from), "{file}: {from}");
        let path = place.write("board.toml", &good.replacen(from, to, 1));
        let (code, out, error) = check(&path);
        assert_eq!(code, Some(65), "{to}: {out}{error}");
        assert!(error.contains("board.toml:") && error.contains(says), "{to}: {error}");
        assert!(!out.contains("is sound"), "{to}: {out}");
    }
}

#[test]
fn all_weights_zero_and_a_missing_file_are_refused() {
    let place = Place::new();
    let good = std::fs::read_to_string(config("policies/weighted.toml")).unwrap();
    let zero = ["0.5", "0.2", "0.3"]
        .iter()
        .fold(good, |text, w| text.replace(&format!("weight = {w}"), "weight = 0.0"));
    let (code, _, error) = check(&place.write("zero.toml", &zero));
    assert!(code == Some(65) && error.contains("sum to 0"), "{error}");
    let (code, _, error) = check(&place.path().join("none.toml"));
    assert!(code == Some(65) && error.contains("none.toml"), "{error}");
}
