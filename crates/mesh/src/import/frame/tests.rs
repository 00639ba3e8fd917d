//! Every frame is a rotation and a factor, takes up to z and forward to x, and is exact in metres.

use super::*;

const NAMES: [&str; 6] = ["+x", "-x", "+y", "-y", "+z", "-z"];

fn axes() -> impl Iterator<Item = (Axis, Axis)> {
    let axis = |name: &&str| name.parse::<Axis>().expect("an axis");
    NAMES.iter().flat_map(move |up| NAMES.iter().map(move |forward| (axis(up), axis(forward))))
}

#[test]
fn every_frame_is_right_handed() {
    let mut count = 0;
    for (up, forward) in axes() {
        let frame = Frame::new(Format::Obj, "cm".parse().expect("a unit"), Some(up), Some(forward));
        let Ok(frame) = frame else {
            assert_eq!(up.index, forward.index);
            continue;
        };
        count += 1;
        assert_eq!(frame.point(up.vector()), [0.0, 0.0, 0.01]);
        assert_eq!(frame.point(forward.vector()), [0.01, 0.0, 0.0]);
        let [a, b, c] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|e| frame.point(e));
        let determinant = a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0])
            + a[2] * (b[0] * c[1] - b[1] * c[0]);
        assert!((determinant - 1e-6).abs() < 1e-18, "{frame}: {determinant}");
    }
    assert_eq!(count, 24);
}

#[test]
fn nothing_stated_is_the_formats_own() {
    let of =
        |format| Frame::new(format, LengthUnit::METRE, None, None).expect("orthogonal").to_string();
    assert_eq!(of(Format::Glb), "unit m, up +y, forward +z");
    assert_eq!(of(Format::Stl), "unit m, up +z, forward +x");
    let same = Frame::new(Format::Stl, LengthUnit::METRE, None, None).expect("orthogonal");
    let point = [f64::from(0.1_f32), -0.0, 1e-40];
    assert_eq!(same.point(point).map(f64::to_bits), point.map(f64::to_bits));
}

#[test]
fn names_are_read_and_others_refused_with_the_choice() {
    for name in NAMES {
        assert_eq!(name.parse::<Axis>().expect("an axis").to_string(), name);
    }
    assert_eq!("Y".parse::<Axis>(), "+y".parse());
    assert_eq!("0.0254".parse::<LengthUnit>().expect("a factor").to_string(), "inch");
    assert_eq!("3.5".parse::<LengthUnit>().expect("a factor").metres(), 3.5);
    for bad in ["", "km", "-1", "0", "nan", "inf", "1e300"] {
        assert!(bad.parse::<LengthUnit>().is_err(), "{bad}");
    }
    assert!("up".parse::<Axis>().is_err() && "".parse::<Axis>().is_err());
}
