//! The written file parses again: lengths, counts, colours.

use super::*;
use crate::shot::ShotPatch;
use serde_json::from_slice;

/// Two triangles ahead of each other; of the second body the only one is hit.
pub(crate) fn shot() -> (Shot, Vec<ShotBody>) {
    let plate = |x: f32| [[x, -1.0, 0.0], [x, 1.0, 0.0], [x, 0.0, 1.5]];
    let bodies = vec![
        ShotBody { name: "ego".into(), corners: vec![plate(0.0), plate(1.0)] },
        ShotBody { name: "other <b>".into(), corners: vec![plate(0.0)] },
    ];
    let shot = Shot {
        name: "a \"way\" </script>".into(),
        candidate: "a way".into(),
        bodies: [0, 1],
        parties: ["ego".into(), "other".into()],
        rotation: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        translation: [2.0, 0.0, 0.0],
        hits: [vec![1], vec![0]],
        patch: Some(ShotPatch {
            centre_m: [1.5, 0.0, 0.5],
            normal: [1.0, 0.0, 0.0],
            size_m: [1.0, 0.6],
        }),
        caption: "a caption".into(),
        is_nearest: false,
    };
    (shot, bodies)
}

#[test]
fn lengths_counts_and_colours_are_right() {
    let (shot, bodies) = shot();
    let file = glb(&shot, &bodies);
    let word =
        |at: usize| u32::from_le_bytes(file[at..at + 4].try_into().expect("four bytes")) as usize;
    assert_eq!((&file[..4], word(4), word(8)), (&b"glTF"[..], 2, file.len()));
    let text = word(12);
    assert_eq!((&file[16..20], text % 4), (&b"JSON"[..], 0));
    let document: Value = from_slice(&file[20..20 + text]).expect("JSON");
    let binary = &file[20 + text + 8..];
    assert_eq!(word(20 + text), binary.len());
    assert_eq!(document["nodes"].as_array().expect("nodes").len(), 3);
    let accessors = document["accessors"].as_array().expect("accessors");
    assert_eq!(accessors[0]["count"], 6);
    assert_eq!(accessors[2]["count"], 3);
    // The other stands two metres ahead: x forward is z in glTF.
    assert_eq!(accessors[2]["min"][2], 2.0);
    let colours = document["bufferViews"][1]["byteOffset"].as_u64().expect("an offset") as usize;
    assert_eq!(binary[colours..colours + 4], COLOURS[0]);
    assert_eq!(binary[colours + 12..colours + 16], COLOURS[2]);
    for view in document["bufferViews"].as_array().expect("views") {
        let end = view["byteOffset"].as_u64().expect("a number")
            + view["byteLength"].as_u64().expect("a number");
        assert!(end as usize <= binary.len());
    }
}
