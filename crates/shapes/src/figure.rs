//! People: a figure put together from a pose, and a pedestrian walking.

use super::blueprint::{Blueprint, Fit};
use super::solids::{Ring, at, tube};
use super::surface::{Cells, Surface};
use super::variation::Variation;
use geometry::DVec3;

/// The joints of one side.
#[derive(Clone, Copy, Debug)]
pub(super) struct Side {
    /// Shoulder, elbow, wrist, middle of the fist.
    pub(super) arm: [DVec3; 4],
    /// Hip, knee, ankle.
    pub(super) leg: [DVec3; 3],
    /// Heel and tip of the shoe, at sole height.
    pub(super) foot: [DVec3; 2],
}

/// A pose: the positions of the joints (m), for a person 1.75 m tall.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pose {
    /// Crotch, waist, and base of the neck.
    pub(super) trunk: [DVec3; 3],
    /// Middle of the head.
    pub(super) head: DVec3,
    /// Unit vector from the chin to the top of the head.
    pub(super) up: DVec3,
    /// Left side.
    pub(super) left: Side,
    /// Right side.
    pub(super) right: Side,
    /// Girth, 1 is usual.
    pub(super) girth: f64,
    /// What the person wears on the head.
    pub(super) cover: Cover,
}

/// What is on the head.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Cover {
    /// Hair.
    Hair,
    /// A helmet of a cyclist: the face is free.
    Cap,
    /// A helmet of a motorcyclist with a visor.
    Full,
}

/// Minimum number of cells of a limb.
const LIMB: Cells = [2, 1, 1];
/// Minimum number of cells of a hand or shoe.
const TIP: Cells = [1, 1, 1];

/// Adds the person.
pub(super) fn add_figure(blueprint: &mut Blueprint, pose: &Pose) {
    let add = |blueprint: &mut Blueprint, part: &str, surface: Surface, least: Cells| {
        blueprint.add(part, surface, least).fit = Fit::Stretched;
    };
    add(blueprint, "torso", torso(pose), [3, 1, 1]);
    add(blueprint, "hips", hips(pose), LIMB);
    add_head(blueprint, pose);
    for (side, name) in [(&pose.left, "left"), (&pose.right, "right")] {
        let g = pose.girth;
        add(blueprint, &format!("arm-{name}"), sleeve(side, g), LIMB);
        add(blueprint, &format!("hand-{name}"), hand(side), TIP);
        add(blueprint, &format!("leg-{name}"), leg(side, g), LIMB);
        add(blueprint, &format!("shoe-{name}"), shoe(side), TIP);
    }
}

/// How far up, half width, half depth, and how far forward of the spine.
type Girdle = (f64, f64, f64, f64);

/// A ring around the spine from `from` to `to`.
fn girdle(from: DVec3, to: DVec3, g: f64, (up, wide, deep, fore): Girdle) -> Ring {
    let heading = (to - from).normalize_or_zero();
    let front = at(heading.z, 0.0, -heading.x);
    (from + (to - from) * up + front * fore, wide * g, deep * g)
}

/// The seat of the trousers.
fn hips(pose: &Pose) -> Surface {
    let [crotch, waist, _] = pose.trunk;
    let rings = [
        (0.0, 0.06, 0.05, 0.0),
        (0.0, 0.12, 0.085, 0.0),
        (0.25, 0.168, 0.116, -0.012),
        (0.60, 0.160, 0.112, -0.012),
        (0.75, 0.150, 0.104, -0.006),
        (0.75, 0.100, 0.070, -0.006),
    ];
    tube(&rings.map(|ring| girdle(crotch, waist, pose.girth, ring)), DVec3::Y)
}

/// From the hem of the jacket to the neck.
fn torso(pose: &Pose) -> Surface {
    let [crotch, waist, neck] = pose.trunk;
    let lower =
        [(0.34, 0.172, 0.122, -0.012), (0.60, 0.168, 0.122, -0.012), (1.0, 0.152, 0.110, 0.0)];
    let upper = [
        (0.25, 0.158, 0.114, 0.010),
        (0.52, 0.176, 0.124, 0.014),
        (0.74, 0.190, 0.118, 0.006),
        (0.89, 0.186, 0.092, -0.004),
        (0.97, 0.130, 0.074, -0.008),
        (1.03, 0.066, 0.062, -0.002),
    ];
    let collar = [(0.30, 0.054, 0.056, 0.010), (0.60, 0.052, 0.056, 0.020)];
    let g = pose.girth;
    let rings: Vec<Ring> = lower
        .iter()
        .map(|ring| girdle(crotch, waist, g, *ring))
        .chain(upper.iter().map(|ring| girdle(waist, neck, g, *ring)))
        .chain(collar.iter().map(|ring| girdle(neck, pose.head, 1.0, *ring)))
        .collect();
    tube(&rings, DVec3::Y)
}

