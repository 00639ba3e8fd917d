//! Directions turn what is drawn without stretching it, and lay the first coordinate along what
//! decides whether bodies meet.

use super::*;
use geometry::rng::Rng;

fn scene(parties: &str, candidates: &[&str]) -> Scenario {
    let mut text = format!(
        "schema = \"trolley.scenario/2\"\nname = \"directions\"\nhorizon_s = 4\n[parties.ego]\n\
         generate = {{ shape = \"sedan\", triangles = 600 }}\n{parties}"
    );
    for (number, motion) in candidates.iter().enumerate() {
        text += &format!("[[candidates]]\nname = \"{number}\"\n{motion}\n");
    }
    Scenario::parse("directions.toml", &text).unwrap_or_else(|error| panic!("{error}"))
}

fn car(name: &str, motion: &str) -> String {
    format!("[parties.{name}]\ngenerate = {{ shape = \"sedan\", triangles = 600 }}\n{motion}\n")
}

const STRAIGHT: &str = "state = { position_m = [0, 0, 0], speed_m_s = 12 }";
const SLOWER: &str = "state = { position_m = [0, 0, 0], speed_m_s = 9 }";
const CROSSES: &str = "state = { position_m = [30, -25, 0], yaw_deg = 90, speed_m_s = 10 }";
const COMES: &str = "state = { position_m = [60, 1, 0], yaw_deg = 180, speed_m_s = 8 }";

/// The columns of the transformation.
fn columns(directions: &Directions, count: usize) -> Vec<Vec<f64>> {
    let column = |axis: usize| {
        let mut vector = vec![0.0; count];
        vector[axis] = 1.0;
        directions.apply(&mut vector);
        vector
    };
    (0..count).map(column).collect()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[test]
fn turning_keeps_lengths_and_right_angles() {
    let parties = car("a", CROSSES) + &car("b", COMES);
    let directions = Directions::new(&scene(&parties, &[STRAIGHT, SLOWER]));
    assert!(!directions.reflections.is_empty());
    let columns = columns(&directions, 12);
    for (i, a) in columns.iter().enumerate() {
        for (j, b) in columns.iter().enumerate() {
            let wanted = f64::from(u8::from(i == j));
            assert!((dot(a, b) - wanted).abs() < 1e-12, "{i} {j}: {}", dot(a, b));
        }
    }
}

/// With random gradients, the first column is the principal component of a dense oracle, and each
/// explains no more than the one before.
#[test]
fn columns_are_principal_components() {
    let mut rng = Rng::new(34);
    let count = EGO_NORMALS + 2 * OF_OTHER_NORMALS;
    for _ in 0..50 {
        let mut any = || rng.between(-1.0, 1.0);
        let gradients: Vec<Gradient> = (0..20)
            .map(|number| Gradient {
                ego: [3.0 * any(), any(), 0.2 * any()],
                other: number % 2,
                of_other: [any(), 0.5 * any(), 0.1 * any()],
            })
            .collect();
        let explained = |vector: &[f64]| -> f64 {
            gradients.iter().map(|gradient| gradient.dot(vector) * gradient.dot(vector)).sum()
        };
        let mut found: Vec<Vec<f64>> = Vec::new();
        while let Some((direction, _)) = next_direction(&gradients, &found, count) {
            assert!((dot(&direction, &direction) - 1.0).abs() < 1e-12);
            assert!(found.iter().all(|before| dot(before, &direction).abs() < 1e-9));
            found.push(direction);
            if found.len() == 3 {
                break;
            }
        }
        // No coordinate axis and no random direction explains more than the first.
        for _ in 0..200 {
            let mut other: Vec<f64> = (0..count).map(|_| rng.between(-1.0, 1.0)).collect();
            unit(&mut other, &[]).expect("a vector");
            assert!(explained(&other) <= 1.01 * explained(&found[0]));
        }
        let mut directions = Directions::default();
        for (axis, direction) in found.iter().enumerate() {
            directions.add(axis, direction);
        }
        for (column, direction) in columns(&directions, count).iter().zip(&found) {
            assert!(column.iter().zip(direction).all(|(a, b)| (a - b).abs() < 1e-9));
        }
    }
}

/// Two cars cross: the lead with which one passes before the other is what the first coordinate
/// draws, whatever the other coordinates are.
#[test]
fn the_first_coordinate_says_who_is_first_at_a_crossing() {
    let scene = scene(&car("a", CROSSES), &[STRAIGHT]);
    let count = EGO_NORMALS + OF_OTHER_NORMALS;
    let first = columns(&Directions::new(&scene), count).swap_remove(0);
    // Both arrive after 2.5 s; by how much each is ahead there, in seconds per standard deviation.
    let ego = [0.0, 0.05 * 2.5, 0.3 / 12.0, 0.0];
    let other = [-0.1 * 2.5, 0.0, -0.3 / 10.0, 0.0];
    // Lateral offsets move the place at which they cross.
    let ego_aside = [0.2 / 10.0, 0.0, 0.0, 0.0];
    let other_aside = [0.0, 0.2 / 12.0, 0.0, 0.0];
    let lead: Vec<f64> = ego
        .iter()
        .zip(ego_aside)
        .map(|(a, b)| a - b)
        .chain(other.iter().zip(other_aside).map(|(a, b)| a - b))
        .collect();
    let cosine = dot(&first, &lead) / dot(&lead, &lead).sqrt();
    assert!(cosine.abs() > 0.97, "{cosine}: {first:?} {lead:?}");
}

#[test]
fn what_cannot_meet_is_drawn_as_it_was() {
    let far = "place = { position_m = [0, 400, 0] }";
    let directions = Directions::new(&scene(&car("a", far), &[STRAIGHT]));
    assert_eq!(directions, Directions::default());
}
