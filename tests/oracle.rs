//! Hit sets against brute force: every pair of triangles, tested one by one, at the poses that the
//! answer names. It uses neither trees nor jobs nor processes, and places the bodies by itself.

mod support;

use geometry::hash::{pair_term, splitmix64};
use geometry::{DVec3, Pose, RelativePose, triangle};
use model::generate::{Shape, generate};
use scenario::{Scenario, Source, State};
use support::{Place, json, run, six};

/// Counts and hashes of what is hit: of A, of B, and of pairs.
type Found = [(u64, u64); 3];

fn brute_force(a: &model::Mesh, b: &model::Mesh, pose: &RelativePose) -> Found {
    let mut found = [(0, 0_u64); 3];
    let (mut hit_a, mut hit_b) = (vec![false; a.corners.len()], vec![false; b.corners.len()]);
    let placed: Vec<_> = b.corners.iter().map(|corners| pose.triangle(corners)).collect();
    for (i, corners) in a.corners.iter().enumerate() {
        let at_home = triangle::Triangle(corners.map(|c| DVec3::from_array(c.map(f64::from))));
        for (j, other) in placed.iter().enumerate() {
            if triangle::intersect(&at_home, other) {
                (hit_a[i], hit_b[j]) = (true, true);
                found[2].0 += 1;
                found[2].1 = found[2].1.wrapping_add(pair_term(i as u32, j as u32));
            }
        }
    }
    for (hits, found) in [hit_a, hit_b].iter().zip(&mut found) {
        for id in (0..hits.len()).filter(|id| hits[*id]) {
            found.0 += 1;
            found.1 = found.1.wrapping_add(splitmix64(id as u64));
        }
    }
    found
}

/// B at a travel, seen from A: moved against the direction of the relative velocity.
fn placed(ego: &State, other: &State, travel_m: f64) -> RelativePose {
    let relative = ego.velocity_m_s - other.velocity_m_s;
    let u = Pose::direction_to_body(&ego.pose, relative) * (1.0 / relative.length());
    RelativePose::between(&ego.pose, &other.pose).moved(-u * travel_m)
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
    assert_eq!(Shape::Sedan.name(), "sedan");
    let (mut poses, mut touching) = (0, 0);
    for row in document["answer"]["ranking"].as_array().unwrap() {
        let candidate =
            scenario.candidates.iter().find(|c| row["name"] == c.name.as_str()).unwrap();
        let other = mesh(candidate.other.party.0);
        for pose in row["poses"].as_array().unwrap() {
            let travel_m = pose["travel_m"].as_f64().unwrap();
            let at = placed(&candidate.ego, &candidate.other.state, travel_m);
            let found = brute_force(&ego, &other, &at);
            let place = format!("{} at {travel_m} m", candidate.name);
            for (side, count, hash) in [(0, "hits_a", "hash_a"), (1, "hits_b", "hash_b")] {
                assert_eq!(pose[count], found[side].0, "{place}: {count}");
                assert_eq!(pose[hash], format!("{:016x}", found[side].1), "{place}: {hash}");
            }
            if let Some(pairs) = pose.get("pairs") {
                assert_eq!(*pairs, found[2].0, "{place}: pairs");
                assert_eq!(pose["hash"], format!("{:016x}", found[2].1), "{place}: hash of pairs");
            }
            poses += 1;
        }
        touching += usize::from(row["contact"]["touch"] == "yes");
        if row["contact"]["touch"] == "no" {
            let found =
                brute_force(&ego, &other, &placed(&candidate.ego, &candidate.other.state, 0.0));
            assert_eq!(found[2].0, 0, "{}: no contact, but pairs", candidate.name);
        }
    }
    assert!(
        poses >= 15 && touching >= 4,
        "{poses} poses of {touching} crashes are too few to tell"
    );
}
