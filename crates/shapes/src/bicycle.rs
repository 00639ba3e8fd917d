//! A bicycle with its rider.

use super::blueprint::{Blueprint, Fit};
use super::figure::{Cover, Pose, Side, add_figure, joint};
use super::solids::{Ring, at, rod, tube, tyre};
use super::variation::Variation;
use geometry::DVec3;

/// A cyclist.
pub(super) fn draft(variation: &mut Variation) -> Blueprint {
    let lean = variation.next(0.03);
    let base = variation.next(0.02);
    let girth = 1.0 + variation.next(0.05);
    let rear = at(-0.545, 0.0, 0.345);
    let front = at(0.585 + base, 0.0, 0.345);
    let bottom = at(-0.09, 0.0, 0.29);
    let cluster = at(-0.245, 0.0, 0.80);
    let head = at(0.345, 0.0, 0.84);
    let crown = at(0.39, 0.0, 0.71);
    let mut blueprint = Blueprint::default();
    for (place, axle) in [("front", front), ("rear", rear)] {
        let wheel = tyre(axle, 0.345, 0.300, 0.044);
        blueprint.add(&format!("wheel-{place}"), wheel, [5, 3, 1]).fit = Fit::Round;
        let hub = rod(&[axle - at(0.0, 0.06, 0.0), axle + at(0.0, 0.06, 0.0)], 0.022);
        blueprint.add(&format!("hub-{place}"), hub, [1, 1, 1]).fit = Fit::Round;
    }
    let mut bar = |part: &str, path: &[DVec3], radius: f64| {
        blueprint.add(part, rod(path, radius), [1, 1, 1]);
    };
    bar("frame-seat-tube", &[bottom + at(-0.003, 0.0, 0.006), at(-0.285, 0.0, 0.93)], 0.017);
    bar("frame-top-tube", &[cluster, head - at(0.0, 0.0, 0.03)], 0.016);
    bar("frame-down-tube", &[bottom, crown], 0.020);
    bar(
        "frame-head-tube",
        &[crown - at(-0.012, 0.0, 0.04), at(0.32, 0.0, 0.985), at(0.41, 0.0, 1.005)],
        0.022,
    );
    let leg = rod(
        &[crown + at(0.0, 0.03, -0.01), crown + at(0.03, 0.05, -0.06), front + at(0.0, 0.05, 0.0)],
        0.013,
    );
    blueprint.add_pair("frame-fork-{}", &leg, [1, 1, 1], Fit::Stretched);
    let stay = [
        bottom + at(0.0, 0.035, 0.0),
        rear + at(0.03, 0.055, 0.0),
        rear + at(0.0, 0.055, 0.03),
        cluster + at(0.0, 0.018, 0.0),
    ];
    blueprint.add_pair("frame-stay-{}", &rod(&stay, 0.010), [2, 1, 1], Fit::Stretched);
    let handle =
        [at(0.33, 0.30, 1.01), at(0.40, 0.13, 1.00), at(0.40, -0.13, 1.00), at(0.33, -0.30, 1.01)];
    blueprint.add("handlebar", rod(&handle, 0.014), [2, 1, 1]);
    let saddle: [Ring; 5] = [
        (at(-0.42, 0.0, 0.955), 0.05, 0.018),
        (at(-0.41, 0.0, 0.955), 0.075, 0.026),
        (at(-0.30, 0.0, 0.950), 0.065, 0.028),
        (at(-0.19, 0.0, 0.945), 0.025, 0.022),
        (at(-0.14, 0.0, 0.940), 0.020, 0.016),
    ];
    blueprint.add("saddle", tube(&saddle, DVec3::Y), [1, 1, 1]);
    // Cranks: left one ahead and low, right one behind and high.
    let crank = at(0.135, 0.0, -0.105);
    let cranks = [(1.0, "left", bottom + crank), (-1.0, "right", bottom - crank)];
    for (y, name, end) in cranks {
        let path = [
            bottom + at(0.0, 0.05 * y, 0.0),
            end + at(0.0, 0.07 * y, 0.0),
            end + at(0.0, 0.16 * y, 0.0),
        ];
        blueprint.add(&format!("crank-{name}"), rod(&path, 0.013), [2, 1, 1]);
    }
    let [left, right] = cranks.map(|(y, _, end)| side(y, end, lean));
    let pose = Pose {
        trunk: [at(-0.285, 0.0, 0.945), at(-0.20, 0.0, 1.195), at(0.01 + lean, 0.0, 1.50)],
        head: at(0.10 + lean, 0.0, 1.635),
        up: at(-0.06, 0.0, 0.998),
        left,
        right,
        girth,
        cover: Cover::Cap,
    };
    add_figure(&mut blueprint, &pose);
    blueprint
}

/// One side of the rider: hand on the bar, foot on the pedal at the end of its crank.
fn side(y: f64, pedal: DVec3, lean: f64) -> Side {
    let hip = at(-0.28, 0.090 * y, 1.00);
    let sole = pedal + at(0.0, 0.115 * y, 0.02);
    let ankle = sole + at(-0.125, -0.005 * y, 0.135);
    let shoulder = at(0.0 + lean, 0.180 * y, 1.435);
    let wrist = at(0.315, 0.255 * y, 1.055);
    Side {
        arm: [
            shoulder,
            joint(shoulder, wrist, 0.29, 0.26, at(-0.4, 0.8 * y, -0.5)),
            wrist,
            at(0.365, 0.25 * y, 1.03),
        ],
        leg: [hip, joint(hip, ankle, 0.43, 0.43, at(1.0, 0.12 * y, 0.3)), ankle],
        foot: [sole + at(-0.185, 0.0, 0.035), sole + at(0.075, 0.005 * y, -0.005)],
    }
}
