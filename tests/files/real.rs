//! Bodies from files: imported, ranked by worker processes, compared with in-process rankings and,
//! for small bodies, with brute force; and replayed from a record.
//!
//! Those of `tests/data` were drawn for this project; `shared_data` uses third-party ones.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use crate::support::{Place, answer, assert_found, brute_force, json, run, shipped, text, trolley};
use body::file;
use geometry::{DVec3, RelativePose};
use serde_json::Value;
use std::path::Path;

fn command(args: &[&str]) {
    let output = trolley().args(args).output().unwrap();
    assert!(output.status.success(), "{args:?}: {}", text(&output.stderr));
}

/// Name, file, and how to read it.
type Given = (&'static str, &'static str, &'static [&'static str]);

fn import(place: &Place, models: &Path, bodies: &[Given]) {
    for (name, mesh, how) in bodies {
        let (mesh, out) = (models.join(mesh), place.path().join(format!("{name}.trolley")));
        let mut args = vec!["model", "import", mesh.to_str().unwrap(), "--name", name];
        args.extend(*how);
        args.extend(["-o", out.to_str().unwrap()]);
        command(&args);
    }
}

/// A sedan again, through another format.
fn again(place: &Place, sedan: &str, format: &str) {
    let path = |name: String| place.path().join(name).to_str().unwrap().to_owned();
    let mesh = path(format!("{sedan}.{format}"));
    let from = path(format!("{sedan}.trolley"));
    command(&["model", "export", &from, "--format", format, "-o", &mesh]);
    let out = path(format!("{sedan}_{format}.trolley"));
    let axes = ["--unit", "m", "--up", "+z", "--forward", "+x", "--kind", "sedan"];
    let mut args = vec!["model", "import", &mesh, "-o", &out];
    args.extend(axes);
    command(&args);
}

