//! Motions, persons, numbers and kinds must fit each other.

use super::*;

#[test]
fn motions_and_probabilities_must_fit_each_other() {
    let post = "[parties.post.place]\nposition_m = [20, -3, 0]";
    let van = "[candidates.reactions.van.path]\ncsv = \"van-brakes.csv\"";
    let cases = [
        ("probability = 0.25", "probability = 0.2", "53:15: the probabilities sum to 0.95"),
        ("probability = 0.25", "", "49:1: probability is missing"),
        ("[parties.walker.state]", "[parties.walker.place]", "key \"speed_m_s\" is not known"),
        (
            "[parties.walker.crush]",
            "[parties.walker.place]\nposition_m = [0, 0, 0]\n[parties.walker.crush]",
            "67:1: party \"walker\" moves in several ways",
        ),
        (
            post,
            "[parties.post.state]\nspeed_m_s = 1\nposition_m = [20, -3, 0]",
            "41:1: a pole is fixed to the ground and cannot move",
        ),
        (
            post,
            "[parties.post.state]\nspeed_m_s = 0\nyaw_rate_deg_s = 3\nposition_m = [2, 3, 0]",
            "41:1: a pole is fixed to the ground and cannot move",
        ),
        ("yaw_rate_deg_s = 10", "", ""),
        ("speed_m_s = 1.5", "", "73:1: the state has neither speed_m_s nor velocity_m_s"),
        (
            "speed_m_s = 1.5\nyaw_rate_deg_s = 10",
            "speed_m_s = 30\nyaw_rate_deg_s = 300",
            "79:18: speed and yaw rate make 157 m/s² sideways",
        ),
        (
            "mass_kg = 1500",
            "place = { position_m = [0, 0, 0] }",
            "25:9: party \"car\" is the ego: its motion is in the candidates",
        ),
        ("csv = \"ego.csv\"", "", "97:1: the path has neither states nor csv"),
        (
            "csv = \"ego.csv\"",
            "csv = \"ego.csv\"\nstates = []",
            "97:1: the path has both states and csv",
        ),
        ("csv = \"ego.csv\"", "states = []", "98:10: the path has no state"),
        ("[candidates.path]\ncsv = \"ego.csv\"", "", "95:1: no motion is given"),
        (
            "[candidates.path]",
            "[candidates.state]\nposition_m = [0, 0, 0]\nspeed_m_s = 1\n[candidates.path]",
            "95:1: several motions are given",
        ),
        (van, "[candidates.reactions.vna.place]\nposition_m = [0, 0, 0]", "\"vna\" is not defined"),
        (
            van,
            "[candidates.reactions.car.place]\nposition_m = [0, 0, 0]",
            "87:23: party \"car\" is the ego: it does not react to itself",
        ),
        (
            van,
            "[candidates.reactions.post.place]\nposition_m = [20, -3, 0]",
            "a pole is fixed to the ground and reacts to nothing",
        ),
        (van, "[candidates.reactions.van]", "no motion is given"),
        ("name = \"follow\"", "name = \"turn\"", "96:8: two candidates are called \"turn\""),
    ];
    for (from, to, fault) in cases {
        match parse(&changed(from, to)) {
            Err(error) => {
                assert!(error.to_string().contains(fault) && !fault.is_empty(), "{to}: {error}");
                assert_reads_well(&told(error));
            }
            Ok(_) => assert_eq!(fault, "", "{to}"),
        }
    }
    let twice: String = "[[parties.van.paths]]\nprobability = 0\ncsv = \"van.csv\"\n".repeat(2);
    let four = parse(&changed("[parties.walker]", &format!("{twice}[parties.walker]")));
    assert_eq!(four.unwrap_err().what, "4 paths are given");
}

