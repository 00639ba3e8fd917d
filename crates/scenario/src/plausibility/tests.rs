//! What is usual passes, each value far beyond is named once.

use super::*;
use crate::scenario::Source;
use geometry::motion::Orientation;
use proptest::prelude::*;

/// The bodies of a scenario whose bodies are all generated, as boxes of their nominal size.
fn bodies(scenario: &Scenario) -> Vec<LoadedBody> {
    let body = |party: &Party| {
        let Source::Generate { shape, .. } = party.source else { panic!("generated") };
        let (size, kind) = (shape.size_m(), shape.kind());
        let bounds = Aabb {
            min: [-0.5 * size[0] as f32, -0.5 * size[1] as f32, 0.0],
            max: [0.5 * size[0] as f32, 0.5 * size[1] as f32, size[2] as f32],
        };
        LoadedBody { kind, mass_kg: body::defaults::inertia(kind, &bounds).mass_kg, bounds }
    };
    scenario.parties.iter().map(body).collect()
}

fn doubts_of(text: &str) -> Vec<String> {
    let scenario = Scenario::parse("crash.toml", text).expect("valid");
    implausible(&scenario, &bodies(&scenario)).into_iter().map(|one| one.says).collect()
}

const SCENE: &str = r#"
schema = "trolley.scenario/2"
name = "A lorry or a wall"
[parties.ego]
generate = { shape = "sedan", triangles = 500 }
[parties.lorry]
generate = { shape = "truck", triangles = 500 }
mass_kg = 18000
state = { position_m = [60, 0, 0], yaw_deg = 180, speed_m_s = 10 }
[parties.wall]
generate = { shape = "wall", triangles = 500 }
place = { position_m = [30, 8, 0] }
[[candidates]]
name = "the lorry"
state = { position_m = [0, 0, 0], speed_m_s = 14 }
[[candidates]]
name = "the wall"
path = { states = [ { t_s = 0, position_m = [0, 0, 0] }, { t_s = 2, position_m = [30, 8, 0] } ] }
"#;

#[test]
fn what_ships_is_plausible() {
    for text in [
        SCENE,
        include_str!("../../config/scenarios/crossing.toml"),
        include_str!("../../config/scenarios/demo.toml"),
        include_str!("../../config/scenarios/minimal.toml"),
        include_str!("../../config/scenarios/small.toml"),
    ] {
        assert_eq!(doubts_of(text), [""; 0]);
    }
}

#[test]
fn each_slip_is_named_once() {
    let away = "state = { position_m = [60, 0, 0], yaw_deg = 180, speed_m_s = 10 }";
    for (from, to, said) in [
        ("mass_kg = 18000", "mass_kg = 25", "\"lorry\" weighs 25 kg, a truck 1000 to 60000 kg"),
        ("mass_kg = 18000", "mass_kg = 180000", "\"lorry\" weighs 180000 kg"),
        (away, "state = { position_m = [2000, 0, 0], speed_m_s = 0 }", "is never within 250 m"),
        ("[60, 0, 0]", "[60, 0, 5]", "\"lorry\" is 5.0 m up in the air"),
        ("[60, 0, 0]", "[60, 0, -5]", "\"lorry\" is 5.0 m below"),
        ("[30, 8, 0] }\n[[", "[30, 8, -5] }\n[[", "\"wall\" is 5.0 m below"),
        ("speed_m_s = 10", "speed_m_s = 50", "\"lorry\" goes 50 m/s, a truck 40 m/s at most"),
        ("speed_m_s = 14", "speed_m_s = 90", "\"ego\" goes 90 m/s, a sedan 80 m/s at most"),
    ] {
        let text = SCENE.replacen(from, to, 1);
        assert_ne!(text, SCENE);
        let doubts = doubts_of(&text);
        assert!(doubts.len() == 1 && doubts[0].contains(said), "{to}: {doubts:?}");
    }
}

#[test]
fn a_size_of_another_unit_is_named() {
    let scenario = Scenario::parse("crash.toml", SCENE).expect("valid");
    let mut bodies = bodies(&scenario);
    let lorry = scenario.parties.iter().position(|party| party.name == "lorry").expect("there");
    let bounds = &mut bodies[lorry].bounds;
    for corner in [&mut bounds.min, &mut bounds.max] {
        *corner = corner.map(|value| value * 0.1);
    }
    let all = implausible(&scenario, &bodies);
    assert_eq!(all.len(), 1, "{all:?}");
    assert_eq!(all[0].party.as_deref(), Some("lorry"));
    assert!(all[0].says.contains("is 1.00 m long, a truck 3.5 to 26 m"), "{all:?}");
}

#[test]
fn hills_and_groups_are_usual() {
    // Uphill by 10 % aside, and thirty people who walk as one body of two tonnes.
    let hill = SCENE.replace("[60, 0, 0]", "[60, 30, 3]");
    assert_eq!(doubts_of(&hill), [""; 0]);
    let group = SCENE
        .replace("shape = \"wall\"", "shape = \"pedestrian\"")
        .replace("place = {", "mass_kg = 2000\npersons = [ { count = 30 } ]\nplace = {");
    assert_eq!(doubts_of(&group), [""; 0]);
    let one = group.replace("persons = [ { count = 30 } ]\n", "");
    assert!(doubts_of(&one)[0].contains("weighs 2000 kg, a pedestrian 3 to 250 kg"));
}

#[test]
fn only_a_winner_that_comes_near_nobody_is_doubted() {
    assert_eq!(unmet("brake", None), None);
    assert_eq!(unmet("brake", Some(("lorry", 9.9))), None);
    let said = unmet("brake", Some(("lorry", 1990.0))).expect("doubted");
    assert_eq!(said.candidate.as_deref(), Some("brake"));
    assert!(said.says.contains("1990 m of \"lorry\""), "{said:?}");
}

/// A path through points of the plane, a second apart.
fn path(points: &[[f64; 2]]) -> MotionPath {
    let states = points.iter().enumerate().map(|(at, [x, y])| State {
        time_s: at as f64 * 6.0 / (points.len() - 1) as f64,
        position_m: [*x, *y, 0.0],
        orientation: Orientation::from_degrees(0.0, 0.0, 0.0),
    });
    MotionPath::new(&states.collect::<Vec<_>>()).expect("valid")
}

proptest! {
    /// The nearest distance is no greater than that of any time, and is that of its own states.
    #[test]
    fn nothing_is_nearer_than_the_nearest(
        a in prop::collection::vec(prop::array::uniform2(-50.0..50.0_f64), 2..6),
        b in prop::collection::vec(prop::array::uniform2(-50.0..50.0_f64), 2..6),
    ) {
        let paths = [path(&a), path(&b)];
        let found = nearest_in_plan([&paths[0], &paths[1]]);
        let apart = |states: [State; 2]| {
            let [a, b] = states.map(|state| state.position_m);
            (b[0] - a[0]).hypot(b[1] - a[1])
        };
        prop_assert!((apart(found.states) - found.apart_m).abs() < 1e-6);
        for step in 0..=600 {
            let time_s = f64::from(step) * 0.01;
            let there = apart([0, 1].map(|side: usize| paths[side].state_at(time_s)));
            prop_assert!(found.apart_m <= there + 1e-9, "{time_s} s: {there} m");
        }
    }
}
