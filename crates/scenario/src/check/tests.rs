//! Every value of a scenario, made wrong, is refused at its own line; and how the refusals read.

use crate::testing::{FULL, assert_reads_well, parse, settings, told, with_line, wrong_values};

#[test]
fn the_full_scenario_is_valid() {
    parse(FULL).unwrap();
}

#[test]
fn every_wrong_value_is_refused_at_its_own_line() {
    for (number, section, key, _) in settings() {
        for wrong in wrong_values(key, &[]) {
            let text = with_line(number, &format!("{key} = {wrong}"));
            let error = parse(&text).expect_err(&format!("{section} {key} = {wrong}"));
            assert_eq!(error.place.line, number, "{section} {key} = {wrong}: {error}");
            let least = if number == 1 { 1 } else { key.len() + 4 };
            assert!(error.place.column >= least, "{section} {key} = {wrong}: {error}");
            assert_reads_well(&told(error));
        }
    }
}

#[test]
fn every_misspelt_key_is_refused_where_it_stands() {
    for (number, section, key, value) in settings().into_iter().skip(1) {
        let text = with_line(number, &format!("{key}x = {value}"));
        let error = parse(&text).expect_err(key);
        assert_eq!((error.place.line, error.place.column), (number, 1), "{section} {error}");
        let traits = key == "seat";
        let remedy = if traits { "seat only".into() } else { format!("Did you mean {key:?}?") };
        assert!(error.remedy.contains(&remedy), "{section} {key}: {error}");
        assert_reads_well(&told(error));
    }
}

#[test]
fn every_repeated_key_is_refused_where_it_is_repeated() {
    for (number, _, key, value) in settings() {
        let line = format!("{key} = {value}");
        let error = parse(&with_line(number, &format!("{line}\n{line}"))).expect_err(key);
        assert_eq!((error.place.line, error.place.column), (number + 1, 1), "{error}");
    }
}

#[test]
fn a_missing_key_is_either_optional_or_named() {
    const REQUIRED: &[&str] = &[
        "schema",
        "name",
        "shape",
        "triangles",
        "position_m",
        "party",
        "speed_m_s",
        "velocity_m_s",
        "file",
        "a_n_m",
        "b_n_m2",
    ];
    for (number, section, key, _) in settings() {
        match parse(&with_line(number, "")) {
            Ok(_) => assert!(!REQUIRED.contains(&key), "{section} {key}"),
            Err(error) if REQUIRED.contains(&key) => {
                assert!(error.what.contains(key), "{section} {key}: {error}");
                assert!(error.place.line <= number, "{section} {key}: {error}");
            }
            // Without it another value no longer fits: the ego is looked for by its usual name, and
            // the number of workers by its default, which the list of cores does not fit.
            Err(error) => {
                let expected = match key {
                    "ego" => "party \"ego\" is not defined",
                    "workers" => "cores lists 2 of them for 4 workers",
                    "seat" => "a person in a sedan needs a seat",
                    _ => panic!("{section} {key}: {error}"),
                };
                assert_eq!(error.what, expected);
            }
        }
    }
}

/// The full scenario with a piece of its text replaced, which must be there.
fn changed(from: &str, to: &str) -> String {
    assert!(FULL.contains(from), "{from}");
    FULL.replacen(from, to, 1)
}

fn refusal(from: &str, to: &str) -> String {
    told(parse(&changed(from, to)).expect_err(to))
}

