//! Possible readings of an unknown mesh: units and axes that make it look like something, as
//! suggestions for the user.
//!
//! Every unit is tried with every up axis, with the longer of the other two axes as forward. The
//! direction follows heuristics: the cabin of a car lies behind its middle (a pick-up's does not),
//! and a person's toes are ahead of the heels. These are only suggestions. What a file states of
//! its unit and up axis is believed, unless it would look like nothing then.

use super::guess::shape;
use super::{Axis, Format, Frame, LengthUnit, StatedFrame};
use body::{BodyKind, Mesh, defaults};
use serde::Serialize;

/// One way to read a mesh.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Reading {
    /// The unit, as `--unit` takes it.
    pub unit: String,
    /// Up axis of the file, as `--up` takes it.
    pub up: String,
    /// Forward axis of the file, as `--forward` takes it.
    pub forward: String,
    /// What it looks like.
    pub looks_like: &'static str,
    /// The kind of body that this is, as `--kind` takes it; of several the likeliest.
    pub kind: BodyKind,
    /// The mass of such a body unless another one is stated (kg); `None`: fixed to the ground.
    pub mass_kg: Option<f64>,
    /// The resulting length, width and height (m).
    pub size_m: [f64; 3],
}

/// The kind that goes by a name of `shape`.
#[must_use]
pub fn likely_kind(looks_like: &str) -> Option<BodyKind> {
    Some(match looks_like {
        "a car" => BodyKind::Sedan,
        "a truck or bus" => BodyKind::Truck,
        "a motorcycle or bicycle" => BodyKind::Motorcycle,
        "a person" => BodyKind::Pedestrian,
        "a pole or tree" => BodyKind::Pole,
        "a wall or barrier" => BodyKind::Wall,
        BUILDING => BodyKind::Building,
        _ => return None,
    })
}

/// What a body is taken for that is as large as a house in a unit that houses are drawn in.
const BUILDING: &str = "a building";

/// As [`shape`], and buildings: these have any proportions, so that they are offered last, and
/// never take the doubt from a body of which the unit is wrong.
fn offered_shape(size: [f64; 3], metres: f64) -> Option<&'static str> {
    let is_building = || {
        let [length, width, height] = size;
        let is_drawn = [1.0, 0.01, 0.001].contains(&metres);
        let is_wide = |x: f64| (4.0..=200.0).contains(&x);
        is_drawn && is_wide(length) && is_wide(width) && (2.5..=100.0).contains(&height)
    };
    shape(size).or_else(|| is_building().then_some(BUILDING))
}

const AXES: [&str; 3] = ["x", "y", "z"];

/// Readings of a mesh in file coordinates, likeliest first: usual units and z up before others, but
/// y up before z for formats that define it; at most `most`. Of a file that states its frame, the
/// readings in that, if there are any.
#[must_use]
pub fn readings(
    mesh: &Mesh,
    format: Format,
    stated: Option<StatedFrame>,
    most: usize,
) -> Vec<Reading> {
    let as_stated = stated.map(|stated| {
        let metres = stated.unit.metres();
        let named = LengthUnit::NAMED.iter().find(|(_, named)| *named == metres);
        let unit = named.map_or_else(|| metres.to_string(), |(name, _)| (*name).to_owned());
        in_frames(mesh, &[stated.up.index()], &[(unit, metres)], most)
    });
    if let Some(found) = as_stated.filter(|found| !found.is_empty()) {
        return found;
    }
    // Up axes in the outer loop, units in the inner one.
    let ups = if matches!(format, Format::Gltf | Format::Glb) { [1, 2, 0] } else { [2, 1, 0] };
    let units = LengthUnit::NAMED.map(|(name, metres)| (name.to_owned(), metres));
    in_frames(mesh, &ups, &units, most)
}

/// Readings with these axes up, and in these units with their lengths (m).
fn in_frames(mesh: &Mesh, ups: &[usize], units: &[(String, f64)], most: usize) -> Vec<Reading> {
    let size = mesh.size_m();
    let mut found = Vec::new();
    for &up in ups {
        let [a, b] = [0, 1, 2].into_iter().filter(|axis| *axis != up).collect::<Vec<_>>()[..]
        else {
            continue;
        };
        for (unit, metres) in units {
            // A person is wider than deep; everything else is longer than wide.
            for [forward, side] in [[a, b], [b, a]] {
                let real = [forward, side, up].map(|axis| size[axis] * metres);
                let Some(looks_like) = offered_shape(real, *metres) else { continue };
                let Some(kind) = likely_kind(looks_like) else { continue };
                let is_along = real[0] >= real[1];
                if is_along == (looks_like == "a person") {
                    continue;
                }
                let sign = if points_back(mesh, forward, up, looks_like) { "-" } else { "" };
                found.push(Reading {
                    unit: unit.clone(),
                    up: AXES[up].to_owned(),
                    forward: format!("{sign}{}", AXES[forward]),
                    looks_like,
                    kind,
                    mass_kg: None,
                    size_m: real,
                });
            }
        }
    }
    // If it is taller than wide, it is a car on its side.
    let is_on_its_side = |of: &Reading| of.looks_like == "a car" && of.size_m[2] > of.size_m[1];
    found.sort_by_key(|reading| (reading.looks_like == BUILDING, is_on_its_side(reading)));
    found.truncate(most);
    for reading in &mut found {
        reading.mass_kg = mass_kg(mesh, reading);
    }
    found
}

