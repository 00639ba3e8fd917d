//! Possible readings of an unknown mesh: units and axes that make it look like something, as
//! suggestions for the user.
//!
//! Every unit is tried with every up axis, with the longer of the other two axes as forward. The
//! direction follows heuristics: the cabin of a car lies behind its middle (a pick-up's does not),
//! and a person's toes are ahead of the heels. These are only suggestions.

use super::guess::shape;
use super::{Format, LengthUnit};
use body::Mesh;
use serde::Serialize;

/// One way to read a mesh.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Reading {
    /// Name of the unit.
    pub unit: &'static str,
    /// Up axis of the file, as `--up` takes it.
    pub up: String,
    /// Forward axis of the file, as `--forward` takes it.
    pub forward: String,
    /// What it looks like.
    pub looks_like: &'static str,
    /// The resulting length, width and height (m).
    pub size_m: [f64; 3],
}

const AXES: [&str; 3] = ["x", "y", "z"];

/// Readings of a mesh in file coordinates, likeliest first: usual units and z up before others, but
/// y up before z for formats that define it; at most `most`.
#[must_use]
pub fn readings(mesh: &Mesh, format: Format, most: usize) -> Vec<Reading> {
    let size = mesh.size_m();
    let mut found = Vec::new();
    // Up axes in the outer loop, units in the inner one.
    let ups = if matches!(format, Format::Gltf | Format::Glb) { [1, 2, 0] } else { [2, 1, 0] };
    for up in ups {
        let [a, b] = [0, 1, 2].into_iter().filter(|axis| *axis != up).collect::<Vec<_>>()[..]
        else {
            continue;
        };
        for (unit, metres) in LengthUnit::NAMED {
            // A person is wider than deep; everything else is longer than wide.
            for [forward, side] in [[a, b], [b, a]] {
                let real = [forward, side, up].map(|axis| size[axis] * metres);
                let Some(looks_like) = shape(real) else { continue };
                let is_along = real[0] >= real[1];
                if is_along == (looks_like == "a person") {
                    continue;
                }
                let sign = if points_back(mesh, forward, up, looks_like) { "-" } else { "" };
                found.push(Reading {
                    unit,
                    up: AXES[up].to_owned(),
                    forward: format!("{sign}{}", AXES[forward]),
                    looks_like,
                    size_m: real,
                });
            }
        }
    }
    // If it is taller than wide, it is a car on its side.
    found.sort_by_key(|reading| {
        reading.looks_like == "a car" && reading.size_m[2] > reading.size_m[1]
    });
    found.truncate(most);
    found
}

/// Whether the front probably is at the lower end of an axis.
fn points_back(mesh: &Mesh, forward: usize, up: usize, looks_like: &str) -> bool {
    let points = || mesh.corners.iter().flatten();
    let ends = |axis: usize| {
        points().fold((f32::MAX, f32::MIN), |(l, h), p| (l.min(p[axis]), h.max(p[axis])))
    };
    let ((low, high), (back, front)) = (ends(up), ends(forward));
    let middle = 0.5 * (back + front);
    let mean = |from: f32, to: f32| {
        let band = (low + from * (high - low), low + to * (high - low));
        let inside = points().filter(|p| (band.0..=band.1).contains(&p[up]));
        let (sum, count) =
            inside.fold((0.0, 0.0), |(s, n), p| (s + f64::from(p[forward]), n + 1.0));
        if count > 0.0 { sum / count - f64::from(middle) } else { 0.0 }
    };
    match looks_like {
        "a car" => mean(0.75, 1.0) > 0.0,
        "a person" => mean(0.0, 0.04) < 0.0,
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    //! A generated body is recognised in any unit and orientation.

    use super::*;
    use body::Shape;
    use shapes::generate;

    /// The first suggestion for a body written in a unit, with forward and up along axes of the
    /// file.
    fn offered(mesh: &Mesh, per_metre: f32, axes: [(usize, f32); 3]) -> Option<Reading> {
        let mut written = mesh.clone();
        for corner in written.corners.iter_mut().flatten() {
            let mut point = [0.0; 3];
            for (value, (axis, sign)) in corner.iter().zip(axes) {
                point[axis] = sign * value * per_metre;
            }
            *corner = point;
        }
        readings(&written, Format::Obj, 4).into_iter().next()
    }

    #[test]
    fn cars_are_recognised_in_inches_facing_anywhere() {
        for shape in [Shape::Sedan, Shape::Suv] {
            let mesh = generate(shape, 4_000, 0).expect("a body");
            let inches = offered(&mesh, 39.37, [(1, -1.0), (0, 1.0), (2, 1.0)]).expect("a car");
            assert_eq!((inches.unit, inches.up.as_str()), ("inch", "z"), "{shape}");
            assert_eq!((inches.forward.as_str(), inches.looks_like), ("-y", "a car"), "{shape}");
        }
        let mesh = generate(Shape::Sedan, 4_000, 0).expect("a body");
        let metres = offered(&mesh, 1.0, [(0, 1.0), (1, 1.0), (2, 1.0)]).expect("a car");
        assert_eq!((metres.unit, metres.forward.as_str()), ("m", "x"));
    }

    #[test]
    fn what_looks_like_nothing_is_offered_nothing() {
        let corners = vec![[[0.0, 0.0, 0.0], [1e6, 0.0, 0.0], [0.0, 1e6, 1.0]]];
        let mesh = Mesh { corners, ..Mesh::default() };
        assert_eq!(readings(&mesh, Format::Obj, 4), []);
    }
}
