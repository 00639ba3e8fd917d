//! What is left out of a search for crossings changes no bit of an overlap.

use super::*;
use geometry::rng::Rng;

impl Facing {
    /// The same, with every neighbour looked at, at every depth.
    fn in_full(mut self) -> Self {
        for beside in &mut self.beside {
            beside.rows.iter_mut().for_each(|row| row.meets = Depths::MAX);
            beside.neighbours.iter_mut().for_each(|neighbour| neighbour.meets = Depths::MAX);
        }
        self
    }
}

/// A star of so many corners about a point; on a grid its sides often coincide with others.
fn star(rng: &mut Rng, centre: [f64; 2], corners: u32, is_on_grid: bool) -> Vec<[f64; 2]> {
    let corner = |k: u32| {
        let (turn, far) = (f64::from(k) / f64::from(corners), 0.3 + 0.9 * rng.between(0.0, 1.0));
        let (sin, cos) = (turn * core::f64::consts::TAU).sin_cos();
        let p = [centre[0] + far * cos, centre[1] + far * sin];
        if is_on_grid { p.map(|x| (x * 4.0).round() / 4.0) } else { p }
    };
    (0..corners).map(corner).collect()
}

#[test]
fn what_is_not_looked_at_changes_no_bit() {
    let mut rng = Rng::new(7);
    let (mut overlaps, mut whole) = (0, 0);
    for round in 0..400 {
        let is_on_grid = round % 2 == 0;
        let mut band = |x: f64, y: f64| {
            let corners = 3 + rng.below(30) as u32;
            PlacedBand::new([0.0, 1.0], vec![star(&mut rng, [x, y], corners, is_on_grid)])
        };
        let (a, b) = (band(0.0, 0.0), band(1.5, 0.25));
        let depth_m = [0.9, 0.25, 0.0][round % 3];
        let Some(mut quick) = Facing::of(&a, &b, depth_m) else { continue };
        let mut full = Facing::of(&a, &b, depth_m).expect("as before").in_full();
        let mut struck: [[SmallVec<[Struck; 16]>; 2]; 2] = Default::default();
        for k in 0..CHORDS {
            let found = [quick.overlap(k, &mut struck[0]), full.overlap(k, &mut struck[1])];
            let bits = found.map(|found| {
                found.map(|o| {
                    [o.chord[0], o.chord[1], o.centre[0], o.centre[1], o.area_m2].map(f64::to_bits)
                })
            });
            assert_eq!(bits[0], bits[1], "round {round}, depth {k}");
            assert_eq!(struck[0], struck[1], "round {round}, depth {k}");
            overlaps += u32::from(bits[0].is_some());
            whole += quick.beside.iter().flat_map(|beside| &beside.rows).fold(0, |count, row| {
                count + u32::from(row.meets >> k & 1 == 0 && row.is_inside >> k & 1 == 1)
            });
        }
    }
    assert!(overlaps > 2_000 && whole > 500, "{overlaps} overlaps, {whole} edges inside");
}
