//! `trolley policy`: the shipped files are sound; each kind of fault is reported with place and
//! remedy; what a policy binds itself to holds; and a map shows who wins.
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
    ("curves/default.toml", ("unit = \"mph\"\n", ""), "unit"),
    ("curves/default.toml", ("source = \"Rosen et al., ESV 09-0132\"", "source = \"\""), "empty"),
    ("curves/default.toml", ("a = -6.9774", "a = nan"), "not a number"),
    ("curves/default.toml", ("b = 0.1620", "b = -0.1620"), "slope"),
    ("curves/levels.toml", ("a = -8.9819", "a = -1.0"), "likelier"),
    ("curves/default.toml", ("sample = \"motorcyclists\"", "sample = \"m\"\nage = 4"), "age"),
    ("policies/weighted.toml", ("weight = 0.5", "weight = -0.5"), "weight"),
    ("policies/weighted.toml", ("weight = 0.5", "weight = 0.0"), "sum to"),
    ("policies/default.toml", ("\"bayes\"", "\"utility\""), "utility"),
    ("policies/default.toml", ("outcome = \"mais3+\"", "outcome = \"fatal\""), "no curve"),
    ("policies/default.toml", ("[[level]]", "[[level]]\nsex = 1"), "never weighed by sex"),
    ("policies/default.toml", ("[[level]]", "[[level]]\ncondition = 1"), "never weighed by"),
];

// verifies REQ-INPUT
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

/// A folder with the example that is signed in `policies`, and the scenarios beside it.
struct Signed {
    place: Place,
    text: String,
}

impl Signed {
    fn new() -> Self {
        let place = Place::new();
        std::fs::create_dir(place.path().join("scenarios")).unwrap();
        std::fs::create_dir(place.path().join("policies")).unwrap();
        for name in ["crossing", "small", "wall-or-pole", "minimal"] {
            let file = format!("scenarios/{name}.toml");
            place.write(&file, &std::fs::read_to_string(config(&file)).unwrap());
        }
        let text = config("policies/acceptable-or-brake.toml");
        Self { place, text: std::fs::read_to_string(text).unwrap() }
    }

    /// Checks it with one thing changed, on a day.
    fn check(&self, from: &str, to: &str, today: &str) -> (Option<i32>, String, String) {
        assert!(self.text.contains(from), "{from}");
        let path = self.place.write("policies/board.toml", &self.text.replacen(from, to, 1));
        let args = ["policy", "check", path.to_str().unwrap(), "--today", today];
        let output = trolley().args(args).output().unwrap();
        (output.status.code(), text(&output.stdout), text(&output.stderr))
    }
}

#[test]
fn a_signed_policy_is_sound_until_its_last_day() {
    let signed = Signed::new();
    let (code, out, error) = signed.check("", "", "2099-12-31");
    assert_eq!((code, error.as_str()), (Some(0), ""), "{out}");
    for said in ["signed by A. Example", "valid until 2099-12-31", "dissent of C. Example"] {
        assert!(out.contains(said), "{out}");
    }
    assert!(out.contains("\"rear-end\" wins and \"pedestrian\" comes last, as stated"), "{out}");
    assert!(out.contains("minimal.toml: nobody wins, as stated"), "{out}");
    let (code, out, error) = signed.check("", "", "2100-01-01");
    assert_eq!((code, out.as_str()), (Some(65), ""));
    let line = signed.text.lines().position(|line| line.starts_with("valid_until")).unwrap() + 1;
    assert!(
        error.contains(&format!("board.toml:{line}: it was valid until 2099-12-31")),
        "{error}"
    );
    assert!(error.contains("help: "), "{error}");
}

#[test]
fn an_outcome_that_changed_is_refused_with_what_was_found() {
    let signed = Signed::new();
    let today = "2027-01-01";
    for (from, to, expected, found) in [
        ("winner = \"rear-end\"", "winner = \"wall\"", "\"wall\" to win", "\"rear-end\""),
        ("worst = \"pedestrian\"", "worst = \"wall\"", "\"wall\" to come last", "\"pedes"),
        (
            "winner = \"rear-end\"\nworst = \"pedestrian\"",
            "refused = true",
            "nobody to win",
            "\"rear-end\"",
        ),
        (
            "refused = true",
            "winner = \"to the left, the pole\"",
            "\"to the left, the pole\" to win",
            "nobody",
        ),
        // The policy itself is another one now.
        ("accept = 0.1", "accept = 0.0", "\"rear-end\" to win", "nobody"),
    ] {
        let (code, out, error) = signed.check(from, to, today);
        assert_eq!(code, Some(65), "{to}: {out}{error}");
        assert!(out.contains("\"acceptable-or-brake\" is refused"), "{out}");
        let says = error.contains(&format!("expected {expected}, got {found}"));
        assert!(says && error.contains("the outcome of ../scenarios/"), "{to}: {error}");
        assert!(error.contains("board.toml:") && error.contains("help: "), "{error}");
    }
}

