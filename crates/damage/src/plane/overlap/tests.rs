//! What is left out of a search for crossings changes no bit of an overlap.

use super::beside::Depths;
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

/// What is left out before a root or a quotient is what these would leave out.
#[test]
fn crossings_are_those_of_the_plain_formulas() {
    let mut rng = Rng::new(5);
    let (mut crossed, mut parallel) = (0, 0);
    for round in 0..200_000 {
        let is_on_grid = round % 2 == 0;
        let mut vector = || {
            let [x, y] = [0, 1].map(|_| rng.between(-1.0, 1.0));
            [x, y].map(|x| if is_on_grid { (x * 3.0).round() / 3.0 } else { x })
        };
        let (d, mut e, w) = (vector(), vector(), vector());
        if round % 5 == 0 {
            e = [2.0 * d[0], 2.0 * d[1] + 10.0_f64.powi(-8 - round % 10)];
        }
        let across = cross(d, e);
        let is_crossing = across.abs() > 1e-12 * (dot(d, d) * dot(e, e)).sqrt();
        assert_eq!(are_parallel(d, e), !is_crossing, "{d:?} {e:?}");
        let (s, t) = (cross(w, e) / across, cross(w, d) / across);
        let is_within = (-1e-9..=1.0 + 1e-9).contains(&t) && s > 0.0 && s < 1.0;
        assert_eq!(crossing(d, e, w), is_within.then_some(s), "{d:?} {e:?} {w:?}");
        crossed += u32::from(is_within);
        parallel += u32::from(!is_crossing);
    }
    assert!(crossed > 10_000 && parallel > 10_000, "{crossed} {parallel}");
}
