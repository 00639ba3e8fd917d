//! Numbered pairs of triangles with a direction, on which a careless first contact fails.
//!
//! Directions are scaled to length 1 and rounded, so few planes contain one exactly. Those whose
//! components are 0 or powers of two keep their ratios, and a corner at 0 can be moved by a power
//! of two times a direction without any rounding: so faces and edges lie along the motion exactly.

use crate::cases::{self, Corners, FAMILIES, Pair, RandomPoints};
use trolley_geometry::hash::splitmix64;
use trolley_geometry::rng::Rng;
use trolley_geometry::{DVec3, Pose, RelativePose, Sweep, Triangle};

/// Two triangles, and the direction in which the second moves.
pub(crate) struct Motion {
    pub(crate) pair: Pair,
    pub(crate) direction: DVec3,
}

/// A way of generating motions.
pub(crate) struct Kind {
    pub(crate) name: &'static str,
    make: fn(&mut RandomPoints) -> (Corners, Corners, DVec3),
}

/// All kinds; motion n is of kind n modulo their number.
pub(crate) const KINDS: &[Kind] = &[
    Kind { name: "general", make: general },
    Kind { name: "shared corner", make: |random| shared(random, 1) },
    Kind { name: "shared edge", make: |random| shared(random, 2) },
    Kind { name: "in one plane", make: in_one_plane },
    Kind { name: "parallel planes", make: parallel_planes },
    Kind { name: "faces along d", make: faces_along },
    Kind { name: "edges along d", make: edges_along },
    Kind { name: "degenerate", make: degenerate },
    Kind { name: "slivers", make: slivers },
    Kind { name: "unequal sizes", make: unequal_sizes },
    Kind { name: "tiny", make: tiny },
    Kind { name: "huge", make: huge },
    Kind { name: "lattice", make: lattice },
    Kind { name: "box faces", make: box_faces },
    Kind { name: "nearly edge-on", make: nearly_edge_on },
    Kind { name: "posed", make: posed },
    Kind { name: "far apart", make: far_apart },
    Kind { name: "grazing", make: grazing },
    Kind { name: "tiny components", make: tiny_components },
    Kind { name: "at rest", make: at_rest },
];

/// The kind of a motion.
pub(crate) fn kind(number: u64) -> usize {
    (number % KINDS.len() as u64) as usize
}

/// Motion `number` of `seed`.
pub(crate) fn motion(seed: u64, number: u64) -> Motion {
    let mut random = RandomPoints(Rng::new(splitmix64(seed) ^ splitmix64(number)));
    let (mut a, mut b, mut direction) = (KINDS[kind(number)].make)(&mut random);
    if random.below(2) == 0 {
        (a, b, direction) = (b, a, -direction);
    }
    Motion { pair: Pair { a: shuffled(&mut random, a), b: shuffled(&mut random, b) }, direction }
}

/// The triangle with its corners in another order.
pub(crate) fn shuffled(random: &mut RandomPoints, mut corners: Corners) -> Triangle {
    corners.rotate_left(random.below(3) as usize);
    if random.below(2) == 0 {
        corners.swap(1, 2);
    }
    Triangle(corners)
}

/// The direction as it will be used.
fn used(direction: DVec3) -> DVec3 {
    Sweep::new(direction, 0.0, 0.0).expect("it has a length").direction()
}

fn nonzero(mut point: impl FnMut() -> DVec3) -> DVec3 {
    loop {
        let point = point();
        if point != DVec3::ZERO {
            return point;
        }
    }
}

fn axis(random: &mut RandomPoints) -> DVec3 {
    let axis = DVec3::AXES[random.below(3) as usize];
    if random.below(2) == 0 { axis } else { -axis }
}

/// A direction whose components keep their ratios: 0, or powers of two.
fn even(random: &mut RandomPoints) -> DVec3 {
    let mut component = || [0.0, 0.0, 1.0, -1.0, 2.0, -2.0, 0.5, -4.0][random.below(8) as usize];
    nonzero(|| DVec3::new(component(), component(), component()))
}

fn any_direction(random: &mut RandomPoints) -> DVec3 {
    match random.below(5) {
        0 => axis(random),
        1 => even(random),
        2 => nonzero(|| random.whole_point(3)),
        _ => nonzero(|| random.real_point()),
    }
}