#[test]
fn what_is_wrong_in_a_dossier_is_named_with_its_place_and_remedy() {
    let signed = Signed::new();
    for (from, to, says) in [
        ("2099-12-31", "2099-13-01", "\"2099-13-01\" is no day"),
        ("valid_until", "valid_until_further_notice", "valid_until_further_notice"),
        ("role = \"accident research\", ", "", "role"),
        ("dissent = [", "[[dossier.dissenting]]\nno = [", "dissenting"),
        ("../scenarios/small.toml", "../scenarios/none.toml", "none.toml"),
        ("../scenarios/small.toml", "board.toml", "board.toml"),
        ("../scenarios/small.toml", "../../etc/small.toml", "leads out of the folder"),
        ("winner = \"brake\"", "winner = \"stop\"", "no candidate \"stop\""),
        ("reason = \"going on", "because = \"going on", "because"),
    ] {
        let (code, out, error) = signed.check(from, to, "2027-01-01");
        assert_eq!(code, Some(65), "{to}: {out}{error}");
        assert!(error.contains("board.toml:") && error.contains(says), "{to}: {error}");
        assert!(error.contains("help: ") && !out.contains("is sound"), "{to}: {out}{error}");
    }
    let (code, _, error) = signed.check("", "", "tomorrow");
    assert!(code == Some(2) && error.contains("YYYY-MM-DD"), "{error}");
}

#[test]
fn who_signed_nothing_is_said_to_be_unsigned() {
    let (code, out, _) = check(&config("policies/default.toml"));
    assert!(code == Some(0) && out.contains("unsigned"), "{out}");
    let signed = Signed::new();
    let begin = signed.text.find("signed = [").unwrap();
    let end = begin + signed.text[begin..].find("]\n").unwrap();
    let (code, out, error) = signed.check(&signed.text[begin..=end], "signed = []", "2027-01-01");
    assert_eq!(code, Some(0), "{error}");
    assert!(out.contains("unsigned") && out.contains("valid until"), "{out}");
}

/// Ranks a scenario of `config` under a policy: exit code, stdout, stderr.
fn rank(policy: &str, scenario: &str, flags: &[&str]) -> (Option<i32>, String, String) {
    let place = Place::new();
    place.write("policy.toml", policy);
    let path = place.write("scenario.toml", &format!("policy = \"policy.toml\"\n{scenario}"));
    let args = ["rank", path.to_str().unwrap(), "--in-process"];
    let output = trolley().args(args).args(flags).output().unwrap();
    (output.status.code(), text(&output.stdout), text(&output.stderr))
}

fn small() -> String {
    std::fs::read_to_string(config("scenarios/small.toml")).unwrap()
}

/// Every way of the scenario harms somebody; so none is acceptable at 0.
fn at_zero(otherwise: &str) -> String {
    let text = std::fs::read_to_string(config("policies/precaution.toml")).unwrap();
    text.replacen("accept = 0.1", &format!("accept = 0.0\n{otherwise}"), 1)
}

// verifies REQ-POLICY
#[test]
fn what_no_way_keeps_is_refused_and_all_ways_are_listed() {
    let refuse = at_zero("otherwise = \"refuse\"");
    let (code, out, error) = rank(&refuse, &small(), &[]);
    assert_eq!(code, Some(4), "{out}{error}");
    assert!(out.contains("NO WINNER: none is acceptable under the policy"), "{out}");
    assert!(
        !out.contains("Least harm:") && !out.contains("First of") && out.contains("COMPLETE"),
        "{out}"
    );
    let (code, out, _) = rank(&refuse, &small(), &["--json"]);
    assert_eq!(code, Some(4), "{out}");
    let answer = &serde_json::from_str::<serde_json::Value>(&out).unwrap()["answer"];
    assert_eq!(answer["ranking"].as_array().map(Vec::len), Some(4), "{answer}");
    assert_eq!(answer["notes"][0]["refused"]["at_most"], 0.0, "{answer}");
    // In the order of the next rules.
    let next = rank(&at_zero(""), &small(), &["--json"]);
    let other = &serde_json::from_str::<serde_json::Value>(&next.1).unwrap()["answer"];
    assert_eq!((next.0, &answer["ranking"]), (Some(0), &other["ranking"]));
    let (_, out, _) = rank(&refuse, &small(), &["--explain"]);
    assert!(out.contains("What would let a candidate win"), "{out}");
}

// verifies REQ-POLICY
#[test]
fn what_no_way_keeps_falls_back_on_the_one_named_or_is_refused() {
    let on = |name: &str| at_zero(&format!("otherwise = \"fall-back\"\nfall_back = \"{name}\""));
    let (code, out, error) = rank(&on("pedestrian"), &small(), &[]);
    assert_eq!(code, Some(0), "{out}{error}");
    assert!(
        out.contains("First of 4 tied: pedestrian.") && out.contains("\n1 pedestrian"),
        "{out}"
    );
    assert!(out.contains("Note: no candidate keeps") && out.contains("falls back on"), "{out}");
    let (code, out, _) = rank(&on("brake"), &small(), &[]);
    assert_eq!(code, Some(4), "{out}");
    assert!(out.contains("\"brake\" is not among them"), "{out}");
}

