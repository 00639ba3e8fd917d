//! Paths keep their states, circles are circles, and what is not said goes straight on.

use super::*;
use proptest::prelude::*;

fn row(time_s: f64, x: f64) -> GivenState {
    GivenState { time_s, position_m: [x, 0.0, 0.0], angles_deg: [0.0; 3], velocity_m_s: None }
}

fn position((path, _): &Followed, time_s: f64) -> [f64; 3] {
    path.pose_at(time_s).translation
}

fn fault(rows: &[GivenState]) -> (Option<usize>, &'static str) {
    let RowFault { row, misfit } = through(rows, 5.0).unwrap_err();
    (row, misfit.setting)
}

#[test]
fn a_path_that_ends_goes_straight_on() {
    let with = |velocity_m_s| [row(0.0, 0.0), GivenState { velocity_m_s, ..row(2.0, 20.0) }];
    let followed = through(&with(None), 5.0).unwrap();
    assert_eq!((position(&followed, 5.0), followed.1), ([50.0, 0.0, 0.0], Some(2.0)));
    let followed = through(&with(Some([9.0, 1.0])), 5.0).unwrap();
    assert_eq!((position(&followed, 5.0), followed.1), ([47.0, 3.0, 0.0], Some(2.0)));
    let turned = [row(0.0, 0.0), GivenState { angles_deg: [40.0, 0.0, 0.0], ..row(2.0, 20.0) }];
    let (path, _) = through(&turned, 5.0).unwrap();
    assert_eq!(path.pose_at(5.0).rotation, path.pose_at(2.0).rotation);
    let one = [GivenState { velocity_m_s: Some([3.0, 4.0]), ..row(0.0, 1.0) }];
    let followed = through(&one, 5.0).unwrap();
    assert_eq!((position(&followed, 5.0), followed.1), ([16.0, 20.0, 0.0], Some(0.0)));
    assert_eq!(fault(&[row(0.0, 1.0)]), (Some(0), "velocity_m_s"));
}

#[test]
fn what_is_before_0_or_after_the_horizon_is_cut_off() {
    let rows = [row(-4.0, -40.0), row(-1.0, -10.0), row(3.0, 30.0), row(7.0, 70.0), row(9.0, 71.0)];
    let (path, ends_s) = through(&rows, 5.0).unwrap();
    let states: Vec<(f64, f64)> =
        path.states().iter().map(|state| (state.time_s, state.position_m[0])).collect();
    assert_eq!((states, ends_s), (vec![(0.0, 0.0), (3.0, 30.0), (5.0, 50.0)], None));
}

#[test]
fn times_that_are_0_or_the_horizon_but_for_rounding_are_these() {
    let third = 5.0 - 3.0 * f64::EPSILON;
    for (first, last) in [(1e-7, 5.0), (-1e-7, 5.0), (0.0, third), (1e-7, 5.0 + 1e-7)] {
        let (path, ends_s) = through(&[row(first, 0.0), row(last, 50.0)], 5.0).unwrap();
        assert_eq!((path.states().len(), ends_s), (2, None), "{first} {last}");
        assert_eq!([path.from_s(), path.to_s()], [0.0, 5.0]);
    }
}

#[test]
fn states_that_are_repeated_are_dropped_and_others_are_refused() {
    let (a, b, c) = (row(0.0, 0.0), row(1.0, 10.0), row(5.0, 50.0));
    assert_eq!(through(&[a, a, b, b, b, c, c], 5.0).unwrap(), through(&[a, b, c], 5.0).unwrap());
    assert_eq!(fault(&[a, b, row(1.0, 10.5), c]), (Some(2), "t_s"));
    assert_eq!(fault(&[a, b, a, c]), (Some(2), "t_s"));
    assert_eq!(fault(&[a, b, row(1.000_001, 10.0), c]), (Some(2), "t_s"));
    assert_eq!(fault(&[]), (None, "states"));
    assert_eq!(fault(&[row(0.1, 0.0), b]), (Some(0), "t_s"));
    assert_eq!(fault(&[row(-2.0, 0.0), row(-1.0, 0.0), row(-1.0, 0.0)]), (Some(1), "t_s"));
}

#[test]
fn a_body_that_jumps_or_spins_is_refused() {
    assert!(through(&[row(0.0, 0.0), row(1.0, 100.0)], 5.0).is_ok());
    assert_eq!(fault(&[row(0.0, 0.0), row(1.0, 100.1)]), (Some(1), "position_m"));
    let turned = |yaw| GivenState { angles_deg: [yaw, 0.0, 0.0], ..row(0.2, 0.0) };
    assert!(through(&[row(0.0, 0.0), turned(143.0)], 5.0).is_ok());
    assert_eq!(fault(&[row(0.0, 0.0), turned(145.0)]), (Some(1), "yaw_deg"));
    // Nearly a full turn is a small one, the other way.
    assert!(through(&[row(0.0, 0.0), turned(350.0)], 5.0).is_ok());
}