/// A travel before contact: whole for half of the pairs, for which it often keeps incidences.
fn way(random: &mut RandomPoints) -> f64 {
    match random.below(4) {
        0 => 0.0,
        1 => random.whole(8),
        _ => random.real() * 10.0,
    }
}

fn back(corners: Corners, direction: DVec3, way: f64) -> Corners {
    corners.map(|corner| corner - used(direction) * way)
}

fn general(random: &mut RandomPoints) -> (Corners, Corners, DVec3) {
    let direction = nonzero(|| random.real_point());
    let [a, b] = [random.real_corners(), random.real_corners()];
    let size = libm::exp2(random.whole(6));
    let way = random.real() * 10.0;
    (a.map(|p| p * size), back(b.map(|p| p * size), direction, way), direction)
}

/// `count` corners in common; moved away again for half of the pairs.
fn shared(random: &mut RandomPoints, count: usize) -> (Corners, Corners, DVec3) {
    let is_whole = random.below(2) == 0;
    let mut corners = || if is_whole { random.grid(4) } else { random.real_corners() };
    let (a, mut b) = (corners(), corners());
    b[..count].copy_from_slice(&a[..count]);
    let direction = any_direction(random);
    let way = way(random);
    if random.below(4) == 0 {
        b[0].x += random.real() * 1e-9;
    }
    (a, back(b, direction, way), direction)
}

/// A face of whole steps along `direction` and along another way.
fn face_along(
    random: &mut RandomPoints,
    direction: DVec3,
) -> impl Fn(&mut RandomPoints) -> Corners + use<> {
    let (origin, side) = (random.whole_point(4), nonzero(|| random.whole_point(3)));
    move |random| [(); 3].map(|()| origin + direction * random.whole(6) + side * random.whole(4))
}

fn in_one_plane(random: &mut RandomPoints) -> (Corners, Corners, DVec3) {
    let direction = even(random);
    let face = face_along(random, direction);
    (face(random), face(random), direction)
}

fn parallel_planes(random: &mut RandomPoints) -> (Corners, Corners, DVec3) {
    let [a, b] = cases::coplanar(random);
    let direction = any_direction(random);
    let off = if random.below(2) == 0 {
        random.whole_point(3)
    } else {
        used(direction) * random.whole(5)
    };
    (a, b.map(|p| p - off), direction)
}

/// A's face along the motion, and now and then B's.
fn faces_along(random: &mut RandomPoints) -> (Corners, Corners, DVec3) {
    let direction = even(random);
    let a = face_along(random, direction)(random);
    let b = match random.below(3) {
        0 => face_along(random, direction)(random),
        1 => random.grid(5),
        _ => random.real_corners().map(|p| p * 4.0),
    };
    (a, b, direction)
}

/// Edges of A along any direction, from corners at 0: exactly.
fn edges_along(random: &mut RandomPoints) -> (Corners, Corners, DVec3) {
    let direction = any_direction(random);
    let d = used(direction);
    let along = |random: &mut RandomPoints| {
        if random.below(3) == 0 {
            return DVec3::ZERO;
        }
        d * (libm::exp2(random.whole(3)) * if random.below(2) == 0 { 1.0 } else { -1.0 })
    };
    let a = [along(random), along(random), random.real_point() * 3.0];
    let b = match random.below(4) {
        0 => [along(random), along(random), random.real_point() * 3.0],
        1 => [along(random), random.real_point(), random.real_point()],
        2 => [DVec3::ZERO, random.whole_point(2), random.whole_point(2)],
        _ => random.real_corners(),
    };
    (a, b, direction)
}

/// Points and segments in A, in B, or in both.
fn degenerate(random: &mut RandomPoints) -> (Corners, Corners, DVec3) {
    let [mut a, mut b] =
        if random.below(4) == 0 { cases::collinear(random) } else { cases::degenerate(random) };
    let direction = match random.below(3) {
        0 => axis(random),
        1 => even(random),
        // From a point of one to a point of the other: it meets it, or misses it by rounding.
        _ => nonzero(|| {
            let numbered = |corners: &Corners, k: u64| corners[k as usize];
            let offset = numbered(&a, random.below(3)) - numbered(&b, random.below(3));
            if random.below(4) == 0 { random.real_point() } else { offset }
        }),
    };
    match random.below(4) {
        0 => a = random.real_corners(),
        1 => b = random.grid(3),
        _ => {}
    }
    (a, b, direction)
}

