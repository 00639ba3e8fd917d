//! A rigid lorry: a cab, a box body on a chassis, one axle in front and two behind.

use super::blueprint::{Blueprint, Fit};
use super::car::{Arches, Wheel, add_mirrors, add_wheels, rounds};
use super::solids::{Rail, at, block, hull, hull_surface, rod};
use super::variation::Variation;

/// A truck.
pub(super) fn draft(variation: &mut Variation) -> Blueprint {
    let height = variation.next(0.06);
    let cab = variation.next(0.05);
    let axle = variation.next(0.08);
    let arches =
        Arches { axles: vec![(1.0, 3.72)], z: 0.52, radius: 0.62, sill: 0.55, inner: 0.80 };
    // Stations: 0 back of the cab, 1–6 arch, 7 door, 8 behind the windscreen, 9–10 nose.
    let mut rails = arches.rails(&[
        (0.0, 2.80, 1.19, 0.80),
        (7.0, 4.55, 1.20, 0.42),
        (8.0, 4.72, 1.20, 0.40),
        (9.0, 4.90, 1.17, 0.38),
        (10.0, 4.96, 1.06, 0.40),
    ]);
    let c = cab;
    rails.extend([
        // 5: over the arch
        Rail::new(
            0.5,
            &[
                (0.0, 2.78, 1.21, 1.34),
                (1.0, 3.05, 1.225, 1.36),
                (6.0, 4.38, 1.225, 1.36),
                (8.0, 4.72, 1.22, 1.15),
                (9.0, 4.93, 1.18, 1.00),
                (10.0, 4.985, 1.07, 0.96),
            ],
        ),
        // 6: under the windows
        Rail::new(
            0.4,
            &[
                (0.0, 2.78, 1.21, 1.90),
                (6.0, 4.36, 1.225, 1.84),
                (8.0, 4.68, 1.21, 1.76),
                (9.0, 4.92, 1.16, 1.66),
                (10.0, 4.98, 1.04, 1.60),
            ],
        ),
        // 7: edge of the roof
        Rail::new(
            0.7,
            &[
                (0.0, 2.78, 1.10, 2.92 + c),
                (1.0, 3.00, 1.12, 2.96 + c),
                (6.0, 4.20, 1.10, 2.94 + c),
                (8.0, 4.56, 1.04, 2.82 + c),
                (9.0, 4.93, 1.10, 1.74),
                (10.0, 4.98, 0.99, 1.66),
            ],
        ),
        // 8: top
        Rail::new(
            1.0,
            &[
                (0.0, 2.78, 0.0, 3.00 + c),
                (6.0, 4.20, 0.0, 3.02 + c),
                (8.0, 4.66, 0.0, 2.90 + c),
                (9.0, 5.03, 0.0, 1.75),
                (10.0, 5.06, 0.0, 1.66),
            ],
        ),
    ]);
    let net = hull(&rails, &rounds(11, &arches, 0.4), 0.9, [0.0, 0.0]);
    let mut blueprint = Blueprint::default();
    blueprint.add("cab", hull_surface(&net, 4.0, 7.0), [4, 2, 2]);
    let cargo = block(at(-1.17, 0.0, 2.345 + height), at(3.83, 1.25, 1.255 + height), 0.03);
    blueprint.add("cargo-box", cargo, [1, 1, 1]);
    blueprint.add("chassis", block(at(-0.4, 0.0, 0.86), at(4.4, 0.43, 0.16), 0.03), [1, 1, 1]);
    let front = Wheel { centre: at(3.72, 1.06, 0.52), radius: 0.52, width: 0.30 };
    add_wheels(&mut blueprint, "front", front);
    for (place, x) in [("middle", -2.15 + axle), ("rear", -3.45 + axle)] {
        let centre = at(x, 0.95, 0.52);
        add_wheels(&mut blueprint, place, Wheel { centre, radius: 0.52, width: 0.54 });
    }
    add_mirrors(&mut blueprint, at(4.62, 1.36, 2.10), at(0.06, 0.10, 0.26));
    // A deflector from the roof of the cab up to the box.
    let deflector = hull(
        &[
            Rail::new(1.0, &[(0.0, 2.80, 0.0, 2.80), (2.0, 4.3, 0.0, 2.92)]),
            Rail::new(
                0.2,
                &[(0.0, 2.80, 1.00, 2.80), (1.0, 3.4, 0.92, 2.86), (2.0, 4.3, 0.72, 2.92)],
            ),
            Rail::new(
                0.7,
                &[(0.0, 2.80, 1.04, 3.52), (1.0, 3.4, 0.92, 3.32 + c), (2.0, 4.3, 0.70, 3.00 + c)],
            ),
            Rail::new(
                1.0,
                &[(0.0, 2.80, 0.0, 3.57), (1.0, 3.5, 0.0, 3.42 + c), (2.0, 4.4, 0.0, 3.06 + c)],
            ),
        ],
        &[0.2, 1.0, 0.2],
        0.9,
        [0.0, 0.0],
    );
    blueprint.add("deflector", hull_surface(&deflector, 1.0, 2.0), [1, 1, 1]);
    let guard = block(at(0.55, 1.17, 0.72), at(1.75, 0.03, 0.22), 0.02);
    blueprint.add_pair("side-guard-{}", &guard, [1, 1, 1], Fit::Stretched);
    blueprint.add(
        "bumper-rear",
        block(at(-4.90, 0.0, 0.55), at(0.05, 1.15, 0.08), 0.02),
        [1, 1, 1],
    );
    blueprint.add(
        "bumper-front",
        rod(&[at(4.96, -1.0, 0.52), at(5.02, 0.0, 0.52), at(4.96, 1.0, 0.52)], 0.10),
        [1, 1, 1],
    );
    blueprint.add_pad(
        "windscreen",
        &net,
        [(9.1, 7.08), (9.1, 8.92), (9.9, 8.94), (9.9, 7.06)],
        0.06,
    );
    let side = [(5.6, 6.12), (8.95, 6.14), (8.8, 6.84), (5.6, 6.84)];
    blueprint.add_pads("window-{}", &net, side, 0.06);
    let lamp = [(10.1, 5.05), (10.75, 5.05), (10.75, 5.4), (10.1, 5.4)];
    blueprint.add_pads("headlamp-{}", &net, lamp, 0.2);
    blueprint
}
