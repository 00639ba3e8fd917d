//! The mesh does not matter: finer meshes keep the order and depth of crashes, flat faces may be
//! split and faces doubled.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use crate::support::{Place, json, run, text, ways};
use body::Shape;
use body::{Mesh, defaults, file, zones};
use bvh::BuildOptions;
use geometry::Corners;
use serde_json::Value;
use shapes::generate;

/// The first contact of each candidate that has one, with the candidate's name and order.
fn contacts(output: &std::process::Output) -> Vec<Value> {
    assert!(output.status.success(), "{}", text(&output.stderr));
    let document = json(output);
    let rows = document["answer"]["ranking"].as_array().unwrap();
    let contact = |row: &Value| {
        let mut contact = row["contacts"].get(0)?.clone();
        contact["name"] = row["name"].clone();
        Some(contact)
    };
    rows.iter().filter_map(contact).collect()
}

fn depth(row: &Value) -> f64 {
    row["contact"]["depth_m"][1].as_f64().unwrap_or(0.0)
}

/// Contacts between the nominal bodies, or other generated ones, with this many triangles.
fn meshed(triangles: u32, nominal: bool) -> Vec<Value> {
    let place = Place::new();
    let mut text = ways(triangles);
    if !nominal {
        let plain = format!("triangles = {triangles} }}");
        text = text.replace(&plain, &format!("triangles = {triangles}, seed = 3 }}"));
    }
    let path = place.write("ways.toml", &text);
    contacts(&run(&["rank", path.to_str().unwrap(), "--json", "--in-process"]))
}

/// Depth within 2 %, risk within 2 %, and the order is the same.
#[test]
fn finer_meshes_of_the_same_bodies_keep_order_and_depth() {
    let ranked_with = |triangles: u32| meshed(triangles, true);
    let coarse = ranked_with(7_000);
    assert_eq!(coarse.len(), 5);
    for triangles in [25_000, 100_000] {
        for (fine, coarse) in ranked_with(triangles).iter().zip(&coarse) {
            assert_eq!(fine["name"], coarse["name"], "{triangles}");
            let (d, e) = (depth(fine), depth(coarse));
            assert!((d - e).abs() <= 0.02 * e, "{} at {triangles}: {d} and {e}", fine["name"]);
            let risk = |row: &Value| row["energy_j"][1].as_f64().unwrap();
            let (r, s) = (risk(fine), risk(coarse));
            assert!((r - s).abs() <= 0.02 * s, "{} at {triangles}: {r} and {s}", fine["name"]);
        }
    }
}

/// A direction may lie within a few thousandths of the edge of N: then its normal turns by one
/// direction with the mesh, 5 degrees. Who is struck where does not change, nor the order, and
/// either risk lies in the model range of the other.
#[test]
fn a_normal_turns_by_one_direction_at_most_and_the_range_holds_both() {
    let (coarse, fine) = (meshed(7_000, false), meshed(25_000, false));
    for (a, b) in coarse.iter().zip(&fine) {
        assert_eq!((&a["name"], &a["party"]), (&b["name"], &b["party"]));
        let normal = |row: &Value| row["contact"]["normal_degrees"].as_f64().unwrap();
        let (m, n) = (normal(a), normal(b));
        assert!((m - n).abs() <= 5.0, "{}: {m} and {n}", a["name"]);
        let persons = |row: &Value| row["persons"].as_array().unwrap().clone();
        for (p, q) in persons(a).iter().zip(&persons(b)) {
            let [r, s] = [p, q].map(|person| person["work"][1].as_f64().unwrap());
            for (person, risk) in [(p, s), (q, r)] {
                let [low, high] = [0, 1].map(|end| person["range"][end].as_f64().unwrap());
                assert!((low..=high).contains(&risk), "{}: {risk} in {low}..{high}", a["name"]);
            }
        }
    }
}

/// Splits every triangle into four at the midpoints of its edges; the surface is unchanged.
fn split(mesh: &Mesh) -> Mesh {
    let mut fine = Mesh { parts: mesh.parts.clone(), ..Mesh::default() };
    for (at, [a, b, c]) in mesh.corners.iter().enumerate() {
        let middle = |p: &[f32; 3], q: &[f32; 3]| [0, 1, 2].map(|i| 0.5 * (p[i] + q[i]));
        let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
        let four: [Corners; 4] = [[*a, ab, ca], [ab, *b, bc], [ca, bc, *c], [ab, bc, ca]];
        fine.corners.extend(four);
        fine.part_of.extend([mesh.part_of[at]; 4]);
    }
    fine.source_ids = (0..fine.corners.len() as u32).collect();
    fine
}

/// Doubles every triangle.
fn doubled(mesh: &Mesh) -> Mesh {
    let mut twice = mesh.clone();
    twice.corners.extend(&mesh.corners);
    twice.part_of.extend(&mesh.part_of);
    twice.source_ids = (0..twice.corners.len() as u32).collect();
    twice
}

