//! Columns are found by their names, boxes stand where they are, and what is wrong is refused with
//! its line.

use super::*;
use proptest::prelude::*;

const KEYS_OF_ONE: [&str; 13] = [
    "Entity_Name [-]",
    "World_Position_X [m]",
    "World_Position_Y [m]",
    "World_Position_Z [m]",
    "World_Heading_Angle [rad]",
    "bb_x [m]",
    "bb_y [m]",
    "bb_z [m]",
    "bb_length [m]",
    "bb_width [m]",
    "bb_height [m]",
    "Vel_X [m/s]",
    "Vel_Y [m/s]",
];

fn head() -> String {
    let mut names = vec!["Index [-]".to_owned(), "TimeStamp [s]".to_owned()];
    for entity in ["#1", "#2"] {
        names.extend(KEYS_OF_ONE.map(|key| format!("{entity} {key}")));
    }
    format!("Version: 1\nScenario File Name: a.xosc\n\n{},\n", names.join(" , "))
}

fn line(time_s: f64) -> String {
    let ego = format!("Ego, {}, 0, 0, 0, 1.4, 0, 0.75, 5, 2, 1.5, 10, 0", 10.0 * time_s);
    // It points to the left, and its box is 0.5 m in front of its reference point.
    let walker = format!(
        "walker, 30, {}, 0, {}, 0.5, 0, 0.9, 0.6, 0.5, 1.8, 0, 1.5",
        -4.0 + 1.5 * time_s,
        core::f64::consts::FRAC_PI_2
    );
    format!("1, {time_s:.3}, {ego}, {walker},\n")
}

fn text() -> String {
    head() + &line(0.0) + &line(0.1) + &line(0.2)
}

fn refused(text: &str) -> String {
    read("t.csv", text, &ReadOptions::default()).expect_err("refused").to_string()
}

#[test]
fn boxes_stand_where_their_reference_points_lead() {
    let recording = read("t.csv", &text(), &ReadOptions::default()).expect("valid");
    assert_eq!(recording.ego.start.place.at, [1.4, 0.0]);
    assert_eq!(recording.ego.went.len(), 3);
    let walker = &recording.others[0];
    assert_eq!((walker.id.as_str(), walker.kind.as_str()), ("walker", "pedestrian"));
    let [x, y] = walker.track[2].place.at;
    assert!((x - 30.0).abs() < 1e-9 && (y + 3.2).abs() < 1e-9, "{x} {y}");
    assert!(recording.notes[0].contains("walker a pedestrian (0.6 × 0.5 × 1.8 m)"));
    // The spelling of earlier versions, and a unit without its space.
    let old = text().replace("Entity_Name", "Entitity_Name").replace("bb_x [m]", "bb_x[m]");
    assert_eq!(read("t.csv", &old, &ReadOptions::default()).expect("valid"), recording);
}

#[test]
fn who_is_gone_has_no_name() {
    let ego = "1, 0.300, Ego, 3, 0, 0, 0, 1.4, 0, 0.75, 5, 2, 1.5, 10, 0,";
    let gone = format!("{ego}{}\n", " ,".repeat(KEYS_OF_ONE.len()));
    let recording = read("t.csv", &(text() + &gone), &ReadOptions::default()).expect("valid");
    assert_eq!((recording.ego.went.len(), recording.others[0].track.len()), (4, 3));
}

#[test]
fn what_cannot_be_used_is_refused_with_its_line() {
    let whole = text();
    for (found, right) in [
        (refused("a,b\n1,2\n"), "t.csv: no line of names"),
        (refused(&head()), "t.csv: it has names of columns, and no moment"),
        (
            refused(&whole.replace("#2 bb_width [m]", "#2 width")),
            "t.csv:4:1: the column \"#2 bb_width\" is missing",
        ),
        (
            refused(&whole.replace("#1 Entity", "Entity").replace("#2 Entity", "Entity")),
            "t.csv:4:1: no column is called \"#1 Entity_Name [-]\"",
        ),
        (refused(&whole[..whole.len() - 30]), "t.csv:7:1: "),
        (refused(&whole.replacen("30, -4,", "30, nan,", 1)), "t.csv:5:1: #2 World_Position_Y [m]"),
        (refused(&whole.replacen("30, -4,", "30, x,", 1)), "t.csv:5:1: #2 World_Position_Y [m]"),
        (
            refused(&(whole.clone() + &line(0.15))),
            "t.csv:8:1: its time, 0.15 s, is before that of the one before it",
        ),
        (refused(&whole.replace("walker", "Ego")), "t.csv:5:1: object \"Ego\" stands there twice"),
        (refused(&whole.replace("Ego", "hero")), "t.csv: no entity is called Ego"),
    ] {
        assert!(found.starts_with(right), "{found}\n{right}");
    }
    let asked = ReadOptions { ego: Some("walker"), ..ReadOptions::default() };
    assert_eq!(read("t.csv", &whole, &asked).expect("valid").others[0].id, "Ego");
}

proptest! {
    #[test]
    fn no_text_makes_it_panic(at in 0_usize..900, new in "[ -~,\n]{0,6}", is_cut in any::<bool>()) {
        let mut text = text();
        let at = at.min(text.len());
        if is_cut {
            text.truncate(at);
        }
        text.insert_str(at, &new);
        drop(read("t.csv", &text, &ReadOptions::default()));
    }
}