fn add_head(blueprint: &mut Blueprint, pose: &Pose) {
    let up = pose.up;
    let front = at(up.z, 0.0, -up.x);
    // Height over the middle, half width, half depth, forward.
    let ring = |(h, wide, deep, fore): (f64, f64, f64, f64)| -> Ring {
        (pose.head + up * h + front * fore, wide, deep)
    };
    let face = [
        (-0.122, 0.020, 0.022, 0.050),
        (-0.120, 0.042, 0.044, 0.044),
        (-0.095, 0.058, 0.070, 0.026),
        (-0.045, 0.070, 0.090, 0.010),
        (0.010, 0.076, 0.097, 0.002),
        (0.060, 0.076, 0.098, -0.004),
        (0.100, 0.064, 0.082, -0.006),
        (0.116, 0.040, 0.050, -0.006),
        (0.116, 0.018, 0.022, -0.006),
    ];
    let head = |rings: &[(f64, f64, f64, f64)]| {
        let rings: Vec<Ring> = rings.iter().map(|r| ring(*r)).collect();
        tube(&rings, DVec3::Y)
    };
    match pose.cover {
        Cover::Hair => {
            blueprint.add("head", head(&face), [3, 1, 1]);
            let hair = [
                (-0.060, 0.052, 0.050, -0.050),
                (-0.055, 0.070, 0.066, -0.042),
                (0.010, 0.083, 0.088, -0.024),
                (0.062, 0.085, 0.100, -0.012),
                (0.105, 0.072, 0.090, -0.008),
                (0.126, 0.046, 0.058, -0.008),
                (0.128, 0.020, 0.026, -0.008),
            ];
            blueprint.add("hair", head(&hair), [2, 1, 1]);
        }
        Cover::Cap => {
            blueprint.add("head", head(&face), [3, 1, 1]);
            let cap = [
                (0.028, 0.060, 0.080, -0.010),
                (0.030, 0.096, 0.125, -0.010),
                (0.070, 0.102, 0.136, -0.010),
                (0.118, 0.088, 0.118, -0.014),
                (0.142, 0.058, 0.080, -0.016),
                (0.144, 0.026, 0.036, -0.016),
            ];
            blueprint.add("helmet", head(&cap), [2, 1, 1]);
        }
        Cover::Full => {
            let shell = [
                (-0.126, 0.050, 0.060, 0.020),
                (-0.124, 0.082, 0.096, 0.022),
                (-0.070, 0.112, 0.140, 0.016),
                (0.000, 0.120, 0.146, 0.000),
                (0.070, 0.116, 0.142, -0.008),
                (0.122, 0.090, 0.110, -0.012),
                (0.144, 0.052, 0.064, -0.012),
                (0.146, 0.024, 0.030, -0.012),
            ];
            let shell = head(&shell);
            // Row and column parameters of the helmet: column 7 is the front.
            if let Surface::Tube { net, .. } = &shell {
                let visor = [(2.2, 5.9), (2.2, 8.1), (3.7, 8.1), (3.7, 5.9)];
                blueprint.add_pad("visor", net, visor, 0.4);
            }
            blueprint.add("helmet", shell, [3, 1, 1]);
        }
    }
}

/// A point between two points.
fn between(a: DVec3, b: DVec3, share: f64) -> DVec3 {
    a + (b - a) * share
}

/// The middle joint of a limb: at distance `upper` from `from` and `lower` from `to` (m), on the
/// side of `towards`. A limb that is too short is stretched.
pub(super) fn joint(from: DVec3, to: DVec3, upper: f64, lower: f64, towards: DVec3) -> DVec3 {
    let reach = to - from;
    let distance = reach.length();
    let heading = reach.normalize_or_zero();
    let along = (upper * upper - lower * lower + distance * distance) / (2.0 * distance);
    let out = (upper * upper - along * along).max(0.0).sqrt();
    let across = (towards - heading * towards.dot(heading)).normalize_or_zero();
    from + heading * along + across * out
}

fn sleeve(side: &Side, g: f64) -> Surface {
    let [shoulder, elbow, wrist, _] = side.arm;
    // From inside the chest over the shoulder.
    let start = shoulder + at(0.0, -0.45 * shoulder.y, 0.0);
    let rings = [
        (start, 0.040, 0.040),
        (between(start, shoulder, 0.7), 0.056 * g, 0.060 * g),
        (shoulder + (elbow - shoulder) * 0.08, 0.064 * g, 0.064 * g),
        (between(shoulder, elbow, 0.35), 0.056 * g, 0.058 * g),
        (between(shoulder, elbow, 0.80), 0.046 * g, 0.046 * g),
        (elbow, 0.045 * g, 0.045 * g),
        (between(elbow, wrist, 0.30), 0.045 * g, 0.045 * g),
        (between(elbow, wrist, 0.90), 0.034, 0.034),
        (wrist, 0.033, 0.033),
    ];
    tube(&rings, DVec3::X)
}

