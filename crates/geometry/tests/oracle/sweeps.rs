//! Campaign: first contact along a straight line against exact arithmetic.
//!
//! Each motion is asked for several times: without limits, between travels at and within
//! nanometres of the ends of contact, with the corners in other orders, and with the roles
//! exchanged.

use crate::cases::{Pair, RandomPoints};
use crate::motions::{KINDS, Motion, kind, motion, shuffled};
use crate::travels::Travels;
use crate::{campaign, count, exact, report, setting};
use trolley_geometry::hash::splitmix64;
use trolley_geometry::rng::Rng;
use trolley_geometry::sweep::{FirstTouch, TOLERANCE_M, TRAVEL_MAX, first_contact};
use trolley_geometry::{DVec3, Sweep, Triangle};

// verifies REQ-FIRST-CONTACT
#[test]
fn first_contact_equals_exact_arithmetic() {
    let seed = setting("ORACLE_SEED", 1);
    let pairs = setting("ORACLE_PAIRS", 20_000);
    let tally = campaign(pairs, KINDS.len(), |number, tally| {
        let motion = motion(seed, number);
        let random = RandomPoints(Rng::new(splitmix64(seed) ^ splitmix64(!number)));
        let touches = compare(&motion, random).unwrap_or_else(|difference| {
            let Motion { pair, direction } = &motion;
            let name = KINDS[kind(number)].name;
            panic!("motion {number}, {name}: {difference}: {pair:?} along {direction:?}")
        });
        count(tally, kind(number), touches);
    });
    println!("first contact");
    report(&tally, &KINDS.iter().map(|kind| kind.name).collect::<Vec<_>>());
}

/// Whether the triangles touch within the greatest travel, or what differs from the truth.
fn compare(motion: &Motion, mut random: RandomPoints) -> Result<bool, String> {
    let Motion { pair, direction } = motion;
    let sweep = Sweep::new(*direction, -TRAVEL_MAX, TRAVEL_MAX).map_err(|e| e.to_string())?;
    let back = Sweep::new(-*direction, -TRAVEL_MAX, TRAVEL_MAX).map_err(|e| e.to_string())?;
    if back.direction() != -sweep.direction() {
        return Err("the direction back is not the opposite".into());
    }
    let truth = Travels::of(pair, sweep.direction());
    if random.below(8) == 0 {
        let touches_at_rest = truth.as_ref().is_some_and(|travels| {
            travels.after_start(0.0) >= 0.0 && travels.after_end(0.0) <= 0.0
        });
        if exact::meet(pair) != touches_at_rest {
            return Err(format!("the oracles differ at rest: {truth:?}"));
        }
    }
    for (from_m, to_m) in queries(truth.as_ref(), &mut random) {
        let [a, b] = [&pair.a, &pair.b].map(|t| shuffled(&mut random, t.0));
        let ahead = sweep.between(from_m, to_m).map_err(|e| e.to_string())?;
        let back = back.between(from_m, to_m).map_err(|e| e.to_string())?;
        let pair = Pair { a, b };
        let found = first_contact(&pair.a, &pair.b, &ahead);
        check(&pair, &ahead, truth.as_ref(), found)?;
        let exchanged = Pair { a: pair.b, b: pair.a };
        let found = first_contact(&exchanged.a, &exchanged.b, &back);
        check(&exchanged, &back, truth.as_ref(), found)
            .map_err(|difference| format!("exchanged, {difference}"))?;
    }
    Ok(truth.is_some_and(|t| t.start() <= TRAVEL_MAX && t.end() >= -TRAVEL_MAX))
}

