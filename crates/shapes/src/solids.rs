//! The solids of which shapes are composed: hulls, tubes, solids of revolution, blocks, tyres.

use super::net::{Axis, Net};
use super::surface::Surface;
use geometry::DVec3;

/// Short for a point (m).
pub(super) fn at(x: f64, y: f64, z: f64) -> DVec3 {
    DVec3::new(x, y, z)
}

/// A lengthwise line of a hull: key points at station numbers, straight in between.
#[derive(Clone, Debug)]
pub(super) struct Rail {
    /// Roundness of the hull across this rail.
    pub(super) round: f64,
    /// Station and point, stations ascending.
    pub(super) keys: Vec<(f64, DVec3)>,
}

impl Rail {
    /// A rail from (station, x, y, z).
    pub(super) fn new(round: f64, keys: &[(f64, f64, f64, f64)]) -> Self {
        Self { round, keys: keys.iter().map(|k| (k.0, at(k.1, k.2, k.3))).collect() }
    }

    /// The point at a station.
    fn at(&self, station: f64) -> DVec3 {
        let k = self.keys.partition_point(|key| key.0 < station);
        match (k.checked_sub(1).map(|k| self.keys[k]), self.keys.get(k).copied()) {
            (Some((s0, p0)), Some((s1, p1))) => p0 + (p1 - p0) * ((station - s0) / (s1 - s0)),
            (Some((_, p)), None) | (None, Some((_, p))) => p,
            (None, None) => DVec3::ZERO,
        }
    }
}

/// A hull from rails of its left half, the first along the bottom middle and the last along the top
/// middle, both with y = 0. The right half is its image. Columns: 0 bottom middle, then up the left
/// side, the top middle, and down the right side.
///
/// Rows are the stations, with one row more at either end: the last ring shrunk to `shrink` and
/// moved out by `bulge` metres, which rounds the edge of the end face. So row = station + 1.
pub(super) fn hull(rails: &[Rail], row_round: &[f64], shrink: f64, bulge: [f64; 2]) -> Net {
    let top = rails.len() - 1;
    let mirror = |p: DVec3| at(p.x, -p.y, p.z);
    let ring = |station: f64| -> Vec<DVec3> {
        let left: Vec<DVec3> = rails.iter().map(|rail| rail.at(station)).collect();
        let right = left[1..top].iter().rev().map(|p| mirror(*p));
        left.iter().copied().chain(right).collect()
    };
    let inset = |ring: &[DVec3], out: f64| -> Vec<DVec3> {
        let mean = ring.iter().sum::<DVec3>() / ring.len() as f64;
        ring.iter().map(|p| mean + (*p - mean) * shrink + at(out, 0.0, 0.0)).collect()
    };
    let mut rows: Vec<Vec<DVec3>> = (0..row_round.len()).map(|k| ring(k as f64)).collect();
    let ends = [inset(&rows[0], -bulge[0]), inset(&rows[rows.len() - 1], bulge[1])];
    let [first, last] = ends;
    rows.insert(0, first);
    rows.push(last);
    let rounds = [&[0.0], row_round, &[0.0]].concat();
    let half: Vec<f64> = rails.iter().map(|rail| rail.round).collect();
    let cols = half.iter().copied().chain(half[1..top].iter().rev().copied()).collect();
    Net::new(&rows, Axis::new(rounds, false), cols)
}

/// A hull as a component; the corners of its end faces lie on rails `low` and `high`.
pub(super) fn hull_surface(net: &Net, low: f64, high: f64) -> Surface {
    let end = net.cols.end();
    Surface::Tube { net: net.clone(), corners: [low, high, end - high, end - low] }
}

/// A ring of a tube: centre, radius towards the side, radius across it (m).
pub(super) type Ring = (DVec3, f64, f64);

/// How much farther out the control points of a round ring of 8 lie than the ring.
const RING: f64 = 1.0 / 0.925_3;
/// Cosines of the eighth-turns from −45° on; sines are the cosines two places earlier.
const EIGHTHS: [f64; 8] = {
    const D: f64 = core::f64::consts::FRAC_1_SQRT_2;
    [D, 1.0, D, 0.0, -D, -1.0, -D, 0.0]
};

/// A tube of elliptic rings along a path, smooth throughout. `side` is across the start of the
/// path; from ring to ring it turns no more than the path does. Consecutive legs must not turn by
/// 90°.
pub(super) fn tube(path: &[Ring], side: DVec3) -> Surface {
    let last = path.len() - 1;
    let mut side = side;
    let rows: Vec<Vec<DVec3>> = path
        .iter()
        .enumerate()
        .map(|(k, (centre, wide, deep))| {
            // Rings at one place share the heading of the path there.
            let before = (0..k).rev().map(|i| path[i].0).find(|p| p.distance(*centre) > 1e-6);
            let after = (k + 1..=last).map(|i| path[i].0).find(|p| p.distance(*centre) > 1e-6);
            let into = before.map_or(DVec3::ZERO, |p| (*centre - p).normalize_or_zero());
            let out = after.map_or(DVec3::ZERO, |p| (p - *centre).normalize_or_zero());
            let heading = (into + out).normalize_or_zero();
            side = (side - heading * side.dot(heading)).normalize_or_zero();
            let across = heading.cross(side);
            (0..8)
                .map(|i| {
                    let (cos, sin) = (EIGHTHS[i], EIGHTHS[(i + 6) % 8]);
                    *centre + side * (cos * wide * RING) + across * (sin * deep * RING)
                })
                .collect()
        })
        .collect();
    let mut round = vec![1.0; path.len()];
    (round[0], round[last]) = (0.0, 0.0);
    let net = Net::new(&rows, Axis::new(round, false), vec![1.0; 8]);
    Surface::Tube { net, corners: [0.0, 2.0, 4.0, 6.0] }
}

