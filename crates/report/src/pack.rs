//! Bodies compressed for a page: 16-bit coordinates, base64, thinned if too large.

use crate::shot::{Shot, ShotBody};
use serde::Serialize;

/// Maximum number of a body's triangles on a page, besides those that are hit.
pub(crate) const TRIANGLES_MAX: usize = 120_000;

/// A body for the page's script.
#[derive(Debug, Serialize)]
pub(crate) struct Packed {
    name: String,
    triangles: usize,
    /// Triangles in the body itself.
    of: usize,
    /// Metres per unit.
    scale: f64,
    /// Nine little-endian i16 per triangle, base64.
    data: String,
}

/// A shot for the page's script.
#[derive(Debug, Serialize)]
pub(crate) struct PackedShot {
    name: String,
    /// The candidate's number in the scene.
    course: Option<usize>,
    bodies: [usize; 2],
    parties: [String; 2],
    is_nearest: bool,
    rotation: [[f64; 3]; 3],
    translation: [f64; 3],
    hits: [Vec<u32>; 2],
    patch: Option<[[f64; 3]; 4]>,
    caption: String,
}

/// All bodies and shots; numbers of hits count the triangles that were kept.
/// Bodies of no shot have no triangles. `course_of` is the number of a candidate in the scene.
pub(crate) fn pack(
    bodies: &[ShotBody],
    shots: &[&Shot],
    course_of: impl Fn(&str) -> Option<usize>,
) -> (Vec<Packed>, Vec<PackedShot>) {
    let mut kept: Vec<Vec<u32>> = Vec::with_capacity(bodies.len());
    let mut packed = Vec::with_capacity(bodies.len());
    for (number, body) in bodies.iter().enumerate() {
        let mut is_hit = vec![false; body.corners.len()];
        for shot in shots {
            for (side, hits) in shot.hits.iter().enumerate() {
                if shot.bodies[side] == number {
                    for hit in hits {
                        if let Some(mark) = is_hit.get_mut(*hit as usize) {
                            *mark = true;
                        }
                    }
                }
            }
        }
        // Every n-th of the rest: enough to see the shape.
        let every = body.corners.len().div_ceil(TRIANGLES_MAX).max(1);
        let is_shown = shots.iter().any(|shot| shot.bodies.contains(&number));
        let count = if is_shown { body.corners.len() as u32 } else { 0 };
        let numbers =
            (0..count).filter(|at| is_hit[*at as usize] || (*at as usize).is_multiple_of(every));
        let numbers: Vec<u32> = numbers.collect();
        packed.push(packed_body(body, &numbers));
        kept.push(numbers);
    }
    let shots = shots.iter().map(|shot| PackedShot {
        name: shot.name.clone(),
        course: course_of(&shot.candidate),
        bodies: shot.bodies,
        parties: shot.parties.clone(),
        is_nearest: shot.is_nearest,
        rotation: shot.rotation,
        translation: shot.translation,
        hits: [0, 1].map(|side| {
            let numbers = kept.get(shot.bodies[side]).map_or(&[][..], Vec::as_slice);
            let place = |hit: &u32| numbers.binary_search(hit).ok().map(|at| at as u32);
            shot.hits[side].iter().filter_map(place).collect()
        }),
        patch: shot.patch.map(|patch| patch.corners()),
        caption: shot.caption.clone(),
    });
    (packed, shots.collect())
}

fn packed_body(body: &ShotBody, numbers: &[u32]) -> Packed {
    let greatest = body.corners.iter().flatten().flatten().fold(0.0_f32, |m, x| m.max(x.abs()));
    let scale = f64::from(greatest).max(1e-6) / 32_767.0;
    let mut bytes = Vec::with_capacity(numbers.len() * 18);
    for number in numbers {
        for x in body.corners[*number as usize].iter().flatten() {
            let unit = (f64::from(*x) / scale).round() as i16;
            bytes.extend(unit.to_le_bytes());
        }
    }
    Packed {
        name: body.name.clone(),
        triangles: numbers.len(),
        of: body.corners.len(),
        scale,
        data: base64(&bytes),
    }
}

/// Base64 (RFC 4648, section 4).
pub(crate) fn base64(bytes: &[u8]) -> String {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for chunk in bytes.chunks(3) {
        let byte = |at: usize| u32::from(chunk.get(at).copied().unwrap_or(0));
        let all = byte(0) << 16 | byte(1) << 8 | byte(2);
        for at in 0..4 {
            if at <= chunk.len() {
                text.push(LETTERS[(all >> (18 - 6 * at) & 63) as usize] as char);
            } else {
                text.push('=');
            }
        }
    }
    text
}

#[cfg(test)]
mod tests {
    //! Base64 by its test vectors; hits keep their triangles when bodies are thinned.

    use super::*;

    #[test]
    fn base64_gives_the_vectors_of_its_specification() {
        for (plain, text) in
            [("", ""), ("f", "Zg=="), ("fo", "Zm8="), ("foo", "Zm9v"), ("foobar", "Zm9vYmFy")]
        {
            assert_eq!(base64(plain.as_bytes()), text);
        }
    }

    #[test]
    fn a_thinned_body_keeps_what_is_hit() {
        let corners = |n: u32| [[n as f32, 0.0, 0.0], [n as f32, 1.0, 0.0], [n as f32, 0.0, 1.0]];
        let count = 3 * TRIANGLES_MAX as u32;
        let body = ShotBody { name: "b".into(), corners: (0..count).map(corners).collect() };
        let shot = Shot {
            name: "s".into(),
            candidate: "s".into(),
            bodies: [0, 0],
            parties: ["ego".into(), "other".into()],
            rotation: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            translation: [0.0; 3],
            hits: [vec![7, 3_001], vec![]],
            patch: None,
            caption: String::new(),
            is_nearest: false,
        };
        let (packed, shots) = pack(&[body], &[&shot], |_| None);
        assert!(packed[0].triangles <= TRIANGLES_MAX + 2 && packed[0].of == count as usize);
        // Triangles 0, 3, 6, 7, ...: the eighth is the fourth that was kept.
        assert_eq!(shots[0].hits[0][0], 3);
        assert_eq!(shots[0].hits[0].len(), 2);
    }
}
