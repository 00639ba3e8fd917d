//! Other methods: overlapping boxes, and the harm formula of TUM.
//!
//! The formula is that of Geisslinger et al. (EthicalTrajectoryPlanning, `harm_parameters.json`,
//! reduced symmetric model), from its published coefficients: ΔV = m₂/(m₁+m₂)·|v_rel|, the whole
//! closing speed and no contact; p = 1/(1+exp(-(a + b ΔV + side))) for the protected, another curve
//! for those outside of vehicles. It knows neither lever arms nor what is fixed, and at ΔV = 0 it
//! still gives a protected person 1.1 % and another one 4.1 %.

use super::cases::{Alternative, Placed};

/// What the formula gives for one alternative.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Formula {
    /// Harm of the ego's occupant.
    pub(crate) ego: f64,
    /// Harm of the other party's person.
    pub(crate) other: f64,
}

impl Formula {
    /// The mean over both.
    pub(crate) fn mean(self) -> f64 {
        0.5 * (self.ego + self.other)
    }
}

/// Mass by type and size (kg): the model of the same source.
fn mass(kind: &str, [length, width]: [f64; 2]) -> f64 {
    match kind {
        "truck" => 25_000.0,
        "bus" => 13_000.0,
        "motorcycle" => 250.0,
        "bicycle" => 90.0,
        "pedestrian" => 75.0,
        _ => -1333.5 + 526.9 * (length * width).powf(0.8),
    }
}

/// The term for the side of a vehicle that the impact comes from (rad from forward).
fn side(angle: f64) -> f64 {
    let off = angle.sin().atan2(angle.cos()).abs().to_degrees();
    if off < 45.0 {
        0.0
    } else if off <= 135.0 {
        0.244
    } else {
        -0.431
    }
}

fn logistic(x: f64) -> f64 {
    1.0 / (1.0 + (-x).exp())
}

/// Harm of the protected (MAIS3+), for a change of velocity (m/s) from a side.
fn protected(delta_v: f64, angle: f64) -> f64 {
    logistic(-4.457 + 0.177 * delta_v + side(angle))
}

/// Harm of persons outside of vehicles (MAIS3+).
fn unprotected(delta_v: f64) -> f64 {
    logistic(-3.164 + 0.288 * delta_v)
}

/// The formula for one alternative.
pub(crate) fn formula(one: &Alternative) -> Formula {
    let (a, b) = (one.ego.velocity(), one.other.velocity());
    let relative = [a[0] - b[0], a[1] - b[1]];
    let speed = relative[0].hypot(relative[1]);
    let heading = relative[1].atan2(relative[0]);
    let m = mass("car", one.ego.body.size);
    let n = mass(&one.kind, one.other.body.size);
    let (of_ego, of_other) = (n / (m + n) * speed, m / (m + n) * speed);
    let other = match one.kind.as_str() {
        "pedestrian" | "motorcycle" | "bicycle" => unprotected(of_other),
        _ => protected(of_other, heading + std::f64::consts::PI - one.other.yaw),
    };
    Formula { ego: protected(of_ego, heading - one.ego.yaw), other }
}

/// The corners of a rectangle in plan (m).
pub(crate) fn corners(placed: &Placed) -> [[f64; 2]; 4] {
    let [length, width] = placed.body.size.map(|x| 0.5 * x);
    let (sin, cos) = placed.yaw.sin_cos();
    [[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]].map(|[i, j]| {
        let (x, y) = (i * length, j * width);
        [placed.at[0] + x * cos - y * sin, placed.at[1] + x * sin + y * cos]
    })
}

/// Whether two rectangles overlap (separating axes), the second moved.
pub(crate) fn overlap(a: &Placed, b: &Placed, moved: [f64; 2]) -> bool {
    let (p, q) = (corners(a), corners(b).map(|[x, y]| [x + moved[0], y + moved[1]]));
    [a.yaw, b.yaw].iter().all(|yaw| {
        let (sin, cos) = yaw.sin_cos();
        [[cos, sin], [-sin, cos]].iter().all(|axis| {
            let reach = |corners: &[[f64; 2]; 4]| {
                let along = corners.map(|c| c[0] * axis[0] + c[1] * axis[1]);
                along.iter().fold((f64::MAX, f64::MIN), |(l, h), x| (l.min(*x), h.max(*x)))
            };
            let ((l, h), (m, n)) = (reach(&p), reach(&q));
            l <= n && m <= h
        })
    })
}

/// Whether the boxes overlap anywhere from 1 m before to 1 m after the given pose, in steps of 1 cm
/// along the relative path: what a sweep of boxes calls a crash.
pub(crate) fn boxes_crash(one: &Alternative) -> bool {
    let (a, b) = (one.ego.velocity(), one.other.velocity());
    let relative = [b[0] - a[0], b[1] - a[1]];
    let speed = relative[0].hypot(relative[1]).max(1e-9);
    (-100..=100).any(|step| {
        let s = 0.01 * f64::from(step) / speed;
        overlap(&one.ego, &one.other, [relative[0] * s, relative[1] * s])
    })
}

#[cfg(test)]
mod tests {
    //! The published values, and rectangles by hand.

    use super::super::bodies::Wanted;
    use super::*;

    fn near(value: f64, expected: f64) {
        assert!((value - expected).abs() < 1e-5, "{value} is not {expected}");
    }

    /// The anchored values at 12 m/s are .07785, .09700, .05221: these are not anchored.
    #[test]
    fn the_formula_gives_its_published_values() {
        for (angle, a, anchored) in
            [(0.0, -4.457, 0.07785), (90.0, -4.213, 0.09700), (180.0, -4.888, 0.05221)]
        {
            let p = protected(12.0, f64::to_radians(angle));
            let at_rest = 1.0 / (1.0 + f64::exp(-a));
            near((p - at_rest) / (1.0 - at_rest), anchored);
        }
        near(protected(0.0, 0.0), 0.01146);
        near(unprotected(0.0), 0.04054);
        near(unprotected(11.0), 0.50100);
        assert!((mass("car", [4.508, 1.61]) - 1239.12).abs() < 0.01);
    }

    fn placed(at: [f64; 2], degrees: f64, speed: f64) -> Placed {
        let body = Wanted { kind: "car".to_owned(), size: [4.0, 2.0] };
        Placed { body, at, yaw: degrees.to_radians(), speed }
    }

    #[test]
    fn rectangles_overlap_where_no_side_separates_them() {
        let a = placed([0.0, 0.0], 0.0, 5.0);
        assert!(overlap(&a, &placed([3.9, 1.9], 0.0, 0.0), [0.0; 2]));
        assert!(!overlap(&a, &placed([3.9, 2.1], 0.0, 0.0), [0.0; 2]));
        // Turned by 45 degrees its corner is 3/√2 further towards the other.
        assert!(overlap(&a, &placed([0.0, 3.0], 45.0, 0.0), [0.0; 2]));
        assert!(!overlap(&a, &placed([0.0, 3.2], 45.0, 0.0), [0.0; 2]));
        assert!(overlap(&a, &placed([9.0, 0.0], 0.0, 0.0), [-5.5, 0.0]));
    }
}
