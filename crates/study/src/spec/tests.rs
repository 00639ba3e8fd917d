//! Every fault of a specification is refused at its place, with a remedy.

use super::*;

const RIGHT: &str = r#"schema = "trolley.study/1"
name = "Test"
policies = ["default"]
[[scenarios]]
files = ["a.toml"]
[sweep]
speed = { from = 0.8, to = 1.2, count = 5 }
offset_m = { values = [-1, 0, 1] }
"#;

fn parsed(text: &str) -> Result<StudySpec, Failure> {
    StudySpec::parse("spec.toml", text.to_owned())
}

#[test]
fn a_range_has_its_ends_and_a_list_its_values() {
    let spec = parsed(RIGHT).unwrap();
    let [(SweepKnob::Speed, speeds), (SweepKnob::Offset, offsets)] = &spec.sweeps[..] else {
        panic!("{:?}", spec.sweeps)
    };
    assert_eq!((speeds.len(), speeds[0], speeds[4]), (5, 0.8, 1.2));
    assert!((speeds[2] - 1.0).abs() < 1e-12);
    assert_eq!(*offsets, [-1.0, 0.0, 1.0]);
    assert_eq!((spec.members, spec.scenes_per_shard), ([1, 1], 500));
}

#[test]
fn every_fault_has_a_place_and_a_remedy() {
    for (right, wrong, place, what) in [
        ("trolley.study/1", "trolley.study/9", "1:10", "schema is"),
        ("\"Test\"", "\" Test\"", "2:8", "name has"),
        ("[\"default\"]", "[]", "3:12", "policies is empty"),
        ("[\"default\"]", "[\"default\", \"default\"]", "3:24", "twice"),
        ("name = \"Test\"", "name = \"Test\"\nnme = 3", "3:1", "unknown field"),
        ("name = \"Test\"", "name = \"Test\"\nname = \"Test\"", "3:1", "name"),
        ("name = \"Test\"", "name = \"Test\"\nmembers = 0", "3:11", "members"),
        ("name = \"Test\"", "name = \"Test\"\nworlds = -1", "3:10", "worlds"),
        ("name = \"Test\"", "name = \"Test\"\nscene_limit_s = 0", "3:17", "scene_limit_s"),
        ("name = \"Test\"", "name = \"Test\"\nscenes_per_shard = 0", "3:20", "scenes_per_shard"),
        ("name = \"Test\"", "name = \"Test\"\npersons = \"some\"", "3:11", "some"),
        ("[\"a.toml\"]", "[]", "5:9", "files is empty"),
        ("count = 5", "count = 0", "7:9", "speed has 0 values"),
        ("count = 5", "counts = 5", "7:33", "unknown field"),
        (", count = 5", "", "7:9", "speed is no range"),
        ("from = 0.8", "from = -0.8", "7:9", "speed has the value -0.8"),
        ("from = 0.8", "from = nan", "7:9", "speed has the value NaN"),
        ("[-1, 0, 1]", "[-1, 0, -1]", "8:12", "twice"),
        ("[-1, 0, 1]", "[]", "8:12", "0 values"),
        ("offset_m", "offset", "8:1", "unknown field"),
        ("speed =", "speed", "7:7", ""),
    ] {
        let text = RIGHT.replacen(right, wrong, 1);
        let Err(failure) = parsed(&text) else { panic!("{wrong} was accepted") };
        let said = failure.what();
        assert!(said.starts_with(&format!("spec.toml:{place}: ")), "{wrong}: {said}");
        assert!(said.contains(what), "{wrong}: {said}");
        assert!(failure.remedy().is_some_and(|remedy| !remedy.is_empty()), "{wrong}");
    }
    let nothing = RIGHT.replace("[[scenarios]]\nfiles = [\"a.toml\"]\n", "");
    assert!(parsed(&nothing).is_err_and(|failure| failure.what().contains("nothing to study")));
}
