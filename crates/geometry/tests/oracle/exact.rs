//! Two oracles in exact arithmetic: slow, short, and based on other ideas than the tested code.
//!
//! [`meet`]: A and B share a point if and only if 0 lies in the convex hull of the nine differences
//! a − b (Minkowski), so in a simplex of at most four affinely independent ones (Carathéodory).
//! [`corners`]: clips A, as a polygon, by the half-spaces that define B (Sutherland and Hodgman).
//! Neither has special cases for degenerate triangles or coplanar pairs.

use crate::cases::Pair;
use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{Signed, ToPrimitive, Zero};
use trolley_geometry::{DVec3, Triangle};

type Vector<T> = [T; 3];

pub(crate) fn difference<T: Clone + core::ops::Sub<Output = T>>(
    p: &Vector<T>,
    q: &Vector<T>,
) -> Vector<T> {
    core::array::from_fn(|i| p[i].clone() - q[i].clone())
}

fn cross<T>(p: &Vector<T>, q: &Vector<T>) -> Vector<T>
where
    T: core::ops::Sub<Output = T>,
    for<'x> &'x T: core::ops::Mul<&'x T, Output = T>,
{
    core::array::from_fn(|i| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        &p[j] * &q[k] - &p[k] * &q[j]
    })
}

fn dot<T>(p: &Vector<T>, q: &Vector<T>) -> T
where
    T: core::ops::Add<Output = T>,
    for<'x> &'x T: core::ops::Mul<&'x T, Output = T>,
{
    &p[0] * &q[0] + &p[1] * &q[1] + &p[2] * &q[2]
}

/// Whether the closed triangles share a point.
pub(crate) fn meet(pair: &Pair) -> bool {
    let (points, _) = integers(pair);
    // Differences of 29 bits, products of four of them: below 2^122 with all sums.
    let small = |x: &BigInt| if x.bits() <= 28 { x.to_i128() } else { None };
    let all: Option<Vec<Vector<i128>>> =
        points.iter().map(|[x, y, z]| Some([small(x)?, small(y)?, small(z)?])).collect();
    all.map_or_else(|| hull_holds_zero(&points), |points| hull_holds_zero(&points))
}

/// Whether 0 lies in the convex hull of the differences of the first three points and the others.
fn hull_holds_zero<T: Clone + Ord + Signed>(points: &[Vector<T>]) -> bool
where
    for<'x> &'x T: core::ops::Mul<&'x T, Output = T>,
{
    let (a, b) = points.split_at(3);
    let mut v: Vec<Vector<T>> =
        a.iter().flat_map(|p| b.iter().map(move |q| difference(p, q))).collect();
    v.sort();
    v.dedup();
    let n = v.len();
    let zero = |p: &Vector<T>| p.iter().all(Zero::is_zero);

    // Of i < j, at j(j − 1)/2 + i.
    let mut products = Vec::with_capacity(36);
    for (j, q) in v.iter().enumerate() {
        for p in &v[..j] {
            let product = cross(p, q);
            if zero(&product) && !dot(p, q).is_positive() {
                return true; // on the segment, or one of its ends
            }
            products.push(product);
        }
    }
    if n == 1 {
        return zero(&v[0]);
    }
    let product = |i: usize, j: usize| &products[j * (j - 1) / 2 + i];

    // 1, 0 or −1 for i < j < k.
    let mut volumes = [[[0; 9]; 9]; 9];
    for (i, j, k) in triples(n) {
        let volume = dot(product(i, j), &v[k]);
        if volume.is_zero() && in_triangle(product(j, k), product(i, k), product(i, j)) {
            return true;
        }
        volumes[i][j][k] = i32::from(volume.is_positive()) - i32::from(volume.is_negative());
    }
    triples(n).any(|(i, j, k)| {
        (k + 1..n).any(|l| {
            // The barycentric coordinates of 0 have these signs, or all the opposite ones.
            let shares = [volumes[j][k][l], -volumes[i][k][l], volumes[i][j][l], -volumes[i][j][k]];
            let some = |sign: i32| shares.contains(&sign);
            some(1) != some(-1)
        })
    })
}

/// All i < j < k < n.
fn triples(n: usize) -> impl Iterator<Item = (usize, usize, usize)> {
    (0..n).flat_map(move |k| (0..k).flat_map(move |j| (0..j).map(move |i| (i, j, k))))
}

/// Whether 0, in the plane of u, v, w, lies in their proper triangle; given v × w, u × w, u × v.
fn in_triangle<T: Clone + Signed>(vw: &Vector<T>, uw: &Vector<T>, uv: &Vector<T>) -> bool
where
    for<'x> &'x T: core::ops::Mul<&'x T, Output = T>,
{
    let normal: Vector<T> = core::array::from_fn(|i| vw[i].clone() - uw[i].clone() + uv[i].clone());
    !normal.iter().all(Zero::is_zero)
        && !dot(vw, &normal).is_negative()
        && !dot(uw, &normal).is_positive()
        && !dot(uv, &normal).is_negative()
}