#[test]
fn a_fixed_body_may_have_paths_that_stand() {
    let place = "[parties.post.place]\nposition_m = [20, -3, 0]\nyaw_deg = 15\npitch_deg = 1\n\
                 roll_deg = -1";
    let path = |x: f64| {
        let states = format!(
            "[[parties.post.paths]]\nstates = [{{ t_s = 0, position_m = [20, 0, 0] }}, \
             {{ t_s = 1, position_m = [{x:?}, 0, 0] }}]"
        );
        parse(&changed(place, &states))
    };
    assert!(!path(20.0).unwrap().parties[1].predictions[0].motion.moves());
    let error = path(20.5).unwrap_err();
    assert_eq!(error.what, "a pole is fixed to the ground and cannot move");
    let csv = changed(place, "[[parties.post.paths]]\ncsv = \"van.csv\"");
    let error = parse(&csv).unwrap_err();
    assert_eq!(
        (error.what.as_str(), error.file.as_str(), error.place.line),
        ("a pole is fixed to the ground and cannot move", "f.toml", 42)
    );
}

#[test]
fn persons_must_fit_their_party() {
    let persons = "[[parties.car.persons]]\ncount = 2";
    let entry = |body: &str| format!("[[parties.car.persons]]\n{body}");
    let cases = [
        (persons, entry("seat = \"front-left\""), "two persons have the seat \"front-left\""),
        (persons, entry("seat = \"rear-left\"\ncount = 2"), "2 persons cannot have the seat"),
        (persons, entry("count = 90"), "a sedan holds 9 persons at most, not 91"),
        (persons, entry("count = 20"), "a sedan holds 9 persons at most, not 21"),
        (persons, entry("count = 9"), "a sedan holds 9 persons at most, not 10"),
        (persons, entry("count = 8"), ""),
        (persons, entry(""), ""),
        ("shape = \"sedan\"", "shape = \"cyclist\"".to_owned(), "no seat \"front-left\""),
        ("mass_kg = 1500", "empty = true".to_owned(), "a party has both persons and empty"),
        ("empty = true", "persons = []".to_owned(), "persons names nobody"),
        ("empty = true", "persons = [{}]".to_owned(), "a pole holds nobody"),
        ("kind = \"unknown\"", "kind = \"unknown\"\nempty = true".to_owned(), "neither mass nor"),
        (
            "kind = \"unknown\"",
            "kind = \"unknown\"\npersons = [{}]".to_owned(),
            "neither mass nor persons",
        ),
        (
            "shape = \"pole\"",
            "shape = \"pedestrian\"".to_owned(),
            "is somebody and cannot be empty",
        ),
    ];
    for (from, to, fault) in cases {
        match parse(&changed(from, &to)) {
            Err(error) => {
                assert!(error.what.contains(fault) && !fault.is_empty(), "{to}: {error}");
                assert_reads_well(&told(error));
            }
            Ok(_) => assert_eq!(fault, "", "{to}"),
        }
    }
    // A group that walks as one body.
    let group = FULL.replace("shape = \"pole\"", "shape = \"pedestrian\"");
    for (persons, count) in [("{}", 1), ("{}, { count = 2 }", 3), ("{ count = 90 }", 90)] {
        let group = parse(&group.replace("empty = true", &format!("persons = [{persons}]")));
        assert_eq!(group.unwrap().parties[1].occupancy.count(), Some(count));
    }
    let many = group.replace("empty = true", "persons = [{ count = 90 }, {}]");
    assert_eq!(
        told(parse(&many).unwrap_err()),
        "f.toml:37:28: a pedestrian holds 90 persons at most, not 91\n  help: count again, or say \
         of which kind the body really is"
    );
}

