//! A shot as glTF 2.0, binary (Khronos: glTF 2.0 Specification, 2021): both bodies with damage as
//! vertex colours, and the patch.

use crate::shot::{Shot, ShotBody};
use serde_json::{Value, json};

/// Colours (RGBA): the ego, the other, hit triangles, the patch.
pub(crate) const COLOURS: [[u8; 4]; 4] =
    [[126, 152, 190, 255], [190, 178, 150, 255], [214, 40, 40, 255], [255, 200, 0, 255]];

/// The file.
#[must_use]
pub fn glb(shot: &Shot, bodies: &[ShotBody]) -> Vec<u8> {
    let mut binary: Vec<u8> = Vec::new();
    let (mut views, mut accessors) = (Vec::new(), Vec::new());
    let (mut meshes, mut nodes): (Vec<Value>, Vec<Value>) = (Vec::new(), Vec::new());
    let mut add = |name: &str, points: &[[f64; 3]], colours: &[[u8; 4]]| {
        let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
        let start = binary.len();
        for point in points {
            // glTF is y up and looks along +z: x forward becomes z, y left becomes x.
            let point = [point[1], point[2], point[0]].map(|x| x as f32);
            for axis in 0..3 {
                low[axis] = low[axis].min(point[axis]);
                high[axis] = high[axis].max(point[axis]);
                binary.extend(point[axis].to_le_bytes());
            }
        }
        views.push(json!({"buffer": 0, "byteOffset": start, "byteLength": binary.len() - start,
            "target": 34962}));
        accessors.push(json!({"bufferView": views.len() - 1, "componentType": 5126,
            "count": points.len(), "type": "VEC3", "min": low, "max": high}));
        let start = binary.len();
        binary.extend(colours.iter().flatten());
        views.push(json!({"buffer": 0, "byteOffset": start, "byteLength": binary.len() - start,
            "target": 34962}));
        accessors.push(json!({"bufferView": views.len() - 1, "componentType": 5121,
            "count": colours.len(), "type": "VEC4", "normalized": true}));
        meshes.push(json!({"name": name, "primitives": [{"material": 0,
            "attributes": {"POSITION": accessors.len() - 2, "COLOR_0": accessors.len() - 1}}]}));
        nodes.push(json!({"name": name, "mesh": meshes.len() - 1}));
    };
    for (side, number) in shot.bodies.into_iter().enumerate() {
        let Some(body) = bodies.get(number).filter(|body| !body.corners.is_empty()) else {
            continue;
        };
        let mut of_triangle = vec![COLOURS[side]; body.corners.len()];
        for hit in &shot.hits[side] {
            if let Some(colour) = of_triangle.get_mut(*hit as usize) {
                *colour = COLOURS[2];
            }
        }
        let points: Vec<[f64; 3]> =
            body.corners.iter().flatten().map(|corner| shot.place(*corner, side == 1)).collect();
        let colours: Vec<[u8; 4]> = of_triangle.into_iter().flat_map(|c| [c; 3]).collect();
        add(&body.name, &points, &colours);
    }
    if let Some(patch) = shot.patch {
        let [a, b, c, d] = patch.corners();
        add("contact patch", &[a, b, c, a, c, d], &[COLOURS[3]; 6]);
    }
    let all: Vec<usize> = (0..nodes.len()).collect();
    let document = json!({
        "asset": {"version": "2.0", "generator": "trolley"},
        "scene": 0,
        "scenes": [{"name": shot.name, "nodes": all}],
        "nodes": nodes,
        "meshes": meshes,
        "materials": [{"name": "damage", "doubleSided": true, "pbrMetallicRoughness":
            {"baseColorFactor": [1.0, 1.0, 1.0, 1.0], "metallicFactor": 0.0,
             "roughnessFactor": 0.9}}],
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{"byteLength": binary.len()}],
    });
    let mut text = document.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    binary.resize(binary.len().next_multiple_of(4), 0);
    let word = |value: usize| (value as u32).to_le_bytes();
    let total = 12 + 8 + text.len() + 8 + binary.len();
    let mut file = Vec::with_capacity(total);
    file.extend(b"glTF");
    file.extend(word(2));
    file.extend(word(total));
    file.extend(word(text.len()));
    file.extend(b"JSON");
    file.extend(text);
    file.extend(word(binary.len()));
    file.extend(b"BIN\0");
    file.extend(binary);
    file
}

#[cfg(test)]
pub(crate) mod tests;