fn write(place: &Place, name: &str, shape: Shape, mesh: &Mesh) {
    let origin = defaults::Origin { name, kind: shape.kind(), origin: name, hash: "" };
    let meta = defaults::assemble(origin, mesh);
    // Zones are those of the source triangles, whose middles lie elsewhere: none, so that only
    // surfaces are compared.
    let zones = vec![body::Zones(0); zones::of_mesh(mesh, shape.kind()).len()];
    let options = BuildOptions::default();
    let body = bvh::body(mesh.clone(), meta, zones, &options, &|_| {}).unwrap();
    std::fs::write(place.path().join(name), file::encode(&body).unwrap()).unwrap();
}

const CRASHES: &str = r#"
schema = "trolley.scenario/2"
name = "meshes"
[parties.ego]
file = "ego.trolley"
[parties.oncoming]
file = "other.trolley"
state = { position_m = [40, 0.2, 0], yaw_deg = 175, speed_m_s = 8 }
[parties.crossing]
file = "other.trolley"
state = { position_m = [26, -14, 0], yaw_deg = 90, speed_m_s = 5 }
[parties.wall]
file = "wall.trolley"
place = { position_m = [24, 6.6, 0] }
[[candidates]]
name = "offset"
state = { position_m = [0, 0, 0], speed_m_s = 12 }
[[candidates]]
name = "flank"
state = { position_m = [0, 0, 0], velocity_m_s = [12, -2.2] }
[[candidates]]
name = "wall"
path = { states = [
  { t_s = 0, position_m = [0, 0, 0] },
  { t_s = 0.5, position_m = [5, 1, 0], yaw_deg = 12 },
  { t_s = 2.5, position_m = [27, 7, 0], yaw_deg = 12 },
] }
"#;

/// The ranking with all bodies remeshed by a function.
fn remeshed(by: fn(&Mesh) -> Mesh) -> Vec<Value> {
    let place = Place::new();
    for (name, shape, seed) in
        [("ego", Shape::Sedan, 0), ("other", Shape::Suv, 0), ("wall", Shape::Wall, 0)]
    {
        let mesh = by(&generate(shape, 1500, seed).unwrap());
        write(&place, &format!("{name}.trolley"), shape, &mesh);
    }
    let path = place.write("meshes.toml", CRASHES);
    contacts(&run(&["rank", path.to_str().unwrap(), "--json", "--in-process"]))
}

/// The bits of everything but counts and hashes of triangles.
fn figures(row: &Value) -> Value {
    let mut row = row.clone();
    // The first triangle is one of two now, and so has another number.
    for key in ["poses", "hits", "hashes", "triangles"] {
        assert!(row.as_object_mut().unwrap().remove(key).is_some(), "{key}");
    }
    row
}

#[test]
fn doubled_faces_change_no_bit_of_any_figure() {
    let (plain, twice) = (remeshed(Mesh::clone), remeshed(doubled));
    assert_eq!(plain.len(), 3, "{plain:#?}");
    for (a, b) in plain.iter().zip(&twice) {
        assert_eq!(figures(a), figures(b));
    }
}

/// Pairs every number of one value with that of the other.
fn numbers(a: &Value, b: &Value, way: &str, pairs: &mut Vec<(String, f64, f64)>) {
    match (a, b) {
        (Value::Object(a), Value::Object(b)) => {
            for (key, value) in a {
                numbers(value, &b[key], &format!("{way}.{key}"), pairs);
            }
        }
        (Value::Array(a), Value::Array(b)) => {
            assert_eq!(a.len(), b.len(), "{way}");
            for (a, b) in a.iter().zip(b) {
                numbers(a, b, way, pairs);
            }
        }
        (Value::Number(a), Value::Number(b)) => {
            pairs.push((way.to_owned(), a.as_f64().unwrap(), b.as_f64().unwrap()));
        }
        _ => assert_eq!(a, b, "{way}"),
    }
}

/// Middles of edges are rounded to f32, which moves a surface of 5 m by less than 1e-6 m.
#[test]
fn split_faces_leave_all_lengths_within_10_micrometres() {
    let (plain, fine) = (remeshed(Mesh::clone), remeshed(split));
    for (a, b) in plain.iter().zip(&fine) {
        let mut pairs = Vec::new();
        let patch = |row: &Value| row["contact"].clone();
        numbers(&patch(a), &patch(b), "patch", &mut pairs);
        assert!(pairs.len() > 15, "{pairs:?}");
        for (what, p, q) in &pairs {
            // Outlines leave out points within 2 mm of them, and so may choose others.
            let of_plane = ["centre_m", "normal", "depth_m"].iter().any(|key| what.contains(key));
            let most = if of_plane { 1e-3 } else { 1e-5 };
            let most = if what.contains("degrees") { 0.1 } else { most };
            assert!((p - q).abs() <= most, "{} {what}: {p} and {q}", a["name"]);
        }
    }
}
