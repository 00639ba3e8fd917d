//! Numbered pairs of triangles on which a careless test fails.
//!
//! Each family builds its pairs so that contacts are exact in f64 (small whole numbers, dyadic
//! fractions), then corners and roles are shuffled. Every third round stretches the axes by powers
//! of two, which keeps every incidence, up to the ends of the f64 range.
//!
//! A [`Group`] has pairs of the same families in the form used by bodies: stored in f32, B's seen
//! through a pose.

use trolley_geometry::hash::splitmix64;
use trolley_geometry::rng::Rng;
use trolley_geometry::{DVec3, Pose, RelativePose, Triangle};

/// Two triangles.
#[derive(Debug)]
pub(crate) struct Pair {
    pub(crate) a: Triangle,
    pub(crate) b: Triangle,
}

/// A way of generating pairs.
pub(crate) struct Family {
    pub(crate) name: &'static str,
    pub(crate) make: fn(&mut RandomPoints) -> [Corners; 2],
}

pub(crate) type Corners = [DVec3; 3];

/// All families; pair n is of family n modulo their number.
pub(crate) const FAMILIES: &[Family] = &[
    Family { name: "random", make: unrelated },
    Family { name: "grid", make: |random| [random.grid(2), random.grid(2)] },
    Family { name: "shared vertex", make: |random| shared(random, 1) },
    Family { name: "shared edge", make: |random| shared(random, 2) },
    Family { name: "vertex on face", make: vertex_on_face },
    Family { name: "edge on edge", make: edge_on_edge },
    Family { name: "coplanar", make: coplanar },
    Family { name: "collinear", make: collinear },
    Family { name: "degenerate", make: degenerate },
    Family { name: "needle", make: needle },
    Family { name: "an ulp off", make: an_ulp_off },
    Family { name: "nearly coplanar", make: nearly_coplanar },
    Family { name: "unequal sizes", make: unequal_sizes },
    Family { name: "posed", make: posed },
    Family { name: "denormal", make: denormal },
];

/// The family of a pair.
pub(crate) fn family(number: u64) -> usize {
    (number % FAMILIES.len() as u64) as usize
}

/// Pair `number` of `seed`.
pub(crate) fn pair(seed: u64, number: u64) -> Pair {
    let mut random = RandomPoints(Rng::new(splitmix64(seed) ^ splitmix64(number)));
    let mut corners = (FAMILIES[family(number)].make)(&mut random);
    if random.below(3) == 0 {
        stretch(&mut random, &mut corners);
    }
    for triangle in &mut corners {
        triangle.rotate_left(random.below(3) as usize);
        if random.below(2) == 0 {
            triangle.swap(1, 2);
        }
    }
    if random.below(2) == 0 {
        corners.swap(0, 1);
    }
    let [a, b] = corners.map(Triangle);
    Pair { a, b }
}

/// As many stored pairs as one batch takes: triangle i of A with triangle i of B.
#[derive(Debug)]
pub(crate) struct Group {
    pub(crate) pose: RelativePose,
    pub(crate) a: Vec<trolley_geometry::Corners>,
    pub(crate) b: Vec<trolley_geometry::Corners>,
}

/// Number of pairs of a group.
pub(crate) const GROUP: usize = 64;

/// Group `number` of `seed`; its pair i is of the family of `GROUP`·`number` + i.
pub(crate) fn group(seed: u64, number: u64) -> Group {
    let mut random = RandomPoints(Rng::new(splitmix64(seed) ^ splitmix64(!number)));
    let right = [-90.0, 0.0, 90.0, 180.0];
    let mut angle = |kind: u64| match kind {
        0 | 1 => 0.0,
        2 => right[random.below(4) as usize],
        _ => random.real() * 180.0,
    };
    let kind = number % 4;
    let (yaw, pitch, roll) = (angle(kind), angle(kind), angle(kind));
    let offset = match kind {
        0 => DVec3::ZERO,
        1 | 2 => random.whole_point(4),
        _ => random.real_point() * libm::exp2(random.whole(12)),
    };
    let pose = Pose::from_degrees(yaw, pitch, roll, offset.to_array());
    let mut group = Group {
        pose: RelativePose::between(&Pose::IDENTITY, &pose),
        a: Vec::with_capacity(GROUP),
        b: Vec::with_capacity(GROUP),
    };
    let stored = |point: DVec3| point.to_array().map(|x| x as f32);
    for i in 0..GROUP as u64 {
        let mut corners = (FAMILIES[family(GROUP as u64 * number + i)].make)(&mut random);
        // Small, as triangles of bodies are compared with their distance; now and then at the ends
        // of f32.
        let exponent = match random.below(16) {
            0 => random.whole(120) - 20.0,
            1..8 => -(random.below(16) as f64),
            _ => 0.0,
        };
        let at = if random.below(2) == 0 { random.whole_point(3) } else { DVec3::ZERO };
        for corner in corners.iter_mut().flatten() {
            *corner = *corner * libm::exp2(exponent) + at;
        }
        let [a, b] = corners;
        group.a.push(a.map(stored));
        group.b.push(b.map(|corner| stored(pose.direction_to_body(corner - offset))));
    }
    group
}

