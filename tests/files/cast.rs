//! `trolley intersect --cast` compared with brute force and with exact poses, and its errors.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use crate::support::{Place, json, shipped, text, trolley};
use body::Shape;
use geometry::rng::Rng;
use geometry::sweep::first_contact;
use geometry::{Corners, DVec3, Pose, RelativePose, Sweep, Triangle};
use serde_json::Value;
use std::fmt::Write as _;
use std::path::Path;
use trolley::kernel::{Build, BuildOptions, SweepWorkspace, Tree, Walk, read_mesh};

fn utf8(path: &Path) -> &str {
    path.to_str().unwrap()
}

/// Poses as the command reads them.
fn rows(poses: &[Pose]) -> String {
    let mut text = String::new();
    for pose in poses {
        for ([x, y, z], t) in pose.rotation.iter().zip(pose.translation) {
            writeln!(text, "{x} {y} {z} {t}").unwrap();
        }
    }
    text
}

/// The triangles of a binary STL, in file order.
fn triangles(path: &Path) -> Vec<Corners> {
    let bytes = std::fs::read(path).unwrap();
    let number = |at: &[u8]| f32::from_le_bytes(at.try_into().unwrap());
    let corner = |at: &[u8]| [0, 4, 8].map(|i| number(&at[i..i + 4]));
    let facets = bytes[84..].chunks_exact(50);
    facets.map(|facet| [12, 24, 36].map(|i| corner(&facet[i..i + 12]))).collect()
}

/// A sedan and an SUV some metres apart, in the world.
struct Traffic {
    place: Place,
    poses: [Pose; 2],
}

impl Traffic {
    fn new() -> Self {
        let place = Place::new();
        for (shape, triangles, name) in [("sedan", "900", "a"), ("suv", "800", "b")] {
            let path_of = |ending: &str| place.path().join(format!("{name}.{ending}"));
            let (model, mesh) = (path_of("trolley"), path_of("stl"));
            let make = ["generate", shape, "--triangles", triangles, "-o", utf8(&model)];
            for args in [&make[..], &["export", utf8(&model), "-o", utf8(&mesh)]] {
                assert!(trolley().arg("model").args(args).status().unwrap().success());
            }
        }
        let a = Pose::from_degrees(40.0, -3.0, 2.0, [12.5, -7.25, 0.3]);
        let ahead = [0, 1, 2].map(|i| a.translation[i] + 6.0 * a.rotation[i][0]);
        let poses = [a, Pose::from_degrees(131.0, 1.5, -4.0, ahead)];
        place.write("poses.txt", &rows(&poses));
        Self { place, poses }
    }

    fn run(&self, more: &[&str]) -> std::process::Output {
        let [a, b, poses] =
            ["a.stl", "b.stl", "poses.txt"].map(|name| self.place.path().join(name));
        let args = [&["intersect", utf8(&a), utf8(&b), "--poses", utf8(&poses)][..], more].concat();
        trolley().args(args).output().unwrap()
    }

    fn ask(&self, more: &[&str]) -> Value {
        let output = self.run(&[&["--json"][..], more].concat());
        assert!(output.status.success(), "{more:?}: {}", text(&output.stderr));
        json(&output)
    }

    /// Every triangle against every other: travels and ids of all that touch, in order.
    fn truth(&self, direction: [f64; 3], from_m: f64, to_m: f64) -> Vec<(f64, [u32; 2])> {
        let r = &self.poses[0].rotation;
        let [x, y, z] = direction;
        let along = |i: usize| (r[0][i] * x + r[1][i] * y) + r[2][i] * z;
        let sweep = Sweep::new(DVec3::from_array([0, 1, 2].map(along)), from_m, to_m).unwrap();
        let pose = RelativePose::between(&self.poses[0], &self.poses[1]);
        let [a, b] = ["a.stl", "b.stl"].map(|name| triangles(&self.place.path().join(name)));
        by_brute_force(&a, &b, &pose, &sweep)
    }
}