/// Ranks crashes that all make contact, identical in every configuration; returns the answer.
fn ranked_the_same(place: &Place, crashes: &str) -> Value {
    let path = place.write("real.toml", crashes);
    let path = path.to_str().unwrap();
    let output = run(&["rank", path, "--json", "--workers", "4"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let document = json(&output);
    let rows = document["answer"]["ranking"].as_array().unwrap();
    assert_eq!(rows.len(), crashes.matches("[[candidates]]").count());
    for row in rows {
        assert!(!row["contacts"].as_array().unwrap().is_empty(), "{}", row["name"]);
    }
    let reference = answer(&run(&["rank", path, "--json", "--in-process"]));
    assert_eq!(answer(&output), reference);
    for way in [&["--workers", "2", "--build", "sah"][..], &["--workers", "1", "--depth", "0"]] {
        let mut args = vec!["rank", path, "--json"];
        args.extend(way);
        assert_eq!(answer(&run(&args)), reference, "{way:?}");
    }
    document
}

/// A sedan imported through two formats gives the same crashes.
fn assert_alike(document: &Value) {
    let rows = document["answer"]["ranking"].as_array().unwrap();
    let row = |name: &str| &rows.iter().find(|row| row["name"] == name).unwrap()["contacts"][0];
    let (stl, ply) = (row("sedan through STL"), row("sedan through PLY"));
    assert_eq!(stl["poses"], ply["poses"]);
    assert_eq!(stl["energy_j"], ply["energy_j"]);
}

/// Ranks the crash of two small bodies; every hit set is what brute force finds.
fn assert_hits([ego, other]: [&str; 2], place: &Place, crash: &str) {
    let path = place.write("small.toml", crash);
    let output = run(&["rank", path.to_str().unwrap(), "--json", "--workers", "2"]);
    let scenario = scenario::Scenario::parse("small.toml", crash).unwrap();
    let bytes = |name: &str| {
        let bytes = std::fs::read(place.path().join(format!("{name}.trolley"))).unwrap();
        file::Aligned::copy_of(&bytes)
    };
    let files = [ego, other].map(bytes);
    let (_, a) = file::view(files[0].bytes()).unwrap();
    let (_, b) = file::view(files[1].bytes()).unwrap();
    let document = json(&output);
    let contact = &document["answer"]["ranking"][0]["contacts"][0];
    let time_s = contact["time_s"].as_f64().unwrap();
    let other = scenario.parties.iter().find(|party| contact["party"] == party.name.as_str());
    let other = &other.unwrap().predictions[0].motion.path;
    let ego = &scenario.candidates[0].ego.path;
    let given = RelativePose::between(&ego.pose_at(time_s), &other.pose_at(time_s));
    let poses = contact["poses"].as_array().unwrap().clone();
    assert!(poses.len() >= 3, "{document}");
    let found_at = |travel_m: f64| {
        let pose_m = given.moved(-DVec3::X * travel_m);
        brute_force((a.corners, a.source_ids), (b.corners, b.source_ids), &pose_m)
    };
    for pose in &poses {
        let travel_m = pose["travel_m"].as_f64().unwrap();
        assert_found(pose, &found_at(travel_m), &format!("{travel_m} m"));
        assert!(found_at(travel_m)[2].0 > 0, "nothing hit at {travel_m}");
    }
    // First contact is that of the motion in real numbers: at the pose itself rounding decides.
    assert!(found_at(-1e-6)[2].0 == 0, "hit before first contact");
    assert!(found_at(1e-6)[2].0 > 0, "nothing hit after first contact");
}

const SHIPPED: &[Given] = &[
    (
        "hatchback",
        "hatchback.obj",
        &["--unit", "inch", "--up", "+z", "--forward", "-y", "--kind", "sedan"],
    ),
    ("barrier", "jersey_barrier.dae", &["--kind", "wall"]),
];

/// Both cars through other formats begin at one place, and are gone before the ego comes, unless
/// they are slow.
const SHIPPED_CRASHES: &str = r#"
schema = "trolley.scenario/2"
name = "bodies of files"
horizon_s = 3
[parties.ego]
file = "hatchback.trolley"
[parties.barrier]
file = "barrier.trolley"
place = { position_m = [24, 6.4, 0] }
[parties.block]
file = "barrier.trolley"
place = { position_m = [26, -7, 0], yaw_deg = 85 }
[parties.stl]
file = "hatchback_stl.trolley"
state = { position_m = [22.4, -17.7, 0], yaw_deg = 88, speed_m_s = 25 }
[parties.ply]
file = "hatchback_ply.trolley"
state = { position_m = [22.4, -17.7, 0], yaw_deg = 88, speed_m_s = 25 }
[parties.pole]
generate = { shape = "pole", triangles = 2000 }
place = { position_m = [16, -8, 0] }

[[candidates]]
name = "along the barrier"
path = { states = [
  { t_s = 0, position_m = [0, 0, 0] },
  { t_s = 0.5, position_m = [5, 1, 0], yaw_deg = 12 },
  { t_s = 3, position_m = [30, 7.4, 0], yaw_deg = 12 },
] }
[[candidates]]
name = "into the barrier"
state = { position_m = [0, 0, 0], velocity_m_s = [10, -2.7] }
[[candidates]]
name = "sedan through STL"
state = { position_m = [0, 0, 0], speed_m_s = 10 }
reactions = { stl = { state = { position_m = [22.4, -17.7, 0], yaw_deg = 88, speed_m_s = 9 } } }
[[candidates]]
name = "sedan through PLY"
state = { position_m = [0, 0, 0], speed_m_s = 10 }
reactions = { ply = { state = { position_m = [22.4, -17.7, 0], yaw_deg = 88, speed_m_s = 9 } } }
[[candidates]]
name = "pole"
state = { position_m = [0, 0, 0], velocity_m_s = [12, -6.2] }
"#;

#[test]
fn bodies_of_files_are_ranked_the_same_by_workers_and_in_one_process() {
    let place = Place::new();
    import(&place, &shipped(""), SHIPPED);
    again(&place, "hatchback", "stl");
    again(&place, "hatchback", "ply");
    assert_alike(&ranked_the_same(&place, SHIPPED_CRASHES));
}

#[test]
fn hit_sets_of_bodies_of_files_equal_those_of_brute_force() {
    let place = Place::new();
    import(&place, &shipped(""), SHIPPED);
    let crash = r#"
schema = "trolley.scenario/2"
name = "small bodies of files"
[parties.ego]
file = "hatchback.trolley"
[parties.barrier]
file = "barrier.trolley"
place = { position_m = [20, 0.2, 0], yaw_deg = 80 }
[[candidates]]
name = "barrier"
state = { position_m = [0, 0, 0], speed_m_s = 13 }
"#;
    assert_hits(["hatchback", "barrier"], &place, crash);
}

/// Two builds, two questions, and a record: a body from a file is the same to all of them.
#[test]
fn a_crash_of_bodies_of_files_is_the_same_between_builds_and_replayed() {
    let place = Place::new();
    import(&place, &shipped(""), SHIPPED);
    again(&place, "hatchback", "stl");
    again(&place, "hatchback", "ply");
    let scenario = place.write("files.toml", SHIPPED_CRASHES);
    let records = place.path().join("records");
    let (scenario, records) = (scenario.to_str().unwrap(), records.to_str().unwrap());
    let output = run(&["rank", scenario, "--json", "--workers", "2", "--record", records]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let record = format!("{records}/000000.record");
    let models = place.path().to_str().unwrap();
    let replayed = trolley()
        .args(["record", "replay", &record, "--models", models, "--json"])
        .output()
        .unwrap();
    assert!(replayed.status.success(), "{}", text(&replayed.stderr));
    assert_eq!(json(&replayed)["same"], true);
    // The mesh itself and the model imported from it, with different trees.
    let poses =
        place.write("poses.txt", "1 0 0 0\n0 1 0 0\n0 0 1 0\n0 -1 0 2.1\n1 0 0 0.2\n0 0 1 0\n");
    let ask = |a: &str, more: &[&str]| {
        let path_of = |name: &str| place.path().join(name).to_str().unwrap().to_owned();
        let files = [path_of(a), path_of("barrier.trolley")];
        let poses = poses.to_str().unwrap();
        let args = [&["intersect", &files[0], &files[1], "--poses", poses, "--json"], more];
        let output = trolley().args(args.concat()).output().unwrap();
        assert!(output.status.success(), "{}", text(&output.stderr));
        let line = json(&output);
        (line["pairs"].clone(), line["hash"].clone())
    };
    let found = ask("hatchback.stl", &[]);
    assert!(found.0.as_u64() > Some(0), "{found:?}");
    for build in ["paper", "literal", "sah"] {
        assert_eq!(ask("hatchback.stl", &["--build", build, "--leaf-size", "2"]), found, "{build}");
    }
    assert_eq!(ask("hatchback_stl.trolley", &[]), found);
}

mod shared_data {
    use super::{Given, again, assert_alike, assert_hits, import, ranked_the_same};
    use crate::support::{Place, shared};

    const BODIES: &[Given] = &[
        ("sedan", "chrono_sedan/sedan_chassis_vis.obj", &["--unit", "m", "--kind", "sedan"]),
        ("suv", "chrono_nissan_patrol_suv/suv_chassis.obj", &["--unit", "m", "--kind", "suv"]),
        ("truck", "chrono_man10t_truck/MAN_10t_chassis.obj", &["--unit", "m", "--kind", "truck"]),
        (
            "human",
            "openmaterial_human/human_example.gltf",
            &["--unit", "m", "--up", "+y", "--forward", "+x", "--kind", "pedestrian"],
        ),
        (
            "motorcycle",
            "kenney_trucks/vehicle-motorcycle.glb",
            &["--unit", "1.0", "--up", "+y", "--forward", "+z", "--kind", "motorcycle"],
        ),
        (
            "hatchback",
            "gazebo_hatchback/hatchback.obj",
            &["--unit", "inch", "--up", "+z", "--forward", "-y", "--kind", "sedan"],
        ),
    ];

    const CRASHES: &str = r#"
schema = "trolley.scenario/2"
name = "real bodies"
horizon_s = 3
[parties.ego]
file = "sedan.trolley"
[parties.suv]
file = "suv.trolley"
state = { position_m = [34, 8.5, 0], yaw_deg = 178, speed_m_s = 4 }
[parties.truck]
file = "truck.trolley"
place = { position_m = [30, -8, 0], yaw_deg = 170 }
[parties.human]
file = "human.trolley"
state = { position_m = [18, 11, 0], yaw_deg = -90, speed_m_s = 1.2 }
[parties.motorcycle]
file = "motorcycle.trolley"
state = { position_m = [20, -12, 0], yaw_deg = 40, speed_m_s = 2 }
[parties.stl]
file = "sedan_stl.trolley"
state = { position_m = [22.4, -17.7, 0], yaw_deg = 88, speed_m_s = 25 }
[parties.ply]
file = "sedan_ply.trolley"
state = { position_m = [22.4, -17.7, 0], yaw_deg = 88, speed_m_s = 25 }
[[candidates]]
name = "suv"
state = { position_m = [0, 0, 0], velocity_m_s = [13, 4] }
[[candidates]]
name = "truck"
state = { position_m = [0, 0, 0], velocity_m_s = [13, -4.2] }
[[candidates]]
name = "pedestrian"
state = { position_m = [0, 0, 0], velocity_m_s = [12, 6.4] }
[[candidates]]
name = "motorcycle"
state = { position_m = [0, 0, 0], velocity_m_s = [12, -6] }
[[candidates]]
name = "sedan through STL"
state = { position_m = [0, 0, 0], speed_m_s = 10 }
reactions = { stl = { state = { position_m = [22.4, -17.7, 0], yaw_deg = 88, speed_m_s = 9 } } }
[[candidates]]
name = "sedan through PLY"
state = { position_m = [0, 0, 0], speed_m_s = 10 }
reactions = { ply = { state = { position_m = [22.4, -17.7, 0], yaw_deg = 88, speed_m_s = 9 } } }
"#;

    #[test]
    #[ignore = "needs ../shared/data: real bodies"]
    fn real_bodies_are_ranked_the_same_by_workers_and_in_one_process() {
        let place = Place::new();
        import(&place, &shared("models"), BODIES);
        again(&place, "sedan", "stl");
        again(&place, "sedan", "ply");
        assert_alike(&ranked_the_same(&place, CRASHES));
    }

    #[test]
    #[ignore = "needs ../shared/data: real bodies"]
    fn hit_sets_of_small_real_bodies_equal_those_of_brute_force() {
        let place = Place::new();
        import(&place, &shared("models"), BODIES);
        let crash = r#"
schema = "trolley.scenario/2"
name = "small real bodies"
[parties.ego]
file = "hatchback.trolley"
[parties.motorcycle]
file = "motorcycle.trolley"
place = { position_m = [20, 0.1, 0], yaw_deg = 80 }
[[candidates]]
name = "motorcycle"
state = { position_m = [0, 0, 0], speed_m_s = 13 }
"#;
        assert_hits(["hatchback", "motorcycle"], &place, crash);
    }
}
