//! A triangle is where it is, nearer ones hide farther ones, hits are red.

use super::*;
use crate::glb::tests::shot;

fn colours(camera: Camera) -> Vec<[f64; 3]> {
    let (shot, bodies) = shot();
    draw(&shot, &bodies, camera, [160, 120]).0
}

/// Whether a pixel has one of the four colours, by its hue; what is hit, by its red.
fn is_like(pixel: [f64; 3], colour: [u8; 4]) -> bool {
    if colour == COLOURS[2] {
        return pixel[0] > 150.0 && pixel[0] > 1.7 * pixel[1] && pixel[0] > 1.7 * pixel[2];
    }
    let scale = pixel[0] / f64::from(colour[0]);
    scale <= 1.001 && (0..3).all(|c| (pixel[c] - scale * f64::from(colour[c])).abs() < 1.0)
}

#[test]
fn both_bodies_hits_and_patch_are_seen() {
    let pixels = colours(Camera::Corner);
    for (what, colour) in ["ego", "other is hit", "patch"].into_iter().zip([0, 2, 3]) {
        let seen = pixels.iter().filter(|pixel| is_like(**pixel, COLOURS[colour])).count();
        assert!(seen > 20, "{what}: {seen} samples");
    }
    assert!(pixels[0] == SKY && pixels[pixels.len() - 1] == SKY);
}

#[test]
fn the_nearer_triangle_hides_the_farther() {
    let size = [40, 40];
    let mut seen = vec![(f64::INFINITY, 0); 1_600];
    let square = |depth: f64| [[0.0, 0.0, depth], [40.0, 0.0, depth], [0.0, 40.0, depth]];
    for (name, depth) in [(1, 5.0), (2, 3.0), (3, 4.0)] {
        fill(square(depth), size, |at, depth| {
            if depth < seen[at].0 {
                seen[at] = (depth, name);
            }
        });
    }
    assert_eq!(seen[10 * 40 + 10].1, 2);
    assert!((seen[10 * 40 + 10].0 - 3.0).abs() < 1e-9);
    assert_eq!(seen[39 * 40 + 39].1, 0, "outside");
}

#[test]
fn a_still_is_a_png_of_the_stated_size() {
    let (shot, bodies) = shot();
    let file = still(&shot, &bodies, Camera::Above, [64, 48]).expect("drawn");
    let reader = png::Decoder::new(std::io::Cursor::new(file)).read_info().expect("PNG");
    assert_eq!((reader.info().width, reader.info().height), (64, 48));
}