/// Every triangle against every other: travels and numbers of all that touch, in order.
fn by_brute_force(
    a: &[Corners],
    b: &[Corners],
    pose: &RelativePose,
    sweep: &Sweep,
) -> Vec<(f64, [u32; 2])> {
    let moved: Vec<Triangle> = b.iter().map(|corners| pose.triangle(corners)).collect();
    let mut found = Vec::new();
    for (i, of_a) in (0..).zip(a) {
        for (j, of_b) in (0..).zip(&moved) {
            let touch = first_contact(&Triangle::stored(of_a), of_b, sweep);
            found.extend(touch.map(|touch| (touch.travel_m, [i, j])));
        }
    }
    found.sort_by(|p, q| p.0.total_cmp(&q.0).then(p.1.cmp(&q.1)));
    found
}

/// Directions from which each pair of bodies is tried.
const DIRECTIONS: u32 = 32;

#[test]
fn first_contact_of_generated_and_real_bodies_is_that_of_brute_force() {
    let of_file = |name: &str| read_mesh(shipped(name)).unwrap();
    let generated = |shape| shapes::generate(shape, 700, 3).unwrap().corners;
    let (hatchback, barrier) = (of_file("hatchback.obj"), of_file("jersey_barrier.dae"));
    let shapes = [Shape::Sedan, Shape::Truck, Shape::Pedestrian, Shape::Cyclist, Shape::Pole];
    let [sedan, truck, pedestrian, cyclist, pole] = shapes.map(generated);
    let pairs = [
        [&sedan, &truck],
        [&sedan, &pedestrian],
        [&truck, &cyclist],
        [&sedan, &pole],
        [&hatchback, &sedan],
        [&hatchback, &barrier],
        [&hatchback, &pedestrian],
        [&barrier, &truck],
        [&hatchback, &hatchback],
    ];
    let builds = [(Build::Sah, 4), (Build::Paper, 1), (Build::Literal, 64), (Build::Sah, 16)];
    let (mut rng, mut workspace) = (Rng::new(31), SweepWorkspace::new());
    let mut contacts = 0;
    for (number, pair) in pairs.iter().enumerate() {
        let trees = builds.map(|(build, leaf_size)| {
            let options = BuildOptions { build, leaf_size, threads: 1 };
            pair.map(|corners| Tree::build(corners, &options).unwrap())
        });
        for direction in 0..DIRECTIONS {
            // From all round, each somewhat past the middle of A.
            let turn = f64::from(direction) / f64::from(DIRECTIONS) * std::f64::consts::TAU;
            let toward = DVec3::new(-turn.cos(), -turn.sin(), rng.between(-0.1, 0.1));
            let aside = DVec3::new(-toward.y, toward.x, 0.0) * rng.between(-2.0, 2.0);
            let [yaw, pitch, roll] = [180.0, 8.0, 8.0].map(|most| rng.between(-most, most));
            let at = aside - toward * 9.0 + DVec3::Z * rng.between(-0.3, 0.3);
            let stands = Pose::from_degrees(yaw, pitch, roll, at.to_array());
            let pose = RelativePose::between(&Pose::IDENTITY, &stands);
            let sweep = Sweep::new(toward, 0.0, 18.0).unwrap();
            let truth = by_brute_force(pair[0], pair[1], &pose, &sweep).first().copied();
            contacts += u32::from(truth.is_some());
            for [a, b] in &trees {
                for walk in [Walk::Wide, Walk::Plain] {
                    workspace.set_walk(walk);
                    let first = trolley::kernel::first_contact(a, b, &pose, &sweep, &mut workspace);
                    let first = first.unwrap().map(|witness| (witness.travel_m, witness.ids));
                    assert_eq!(first, truth, "pair {number}, {turn} rad, {walk:?}");
                }
            }
        }
    }
    assert!(contacts > DIRECTIONS * pairs.len() as u32 / 2, "{contacts} touch");
}

