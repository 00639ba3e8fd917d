//! How contacts combine, what a run-out is, and that impulses keep momentum.

use super::*;
use crate::dynamics::delta_v_at_most;
use crate::parameters::Parameters;
use crate::scene::head_on;
use body::OwnParameters;

/// A person's risk, the same at both ends.
fn risk(id: usize, value: f64, range: [f64; 2]) -> Risk {
    let high = Interval::exactly(range[1]);
    Risk {
        id: PersonId(id),
        work: Interval::exactly(value),
        range: Range::new(range[0], range[1]),
        high,
    }
}

#[test]
fn risks_of_several_contacts_combine_as_independent_events() {
    let both = combined(&risk(0, 0.2, [0.1, 0.5]), &risk(0, 0.5, [0.3, 0.7]));
    assert!((both.work.hi() - 0.6).abs() < 1e-12 && both.work.is_settled());
    assert_eq!([both.range.low(), both.range.high()], [0.3, 1.0]);
    // A contact that harms nobody changes nothing, to the bit.
    let alone = risk(0, 0.1, [0.0, 0.3]);
    assert_eq!(combined(&alone, &risk(0, 0.0, [0.0, 0.0])), alone);
    assert_eq!(combined(&risk(0, 0.0, [0.0, 0.0]), &alone), alone);
}

#[test]
fn the_order_in_which_contacts_are_included_does_not_matter_but_for_rounding() {
    let harms = [0.0, 0.4, 0.9].map(|across| head_on(across).harm().expect("a sound scene"));
    let course = |order: [usize; 3]| {
        let mut course = CourseHarm::none();
        order.iter().for_each(|k| course.include(&harms[*k]));
        course
    };
    let (forth, back) = (course([0, 1, 2]), course([2, 1, 0]));
    assert_eq!(forth.persons.len(), 2);
    for (a, b) in forth.persons.iter().zip(&back.persons) {
        assert!((a.work.hi() - b.work.hi()).abs() < 1e-12);
        let of_one = |harm: &CandidateHarm| {
            let person = harm.persons.iter().find(|person| person.id == a.id);
            person.map_or(0.0, |person| person.work.hi())
        };
        assert!(harms.iter().all(|harm| a.work.hi() >= of_one(harm)));
        assert!(a.work.hi() <= harms.iter().map(of_one).sum());
    }
    assert!(forth.is_done());
}

#[test]
fn one_contact_is_its_own_harm_to_the_bit() {
    let harm = head_on(0.3).harm().expect("a sound scene");
    let mut course = CourseHarm::none();
    course.include(&harm);
    let expected: Vec<Risk> = harm.persons.iter().map(Risk::of).collect();
    assert_eq!((course.persons.as_slice(), course.energy_j), (expected.as_slice(), harm.energy_j));
}

#[test]
fn what_is_open_may_be_anything() {
    let mut course = CourseHarm::none();
    course.include(&head_on(0.0).harm().expect("a sound scene"));
    let before = course.risk_of(PersonId(1)).map(|risk| risk.work.lo());
    course.leave_open([PersonId(1), PersonId(2)].into_iter(), 1e6);
    for (id, lo) in [(1, before), (2, Some(0.0))] {
        let risk = course.risk_of(PersonId(id)).expect("it was named");
        assert_eq!((Some(risk.work.lo()), risk.work.hi(), risk.range.high()), (lo, 1.0, 1.0));
    }
    assert!(!course.is_done());
}

#[test]
fn a_run_out_is_braked_to_rest() {
    // 1500 kg at 20 m/s lose 15 000 Ns ahead and gain 3 000 Ns to the left.
    let (before, impulse) = (DVec3::new(20.0, 0.0, 0.0), DVec3::new(-15e3, 3e3, 0.0));
    let run_out = RunOut::after(before, impulse, 1500.0);
    assert_eq!(run_out.velocity_m_s, [10.0, 2.0]);
    let rest = run_out.travel_m(run_out.lasts_s());
    assert_eq!(run_out.travel_m(60.0), rest);
    let length = libm::sqrt(rest[0] * rest[0] + rest[1] * rest[1]);
    assert!((length - 104.0 / (2.0 * RUN_OUT_M_S2)).abs() < 1e-9);
    assert!((length - run_out.length_m()).abs() < 1e-9);
    // The way is travelled at the speed that is left: its slope at the begin is the velocity.
    let early = run_out.travel_m(1e-6);
    assert!((early[0] / 1e-6 - 10.0).abs() < 1e-4 && (early[1] / 1e-6 - 2.0).abs() < 1e-4);
    assert_eq!(RunOut { velocity_m_s: [0.0; 2], ..run_out }.travel_m(3.0), [0.0; 2]);
    let drawn = run_out.drawn(90.0, 0.5);
    assert!((drawn.speed_m_s() - run_out.speed_m_s()).abs() < 1e-12);
    assert!((drawn.lasts_s() - run_out.lasts_s()).abs() < 1e-12, "the middle is the usual one");
    let [[x, y], [p, q]] = [run_out.travel_m(0.5), drawn.travel_m(0.5)];
    assert!((p + y).abs() < 1e-12 && (q - x).abs() < 1e-12, "it goes to the left");
    assert!(run_out.drawn(0.0, 0.0).length_m() > run_out.drawn(0.0, 1.0).length_m());
}

#[test]
fn the_impulse_keeps_the_momentum_of_both_and_gives_the_change_of_velocity() {
    for across in [0.0, 0.5, 1.2] {
        let scene = head_on(across);
        let harm = scene.harm().expect("a sound scene");
        let size = DVec3::from_array(harm.impulse_n_s).length();
        for (party, delta) in [&scene.party_a, &scene.party_b].into_iter().zip(&harm.delta_v) {
            let mass = party.mass_kg.expect("a car");
            assert!((size / mass - delta.work.hi()).abs() < 1e-9);
        }
        // A drives along x into B: B is pushed that way.
        assert!(harm.impulse_n_s[0] > 0.0);
    }
}

#[test]
fn no_impact_changes_the_ego_more_than_its_bound() {
    let none = OwnParameters::default();
    let parameters = Parameters::shipped().expect("sound").of_pair([&none, &none]);
    for across in [0.0, 0.3, 0.9, 1.4, 1.7] {
        for [vx, vy] in [[20.0, 0.0], [12.0, 5.0], [3.0, -8.0]] {
            for yaw_rad_s in [[0.0; 2], [0.5, -1.0]] {
                let mut scene = head_on(across);
                (scene.velocity, scene.yaw_rad_s) = ([vx, vy], yaw_rad_s);
                let harm = scene.harm().expect("a sound scene");
                let masses = [scene.party_a.mass_kg, scene.party_b.mass_kg];
                let [n, t] = [harm.normal_m_s, harm.tangential_m_s];
                let most = delta_v_at_most(libm::sqrt(n * n + t * t), masses, &parameters);
                assert!(harm.delta_v[0].work.hi() <= most + 1e-9, "{across} {vx} {vy}");
            }
        }
    }
    let wall = delta_v_at_most(10.0, [Some(1500.0), None], &parameters);
    assert!((10.0 * (1.0 + parameters.restitution.nominal)..14.0).contains(&wall));
    assert_eq!(delta_v_at_most(10.0, [None, Some(1500.0)], &parameters), 0.0);
}
