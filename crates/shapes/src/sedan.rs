//! A four-door car with a boot.

use super::blueprint::Blueprint;
use super::car::{Arches, Wheel, add_body, add_mirrors, add_wheels, rounds};
use super::solids::{Rail, at, block, hull};
use super::variation::Variation;

/// A sedan.
pub(super) fn draft(variation: &mut Variation) -> Blueprint {
    let roof = variation.next(0.02);
    let cabin = variation.next(0.05);
    let deck = variation.next(0.02);
    let arches = Arches {
        axles: vec![(3.0, -1.36), (12.0, 1.40)],
        z: 0.33,
        radius: 0.375,
        sill: 0.20,
        inner: 0.62,
    };
    // Stations: 0 tail, 3–8 rear arch, 9–11 doors, 12–17 front arch, 18–20 nose.
    let mut rails = arches.rails(&[
        (0.0, -2.28, 0.74, 0.30),
        (1.0, -2.20, 0.84, 0.26),
        (2.0, -2.00, 0.89, 0.22),
        (9.0, -0.80, 0.895, 0.20),
        (10.0, -0.05, 0.90, 0.20),
        (11.0, 0.85, 0.895, 0.20),
        (18.0, 2.00, 0.87, 0.20),
        (19.0, 2.19, 0.78, 0.22),
        (20.0, 2.28, 0.60, 0.25),
    ]);
    rails.extend([
        // 5: widest line, over the arches
        Rail::new(
            0.9,
            &[
                (0.0, -2.31, 0.76, 0.58),
                (1.0, -2.24, 0.86, 0.62),
                (2.0, -2.02, 0.915, 0.70),
                (3.0, -1.76, 0.925, 0.76),
                (8.0, -0.95, 0.925, 0.76),
                (9.0, -0.75, 0.925, 0.66),
                (11.0, 0.80, 0.925, 0.64),
                (12.0, 1.00, 0.925, 0.74),
                (17.0, 1.80, 0.92, 0.74),
                (18.0, 2.02, 0.88, 0.62),
                (19.0, 2.22, 0.78, 0.56),
                (20.0, 2.32, 0.60, 0.52),
            ],
        ),
        // 6: shoulder, under the windows
        Rail::new(
            0.8,
            &[
                (0.0, -2.31, 0.70, 0.93 + deck),
                (1.0, -2.24, 0.78, 0.97 + deck),
                (3.0, -1.74, 0.86, 0.99 + deck),
                (8.0, -0.98, 0.89, 0.97),
                (11.0, 0.75, 0.89, 0.92),
                (13.0, 1.10, 0.88, 0.89),
                (17.0, 1.82, 0.84, 0.81),
                (18.0, 2.04, 0.78, 0.74),
                (19.0, 2.20, 0.68, 0.68),
                (20.0, 2.27, 0.52, 0.64),
            ],
        ),
        // 7: edge of the roof, of the boot lid and of the bonnet
        Rail::new(
            0.7,
            &[
                (0.0, -2.29, 0.60, 1.00 + deck),
                (1.0, -2.20, 0.66, 1.035 + deck),
                (3.0, -1.80, 0.69, 1.05 + deck),
                (4.0, -1.66 + cabin, 0.69, 1.07 + deck),
                (8.0, -0.92 + cabin, 0.575, 1.36 + roof),
                (9.0, -0.62 + cabin, 0.575, 1.40 + roof),
                (10.0, -0.05 + cabin, 0.58, 1.415 + roof),
                (11.0, 0.30 + cabin, 0.575, 1.385 + roof),
                (13.0, 1.08 + cabin, 0.71, 0.985),
                (14.0, 1.26, 0.70, 0.945),
                (17.0, 1.84, 0.66, 0.855),
                (18.0, 2.04, 0.62, 0.79),
                (19.0, 2.17, 0.55, 0.725),
                (20.0, 2.24, 0.42, 0.68),
            ],
        ),
        // 8: top
        Rail::new(
            1.0,
            &[
                (0.0, -2.33, 0.0, 1.01 + deck),
                (1.0, -2.24, 0.0, 1.055 + deck),
                (3.0, -1.86, 0.0, 1.075 + deck),
                (4.0, -1.74 + cabin, 0.0, 1.09 + deck),
                (8.0, -0.98 + cabin, 0.0, 1.40 + roof),
                (9.0, -0.62 + cabin, 0.0, 1.445 + roof),
                (10.0, -0.05 + cabin, 0.0, 1.455 + roof),
                (11.0, 0.36 + cabin, 0.0, 1.43 + roof),
                (13.0, 1.20 + cabin, 0.0, 1.00),
                (14.0, 1.36, 0.0, 0.97),
                (17.0, 1.88, 0.0, 0.885),
                (18.0, 2.10, 0.0, 0.82),
                (19.0, 2.25, 0.0, 0.75),
                (20.0, 2.32, 0.0, 0.70),
            ],
        ),
    ]);
    let net = hull(&rails, &rounds(21, &arches, 0.7), 0.85, [0.0, 0.0]);
    let mut blueprint = Blueprint::default();
    add_body(&mut blueprint, &net);
    for (place, x) in [("front", 1.40), ("rear", -1.36)] {
        let centre = at(x, 0.795, 0.33);
        add_wheels(&mut blueprint, place, Wheel { centre, radius: 0.33, width: 0.215 });
    }
    add_mirrors(&mut blueprint, at(0.86, 0.96, 0.985), at(0.06, 0.09, 0.065));
    // Rows are stations + 1; columns are rails.
    let top = 8.0;
    blueprint.add_pad(
        "windscreen",
        &net,
        [(12.25, 7.15), (12.25, 2.0 * top - 7.15), (13.8, 2.0 * top - 7.12), (13.8, 7.12)],
        0.12,
    );
    blueprint.add_pad(
        "rear-window",
        &net,
        [(5.3, 7.15), (5.3, 2.0 * top - 7.15), (8.8, 2.0 * top - 7.18), (8.8, 7.18)],
        0.15,
    );
    let side = [(10.95, 6.25), (13.2, 6.22), (12.2, 6.86), (10.95, 6.86)];
    blueprint.add_pads("window-front-{}", &net, side, 0.1);
    let side = [(7.0, 6.30), (10.75, 6.25), (10.75, 6.86), (8.9, 6.84)];
    blueprint.add_pads("window-rear-{}", &net, side, 0.1);
    let lamp = [(19.0, 5.5), (20.6, 5.5), (20.6, 6.3), (19.0, 6.3)];
    blueprint.add_pads("headlamp-{}", &net, lamp, 0.4);
    let lamp = [(1.1, 5.5), (2.3, 5.5), (2.3, 6.3), (1.1, 6.3)];
    blueprint.add_pads("tail-lamp-{}", &net, lamp, 0.3);
    let grille = block(at(2.31, 0.0, 0.40), at(0.03, 0.42, 0.07), 0.02);
    blueprint.add("grille", grille, [1, 1, 1]);
    blueprint
}
