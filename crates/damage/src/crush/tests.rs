//! Crush against its own definition: energy and equal force.

use super::*;
use proptest::prelude::*;

/// Energy that a crush absorbs, term by term as published.
fn absorbed(s: Stiffness, c: f64, w: f64) -> f64 {
    w * (s.a_n_m * c + 0.5 * s.b_n_m2 * c * c + s.a_n_m * s.a_n_m / (2.0 * s.b_n_m2))
}

#[test]
fn a_wall_does_not_yield_and_an_unknown_body_is_not_guessed() {
    let car = Stiffness { a_n_m: 50_000.0, b_n_m2: 600_000.0 };
    let energy = absorbed(car, 0.5, 1.6);
    let of =
        |other, depth| Crush::of([Some(Some(car)), other], energy, 1.6, Interval::exactly(depth));
    let wall = of(None, 0.45).expect("both are known");
    assert!((wall.crush_m[0] - 0.5).abs() < 1e-12 && wall.crush_m[1] == 0.0, "{wall:?}");
    assert!(!wall.mismatch && of(None, 0.2).expect("known").mismatch);
    assert_eq!(of(Some(None), 0.45), None);
    assert_eq!(Crush::of([None, None], energy, 1.6, Interval::ZERO), None);
    assert_eq!(Crush::of([Some(Some(car)), None], energy, 0.0, Interval::ZERO), None);
}

proptest! {
    /// Where both yield, forces are equal and the energy is all there.
    #[test]
    fn both_bodies_press_with_equal_force(
        a in [0.0..1e5_f64, 0.0..1e5_f64],
        b in [2e5..2e6_f64, 2e5..2e6_f64],
        energy in 1e3..5e5_f64,
        width in 0.2..2.0_f64,
    ) {
        let s = [0, 1].map(|i| Stiffness { a_n_m: a[i], b_n_m2: b[i] });
        let crush = Crush::of(s.map(|s| Some(Some(s))), energy, width, Interval::ZERO);
        let [c, d] = crush.ok_or_else(|| TestCaseError::fail("known"))?.crush_m;
        prop_assume!(c > 0.0 && d > 0.0);
        let (f, g) = (a[0] + b[0] * c, a[1] + b[1] * d);
        prop_assert!((f - g).abs() <= 1e-9 * f);
        let sum = absorbed(s[0], c, width) + absorbed(s[1], d, width);
        prop_assert!((sum - energy).abs() <= 1e-9 * energy);
    }
}
