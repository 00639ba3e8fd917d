//! The worked vectors D1 to D6, and the laws on which end points rely.

use super::*;
use proptest::prelude::*;

mod coupled;

fn side(mass: f64, h: f64, q: f64, k: f64) -> ImpactBody {
    ImpactBody { inverse_mass: 1.0 / mass, gyration_m: k, across_m: h, along_m: q }
}

fn impact(speeds: [f64; 2], e: f64, mu: f64, sides: [ImpactBody; 2]) -> Impact {
    let [normal_m_s, tangential_m_s] = speeds;
    Impact { normal_m_s, tangential_m_s, restitution: e, friction: mu, sides }
}

fn near(value: f64, expected: f64, last_digit: f64) {
    assert!((value - expected).abs() <= last_digit, "{value} is not {expected}");
}

#[test]
fn d1_d2_central_impacts() {
    let sides = [side(1200.0, 0.0, 0.0, 1.26), side(1800.0, 0.0, 0.0, 1.26)];
    let d1 = impact([20.0, 0.0], 0.0, 0.45, sides).respond();
    near(d1.delta_v_m_s[0], 12.0, 1e-3);
    near(d1.delta_v_m_s[1], 8.0, 1e-3);
    near(d1.energy_j, 144_000.0, 1.0);
    let d2 = impact([20.0, 0.0], 0.1, 0.45, sides).respond();
    near(d2.delta_v_m_s[0], 13.2, 1e-3);
    near(d2.delta_v_m_s[1], 8.8, 1e-3);
    near(d2.energy_j, 142_560.0, 1.0);
}

#[test]
fn d3_a_lever_arm_turns_part_of_the_impulse_into_spin() {
    let sides = [side(1200.0, 0.6, 0.0, 1.26), side(1800.0, 0.0, 0.0, 1.26)];
    let d3 = impact([20.0, 0.0], 0.1, 0.45, sides).respond();
    near(d3.normal_n_s, 13_942.99, 0.01);
    near(d3.delta_v_m_s[0], 11.619, 1e-3);
    near(d3.delta_v_m_s[1], 7.746, 1e-3);
    near(d3.energy_j, 125_487.0, 1.0);
}

#[test]
fn d4_a_fixed_object_takes_no_velocity() {
    let wall = ImpactBody { inverse_mass: 0.0, ..side(1.0, 3.0, 3.0, 1.0) };
    let d4 = impact([15.0, 0.0], 0.1, 0.45, [side(1500.0, 0.5, 0.0, 1.26), wall]).respond();
    near(d4.delta_v_m_s[0], 14.255, 1e-3);
    assert_eq!(d4.delta_v_m_s[1], 0.0);
    let front = crate::injury::Curves::shipped().expect("sound");
    let rung = front.rung(crate::injury::Victim::OccupantFront, crate::curve::Level::Mais3);
    near(front.nominal(rung.expect("has a curve")).risk(d4.delta_v_m_s[0]), 0.11620, 1e-5);
}

#[test]
fn d5_a_sideswipe_slides() {
    let one = side(1500.0, 0.4, 0.9, 1.26);
    let d5 = impact([0.8, 24.0], 0.1, 0.45, [one, one]).respond();
    near(d5.tangential_n_s, 269.808, 1e-3);
    near(d5.delta_v_m_s[0], 0.4383, 1e-4);
    near(d5.delta_v_m_s[1], 0.4383, 1e-4);
    near(d5.energy_j, 6618.0, 0.1);
}

#[test]
fn d6_slow_sliding_sticks() {
    let sides = [side(1200.0, 0.0, 1.8, 1.26), side(1800.0, 0.0, 1.8, 1.33)];
    let d6 = impact([10.0, 2.0], 0.1, 0.45, sides).respond();
    near(d6.tangential_n_s, 486.956, 1e-3);
    near(d6.delta_v_m_s[0], 6.612, 1e-3);
    near(d6.delta_v_m_s[1], 4.408, 1e-3);
    near(d6.energy_j, 36_127.0, 0.1);
}

