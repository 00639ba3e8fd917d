//! The recordings of others, which are no part of this project, read and swept.

use crate::{ManoeuvreSweep, ReadOptions, Recording, read};
use serde_json::Value;
use std::path::PathBuf;

fn shared(path: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data").join(path)
}

fn recorded(name: &str) -> Recording {
    let path = shared("scenarios/commonroad").join(name);
    let text = std::fs::read_to_string(path).expect("readable");
    read(name, &text, &ReadOptions::default()).unwrap_or_else(|e| panic!("{e}"))
}

/// Alternatives that others derived from the same files, with other code: the same manoeuvre meets
/// the same partner within 0.1 s, and both are within 0.2 m of the stated places.
#[test]
#[ignore = "needs ../shared/data: recorded traffic"]
fn derived_alternatives_are_found_again() {
    let list = shared("scenarios/derived_alternatives.json");
    let text = std::fs::read_to_string(list).expect("readable");
    let list: std::collections::BTreeMap<String, Vec<Value>> =
        serde_json::from_str(&text).expect("JSON");
    let (mut found, mut all, mut report) = (0, 0, String::new());
    for (file, cases) in &list {
        let recording = recorded(file);
        let swept = recording.sweep(&ManoeuvreSweep::default());
        for case in cases {
            all += 1;
            let number = |at: &Value, key: &str| at[key].as_f64().expect("a number");
            let manoeuvre = &case["manoeuvre"];
            let asked = crate::Manoeuvre::Arc {
                brake_m_s2: number(manoeuvre, "brake"),
                lateral_m_s2: number(manoeuvre, "alat"),
            };
            let Some(meeting) = swept.meetings.iter().find(|m| m.manoeuvre == asked) else {
                report += &format!("{file} {}: no meeting\n", asked.name());
                continue;
            };
            let whom = &recording.others[meeting.whom];
            let after_s = meeting.ego.time_s - swept.began_s;
            let late = (after_s - number(case, "t")).abs();
            let apart = |at: [f64; 2], of: &Value| {
                libm::hypot(at[0] - number(of, "x"), at[1] - number(of, "y"))
            };
            let ego = apart(meeting.ego.place.at, &case["ego"]);
            let other = apart(meeting.other.place.at, &case["obstacle"]);
            let same = whom.id == case["obstacle"]["id"].as_str().expect("an id");
            let holds = same && late <= 0.1 && ego <= 0.2 && other <= 0.2;
            found += u32::from(holds);
            report += &format!(
                "{file} {}: {} after {after_s:.2} s; off by {late:.2} s, ego {ego:.3} m, other \
                 {other:.3} m{}\n",
                asked.name(),
                whom.id,
                if holds { "" } else { "  <--" }
            );
        }
    }
    eprintln!("{report}{found} of {all}");
    assert!(found >= 18 && all == 20, "{report}{found} of {all}");
}

#[test]
#[ignore = "needs ../shared/data: recorded traffic"]
fn the_ego_among_the_obstacles_is_recognised() {
    let recording = recorded("OSC_PedestrianCollision-1_1_T-1.xml");
    assert_eq!(recording.others.len(), 1);
    assert!(recording.ego.went.len() > 80);
    let meets_s = recording.recorded_meeting_s(0.02).expect("the recording ends in a crash");
    assert!((5.0..6.0).contains(&meets_s), "{meets_s}");
}
