//! Who is seen once goes on as then; who is on another level is noted; sizes tell kinds apart.

use super::*;

const CAR: Seen = Seen {
    kind: "car",
    is_guessed: false,
    is_fixed: false,
    size_m: [4.5, 1.8, 1.5],
    place: Placed { at: [0.0; 2], yaw: 0.0 },
    bottom_m: 0.0,
    velocity_m_s: Some([8.0, 0.0]),
};

#[test]
fn who_is_seen_once_goes_on_as_then() {
    let mut tracks = Tracks::default();
    tracks.begin(3.0).expect("a time");
    tracks.add("ego", CAR).expect("somebody");
    let above = Seen { bottom_m: 5.0, velocity_m_s: Some([0.0, 4.0]), ..CAR };
    tracks.add("above", above).expect("somebody");
    let recording = tracks.recording("t", "ego", &ReadOptions::default()).expect("valid");
    let track = &recording.others[0].track;
    assert!(!recording.others[0].is_static() && (track[1].place.at[1] - 0.4).abs() < 1e-9);
    assert!(recording.notes[0].ends_with("below it: above"), "{:?}", recording.notes);
}

#[test]
fn sizes_tell_kinds_apart() {
    for (size_m, kind) in [
        ([0.5, 0.6, 1.8], "pedestrian"),
        ([1.8, 0.6, 1.7], "bicycle"),
        ([2.2, 0.9, 1.5], "motorcycle"),
        ([4.5, 1.8, 1.5], "car"),
        ([4.7, 1.9, 1.75], "suv"),
        ([5.9, 2.0, 2.6], "truck"),
        ([12.0, 2.5, 3.5], "truck"),
    ] {
        assert_eq!(kind_by_size(size_m), kind);
    }
}
