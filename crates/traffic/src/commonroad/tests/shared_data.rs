//! The recordings of others, which are no part of this project, read.

use crate::{ReadOptions, Recording, read};
use std::path::PathBuf;

fn shared(path: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data").join(path)
}

fn recorded(name: &str) -> Recording {
    let path = shared("scenarios/commonroad").join(name);
    let text = std::fs::read_to_string(path).expect("readable");
    read(name, &text, &ReadOptions::default()).unwrap_or_else(|e| panic!("{e}"))
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