#[test]
fn first_contact_and_the_earliest_pairs_are_those_of_brute_force() {
    let traffic = Traffic::new();
    // Towards A along its axis and obliquely, from before the pose, and past it.
    for (cast, direction) in [
        ("-2,-1.5,0.1", [-2.0, -1.5, 0.1]),
        ("-1e-3,-1.2e-3,0", [-1e-3, -1.2e-3, 0.0]),
        ("1,0.4,0", [1.0, 0.4, 0.0]),
    ] {
        let truth = traffic.truth(direction, -1.0, 9.0);
        let least = [("sah", "4", "wide"), ("paper", "1", "wide"), ("literal", "64", "plain")];
        for (build, leaf_size, walk) in least {
            let how = ["--build", build, "--leaf-size", leaf_size, "--walk", walk, "--repeat", "3"];
            let motion = ["--cast", cast, "--reach", "9", "--back", "1", "--nearest", "20"];
            let line = traffic.ask(&[&motion[..], &how].concat());
            assert_eq!(line["question"], "first-contact");
            assert_eq!((line.get("pairs"), line.get("hash")), (None, None), "{line}");
            let Some((travel_m, ids)) = truth.first() else {
                for key in ["first_contact_m", "witness", "bracket"] {
                    assert!(line[key].is_null(), "{line}");
                }
                assert_eq!(line["nearest"], Value::Array(Vec::new()));
                continue;
            };
            assert_eq!(line["first_contact_m"].as_f64().unwrap().to_bits(), travel_m.to_bits());
            assert_eq!(line["witness"], Value::from(ids.to_vec()));
            let [low, high] = [0, 1].map(|i| line["bracket"][i].as_f64().unwrap());
            assert!(low <= *travel_m && *travel_m <= high && high - low <= 2.1e-9, "{line}");
            assert!(line["exact_tests"].as_u64().unwrap() > 0, "{line}");
            let nearest: Vec<Value> = truth
                .iter()
                .take(20)
                .map(|(travel_m, ids)| serde_json::json!({ "travel_m": travel_m, "ids": ids }))
                .collect();
            assert_eq!(line["nearest"], Value::from(nearest), "{cast} {how:?}");
        }
    }
}

#[test]
fn the_length_of_the_direction_and_a_begin_in_contact_do_not_matter() {
    let traffic = Traffic::new();
    let first = |more: &[&str]| traffic.ask(more)["first_contact_m"].as_f64();
    let short = first(&["--cast", "-2,-1.5,0.1", "--reach", "9"]);
    assert!(short.is_some_and(|travel_m| travel_m > 0.5), "{short:?}");
    for cast in ["-2e300,-1.5e300,1e299", "-2e-320,-1.5e-320,1e-321"] {
        let long = first(&["--cast", cast, "--reach", "9"]).unwrap();
        assert!((long - short.unwrap()).abs() < 1e-2, "{cast}: {long}");
    }
    // Contact begins 2 m before the second motion does, and lasts.
    let late = format!("{}", short.unwrap() - 0.001);
    assert_eq!(first(&["--cast", "-2,-1.5,0.1", "--reach", &late]), None);
    let never = traffic.ask(&["--cast", "2,1.5,0", "--reach", "5"]);
    assert!(never["first_contact_m"].is_null() && never.get("nearest").is_none(), "{never}");
}

#[test]
fn the_text_says_what_the_line_says() {
    let traffic = Traffic::new();
    let flags = ["--cast", "-2,-1.5,0.1", "--reach", "9", "--nearest", "2"];
    let line = traffic.ask(&flags);
    let shown = text(&traffic.run(&flags).stdout);
    let [a, b] = [0, 1].map(|i| line["witness"][i].as_u64().unwrap());
    let first = format!("First contact at {} m", line["first_contact_m"]);
    let pair = format!("triangle {a} of A, {b} of B");
    for part in [first.as_str(), &pair, "motion", "along -2, -1.5, 0.1 from 0 to 9 m", "one by one"]
    {
        assert!(shown.contains(part), "\"{part}\" is not in: {shown}");
    }
    let shown = text(&traffic.run(&["--cast", "2,1.5,0", "--reach", "5"]).stdout);
    assert!(shown.starts_with("They never touch on that way.\n"), "{shown}");
}