/// The mass that an import in this way gives: that of a car depends on its outline.
fn mass_kg(mesh: &Mesh, reading: &Reading) -> Option<f64> {
    let unit = reading.unit.parse().ok()?;
    let axes = [&reading.up, &reading.forward].map(|axis| axis.parse::<Axis>().ok());
    let frame = Frame::new(Format::Obj, unit, axes[0], axes[1]).ok()?;
    let placed = |point: [f32; 3]| frame.point(point.map(f64::from)).map(|x| x as f32);
    let corners = mesh.corners.iter().map(|corners| corners.map(placed)).collect();
    let origin = defaults::Origin { name: "", kind: reading.kind, origin: "", hash: "" };
    defaults::assemble(origin, &Mesh { corners, ..mesh.clone() }).mass_kg
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
        readings(&written, Format::Obj, None, 4).into_iter().next()
    }

    #[test]
    fn cars_are_recognised_in_inches_facing_anywhere() {
        for shape in [Shape::Sedan, Shape::Suv] {
            let mesh = generate(shape, 4_000, 0).expect("a body");
            let inches = offered(&mesh, 39.37, [(1, -1.0), (0, 1.0), (2, 1.0)]).expect("a car");
            assert_eq!((&*inches.unit, inches.up.as_str()), ("inch", "z"), "{shape}");
            assert_eq!((inches.forward.as_str(), inches.looks_like), ("-y", "a car"), "{shape}");
        }
        let mesh = generate(Shape::Sedan, 4_000, 0).expect("a body");
        let metres = offered(&mesh, 1.0, [(0, 1.0), (1, 1.0), (2, 1.0)]).expect("a car");
        assert_eq!((&*metres.unit, metres.forward.as_str()), ("m", "x"));
    }

    #[test]
    fn what_looks_like_nothing_is_offered_nothing() {
        let corners = vec![[[0.0, 0.0, 0.0], [1e6, 0.0, 0.0], [0.0, 1e6, 1.0]]];
        let mesh = Mesh { corners, ..Mesh::default() };
        assert_eq!(readings(&mesh, Format::Obj, None, 4), []);
    }

    /// A mesh of this extent along x, y and z.
    fn sized([x, y, z]: [f32; 3]) -> Mesh {
        Mesh { corners: vec![[[0.0; 3], [x, y, 0.0], [0.0, 0.0, z]]], ..Mesh::default() }
    }

    #[test]
    fn trucks_and_buildings_are_offered_with_kind_size_and_mass() {
        let truck = &readings(&sized([972.0, 247.0, 259.0]), Format::Obj, None, 4)[0];
        assert_eq!(
            (truck.kind, &*truck.unit, truck.mass_kg),
            (BodyKind::Truck, "cm", Some(25_000.0))
        );
        let [length, width, height] = truck.size_m;
        assert!((length - 9.72).abs() < 1e-6 && (width - 2.47).abs() < 1e-6 && height > 2.5);
        for (unit, factor) in [("m", 1.0), ("mm", 1000.0)] {
            let size = [24.0, 18.0, 9.0].map(|x: f32| x * factor);
            let found = readings(&sized(size), Format::Obj, None, 4);
            let house = found.iter().find(|one| one.kind == BodyKind::Building);
            let house = house.map(|one| (&*one.unit, one.mass_kg, one.size_m[2].round()));
            assert_eq!(house, Some((unit, None, 9.0)), "{found:?}");
        }
        // A car in whatever unit is a car first.
        for factor in [1.0, 10.0, 100.0, 1000.0] {
            let size = [4.6, 1.8, 1.4].map(|x: f32| x * factor);
            let car = &readings(&sized(size), Format::Obj, None, 4)[0];
            assert_eq!(car.kind, BodyKind::Sedan, "{factor}");
            assert!(car.mass_kg.is_some());
        }
    }

    /// Regression: a car in inches whose file says so was offered in centimetres, too.
    #[test]
    fn a_frame_that_is_stated_is_believed_unless_it_fits_nothing() {
        let stated = |unit: &str, up: &str| {
            let (unit, up) = (unit.parse().expect("a unit"), up.parse().expect("an axis"));
            Some(StatedFrame { unit, up })
        };
        let mesh = sized([181.0, 55.0, 75.0]);
        let found = readings(&mesh, Format::Collada, stated("inch", "y"), 4);
        assert!(found.iter().all(|one| (&*one.unit, &*one.up) == ("inch", "y")), "{found:?}");
        assert_eq!(found[0].kind, BodyKind::Sedan);
        let feet = readings(&sized([15.1, 6.2, 4.6]), Format::Collada, stated("0.3048", "z"), 4);
        assert_eq!((&*feet[0].unit, feet[0].kind), ("0.3048", BodyKind::Sedan));
        let wrong = readings(&mesh, Format::Collada, stated("dm", "x"), 4);
        assert!(!wrong.is_empty() && wrong.iter().all(|one| one.unit != "dm"), "{wrong:?}");
    }
}