#[test]
fn parameters_out_of_order_are_refused() {
    assert_eq!(Parameters::default().check(), Ok(()));
    let mut odd = Parameters::default();
    odd.restitution.high = 1.5;
    assert!(odd.check().is_err_and(|e| e.to_string().contains("restitution")));
    let odd = Parameters { pose_error_m: f64::NAN, ..Parameters::default() };
    assert!(odd.check().is_err_and(|e| e.to_string().contains("pose error")));
    let odd = Parameters { mass_share: 1.0, ..Parameters::default() };
    assert!(odd.check().is_err_and(|e| e.to_string().contains("mass share")));
}

fn impacts() -> impl Strategy<Value = Impact> {
    let arm = || (60.0..30_000.0_f64, 0.0..2.5_f64, 0.0..2.5_f64, 0.2..3.0_f64);
    let sides = (arm(), arm());
    (0.0..40.0_f64, 0.0..40.0_f64, 0.0..0.3_f64, 0.0..0.6_f64, sides).prop_map(
        |(n, t, e, mu, ((m, h, q, k), (m2, h2, q2, k2)))| {
            impact([n, t], e, mu, [side(m, h, q, k), side(m2, h2, q2, k2)])
        },
    )
}

proptest! {
    /// What the end points of every interval rely on.
    #[test]
    fn delta_v_moves_one_way_with_every_input(base in impacts(), grow in 1.0..2.0_f64) {
        let with = |change: &dyn Fn(&mut Impact)| {
            let mut other = base;
            change(&mut other);
            other.respond()
        };
        let before = base.respond();
        let rises = [
            with(&|i| i.normal_m_s *= grow),
            with(&|i| i.tangential_m_s *= grow),
            with(&|i| i.restitution *= grow),
            with(&|i| i.friction *= grow),
            with(&|i| i.sides[0].gyration_m *= grow),
            with(&|i| i.sides[1].gyration_m *= grow),
            with(&|i| i.sides[1].inverse_mass /= grow),
        ];
        for after in rises {
            prop_assert!(after.delta_v_m_s[0] >= before.delta_v_m_s[0] * (1.0 - 1e-12));
        }
        let falls = [
            with(&|i| i.sides[0].across_m *= grow),
            with(&|i| i.sides[1].across_m *= grow),
            with(&|i| i.sides[0].along_m *= grow),
            with(&|i| i.sides[1].along_m *= grow),
            with(&|i| i.sides[0].inverse_mass /= grow),
        ];
        for (k, after) in falls.iter().enumerate() {
            prop_assert!(after.delta_v_m_s[0] <= before.delta_v_m_s[0] * (1.0 + 1e-12));
            prop_assert!(k > 3 || after.energy_j <= before.energy_j * (1.0 + 1e-12));
        }
    }

    /// Energy is lost, never won, and never more than there was.
    #[test]
    fn energy_lost_is_between_nothing_and_all(i in impacts()) {
        let response = i.respond();
        let mass = 1.0 / (i.sides[0].inverse_mass + i.sides[1].inverse_mass);
        let all = 0.5 * mass * (i.normal_m_s * i.normal_m_s + i.tangential_m_s * i.tangential_m_s);
        prop_assert!((0.0..=all * (1.0 + 1e-12)).contains(&response.energy_j));
    }

    /// The published special cases.
    #[test]
    fn central_impacts_are_those_of_the_literature(
        m1 in 60.0..30_000.0_f64,
        m2 in 60.0..30_000.0_f64,
        v in 0.0..40.0_f64,
        e in 0.0..0.3_f64,
    ) {
        let sides = [side(m1, 0.0, 0.0, 1.0), side(m2, 0.0, 0.0, 1.0)];
        let dv = |e: f64| impact([v, 0.0], e, 0.0, sides).respond().delta_v_m_s[0];
        prop_assert!((dv(0.0) - m2 / (m1 + m2) * v).abs() < 1e-9);
        prop_assert!((dv(e) - (1.0 + e) * v / (1.0 + m1 / m2)).abs() < 1e-9);
    }
}
