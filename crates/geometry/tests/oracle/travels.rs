//! The travels at which two triangles touch, in exact arithmetic: slow, short, and based on another
//! idea than the tested code.
//!
//! B moved by s·d shares a point with A if and only if s·d lies in the convex hull of the nine
//! differences a − b (Minkowski). Across d, that hull is one of nine points of a plane, and the
//! travels are its heights above 0: each end lies above a simplex of at most three of the nine
//! (Carathéodory). All simplices are tried, without special cases for degenerate triangles, edges
//! or planes along d.

use crate::cases::Pair;
use crate::exact::{difference, integers};
use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{Signed, ToPrimitive, Zero};
use std::cmp::Ordering;
use trolley_geometry::DVec3;

/// The components of a direction are multiples of 2 to the power of this.
const DIRECTION_UNIT: i64 = -60;

/// A fraction with a positive denominator; not reduced, as that would take most of the time.
#[derive(Clone, Debug)]
struct Fraction {
    over: BigInt,
    under: BigInt,
}

/// A closed interval of travels, in units of a power of two.
#[derive(Debug)]
pub(crate) struct Travels {
    start: Fraction,
    end: Fraction,
    unit: i64,
}

impl Fraction {
    fn of(over: BigInt, under: BigInt) -> Self {
        if under.is_negative() { Self { over: -over, under: -under } } else { Self { over, under } }
    }

    fn compare(&self, other: &Self) -> Ordering {
        (&self.over * &other.under).cmp(&(&other.over * &self.under))
    }
}

impl Travels {
    /// The travels along `direction`, as given by `Sweep::direction`; none if they never touch.
    pub(crate) fn of(pair: &Pair, direction: DVec3) -> Option<Self> {
        let (corners, lowest) = integers(pair);
        let whole = |x: f64| BigInt::from(libm::scalbn(x, -DIRECTION_UNIT as i32) as i64);
        let d = direction.to_array().map(whole);
        let k = (0..3).max_by_key(|k| d[*k].magnitude())?;
        let [i, j] = [(k + 1) % 3, (k + 2) % 3];
        // Across d: two coordinates that d itself does not change.
        let across = |v: &[BigInt; 3]| [i, j].map(|i| &v[i] * &d[k] - &v[k] * &d[i]);
        let (a, b) = corners.split_at(3);
        let points = a.iter().flat_map(|p| b.iter().map(move |q| difference(p, q)));
        let (places, heights): (Vec<_>, Vec<_>) =
            points.map(|v| (across(&v), v[k].clone())).collect();
        let mut found: Option<[Fraction; 2]> = None;
        over_zero(&places, &heights, &mut |over, under| {
            let height = Fraction::of(over, under * &d[k]);
            let [low, high] = found.get_or_insert_with(|| [height.clone(), height.clone()]);
            if height.compare(low).is_lt() {
                *low = height;
            } else if height.compare(high).is_gt() {
                *high = height;
            }
        });
        let [start, end] = found?;
        Some(Self { start, end, unit: i64::from(lowest) - DIRECTION_UNIT })
    }

    /// The first, rounded.
    pub(crate) fn start(&self) -> f64 {
        -self.after_start(0.0)
    }

    /// The last, rounded.
    pub(crate) fn end(&self) -> f64 {
        -self.after_end(0.0)
    }

    /// By how much `travel` lies beyond the first: the exact difference, rounded.
    pub(crate) fn after_start(&self, travel: f64) -> f64 {
        self.beyond(&self.start, travel)
    }

    /// By how much `travel` lies beyond the last.
    pub(crate) fn after_end(&self, travel: f64) -> f64 {
        self.beyond(&self.end, travel)
    }

    fn beyond(&self, fraction: &Fraction, travel: f64) -> f64 {
        let (mantissa, exponent, sign) = num_traits::float::FloatCore::integer_decode(travel);
        let least = self.unit.min(exponent.into());
        let up = |by: i64| usize::try_from(by - least).expect("the least exponent");
        let over = ((BigInt::from(mantissa) * sign * &fraction.under) << up(exponent.into()))
            - (&fraction.over << up(self.unit));
        let under = &fraction.under << usize::try_from(-least.min(0)).expect("not negative");
        let over = over << usize::try_from(least.max(0)).expect("not negative");
        let sign = if over.is_negative() { -1.0 } else { f64::from(u8::from(!over.is_zero())) };
        let rounded = BigRational::new_raw(over, under).to_f64().expect("rounded");
        // 0 is for equality alone.
        if rounded == 0.0 { sign * f64::MIN_POSITIVE } else { rounded }
    }
}

/// Calls `add` with the heights above 0, as fractions, of all simplices of these points of a plane
/// that contain 0.
fn over_zero(places: &[[BigInt; 2]], heights: &[BigInt], add: &mut impl FnMut(BigInt, BigInt)) {
    let n = places.len();
    // Twice the areas of 0 and two points; of i < j, at j(j − 1)/2 + i.
    let mut areas = Vec::with_capacity(n * (n - 1) / 2);
    for (j, q) in places.iter().enumerate() {
        if q.iter().all(Zero::is_zero) {
            add(heights[j].clone(), BigInt::from(1));
        }
        for (i, p) in places[..j].iter().enumerate() {
            let area = &p[0] * &q[1] - &p[1] * &q[0];
            if area.is_zero() {
                // In line with 0: on both sides of it in a coordinate?
                for c in 0..2 {
                    if (&p[c] * &q[c]).is_negative() {
                        let over = &heights[i] * &q[c] - &heights[j] * &p[c];
                        add(over, &q[c] - &p[c]);
                        break;
                    }
                }
            }
            areas.push(area);
        }
    }
    let sign = |x: &BigInt| i32::from(x.is_positive()) - i32::from(x.is_negative());
    let signs: Vec<i32> = areas.iter().map(sign).collect();
    let index = |i: usize, j: usize| j * (j - 1) / 2 + i;
    for k in 0..n {
        for j in 0..k {
            for i in 0..j {
                let [ij, jk, ik] = [index(i, j), index(j, k), index(i, k)];
                // If 0 lies on a side of the triangle, that side has been added above.
                if signs[ij] != 0 && signs[jk] == signs[ij] && signs[ik] == -signs[ij] {
                    let [p, q, r] = [&areas[jk], &areas[ik], &areas[ij]];
                    let over = p * &heights[i] - q * &heights[j] + r * &heights[k];
                    add(over, p - q + r);
                }
            }
        }
    }
}