#[test]
fn a_cast_that_is_none_is_refused_with_how_to_write_one() {
    let traffic = Traffic::new();
    for (flags, says) in [
        (&["--cast", "0,0,0", "--reach", "1"][..], "not all 0"),
        (&["--cast", "1,0", "--reach", "1"], "three finite numbers"),
        (&["--cast", "1,nan,0", "--reach", "1"], "three finite numbers"),
        (&["--cast", "1,inf,0", "--reach", "1"], "three finite numbers"),
        (&["--cast", "1,0,0"], "--reach"),
        (&["--reach", "1"], "--cast"),
        (&["--nearest", "1"], "--cast"),
        (&["--back", "1"], "--cast"),
        (&["--cast", "1,0,0", "--reach", "-1"], "0 to 1000000"),
        (&["--cast", "1,0,0", "--reach", "2e6"], "0 to 1000000"),
        (&["--cast", "1,0,0", "--reach", "1", "--back", "nan"], "0 to 1000000"),
        (&["--cast", "1,0,0", "--reach", "1", "--nearest", "0"], "1..=1024"),
        (&["--cast", "1,0,0", "--reach", "1", "--nearest", "1025"], "1..=1024"),
        (&["--cast", "1,0,0", "--reach", "1", "--question", "sets"], "--question"),
    ] {
        let output = traffic.run(flags);
        let message = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{flags:?}: {message}");
        assert!(message.contains(says), "\"{says}\" is not said by: {message}");
    }
}

mod shared_data {
    use super::{Place, utf8};
    use crate::support::shared;
    use std::collections::BTreeMap;
    use std::process::Command;
    use trolley::kernel::{BuildOptions, RelativePose, Sweep, SweepWorkspace, Tree};
    use trolley::kernel::{first_contact, read_mesh};

    /// Answers of another program, for bodies that it makes.
    #[test]
    #[ignore = "needs ../shared, g++, and some minutes"]
    fn the_answers_of_another_program_are_found_to_a_micrometre() {
        let peers = shared("../peers");
        let place = Place::new();
        let (program, folder) = (place.path().join("gen"), place.path().join("data"));
        let source = peers.join("gen.cpp");
        let compile = ["-O2", "-o", utf8(&program), utf8(&source)];
        assert!(Command::new("g++").args(compile).status().unwrap().success());
        assert!(Command::new(&program).arg(&folder).output().unwrap().status.success());
        let answers = std::fs::read_to_string(peers.join("first-contact.txt")).unwrap();
        let mut cases = BTreeMap::<&str, Vec<Vec<&str>>>::new();
        for line in answers.lines().filter(|line| !line.starts_with('#')) {
            let words: Vec<&str> = line.split(' ').collect();
            cases.entry(words[0]).or_default().push(words);
        }
        let mut workspace = SweepWorkspace::new();
        let (mut count, mut worst_m) = (0, 0.0_f64);
        for (case, queries) in cases {
            let tree = |name: &str| {
                let triangles = read_mesh(folder.join(case).join(name)).unwrap();
                Tree::build(&triangles, &BuildOptions::default()).unwrap()
            };
            let (a, b) = (tree("a.stl"), tree("b.stl"));
            for words in queries {
                let n: Vec<f64> = words[2..19].iter().map(|word| word.parse().unwrap()).collect();
                let rotation = [[n[0], n[1], n[2]], [n[3], n[4], n[5]], [n[6], n[7], n[8]]];
                let pose = RelativePose { rotation, translation: [n[9], n[10], n[11]] };
                let sweep = Sweep::new([n[12], n[13], n[14]].into(), n[15], n[16]).unwrap();
                let first = first_contact(&a, &b, &pose, &sweep, &mut workspace).unwrap();
                let first_m = first.map(|first| first.travel_m);
                let answer_m = words[19].parse::<f64>().ok();
                assert_eq!(first_m.is_some(), answer_m.is_some(), "{case} {}", words[1]);
                let off_m = (first_m.unwrap_or_default() - answer_m.unwrap_or_default()).abs();
                assert!(off_m <= 1e-6, "{case} {}: {first_m:?} is not {answer_m:?}", words[1]);
                (count, worst_m) = (count + 1, worst_m.max(off_m));
            }
        }
        assert_eq!(count, 64);
        // Shown with --nocapture.
        let _gone = std::io::Write::write_fmt(
            &mut std::io::stderr(),
            format_args!("{count} answers, off by {worst_m:.1e} m at most\n"),
        );
    }
}
