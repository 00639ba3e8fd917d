//! Poses come in bit for bit, and every fault is said with its place.

use super::*;
use proptest::prelude::*;

const GOOD: &str = "1 0 0 0\n0 1 0 0\n0 0 1 0\n0 -1 0 2.5\n1 0 0 -1e3\n0 0 1 0.25\n";

fn written(poses: &[Pose; 2], gap: &str, end: &str) -> String {
    let rows = poses.iter().flat_map(|pose| pose.rotation.iter().zip(pose.translation));
    rows.map(|([x, y, z], t)| format!("{x:e}{gap}{y}{gap}{z:?}{gap}{t}{end}")).collect()
}

fn pose() -> impl Strategy<Value = Pose> {
    let turn = -360.0..360.0;
    (turn.clone(), turn.clone(), turn, prop::array::uniform3(-1e6..1e6))
        .prop_map(|(yaw, pitch, roll, t)| Pose::from_degrees(yaw, pitch, roll, t))
}

proptest! {
    #[test]
    fn what_is_written_is_read(
        a in pose(), b in pose(),
        gap in prop::sample::select(vec![" ", "\t", "   "]),
        end in prop::sample::select(vec!["\n", "\r\n", " # R | t\n", "\n\n", "\n# A\n"]),
    ) {
        let poses = [a, b];
        let text = written(&poses, gap, end);
        prop_assert_eq!(parse("p", text.as_bytes()).expect("rigid"), poses);
    }

    #[test]
    fn no_bytes_make_it_panic(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        prop_assert!(parse("p", &bytes).is_err());
    }

    #[test]
    fn bent_text_is_refused_or_read(at in any::<prop::sample::Index>(), byte in any::<u8>()) {
        let mut bytes = GOOD.as_bytes().to_vec();
        let at = at.index(bytes.len());
        bytes[at] = byte;
        if let Err(failure) = parse("p", &bytes) {
            let is_placed = failure.what().starts_with("p:");
            prop_assert!(is_placed && failure.remedy().is_some(), "{failure}");
        }
    }
}

#[test]
fn every_fault_has_its_place() {
    let fault = |change: (&str, &str)| {
        assert!(GOOD.contains(change.0), "{change:?}");
        let text = GOOD.replacen(change.0, change.1, 1);
        let failure = parse("p", text.as_bytes()).expect_err(change.1);
        assert!(failure.remedy().is_some(), "{failure}");
        failure.what().to_owned()
    };
    for (change, said) in [
        (("2.5", "zwei"), "p:4:8: \"zwei\" is no number"),
        (("2.5", "nan"), "p:4:8: nan is not finite"),
        (("2.5", "1e999"), "p:4:8: 1e999 is not finite"),
        (("-1e3", "-1e10"), "p:5:7: -1e10 m is beyond 1e9 m"),
        (("2.5", "2,5"), "p:4:8: \"2,5\" is no number"),
        (("\n0 1 0 0", "\n\n  0 1 0 0 7"), "p:3:11: \"7\" is a fifth number, a row has four"),
        (("0 1 0 0", "0 1 #"), "p:2:4: the row ends after 2 of four numbers"),
        (("0 0 1 0.25\n", ""), "p:6:1: the text ends after 5 of the six rows of two poses"),
        (("0.25\n", "0.25\n 1 2 3 4"), "p:7:2: this is a seventh row, two poses have six"),
        (
            ("1 0 0 0", "1.001 0 0 0"),
            "p:1:1: the rotation of A is not rigid: RᵀR differs from the identity by 2.0e-3",
        ),
        (
            ("1 0 0 -1e3", "1 0 1e200 -1e3"),
            "p:4:1: the rotation of B is not rigid: RᵀR differs from the identity by inf",
        ),
        (
            ("0 0 1 0.25", "0 0 -1 0"),
            "p:4:1: the rotation of B mirrors the body: its determinant is -1",
        ),
    ] {
        assert_eq!(fault(change), said);
    }
    let failure = parse("p", b"1 0 0 0\n0 \xff").expect_err("bytes");
    assert_eq!(failure.what(), "p:2:3: this is not UTF-8 text");
    // Six decimals of rounding pass, a thousandth of a degree off does not matter to anybody.
    let rounded = GOOD.replacen("1 0 0 0\n", "0.9999997 0 0 0\n", 1);
    assert!(parse("p", rounded.as_bytes()).is_ok());
}

#[test]
fn a_pose_of_a_program_is_held_to_what_a_text_may_state() {
    let says = |pose: Pose| check(&pose).expect_err("refused").what().to_owned();
    let turned = Pose::from_degrees(20.0, 30.0, 40.0, [1.0, 2.0, 3.0]);
    assert_eq!(check(&turned), Ok(()));
    assert_eq!(says(Pose { translation: [0.0, f64::NAN, 0.0], ..turned }), "NaN is not finite");
    assert_eq!(says(Pose { translation: [2e9; 3], ..turned }), "2000000000 m is beyond 1e9 m");
    let mut mirrored = Pose::IDENTITY;
    mirrored.rotation[2][2] = -1.0;
    assert!(says(mirrored).contains("mirrors the body"));
    mirrored.rotation[2][2] = 1.01;
    assert!(says(mirrored).contains("is not rigid"));
}
