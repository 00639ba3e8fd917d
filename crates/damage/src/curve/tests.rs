//! Laws of curves.

use super::*;
use proptest::prelude::*;

fn curve(unit: CurveUnit, a: f64, b: f64) -> Curve {
    let empty = String::new;
    Curve {
        id: empty().into(),
        outcome: Level::Mais3,
        unit,
        a,
        b,
        front: None,
        valid: [0.0, 1.0],
        source: empty(),
        year: 2000,
        sample: empty(),
        origin: empty(),
        note: empty(),
    }
}

#[test]
fn units_are_converted_into_the_curves_own() {
    assert!((CurveUnit::MilesPerHour.of(12.0) - 26.8432).abs() < 1e-4);
    assert!((CurveUnit::KilometresPerHour.of(10.0) - 36.0).abs() < 1e-12);
    for unit in [CurveUnit::MetresPerSecond, CurveUnit::KilometresPerHour, CurveUnit::MilesPerHour]
    {
        assert!((unit.of(7.0) * unit.metres_per_second() - 7.0).abs() < 1e-12);
    }
}

proptest! {
    /// The published form, anchored by hand; the risk at 0 is 0, and nothing ever falls.
    #[test]
    fn risk_is_the_anchored_logistic(
        a in -9.0..-1.0_f64,
        b in 0.01..0.5_f64,
        v in 0.0..80.0_f64,
        more in 0.0..5.0_f64,
    ) {
        let curve = curve(CurveUnit::MetresPerSecond, a, b);
        let p = |x: f64| 1.0 / (1.0 + (-(a + b * x)).exp());
        let expected = (p(v) - p(0.0)) / (1.0 - p(0.0));
        prop_assert!((curve.risk(Dose::at(v)) - expected).abs() < 1e-12);
        prop_assert_eq!(curve.risk(Dose::at(0.0)).to_bits(), 0);
        prop_assert!(curve.risk(Dose::at(v + more)) >= curve.risk(Dose::at(v)));
        prop_assert!((0.0..=1.0).contains(&curve.risk(Dose::at(v))));
    }

    /// With a term for tall fronts: still anchored, rising with speed and with height.
    #[test]
    fn a_tall_front_only_adds(
        v in 0.0..40.0_f64,
        more in 0.0..5.0_f64,
        front_m in 0.3..1.3_f64,
        taller in 0.0..0.5_f64,
    ) {
        let term = FrontTerm { from_cm: 75.0, per_cm: 0.039, per_cm_and_unit: 0.002, at: 42.79 };
        let curve =
            Curve { front: Some(term), ..curve(CurveUnit::KilometresPerHour, -4.442, 0.078) };
        let risk = |speed_m_s: f64, front_m: f64| curve.risk(Dose { speed_m_s, front_m });
        prop_assert_eq!(risk(0.0, front_m).to_bits(), 0);
        prop_assert!(risk(v + more, front_m) >= risk(v, front_m));
        prop_assert!(risk(v, front_m + taller) >= risk(v, front_m));
        prop_assert!(risk(v, 0.75) == risk(v, 0.0));
    }
}