/// From where to where contact is asked for: everywhere, and close to the ends of contact.
fn queries(truth: Option<&Travels>, random: &mut RandomPoints) -> Vec<(f64, f64)> {
    let mut queries = vec![(-TRAVEL_MAX, TRAVEL_MAX)];
    let Some(truth) = truth else {
        queries.push((random.real() * 10.0, 10.0));
        return queries;
    };
    let (start, end) = (truth.start(), truth.end());
    let inside = start + (end - start) * random.real().abs();
    let mut beside = |travel: f64| match random.below(8) {
        0 | 1 => travel,
        2 => travel.next_up(),
        3 => travel.next_down(),
        4 => travel + 2e-9,
        5 => travel - 2e-9,
        _ => travel + random.real() * 3e-9,
    };
    queries.extend([
        (start - 1.0, beside(start)),
        (beside(end), end + 1.0),
        (beside(start), beside(end)),
        (inside, inside + 1.0),
    ]);
    let within = |travel: f64| travel.clamp(-TRAVEL_MAX, TRAVEL_MAX);
    let queries = queries.into_iter().map(|(from, to)| (within(from), within(to.max(from))));
    queries.collect()
}

/// Compares an answer with the truth.
fn check(
    pair: &Pair,
    sweep: &Sweep,
    truth: Option<&Travels>,
    found: Option<FirstTouch>,
) -> Result<(), String> {
    let (from, to) = (sweep.from_m(), sweep.to_m());
    let wrong = |what: &str| {
        let known = truth.map(|t| (t.start(), t.end()));
        Err(format!("{what}: {found:?} for {known:?} from {from:?} to {to:?}"))
    };
    let Some(truth) = truth else {
        return if found.is_some() { wrong("they never touch") } else { Ok(()) };
    };
    let (after_start, before_end) = (truth.after_start(to), -truth.after_end(from));
    let touches = after_start >= 0.0 && before_end >= 0.0;
    let is_open = after_start.abs().min(before_end.abs()) <= TOLERANCE_M;
    if found.is_some() != touches && !is_open {
        return wrong(if touches { "contact is missed" } else { "there is no contact" });
    }
    let Some(FirstTouch { travel_m, point }) = found else { return Ok(()) };
    // Beyond the later of the true start and the begin.
    let late = truth.after_start(travel_m).min(travel_m - from);
    if !(late.abs() <= TOLERANCE_M && from <= travel_m && travel_m <= to) {
        return wrong(&format!("{late:e} m late"));
    }
    let moved = Triangle(pair.b.0.map(|p| p + sweep.direction() * travel_m));
    let (box_a, box_b) = (pair.a.bounds(), moved.bounds());
    let size = (box_a.max - box_a.min).max(box_b.max - box_b.min).max_element();
    let magnitude = [box_a.min, box_a.max, box_b.min, box_b.max].map(|p| p.abs().max_element());
    let magnitude = magnitude.into_iter().fold(travel_m.abs(), f64::max);
    // Squares would overflow.
    if magnitude > 1e100 {
        return Ok(());
    }
    let room = 1e-6 * size + 1e-14 * magnitude + 2.0 * TOLERANCE_M;
    let [off_a, off_b] = [&pair.a, &moved].map(|t| distance(point, t));
    if !(off_a <= room && off_b <= room) {
        return wrong(&format!("the point is {off_a:e} off A, {off_b:e} off B, size {size:e}"));
    }
    Ok(())
}

/// The distance of a point from a triangle, within rounding.
fn distance(point: DVec3, t: &Triangle) -> f64 {
    let [p, q, r] = t.0;
    let length = |v: DVec3| libm::sqrt(v.dot(v));
    let from_edge = |from: DVec3, to: DVec3| {
        let (along, towards) = (to - from, point - from);
        let squared = along.dot(along);
        let share = if squared > 0.0 { towards.dot(along) / squared } else { 0.0 };
        length(towards - along * share.clamp(0.0, 1.0))
    };
    let edges = [(p, q), (q, r), (r, p)];
    let from_edges = edges.map(|(from, to)| from_edge(from, to)).into_iter().fold(1e300, f64::min);
    let normal = (q - p).cross(r - p);
    let is_above =
        edges.iter().all(|(from, to)| normal.dot((*to - *from).cross(point - *from)) > 0.0);
    if is_above { from_edges.min(normal.dot(point - p).abs() / length(normal)) } else { from_edges }
}
