//! Sizes of things that everybody knows are recognised, turned and scaled ones are doubted.

use super::*;
use body::testing::mesh_of;

fn guessed(size: [f32; 3]) -> Guess {
    let [x, y, z] = size;
    guess(&mesh_of(vec![[[0.0; 3], [x, y, 0.0], [0.0, 0.0, z]]]))
}

#[test]
fn usual_sizes_are_recognised_without_doubt() {
    let known = [
        ([4.62, 2.01, 1.39], "a car"),
        ([5.33, 2.24, 1.91], "a car"),
        ([9.72, 2.47, 2.59], "a truck or bus"),
        ([2.2, 0.8, 1.6], "a motorcycle or bicycle"),
        ([0.37, 1.09, 1.78], "a person"),
        ([0.3, 0.3, 9.27], "a pole or tree"),
        ([0.6, 4.0, 0.8], "a wall or barrier"),
    ];
    for (size, name) in known {
        let guess = guessed(size);
        assert_eq!((guess.looks_like, guess.doubts.len()), (Some(name), 0), "{size:?}");
    }
    assert_eq!(guessed([4.62, 2.01, 1.39]).to_string(), "4.62 × 2.01 × 1.39 m: a car");
}

#[test]
fn turned_and_scaled_bodies_are_doubted_with_the_remedy() {
    let sideways = guessed([2.01, 4.62, 1.39]).doubts;
    assert!(sideways[0].contains("a car: forward"), "{sideways:?}");
    let lying = guessed([4.62, 1.39, 2.01]).doubts;
    assert_eq!(lying, ["it is taller than wide: check --up"]);
    let upright = guessed([1.39, 2.01, 4.62]).doubts;
    assert!(upright[0].contains("check --up and --forward"), "{upright:?}");
    let inches = guessed([181.9, 79.1, 54.7]).doubts;
    assert!(inches.iter().any(|doubt| doubt.contains("in inch instead of metres")), "{inches:?}");
    assert_eq!(guessed([1.26, 0.35, 1.26]).looks_like, None, "a wheel");
    assert_eq!(guessed([40.0, 40.0, 40.0]).looks_like, None);
    assert_eq!(guessed([40.0, 40.0, 40.0]).doubts.len(), 1);
}