/// A straight or bent rod of one radius, with flat ends (m).
pub(super) fn rod(path: &[DVec3], radius: f64) -> Surface {
    let heading = path[path.len() - 1] - path[0];
    let side = if heading.y.abs() > 0.7 * heading.length() { DVec3::X } else { DVec3::Y };
    let rings: Vec<Ring> = path.iter().map(|p| (*p, radius, radius)).collect();
    tube(&rings, side)
}

/// A solid of revolution: radii at places along `axis` from `centre` (m).
pub(super) fn turned(centre: DVec3, axis: DVec3, profile: &[(f64, f64)]) -> Surface {
    let side = if axis.y.abs() > 0.7 { DVec3::X } else { DVec3::Y };
    let a = (side - axis * side.dot(axis)).normalize_or_zero();
    let b = axis.cross(a);
    let rows: Vec<Vec<DVec3>> = profile
        .iter()
        .map(|(along, radius)| {
            circle(16)
                .map(|(cos, sin)| centre + axis * *along + (a * cos + b * sin) * *radius)
                .collect()
        })
        .collect();
    let mut round = vec![0.6; profile.len()];
    round[0] = 0.0;
    let net = Net::new(&rows, Axis::new(round, false), vec![1.0; 16]);
    Surface::Tube { net, corners: [2.0, 6.0, 10.0, 14.0] }
}

/// Control points of a unit circle, from (0, −1) on, counter-clockwise.
fn circle(count: usize) -> impl Iterator<Item = (f64, f64)> {
    let step = core::f64::consts::TAU / count as f64;
    let (_, cos) = libm::sincos(step);
    // The mean of the curve's radii at a control point and between two.
    let out = 1.0 / (0.375 + 0.125 * cos + 0.5 * libm::sqrt(0.5 + 0.5 * cos));
    (0..count).map(move |k| {
        let (sin, cos) = libm::sincos(step * k as f64 - core::f64::consts::FRAC_PI_2);
        (out * cos, out * sin)
    })
}

/// A block with edges rounded by about `round` metres.
pub(super) fn block(centre: DVec3, half: DVec3, round: f64) -> Surface {
    let section = |x: f64, shrink: f64| -> Vec<DVec3> {
        let (y, z) = (half.y - shrink, half.z - shrink);
        let r = round.min(0.7 * y.min(z));
        let quarter = |sy: f64, sz: f64, swap: bool| {
            let points =
                [(y - r, z), (y, z), (y, z - r)].map(|(y, z)| centre + at(x, sy * y, sz * z));
            if swap { points } else { [points[2], points[1], points[0]] }
        };
        [
            quarter(1.0, -1.0, true),
            quarter(1.0, 1.0, false),
            quarter(-1.0, 1.0, true),
            quarter(-1.0, -1.0, false),
        ]
        .concat()
    };
    let rows = [
        section(-half.x, round),
        section(-half.x, 0.0),
        section(round - half.x, 0.0),
        section(half.x - round, 0.0),
        section(half.x, 0.0),
        section(half.x, round),
    ];
    let axis = Axis::new(vec![0.0, 1.0, 0.0, 0.0, 1.0, 0.0], false);
    let net = Net::new(&rows, axis, [0.0, 1.0, 0.0].repeat(4));
    Surface::Tube { net, corners: [1.0, 4.0, 7.0, 10.0] }
}

/// A tyre around a wheel whose axle points along y: outer radius, radius of the rim, width (m).
pub(super) fn tyre(centre: DVec3, radius: f64, rim: f64, width: f64) -> Surface {
    let (w, step) = (width / 2.0, 0.3 * (radius - rim));
    let section = [
        (radius, 0.0),
        (radius, 0.70 * w),
        (radius - 0.25 * step, 0.95 * w),
        (radius - 1.5 * step, 1.05 * w),
        (rim, 0.85 * w),
        (rim, 0.0),
        (rim, -0.85 * w),
        (radius - 1.5 * step, -1.05 * w),
        (radius - 0.25 * step, -0.95 * w),
        (radius, -0.70 * w),
    ];
    let rows: Vec<Vec<DVec3>> = circle(16)
        .map(|(cos, sin)| section.iter().map(|(r, y)| centre + at(r * cos, *y, r * sin)).collect())
        .collect();
    let round = vec![0.3, 1.0, 1.0, 1.0, 0.6, 0.3, 0.6, 1.0, 1.0, 1.0];
    Surface::Torus { net: Net::new(&rows, Axis::new(vec![1.0; 16], true), round) }
}
