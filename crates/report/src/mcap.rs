//! Contacts as an MCAP file for Foxglove and Lichtblick (mcap.dev; Foxglove schema
//! `foxglove.SceneUpdate` in JSON): one contact each second, each replacing the one before.

use crate::glb::COLOURS;
use crate::shot::{Shot, ShotBody};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::io::Cursor;

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
pub fn mcap(shots: &[&Shot], bodies: &[ShotBody]) -> Result<Vec<u8>, McapError> {
    let options = mcap::WriteOptions::new().compression(None).library("trolley");
    let mut file = Cursor::new(Vec::new());
    let mut writer = options.create(&mut file)?;
    let schema = json!({"title": "foxglove.SceneUpdate", "type": "object"}).to_string();
    let schema = writer.add_schema("foxglove.SceneUpdate", "jsonschema", schema.as_bytes())?;
    let channel = writer.add_channel(schema, "/crash", "json", &BTreeMap::new())?;
    for (number, shot) in shots.iter().enumerate() {
        let head = mcap::records::MessageHeader {
            channel_id: channel,
            sequence: number as u32,
            log_time: number as u64 * 1_000_000_000,
            publish_time: number as u64 * 1_000_000_000,
        };
        writer.write_to_known_channel(&head, scene(shot, bodies, number).to_string().as_bytes())?;
    }
    let _summary = writer.finish()?;
    drop(writer);
    Ok(file.into_inner())
}

/// Deletes everything, then adds both bodies, with hit triangles in red.
fn scene(shot: &Shot, bodies: &[ShotBody], number: usize) -> Value {
    let time = json!({"sec": number, "nsec": 0});
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
    let text = json!({
        "pose": pose(), "billboard": true, "font_size": 14, "scale_invariant": true,
        "color": {"r": 0, "g": 0, "b": 0, "a": 1},
        "text": format!("{}: {}", shot.name, shot.caption),
    });
    json!({
        "deletions": [{"timestamp": time, "type": 1, "id": ""}],
        "entities": [{
            "timestamp": time, "frame_id": "ego", "id": shot.name,
            "lifetime": {"sec": 0, "nsec": 0}, "frame_locked": false, "metadata": [],
            "arrows": [], "cubes": [], "spheres": [], "cylinders": [], "lines": [],
            "triangles": triangles, "texts": [text], "models": [],
        }],
    })
}

fn pose() -> Value {
    json!({
        "position": {"x": 0, "y": 0, "z": 0}, "orientation": {"x": 0, "y": 0, "z": 0, "w": 1},
    })
}

fn list(points: Vec<Value>, colour: [u8; 4]) -> Value {
    let [r, g, b, a] = colour.map(|part| f64::from(part) / 255.0);
    json!({
        "pose": pose(), "points": points, "color": {"r": r, "g": g, "b": b, "a": a},
        "colors": [], "indices": [],
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
            rotation: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            translation: [2.0, 0.0, 0.0],
            hits: [vec![1], vec![0, 2]],
            patch: Some(ShotPatch {
                centre_m: [0.0; 3],
                normal: [1.0, 0.0, 0.0],
                size_m: [1.0, 1.0],
            }),
            caption: "they touch".into(),
        };
        let shots = [shot("first"), shot("second")];
        let file = mcap(&[&shots[0], &shots[1]], &[body(0.0), body(5.0)]).expect("written");
        let messages: Result<Vec<_>, _> = mcap::MessageStream::new(&file).expect("read").collect();
        let messages = messages.expect("sound");
        assert_eq!(messages.len(), 2);
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
