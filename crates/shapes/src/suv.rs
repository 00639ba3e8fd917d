//! A tall car with a tailgate.

use super::blueprint::{Blueprint, Fit};
use super::car::{Arches, Wheel, add_body, add_mirrors, add_wheels, rounds};
use super::solids::{Rail, at, block, hull, rod};
use super::variation::Variation;

/// An SUV.
pub(super) fn draft(variation: &mut Variation) -> Blueprint {
    let roof = variation.next(0.02);
    let cabin = variation.next(0.05);
    let bonnet = variation.next(0.02);
    let arches = Arches {
        axles: vec![(3.0, -1.40), (12.0, 1.44)],
        z: 0.37,
        radius: 0.43,
        sill: 0.27,
        inner: 0.66,
    };
    // Stations: 0 tail, 1–2 tailgate window, 3–8 rear arch, 9–11 doors, 12–17 front arch, 18–20
    // nose.
    let mut rails = arches.rails(&[
        (0.0, -2.36, 0.80, 0.40),
        (1.0, -2.30, 0.90, 0.34),
        (2.0, -2.08, 0.94, 0.29),
        (9.0, -0.80, 0.945, 0.27),
        (10.0, -0.05, 0.95, 0.27),
        (11.0, 0.85, 0.945, 0.27),
        (18.0, 2.06, 0.93, 0.27),
        (19.0, 2.25, 0.85, 0.30),
        (20.0, 2.34, 0.70, 0.33),
    ]);
    rails.extend([
        // 5: widest line, over the arches
        Rail::new(
            0.8,
            &[
                (0.0, -2.40, 0.82, 0.66),
                (1.0, -2.34, 0.92, 0.70),
                (2.0, -2.14, 0.965, 0.78),
                (3.0, -1.84, 0.975, 0.87),
                (8.0, -0.94, 0.975, 0.87),
                (9.0, -0.75, 0.975, 0.76),
                (11.0, 0.80, 0.975, 0.76),
                (12.0, 0.98, 0.975, 0.86),
                (17.0, 1.90, 0.97, 0.86),
                (18.0, 2.12, 0.93, 0.74),
                (19.0, 2.31, 0.85, 0.66),
                (20.0, 2.40, 0.70, 0.62),
            ],
        ),
        // 6: shoulder, under the windows
        Rail::new(
            0.7,
            &[
                (0.0, -2.40, 0.76, 1.02),
                (1.0, -2.36, 0.86, 1.08),
                (2.0, -2.20, 0.92, 1.14),
                (3.0, -1.96, 0.935, 1.16),
                (8.0, -0.98, 0.94, 1.12),
                (11.0, 0.75, 0.94, 1.08),
                (13.0, 1.12, 0.935, 1.05),
                (17.0, 1.92, 0.91, 1.00 + bonnet),
                (18.0, 2.14, 0.87, 0.95 + bonnet),
                (19.0, 2.29, 0.79, 0.90 + bonnet),
                (20.0, 2.36, 0.66, 0.86 + bonnet),
            ],
        ),
        // 7: edge of the tailgate window, of the roof and of the bonnet
        Rail::new(
            0.6,
            &[
                (0.0, -2.38, 0.68, 1.08),
                (1.0, -2.33, 0.74, 1.13),
                (2.0, -2.12, 0.68, 1.62 + roof),
                (3.0, -1.96, 0.675, 1.68 + roof),
                (8.0, -0.94, 0.69, 1.735 + roof),
                (10.0, -0.05, 0.70, 1.75 + roof),
                (11.0, 0.42 + cabin, 0.69, 1.715 + roof),
                (13.0, 1.14 + cabin, 0.80, 1.135),
                (14.0, 1.30, 0.80, 1.10),
                (17.0, 1.94, 0.76, 1.055 + bonnet),
                (18.0, 2.14, 0.72, 1.01 + bonnet),
                (19.0, 2.28, 0.66, 0.945 + bonnet),
                (20.0, 2.34, 0.54, 0.90 + bonnet),
            ],
        ),
        // 8: top
        Rail::new(
            1.0,
            &[
                (0.0, -2.42, 0.0, 1.09),
                (1.0, -2.39, 0.0, 1.14),
                (2.0, -2.20, 0.0, 1.68 + roof),
                (3.0, -2.02, 0.0, 1.73 + roof),
                (8.0, -0.94, 0.0, 1.78 + roof),
                (10.0, -0.05, 0.0, 1.79 + roof),
                (11.0, 0.48 + cabin, 0.0, 1.755 + roof),
                (13.0, 1.26 + cabin, 0.0, 1.15),
                (14.0, 1.40, 0.0, 1.13),
                (17.0, 1.98, 0.0, 1.085 + bonnet),
                (18.0, 2.20, 0.0, 1.04 + bonnet),
                (19.0, 2.36, 0.0, 0.965 + bonnet),
                (20.0, 2.42, 0.0, 0.91 + bonnet),
            ],
        ),
    ]);
    let net = hull(&rails, &rounds(21, &arches, 0.6), 0.85, [0.0, 0.0]);
    let mut blueprint = Blueprint::default();
    add_body(&mut blueprint, &net);
    for (place, x) in [("front", 1.44), ("rear", -1.40)] {
        let centre = at(x, 0.835, 0.37);
        add_wheels(&mut blueprint, place, Wheel { centre, radius: 0.37, width: 0.235 });
    }
    add_mirrors(&mut blueprint, at(0.92, 1.02, 1.15), at(0.06, 0.09, 0.085));
    let rail = rod(
        &[
            at(-1.65, 0.60, 1.685 + roof),
            at(-0.80, 0.62, 1.785 + roof),
            at(0.20, 0.61, 1.70 + roof),
        ],
        0.022,
    );
    blueprint.add_pair("roof-rail-{}", &rail, [1, 1, 1], Fit::Stretched);
    // Rows are stations + 1; columns are rails.
    let windscreen = [(12.25, 7.12), (12.25, 8.88), (13.8, 8.9), (13.8, 7.1)];
    blueprint.add_pad("windscreen", &net, windscreen, 0.1);
    blueprint.add_pad(
        "rear-window",
        &net,
        [(2.25, 7.12), (2.25, 8.88), (2.85, 8.85), (2.85, 7.15)],
        0.15,
    );
    let side = [(10.95, 6.22), (13.25, 6.2), (12.25, 6.86), (10.95, 6.86)];
    blueprint.add_pads("window-front-{}", &net, side, 0.1);
    let side = [(4.6, 6.24), (10.75, 6.22), (10.75, 6.86), (4.8, 6.84)];
    blueprint.add_pads("window-rear-{}", &net, side, 0.1);
    let lamp = [(19.2, 5.6), (20.7, 5.6), (20.7, 6.4), (19.2, 6.4)];
    blueprint.add_pads("headlamp-{}", &net, lamp, 0.3);
    let lamp = [(1.2, 5.35), (2.2, 5.35), (2.2, 6.3), (1.2, 6.3)];
    blueprint.add_pads("tail-lamp-{}", &net, lamp, 0.3);
    let grille = block(at(2.40, 0.0, 0.72), at(0.03, 0.45, 0.11), 0.02);
    blueprint.add("grille", grille, [1, 1, 1]);
    blueprint
}
