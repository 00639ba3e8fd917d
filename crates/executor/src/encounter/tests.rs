//! A look is what dense sampling shows, is the same wherever it is done, and nothing impossible is
//! taken for one.

use super::*;
use crate::motion;
use body::Body;
use body::testing::{body_of, mesh_of, strip};
use geometry::motion::{Orientation, State};

const NEVER: fn(u64) -> ControlFlow<()> = |_| ControlFlow::Continue(());

fn bodies() -> [Body; 2] {
    [40, 24].map(|count| body_of(&mesh_of(strip(count))))
}

/// From x, at a speed (m/s), turning (degrees/s).
fn path(x: f64, speed: f64, rate: f64) -> MotionPath {
    let state = |time_s: f64| State {
        time_s,
        position_m: [x + speed * time_s, 0.1 * speed, 0.0],
        orientation: Orientation::from_degrees(rate * time_s, 0.0, 0.0),
    };
    MotionPath::new(&[state(0.0), state(1.0), state(3.0)]).unwrap()
}

fn look<'p>(bodies: &'p [Body; 2], paths: [&'p MotionPath; 2], may_touch: bool) -> Look<'p> {
    let ways = Ways { bodies: bodies.each_ref().map(Body::view), paths };
    Look { ways, from_s: 0.0, end_s: 3.0, resolution_m: 1e-3, may_touch }
}

#[test]
fn the_first_contact_is_where_poses_begin_to_touch() {
    let bodies = bodies();
    let mut encounters = Encounters::default();
    let (mut met, mut never) = (0, 0);
    for number in 0..24 {
        let number = f64::from(number);
        let still = path(0.0, 0.0, 0.0);
        let moving = path(15.0, -20.0 + 1.2 * number, 20.0 * (number % 5.0));
        let asked = look(&bodies, [&still, &moving], false);
        let (seen, _) = encounters.look(&asked, &mut { NEVER }).unwrap();
        let steps = (0..=3000).map(|step| f64::from(step) * 1e-3);
        let sampled = steps.clone().find(|time_s| encounters.touch_at(&asked.ways, *time_s));
        match seen {
            LookOutcome::Contact(touching) if touching.is_certain => {
                met += 1;
                assert!(encounters.touch_at(&asked.ways, touching.time_s) || sampled.is_some());
                if let Some(sampled) = sampled {
                    assert!(touching.time_s <= sampled + 1e-9, "{touching:?} {sampled}");
                    assert!(touching.excluded_before_s <= touching.time_s);
                }
            }
            LookOutcome::Contact(_) => {}
            LookOutcome::Never => {
                never += 1;
                assert_eq!(sampled, None);
            }
            LookOutcome::Still(_) | LookOutcome::Hidden => panic!("they were not said to touch"),
        }
        // In a worker: paths come back from words, and what was seen, too.
        let back = [&still, &moving].map(|path| {
            let mut words = Vec::new();
            motion::write(path, &mut words);
            motion::read(&words).unwrap()
        });
        let there = look(&bodies, [&back[0], &back[1]], false);
        let (again, _) = Encounters::default().look(&there, &mut { NEVER }).unwrap();
        assert_eq!(LookOutcome::from_wire(&again.to_wire(), &asked), Some(seen));
    }
    assert!(met > 3 && never > 3, "{met} met, {never} never");
}

#[test]
fn bodies_that_touch_are_seen_to_do_so_until_they_part() {
    let bodies = bodies();
    let (still, moving) = (path(0.0, 0.0, 0.0), path(0.3, 4.0, 0.0));
    let mut encounters = Encounters::default();
    let mut asked = look(&bodies, [&still, &moving], true);
    let (mut touching, mut apart) = (0, 0);
    for step in 0..100 {
        asked.from_s = 0.029 * f64::from(step);
        let (seen, _) = encounters.look(&asked, &mut { NEVER }).unwrap();
        let touches = encounters.touch_at(&asked.ways, asked.from_s);
        assert_eq!(matches!(seen, LookOutcome::Still(_)), touches, "{seen:?}");
        if let LookOutcome::Still(found) = seen {
            assert_eq!(found.time_s, asked.from_s);
            touching += 1;
        } else {
            apart += 1;
        }
        assert_eq!(LookOutcome::from_wire(&seen.to_wire(), &asked), Some(seen));
    }
    assert!(touching > 0 && apart > 0, "{touching} {apart}");
}

#[test]
fn what_cannot_be_is_not_taken() {
    let bodies = bodies();
    let (still, moving) = (path(0.0, 0.0, 0.0), path(20.0, -10.0, 0.0));
    let asked = look(&bodies, [&still, &moving], false);
    let (seen, _) = Encounters::default().look(&asked, &mut { NEVER }).unwrap();
    let good = seen.to_wire();
    assert!(matches!(LookOutcome::from_wire(&good, &asked), Some(LookOutcome::Contact(_))));
    let wrong = [
        WireSeen { kind: 0, ..good },
        WireSeen { kind: SeenKind::Still as u32, ..good },
        WireSeen { kind: SeenKind::Hidden as u32, ..good },
        WireSeen { triangles: [u32::MAX, 0], ..good },
        WireSeen { ids: [good.ids[0] ^ 1, good.ids[1]], ..good },
        WireSeen { time_s: 3.1, ..good },
        WireSeen { time_s: f64::NAN, ..good },
        WireSeen { excluded_before_s: -1.0, ..good },
        WireSeen { excluded_before_s: good.time_s + 1e-3, ..good },
        WireSeen { point: [f64::INFINITY, 0.0, 0.0], ..good },
    ];
    for wrong in wrong {
        assert_eq!(LookOutcome::from_wire(&wrong, &asked), None, "{wrong:?}");
    }
}

#[test]
fn a_look_ends_where_it_is_told_to_and_without_a_motion() {
    let bodies = bodies();
    let (still, moving) = (path(0.0, 0.0, 0.0), path(0.3, 4.0, 0.0));
    let mut asked = look(&bodies, [&still, &moving], false);
    let mut encounters = Encounters::default();
    asked.end_s = 4.0;
    assert_eq!(encounters.look(&asked, &mut { NEVER }), Err(Unseen::NoMotion));
    let sedan = body::testing::body_of(&mesh_of(strip(4000)));
    let bodies = [sedan.clone(), sedan];
    let turning = path(0.0, 0.0, 30.0);
    let asked = look(&bodies, [&still, &turning], true);
    let mut calls = 0;
    let mut stop = |_| {
        calls += 1;
        ControlFlow::Break(())
    };
    assert_eq!(encounters.look(&asked, &mut stop), Err(Unseen::Stopped));
    assert_eq!(calls, 1);
}
