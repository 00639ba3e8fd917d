//! `trolley intersect` compared with brute force, and its errors on bad input.
//!
//! The meshes are generated, exported and read back; ids are triangle numbers.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use crate::support::{Found, Place, brute_force, json, text, trolley};
use geometry::simd::{self, Simd};
use geometry::{Corners, Pose, RelativePose};
use serde_json::Value;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Runs `trolley ...`, which must succeed.
fn done(args: &[&str]) -> std::process::Output {
    let output = trolley().args(args).output().unwrap();
    assert!(output.status.success(), "{args:?}: {}", text(&output.stderr));
    output
}

fn utf8(path: &Path) -> &str {
    path.to_str().unwrap()
}

/// Two bodies, as model files and as meshes, and their poses.
struct Crash {
    place: Place,
    models: [PathBuf; 2],
    meshes: [PathBuf; 2],
    poses: PathBuf,
    relative: RelativePose,
}

impl Crash {
    /// A sedan in the side of an SUV.
    fn new() -> Self {
        let place = Place::new();
        let path_of = |name: &str| place.path().join(name);
        let models = ["a.trolley", "b.trolley"].map(path_of);
        let meshes = ["a.stl", "b.stl"].map(path_of);
        for (shape, triangles, i) in [("sedan", "1500", 0), ("suv", "1300", 1)] {
            let (model, mesh) = (utf8(&models[i]), utf8(&meshes[i]));
            done(&["model", "generate", shape, "--triangles", triangles, "-o", model]);
            done(&["model", "export", model, "-o", mesh]);
        }
        let a = Pose::from_degrees(40.0, -3.0, 2.0, [12.5, -7.25, 0.3]);
        let ahead = [0, 1, 2].map(|i| a.translation[i] + 2.4 * a.rotation[i][0]);
        let b = Pose::from_degrees(131.0, 1.5, -4.0, ahead);
        let poses = place.write("poses.txt", &rows(&[a, b]));
        Self { place, models, meshes, poses, relative: RelativePose::between(&a, &b) }
    }

    fn ask(&self, files: &[PathBuf; 2], more: &[&str]) -> Value {
        let [a, b] = [utf8(&files[0]), utf8(&files[1])];
        let args = [&["intersect", a, b, "--poses", utf8(&self.poses), "--json"], more].concat();
        json(&done(&args))
    }

