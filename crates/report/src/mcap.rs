//! Contacts as an MCAP file for Foxglove and Lichtblick (mcap.dev; Foxglove schema
//! `foxglove.SceneUpdate` in JSON): one contact each second, each replacing the one before. On
//! `/crash` both bodies in the ego's frame, on `/plan` the candidate from above in the world's.

use crate::glb::COLOURS;
use crate::shot::{Shot, ShotBody};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::io::Cursor;
use trolley::plan::{PlanCourse, PlanSample, PlanScene};

/// Kinds of lines (Foxglove schema `foxglove.LinePrimitive`).
const STRIP: u8 = 0;
const LOOP: u8 = 1;

/// The file cannot be encoded.
#[derive(Debug, thiserror::Error)]
#[error("cannot write MCAP: {0}")]
pub struct McapError(#[from] mcap::McapError);

impl diagnostic::Diagnostic for McapError {
    fn kind(&self) -> diagnostic::FailureKind {
        diagnostic::FailureKind::Internal
    }
}

/// The file.
///
/// # Errors
///
/// If the writer refuses.
pub fn mcap(shots: &[&Shot], bodies: &[ShotBody], plan: &PlanScene) -> Result<Vec<u8>, McapError> {
    let options = mcap::WriteOptions::new().compression(None).library("trolley");
    let mut file = Cursor::new(Vec::new());
    let mut writer = options.create(&mut file)?;
    let schema = json!({"title": "foxglove.SceneUpdate", "type": "object"}).to_string();
    let schema = writer.add_schema("foxglove.SceneUpdate", "jsonschema", schema.as_bytes())?;
    let crash = writer.add_channel(schema, "/crash", "json", &BTreeMap::new())?;
    let above = writer.add_channel(schema, "/plan", "json", &BTreeMap::new())?;
    for (number, shot) in shots.iter().enumerate() {
        let course = plan.courses.iter().find(|course| course.name == shot.candidate);
        let drawn = course.map(|course| (above, from_above(plan, course, number)));
        for (channel_id, message) in [(crash, scene(shot, bodies, number))].into_iter().chain(drawn)
        {
            let head = mcap::records::MessageHeader {
                channel_id,
                sequence: number as u32,
                log_time: number as u64 * 1_000_000_000,
                publish_time: number as u64 * 1_000_000_000,
            };
            writer.write_to_known_channel(&head, message.to_string().as_bytes())?;
        }
    }
    let _summary = writer.finish()?;
    drop(writer);
    Ok(file.into_inner())
}

/// Deletes everything, then adds both bodies, with hit triangles in red.
fn scene(shot: &Shot, bodies: &[ShotBody], number: usize) -> Value {
    let mut triangles = Vec::new();
    for (side, of) in shot.bodies.into_iter().enumerate() {
        let Some(body) = bodies.get(of) else { continue };
        let mut is_hit = vec![false; body.corners.len()];
        for hit in &shot.hits[side] {
            if let Some(mark) = is_hit.get_mut(*hit as usize) {
                *mark = true;
            }
        }
        for (wanted, colour) in [(false, COLOURS[side]), (true, COLOURS[2])] {
            let marked = body.corners.iter().zip(&is_hit).filter(|(_, is_hit)| **is_hit == wanted);
            let points = marked.flat_map(|(corners, _)| corners).map(|corner| {
                let [x, y, z] = shot.place(*corner, side == 1);
                json!({"x": x, "y": y, "z": z})
            });
            triangles.push(list(points.collect(), colour));
        }
    }
    if let Some(patch) = shot.patch {
        let [a, b, c, d] = patch.corners().map(|[x, y, z]| json!({"x": x, "y": y, "z": z}));
        let points = vec![a.clone(), b, c.clone(), a, c, d];
        triangles.push(list(points, COLOURS[3]));
    }
    let text = text(&format!("{}: {}", shot.name, shot.caption), [0.0; 2]);
    update(number, "ego", &shot.name, json!({"triangles": triangles, "texts": [text]}))
}

/// Deletes everything, then adds one entity with these shapes.
fn update(number: usize, frame: &str, id: &str, shapes: Value) -> Value {
    let time = json!({"sec": number, "nsec": 0});
    let mut entity = json!({
        "timestamp": time, "frame_id": frame, "id": id,
        "lifetime": {"sec": 0, "nsec": 0}, "frame_locked": false, "metadata": [],
        "arrows": [], "cubes": [], "spheres": [], "cylinders": [], "lines": [],
        "triangles": [], "texts": [], "models": [],
    });
    if let (Value::Object(entity), Value::Object(shapes)) = (&mut entity, shapes) {
        entity.extend(shapes);
    }
    json!({"deletions": [{"timestamp": time, "type": 1, "id": ""}], "entities": [entity]})
}

/// Where everybody goes in a candidate, bodies at the start, and where they touch.
fn from_above(plan: &PlanScene, course: &PlanCourse, number: usize) -> Value {
    let (mut lines, mut texts) = (Vec::new(), Vec::new());
    for (party, of) in plan.parties.iter().enumerate() {
        let is_ego = party == plan.ego;
        let reacts = course.reactions.iter().find(|(who, _)| *who == party);
        let track = match reacts {
            _ if is_ego => &course.ego[..],
            Some((_, track)) => track,
            None => of.paths.get(of.followed).map_or(&[][..], |path| &path.track),
        };
        let colour = COLOURS[usize::from(!is_ego)];
        let place = |sample: &PlanSample| point([sample.0[1], sample.0[2]]);
        lines.push(line(STRIP, track.iter().map(place).collect(), colour));
        let Some(PlanSample([_, x, y, cos, sin])) = track.first() else { continue };
        let corner = |[u, v]: &[f64; 2]| point([x + cos * u - sin * v, y + sin * u + cos * v]);
        lines.push(line(LOOP, of.outline_m.iter().map(corner).collect(), colour));
        texts.push(text(&of.name, [*x, *y]));
    }
    let spheres = course.contacts.iter().map(|contact| {
        let mut pose = pose();
        pose["position"] = point(contact.at_m);
        json!({"pose": pose, "size": {"x": 0.6, "y": 0.6, "z": 0.6}, "color": share(COLOURS[2])})
    });
    let spheres: Vec<Value> = spheres.collect();
    let shapes = json!({"lines": lines, "texts": texts, "spheres": spheres});
    update(number, "world", &course.name, shapes)
}

fn point([x, y]: [f64; 2]) -> Value {
    json!({"x": x, "y": y, "z": 0.0})
}

fn line(kind: u8, points: Vec<Value>, colour: [u8; 4]) -> Value {
    json!({
        "type": kind, "pose": pose(), "thickness": 2, "scale_invariant": true, "points": points,
        "color": share(colour), "colors": [], "indices": [],
    })
}

fn text(said: &str, at_m: [f64; 2]) -> Value {
    let mut pose = pose();
    pose["position"] = point(at_m);
    json!({
        "pose": pose, "billboard": true, "font_size": 14, "scale_invariant": true,
        "color": {"r": 0, "g": 0, "b": 0, "a": 1}, "text": said,
    })
}

/// A colour as shares of 1.
fn share(colour: [u8; 4]) -> Value {
    let [r, g, b, a] = colour.map(|part| f64::from(part) / 255.0);
    json!({"r": r, "g": g, "b": b, "a": a})
}

fn pose() -> Value {
    json!({
        "position": {"x": 0, "y": 0, "z": 0}, "orientation": {"x": 0, "y": 0, "z": 0, "w": 1},
    })
}

fn list(points: Vec<Value>, colour: [u8; 4]) -> Value {
    json!({
        "pose": pose(), "points": points, "color": share(colour), "colors": [], "indices": [],
    })
}

#[cfg(test)]
mod tests {
    //! The format's own reader reads the file back, triangle by triangle.
    use super::*;
    use crate::shot::ShotPatch;

    #[test]
    fn a_file_reads_back_with_a_scene_for_each_candidate() {
        let body = |x: f32| ShotBody {
            name: "b".into(),
            corners: vec![[[x, 0.0, 0.0], [x, 1.0, 0.0], [x, 0.0, 1.0]]; 3],
        };
        let shot = |name: &str| Shot {
            name: name.into(),
            candidate: name.into(),
            bodies: [0, 1],
            parties: ["ego".into(), "other".into()],
            rotation: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            translation: [2.0, 0.0, 0.0],
            hits: [vec![1], vec![0, 2]],
            patch: Some(ShotPatch {
                centre_m: [0.0; 3],
                normal: [1.0, 0.0, 0.0],
                size_m: [1.0, 1.0],
            }),
            caption: "they touch".into(),
            is_nearest: false,
        };
        let shots = [shot("first"), shot("second")];
        let sample = |time_s: f64| PlanSample([time_s, 3.0 * time_s, 1.0, 1.0, 0.0]);
        let plan = PlanScene {
            horizon_s: 2.0,
            parties: vec![trolley::plan::PlanParty {
                name: "ego".into(),
                outline_m: vec![[2.0, 1.0], [-2.0, 1.0], [-2.0, -1.0], [2.0, -1.0]],
                ..Default::default()
            }],
            courses: vec![PlanCourse {
                name: "second".into(),
                ego: vec![sample(0.0), sample(2.0)],
                contacts: vec![trolley::plan::PlanContact {
                    at_m: [5.0, 1.0],
                    ..Default::default()
                }],
                ..Default::default()
            }],
            ..Default::default()
        };
        let both = [&shots[0], &shots[1]];
        let file = mcap(&both, &[body(0.0), body(5.0)], &plan).expect("written");
        let messages: Result<Vec<_>, _> = mcap::MessageStream::new(&file).expect("read").collect();
        let messages = messages.expect("sound");
        let (above, messages): (Vec<_>, Vec<_>) =
            messages.into_iter().partition(|message| message.channel.topic == "/plan");
        assert_eq!((above.len(), messages.len()), (1, 2), "the plan of the second alone is known");
        let drawn: Value = serde_json::from_slice(&above[0].data).expect("JSON");
        let entity = &drawn["entities"][0];
        assert_eq!((entity["id"].as_str(), above[0].log_time), (Some("second"), 1_000_000_000));
        assert_eq!(entity["lines"][0]["points"][1]["x"], 6.0);
        assert_eq!(entity["lines"][1]["points"].as_array().map(Vec::len), Some(4));
        assert_eq!(entity["spheres"][0]["pose"]["position"]["x"], 5.0);
        for (message, shot) in messages.iter().zip(&shots) {
            let schema = message.channel.schema.as_ref().expect("named");
            assert_eq!(schema.name, "foxglove.SceneUpdate");
            let scene: Value = serde_json::from_slice(&message.data).expect("JSON");
            let entity = &scene["entities"][0];
            assert_eq!(entity["id"], shot.name);
            let counts: Vec<usize> = entity["triangles"]
                .as_array()
                .expect("a list")
                .iter()
                .map(|list| list["points"].as_array().expect("a list").len() / 3)
                .collect();
            assert_eq!(counts, [2, 1, 1, 2, 2]);
            // The other body stands where the shot puts it.
            assert_eq!(entity["triangles"][2]["points"][0]["x"], 7.0);
        }
    }
}
