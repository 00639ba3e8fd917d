//! `trolley validate`: the shipped orderings hold, crash tests are computed and judged, an ordering
//! that fails is told, and bad files are refused with their place.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use crate::support::{Place, json, text, trolley};
use std::path::{Path, PathBuf};
use std::process::Output;

fn validate(args: &[&str]) -> Output {
    trolley().arg("validate").args(args).output().unwrap()
}

fn config(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config").join(name)
}

/// A car that meets a wall head on, one that does not quite, and one along a barrier: the middle
/// one is what a calculation by hand gives.
const TESTS: &str = r#"[
 { "id": "whole", "group": "walls", "size_m": [4.5, 1.8], "mass_kg": 1500,
   "object": "Flat steel wall 5 cm rad", "overlap": 1.0, "speed_m_s": 15, "dv_m_s": 16.5,
   "source": "by hand" },
 { "id": "fast", "group": "walls", "size_m": [4.8, 1.9], "mass_kg": 1800,
   "object": "Flat steel wall 5 cm rad", "overlap": 1.0, "speed_m_s": 20, "dv_m_s": 22,
   "source": "by hand" },
 { "id": "along", "group": "barriers", "size_m": [4.5, 1.8], "mass_kg": 1500, "angle_deg": 25,
   "speed_m_s": 28, "dv_m_s": 15.6868, "yaw_rate_deg_s": 20, "source": "by hand" }
]"#;

#[test]
fn crash_tests_are_computed_by_the_whole_engine() {
    let place = Place::new();
    let file = place.write("tests.json", TESTS);
    let page = place.path().join("page.md");
    let (file, page) = (file.to_str().unwrap(), page.to_str().unwrap());
    let output = validate(&[file, "--json", "--page", page]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let document = json(&output);
    assert_eq!(document["schema"], "trolley.validate/1");
    let tests = document["tests"].as_array().unwrap();
    assert_eq!(tests.len(), 3);
    for test in tests {
        // (1+e) v against a wall; 1.3 v sin 25° times the square root of 1 + 0.2² along a barrier.
        let [measured, computed] =
            ["measured_m_s", "computed_m_s"].map(|key| test[key].as_f64().unwrap());
        assert!((computed / measured - 1.0).abs() < 0.03, "{test}");
    }
    let groups = document["groups"].as_array().unwrap();
    assert_eq!((&groups[0]["name"], &groups[0]["tests"]), (&"walls".into(), &2.into()));
    assert!(groups[0]["left_out"]["parameter"] == "friction" && groups[1]["left_out"].is_null());
    let written = std::fs::read_to_string(page).unwrap();
    assert!(written.contains("| along | 15.69 |") && written.contains("](page.png)"), "{written}");
    assert!(std::fs::metadata(page.replace(".md", ".png")).unwrap().len() > 5_000);
}

#[test]
fn the_shipped_orderings_hold_and_their_figures_follow_the_parameters() {
    let folder = config("orderings");
    let folder = folder.to_str().unwrap();
    let output = validate(&[folder, "--json"]);
    let document = json(&output);
    let orderings = document["orderings"].as_array().unwrap();
    assert!(orderings.len() >= 40);
    for one in orderings {
        assert!(one["holds"] == true && one["reason"].as_str().unwrap().len() > 3, "{one}");
    }
    assert!(output.status.success());
    // With another restitution, other figures.
    let place = Place::new();
    let shipped = std::fs::read_to_string(config("parameters/default.toml")).unwrap();
    let few = shipped.replacen("nominal = 0.1\nhigh = 0.3", "nominal = 0.0\nhigh = 0.3", 1);
    assert_ne!(few, shipped);
    let parameters = place.write("few.toml", &few);
    let other = validate(&[folder, "--json", "--parameters", parameters.to_str().unwrap()]);
    let other = json(&other);
    assert_ne!(other["orderings"], document["orderings"], "parameters count");
}

#[test]
fn an_ordering_that_fails_is_shown_and_told_by_the_exit_code() {
    let place = Place::new();
    let good = std::fs::read_to_string(config("orderings").join("heights.toml")).unwrap();
    let wrong = good.replacen("value = 1.0", "value = 2.0", 1);
    let file = place.write("wrong.toml", &wrong);
    let output = validate(&[file.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(1), "{}", text(&output.stderr));
    assert!(text(&output.stdout).contains("FAILS"));
}

#[test]
fn bad_files_are_refused_with_their_place() {
    let place = Place::new();
    let good = std::fs::read_to_string(config("orderings").join("heights.toml")).unwrap();
    let cases = [
        ("a.json", TESTS.replacen("\"mass_kg\": 1500", "\"mass_kg\": -1", 1), "mass_kg -1"),
        ("b.json", TESTS.replacen("Flat steel wall", "A hedge", 1), "no wall, pole or barrier"),
        ("c.json", TESTS.replacen("\"dv_m_s\": 16.5,", "", 1), "dv_m_s"),
        ("d.json", TESTS.replacen('[', "", 1), "d.json:2"),
        ("e.toml", good.replacen("of = \"over\"", "of = \"above\"", 1), "above"),
        ("f.toml", good.replacen("scene = \"lying\"", "scene = \"flying\"", 1), "flying"),
        ("g.toml", good.replacen("reason = ", "cause = ", 1), "cause"),
        ("h.toml", good.replacen("value = 1.0\n", "", 1), "two of more, less and value"),
        ("i.toml", good.replacen("generate =", "generated =", 1), "generated"),
        ("j.toml", String::new(), "schema"),
        (
            "k.toml",
            good.replacen("of = \"under\", party = \"ego\"", "of = \"under\", party = \"egg\"", 1),
            "no party \"egg\"",
        ),
    ];
    for (name, content, says) in cases {
        let file = place.write(name, &content);
        let output = validate(&[file.to_str().unwrap()]);
        let error = text(&output.stderr);
        assert_eq!(output.status.code(), Some(65), "{name}: {error}");
        assert!(error.contains(name) && error.contains(says), "{name}: {error}");
    }
    let missing = validate(&["no-such-file.json"]);
    assert!(!missing.status.success() && text(&missing.stderr).contains("no-such-file.json"));
}

mod shared_data {
    use super::validate;
    use crate::support::{json, shared};

    #[test]
    #[ignore = "needs ../shared/data: crash tests"]
    fn groups_of_crash_tests_keep_their_bias_and_their_spread() {
        let file = shared("crash-tests/tests.json");
        let output = validate(&[file.to_str().unwrap(), "--json"]);
        let document = json(&output);
        for group in document["groups"].as_array().unwrap() {
            let [bias, rms] =
                ["bias_percent", "rms_percent"].map(|key| group[key].as_f64().unwrap());
            assert!(bias.abs() <= 10.0 && rms <= 30.0, "{group}");
        }
        assert!(output.status.success());
    }
}
