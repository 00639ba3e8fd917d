//! Paths keep their states; chords keep their margins; what is called apart never touches.

use super::interval::Movers;
use super::*;
use crate::{Aabb, Bounds, Corners, Triangle, triangle};
use proptest::prelude::*;

fn orientation() -> impl Strategy<Value = Orientation> {
    let turn = -180.0..180.0;
    (turn.clone(), -89.0..89.0, turn).prop_map(|(y, p, r)| Orientation::from_degrees(y, p, r))
}

/// Two or three states over some seconds, with turns up to several rad/s about any axis.
fn path() -> impl Strategy<Value = MotionPath> {
    path_within(f64::MIN_POSITIVE)
}

/// The same about any place up to so far from the origin (m).
fn path_within(far_m: f64) -> impl Strategy<Value = MotionPath> {
    let state = (0.2..2.0_f64, prop::array::uniform3(-5.0..5.0_f64), orientation());
    let middle = prop::array::uniform3(-far_m..far_m);
    (prop::collection::vec(state, 2..4), middle).prop_map(|(steps, middle)| {
        let mut time_s = -1.0;
        let states: Vec<State> = steps
            .into_iter()
            .map(|(step_s, position_m, orientation)| {
                time_s += step_s;
                let position_m = core::array::from_fn(|k| middle[k] + position_m[k]);
                State { time_s, position_m, orientation }
            })
            .collect();
        MotionPath::new(&states).unwrap()
    })
}

/// What a box passes.
fn passed(movers: &Movers, box_: &Aabb) -> Bounds {
    let [min, max] = movers.passed(box_).map(|v| v.as_dvec3());
    Bounds { min, max }
}

fn corners() -> impl Strategy<Value = Corners> {
    prop::array::uniform3(prop::array::uniform3(-2.0..2.0_f32))
}

/// An interval of the tree over the motion: the halves taken are told by `ways`.
fn some_interval(
    motion: &RelativeMotion<'_>,
    bodies: &MovingBodies,
    piece: usize,
    ways: &[bool],
) -> TimeInterval {
    let pieces: Vec<PathPiece> = motion.pieces().collect();
    let piece = &pieces[piece % pieces.len()];
    ways.iter().fold(TimeInterval::of(motion, bodies, piece), |interval, way| {
        interval.halves(motion, bodies, piece).unwrap()[usize::from(*way)]
    })
}