/// Random numbers and points.
pub(crate) struct RandomPoints(pub(crate) Rng);

impl RandomPoints {
    pub(crate) fn below(&mut self, n: u64) -> u64 {
        self.0.below(n)
    }

    /// A whole number in [−n, n].
    pub(crate) fn whole(&mut self, n: i64) -> f64 {
        (self.below(2 * n as u64 + 1) as i64 - n) as f64
    }

    /// In [−1, 1).
    pub(crate) fn real(&mut self) -> f64 {
        (self.0.bits() >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    pub(crate) fn whole_point(&mut self, n: i64) -> DVec3 {
        DVec3::new(self.whole(n), self.whole(n), self.whole(n))
    }

    pub(crate) fn real_point(&mut self) -> DVec3 {
        DVec3::new(self.real(), self.real(), self.real())
    }

    pub(crate) fn grid(&mut self, n: i64) -> Corners {
        core::array::from_fn(|_| self.whole_point(n))
    }

    pub(crate) fn real_corners(&mut self) -> Corners {
        core::array::from_fn(|_| self.real_point())
    }
}

/// Multiplies each axis by a power of two: within the range of `robust`, or far out of it.
pub(crate) fn stretch(random: &mut RandomPoints, corners: &mut [Corners; 2]) {
    let far = random.below(3) == 0;
    let even = random.below(2) == 0;
    let mut exponent = || if far { random.whole(1000) as i32 } else { random.whole(60) as i32 };
    let first = exponent();
    let exponents = if even { [first; 3] } else { [first, exponent(), exponent()] };
    for corner in corners.iter_mut().flatten() {
        let scaled = corner.to_array();
        *corner =
            DVec3::from_array(core::array::from_fn(|i| libm::scalbn(scaled[i], exponents[i])));
    }
}

fn unrelated(random: &mut RandomPoints) -> [Corners; 2] {
    [random.real_corners(), random.real_corners()]
}

/// Two triangles with `count` corners in common.
fn shared(random: &mut RandomPoints, count: usize) -> [Corners; 2] {
    let [a, mut b] = unrelated(random);
    b[..count].copy_from_slice(&a[..count]);
    // Now and then off by one coordinate: then they may miss.
    if random.below(2) == 0 {
        b[0].x += random.real() * 1e-9;
        b[1].y += random.real() * 1e-9;
    }
    [a, b]
}

/// A corner at a dyadic combination of the other's corners: inside, on an edge, or just outside.
fn vertex_on_face(random: &mut RandomPoints) -> [Corners; 2] {
    let (mut a, b) = (random.grid(1000), random.grid(1000));
    let (v, w) = (random.whole(9), random.whole(9));
    a[0] = b[0] * ((8.0 - v - w) / 8.0) + b[1] * (v / 8.0) + b[2] * (w / 8.0);
    [a, b]
}

/// An edge of each through one point, and now and then past its end.
fn edge_on_edge(random: &mut RandomPoints) -> [Corners; 2] {
    let meeting = random.whole_point(100);
    let mut side = || {
        let (along, past) = (random.whole_point(100), random.whole(1) - 0.5);
        [meeting + along, meeting + along * past, random.whole_point(200)]
    };
    [side(), side()]
}

/// Whole steps along two directions of one plane.
pub(crate) fn coplanar(random: &mut RandomPoints) -> [Corners; 2] {
    let (origin, u, v) = (random.whole_point(9), random.whole_point(9), random.whole_point(9));
    let mut corners =
        || core::array::from_fn(|_| origin + u * random.whole(3) + v * random.whole(3));
    [corners(), corners()]
}

/// All corners on one line.
pub(crate) fn collinear(random: &mut RandomPoints) -> [Corners; 2] {
    let (origin, along) = (random.whole_point(9), random.whole_point(9));
    let mut corners = || core::array::from_fn(|_| origin + along * random.whole(6));
    [corners(), corners()]
}

/// Points and segments, against each other and against proper triangles.
pub(crate) fn degenerate(random: &mut RandomPoints) -> [Corners; 2] {
    let mut corners = || {
        let mut corners = random.grid(1);
        match random.below(4) {
            0 => corners = [corners[0]; 3],
            1 => corners[2] = corners[1],
            2 => corners[2] = (corners[0] + corners[1]) * 0.5,
            _ => {}
        }
        corners
    };
    [corners(), corners()]
}

/// Third corners almost on the edge between the first two, the edges crossing or nearly so.
pub(crate) fn needle(random: &mut RandomPoints) -> [Corners; 2] {
    let meeting = random.real_point();
    let mut corners = || {
        let along = random.real_point();
        let [off, thin] = [(); 2].map(|()| libm::exp2(-10.0 - random.below(45) as f64));
        let (p, q) = (meeting + along + random.real_point() * off, meeting - along);
        [p, q, p + (q - p) * random.real().abs() + random.real_point() * thin]
    };
    [corners(), corners()]
}

/// A contact of another family, with one coordinate of one corner moved to a neighbouring number.
fn an_ulp_off(random: &mut RandomPoints) -> [Corners; 2] {
    let touching: [fn(&mut RandomPoints) -> [Corners; 2]; 4] =
        [vertex_on_face, edge_on_edge, coplanar, |random| shared(random, 1)];
    let mut corners = touching[random.below(4) as usize](random);
    let corner = &mut corners[random.below(2) as usize][random.below(3) as usize];
    let coordinate = &mut corner[random.below(3) as usize];
    for _ in 0..=random.below(2) {
        *coordinate =
            if random.below(2) == 0 { coordinate.next_up() } else { coordinate.next_down() };
    }
    corners
}

/// One plane, up to some last bits.
fn nearly_coplanar(random: &mut RandomPoints) -> [Corners; 2] {
    let (origin, u, v) = (random.real_point(), random.real_point(), random.real_point());
    let off = libm::exp2(-30.0 - random.below(26) as f64);
    let mut corners = || {
        core::array::from_fn(|_| {
            origin + u * random.real() + v * random.real() + random.real_point() * off
        })
    };
    [corners(), corners()]
}

/// A large triangle, and a small one at one of its points.
pub(crate) fn unequal_sizes(random: &mut RandomPoints) -> [Corners; 2] {
    let [large, small] = unrelated(random);
    let (v, w) = (random.real().abs(), random.real().abs());
    let at = large[0] + (large[1] - large[0]) * v + (large[2] - large[0]) * w;
    let scale = libm::exp2(-(random.below(60) as f64));
    [large, small.map(|corner| at + corner * scale)]
}

/// Stored f32 corners, B's through a relative pose: right angles, minute angles, any.
fn posed(random: &mut RandomPoints) -> [Corners; 2] {
    let mut angle = || match random.below(4) {
        0 => random.whole(4) * 90.0,
        1 => random.real() * libm::exp2(-(random.below(1060) as f64)),
        2 => 0.0,
        _ => random.real() * 180.0,
    };
    let (yaw, pitch, roll) = (angle(), angle(), angle());
    // Equal yaws make R nearly the unit matrix: zeros meet minute sines.
    let tiny = random.below(4) == 0;
    let at = if tiny { DVec3::ZERO } else { random.whole_point(2) };
    let a = Pose::from_degrees(yaw, 0.0, 0.0, at.to_array());
    let b = Pose::from_degrees(if random.below(2) == 0 { yaw } else { 0.0 }, pitch, roll, [0.0; 3]);
    let pose = RelativePose::between(&a, &b);
    let scale = if tiny { f32::from_bits(1) } else { 1.0 };
    let mut stored = || random.grid(2).map(|p| p.to_array().map(|x| x as f32 * scale));
    let (corners_a, corners_b) = (stored(), stored());
    let exactly = corners_a.map(|p| DVec3::from_array(p.map(f64::from)));
    [exactly, pose.triangle(&corners_b).0]
}

/// Coordinates at and below the least normal number, among zeros and ordinary ones.
fn denormal(random: &mut RandomPoints) -> [Corners; 2] {
    let shift = random.below(3);
    let mut coordinate = || match (random.below(4), shift) {
        (0, 0) => random.whole(2),
        (1, 1) => random.real() * f64::MIN_POSITIVE,
        _ => random.whole(3) * f64::from_bits(1),
    };
    let mut corners =
        || core::array::from_fn(|_| DVec3::new(coordinate(), coordinate(), coordinate()));
    [corners(), corners()]
}