#[test]
fn the_main_faults_read_like_this() {
    let cases = [
        (
            ("party = \"walker\"", "party = \"wlaker\""),
            "f.toml:54:9: party \"wlaker\" is not defined\n  help: parties defined here: car, \
             post, walker.  Did you mean \"walker\"?",
        ),
        (
            ("party = \"walker\"", "party = \"car\""),
            "f.toml:54:9: party \"car\" is the ego: it cannot hit itself\n  help: name another \
             party",
        ),
        (
            ("depth = 6", "depht = 6"),
            "f.toml:12:1: key \"depht\" is not known in [engine]\n  help: keys known here: \
             workers, cores, coordinator_core, depth, scheme, alpha, batch, queue, build, \
             leaf_size, seed.  Did you mean \"depth\"?",
        ),
        (
            ("seat = \"front-left\"", "seat = \"front-left\"\nage = 7"),
            "f.toml:30:1: \"age\" of a person is not an input\n  help: persons carry a seat only: \
             who somebody is never weighs in a ranking",
        ),
        (
            ("mass_kg = 1500", "mass_kg = -1500"),
            "f.toml:22:11: mass_kg is -1500\n  help: mass_kg may be 0.1 to 1000000 kg",
        ),
        (
            ("mass_kg = 1500", "sex = \"m\""),
            "f.toml:22:1: \"sex\" of a person is not an input\n  help: persons carry a seat only: \
             who somebody is never weighs in a ranking",
        ),
        (
            ("deadline_ms = 50", "deadline_ms = -50"),
            "f.toml:5:15: deadline_ms is -50\n  help: deadline_ms may be 0.001 to 3600000 ms",
        ),
        (
            ("speed_m_s = 12", "speed_m_s = \"12 m/s\""),
            "f.toml:52:13: \"speed_m_s\": found \"12 m/s\", expected a number\n  help: `trolley \
             schema` prints every key with its type, unit and range",
        ),
        (
            ("depth = 6", "depth = \"auto\""),
            "f.toml:12:9: \"depth\": found \"auto\", expected a whole number\n  help: write a \
             number of levels, 0 to 20; the default is 4",
        ),
        (
            ("name = \"post\"", "name = \"walker\""),
            "f.toml:62:8: two candidates are called \"walker\"\n  help: the first stands at 44:1; \
             give one another name",
        ),
        (
            ("speed_m_s = 12", "speed_m_s = 12\nvelocity_m_s = [1, 2]"),
            "f.toml:47:1: the state has both speed_m_s and velocity_m_s\n  help: write speed_m_s = \
             … along the heading, or velocity_m_s = [x, y] in the world",
        ),
        (
            ("speed_m_s = 0", "speed_m_s = 2"),
            "f.toml:69:13: a pole is fixed to the ground and cannot move\n  help: write speed_m_s \
             = 0",
        ),
        (
            ("file = \"bodies/walker.trolley\"", "responsibility = 1"),
            "f.toml:33:1: party \"walker\" has neither file nor generate\n  help: write file = \
             \"….trolley\", or generate = { shape = \"sedan\", triangles = 20000 }",
        ),
        (
            ("name = \"Every key\"", "name = \"Every key"),
            "f.toml:2:18: invalid basic string, expected `\"`\n  help: a scenario is TOML: key = \
             value lines under [table] headers, text in quotes",
        ),
    ];
    for ((from, to), expected) in cases {
        assert_eq!(refusal(from, to), expected);
    }
}

#[test]
fn what_is_unknown_has_neither_mass_nor_persons_and_is_not_the_ego() {
    let unknown = "kind = \"unknown\"";
    let ego = refusal("[parties.car]\nmass_kg = 1500", &format!("[parties.car]\n{unknown}"));
    assert!(ego.contains("neither mass nor persons"), "{ego}");
    let mass = refusal(unknown, &format!("{unknown}\nmass_kg = 80"));
    assert!(mass.contains("f.toml:35:8: ") && mass.contains("neither mass nor persons"), "{mass}");
    let walker = changed("ego = \"car\"", "ego = \"walker\"");
    let error = parse(&walker).expect_err("nobody knows it").to_string();
    assert!(error.contains("f.toml:6:7: the ego is of unknown kind"), "{error}");
}

