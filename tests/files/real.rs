//! Real bodies: imported from other people's files, ranked by worker processes, compared with this
//! one process and, for small bodies, with brute force. Skipped where the bodies are not there.
#![expect(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a test that cannot go on has failed; one that cannot begin says so"
)]

use crate::support::{Place, answer, assert_found, brute_force, json, run, text, trolley};
use body::file;
use geometry::{DVec3, RelativePose};
use std::path::{Path, PathBuf};

fn data() -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data/models");
    if path.is_dir() {
        return Some(path);
    }
    println!("skipped: no real bodies at {}", path.display());
    None
}

fn command(args: &[&str]) {
    let output = trolley().args(args).output().unwrap();
    assert!(output.status.success(), "{args:?}: {}", text(&output.stderr));
}

/// Name, file, and how to read it.
const BODIES: &[(&str, &str, &[&str])] = &[
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

fn import(place: &Place, models: &Path) {
    for (name, mesh, how) in BODIES {
        let (mesh, out) = (models.join(mesh), place.path().join(format!("{name}.trolley")));
        let mut args = vec!["model", "import", mesh.to_str().unwrap(), "--name", name];
        args.extend(*how);
        args.extend(["-o", out.to_str().unwrap()]);
        command(&args);
    }
}

/// The sedan once more, through another format.
fn again(place: &Place, format: &str) {
    let path = |name: String| place.path().join(name).to_str().unwrap().to_owned();
    let mesh = path(format!("sedan.{format}"));
    let from = path("sedan.trolley".to_owned());
    command(&["model", "export", &from, "--format", format, "-o", &mesh]);
    let out = path(format!("sedan_{format}.trolley"));
    let axes = ["--unit", "m", "--up", "+z", "--forward", "+x", "--kind", "sedan"];
    let mut args = vec!["model", "import", &mesh, "-o", &out];
    args.extend(axes);
    command(&args);
}

const CRASHES: &str = r#"
schema = "trolley.scenario/1"
name = "real bodies"
[parties.ego]
file = "sedan.trolley"
[parties.suv]
file = "suv.trolley"
[parties.truck]
file = "truck.trolley"
[parties.human]
file = "human.trolley"
[parties.motorcycle]
file = "motorcycle.trolley"
[parties.stl]
file = "sedan_stl.trolley"
[parties.ply]
file = "sedan_ply.trolley"
[parties.wall]
generate = { shape = "wall", triangles = 4000 }
[parties.pole]
generate = { shape = "pole", triangles = 2000 }

[[candidates]]
name = "SUV ahead"
ego = { position_m = [0, 0, 0], speed_m_s = 15 }
other = { party = "suv", position_m = [5.0, 0.2, 0], speed_m_s = 7 }
[[candidates]]
name = "oncoming truck"
ego = { position_m = [0, 0, 0], speed_m_s = 12 }
other = { party = "truck", position_m = [6.0, 0.7, 0], yaw_deg = 180, speed_m_s = 10 }
[[candidates]]
name = "human"
ego = { position_m = [0, 0, 0], speed_m_s = 11 }
other = { party = "human", position_m = [2.5, 0.3, 0], yaw_deg = 90, speed_m_s = 1.5 }
[[candidates]]
name = "motorcycle"
ego = { position_m = [0, 0, 0], speed_m_s = 13 }
other = { party = "motorcycle", position_m = [2.8, 0.1, 0], yaw_deg = 80, speed_m_s = 6 }
[[candidates]]
name = "sedan through STL"
ego = { position_m = [0, 0, 0], speed_m_s = 10 }
other = { party = "stl", position_m = [3.2, 0.3, 0], yaw_deg = 88, speed_m_s = 9 }
[[candidates]]
name = "sedan through PLY"
ego = { position_m = [0, 0, 0], speed_m_s = 10 }
other = { party = "ply", position_m = [3.2, 0.3, 0], yaw_deg = 88, speed_m_s = 9 }
[[candidates]]
name = "wall"
ego = { position_m = [0, 0, 0], yaw_deg = 8, speed_m_s = 10 }
other = { party = "wall", position_m = [3, 1.3, 0], speed_m_s = 0 }
[[candidates]]
name = "pole"
ego = { position_m = [0, 0, 0], speed_m_s = 13 }
other = { party = "pole", position_m = [2.5, -0.3, 0], speed_m_s = 0 }
"#;

#[test]
fn real_bodies_are_ranked_the_same_by_workers_and_in_one_process() {
    let Some(models) = data() else { return };
    let place = Place::new();
    import(&place, &models);
    again(&place, "stl");
    again(&place, "ply");
    let path = place.write("real.toml", CRASHES);
    let path = path.to_str().unwrap();
    let output = run(&["rank", path, "--json", "--workers", "4"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let document = json(&output);
    let rows = document["answer"]["ranking"].as_array().unwrap();
    assert_eq!(rows.len(), 8);
    for row in rows {
        assert_eq!(row["contact"]["touch"], "yes", "{}", row["name"]);
    }
    let row = |name: &str| rows.iter().find(|row| row["name"] == name).unwrap();
    let (stl, ply) = (row("sedan through STL"), row("sedan through PLY"));
    assert_eq!(stl["poses"], ply["poses"]);
    assert_eq!(stl["work"], ply["work"]);
    let reference = answer(&run(&["rank", path, "--json", "--in-process"]));
    assert_eq!(answer(&output), reference);
    for way in [&["--workers", "2", "--build", "sah"][..], &["--workers", "1", "--depth", "0"]] {
        let mut args = vec!["rank", path, "--json"];
        args.extend(way);
        assert_eq!(answer(&run(&args)), reference, "{way:?}");
    }
}

#[test]
fn hit_sets_of_small_real_bodies_equal_those_of_brute_force() {
    let Some(models) = data() else { return };
    let place = Place::new();
    import(&place, &models);
    let crash = r#"
schema = "trolley.scenario/1"
name = "small real bodies"
[parties.ego]
file = "hatchback.trolley"
[parties.motorcycle]
file = "motorcycle.trolley"
[[candidates]]
name = "motorcycle"
ego = { position_m = [0, 0, 0], speed_m_s = 13 }
other = { party = "motorcycle", position_m = [2.6, 0.1, 0], yaw_deg = 80, speed_m_s = 0 }
"#;
    let path = place.write("small.toml", crash);
    let output = run(&["rank", path.to_str().unwrap(), "--json", "--workers", "2"]);
    let scenario = scenario::Scenario::parse("small.toml", crash).unwrap();
    let bytes = |name: &str| {
        let bytes = std::fs::read(place.path().join(name)).unwrap();
        file::Aligned::copy_of(&bytes)
    };
    let (hatchback, motorcycle) = (bytes("hatchback.trolley"), bytes("motorcycle.trolley"));
    let (_, a) = file::view(hatchback.bytes()).unwrap();
    let (_, b) = file::view(motorcycle.bytes()).unwrap();
    let candidate = &scenario.candidates[0];
    let given = RelativePose::between(&candidate.ego.pose, &candidate.other.state.pose);
    let document = json(&output);
    let poses = document["answer"]["ranking"][0]["poses"].as_array().unwrap().clone();
    assert!(poses.len() >= 3, "{document}");
    for pose in &poses {
        let travel_m = pose["travel_m"].as_f64().unwrap();
        let pose_m = given.moved(-DVec3::X * travel_m);
        let found = brute_force((a.corners, a.source_ids), (b.corners, b.source_ids), &pose_m);
        assert!(found[2].0 > 0, "nothing hit at {travel_m}");
        assert_found(pose, &found, &format!("{travel_m} m"));
    }
}
