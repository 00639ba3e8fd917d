//! Values are checked, alone and against the kind of body.

use super::*;

fn range(low: f64, nominal: f64, high: f64) -> Option<Setting> {
    Some(Setting { low, nominal, high })
}

#[test]
fn nothing_fits_every_kind() {
    for kind in BodyKind::ALL {
        assert_eq!(OwnParameters::default().check(kind), Ok(()));
    }
    assert!(OwnParameters::default().is_empty());
    assert!(!OwnParameters { mass_share: Some(0.0), ..OwnParameters::default() }.is_empty());
}

#[test]
fn what_is_unsound_is_refused() {
    use BodyKind::{Sedan, Wall};
    let none = OwnParameters::default();
    let cases = [
        (Sedan, OwnParameters { restitution: range(0.2, 0.1, 0.3), ..none }, "restitution"),
        (Sedan, OwnParameters { restitution: range(0.0, 0.1, 1.1), ..none }, "≤ 1"),
        (Sedan, OwnParameters { friction: range(0.0, f64::NAN, 1.0), ..none }, "friction"),
        (Sedan, OwnParameters { mass_share: Some(1.0), ..none }, "mass_share"),
        (Sedan, OwnParameters { gyration_share: Some(-0.1), ..none }, "gyration_share"),
        (Sedan, OwnParameters { face_tangential_share: Some(0.1), ..none }, "no long flat"),
        (Wall, OwnParameters { mass_share: Some(0.1), ..none }, "fixed to the ground"),
    ];
    for (kind, own, expected) in cases {
        let fault = own.check(kind).expect_err(expected);
        assert!(fault.contains(expected), "{fault}");
    }
}
