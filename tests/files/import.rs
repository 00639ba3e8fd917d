//! Bodies from files: real ones are imported at their true size, exports are reimported bit for
//! bit, and malformed files are refused within seconds with a clear message, leaving nothing
//! behind.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod bodies;
mod shared_data;

use crate::support::{Place, json, shipped, text, trolley};
use bodies::{Body, SHIPPED};
use runtime::clock::now_ns;
use serde_json::Value;
use std::fmt::Write as _;
use std::path::Path;
use std::process::Output;

/// A refusal takes a fraction of a second; this allows for a busy machine.
const REFUSAL_NS_MAX: u64 = 10_000_000_000;

/// Runs `trolley model ...`.
fn model(args: &[&str]) -> Output {
    trolley().arg("model").args(args).output().unwrap()
}

/// As [`model`], which must succeed.
fn done(args: &[&str]) -> Output {
    let output = model(args);
    assert!(output.status.success(), "{args:?}: {}", text(&output.stderr));
    output
}

fn utf8(path: &Path) -> &str {
    path.to_str().unwrap()
}

/// Names in a folder, sorted.
fn listing(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap().flatten();
    let mut names: Vec<String> =
        entries.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

/// Runs an import that must be refused: exit code, a message that names file, fault and remedy, a
/// short time, and an unchanged output folder. Returns the message.
fn refused(file: &str, more: &[&str], code: i32) -> String {
    let place = Place::new();
    let out = place.write("out.trolley", "old");
    let args = [&["import", file, "-o", utf8(&out)], more].concat();
    let begun_ns = now_ns();
    let output = model(&args);
    let taken_ns = now_ns() - begun_ns;
    let message = text(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{args:?}: {message}");
    assert!(message.starts_with("error: ") && message.contains("\n  help: "), "{message}");
    assert!(message.contains(file), "{message} does not name {file}");
    assert!(taken_ns < REFUSAL_NS_MAX, "{file}: {taken_ns} ns");
    assert_eq!(text(&output.stdout), "", "{args:?}");
    assert_eq!(listing(place.path()), ["out.trolley"], "{args:?}");
    assert_eq!(std::fs::read_to_string(&out).unwrap(), "old", "{args:?}");
    message
}

/// Imports bodies of a folder, and checks their known properties.
fn come_in(models: &Path, bodies: &[Body]) {
    let place = Place::new();
    let out = place.path().join("out.trolley");
    for Body { file, flags, triangles, size, looks } in bodies {
        let path = models.join(file);
        let args = [&["import", utf8(&path), "-o", utf8(&out), "--json"], *flags].concat();
        let document = json(&done(&args));
        assert!(
            text(&done(&args).stdout).starts_with("{\n  \"schema\": \"trolley.model-import/1\"")
        );
        let body = &document["body"];
        assert_eq!(body["triangles"], *triangles, "{file}");
        assert_eq!(body["looks_like"], *looks, "{file}");
        for (axis, size) in size.iter().enumerate() {
            let found = body["size_m"][axis].as_f64().unwrap();
            assert!((found - size).abs() < 0.006, "{file}: {}", body["size_m"]);
        }
        let of_parts = body["parts"].as_array().unwrap().iter();
        let sum: u64 = of_parts.map(|part| part["triangles"].as_u64().unwrap()).sum();
        assert_eq!(sum, *triangles, "{file}");
        // The file agrees with the import's report.
        let info = json(&done(&["info", utf8(&out), "--json"]));
        assert_eq!(info["body"], *body, "{file}");
        let table = text(&done(&["info", utf8(&out)]).stdout);
        let sentence = format!("{:.2} × {:.2} × {:.2} m: {looks}\n", size[0], size[1], size[2]);
        assert!(table.starts_with(&sentence) && !table.contains("doubt"), "{table}");
        assert_eq!(listing(place.path()), ["out.trolley"], "{file}");
    }
}

#[test]
fn shipped_bodies_come_in_at_their_size() {
    come_in(&shipped(""), &SHIPPED);
}

/// Exports a model, imports that with its name and kind and no other option, and exports again.
fn goes_round(folder: &Path, from: &Path, kind: &str) {
    let path = |name: &str| folder.join(name);
    let first_stl = path("first.stl");
    done(&["export", utf8(from), "-o", utf8(&first_stl)]);
    let before = json(&done(&["info", utf8(from), "--json"]));
    for format in ["stl", "ply", "obj"] {
        let (mesh, again) = (path(&format!("mesh.{format}")), path(&format!("again.{format}")));
        let (body, stl) = (path("body.trolley"), path("again-as.stl"));
        done(&["export", utf8(from), "--format", format, "-o", utf8(&mesh)]);
        let name = before["body"]["name"].as_str().unwrap();
        done(&["import", utf8(&mesh), "--kind", kind, "--name", name, "-o", utf8(&body)]);
        done(&["export", utf8(&body), "--format", format, "-o", utf8(&again)]);
        assert!(std::fs::read(&mesh).unwrap() == std::fs::read(&again).unwrap(), "{format}");
        // STL holds coordinates and order and nothing else.
        done(&["export", utf8(&body), "-o", utf8(&stl)]);
        assert!(std::fs::read(&first_stl).unwrap() == std::fs::read(&stl).unwrap(), "{format}");
        let after = json(&done(&["info", utf8(&body), "--json"]));
        for key in ["size_m", "min_m", "max_m", "triangles", "degenerate_kept"] {
            assert_eq!(before["body"][key], after["body"][key], "{format}: {key}");
        }
    }
}

#[test]
fn what_is_exported_comes_back_bit_for_bit() {
    let place = Place::new();
    let from = place.path().join("body.trolley-0");
    done(&["generate", "sedan", "--triangles", "3000", "--seed", "7", "-o", utf8(&from)]);
    goes_round(place.path(), &from, "sedan");
    let hatchback = shipped("hatchback.obj");
    let frame = ["--unit", "inch", "--forward", "-y"];
    let args = [&["import", utf8(&hatchback), "--kind", "sedan", "-o", utf8(&from)], &frame[..]];
    done(&args.concat());
    goes_round(place.path(), &from, "sedan");
}

/// A box as OBJ, its least corner at the origin.
fn box_obj([x, y, z]: [f64; 3]) -> String {
    let mut obj = String::new();
    for corner in 0..8 {
        let coordinate = |bit: u32, size: f64| if corner >> bit & 1 == 1 { size } else { 0.0 };
        writeln!(obj, "v {} {} {}", coordinate(0, x), coordinate(1, y), coordinate(2, z)).unwrap();
    }
    obj + "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n"
}

/// A hostile file: name, content, what the message must say.
fn hostile() -> Vec<(&'static str, Vec<u8>, &'static str)> {
    let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    let mut stl = vec![0_u8; 80];
    stl.extend(u32::MAX.to_le_bytes());
    stl.extend([0; 50]);
    let ply = |vertices: &str, faces: &str| {
        format!(
            "ply\nformat binary_little_endian 1.0\nelement vertex {vertices}\nproperty float x\n\
             property float y\nproperty float z\nelement face {faces}\nproperty list uint uint \
             vertex_indices\nend_header\n"
        )
    };
    let mut long_face = ply("0", "1").into_bytes();
    long_face.extend(u32::MAX.to_le_bytes());
    let node = "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],";
    let recursive = format!("{node}\"nodes\":[{{\"children\":[1]}},{{\"children\":[0]}}]}}");
    let buffer = |uri: &str, bytes: &str| {
        format!(
            "{node}\"nodes\":[{{\"mesh\":0}}],\"meshes\":[{{\"primitives\":[{{\"attributes\":\
             {{\"POSITION\":0}}}}]}}],\"accessors\":[{{\"bufferView\":0,\"componentType\":5126,\
             \"count\":3,\"type\":\"VEC3\",\"min\":[0,0,0],\"max\":[1,1,1]}}],\"bufferViews\":\
             [{{\"buffer\":0,\"byteLength\":36}}],\"buffers\":[{{\"uri\":\"{uri}\",\
             \"byteLength\":{bytes}}}]}}"
        )
    };
    let mut glb = b"glTF\x02\x00\x00\x00".to_vec();
    glb.extend([0xff; 12]);
    let deep = "[".repeat(100_000);
    vec![
        ("four-billion.stl", stl, "4294967295"),
        ("index.obj", format!("{triangle}f 1 2 9\n").into(), "line 4: index 9 is out of range"),
        ("nan.obj", "v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n".into(), "is not finite"),
        ("vertices.ply", ply("4000000000", "1").into(), ""),
        ("faces.ply", ply("0", "18446744073709551615").into(), ""),
        ("long-face.ply", long_face, ""),
        ("recursive.gltf", recursive.into(), "node"),
        ("missing.gltf", buffer("nowhere.bin", "36").into(), "nowhere.bin"),
        ("outside.gltf", buffer("../../etc/passwd", "36").into(), "../../etc/passwd"),
        ("absolute.gltf", buffer("/etc/passwd", "36").into(), "/etc/passwd"),
        ("linked.gltf", buffer("link.bin", "36").into(), "leads out of the mesh's folder"),
        ("huge.gltf", buffer("own.bin", "99999999999").into(), ""),
        ("cut.glb", glb, ""),
        ("deep.gltf", format!("{{\"asset\":{deep}").into(), ""),
        ("deep-side.obj", box_obj([4.0, 2.0, 1.5]).into(), "deep-side.toml"),
        ("bad-side.obj", box_obj([4.0, 2.0, 1.5]).into(), "bad-side.toml:2:11"),
        ("empty.obj", Vec::new(), "the file is empty"),
        ("empty.glb", Vec::new(), ""),
        ("picture.png", b"\x89PNG".to_vec(), "cannot be imported"),
        ("wrong.stl", box_obj([4.0, 2.0, 1.5]).into(), "named STL, but its content looks like OBJ"),
        ("millimetres.obj", box_obj([4500.0, 1800.0, 1400.0]).into(), "--unit mm"),
    ]
}

#[test]
fn hostile_files_are_refused_in_bounded_time_and_memory() {
    let place = Place::new();
    place.write("deep-side.toml", &format!("name = {}", "[".repeat(100_000)));
    place.write("bad-side.toml", "name = \"x\"\nmass_kg = -5.0\n");
    place.write("own.bin", "too short");
    std::os::unix::fs::symlink("/etc/passwd", place.path().join("link.bin")).unwrap();
    for (name, content, says) in hostile() {
        let file = place.path().join(name);
        std::fs::write(&file, content).unwrap();
        // A quarter of the default limit; none of these may even approach it.
        let limits = ["--kind", "sedan", "--memory-mb", "512", "--cpu-s", "8"];
        let message = if name.contains("-side.") {
            refused_by_side(&file, &limits)
        } else {
            refused(utf8(&file), &limits, 65)
        };
        assert!(message.contains(says), "{name}: {message}");
        for sign in ["MB of memory", "CPU time", "crashed", "gave up", "reader failed", "of stack"]
        {
            assert!(!message.contains(sign), "{name}: {message}");
        }
    }
    for name in [".", "nowhere.obj", "no/folder.obj"] {
        let file = place.path().join(name);
        refused(utf8(&file), &["--kind", "sedan"], 65);
    }
    refused("/dev/zero", &["--kind", "sedan"], 65);
}

/// As [`refused`], for a fault in the side file, which is named instead.
fn refused_by_side(file: &Path, more: &[&str]) -> String {
    let out = file.with_extension("trolley");
    let output = model(&[&["import", utf8(file), "-o", utf8(&out)], more].concat());
    let message = text(&output.stderr);
    assert_eq!(output.status.code(), Some(65), "{message}");
    assert!(message.contains(utf8(&file.with_extension("toml"))), "{message}");
    assert!(message.contains("\n  help: ") && !out.exists(), "{message}");
    message
}

/// Triangles that each enclose the one before: the literal split peels them off one by one.
fn nested(triangles: u32) -> Vec<u8> {
    let mut stl = vec![0_u8; 80];
    stl.extend(triangles.to_le_bytes());
    for number in 1..=triangles {
        let r = 4.0 * number as f32 / triangles as f32;
        stl.extend([0; 12]);
        for [x, y, z] in [[-r, -r, -r], [r, -r, r], [0.0, r, 0.0]] {
            stl.extend([x, y, z].iter().flat_map(|x: &f32| x.to_le_bytes()));
        }
        stl.extend([0; 2]);
    }
    stl
}

#[test]
fn a_reader_that_takes_too_much_is_stopped() {
    let place = Place::new();
    let file = place.path().join("nested.stl");
    std::fs::write(&file, nested(50_000)).unwrap();
    let slow = ["--kind", "sedan", "--build", "literal", "--cpu-s", "1"];
    let message = refused(utf8(&file), &slow, 65);
    assert!(message.contains("stopped after 1 s of CPU time"), "{message}");
    let message = refused(utf8(&file), &["--kind", "sedan", "--memory-mb", "16"], 65);
    assert!(message.contains("needed more than 16 MB of memory"), "{message}");
    let out = place.path().join("nested.trolley");
    done(&["import", utf8(&file), "--kind", "sedan", "-o", utf8(&out)]);
}

#[test]
fn what_a_body_is_must_be_said_and_a_side_file_may_say_it() {
    let place = Place::new();
    let file = place.write("thing.obj", &box_obj([4.5, 1.8, 1.4]));
    let message = refused(utf8(&file), &[], 65);
    for word in ["4.50 × 1.80 × 1.40 m: a car", "--kind sedan", "pedestrian", "thing.toml"] {
        assert!(message.contains(word), "{message}");
    }
    place.write(
        "thing.toml",
        "name = \"taxi\"\nkind = \"suv\"\nmass_kg = 1500.0\noccupants = [{ seat = \
         \"front-left\" }]\n",
    );
    let out = place.path().join("out.trolley");
    let import = |more: &[&str]| -> Value {
        json(&done(&[&["import", utf8(&file), "-o", utf8(&out), "--json"], more].concat()))
    };
    let body = &import(&[])["body"];
    assert_eq!((&body["name"], &body["kind"]), (&"taxi".into(), &"suv".into()));
    assert_eq!(body["mass_kg"], 1500.0);
    assert_eq!(body["occupants"][0], "front-left");
    // The command line overrides the side file.
    let document = import(&["--kind", "sedan", "--name", "cab"]);
    let body = &document["body"];
    assert_eq!((&body["name"], &body["kind"]), (&"cab".into(), &"sedan".into()));
    let note = document["import"]["notes"][0].as_str().unwrap();
    assert!(note.contains("--kind sedan") && note.contains("suv"), "{note}");
}

#[test]
fn damaged_and_foreign_model_files_are_refused() {
    let place = Place::new();
    let file = place.path().join("pole.trolley");
    let path = utf8(&file);
    let pole = |out: &str| done(&["generate", "pole", "--triangles", "500", "-o", out]);
    pole(path);
    let good = std::fs::read(&file).unwrap();
    pole(path);
    assert!(good == std::fs::read(&file).unwrap(), "equal calls give equal bytes");
    let mut bent = good.clone();
    bent[good.len() / 2] ^= 1;
    let cut = good[..good.len() - 64].to_vec();
    for (content, says) in
        [(bent, "hash does not match"), (cut, "bytes"), (b"solid x".to_vec(), "TROLLEY")]
    {
        std::fs::write(&file, content).unwrap();
        let mesh = place.path().join("out.stl");
        let commands: [&[&str]; 3] =
            [&["info", path], &["check", path], &["export", path, "-o", utf8(&mesh)]];
        for args in commands {
            let output = model(args);
            let said = text(&output.stdout) + &text(&output.stderr);
            assert_eq!(output.status.code(), Some(65), "{args:?}: {said}");
            assert!(
                said.contains(path) && said.contains(says) && said.contains("help: "),
                "{said}"
            );
        }
    }
    assert_eq!(listing(place.path()), ["pole.trolley"]);
}

#[test]
fn an_output_that_cannot_be_written_is_refused_at_once() {
    let place = Place::new();
    let file = place.write("car.obj", &box_obj([4.5, 1.8, 1.4]));
    let inside = place.path().join("no/such/out.trolley");
    let before = std::fs::read(&file).unwrap();
    for out in [utf8(&inside), utf8(place.path()), utf8(&file), "/dev/null"] {
        let output = model(&["import", utf8(&file), "--kind", "sedan", "-o", out]);
        let message = text(&output.stderr);
        assert_eq!(output.status.code(), Some(71), "{message}");
        assert!(message.contains(out) && message.contains("help: "), "{message}");
    }
    assert!(before == std::fs::read(&file).unwrap());
    assert_eq!(listing(place.path()), ["car.obj"]);
}

/// What a side file knows of impacts replaces the parameters in force, and is told.
#[test]
fn a_side_file_may_know_how_a_body_bounces() {
    let place = Place::new();
    let file = place.write("taxi.obj", &box_obj([4.5, 1.8, 1.4]));
    let out = place.path().join("taxi.trolley");
    let scene = place.write(
        "wall.toml",
        "schema = \"trolley.scenario/2\"\nname = \"wall\"\n\
         [parties.ego]\nfile = \"taxi.trolley\"\n\
         [parties.wall]\ngenerate = { shape = \"wall\", triangles = 2000 }\n\
         place = { position_m = [20, 0, 0], yaw_deg = 90 }\n\
         [[candidates]]\nname = \"on\"\nstate = { position_m = [0, 0, 0], speed_m_s = 10 }\n",
    );
    let delta_v = |side: &str| {
        place.write("taxi.toml", &format!("kind = \"sedan\"\nsource = \"a test\"\n{side}"));
        done(&["import", utf8(&file), "-o", utf8(&out)]);
        let ranked = trolley().args(["rank", utf8(&scene), "--in-process", "--json"]).output();
        let answer = json(&ranked.unwrap());
        answer["answer"]["ranking"][0]["contacts"][0]["delta_v_m_s"][0]["work"][1].clone()
    };
    let usual = delta_v("").as_f64().unwrap();
    assert!((usual - 11.0).abs() < 0.01, "{usual}");
    let own = delta_v("[impact]\nrestitution = { low = 0.4, nominal = 0.5, high = 0.6 }\n");
    assert!((own.as_f64().unwrap() - 15.0).abs() < 0.01, "{own}");
    let shown = text(&done(&["info", utf8(&out)]).stdout);
    assert!(shown.contains("impact      e 0.5 in 0.4–0.6; from taxi.toml (a test)"), "{shown}");
}