/// Two bodies of 2 m about their origins on their paths, while both have one.
fn moving<'p>(a: &'p MotionPath, b: &'p MotionPath) -> Option<(RelativeMotion<'p>, MovingBodies)> {
    let motion = RelativeMotion::new(a, b).ok()?;
    let box_ = Aabb { min: [-2.0; 3], max: [2.0; 3] };
    let bodies = MovingBodies::new(&motion, [&box_, &box_]);
    Some((motion, bodies))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    /// A path that is cut at any time goes where the whole one goes.
    #[test]
    fn a_path_that_is_cut_is_the_same_motion(path in path(), cut in 0.0..1.0_f64) {
        let time_s = path.from_s() + (path.to_s() - path.from_s()) * cut;
        let before = path.states().iter().filter(|state| state.time_s < time_s).copied();
        let states: Vec<State> = before.chain([path.state_at(time_s)]).collect();
        let Ok(part) = MotionPath::new(&states) else { return Ok(()) };
        for k in 0..=20 {
            let time_s = part.from_s() + (part.to_s() - part.from_s()) * f64::from(k) / 20.0;
            let (a, b) = (path.state_at(time_s), part.state_at(time_s));
            let off = (0..3).map(|k| (a.position_m[k] - b.position_m[k]).abs());
            prop_assert!(off.fold(0.0, f64::max) < 1e-12);
            prop_assert!(a.orientation.angle_to(&b.orientation) < 1e-9);
        }
    }

    /// The path passes through its states; in between it turns by the share of the angle.
    #[test]
    fn passes_through_its_states(path in path()) {
        for state in path.states() {
            let pose = path.pose_at(state.time_s);
            let difference = (0..3).map(|k| (pose.translation[k] - state.position_m[k]).abs());
            prop_assert!(difference.fold(0.0, f64::max) < 1e-13);
            prop_assert_eq!(pose.rotation, state.orientation.rotation());
        }
        for legs in path.states().windows(2) {
            let near = legs[1].time_s - 1e-13;
            let (before, at) = (path.pose_at(near), path.pose_at(legs[1].time_s));
            for i in 0..3 {
                for j in 0..3 {
                    prop_assert!((before.rotation[i][j] - at.rotation[i][j]).abs() < 1e-11);
                }
            }
        }
    }

    /// Points stay within the margin of their chords, and boxes contain what passes.
    #[test]
    fn points_stay_close_to_their_chords(
        (a, b) in (path(), path()),
        point in prop::array::uniform3(-2.0..2.0_f32),
        piece in 0..3_usize,
        ways in prop::collection::vec(any::<bool>(), 0..9),
    ) {
        let Some((motion, bodies)) = moving(&a, &b) else { return Ok(()) };
        let interval = some_interval(&motion, &bodies, piece, &ways);
        let moved = interval.moved_b(&[point; 3]);
        let small = Aabb { min: point, max: point };
        let all = passed(&interval.movers[0], &small);
        for step in 0..=20 {
            let share = f64::from(step) / 20.0;
            let time_s = interval.from_s + (interval.to_s - interval.from_s) * share;
            let at = motion.pose_at(time_s).point(point);
            let chord = moved.ends[0][0] * (1.0 - share) + moved.ends[1][0] * share;
            let off = (at - chord).length();
            prop_assert!(off <= interval.margins_m()[0], "{} of {:?}", off, interval.margins_m());
            let here = Bounds { min: at, max: at };
            prop_assert!(all.overlaps(&here));
            let begin = moved.ends[0][0];
            prop_assert!((at - begin).length() <= interval.travel_m());
        }
    }

    /// The same for points of A in B's frame.
    #[test]
    fn points_of_a_stay_close_too(
        (a, b) in (path(), path()),
        point in prop::array::uniform3(-2.0..2.0_f32),
        piece in 0..3_usize,
        ways in prop::collection::vec(any::<bool>(), 0..9),
    ) {
        let Some((motion, bodies)) = moving(&a, &b) else { return Ok(()) };
        let interval = some_interval(&motion, &bodies, piece, &ways);
        let moved = interval.moved_a(&[point; 3]);
        for step in 0..=20 {
            let share = f64::from(step) / 20.0;
            let time_s = interval.from_s + (interval.to_s - interval.from_s) * share;
            let [of_a, of_b] = motion.poses_at(time_s);
            let at = crate::RelativePose::between(&of_b, &of_a).point(point);
            let chord = moved.ends[0][0] * (1.0 - share) + moved.ends[1][0] * share;
            let off = (at - chord).length();
            prop_assert!(off <= interval.margins_m()[1], "{} of {:?}", off, interval.margins_m());
        }
    }

    /// What boxes pass, in single precision, contains what triangles in them pass, and is little
    /// more, however far the bodies are apart and how short the interval is.
    #[test]
    fn boxes_contain_their_triangles(
        (a, b) in (path_within(1e5), path_within(1e5)),
        of_both in [corners(), corners()],
        piece in 0..3_usize,
        ways in prop::collection::vec(any::<bool>(), 0..25),
    ) {
        let Some((motion, bodies)) = moving(&a, &b) else { return Ok(()) };
        let interval = some_interval(&motion, &bodies, piece, &ways);
        let [of_a, of_b] = &of_both;
        let bounds = [interval.moved_b(of_b).bounds, interval.moved_a(of_a).bounds];
        for ((movers, corners), bounds) in interval.movers.iter().zip([of_b, of_a]).zip(bounds) {
            let all = passed(movers, &Aabb::of(corners));
            prop_assert!(all.min.cmple(bounds.min).all() && bounds.max.cmple(all.max).all());
            // A point is its own box: what it passes is enlarged by rounding alone.
            let [corner, ..] = corners;
            let Bounds { min, max } = passed(movers, &Aabb { min: *corner, max: *corner });
            let point = &[*corner; 3];
            let is_of_b = core::ptr::eq(corners, of_b);
            let moved = if is_of_b { interval.moved_b(point) } else { interval.moved_a(point) };
            let reach = min.abs().max(max.abs()).max_element() + 6.0;
            let more = (moved.bounds.min - min).max(max - moved.bounds.max).max_element();
            prop_assert!(more <= 4e-6 * reach, "{} of {}", more, reach);
        }
    }

    /// Triangles that are called apart do not touch at any pose, and lie in the boxes of their
    /// boxes.
    #[test]
    fn what_is_apart_never_touches(
        (a, b) in (path(), path()),
        (of_a, of_b) in (corners(), corners()),
        piece in 0..3_usize,
        ways in prop::collection::vec(any::<bool>(), 0..9),
    ) {
        let Some((motion, bodies)) = moving(&a, &b) else { return Ok(()) };
        let interval = some_interval(&motion, &bodies, piece, &ways);
        let moved = interval.moved_b(&of_b);
        let of_both = [(&of_b, moved.bounds), (&of_a, interval.moved_a(&of_a).bounds)];
        for (movers, (corners, bounds)) in interval.movers.iter().zip(of_both) {
            let all = passed(movers, &Aabb::of(corners));
            prop_assert!(all.min.cmple(bounds.min).all() && bounds.max.cmple(all.max).all());
        }
        let apart = interval.are_apart(&of_a, &of_b, &moved);
        let stored = Triangle::stored(&of_a);
        for step in 0..=50 {
            let share = f64::from(step) / 50.0;
            let time_s = interval.from_s + (interval.to_s - interval.from_s) * share;
            let touches = triangle::intersect(&stored, &motion.pose_at(time_s).triangle(&of_b));
            prop_assert!(!(apart && touches), "at {} of {:?}", time_s, interval);
            let found = interval.first_touch(&motion, &of_a, &of_b, f64::INFINITY);
            if let Some(time_s) = found {
                let pose = motion.pose_at(time_s);
                prop_assert!(triangle::intersect(&stored, &pose.triangle(&of_b)) && !apart);
            }
        }
    }

    /// Whenever triangles touch, or corners are near each other, that is in their span and in that
    /// of their boxes.
    #[test]
    fn spans_leave_out_nothing_that_is_near(
        (a, b) in (path(), path()),
        (of_a, of_b) in (corners(), corners()),
        piece in 0..3_usize,
        ways in prop::collection::vec(any::<bool>(), 0..9),
        (near_m, before) in (prop_oneof![Just(0.0), 1e-5..2.0_f64], 0.1..1.5_f64),
    ) {
        let Some((motion, bodies)) = moving(&a, &b) else { return Ok(()) };
        let interval = some_interval(&motion, &bodies, piece, &ways);
        let spans = interval.near_spans(near_m);
        let moved = interval.moved_b(&of_b);
        let of_boxes = spans.of_boxes(&Aabb::of(&of_a), &Aabb::of(&of_b));
        let of_triangles = spans.of_triangles(&interval, (&of_a, &of_b), &moved, before);
        let stored = Triangle::stored(&of_a);
        let holds = |span: Option<NearSpan>, share: f64| {
            span.is_some_and(|span| span.from <= share && share <= span.to)
        };
        for step in 0..=50 {
            let share = f64::from(step) / 50.0;
            let time_s = interval.time_s(share);
            let placed = motion.pose_at(time_s).triangle(&of_b);
            let gaps = stored.0.iter().flat_map(|p| placed.0.iter().map(|q| (*q - *p).length()));
            let is_near = gaps.fold(f64::INFINITY, f64::min) <= near_m;
            if is_near || triangle::intersect(&stored, &placed) {
                prop_assert!(holds(of_boxes, share), "{:?} without {}", of_boxes, share);
                let is_held = share > before || holds(of_triangles, share);
                prop_assert!(is_held, "{:?} without {}", of_triangles, share);
            }
        }
    }

    /// What is clearly apart in an interval is apart in its parts.
    #[test]
    fn what_is_clearly_apart_stays_apart(
        (a, b) in (path(), path()),
        (of_a, of_b) in (corners(), corners()),
        piece in 0..3_usize,
        ways in prop::collection::vec(any::<bool>(), 1..14),
        cut in any::<prop::sample::Index>(),
    ) {
        let Some((motion, bodies)) = moving(&a, &b) else { return Ok(()) };
        let whole = some_interval(&motion, &bodies, piece, &ways[..cut.index(ways.len())]);
        let part = some_interval(&motion, &bodies, piece, &ways);
        let clearly = |of: &TimeInterval| of.are_clearly_apart(&of_a, &of_b, &of.moved_b(&of_b));
        let apart = part.are_apart(&of_a, &of_b, &part.moved_b(&of_b));
        prop_assert!(!clearly(&whole) || apart, "{:?} {:?}", whole, part);
        prop_assert!(!clearly(&part) || apart, "{:?}", part);
        prop_assert!(!whole.is_far() || part.is_just_far());
    }
}