#[test]
fn no_kind_holds_more_persons_than_it_can() {
    let held = |kind| (1..=91).filter(|count| occupancy_of(kind, *count).is_ok()).count();
    for (kind, most) in [
        (BodyKind::Sedan, 9),
        (BodyKind::Suv, 9),
        (BodyKind::Truck, 3),
        (BodyKind::Bus, 90),
        (BodyKind::Motorcycle, 2),
        (BodyKind::Cyclist, 2),
        (BodyKind::Pedestrian, 90),
        (BodyKind::Wall, 0),
        (BodyKind::Pole, 0),
        (BodyKind::Building, 0),
    ] {
        assert_eq!(held(kind), most, "{kind}");
        assert_eq!(crate::capacity(kind), most as u32, "{kind}");
        // All seats that have names can be taken, and no more.
        let seated = kind.seats().iter().map(|seat| OccupantGroup { seat: Some(*seat), count: 1 });
        let seated = Occupancy::Stated(seated.collect());
        assert!(crate::rules::occupancy_fits(kind, &seated).is_ok(), "{kind}");
    }
    // The kind of a model file is known when it is open.
    let scenario = parse(&city(1, 20)).unwrap();
    scenario.check_kinds("f.toml", &[BodyKind::Bus, BodyKind::Sedan]).unwrap();
    let error = scenario.check_kinds("f.toml", &[BodyKind::Suv, BodyKind::Sedan]).unwrap_err();
    assert_eq!(error.what, "a suv holds 9 persons at most, not 20");
    assert_eq!(error.place, scenario.parties[0].place);
}

fn occupancy_of(kind: BodyKind, count: u32) -> Result<(), Misfit> {
    let groups = vec![OccupantGroup { seat: None, count }];
    crate::rules::occupancy_fits(kind, &Occupancy::Stated(groups))
}

#[test]
fn two_ride_a_motorcycle_and_each_has_a_seat() {
    let riding = |persons: &str| {
        let text = FULL.replace("shape = \"pole\"", "shape = \"motorcycle\"");
        parse(&text.replace("empty = true", &format!("persons = [{persons}]")))
    };
    let both = riding("{ seat = 'rider' }, { seat = 'pillion' }").unwrap();
    assert_eq!(both.parties[1].occupancy.count(), Some(2));
    let what = |persons| riding(persons).unwrap_err().what;
    assert_eq!(what("{ count = 3 }"), "a motorcycle holds 2 persons at most, not 3");
    let twice = "{ seat = 'pillion' }, { seat = 'pillion' }";
    assert_eq!(what(twice), "two persons have the seat \"pillion\"");
    let car = parse(&changed("seat = \"front-left\"", "seat = \"pillion\"")).unwrap_err();
    assert_eq!(car.what, "a sedan has no seat \"pillion\"");
}

/// Now is one time: whoever is somewhere else in another motion is refused there.
#[test]
fn all_motions_of_a_party_begin_where_it_is_now() {
    let ego = "[candidates.state]\nposition_m = [0, 0, 0]";
    let walker = "[candidates.reactions.walker.place]\nposition_m = [1, 5, 0]\nyaw_deg = -90";
    let van = "[candidates.reactions.van.state]\nposition_m = [35, 3, 0.125]\nyaw_deg = 177.5";
    let inline = "position_m = [20, 3, 0.5]\nyaw_deg = 170";
    let place = |table: &str, position: &str, yaw: &str| {
        let yaw = if yaw.is_empty() { String::new() } else { format!("\nyaw_deg = {yaw}") };
        format!("[candidates.{table}]\nposition_m = [{position}]{yaw}")
    };
    let cases = [
        (ego, place("state", "0.0009, 0, 0", ""), None),
        // The second candidate's, in a file, is compared with the first one's.
        (ego, place("state", "0.0011, 0, 0", ""), Some("97:1: at 0 s party \"car\" is 0.001 m")),
        (ego, place("state", "0, 0, 0.5", ""), Some("97:1: at 0 s party \"car\" is 0.500 m")),
        (ego, place("state", "0, 0, 0", "0.09"), None),
        (ego, place("state", "0, 0, 0", "-0.11"), Some("is 0.000 m and 0.1 degrees from where")),
        (walker, place("reactions.walker.place", "1, 5, 0", "-90.09"), None),
        (
            walker,
            place("reactions.walker.place", "1, 4, 0", "-90"),
            Some("89:1: at 0 s party \"walker\" is 1.000 m and 0.0 degrees from where line 73"),
        ),
        // A turn more is the same orientation.
        (walker, place("reactions.walker.place", "1, 5, 0", "270"), None),
        (
            van,
            place("reactions.van.state", "35, 3, 0.125", "-2.5"),
            Some("99:1: at 0 s party \"van\" is 0.000 m and 180."),
        ),
        (
            inline,
            "position_m = [20, 3, 0.5]\nyaw_deg = 160".to_owned(),
            Some("52:1: at 0 s party \"van\" is 0.000 m and 2.5 degrees from where line 49"),
        ),
    ];
    for (from, to, fault) in cases {
        match (parse(&changed(from, &to)), fault) {
            (Ok(_), None) => {}
            (Err(error), Some(fault)) => {
                assert!(error.to_string().contains(fault), "{to}: {error}");
                assert!(error.remedy.contains("within 1 mm and 0.1 degrees"), "{error}");
                assert_reads_well(&told(error));
            }
            (read, fault) => panic!("{to}: {fault:?}, {read:?}"),
        }
    }
}

