//! Worked vectors, and the laws on which assessment relies.

use super::*;
use proptest::prelude::*;

fn side(mass: f64, arm_m: [f64; 2], k: f64) -> ImpactBody {
    ImpactBody { inverse_mass: 1.0 / mass, gyration_m: k, arm_m }
}

fn impact(velocity_m_s: [f64; 2], e: f64, mu: f64, sides: [ImpactBody; 2]) -> Impact {
    Impact { velocity_m_s, surface: Surface::Coupled { restitution: e, friction: mu }, sides }
}

fn near(value: f64, expected: f64, last_digit: f64) {
    assert!((value - expected).abs() <= last_digit, "{value} is not {expected}");
}

#[test]
fn central_impacts() {
    let sides = [side(1200.0, [2.0, 0.0], 1.26), side(1800.0, [-2.0, 0.0], 1.26)];
    let d1 = impact([20.0, 0.0], 0.0, 0.7, sides).respond();
    near(d1.delta_v_m_s[0], 12.0, 1e-9);
    near(d1.delta_v_m_s[1], 8.0, 1e-9);
    near(d1.energy_j, 144_000.0, 1e-6);
    let d2 = impact([20.0, 0.0], 0.1, 0.7, sides).respond();
    near(d2.delta_v_m_s[0], 13.2, 1e-9);
    near(d2.energy_j, 142_560.0, 1e-6);
    assert_eq!(d2.delta_yaw_rad_s, [0.0; 2]);
}

/// Without friction an arm across the normal takes part of the impulse: D3 of the worked vectors.
#[test]
fn an_arm_turns_part_of_the_impulse_into_spin() {
    let sides = [side(1200.0, [0.0, 0.6], 1.26), side(1800.0, [0.0, 0.0], 1.26)];
    let d3 = impact([20.0, 0.0], 0.1, 0.0, sides).respond();
    near(d3.normal_n_s, 13_942.99, 0.01);
    near(d3.delta_v_m_s[0], 11.619, 1e-3);
    near(d3.energy_j, 125_487.0, 1.0);
    // Hit at the left, it turns to the left: the other one pushes it back there.
    near(d3.delta_yaw_rad_s[0], 0.6 * 13_942.99 / (1200.0 * 1.26 * 1.26), 1e-3);
}

/// Sticking: the point of contact has the relative velocity that e leaves, and does not slide.
#[test]
fn a_sticking_impact_ends_the_sliding() {
    let sides = [side(1200.0, [1.8, 0.4], 1.26), side(1800.0, [-1.9, 0.3], 1.33)];
    let before = [10.0, 2.0];
    let response = impact(before, 0.1, 5.0, sides).respond();
    assert!(!response.slides);
    let after = relative_after(before, &response, &sides);
    near(after[0], -1.0, 1e-9);
    near(after[1], 0.0, 1e-9);
}

/// The relative velocity at the point of contact after an impact, from the bodies' own motions.
fn relative_after(before: [f64; 2], response: &Response, sides: &[ImpactBody; 2]) -> [f64; 2] {
    let mut after = before;
    for (p, side) in sides.iter().enumerate() {
        let sign = if p == 0 { 1.0 } else { -1.0 };
        let change =
            [response.normal_n_s, response.tangential_n_s].map(|j| -sign * j * side.inverse_mass);
        let turn = response.delta_yaw_rad_s[p];
        let of_turning = [-turn * side.arm_m[1], turn * side.arm_m[0]];
        for axis in 0..2 {
            after[axis] += sign * (change[axis] + of_turning[axis]);
        }
    }
    after
}

#[test]
fn who_does_not_come_nearer_exchanges_nothing() {
    let one = side(1500.0, [1.0, 0.3], 1.2);
    for v in [[0.0, 5.0], [-3.0, 1.0], [f64::NAN, 0.0]] {
        assert_eq!(impact(v, 0.1, 0.7, [one; 2]).respond(), Response::default());
    }
}

/// MASH 3-11: 2,250 kg at 28 m/s and 25.5° along a rigid barrier.
#[test]
fn a_barrier_turns_a_car_along_itself() {
    let (sin, cos) = libm::sincos(25.5_f64.to_radians());
    let wall = ImpactBody { inverse_mass: 0.0, gyration_m: 1.0, arm_m: [0.0; 2] };
    let impact = Impact {
        velocity_m_s: [28.0 * sin, 28.0 * cos],
        surface: Surface::Redirecting {
            restitution: 0.1,
            restitution_more: 0.2,
            tangential_share: 0.2,
        },
        sides: [side(2250.0, [2.0, 0.5], 1.4), wall],
    };
    let response = impact.respond();
    let across = 1.3 * 28.0 * sin;
    near(response.normal_n_s, 2250.0 * across, 1e-6);
    near(response.tangential_n_s, 0.2 * response.normal_n_s, 1e-6);
    near(response.delta_v_m_s[0], across * libm::sqrt(1.04), 1e-9);
}

