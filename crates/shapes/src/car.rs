//! Parts common to all vehicles: the rails of a hull with wheel arches, wheels, mirrors.

use super::blueprint::{Blueprint, Fit};
use super::net::Net;
use super::solids::{Rail, at, block, hull_surface, turned, tyre};
use geometry::DVec3;

/// A wheel: middle of the tyre on the left side, outer radius, width (m).
#[derive(Clone, Copy, Debug)]
pub(super) struct Wheel {
    /// Middle.
    pub(super) centre: DVec3,
    /// Outer radius of the tyre.
    pub(super) radius: f64,
    /// Width of the tyre.
    pub(super) width: f64,
}

/// Adds a wheel and its image on the other side: a tyre and a dished rim each.
pub(super) fn add_wheels(blueprint: &mut Blueprint, place: &str, wheel: Wheel) {
    let Wheel { centre, radius, width } = wheel;
    let rim = 0.66 * radius;
    let tyre = tyre(centre, radius, rim, width);
    let (w, c) = (0.42 * width, rim / 10.0);
    let profile = [
        (-w, 5.0 * c),
        (-w, 9.6 * c),
        (-0.8 * w, 10.3 * c),
        (0.8 * w, 10.3 * c),
        (w, 9.8 * c),
        (w, 9.0 * c),
        (0.70 * w, 8.2 * c),
        (0.62 * w, 5.0 * c),
        (0.80 * w, 3.0 * c),
        (0.85 * w, 1.2 * c),
    ];
    let rim = turned(centre, DVec3::Y, &profile);
    blueprint.add_pair(&format!("wheel-{place}-{{}}"), &tyre, [5, 3, 1], Fit::Round);
    blueprint.add_pair(&format!("rim-{place}-{{}}"), &rim, [1, 1, 1], Fit::Round);
}

/// Six key points of a rail that follows a wheel arch: an octagon around a circle of radius `r`
/// around `(x, z)`, at height `foot` below, from station `first` on.
pub(super) fn arch(first: f64, x: f64, z: f64, r: f64, foot: f64, y: f64) -> Vec<(f64, DVec3)> {
    // Half the edge of an octagon around a unit circle: tan 22.5°.
    let half = 0.414_213_562 * r;
    let path =
        [(-r, foot), (-r, z + half), (-half, z + r), (half, z + r), (r, z + half), (r, foot)];
    let points = path.iter().enumerate();
    points.map(|(k, (dx, z))| (first + k as f64, at(x + dx, y, *z))).collect()
}

/// The wheel arches of a car: first station and x of each axle, radius of the arch, height of the
/// axle, half width of the wheel house's inner wall.
#[derive(Clone, Debug)]
pub(super) struct Arches {
    /// (first station, x of the axle).
    pub(super) axles: Vec<(f64, f64)>,
    /// Height of the axles.
    pub(super) z: f64,
    /// Radius of the arches.
    pub(super) radius: f64,
    /// Height of the sill.
    pub(super) sill: f64,
    /// Where the wheel house ends inside.
    pub(super) inner: f64,
}

impl Arches {
    /// The five rails of the underside, from the middle out: middle, foot and head of the wheel
    /// house's inner wall, lower edge inside and outside. `outer` gives the half width of the lower
    /// edge as (station, x, y, z) keys away from the arches.
    pub(super) fn rails(&self, outer: &[(f64, f64, f64, f64)]) -> Vec<Rail> {
        let with_arches = |round: f64, y: Option<f64>, dy: f64, dz: f64| {
            let mut keys: Vec<(f64, DVec3)> = outer
                .iter()
                .map(|k| (k.0, at(k.1, y.map_or(k.2 - dy, |y| y.min(k.2 - dy)), k.3 + dz)))
                .collect();
            for (first, x) in self.axles.iter().copied() {
                let width = outer
                    .windows(2)
                    .find(|pair| pair[0].0 <= first && first <= pair[1].0)
                    .map_or(0.0, |pair| pair[0].2.max(pair[1].2));
                let y = y.unwrap_or(width - dy);
                keys.extend(arch(first, x, self.z, self.radius - dz, self.sill + dz, y));
            }
            keys.sort_by(|a, b| a.0.total_cmp(&b.0));
            Rail { round, keys }
        };
        let flat = |round: f64, y: f64| {
            let keys = outer.iter().map(|k| (k.0, at(k.1, y.min(0.75 * k.2), k.3 + 0.0)));
            let mut keys: Vec<(f64, DVec3)> = keys.collect();
            for (first, x) in self.axles.iter().copied() {
                let r = self.radius;
                keys.push((first, at(x - r, y, self.sill)));
                keys.push((first + 5.0, at(x + r, y, self.sill)));
            }
            keys.sort_by(|a, b| a.0.total_cmp(&b.0));
            Rail { round, keys }
        };
        vec![
            flat(1.0, 0.0),
            flat(0.3, self.inner - 0.05),
            with_arches(0.3, Some(self.inner), 0.04, 0.0),
            with_arches(0.3, None, 0.05, 0.0),
            with_arches(0.6, None, 0.0, 0.012),
        ]
    }
}

/// Roundness of the stations: arches are round, the rest by default.
pub(super) fn rounds(count: usize, arches: &Arches, usual: f64) -> Vec<f64> {
    (0..count)
        .map(|k| {
            let in_arch = |(first, _): &(f64, f64)| (*first..=first + 5.0).contains(&(k as f64));
            if arches.axles.iter().any(in_arch) { 1.0 } else { usual }
        })
        .collect()
}

/// Adds door mirrors: a shell on a short arm.
pub(super) fn add_mirrors(blueprint: &mut Blueprint, centre: DVec3, half: DVec3) {
    let shell = block(centre, half, 0.03);
    blueprint.add_pair("mirror-{}", &shell, [1, 1, 1], Fit::Beside);
}

/// Adds the hull of a car or bus: rails 4 and 7 are the corners of its end faces.
pub(super) fn add_body(blueprint: &mut Blueprint, net: &Net) {
    blueprint.add("body", hull_surface(net, 4.0, 7.0), [6, 2, 2]);
}