/// Triangles that are not apart in a short interval come as close as it says.
/// A proof that boxes are apart must not come of numbers that are too large for single precision.
#[test]
fn boxes_beyond_single_precision_are_never_called_apart() {
    let states = [(0.0, 0.0), (1.0, 40.0)].map(|(time_s, yaw)| State {
        time_s,
        position_m: [1.0, 2.0, 3.0],
        orientation: Orientation::from_degrees(yaw, 0.0, 0.0),
    });
    let path = MotionPath::new(&states).unwrap();
    let motion = RelativeMotion::new(&path, &path).unwrap();
    let piece = motion.pieces().next().unwrap();
    for far in [1e6_f32, 1e20, 1e30, 1e37, 3e38] {
        let [near, farther] = [0.5 * far, far];
        for box_ in [
            Aabb { min: [near; 3], max: [farther; 3] },
            Aabb { min: [-farther, near, near], max: [farther; 3] },
            Aabb { min: [farther; 3], max: [farther; 3] },
        ] {
            let bodies = MovingBodies::new(&motion, [&box_, &box_]);
            let interval = TimeInterval::of(&motion, &bodies, &piece);
            assert!(interval.may_meet(&box_, &box_), "{box_:?}");
            let span = interval.near_spans(1e-3).of_boxes(&box_, &box_);
            assert_eq!(span, Some(NearSpan::ALL), "{box_:?}");
        }
    }
}

