//! A city bus.

use super::blueprint::Blueprint;
use super::car::{Arches, Wheel, add_body, add_mirrors, add_wheels, rounds};
use super::solids::{Rail, at, hull};
use super::variation::Variation;

/// A bus.
pub(super) fn draft(variation: &mut Variation) -> Blueprint {
    let roof = variation.next(0.03);
    let belt = variation.next(0.03);
    let shift = variation.next(0.08);
    let arches = Arches {
        axles: vec![(3.0, -2.95 + shift), (12.0, 3.10 + shift)],
        z: 0.48,
        radius: 0.56,
        sill: 0.30,
        inner: 0.85,
    };
    // Stations: 0 tail, 1–2 rear window, 3–8 rear arch, 9–11 middle, 12–17 front arch,
    // 18 behind the windscreen, 19–20 nose.
    let mut rails = arches.rails(&[
        (0.0, -5.94, 1.12, 0.42),
        (1.0, -5.86, 1.20, 0.38),
        (2.0, -5.60, 1.235, 0.33),
        (9.0, -1.90, 1.24, 0.30),
        (11.0, 2.00, 1.24, 0.30),
        (18.0, 5.45, 1.235, 0.30),
        (19.0, 5.84, 1.19, 0.32),
        (20.0, 5.95, 1.06, 0.35),
    ]);
    let b = belt;
    rails.extend([
        // 5: over the arches
        Rail::new(
            0.4,
            &[
                (0.0, -5.97, 1.13, 0.80),
                (1.0, -5.90, 1.22, 0.86),
                (2.0, -5.62, 1.27, 1.06 + 0.5 * b),
                (3.0, -3.60, 1.275, 1.10 + 0.5 * b),
                (17.0, 3.80, 1.275, 1.10 + 0.5 * b),
                (18.0, 5.42, 1.27, 1.00),
                (19.0, 5.88, 1.21, 0.84),
                (20.0, 5.99, 1.07, 0.78),
            ],
        ),
        // 6: under the windows
        Rail::new(
            0.3,
            &[
                (0.0, -5.98, 1.08, 1.44 + b),
                (1.0, -5.92, 1.18, 1.50 + b),
                (2.0, -5.62, 1.27, 1.30 + b),
                (3.0, -3.64, 1.275, 1.22 + b),
                (17.0, 3.84, 1.275, 1.22 + b),
                (18.0, 5.38, 1.27, 1.16 + b),
                (19.0, 5.88, 1.19, 1.06 + b),
                (20.0, 5.985, 1.03, 1.00 + b),
            ],
        ),
        // 7: edge of the roof
        Rail::new(
            0.45,
            &[
                (0.0, -5.97, 1.02, 1.52 + b),
                (1.0, -5.92, 1.08, 1.58 + b),
                (2.0, -5.74, 1.16, 2.86 + roof),
                (3.0, -3.62, 1.235, 3.00 + roof),
                (17.0, 3.82, 1.235, 3.00 + roof),
                (18.0, 5.56, 1.14, 2.90 + roof),
                (19.0, 5.89, 1.12, 1.14 + b),
                (20.0, 5.98, 0.98, 1.06 + b),
            ],
        ),
        // 8: top
        Rail::new(
            1.0,
            &[
                (0.0, -6.01, 0.0, 1.53 + b),
                (1.0, -5.97, 0.0, 1.59 + b),
                (2.0, -5.80, 0.0, 2.95 + roof),
                (3.0, -3.60, 0.0, 3.08 + roof),
                (17.0, 3.80, 0.0, 3.08 + roof),
                (18.0, 5.70, 0.0, 2.98 + roof),
                (19.0, 6.01, 0.0, 1.15 + b),
                (20.0, 6.06, 0.0, 1.06 + b),
            ],
        ),
    ]);
    let net = hull(&rails, &rounds(21, &arches, 0.35), 0.9, [0.0, 0.0]);
    let mut blueprint = Blueprint::default();
    add_body(&mut blueprint, &net);
    for (place, x) in [("front", 3.10 + shift), ("rear", -2.95 + shift)] {
        let centre = at(x, 1.09, 0.48);
        add_wheels(&mut blueprint, place, Wheel { centre, radius: 0.48, width: 0.30 });
    }
    add_mirrors(&mut blueprint, at(5.88, 1.24, 2.25), at(0.05, 0.10, 0.20));
    blueprint.add_pad(
        "windscreen",
        &net,
        [(19.12, 7.06), (19.12, 8.94), (19.92, 8.95), (19.92, 7.05)],
        0.05,
    );
    blueprint.add_pad(
        "rear-window",
        &net,
        [(2.15, 7.2), (2.15, 8.8), (2.75, 8.8), (2.75, 7.2)],
        0.1,
    );
    // Windows from pillar to pillar, as rows; the right side has doors instead of two of them.
    for (name, from, to) in [
        ("window-rear-{}", 3.25, 6.45),
        ("window-middle-{}", 6.55, 10.75),
        ("window-centre-{}", 10.85, 13.9),
        ("window-front-{}", 14.0, 18.0),
    ] {
        let side = [(from, 6.06), (to, 6.06), (to, 6.84), (from, 6.84)];
        blueprint.add_pads(name, &net, side, 0.03);
    }
    // Ahead of the front axle: the driver's window on the left, the door on the right.
    let window = [(18.3, 6.06), (18.9, 6.06), (18.9, 6.84), (18.3, 6.84)];
    blueprint.add_pad("window-driver", &net, window, 0.03);
    let end = net.cols.end();
    let door = [(18.3, 4.35), (18.85, 4.35), (18.85, 6.86), (18.3, 6.86)];
    let [a, b, c, d] = door.map(|(s, t)| (s, end - t));
    blueprint.add_pad("window-door", &net, [b, a, d, c], 0.02);
    let lamp = [(20.15, 5.25), (20.75, 5.25), (20.75, 5.9), (20.15, 5.9)];
    blueprint.add_pads("headlamp-{}", &net, lamp, 0.3);
    let lamp = [(1.25, 5.15), (1.85, 5.15), (1.85, 5.9), (1.25, 5.9)];
    blueprint.add_pads("tail-lamp-{}", &net, lamp, 0.3);
    blueprint
}