#[test]
fn numbers_of_parties_persons_and_states_are_bounded() {
    assert_eq!(parse(&city(32, 8)).unwrap().parties.len(), 33);
    assert_eq!(parse(&city(33, 1)).unwrap_err().what, "34 parties are defined");
    assert_eq!(parse(&city(0, 1)).unwrap_err().what, "1 parties are defined");
    let error = parse(&city(32, 9)).unwrap_err();
    assert_eq!(error.what, "up to here there are 261 persons");
    assert_reads_well(&told(error));

    let states = |n: usize| {
        let state = |i: usize| format!("{{ t_s = {i}, position_m = [{i}, 0, 0] }}, ");
        let states: String = (0..n).map(state).collect();
        let states = format!("states = [{states}]");
        parse(&FULL.replace("csv = \"ego.csv\"", &states))
    };
    assert_eq!(states(64).unwrap().candidates[1].ego.path.states().len(), 5);
    assert_eq!(states(65).unwrap_err().what, "65 states are too many");
}

#[test]
fn kinds_are_checked_again_when_the_files_are_open() {
    let scenario = parse(FULL).unwrap();
    let kinds = |van, walker| [BodyKind::Sedan, BodyKind::Pole, van, walker];
    scenario.check_kinds("f.toml", &kinds(BodyKind::Suv, BodyKind::Pedestrian)).unwrap();
    let refused = |kinds: &[BodyKind]| scenario.check_kinds("f.toml", kinds).unwrap_err();
    let error = refused(&kinds(BodyKind::Building, BodyKind::Pedestrian));
    assert_eq!((error.place.line, error.what.contains("cannot move")), (49, true), "{error}");
    let error = refused(&kinds(BodyKind::Suv, BodyKind::Wall));
    assert_eq!((error.place.line, error.what.contains("cannot move")), (73, true), "{error}");
    let error = refused(&[BodyKind::Cyclist, BodyKind::Pole, BodyKind::Suv, BodyKind::Suv]);
    assert_eq!((error.place.line, error.what.contains("be the ego")), (24, true), "{error}");
    let error = refused(&[BodyKind::Motorcycle, BodyKind::Pole, BodyKind::Suv, BodyKind::Suv]);
    assert_eq!((error.place.line, error.what.contains("no seat")), (24, true), "{error}");
    let error = scenario.check_fixed("f.toml").unwrap_err();
    assert_eq!((error.place.line, error.what.contains("unknown kind")), (73, true), "{error}");

    let stands = FULL.replace("speed_m_s = 1.5\nyaw_rate_deg_s = 10", "speed_m_s = 0");
    let error = parse(&stands).unwrap().check_fixed("f.toml").unwrap_err();
    assert!(error.what.contains("reacts"), "{error}");
    let error =
        parse(&stands).unwrap().check_kinds("f.toml", &kinds(BodyKind::Suv, BodyKind::Wall));
    assert!(error.unwrap_err().what.contains("reacts to nothing"));
    let reaction = "[candidates.reactions.walker.place]\nposition_m = [1, 5, 0]\nyaw_deg = -90\n\
                    pitch_deg = 1\nroll_deg = 2";
    let silent = stands.replace(reaction, "");
    parse(&silent).unwrap().check_fixed("f.toml").unwrap();
}
