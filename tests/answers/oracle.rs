//! Hit sets against brute force: every pair of triangles, tested one by one, at the poses that the
//! answer names. It uses neither trees nor jobs nor processes, and places the bodies by itself.

use crate::support::{Found, Place, assert_found, brute_force, json, run, ways};
use body::Mesh;
use geometry::motion::MotionPath;
use geometry::{DVec3, Pose, RelativePose};
use scenario::{Scenario, Source};
use shapes::generate;

/// B some travel after contact, seen from A: moved against the direction of the relative velocity.
fn placed(ego: &MotionPath, other: &MotionPath, time_s: f64, travel_m: f64) -> RelativePose {
    let [a, b] = [ego, other].map(|path| path.pose_at(time_s));
    let [v, w] = [ego, other].map(|path| path.velocity_before(time_s, [0.0; 3]).0);
    let relative: DVec3 = v - w;
    let u = Pose::direction_to_body(&a, relative) * (1.0 / relative.length());
    RelativePose::between(&a, &b).moved(-u * travel_m)
}

fn of(a: &Mesh, b: &Mesh, pose: &RelativePose) -> Found {
    brute_force((&a.corners, &a.source_ids), (&b.corners, &b.source_ids), pose)
}

// verifies REQ-EXACT
#[test]
fn hit_sets_equal_those_of_brute_force() {
    let text = ways(800);
    let place = Place::new();
    let path = place.write("ways.toml", &text);
    let output = run(&["rank", path.to_str().unwrap(), "--json", "--workers", "2", "--depth", "5"]);
    let document = json(&output);
    let scenario = Scenario::parse("ways.toml", &text).unwrap();
    let mesh = |party: usize| match scenario.parties[party].source {
        Source::Generate { shape, triangles, seed } => generate(shape, triangles, seed).unwrap(),
        Source::File(_) => unreachable!("this scenario generates its bodies"),
    };
    let ego = mesh(scenario.ego.0);
    let (mut poses, mut touching) = (0, 0);
    for row in document["answer"]["ranking"].as_array().unwrap() {
        let candidate =
            scenario.candidates.iter().find(|c| row["name"] == c.name.as_str()).unwrap();
        // Until the first contact all move as they are written; nobody turns.
        let Some(contact) = row["contacts"].get(0) else { continue };
        let number = scenario.parties.iter().position(|p| contact["party"] == p.name.as_str());
        let number = number.unwrap();
        let (other, path) = (mesh(number), &scenario.parties[number].predictions[0].motion.path);
        let time_s = contact["time_s"].as_f64().unwrap();
        for pose in contact["poses"].as_array().unwrap() {
            let travel_m = pose["travel_m"].as_f64().unwrap();
            let at = placed(&candidate.ego.path, path, time_s, travel_m);
            let found = of(&ego, &other, &at);
            assert_found(pose, &found, &format!("{} at {travel_m} m", candidate.name));
            poses += 1;
        }
        // A millimetre before, nothing touches.
        let before = of(&ego, &other, &placed(&candidate.ego.path, path, time_s, -1e-3));
        assert_eq!(before[2].0, 0, "{}: pairs before contact", candidate.name);
        touching += 1;
    }
    assert!(
        poses >= 15 && touching >= 4,
        "{poses} poses of {touching} crashes are too few to tell"
    );
}