#[test]
fn a_velocity_that_is_not_that_of_the_positions_is_refused() {
    let with = |velocity| {
        [
            row(0.0, 0.0),
            GivenState { velocity_m_s: Some(velocity), ..row(0.5, 5.0) },
            row(1.0, 10.0),
        ]
    };
    assert!(through(&with([14.0, 0.0]), 5.0).is_ok());
    // In km/h, and turned into the body frame of a car that drives along y.
    assert_eq!(fault(&with([36.0, 0.0])), (Some(1), "velocity_m_s"));
    assert_eq!(fault(&with([-1.0, 15.0])), (Some(1), "velocity_m_s"));
}

#[test]
fn a_motion_that_leads_beyond_all_coordinates_is_refused() {
    let rows = [row(0.0, 1e6 - 10.0), row(1.0, 1e6)];
    assert_eq!(fault(&rows), (None, "path"));
    let misfit = onward([1e6, 0.0, 0.0], [0.0; 3], [10.0, 0.0], 0.0, 5.0).unwrap_err();
    assert!(misfit.remedy.contains("1000000"), "{misfit:?}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    /// A circle is met at every time, and the body turns with it.
    #[test]
    fn a_turn_is_a_circle(
        position in prop::array::uniform3(-100.0..100.0_f64),
        yaw in -360.0..360.0_f64,
        speed in -100.0..100.0_f64,
        rate in -720.0..720.0_f64,
        horizon_s in 0.001..30.0_f64,
    ) {
        // Within the limit of lateral acceleration.
        let rate = rate.signum() * rate.abs().min(5700.0 / speed.abs().max(1.0));
        let (sin, cos) = yaw.to_radians().sin_cos();
        let velocity = [speed * cos, speed * sin];
        let path = onward(position, [yaw, 0.0, 0.0], velocity, rate, horizon_s).unwrap();
        prop_assert_eq!([path.from_s(), path.to_s()], [0.0, horizon_s]);
        prop_assert!(path.states().len() <= 3400);
        for k in 0..=997 {
            let time_s = horizon_s * f64::from(k) / 997.0;
            let turn = rate.to_radians() * time_s;
            let heading = yaw.to_radians() + turn;
            let radius = speed / rate.to_radians();
            let exact = [
                position[0] + radius * (heading.sin() - sin),
                position[1] - radius * (heading.cos() - cos),
                position[2],
            ];
            let pose = path.pose_at(time_s);
            let off = (0..3).map(|axis| (pose.translation[axis] - exact[axis]).powi(2));
            // A circle of a huge radius is itself only known to its rounding.
            let rounding = 1e-9 + 1e-15 * radius.abs();
            prop_assert!(off.sum::<f64>().sqrt() <= CIRCLE_ERROR_M + rounding);
            let facing = [pose.rotation[0][0] - heading.cos(), pose.rotation[1][0] - heading.sin()];
            prop_assert!(facing.iter().all(|off| off.abs() < 1e-9));
        }
    }

    /// Between states position is linear; at them it is what was written.
    #[test]
    fn a_path_goes_through_its_states(
        steps in prop::collection::vec((0.05..2.0_f64, -1.0..1.0_f64, -15.0..15.0_f64), 1..20),
        begin in -3.0..0.0_f64,
    ) {
        let mut time_s = begin;
        let mut rows = vec![row(begin, 0.0)];
        for (step_s, x, yaw) in steps {
            time_s += step_s;
            rows.push(GivenState { angles_deg: [yaw, 0.0, 0.0], ..row(time_s, x) });
        }
        prop_assume!(time_s > 0.0);
        let (path, ends_s) = through(&rows, 5.0).unwrap();
        prop_assert_eq!(ends_s, (time_s < 5.0 - limit::PATH_SNAP_S).then_some(time_s));
        for pair in rows.windows(2) {
            for share in [0.0, 0.3, 1.0] {
                let time_s = pair[0].time_s + (pair[1].time_s - pair[0].time_s) * share;
                if (0.0..=5.0).contains(&time_s) {
                    let x = pair[0].position_m[0] * (1.0 - share) + pair[1].position_m[0] * share;
                    prop_assert!((path.pose_at(time_s).translation[0] - x).abs() < 1e-5);
                }
            }
        }
    }
}