#[test]
fn zero_and_too_many_candidates_are_refused() {
    let (head, _) = FULL.split_once("[[candidates]]").unwrap();
    let none = "f.toml:1:1: no candidates: there is nothing to rank\n  help: add [[candidates]]";
    assert_eq!(told(parse(head).unwrap_err()), none);
    let empty = format!("candidates = []\n{head}");
    assert!(parse(&empty).unwrap_err().what.starts_with("no candidates"));

    let candidate = |i: usize| {
        format!(
            "[[candidates]]\nname = \"c{i}\"\nego = {{ position_m = [0, 0, 0], speed_m_s = 1 }}\n\
             other = {{ party = \"post\", position_m = [3, 0, 0], speed_m_s = 0 }}\n"
        )
    };
    let many = |n: usize| head.to_owned() + &(0..n).map(candidate).collect::<String>();
    assert_eq!(parse(&many(16)).unwrap().candidates.len(), 16);
    let error = parse(&many(17)).unwrap_err();
    assert_eq!(error.what, "17 candidates are too many");
    assert_eq!(error.place.line, head.lines().count() + 1);
}

#[test]
fn the_number_of_parties_is_bounded() {
    let party = |i: usize| format!("[parties.p{i}.generate]\nshape = \"pole\"\ntriangles = 500\n");
    let with = |n: usize| format!("{FULL}{}", (0..n).map(party).collect::<String>());
    assert_eq!(parse(&with(14)).unwrap().parties.len(), 17);
    assert_eq!(parse(&with(15)).unwrap_err().what, "18 parties are defined");
}

#[test]
fn bodies_that_cannot_play_their_part_are_refused() {
    let cases = [
        ("shape = \"sedan\"", "shape = \"pedestrian\"", "a pedestrian has no seats"),
        ("shape = \"sedan\"", "shape = \"wall\"", "a wall is fixed to the ground and has no mass"),
        (
            "seat = \"rear-right\"",
            "seat = \"front-left\"",
            "two persons have the seat \"front-left\"",
        ),
        ("seat = \"rear-right\"", "", "a person in a sedan needs a seat"),
        ("size_m = [0.3, 0.25]", "size_m = [0.3, 0.25]\npersons = [{}]", "a pole holds nobody"),
    ];
    for (from, to, fault) in cases {
        assert_eq!(parse(&changed(from, to)).unwrap_err().what, fault);
    }
    let ridden = FULL
        .replace("shape = \"sedan\"", "shape = \"cyclist\"")
        .replace("seat = \"front-left\"", "seat = \"rider\"")
        .replace("[[parties.car.persons]]\nseat = \"rear-right\"\n", "");
    let error = parse(&ridden).unwrap_err();
    assert_eq!((error.what.as_str(), error.place.line), ("a cyclist cannot be the ego", 6));
}

#[test]
fn too_much_text_is_refused_unread() {
    let text = format!("{FULL}#{}", "x".repeat(crate::TEXT_BYTES_MAX));
    let error = parse(&text).unwrap_err();
    assert_eq!((error.place.line, error.place.column), (1, 1));
    assert!(error.what.contains("too many for a scenario"), "{error}");
}

#[test]
fn a_list_is_not_taken_for_a_table() {
    let minimal = include_str!("../../config/scenarios/minimal.toml");
    for (table, list) in [
        ("{ shape = \"pole\", triangles = 2000 }", "[\"pole\", 2000, 0]"),
        ("{ position_m = [0, 0, 0], speed_m_s = 10 }", "[[0, 0, 0], 0, 0, 0, 10]"),
        ("{ generate = { shape = \"pole\", triangles = 2000 } }", "[\"pole.trolley\"]"),
        (
            "{ party = \"pole\", position_m = [2.4, 0.3, 0], speed_m_s = 0 }",
            "[\"pole\", [2.4, 0.3, 0], 0, 0, 0, 0]",
        ),
        ("triangles = 2000 } }\n\n", "triangles = 2000 }, persons = [[]] }\n\n"),
        ("[parties]", "engine = [2]\n[parties]"),
        ("[parties]", "engine = []\n[parties]"),
    ] {
        assert!(minimal.contains(table), "{table}");
        let error = parse(&minimal.replacen(table, list, 1)).expect_err(list);
        assert!(error.what.contains("found a list, expected a table"), "{list}: {error}");
        assert_reads_well(&told(error));
    }
}