fn slivers(random: &mut RandomPoints) -> (Corners, Corners, DVec3) {
    let [a, b] = cases::needle(random);
    let direction = match random.below(4) {
        0 => any_direction(random),
        1 => nonzero(|| a[0] - a[1]),
        2 => nonzero(|| (a[0] - a[1]) + random.real_point() * 1e-9),
        _ => nonzero(|| random.real_point()),
    };
    let way = way(random);
    (a, back(b, direction, way), direction)
}

fn unequal_sizes(random: &mut RandomPoints) -> (Corners, Corners, DVec3) {
    let [a, b] = cases::unequal_sizes(random);
    let (direction, way) = (any_direction(random), way(random));
    (a, back(b, direction, way), direction)
}

/// One of a few other kinds.
fn another(random: &mut RandomPoints) -> (Corners, Corners, DVec3) {
    let kinds = [general, in_one_plane, faces_along, edges_along, degenerate, lattice, slivers];
    kinds[random.below(7) as usize](random)
}

/// Down to a picometre, or down to where f64 ends.
fn tiny(random: &mut RandomPoints) -> (Corners, Corners, DVec3) {
    let (a, b, direction) = another(random);
    let exponent = if random.below(2) == 0 { random.below(40) } else { random.below(1070) };
    let scaled = |p: DVec3| DVec3::from_array(p.to_array().map(|x| scale(x, -(exponent as i32))));
    (a.map(scaled), b.map(scaled), direction)
}

/// Up to the greatest travel, or up to where f64 ends.
fn huge(random: &mut RandomPoints) -> (Corners, Corners, DVec3) {
    let (a, b, direction) = another(random);
    let exponent = if random.below(4) == 0 { random.below(1015) } else { random.below(24) };
    let scaled = |p: DVec3| DVec3::from_array(p.to_array().map(|x| scale(x, exponent as i32)));
    (a.map(scaled), b.map(scaled), direction)
}

fn scale(x: f64, exponent: i32) -> f64 {
    libm::scalbn(x, exponent)
}

fn lattice(random: &mut RandomPoints) -> (Corners, Corners, DVec3) {
    let n = 1 + random.below(3) as i64;
    let direction = match random.below(3) {
        0 => axis(random),
        1 => even(random),
        _ => nonzero(|| random.whole_point(2)),
    };
    (random.grid(n), random.grid(n), direction)
}

/// Halves of two boxes' faces, of f32 sizes, moving along an axis.
fn box_faces(random: &mut RandomPoints) -> (Corners, Corners, DVec3) {
    let mut half = || {
        let mut decimal = || f64::from(random.whole(20) as f32 * 0.1);
        let (low, high) = (
            DVec3::new(decimal(), decimal(), decimal()),
            DVec3::new(decimal(), decimal(), decimal()),
        );
        let (k, side) = (random.below(3) as usize, random.below(2) == 0);
        let [i, j] = [(k + 1) % 3, (k + 2) % 3];
        let mut corners = [low; 3];
        for (n, corner) in corners.iter_mut().enumerate() {
            let mut at = corner.to_array();
            at[k] = if side { low } else { high }.to_array()[k];
            at[i] = if n > 0 { high } else { low }.to_array()[i];
            at[j] = if n > 1 { high } else { low }.to_array()[j];
            *corner = DVec3::from_array(at);
        }
        corners
    };
    let (a, b) = (half(), half());
    let direction = axis(random);
    // Far enough away for half of the pairs.
    let off = if random.below(2) == 0 { direction * 5.0 } else { DVec3::ZERO };
    (a, b.map(|p| p - off), direction)
}

