//! Laws of paths, and the worked cases G1 to G3.

use super::*;
use crate::approach::HORIZONTAL;
use crate::contact::Normals;
use crate::evidence::{Evidence, Seen};
use crate::scene::{Prism, Scene, car, head_on};
use proptest::prelude::*;
use smallvec::smallvec;

fn path_of(scene: &Scene) -> Path {
    match plan(&scene.approach()) {
        Ok(Meeting::Path(path)) => path,
        other => panic!("no path: {other:?}"),
    }
}

/// G1: boxes overlap, bodies do not, and the motion keeps them apart.
#[test]
fn prisms_that_pass_never_meet_though_their_boxes_overlap() {
    let scene = Scene {
        a: Prism::over(&[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]),
        b: Prism::over(&[[1.1, 1.1], [0.1, 1.1], [1.1, 0.1]]),
        velocity: [5.0, -5.0],
        ..head_on(0.0)
    };
    let approach = scene.approach();
    assert_eq!(plan(&approach), Ok(Meeting::Never(Apart::Passing)));
    assert!((approach.nearest().gap_m - 0.2 / 2.0_f64.sqrt()).abs() < 1e-9);
}

/// G2: a cube inside a cube crosses nothing, and yet there is contact on the path.
#[test]
fn a_body_inside_another_meets_it_on_the_way_in() {
    let scene = Scene {
        a: Prism::cuboid(2.0, 2.0, [0.0, 0.0], 0.0),
        b: Prism::cuboid(0.2, 0.2, [0.1, 0.1], 0.0),
        velocity: [5.0, 0.0],
        ..head_on(0.0)
    };
    let approach = scene.approach();
    assert!(scene.hits(0.0, &approach).is_empty());
    let path = path_of(&scene);
    assert!((path.from_m + 1.0).abs() < 1e-6, "{path:?}");
    let f = scene.first(&path, &approach).expect("contact");
    assert!((f + 1.0).abs() <= 0.002, "{f}");
}

/// G3: the hits at one pose are a planar ring; the hulls tell how deep it is.
#[test]
fn a_box_in_a_wide_box_has_a_flat_ring_of_hits_and_a_depth() {
    let scene = Scene {
        a: Prism::cuboid(4.5, 1.8, [0.0, 0.0], 0.0),
        b: Prism::cuboid(4.5, 20.0, [4.3, 0.0], 0.0),
        ..head_on(0.0)
    };
    let approach = scene.approach();
    assert!((approach.penetration(0, 0.0) - 0.2).abs() < 1e-12);
    let normals = Normals::between(&approach, 0.0, 0.0, 0.0);
    assert_eq!((normals.possible, normals.nominal), (smallvec![0], smallvec![0]));
    let mut seen = Seen::NOTHING;
    scene.hits(0.0, &approach).iter().for_each(|p| seen.patch.add(&approach.directions, *p));
    let mut evidence = Evidence::none((0.0, 0.0));
    evidence.add_hits(0.0, &seen);
    let span = evidence.span(0, HORIZONTAL / 2, &approach.reach(0.0, 0.0));
    assert!(span.hi().abs() < 1e-12, "{span:?}");
}

#[test]
fn overlap_at_standstill_or_without_end_is_refused() {
    let still = Scene { velocity: [0.05, 0.0], ..head_on(0.0) };
    assert_eq!(plan(&still.approach()), Ok(Meeting::AlreadyOverlapping));
    let wall = Prism::cuboid(30.0, 20.0, [2.0, 0.0], 0.0);
    let inside = Scene { b: wall, ..head_on(0.0) };
    assert_eq!(plan(&inside.approach()), Ok(Meeting::AlreadyOverlapping));
}

