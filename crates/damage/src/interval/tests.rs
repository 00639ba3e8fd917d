//! Laws of intervals.

use super::*;
use proptest::prelude::*;

#[test]
fn distance_of_overlapping_intervals_reaches_zero() {
    let apart = Interval::new(0.1, 0.3).distance(Interval::new(0.2, 0.5));
    assert!(apart.lo() == 0.0 && (apart.hi() - 0.4).abs() < 1e-12);
}

#[test]
fn no_end_is_nan_or_negative_zero() {
    assert_eq!(Interval::new(-0.0, 0.0).lo().to_bits(), 0);
    let lost = Interval::new(f64::NAN, 1.0);
    assert!(lost.contains(-1e300) && !lost.contains(2.0));
    assert!(Range::new(0.0, f64::NAN).high().is_infinite());
}

proptest! {
    /// Against values picked from both intervals.
    #[test]
    fn distance_holds_every_distance_and_nothing_more(
        a in -2.0..2.0_f64,
        b in 0.0..2.0_f64,
        c in -2.0..2.0_f64,
        d in 0.0..2.0_f64,
    ) {
        let (x, y) = (Interval::new(a, a + b), Interval::new(c, c + d));
        let distance = x.distance(y);
        let mut seen = Interval::exactly((a - c).abs());
        for i in 0..=20 {
            for j in 0..=20 {
                let p = a + b * f64::from(i) / 20.0;
                let q = c + d * f64::from(j) / 20.0;
                seen = seen.hull(Interval::exactly((p - q).abs()));
            }
        }
        prop_assert!(distance.lo() <= seen.lo() + 1e-12 && seen.hi() <= distance.hi() + 1e-12);
        prop_assert!(seen.lo() - distance.lo() <= 0.11 && distance.hi() - seen.hi() <= 1e-12);
    }
}
