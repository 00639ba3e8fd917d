//! A sweep changes what it says and nothing else: undone, it is the scene as given; and what it
//! gives is a scenario.

use super::*;

const SCENE: &str = r#"
schema = "trolley.scenario/2"
name = "Scene"
horizon_s = 3

[parties]
ego = { generate = { shape = "sedan", triangles = 600 } }

[parties.pole]
generate = { shape = "pole", triangles = 600 }
place = { position_m = [12, -1.5, 0] }

[parties.other]
generate = { shape = "suv", triangles = 600 }
errors = { lateral_m = 0.1 }
paths = [{ states = [
  { t_s = 0, position_m = [30, 0, 0], yaw_deg = 90 },
  { t_s = 2, position_m = [30, 10, 0], yaw_deg = 90 },
] }]

[[candidates]]
name = "on"
state = { position_m = [0, 0, 0], yaw_deg = 5, speed_m_s = 9 }
reactions = { other = { state = { position_m = [30, 0, 0], yaw_deg = 90, speed_m_s = 4 } } }

[[candidates]]
name = "swerve"
path = { states = [
  { t_s = -0.5, position_m = [-5, 0, 0] },
  { t_s = 0.5, position_m = [5, 0, 0], yaw_deg = 10 },
  { t_s = 1.5, position_m = [14, 3, 0], yaw_deg = 20 },
] }
"#;

fn table() -> Table {
    toml::from_str(SCENE).unwrap()
}

fn set(knob: SweepKnob, value: f64) -> Table {
    let mut table = table();
    knob.set(value, &mut table).unwrap();
    table
}

fn parsed(table: &Table) -> scenario::Scenario {
    scenario::Scenario::parse("scene.toml", &toml::to_string(table).unwrap()).unwrap()
}

/// Where a motion is: position is linear between states.
fn place(motion: &scenario::Motion, time_s: f64) -> [f64; 2] {
    let states = motion.path.states();
    let next = states.iter().position(|state| state.time_s > time_s).unwrap_or(states.len() - 1);
    let [a, b] = [&states[next - 1], &states[next]];
    let share = (time_s - a.time_s) / (b.time_s - a.time_s);
    [0, 1].map(|k| a.position_m[k] + share * (b.position_m[k] - a.position_m[k]))
}

/// Where the ego is on its second way.
fn swerves(table: &Table, time_s: f64) -> [f64; 2] {
    place(&parsed(table).candidates[1].ego, time_s)
}

fn assert_near(a: [f64; 2], b: [f64; 2]) {
    assert!((a[0] - b[0]).abs() < 1e-6 && (a[1] - b[1]).abs() < 1e-6, "{a:?} {b:?}");
}

#[test]
fn the_value_of_the_scene_as_given_changes_nothing() {
    for knob in SweepKnob::ALL {
        assert_eq!(set(knob, knob.given()), table(), "{}", knob.name());
    }
}

#[test]
fn every_value_within_the_limits_gives_a_scenario() {
    for knob in SweepKnob::ALL {
        let [least, most] = knob.limits();
        for share in [0.0, 0.1, 0.35, 0.5, 0.8, 1.0] {
            parsed(&set(knob, least + share * (most - least)));
        }
    }
}

#[test]
fn what_is_undone_is_as_given() {
    for (knob, value, back) in [
        (SweepKnob::Speed, 1.25, 0.8),
        (SweepKnob::Offset, 0.75, -0.75),
        (SweepKnob::ErrorSigma, 1.5, -1.5),
    ] {
        let mut table = set(knob, value);
        assert_ne!(parsed(&table), parsed(&self::table()), "{}", knob.name());
        knob.set(back, &mut table).unwrap();
        let [changed, given] = [parsed(&table), parsed(&self::table())];
        for time_s in [0.0, 0.25, 1.0, 2.5] {
            assert_near(swerves(&table, time_s), swerves(&self::table(), time_s));
            for (a, b) in changed.parties.iter().zip(&given.parties) {
                for (a, b) in a.predictions.iter().zip(&b.predictions) {
                    let [a, b] = [a, b].map(|it| place(&it.motion, time_s));
                    assert_near(a, b);
                }
            }
        }
    }
}

#[test]
fn a_late_reaction_is_the_same_way_later_from_where_the_ego_is_then() {
    let late = set(SweepKnob::Reaction, 0.8);
    // 10 m/s at time 0: straight on until 0.8 s, and 8 m further from then on.
    assert_near(swerves(&late, 0.0), swerves(&table(), 0.0));
    assert_near(swerves(&late, 0.4), [4.0, 0.0]);
    for time_s in [0.0, 0.3, 0.5, 1.0, 1.5, 2.0] {
        let [x, y] = swerves(&table(), time_s);
        assert_near(swerves(&late, time_s + 0.8), [x + 8.0, y]);
    }
}

#[test]
fn a_way_with_as_many_states_as_a_path_holds_may_begin_later() {
    a_full_way_begins_later(21.0);
    // All of it before the horizon: one state is left out, where it matters least.
    a_full_way_begins_later(32.0);
}

fn a_full_way_begins_later(per_s: f64) {
    let state = |k: i32| {
        let time_s = f64::from(k) / per_s;
        format!("{{ t_s = {time_s}, position_m = [{}, 0, 0], yaw_deg = 5 }}", 21.0 * time_s)
    };
    let states: Vec<String> = (0..64).map(state).collect();
    let begin = SCENE.rfind("path = {").unwrap();
    let text = format!("{}path = {{ states = [{}] }}", &SCENE[..begin], states.join(", "));
    let mut table: Table = toml::from_str(&text).unwrap();
    let given = table.clone();
    SweepKnob::Reaction.set(0.2, &mut table).unwrap();
    for time_s in [0.0, 0.5, 1.0, 2.0, 2.7] {
        let [x, y] = swerves(&given, time_s);
        assert_near(swerves(&table, time_s + 0.2), [x + 4.2, y]);
    }
}

#[test]
fn an_error_puts_others_where_their_deviations_say_and_leaves_the_ego() {
    let shifted = parsed(&set(SweepKnob::ErrorSigma, 2.0));
    let given = parsed(&table());
    assert_eq!(shifted.candidates[0].ego, given.candidates[0].ego);
    let position = |scene: &scenario::Scenario, name: &str| {
        let party = scene.parties.iter().find(|party| party.name == name).unwrap();
        place(&party.predictions[0].motion, 0.0)
    };
    // It faces y: 0.6 m ahead of it, and 0.2 m to its left, as it states 0.1 m.
    assert_near(position(&shifted, "other"), [30.0 - 0.2, 0.6]);
    assert_near(position(&shifted, "pole"), [12.6, -1.5 + 0.4]);
}

#[test]
fn what_a_sweep_cannot_change_is_refused_by_name() {
    let turning = SCENE.replace("speed_m_s = 9", "speed_m_s = 9, yaw_rate_deg_s = 3");
    let mut table: Table = toml::from_str(&turning).unwrap();
    let fault = SweepKnob::Reaction.set(0.5, &mut table).unwrap_err();
    assert!(fault.starts_with("candidate \"on\": "), "{fault}");
    let csv = SCENE.replace("paths = [{ states", "paths = [{ csv = \"a.csv\", x");
    let mut table: Table = toml::from_str(&csv).unwrap();
    let fault = SweepKnob::ErrorSigma.set(1.0, &mut table).unwrap_err();
    assert!(fault.starts_with("party \"other\": its path is a CSV file"), "{fault}");
}