#[test]
fn what_is_not_apart_is_close() {
    const STEPS: u32 = 20;
    let mut rng = crate::rng::Rng::new(9);
    let state = |time_s, y, yaw| State {
        time_s,
        position_m: [0.0, y, 0.0],
        orientation: Orientation::from_degrees(yaw, 0.0, 0.0),
    };
    let still = MotionPath::still([0.0; 3], Orientation::IDENTITY, [0.0, 1e-3]).unwrap();
    let moving = MotionPath::new(&[state(0.0, 0.0, 0.0), state(1e-3, 2e-3, 0.5)]).unwrap();
    let motion = RelativeMotion::new(&still, &moving).unwrap();
    let box_ = Aabb { min: [-0.02; 3], max: [0.02; 3] };
    let bodies = MovingBodies::new(&motion, [&box_, &box_]);
    let piece = motion.pieces().next().unwrap();
    let interval = TimeInterval::of(&motion, &bodies, &piece);
    let resolution_m = 4e-3;
    assert!(interval.is_short(resolution_m) && !interval.is_short(2e-3));
    let points = |Triangle([p, q, r]): Triangle| {
        let shares = (0..=STEPS).flat_map(|i| (0..=STEPS - i).map(move |j| (i, j)));
        let point = move |(i, j): (u32, u32)| {
            let [i, j] = [i, j].map(|k| f64::from(k) / f64::from(STEPS));
            p + (q - p) * i + (r - p) * j
        };
        shares.map(point).collect::<Vec<_>>()
    };
    let (mut apart, mut close) = (0, 0);
    for _ in 0..400 {
        let centres = [[0.0; 3], [0.0; 3].map(|x: f64| x + rng.between(-4e-3, 4e-3))];
        let [a, b] = centres.map(|centre| {
            [0; 3].map(|_| centre.map(|x: f64| (x + rng.between(-4e-3, 4e-3)) as f32))
        });
        if interval.are_apart(&a, &b, &interval.moved_b(&b)) {
            apart += 1;
            continue;
        }
        // Points of both, half a millimetre apart in each: none is farther than that from one.
        let of_b = points(motion.pose_at(5e-4).triangle(&b));
        let least = points(Triangle::stored(&a))
            .into_iter()
            .flat_map(|p| of_b.iter().map(move |q| (*q - p).length()))
            .fold(f64::INFINITY, f64::min);
        assert!(least <= resolution_m + 1e-3, "{least}");
        close += 1;
    }
    assert!(apart > 50 && close > 50, "{apart} {close}");
}

