//! The examples are valid, and one is what its comments say.

use super::violated;
use crate::{Occupancy, PartyIndex, Prediction, Scenario};

const CROSSING: &str = include_str!("../../../config/scenarios/crossing.toml");

#[test]
fn the_shipped_examples_are_valid() {
    for (name, text) in [
        ("minimal.toml", include_str!("../../../config/scenarios/minimal.toml")),
        ("small.toml", include_str!("../../../config/scenarios/small.toml")),
        ("demo.toml", include_str!("../../../config/scenarios/demo.toml")),
    ] {
        let read = Scenario::parse(name, text).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(violated(text), Vec::<String>::new(), "{name}");
        let kinds = read.parties.iter().map(|party| party.source.kind().unwrap());
        read.check_kinds(name, &kinds.collect::<Vec<_>>()).unwrap();
    }
}

#[test]
fn the_crossing_is_as_its_comments_say() {
    let read = Scenario::parse("crossing.toml", CROSSING).unwrap();
    assert_eq!(violated(CROSSING), Vec::<String>::new());
    let names: Vec<&str> = read.candidates.iter().map(|way| way.name.as_str()).collect();
    assert_eq!(names, ["go on", "brake", "swerve"]);
    let party = |name: &str| read.parties.iter().position(|party| party.name == name).unwrap();
    assert_eq!(read.parties[party("parked")].occupancy, Occupancy::Empty);
    let oncoming = &read.parties[party("oncoming")];
    assert_eq!(oncoming.occupancy, Occupancy::Default);
    let probabilities: Vec<f64> = oncoming.predictions.iter().map(|p| p.probability).collect();
    assert_eq!(probabilities, [0.7, 0.3]);
    assert_eq!(read.candidates[0].reactions[0].party, PartyIndex(party("pedestrian")));

    let kinds = read.parties.iter().map(|party| party.source.kind().unwrap());
    read.check_kinds("crossing.toml", &kinds.collect::<Vec<_>>()).unwrap();
    read.check_fixed("crossing.toml").unwrap();
}

#[test]
fn who_could_meet_whom_is_as_the_comments_say() {
    let read = Scenario::parse("crossing.toml", CROSSING).unwrap();
    let party = |name: &str| &read.parties.iter().find(|p| p.name == name).unwrap().predictions;
    // The least distance of two origins over the horizon.
    let least = |way: usize, Prediction { motion, .. }: &Prediction| {
        let apart = |k: u32| {
            let time_s = read.horizon_s * f64::from(k) / 400.0;
            let [a, b] = [&read.candidates[way].ego, motion].map(|m| m.path.pose_at(time_s));
            (a.translation[0] - b.translation[0]).hypot(a.translation[1] - b.translation[1])
        };
        (0..=400).map(apart).fold(f64::INFINITY, f64::min)
    };
    let [go_on, brake, swerve] = [0, 1, 2];
    let pedestrian = &party("pedestrian")[0];
    assert!(least(go_on, pedestrian) < 2.0 && least(brake, pedestrian) < 2.5);
    assert!(least(swerve, pedestrian) > 2.5);
    let [goes_on, brakes] = &party("oncoming")[..] else { panic!() };
    assert!(least(swerve, goes_on) < 3.0, "{}", least(swerve, goes_on));
    assert!(least(swerve, brakes) > 3.0, "{}", least(swerve, brakes));
}
