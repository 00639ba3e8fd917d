//! A motorcycle with its rider.

use super::blueprint::{Blueprint, Fit};
use super::figure::{Cover, Pose, Side, add_figure, joint};
use super::solids::{Ring, at, block, rod, tube, turned, tyre};
use super::surface::Surface;
use super::variation::Variation;
use geometry::DVec3;

/// An arc of flat tube over a wheel, from `from` to `to` eighth-turns from the front.
fn fender(axle: DVec3, radius: f64, from: f64, to: f64) -> Surface {
    let rings: Vec<Ring> = (0..7)
        .map(|k| {
            let angle = (from + (to - from) * f64::from(k) / 6.0) * core::f64::consts::FRAC_PI_4;
            let (sin, cos) = libm::sincos(angle);
            (axle + at(radius * cos, 0.0, radius * sin), 0.075, 0.014)
        })
        .collect();
    tube(&rings, DVec3::Y)
}

/// A motorcycle.
pub(super) fn draft(variation: &mut Variation) -> Blueprint {
    let lean = variation.next(0.03);
    let base = variation.next(0.03);
    let girth = 1.0 + variation.next(0.05);
    let front = at(0.77 + base, 0.0, 0.32);
    let rear = at(-0.75, 0.0, 0.32);
    let mut blueprint = Blueprint::default();
    for (place, axle, width) in [("front", front, 0.12), ("rear", rear, 0.17)] {
        let wheel = tyre(axle, 0.32, 0.215, width);
        blueprint.add(&format!("wheel-{place}"), wheel, [5, 3, 1]).fit = Fit::Round;
        let w = 0.4 * width;
        let profile = [(-w, 0.225), (-w, 0.20), (-0.3 * w, 0.17), (-w, 0.06), (-w, 0.02)];
        // From the hub of one side over the rim to the hub of the other.
        let disc: Vec<(f64, f64)> =
            profile.iter().rev().copied().chain(profile.iter().map(|(x, r)| (-x, *r))).collect();
        blueprint.add(&format!("rim-{place}"), turned(axle, DVec3::Y, &disc), [1, 1, 1]).fit =
            Fit::Round;
    }
    let tank = [
        (at(0.40, 0.0, 0.86), 0.05, 0.05),
        (at(0.40, 0.0, 0.88), 0.11, 0.08),
        (at(0.26, 0.0, 0.90), 0.155, 0.115),
        (at(0.08, 0.0, 0.88), 0.150, 0.110),
        (at(-0.08, 0.0, 0.83), 0.110, 0.080),
        (at(-0.16, 0.0, 0.81), 0.09, 0.05),
    ];
    blueprint.add("tank", tube(&tank, DVec3::Y), [2, 1, 1]);
    let seat = [
        (at(-0.06, 0.0, 0.80), 0.07, 0.03),
        (at(-0.10, 0.0, 0.80), 0.10, 0.045),
        (at(-0.30, 0.0, 0.79), 0.145, 0.050),
        (at(-0.48, 0.0, 0.83), 0.125, 0.055),
        (at(-0.78, 0.0, 0.88), 0.090, 0.050),
        (at(-0.92, 0.0, 0.90), 0.050, 0.030),
        (at(-0.92, 0.0, 0.90), 0.020, 0.012),
    ];
    blueprint.add("seat", tube(&seat, DVec3::Y), [1, 1, 1]);
    let tail = [
        (at(-0.30, 0.0, 0.70), 0.10, 0.05),
        (at(-0.60, 0.0, 0.76), 0.10, 0.07),
        (at(-0.95, 0.0, 0.84), 0.06, 0.045),
    ];
    blueprint.add("tail", tube(&tail, DVec3::Y), [1, 1, 1]);
    blueprint.add("engine", block(at(0.10, 0.0, 0.42), at(0.24, 0.17, 0.16), 0.06), [1, 1, 1]);
    blueprint.add("engine-head", block(at(0.20, 0.0, 0.66), at(0.14, 0.15, 0.14), 0.04), [1, 1, 1]);
    let side = rod(&[at(0.42, 0.04, 0.92), at(-0.12, 0.13, 0.62), at(-0.20, 0.13, 0.38)], 0.03);
    blueprint.add_pair("frame-{}", &side, [1, 1, 1], Fit::Stretched);
    let arm = rod(&[at(-0.16, 0.12, 0.42), rear + at(0.0, 0.12, 0.0)], 0.032);
    blueprint.add_pair("swing-arm-{}", &arm, [1, 1, 1], Fit::Stretched);
    let leg = rod(&[at(0.435, 0.10, 1.06), front + at(0.02, 0.10, 0.0)], 0.034);
    blueprint.add_pair("fork-{}", &leg, [1, 1, 1], Fit::Stretched);
    blueprint.add("fender-front", fender(front, 0.36, 0.9, 4.2), [1, 1, 1]);
    blueprint.add("fender-rear", fender(rear, 0.375, 2.2, 4.2), [1, 1, 1]);
    let bar =
        [at(0.36, 0.42, 1.07), at(0.46, 0.16, 1.05), at(0.46, -0.16, 1.05), at(0.36, -0.42, 1.07)];
    blueprint.add("fork-bar", rod(&bar, 0.018), [1, 1, 1]);
    let lamp = [(-0.10, 0.04), (-0.10, 0.07), (0.04, 0.10), (0.09, 0.095), (0.10, 0.06)];
    blueprint.add("headlamp", turned(at(0.60, 0.0, 0.93), DVec3::X, &lamp), [1, 1, 1]);
    let pipe = [
        at(0.30, -0.10, 0.56),
        at(0.40, -0.14, 0.34),
        at(0.10, -0.21, 0.25),
        at(-0.30, -0.21, 0.27),
        at(-0.55, -0.22, 0.34),
        at(-0.98, -0.22, 0.46),
    ];
    let radii = [0.026, 0.026, 0.028, 0.032, 0.055, 0.055];
    let pipe: Vec<Ring> = pipe.iter().zip(radii).map(|(p, r)| (*p, r, r)).collect();
    blueprint.add("exhaust", tube(&pipe, DVec3::Y), [1, 1, 1]);
    add_figure(&mut blueprint, &rider(lean, girth));
    blueprint
}

/// Upright, hands on the bar, feet on the pegs.
fn rider(lean: f64, girth: f64) -> Pose {
    let side = |y: f64| {
        let hip = at(-0.26, 0.095 * y, 0.90);
        let ankle = at(-0.08, 0.215 * y, 0.40);
        let shoulder = at(-0.07 + lean, 0.185 * y, 1.375);
        let wrist = at(0.34, 0.365 * y, 1.105);
        Side {
            arm: [
                shoulder,
                joint(shoulder, wrist, 0.29, 0.26, at(-0.2, 0.9 * y, -0.6)),
                wrist,
                at(0.385, 0.36 * y, 1.085),
            ],
            leg: [hip, joint(hip, ankle, 0.44, 0.43, at(1.0, 0.25 * y, 0.3)), ankle],
            foot: [at(-0.155, 0.225 * y, 0.285), at(0.11, 0.235 * y, 0.285)],
        }
    };
    Pose {
        trunk: [at(-0.27, 0.0, 0.83), at(-0.21, 0.0, 1.08), at(-0.07 + lean, 0.0, 1.44)],
        head: at(0.0 + lean, 0.0, 1.60),
        up: DVec3::Z,
        left: side(1.0),
        right: side(-1.0),
        girth,
        cover: Cover::Full,
    }
}
