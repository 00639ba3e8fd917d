//! Hit sets against brute force: every pair of triangles, tested one by one, at the poses that the
//! answer names. It uses neither trees nor jobs nor processes, and places the bodies by itself.

use crate::support::{Found, Place, assert_found, brute_force, json, run, six};
use body::Mesh;
use geometry::{Pose, RelativePose};
use scenario::{MotionState, Scenario, Source};
use shapes::generate;

/// B at a travel, seen from A: moved against the direction of the relative velocity.
fn placed(ego: &MotionState, other: &MotionState, travel_m: f64) -> RelativePose {
    let relative = ego.velocity_m_s - other.velocity_m_s;
    let u = Pose::direction_to_body(&ego.pose, relative) * (1.0 / relative.length());
    RelativePose::between(&ego.pose, &other.pose).moved(-u * travel_m)
}

fn of(a: &Mesh, b: &Mesh, pose: &RelativePose) -> Found {
    brute_force((&a.corners, &a.source_ids), (&b.corners, &b.source_ids), pose)
}

#[test]
fn hit_sets_equal_those_of_brute_force() {
    let text = six(800);
    let place = Place::new();
    let path = place.write("six.toml", &text);
    let output = run(&["rank", path.to_str().unwrap(), "--json", "--workers", "2", "--depth", "5"]);
    let document = json(&output);
    let scenario = Scenario::parse("six.toml", &text).unwrap();
    let mesh = |party: usize| match scenario.parties[party].source {
        Source::Generate { shape, triangles, seed } => generate(shape, triangles, seed).unwrap(),
        Source::File(_) => unreachable!("this scenario generates its bodies"),
    };
    let ego = mesh(scenario.ego.0);
    let (mut poses, mut touching) = (0, 0);
    for row in document["answer"]["ranking"].as_array().unwrap() {
        let candidate =
            scenario.candidates.iter().find(|c| row["name"] == c.name.as_str()).unwrap();
        let other = mesh(candidate.other.party.0);
        for pose in row["poses"].as_array().unwrap() {
            let travel_m = pose["travel_m"].as_f64().unwrap();
            let at = placed(&candidate.ego, &candidate.other.state, travel_m);
            let found = of(&ego, &other, &at);
            assert_found(pose, &found, &format!("{} at {travel_m} m", candidate.name));
            poses += 1;
        }
        touching += usize::from(row["contact"]["touch"] == "yes");
        if row["contact"]["touch"] == "no" {
            let found = of(&ego, &other, &placed(&candidate.ego, &candidate.other.state, 0.0));
            assert_eq!(found[2].0, 0, "{}: no contact, but pairs", candidate.name);
        }
    }
    assert!(
        poses >= 15 && touching >= 4,
        "{poses} poses of {touching} crashes are too few to tell"
    );
}