fn impacts() -> impl Strategy<Value = Impact> {
    // Arms as far as bodies reach whose radius of gyration is 0.28 of their length.
    let arm = || (60.0..30_000.0_f64, -1.8..1.8_f64, -1.8..1.8_f64, 0.2..3.0_f64);
    let sides = (arm(), arm());
    (0.01..40.0_f64, -40.0..40.0_f64, 0.0..0.3_f64, 0.0..1.0_f64, sides).prop_map(
        |(n, t, e, mu, ((m, q, h, k), (m2, q2, h2, k2)))| {
            impact([n, t], e, mu, [side(m, [q * k, h * k], k), side(m2, [q2 * k2, h2 * k2], k2)])
        },
    )
}

proptest! {
    #[test]
    fn scaling_velocities_scales_the_response(base in impacts(), grow in 1.0..3.0_f64) {
        let faster = Impact { velocity_m_s: base.velocity_m_s.map(|v| v * grow), ..base };
        let (before, after) = (base.respond(), faster.respond());
        for p in 0..2 {
            let expected = before.delta_v_m_s[p] * grow;
            prop_assert!((after.delta_v_m_s[p] - expected).abs() <= 1e-9 * (1.0 + expected));
        }
    }

    /// Evidence, not proof: what ranges and the laws of harm rely on.
    #[test]
    fn delta_v_rises_with_the_partners_mass_and_falls_with_the_own(
        base in impacts(),
        grow in 1.0..2.0_f64,
    ) {
        let with = |p: usize, by: f64| {
            let mut other = base;
            other.sides[p].inverse_mass *= by;
            other.respond().delta_v_m_s[0]
        };
        let before = base.respond().delta_v_m_s[0];
        prop_assert!(with(1, 1.0 / grow) >= before * (1.0 - 1e-9));
        prop_assert!(with(0, 1.0 / grow) <= before * (1.0 + 1e-9));
    }

    /// Proven bounds.
    #[test]
    fn an_impulse_has_a_most(i in impacts()) {
        let response = i.respond();
        let Surface::Coupled { restitution, .. } = i.surface else { return Ok(()) };
        let inverse = i.sides[0].inverse_mass + i.sides[1].inverse_mass;
        let [n, t] = i.velocity_m_s;
        let most = (1.0 + restitution) * libm::sqrt(n * n + t * t) / inverse;
        for (side, delta_v) in i.sides.iter().zip(response.delta_v_m_s) {
            prop_assert!(delta_v <= most * side.inverse_mass * (1.0 + 1e-12));
        }
        let all = 0.5 * (n * n + t * t) / inverse;
        prop_assert!((0.0..=all * (1.0 + 1e-9)).contains(&response.energy_j));
    }

    /// Mirrored, the same happens mirrored; exchanged, the same happens.
    #[test]
    fn mirror_and_exchange_change_nothing(i in impacts()) {
        let response = i.respond();
        let [n, t] = i.velocity_m_s;
        let mirrored = |side: &ImpactBody| {
            ImpactBody { arm_m: [side.arm_m[0], -side.arm_m[1]], ..*side }
        };
        let sides = [mirrored(&i.sides[0]), mirrored(&i.sides[1])];
        let mirror = Impact { velocity_m_s: [n, -t], sides, ..i }.respond();
        let turned = |side: &ImpactBody| ImpactBody { arm_m: side.arm_m.map(|x| -x), ..*side };
        let sides = [turned(&i.sides[1]), turned(&i.sides[0])];
        let exchange = Impact { sides, ..i }.respond();
        for p in 0..2 {
            let size = 1e-9 * (1.0 + response.delta_v_m_s[p]);
            prop_assert!((mirror.delta_v_m_s[p] - response.delta_v_m_s[p]).abs() <= size);
            prop_assert!((exchange.delta_v_m_s[1 - p] - response.delta_v_m_s[p]).abs() <= size);
            prop_assert!((mirror.delta_yaw_rad_s[p] + response.delta_yaw_rad_s[p]).abs() <= 1e-6);
        }
    }
}