#[test]
fn bodies_at_rest_apart_or_far_away_never_meet() {
    let apart = Scene { b: Prism::cuboid(4.5, 1.8, [5.0, 0.0], 0.0), ..head_on(0.0) };
    let still = Scene { velocity: [0.0, 0.0], ..apart.clone() };
    assert_eq!(plan(&still.approach()), Ok(Meeting::Never(Apart::Passing)));
    // Just past each other is a crash seen too late; long past each other is none.
    let away = Scene { velocity: [-9.0, 0.0], ..apart };
    assert!(matches!(plan(&away.approach()), Ok(Meeting::Path(_))));
    let far = Scene { b: Prism::cuboid(4.5, 1.8, [15.0, 0.0], 0.0), ..head_on(0.0) };
    assert!(matches!(plan(&far.approach()), Ok(Meeting::Path(path)) if path.from_m > 10.0));
    let long_past = Scene { velocity: [-9.0, 0.0], ..far };
    assert_eq!(plan(&long_past.approach()), Ok(Meeting::Never(Apart::Passing)));
    let above = Prism { height: [3.0, 4.0], ..head_on(0.0).b };
    let below = Scene { b: above, ..head_on(0.0) };
    assert_eq!(plan(&below.approach()), Ok(Meeting::Never(Apart::Passing)));
}

#[test]
fn a_thin_body_makes_a_long_survey_coarse() {
    let path = path_of(&head_on(0.0));
    assert_eq!((path.step_m, path.coarse), (0.1, false));
    let pole = Prism::round(0.02, [2.3, 0.0]);
    let thin = Scene { b: pole, party_b: car(1, 900.0, [2.3, 0.0], 0.0), ..head_on(0.0) };
    let path = path_of(&thin);
    assert!(path.coarse && path.survey(0.0).len() <= POSES_MAX, "{path:?}");
    assert!((path.step_m - 0.6 / 14.0).abs() < 1e-9);
}

proptest! {
    /// Before it the hulls are apart, behind it they are apart for good.
    #[test]
    fn a_path_covers_all_travels_at_which_hulls_meet(
        x in -6.0..40.0_f64,
        y in -3.0..3.0_f64,
        turned in -180.0..180.0_f64,
    ) {
        let scene = Scene { b: Prism::cuboid(4.0, 1.7, [x, y], turned), ..head_on(0.0) };
        let approach = scene.approach();
        if let Meeting::Path(path) = plan(&approach)? {
            prop_assert!(approach.hulls_meet(path.from_m + 1e-6));
            prop_assert!(!approach.hulls_meet(path.from_m - 0.001));
            for k in 0..20 {
                prop_assert!(!approach.hulls_meet(path.to_m + 0.001 + 0.3 * f64::from(k)));
            }
        }
    }

    #[test]
    fn a_survey_starts_at_first_contact_and_holds_both_ends(
        start in -9.0..9.0_f64, length in 0.6..12.0_f64, step in 0.02..0.1_f64,
        part in 0.0..1.0_f64, closing in 0.0..60.0_f64,
    ) {
        let to_m = start + length;
        let path = Path { from_m: start, to_m, step_m: step, coarse: false, closing_m_s: closing };
        let f = start + part * length;
        let stops = path.survey(f);
        let (r, e) = (path.patch_end(f), path.crush_end(f));
        prop_assert!(stops.len() <= POSES_MAX);
        prop_assert!((stops[0].travel_m - f).abs() < 1e-8 && stops[0].patch && stops[0].zones);
        prop_assert!(stops.windows(2).all(|p| p[0].travel_m < p[1].travel_m));
        prop_assert!(stops.iter().any(|s| s.travel_m == r && s.patch));
        prop_assert_eq!(stops.iter().filter(|s| s.depth).count(), 1);
        prop_assert!(stops.iter().any(|s| s.travel_m == e && s.depth && s.zones));
        for s in &stops {
            prop_assert!(s.patch == (s.travel_m <= r) && s.zones == (s.travel_m <= e));
        }
        prop_assert!(e <= f + 0.6 + 1e-12);
    }
}