/// A face along the motion, but for 1e-12 to 1e-16.
fn nearly_edge_on(random: &mut RandomPoints) -> (Corners, Corners, DVec3) {
    let kinds = [in_one_plane, faces_along, edges_along, box_faces, parallel_planes];
    let (a, b, direction) = kinds[random.below(5) as usize](random);
    let off = random.real_point() * libm::pow(10.0, -12.0 - random.real().abs() * 4.0);
    (a, b, used(direction) + off)
}

/// Stored f32 corners, B's through a relative pose; along an axis of A or of B, or any direction.
fn posed(random: &mut RandomPoints) -> (Corners, Corners, DVec3) {
    let mut angle = || match random.below(4) {
        0 => random.whole(4) * 90.0,
        1 => random.real() * libm::exp2(-(random.below(60) as f64)),
        2 => 0.0,
        _ => random.real() * 180.0,
    };
    let (yaw, pitch, roll) = (angle(), angle(), angle());
    let place = random.real_point() * 4.0;
    let at = Pose::from_degrees(yaw, pitch, roll, place.to_array());
    let pose = RelativePose::between(&Pose::IDENTITY, &at);
    let is_whole = random.below(2) == 0;
    let mut stored = || {
        let corners = if is_whole { random.grid(3) } else { random.real_corners() };
        corners.map(|p| p.to_array().map(|x| x as f32 * 0.7))
    };
    let (stored_a, stored_b) = (stored(), stored());
    let a = Triangle::stored(&stored_a).0;
    let b = pose.triangle(&stored_b).0;
    let turned =
        |d: DVec3| DVec3::from_array(pose.rotation.map(|row| DVec3::from_array(row).dot(d)));
    let direction = match random.below(4) {
        0 => axis(random),
        1 => turned(axis(random)),
        2 => nonzero(|| random.real_point()),
        // Towards A.
        _ => nonzero(|| (a[0] - b[0]) + random.real_point() * 0.1),
    };
    (a, b, direction)
}

/// 100 m apart along the motion, and up to 100 km.
fn far_apart(random: &mut RandomPoints) -> (Corners, Corners, DVec3) {
    let (a, b, direction) = another(random);
    let way = 100.0 * if random.below(4) == 0 { 1000.0 } else { 1.0 };
    let way = if random.below(2) == 0 { way } else { way * random.real() };
    (a, back(b, direction, way), direction)
}

/// A corner of B that passes an edge or a corner of A by 1e-9 to 1e-15.
fn grazing(random: &mut RandomPoints) -> (Corners, Corners, DVec3) {
    let direction = any_direction(random);
    let d = used(direction);
    let a = if random.below(2) == 0 { random.real_corners() } else { random.grid(3) };
    let share = random.below(5) as f64 * 0.25;
    let at = a[0] + (a[1] - a[0]) * share;
    let out = (at - a[2]) - d * d.dot(at - a[2]);
    let size = if out == DVec3::ZERO { 1.0 } else { libm::sqrt(out.dot(out)) };
    let past = libm::pow(10.0, -9.0 - 6.0 * random.real().abs());
    let past = if random.below(2) == 0 { past } else { -past };
    let corner = at + out * (past / size);
    let away = |random: &mut RandomPoints| corner + out * random.real().abs() + d * random.real();
    let b = [corner, away(random), away(random)];
    let way = way(random);
    (a, back(b, direction, way), direction)
}

/// An axis, with components of 1e-12 to 1e-18 beside it.
fn tiny_components(random: &mut RandomPoints) -> (Corners, Corners, DVec3) {
    let kinds = [lattice, box_faces, general, in_one_plane, degenerate];
    let (a, b, _) = kinds[random.below(5) as usize](random);
    let mut tiny = || [0.0, 1e-12, -1e-17, 3e-17, 1e-18, 1e-15][random.below(6) as usize];
    let beside = DVec3::new(tiny(), tiny(), tiny());
    (a, b, axis(random) + beside)
}

/// Pairs of the triangle test, stretched over the range of f64 or not, touching at travel 0 or
/// nearly.
fn at_rest(random: &mut RandomPoints) -> (Corners, Corners, DVec3) {
    let mut corners = (FAMILIES[random.below(FAMILIES.len() as u64) as usize].make)(random);
    if random.below(3) == 0 {
        cases::stretch(random, &mut corners);
    }
    let [a, b] = corners;
    (a, b, any_direction(random))
}