    /// Every triangle against every other.
    fn truth(&self) -> Found {
        let [a, b] = [0, 1].map(|i| triangles(&std::fs::read(&self.meshes[i]).unwrap()));
        let ids = |corners: &[Corners]| (0..corners.len() as u32).collect::<Vec<_>>();
        brute_force((&a, &ids(&a)), (&b, &ids(&b)), &self.relative)
    }
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
fn triangles(bytes: &[u8]) -> Vec<Corners> {
    let number = |at: &[u8]| f32::from_le_bytes(at.try_into().unwrap());
    let facets = bytes[84..].chunks_exact(50);
    let corner = |at: &[u8]| [0, 4, 8].map(|i| number(&at[i..i + 4]));
    facets.map(|facet| [12, 24, 36].map(|i| corner(&facet[i..i + 12]))).collect()
}

fn assert_pairs(line: &Value, truth: &Found, what: &str) {
    assert_eq!(line["pairs"], truth[2].0, "{what}");
    assert_eq!(line["hash"], format!("{:016x}", truth[2].1), "{what}");
}

fn assert_sets(line: &Value, truth: &Found, what: &str) {
    for (side, hits, hash) in [(0, "hits_a", "hash_a"), (1, "hits_b", "hash_b")] {
        assert_eq!(line[hits], truth[side].0, "{what}: {hits}");
        assert_eq!(line[hash], format!("{:016x}", truth[side].1), "{what}: {hash}");
    }
}

#[test]
fn every_build_leaf_size_and_thread_count_finds_what_brute_force_finds() {
    let crash = Crash::new();
    let truth = crash.truth();
    assert!(truth[2].0 > 100, "{truth:?}: they hardly touch");
    for (build, leaf_size, threads, walk, files) in [
        ("paper", "1", "1", "wide", &crash.meshes),
        ("paper", "4", "2", "plain", &crash.meshes),
        ("paper", "64", "3", "wide", &crash.meshes),
        ("literal", "2", "1", "plain", &crash.meshes),
        ("literal", "8", "2", "wide", &crash.meshes),
        ("sah", "1", "3", "plain", &crash.meshes),
        ("sah", "4", "1", "wide", &crash.meshes),
        ("sah", "8", "2", "wide", &crash.meshes),
        ("sah", "2", "2", "wide", &crash.models),
        ("paper", "64", "1", "plain", &crash.models),
    ] {
        let how = ["--threads", threads, "--walk", walk];
        let flags = [&["--build", build, "--leaf-size", leaf_size][..], &how].concat();
        let ask = |question| {
            let more = [&flags[..], &["--question", question, "--repeat", "3"]].concat();
            let line = crash.ask(files, &more);
            assert_eq!(line["question"], question);
            assert_eq!(line["build"], build);
            assert_eq!(line["leaf_size"].to_string(), leaf_size);
            assert_eq!(line["threads"].to_string(), threads);
            line
        };
        let what = format!("{flags:?}");
        assert_pairs(&ask("pairs"), &truth, &what);
        assert_sets(&ask("sets"), &truth, &what);
        let touches = ask("touches");
        assert_eq!((&touches["pairs"], &touches["hash"]), (&1.into(), &"".into()), "{what}");
    }
}

#[test]
fn every_level_of_this_processor_gives_the_same_and_others_are_refused() {
    let crash = Crash::new();
    let truth = crash.truth();
    let [a, b, poses] = [&crash.meshes[0], &crash.meshes[1], &crash.poses].map(|path| utf8(path));
    for simd in Simd::ALL {
        let args = ["intersect", a, b, "--poses", poses, "--json", "--simd", simd.name()];
        let output = trolley().args(args).output().unwrap();
        let Ok(level) = simd.level() else {
            let message = text(&output.stderr);
            assert_eq!(output.status.code(), Some(78), "{simd}: {message}");
            assert!(message.contains(simd.name()) && message.contains("auto"), "{message}");
            continue;
        };
        let line = json(&output);
        assert_pairs(&line, &truth, simd.name());
        assert_eq!(line["simd"], simd::name(level));
    }
}

#[test]
fn what_is_found_is_of_the_pose_though_the_body_moves() {
    let crash = Crash::new();
    let truth = crash.truth();
    assert_eq!(crash.ask(&crash.meshes, &[])["moving"], false);
    // Less than one turn, and more than one.
    for (repeat, threads) in [("1", "1"), ("5", "2"), ("12", "1")] {
        let how = ["--moving", "--repeat", repeat, "--threads", threads];
        let line = crash.ask(&crash.meshes, &how);
        assert_pairs(&line, &truth, repeat);
        assert_eq!(line["moving"], true);
        let sets = crash.ask(&crash.meshes, &[&how[..], &["--question", "sets"]].concat());
        assert_sets(&sets, &truth, repeat);
    }
}

#[test]
fn a_model_file_keeps_its_tree_unless_another_is_asked_for() {
    let crash = Crash::new();
    let truth = crash.truth();
    let sah = crash.place.path().join("sah.trolley");
    done(&[
        "model",
        "generate",
        "suv",
        "--triangles",
        "1300",
        "--build",
        "sah",
        "--leaf-size",
        "7",
        "-o",
        utf8(&sah),
    ]);
    let [mesh, model] = [crash.meshes[0].clone(), crash.models[0].clone()];
    for (files, build, leaf_size, is_built) in [
        ([model.clone(), crash.models[1].clone()], "paper", 4, false),
        ([model, sah.clone()], "paper", 4, true),
        ([mesh, sah], "sah", 7, true),
    ] {
        let line = crash.ask(&files, &[]);
        assert_pairs(&line, &truth, build);
        assert_eq!((&line["build"], &line["leaf_size"]), (&build.into(), &leaf_size.into()));
        assert_eq!(line["build_ms"] != 0.0, is_built, "{line}");
    }
}

#[test]
fn the_line_and_the_text_say_the_same() {
    let crash = Crash::new();
    let [a, b, poses] = [&crash.meshes[0], &crash.meshes[1], &crash.poses].map(|path| utf8(path));
    let output = done(&["intersect", a, b, "--poses", poses, "--json", "--repeat", "2"]);
    let printed = text(&output.stdout);
    assert_eq!(printed.lines().count(), 1, "{printed}");
    let line = json(&output);
    let folder = crash.place.path().file_name().unwrap().to_str().unwrap();
    assert_eq!(line["case"], folder);
    assert_eq!((&line["peer"], &line["schema"]), (&"trolley".into(), &1.into()));
    assert_eq!((&line["triangles_a"], &line["triangles_b"]), (&1500.into(), &1300.into()));
    assert!(line["query_ms"].as_f64().unwrap() > 0.0 && line["np"].as_u64().unwrap() > 0, "{line}");
    let shown = text(&done(&["intersect", a, b, "--poses", poses]).stdout);
    for part in [line["hash"].as_str().unwrap(), "1,500 triangles", "pairs of triangles", a, b] {
        assert!(shown.contains(part), "\"{part}\" is not in: {shown}");
    }
    assert!(shown.lines().count() < 12, "{shown}");
}

#[test]
fn a_mesh_is_taken_as_it_stands() {
    let place = Place::new();
    // A plate of two squares, both there twice; a needle through the first; far too small to be a
    // person. The side file would scale it up, but must be ignored.
    let plate = "v 0 0 0\nv 1e-6 0 0\nv 1e-6 1e-6 0\nv 0 1e-6 0\nv 2e-6 0 0\nv 2e-6 1e-6 0\n\
                 f 1 2 3 4\nf 2 5 6 3\nf 1 2 3 4\nf 2 5 6 3\n";
    let needle = "v 5e-7 2e-7 -1\nv 5e-7 2e-7 1\nv 5e-7 2e-7 1\nf 1 2 3\nf 1 2 3\n";
    let [a, b] = [("a.obj", plate), ("b.obj", needle)].map(|(name, text)| place.write(name, text));
    place.write("a.toml", "this = \"is no side file\"");
    let poses = place.write("poses.txt", &rows(&[Pose::IDENTITY; 2]));
    let args = ["intersect", utf8(&a), utf8(&b), "--poses", utf8(&poses), "--json"];
    let pairs = json(&done(&args));
    assert_eq!((&pairs["triangles_a"], &pairs["triangles_b"]), (&8.into(), &2.into()));
    assert_eq!(pairs["pairs"], 4, "{pairs}");
    let sets = json(&done(&[&args[..], &["--question", "sets"]].concat()));
    assert_eq!((&sets["hits_a"], &sets["hits_b"]), (&2.into(), &2.into()));
    assert_eq!((sets.get("pairs"), sets.get("hash")), (None, None));
}

#[test]
fn what_is_no_good_is_named_with_its_place_and_remedy() {
    let crash = Crash::new();
    let place = &crash.place;
    let good = std::fs::read_to_string(&crash.poses).unwrap();
    let [a, poses] = [&crash.meshes[0], &crash.poses].map(|path| utf8(path).to_owned());
    let write = |name: &str, text: &str| utf8(&place.write(name, text)).to_owned();
    let mesh = |name: &str, corner: &str| {
        write(name, &format!("v 0 0 0\nv 1 0 0\nv {corner} 1 0\nf 1 2 3\n"))
    };
    let path_of = |name: &str| utf8(&place.path().join(name)).to_owned();
    let bad_poses = |name: &str, text: &str| [a.clone(), a.clone(), write(name, text)];
    let bad_mesh = |file: String| [a.clone(), file, poses.clone()];
    let binary = std::fs::read(&a).unwrap();
    std::fs::write(path_of("cut.stl"), &binary[..binary.len() / 2]).unwrap();
    let mut damaged = std::fs::read(&crash.models[0]).unwrap();
    let at = damaged.len() - 100;
    damaged[at] ^= 1;
    std::fs::write(path_of("damaged.trolley"), &damaged).unwrap();
    let cases: Vec<([String; 3], &[&str])> = vec![
        (bad_poses("word.txt", &good.replacen(' ', " x", 1)), &["word.txt:1:", "is no number"]),
        (bad_poses("nan.txt", &good.replacen(' ', " nan ", 1)), &["nan.txt:1:", "not finite"]),
        (bad_poses("short.txt", "1 0 0 0\n"), &["short.txt:2:1:", "after 1 of the six rows"]),
        (bad_poses("bent.txt", &good.replacen("0.", "0.1", 1)), &["bent.txt:1:1:", "not rigid"]),
        (bad_poses("long.txt", &"#\n".repeat(40_000)), &["long.txt", "bytes are too many"]),
        ([a.clone(), a.clone(), path_of("none.txt")], &["none.txt", "no such file"]),
        (bad_mesh(path_of("none.stl")), &["none.stl", "no such file"]),
        (bad_mesh(utf8(place.path()).to_owned()), &["a folder"]),
        (bad_mesh(path_of("cut.stl")), &["cut.stl", "it states"]),
        (bad_mesh(path_of("damaged.trolley")), &["damaged.trolley", "damaged"]),
        (bad_mesh(write("empty.obj", "# nothing\n")), &["empty.obj", "no triangle"]),
        (bad_mesh(mesh("nan.obj", "nan")), &["nan.obj", "not finite"]),
        (bad_mesh(mesh("far.obj", "1e7")), &["far.obj", "beyond", "as they stand"]),
        (bad_mesh(write("what.txt", "v 0 0 0\n")), &["what.txt", "cannot be imported"]),
    ];
    for ([a, b, poses], says) in cases {
        let output = trolley().args(["intersect", &a, &b, "--poses", &poses]).output().unwrap();
        let message = text(&output.stderr);
        assert_eq!(output.status.code(), Some(65), "{says:?}: {message}");
        for part in says.iter().chain(&["error: ", "\n  help: "]) {
            assert!(message.contains(part), "\"{part}\" is not said by: {message}");
        }
        assert_eq!(text(&output.stdout), "", "{says:?}");
    }
    for flags in
        [["--leaf-size", "0"], ["--threads", "0"], ["--question", "why"], ["--simd", "mmx"]]
    {
        let args = [&["intersect", a.as_str(), &a, "--poses", &poses][..], &flags].concat();
        let output = trolley().args(args).output().unwrap();
        assert_eq!(output.status.code(), Some(2), "{flags:?}: {}", text(&output.stderr));
    }
}
