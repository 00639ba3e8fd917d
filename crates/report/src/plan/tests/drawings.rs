//! What the drawing of a plan shows: where, of whom, and when.

use super::*;

#[test]
fn the_window_holds_every_way_and_contact_and_is_neither_flat_nor_tall() {
    let (_, _, mut scene) = ranked();
    let mut rng = Rng::new(3);
    for _ in 0..100 {
        let (x, y) = (rng.between(-200.0, 200.0), rng.between(-200.0, 200.0));
        let samples = [[0.0, 0.0, 0.0, 1.0, 0.0], [3.0, x, y, 1.0, 0.0]];
        scene.courses[0].ego = samples.map(PlanSample).to_vec();
        scene.courses[0].contacts[0].at_m = [y, x];
        let window = PlanWindow::of(&scene);
        for at in [[0.0, 0.0], [x, y], [y, x]] {
            assert!(window.shows(at), "{at:?} in {window:?}");
        }
        let share = window.share();
        assert!((0.299..=0.751).contains(&share), "{share}");
    }
}

#[test]
fn a_track_is_linear_between_samples_and_still_after_the_last() {
    let track = [[0.0, 0.0, 2.0, 1.0, 0.0], [2.0, 4.0, 2.0, 1.0, 0.0]].map(PlanSample);
    for (time_s, x) in [(-1.0, 0.0), (0.0, 0.0), (0.5, 1.0), (2.0, 4.0), (9.0, 4.0)] {
        assert_eq!(pose_at(&track, time_s)[1..3], [x, 2.0], "after {time_s} s");
    }
}

#[test]
fn the_gap_is_the_shortest_line_between_two_outlines() {
    let mut rng = Rng::new(9);
    let mut square = |by: f64| {
        let (x, y, turn) =
            (by + rng.between(-5.0, 5.0), rng.between(-9.0, 9.0), rng.between(0.0, 3.0));
        let (sin, cos) = libm::sincos(turn);
        [[2.0, 1.0], [-2.0, 1.0], [-2.0, -1.0], [2.0, -1.0]]
            .map(|[u, v]: [f64; 2]| [x + cos * u - sin * v, y + sin * u + cos * v])
    };
    let edge = |corners: &[[f64; 2]; 4]| -> Vec<[f64; 2]> {
        let side = |k: usize| {
            let [from, to] = [corners[k], corners[(k + 1) % 4]];
            (0..50).map(move |step| {
                let share = f64::from(step) / 50.0;
                [0, 1].map(|axis| from[axis] + share * (to[axis] - from[axis]))
            })
        };
        (0..4).flat_map(side).collect()
    };
    let apart = |[a, b]: [[f64; 2]; 2]| f64::hypot(a[0] - b[0], a[1] - b[1]);
    for _ in 0..50 {
        let (one, other) = (square(-9.0), square(9.0));
        let [from, to] = drawing::gap(&one, &other);
        let (ours, theirs) = (edge(&one), edge(&other));
        let pairs = ours.iter().flat_map(|a| theirs.iter().map(move |b| apart([*a, *b])));
        let least = pairs.fold(f64::INFINITY, f64::min);
        assert!((apart([from, to]) - least).abs() < 0.05, "{from:?} {to:?} {least}");
        assert!(ours.iter().any(|at| apart([*at, from]) < 0.1));
        assert!(theirs.iter().any(|at| apart([*at, to]) < 0.1));
    }
}

#[test]
fn paths_of_all_members_are_drawn() {
    let (answer, run, scene) = ranked_in_members();
    let page = made(&answer, &run, &scene);
    let (screen, _) = page.split_once("The ranking").expect("the drawing stands before");
    // Four members of each of two candidates.
    assert_eq!(screen.matches("class=\"thread own\"").count(), 8);
    assert!(page.contains("the paths of 4 members"));
    // A strip for whoever harms somebody, and a line for the others.
    let harms = |row: &&CourseRow| row.expected.as_ref().expect("of members").injured.hi() > 0.0;
    let harmful = answer.ranking.iter().filter(harms).count();
    assert!(harmful == 1, "{harmful}");
    assert_eq!(page.matches("<svg class=\"strip\"").count(), 1);
    assert!(page.contains("<p>No harm in any member: <bdi>creep</bdi>.</p>"));
}