fn hand(side: &Side) -> Surface {
    let [_, _, wrist, fist] = side.arm;
    let tip = fist + (fist - wrist).normalize_or_zero() * 0.065;
    let rings = [
        (between(wrist, fist, -0.2), 0.022, 0.024),
        (between(wrist, fist, 0.2), 0.023, 0.028),
        (fist, 0.022, 0.044),
        (between(fist, tip, 0.6), 0.019, 0.040),
        (tip, 0.013, 0.026),
        (tip, 0.005, 0.010),
    ];
    tube(&rings, DVec3::Y)
}

fn leg(side: &Side, g: f64) -> Surface {
    let [hip, knee, ankle] = side.leg;
    let start = hip + (hip - knee).normalize_or_zero() * 0.06;
    let rings = [
        (start, 0.070, 0.075),
        (hip, 0.090 * g, 0.100 * g),
        (between(hip, knee, 0.3), 0.085 * g, 0.094 * g),
        (between(hip, knee, 0.85), 0.062 * g, 0.066 * g),
        (knee, 0.060 * g, 0.064 * g),
        (between(knee, ankle, 0.3), 0.060 * g, 0.064 * g),
        (between(knee, ankle, 0.85), 0.052, 0.056),
        (ankle, 0.053, 0.058),
    ];
    tube(&rings, DVec3::Y)
}

/// A shoe with a flat sole.
fn shoe(side: &Side) -> Surface {
    let [heel, toe] = side.foot;
    let along = (toe - heel).normalize_or_zero();
    let up = along.cross(DVec3::Y) * -1.0;
    let up = if up.z < 0.0 { -up } else { up };
    let length = heel.distance(toe);
    // Share of the length, half width, height of the upper side.
    let stations = [
        (0.0, 0.032, 0.075),
        (0.12, 0.040, 0.105),
        (0.32, 0.042, 0.110),
        (0.55, 0.046, 0.078),
        (0.80, 0.052, 0.060),
        (0.97, 0.044, 0.048),
        (1.0, 0.030, 0.040),
    ];
    let rings: Vec<Ring> = stations
        .iter()
        .map(|(share, wide, high)| {
            (heel + along * (share * length) + up * (0.5 * high), *wide, 0.56 * high)
        })
        .collect();
    let surface = tube(&rings, DVec3::Y);
    surface.map(|p| {
        let under = (p - heel).dot(up);
        if under < 0.0 { p - up * under } else { p }
    })
}

/// A person in mid-stride, left leg ahead.
pub(super) fn draft(variation: &mut Variation) -> Blueprint {
    let stride = 1.0 + variation.next(0.12);
    let swing = 1.0 + variation.next(0.15);
    let girth = 1.0 + variation.next(0.06);
    let left = Side {
        arm: [
            at(0.0, 0.185, 1.405),
            at(-0.10 * swing, 0.255, 1.145),
            at(-0.13 * swing, 0.265, 0.905),
            at(-0.12 * swing, 0.262, 0.845),
        ],
        leg: [
            at(0.0, 0.090, 0.90),
            at(0.19 * stride, 0.095, 0.50),
            at(0.29 * stride, 0.095, 0.115),
        ],
        foot: [at(0.29 * stride - 0.075, 0.100, 0.005), at(0.29 * stride + 0.185, 0.110, 0.045)],
    };
    let right = Side {
        arm: [
            at(0.0, -0.185, 1.405),
            at(0.03 * swing, -0.255, 1.140),
            at(0.21 * swing, -0.250, 0.960),
            at(0.265 * swing, -0.245, 0.925),
        ],
        leg: [
            at(0.0, -0.090, 0.90),
            at(0.06 * stride, -0.095, 0.49),
            at(-0.27 * stride, -0.095, 0.19),
        ],
        foot: [at(-0.27 * stride - 0.095, -0.100, 0.115), at(-0.27 * stride + 0.12, -0.105, 0.0)],
    };
    let pose = Pose {
        trunk: [at(0.0, 0.0, 0.815), at(0.005, 0.0, 1.08), at(0.0, 0.0, 1.475)],
        head: at(0.025, 0.0, 1.635),
        up: DVec3::Z,
        left,
        right,
        girth,
        cover: Cover::Hair,
    };
    let mut blueprint = Blueprint::default();
    add_figure(&mut blueprint, &pose);
    blueprint
}
