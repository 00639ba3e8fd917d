//! Third-party bodies and malformed files, which are not part of this project.

use super::bodies::{BODIES, ODD};
use super::{come_in, done, goes_round, listing, model, refused, utf8};
use crate::support::{Place, json, shared, text};
use std::path::PathBuf;

#[test]
#[ignore = "needs ../shared/data: malformed files"]
fn every_malformed_file_loads_or_is_refused() {
    let folder = shared("robustness");
    const LOAD: [&str; 7] = [
        "Spider_ascii.stl",
        "Spider_binary.stl",
        "Wuson.ply",
        "box_longline.obj",
        "concave_polygon.obj",
        "cube_binary.ply",
        "triangle_with_empty_solid.stl",
    ];
    let place = Place::new();
    let out = place.path().join("out.trolley");
    let names = listing(&folder);
    assert!(names.len() >= 19, "{names:?}");
    for name in &names {
        let file = folder.join(name);
        if LOAD.contains(&name.as_str()) {
            done(&["import", utf8(&file), "--kind", "building", "-o", utf8(&out)]);
            done(&["check", utf8(&out)]);
            std::fs::remove_file(&out).unwrap();
        } else {
            refused(utf8(&file), &["--kind", "building"], 65);
        }
    }
    // All at once: one line per file, in the order asked for.
    let files: Vec<PathBuf> = names.iter().map(|name| folder.join(name)).collect();
    let args: Vec<&str> = ["check"].into_iter().chain(files.iter().map(|f| utf8(f))).collect();
    let output = model(&args);
    assert_eq!(output.status.code(), Some(65));
    let lines: Vec<String> = text(&output.stdout).lines().map(str::to_owned).collect();
    assert_eq!(lines.len(), names.len());
    for (line, name) in lines.iter().zip(&names) {
        let state = if LOAD.contains(&name.as_str()) { "ok " } else { "refused " };
        assert!(line.starts_with(state) && line.contains(name), "{line}");
    }
    let document = json(&model(&[&args[..], &["--json"]].concat()));
    assert_eq!(document["schema"], "trolley.model-check/1");
    assert_eq!(document["refused"], names.len() - LOAD.len());
}

#[test]
#[ignore = "needs ../shared/data: real bodies"]
fn real_bodies_come_in_at_their_real_size() {
    come_in(&shared("models"), &BODIES);
}

#[test]
#[ignore = "needs ../shared/data: real bodies"]
fn what_looks_like_something_else_comes_in_as_what_it_is_said_to_be() {
    let models = shared("models");
    let place = Place::new();
    let out = place.path().join("out.trolley");
    for (file, flags, size) in ODD {
        let path = models.join(file);
        let mut args = vec!["import", utf8(&path), "-o", utf8(&out), "--json", "--kind", "pole"];
        args.extend(flags.split(' '));
        let body = &json(&done(&args))["body"];
        for (axis, size) in size.into_iter().enumerate() {
            let found = body["size_m"][axis].as_f64().unwrap();
            assert!((found - size).abs() < 0.006, "{file}: {}", body["size_m"]);
        }
        let table = text(&done(&["info", utf8(&out)]).stdout);
        assert!(table.contains("doubt"), "{file}: {table}");
    }
}

#[test]
#[ignore = "needs ../shared/data: real bodies"]
fn what_is_exported_of_a_real_body_comes_back_bit_for_bit() {
    let place = Place::new();
    let from = place.path().join("body.trolley-0");
    let truck = shared("models/chrono_man10t_truck/MAN_10t_chassis.obj");
    done(&["import", utf8(&truck), "--kind", "truck", "-o", utf8(&from)]);
    goes_round(place.path(), &from, "truck");
}
