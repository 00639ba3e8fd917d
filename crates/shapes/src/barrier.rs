//! Fixed objects: a Jersey barrier and a pole.

use super::blueprint::Blueprint;
use super::solids::{Rail, at, hull, hull_surface, turned};
use super::variation::Variation;
use geometry::DVec3;

/// A concrete wall with the Jersey profile (upright toe, slope of 55°, slope of 84°), along x.
pub(super) fn wall(variation: &mut Variation) -> Blueprint {
    let knee = 0.36 + variation.next(0.03);
    let line =
        |round: f64, y: f64, z: f64| Rail::new(round, &[(0.0, -5.0, y, z), (3.0, 5.0, y, z)]);
    let rails = [
        line(0.0, 0.0, 0.0),
        line(0.0, 0.29, 0.0),
        line(0.8, 0.30, 0.0),
        line(0.5, 0.30, 0.075),
        line(0.5, 0.145, knee),
        line(0.0, 0.092, 0.87),
        line(0.9, 0.09, 0.9),
        line(0.0, 0.06, 0.9),
        line(0.0, 0.0, 0.9),
    ];
    let mut net_rails = rails.to_vec();
    for rail in &mut net_rails {
        let (first, last) = (rail.keys[0].1, rail.keys[1].1);
        let inner = [(1.0, first + at(0.03, 0.0, 0.0)), (2.0, last - at(0.03, 0.0, 0.0))];
        rail.keys.splice(1..1, inner);
    }
    let net = hull(&net_rails, &[0.9, 0.0, 0.0, 0.9], 0.93, [0.0, 0.0]);
    let mut blueprint = Blueprint::default();
    blueprint.add("barrier", hull_surface(&net, 2.0, 6.0), [4, 2, 4]);
    blueprint
}

/// A steel pole on a base, slightly tapered, with a rounded top.
pub(super) fn pole(variation: &mut Variation) -> Blueprint {
    let top = 0.10 + variation.next(0.008);
    let profile = [
        (0.0, 0.11),
        (0.0, 0.15),
        (0.04, 0.15),
        (0.5, 0.148),
        (4.85, top),
        (5.0, top),
        (5.0, 0.5 * top),
    ];
    let mut blueprint = Blueprint::default();
    blueprint.add("pole", turned(DVec3::ZERO, DVec3::Z, &profile), [4, 2, 2]);
    blueprint
}