/// Most random triangles that are a little apart are called so: the axes are worth their time.
#[test]
fn most_that_are_apart_are_called_so() {
    let mut random = crate::rng::Rng::new(5);
    let mut unit = || random.between(-0.5, 0.5) as f32;
    let state = |time_s, x, yaw| State {
        time_s,
        position_m: [x, 0.0, 0.0],
        orientation: Orientation::from_degrees(yaw, 0.0, 0.0),
    };
    let still = MotionPath::still([0.0; 3], Orientation::IDENTITY, [0.0, 1e-2]).unwrap();
    let moving = MotionPath::new(&[state(0.0, 0.0, 0.0), state(1e-2, 0.05, 1.0)]).unwrap();
    let motion = RelativeMotion::new(&still, &moving).unwrap();
    let box_ = Aabb { min: [-1.0; 3], max: [1.0; 3] };
    let bodies = MovingBodies::new(&motion, [&box_, &box_]);
    let piece = motion.pieces().next().unwrap();
    let interval = TimeInterval::of(&motion, &bodies, &piece);
    let (mut apart, mut called) = (0, 0);
    for _ in 0..4_000 {
        let [a, b]: [Corners; 2] = [0; 2].map(|_| [0; 3].map(|_| [0; 3].map(|_| unit())));
        let stored = Triangle::stored(&a);
        let touches = (0..=20).any(|step| {
            let pose = motion.pose_at(f64::from(step) * 5e-4);
            triangle::intersect(&stored, &pose.triangle(&b))
        });
        apart += u32::from(!touches);
        called += u32::from(interval.are_apart(&a, &b, &interval.moved_b(&b)));
    }
    assert!(called <= apart && called * 100 > apart * 97, "{called} of {apart}");
}

/// Triangles that move straight come near when they touch, to a micrometre.
#[test]
fn spans_begin_where_triangles_touch() {
    let mut random = crate::rng::Rng::new(11);
    let mut unit = || random.between(-0.5, 0.5) as f32;
    let state = |time_s, x| State {
        time_s,
        position_m: [x, 0.1, 0.0],
        orientation: Orientation::from_degrees(30.0, 0.0, 0.0),
    };
    let still = MotionPath::still([0.0; 3], Orientation::IDENTITY, [0.0, 1.0]).unwrap();
    let moving = MotionPath::new(&[state(0.0, -4.0), state(1.0, 4.0)]).unwrap();
    let motion = RelativeMotion::new(&still, &moving).unwrap();
    let box_ = Aabb { min: [-1.0; 3], max: [1.0; 3] };
    let bodies = MovingBodies::new(&motion, [&box_, &box_]);
    let piece = motion.pieces().next().unwrap();
    let interval = TimeInterval::of(&motion, &bodies, &piece);
    let spans = interval.near_spans(1e-9);
    let sweep = crate::Sweep::new(DVec3::X, 0.0, 8.0).unwrap();
    let (mut met, mut missed) = (0, 0);
    for _ in 0..4_000 {
        let [a, b]: [Corners; 2] = [0; 2].map(|_| [0; 3].map(|_| [0; 3].map(|_| unit())));
        let moved = interval.moved_b(&b);
        let span = spans.of_triangles(&interval, (&a, &b), &moved, f64::INFINITY);
        let begin = motion.pose_at(0.0).triangle(&b);
        match crate::sweep::first_contact(&Triangle::stored(&a), &begin, &sweep) {
            Some(touch) => {
                let off_m = span.unwrap().from * 8.0 - touch.travel_m;
                assert!((-1e-6..=0.0).contains(&off_m), "{off_m}");
                met += 1;
            }
            None => {
                assert_eq!(span, None);
                missed += 1;
            }
        }
    }
    assert!(met > 400 && missed > 400, "{met} {missed}");
}

/// States that are no path are refused, and say why.
#[test]
fn refuses_what_is_no_path() {
    let state =
        |time_s, x| State { time_s, position_m: [x, 0.0, 0.0], orientation: Orientation::IDENTITY };
    assert_eq!(MotionPath::new(&[state(0.0, 0.0)]), Err(PathError::Short));
    assert_eq!(MotionPath::new(&[state(0.0, 0.0), state(0.0, 1.0)]), Err(PathError::State(1)));
    assert_eq!(MotionPath::new(&[state(0.0, f64::NAN), state(1.0, 1.0)]), Err(PathError::State(0)));
    assert_eq!(MotionPath::new(&[state(0.0, 0.0), state(1.0, 1e5)]), Err(PathError::Fast(0)));
    let nowhere = Orientation::from_quaternion([0.0; 4]);
    assert_eq!(MotionPath::still([0.0; 3], nowhere, [0.0, 1.0]), Err(PathError::State(0)));
    let [early, late, long] = [[0.0, 1.0], [2.0, 3.0], [0.0, 31.0]]
        .map(|times| MotionPath::still([0.0; 3], Orientation::IDENTITY, times).unwrap());
    assert!(matches!(RelativeMotion::new(&early, &late), Err(PathError::Span { .. })));
    assert!(matches!(RelativeMotion::new(&long, &long), Err(PathError::Span { .. })));
    assert!(RelativeMotion::new(&long, &late).is_ok());
}