/// The page of an answer without a winner names none.
#[test]
fn a_page_of_a_refusal_names_no_winner() {
    let place = Place::new();
    let page = place.path().join("page.html");
    let refuse = at_zero("otherwise = \"refuse\"");
    let (code, ..) = rank(&refuse, &small(), &["--report", page.to_str().unwrap()]);
    let page = std::fs::read_to_string(&page).unwrap();
    assert_eq!(code, Some(4));
    assert!(page.contains("No way is acceptable under the policy") && !page.contains("Least harm"));
}

#[test]
fn among_equals_the_preferred_one_wins_wherever_it_stands() {
    let policy = "schema = 1\nname = \"lane\"\nboard = \"test\"\noutcome = \"mais3+\"\n\
        composition = \"lexicographic\"\nproperty = \"last\"\npreferred = [\"brake in lane\"]\n\
        tie_break = [\"brake-in-lane\", \"request\"]\n[[level]]\nrule = \"uninvolved\"\n";
    let head = "schema = \"trolley.scenario/2\"\nname = \"Nothing near\"\nmembers = 1\n\
        [parties.ego]\ngenerate = { shape = \"sedan\", triangles = 600 }\n\
        [parties.pole]\ngenerate = { shape = \"pole\", triangles = 600 }\n\
        place = { position_m = [400, 0, 0] }\n";
    let candidate = |name: &str, speed: f64| {
        let state = format!("state = {{ position_m = [0, 0, 0], speed_m_s = {speed:?} }}");
        format!("[[candidates]]\nname = \"{name}\"\n{state}\n")
    };
    let three = [candidate("go on", 9.0), candidate("brake in lane", 5.0), candidate("slow", 7.0)];
    for turn in 0..3 {
        let ways: Vec<&str> = (0..3).map(|k| three[(k + turn) % 3].as_str()).collect();
        let (code, out, error) = rank(policy, &format!("{head}{}", ways.concat()), &[]);
        assert_eq!(code, Some(0), "{error}");
        assert!(out.contains("\n1 brake in lane"), "{out}");
        assert!(out.contains("the tie-break prefers it by name"), "{out}");
    }
}

#[test]
fn an_expired_policy_still_ranks_with_a_warning() {
    let signed = Signed::new();
    let dossier = signed.text[signed.text.find("[dossier]").unwrap()..].replace("2099", "2026");
    let policy = std::fs::read_to_string(config("policies/default.toml")).unwrap();
    let policy = format!("{policy}\n{dossier}").replace("2026-12-31", "2026-01-15");
    let (code, out, error) = rank(&policy, &small(), &[]);
    assert_eq!(code, Some(0), "{error}");
    assert!(error.contains("warning: policy \"default\" was valid until 2026-01-15"), "{error}");
    let (_, quiet, error) = rank(&policy, &small(), &["--quiet"]);
    assert_eq!(error, "");
    let first = |out: &str| out.lines().nth(4).map(str::to_owned);
    assert_eq!(first(&quiet), first(&out));
}

#[test]
fn a_map_says_who_wins_under_which_policy_and_draws_where_it_flips() {
    let place = Place::new();
    let picture = place.path().join("map.svg");
    let scenario = config("scenarios/small.toml");
    let policies = [config("policies/acceptable-or-brake.toml"), config("policies/default.toml")];
    let map = |flags: &[&str]| {
        let mut command = trolley();
        command.args(["policy", "map", scenario.to_str().unwrap(), "--policies"]);
        let output = command.args(&policies).args(flags).output().unwrap();
        (output.status.code(), text(&output.stdout), text(&output.stderr))
    };
    let out = picture.to_str().unwrap();
    let (code, said, error) = map(&["-o", out, "--cells", "5", "--y", "odds-inside=1..1000"]);
    assert_eq!(code, Some(0), "{said}{error}");
    for policy in ["acceptable-or-brake", "default"] {
        let row = said.lines().find(|line| line.starts_with(policy)).unwrap();
        assert!(row.contains("rear-end") && row.contains("pedestrian"), "{said}");
    }
    let svg = std::fs::read_to_string(&picture).unwrap();
    assert!(svg.starts_with("<svg ") && svg.ends_with("</svg>"), "{svg}");
    // With a thousand times the odds no way is acceptable, and one policy lets none be chosen.
    assert!(svg.contains("nobody: no way is acceptable") && svg.contains(">wall<"), "{svg}");
    let (code, said, error) = map(&["--json"]);
    assert_eq!(code, Some(0), "{error}");
    let document: serde_json::Value = serde_json::from_str(&said).unwrap();
    assert_eq!(document["schema"], "trolley.policy-map/1");
    assert_eq!(document["rows"][1]["winner"], "rear-end", "{said}");
    for (flags, says) in [
        (["-o", out, "--x", "weather"], "cannot be varied"),
        (["-o", out, "--x", "speed=2..1"], "no range of speed"),
        (["-o", out, "--cells", "1"], "2 to 101 cells"),
        (["-o", "map.png", "--cells", "5"], "an .svg or an .html"),
    ] {
        let (code, _, error) = map(&flags);
        assert_eq!(code, Some(78), "{error}");
        assert!(error.contains(says) && error.contains("help: "), "{error}");
    }
}
