//! Cells are rankings of scenarios in which the two numbers are written by hand.

use super::*;
use crate::bodies::SILENT;
use damage::injury::Victim;

/// The ego goes straight on or to the side; on foot and in a car somebody is hit.
const SCENE: &str = r#"
schema = "trolley.scenario/2"
name = "Two ways"
[parties.ego]
generate = { shape = "sedan", triangles = 600 }
[parties.pedestrian]
generate = { shape = "pedestrian", triangles = 600 }
place = { position_m = [20, 0, 0] }
[parties.wall]
generate = { shape = "wall", triangles = 600 }
place = { position_m = [25, 14, 0], yaw_deg = 90 }
[[candidates]]
name = "on foot"
state = { position_m = [0, 0, 0], speed_m_s = SLOW }
[[candidates]]
name = "wall"
state = { position_m = [0, 0, 0], yaw_deg = 0, velocity_m_s = [FAST, ACROSS] }
"#;

fn scene(times: f64) -> String {
    let number = |speed: f64| format!("{:?}", speed * times);
    SCENE
        .replace("SLOW", &number(4.0))
        .replace("FAST", &number(11.0))
        .replace("ACROSS", &number(6.0))
}

fn axis(text: &str) -> MapAxis {
    MapAxis::parse(text).unwrap()
}

#[test]
fn a_cell_is_the_ranking_of_what_is_written_by_hand() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("scene.toml");
    std::fs::write(&file, scene(1.0)).unwrap();
    let axes = [axis("speed=0.5..2"), axis("odds-outside=0.02..50")];
    let request = MapRequest { grid: Some((axes, 4)), ..MapRequest::default() };
    let map = map(&file, &request, SILENT).unwrap();
    let row = &map.rows[0];
    assert_eq!((row.given, row.cells.len()), (Some([1.0, 1.0]), 4));
    let curves_text = crate::read_text("../../config/curves/default.toml".as_ref()).unwrap();
    // Each curve of the set that somebody outside follows, and nobody else does.
    let curves = damage::Curves::parse("", &curves_text).unwrap();
    let is_outside = |victim: Victim| {
        [Victim::Pedestrian, Victim::Cyclist, Victim::Motorcyclist].contains(&victim)
    };
    let of_rung = |rung: &damage::injury::Rung| {
        [&rung.low.curves[..], &rung.high.curves, &[rung.nominal]].concat()
    };
    let outside = curves.rungs.iter().filter(|rung| is_outside(rung.victim)).flat_map(of_rung);
    let outside: Vec<&str> = outside.map(|number| &*curves.curves[number].id).collect();
    let mut engine = Engine::builder().in_process().build().unwrap();
    let mut winners = std::collections::BTreeSet::new();
    for (y, odds) in axes[1].values(4).into_iter().enumerate() {
        let mut text = String::new();
        for block in curves_text.split_inclusive("\n\n") {
            let line = block.lines().find(|line| line.starts_with("a = "));
            let is_outside = outside.iter().any(|id| block.contains(&format!("id = \"{id}\"")));
            match line.filter(|_| is_outside) {
                Some(line) => {
                    let a: f64 = line.trim_start_matches("a = ").parse().unwrap();
                    text += &block.replacen(line, &format!("a = {:?}", a + odds.ln()), 1);
                }
                None => text += block,
            }
        }
        for (x, speed) in axes[0].values(4).into_iter().enumerate() {
            let scenario = Scenario::parse("scene.toml", &scene(speed)).unwrap();
            let curves = SourceText { name: "curves".to_owned(), text: text.clone() };
            let scenario = scenario.with_curves(curves).unwrap();
            let answer = engine.rank(&scenario, &Limits::default()).unwrap().answer;
            let best = &answer.best().unwrap().name;
            let number = map.candidates.iter().position(|name| name == best).unwrap();
            assert_eq!(row.cells[y][x], MapCell::Winner(number), "{speed} {odds}");
            winners.insert(number);
        }
    }
    assert_eq!(winners.len(), 2, "it flips: {:?}", row.cells);
}

#[test]
fn numbers_of_a_policy_flip_as_they_are_set() {
    let folder = tempfile::tempdir().unwrap();
    let (file, policy) = (folder.path().join("scene.toml"), folder.path().join("policy.toml"));
    std::fs::write(&file, scene(1.0)).unwrap();
    let text = crate::read_text("../../config/policies/precaution.toml".as_ref()).unwrap();
    let text = text.replacen("accept = 0.1", "accept = 0.1\notherwise = \"refuse\"", 1);
    std::fs::write(&policy, text).unwrap();
    let default = PathBuf::from("../../config/policies/default.toml");
    let request = MapRequest {
        policies: vec![policy, default],
        grid: Some(([axis("accepted=0..1"), axis("tolerance=0..1")], 3)),
        ..MapRequest::default()
    };
    let map = map(&file, &request, SILENT).unwrap();
    let row = &map.rows[0];
    assert_eq!(row.given, Some([0.1, 0.005]));
    for cells in &row.cells {
        assert_eq!(cells[0], MapCell::Nobody, "everybody is at risk");
        assert!(matches!(cells[2], MapCell::Winner(_)), "all is accepted");
    }
    let default = &map.rows[1];
    assert!(default.cells.is_empty() && default.notes[0].contains("does not have"));
}

#[test]
fn the_speed_as_given_changes_nothing() {
    for name in ["small", "crossing", "demo"] {
        let path = format!("../../config/scenarios/{name}.toml");
        let scenario = Scenario::open(&path).unwrap();
        let damage::Criteria { policy, curves, .. } = scenario.criteria();
        let mut all = Varied {
            scenario: scenario.parsed().clone(),
            policy: damage::Policy::clone(policy),
            curves: damage::Curves::clone(curves),
        };
        MapKnob::Speed.set(1.0, &mut all).unwrap();
        assert_eq!(all.scenario, *scenario.parsed(), "{name}");
    }
}