/// The corners of both triangles as multiples of a common power of two, and its exponent.
pub(crate) fn integers(pair: &Pair) -> (Vec<Vector<BigInt>>, i16) {
    let corners = || pair.a.0.iter().chain(&pair.b.0).map(|corner| corner.to_array());
    let decoded = |x: f64| num_traits::float::FloatCore::integer_decode(x);
    let lowest = corners().flatten().filter(|x| *x != 0.0).map(|x| decoded(x).1).min().unwrap_or(0);
    let whole = corners()
        .map(|corner| {
            corner.map(|x| {
                let (mantissa, exponent, sign) = decoded(x);
                if mantissa == 0 {
                    return BigInt::ZERO;
                }
                (BigInt::from(mantissa) << usize::try_from(exponent - lowest).expect("lowest"))
                    * sign
            })
        })
        .collect();
    (whole, lowest)
}

/// The corners of the intersection, each rounded once; none if there is no common point.
pub(crate) fn corners(pair: &Pair) -> Vec<DVec3> {
    let mut polygon = rational(&pair.a);
    let b = rational(&pair.b);
    // Only end points: a corner between two others is not a corner of the intersection.
    if plane(&polygon).iter().all(Zero::is_zero) {
        polygon = ends(&polygon);
    }
    for (normal, offset) in half_spaces(&b) {
        let heights: Vec<_> = polygon.iter().map(|p| dot(&normal, p) - &offset).collect();
        let mut kept = Vec::new();
        for (i, p) in polygon.iter().enumerate() {
            let next = (i + 1) % polygon.len();
            let (here, there) = (&heights[i], &heights[next]);
            if !here.is_negative() {
                kept.push(p.clone());
            }
            if (here * there).is_negative() {
                let share = here / (here - there);
                let q = &polygon[next];
                kept.push(core::array::from_fn(|k| &p[k] + (&q[k] - &p[k]) * &share));
            }
        }
        polygon = kept;
    }
    let rounded = |x: &BigRational| x.to_f64().expect("finite");
    polygon.iter().map(|p| DVec3::from_array([0, 1, 2].map(|i| rounded(&p[i])))).collect()
}

fn rational(triangle: &Triangle) -> Vec<Vector<BigRational>> {
    let exactly = |x: f64| BigRational::from_float(x).expect("finite");
    triangle.0.iter().map(|corner| corner.to_array().map(exactly)).collect()
}

fn plane(corners: &[Vector<BigRational>]) -> Vector<BigRational> {
    cross(&difference(&corners[1], &corners[0]), &difference(&corners[2], &corners[0]))
}

fn ends(corners: &[Vector<BigRational>]) -> Vec<Vector<BigRational>> {
    let mut sorted = corners.to_vec();
    sorted.sort();
    vec![sorted[0].clone(), sorted[2].clone()]
}

/// Half-spaces n·x ≥ c whose intersection is the triangle.
fn half_spaces(b: &[Vector<BigRational>]) -> Vec<(Vector<BigRational>, BigRational)> {
    let through = |normal: Vector<BigRational>, p: &Vector<BigRational>| {
        let offset = dot(&normal, p);
        (normal, offset)
    };
    let negative = |v: &Vector<BigRational>| -> Vector<BigRational> {
        core::array::from_fn(|i| -v[i].clone())
    };
    let normal = plane(b);
    if !normal.iter().all(Zero::is_zero) {
        let sides = (0..3).map(|i| {
            let edge = difference(&b[(i + 1) % 3], &b[i]);
            through(cross(&normal, &edge), &b[i])
        });
        return [through(normal.clone(), &b[0]), through(negative(&normal), &b[0])]
            .into_iter()
            .chain(sides)
            .collect();
    }
    // A segment or a point: on its line, and between its ends, along each axis.
    let ends = ends(b);
    let along = difference(&ends[1], &ends[0]);
    let mut spaces = Vec::new();
    for axis in 0..3 {
        let unit: Vector<BigRational> =
            core::array::from_fn(|i| BigRational::from_integer(i32::from(i == axis).into()));
        let across = cross(&along, &unit);
        spaces.push(through(across.clone(), &ends[0]));
        spaces.push(through(negative(&across), &ends[0]));
        let (low, high) = if ends[0][axis] <= ends[1][axis] { (0, 1) } else { (1, 0) };
        spaces.push(through(unit.clone(), &ends[low]));
        spaces.push(through(negative(&unit), &ends[high]));
    }
    spaces
}
