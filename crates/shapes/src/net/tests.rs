//! Invariants of the weights: a partition of one, never negative, smooth where the net is round.

use super::Axis;
use proptest::prelude::*;

/// Weights as one number per control point.
fn spread(axis: &Axis, p: f64, slopes: bool) -> Vec<f64> {
    let weights = axis.weights(p);
    let mut all = vec![0.0; axis.round.len()];
    for (at, (value, slope)) in weights.at.iter().zip(weights.value.iter().zip(weights.slope)) {
        all[*at] += if slopes { slope } else { *value };
    }
    all
}

fn axes() -> impl Strategy<Value = Axis> {
    (prop::collection::vec(0.0..=1.0, 3..9), any::<bool>())
        .prop_map(|(round, closed)| Axis::new(round, closed))
}

proptest! {
    #[test]
    fn weights_are_a_partition_of_one(axis in axes(), share in 0.0..=1.0) {
        let weights = spread(&axis, share * axis.end(), false);
        prop_assert!(weights.iter().all(|w| *w >= 0.0));
        prop_assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn the_curve_has_no_gap_and_slopes_are_its_derivative(axis in axes(), share in 0.001..0.999) {
        let p = share * axis.end();
        let h = 1e-6;
        let (before, after) = (spread(&axis, p - h, false), spread(&axis, p + h, false));
        let slopes = (spread(&axis, p - h, true), spread(&axis, p + h, true));
        for k in 0..before.len() {
            prop_assert!((after[k] - before[k]).abs() < 5.0 * h);
            // Away from sharp corners, where the slope jumps, it is the difference quotient.
            if (slopes.0[k] - slopes.1[k]).abs() < 1e-3 {
                let quotient = (after[k] - before[k]) / (2.0 * h);
                prop_assert!((quotient - slopes.0[k]).abs() < 1e-3);
            }
        }
    }

    #[test]
    fn a_closed_axis_repeats(round in prop::collection::vec(0.0..=1.0, 3..9), p in 0.0..9.0) {
        let axis = Axis::new(round, true);
        let (once, again) = (spread(&axis, p, false), spread(&axis, p + axis.end(), false));
        prop_assert!(once.iter().zip(&again).all(|(a, b)| (a - b).abs() < 1e-9));
    }
}
