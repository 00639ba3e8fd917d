//! Planted tables, for each of which it is known what is true of every claim.

use super::*;
use Verdict::{Fails, Holds, Open};

const DEPTHS: [u32; 6] = [0, 1, 2, 4, 8, 12];

/// Lines of every scheme from a function of scheme and depth: time, bytes, share of runs beyond
/// memory. Random match has sixteen seeds with a spread.
fn planted(of_point: impl Fn(Scheme, u32) -> (f64, f64, f64)) -> Curves {
    let mut curves = Curves { alone_us: 100.0, ..Curves::default() };
    for (line, scheme) in curves.lines.iter_mut().zip(SCHEMES) {
        for depth in DEPTHS {
            let (time, moved, out) = of_point(scheme, depth);
            let (count, share) = if scheme == Scheme::RandomMatch { (16, 0.02) } else { (1, 0.0) };
            let spread = |mean: f64| Spread { mean, deviation: share * mean, count };
            let (time_us, moved) = (spread(time), spread(moved));
            line.push((depth, Point { time_us, moved, out, ..Point::default() }));
        }
    }
    curves
}

/// 0 for the best, 1 for random, 2 for the lowest match.
fn rank(scheme: Scheme) -> f64 {
    match scheme {
        Scheme::RandomMatch => 1.0,
        Scheme::LowestMatch => 2.0,
        _ => 0.0,
    }
}

/// As the paper says it is: the best depth is `best`, random match moves `gain` times as much.
fn as_the_paper_says(best: u32, gain: f64) -> Curves {
    planted(|scheme, depth| {
        let off = (f64::from(depth) - f64::from(best)).abs();
        let time = 30.0 + 2.0 * off + 3.0 * rank(scheme);
        let moved = 1.0 + (gain - 1.0) * rank(scheme);
        let is_out = depth <= 2 && rank(scheme) > 0.0;
        (time, moved, f64::from(u8::from(is_out)))
    })
}

/// The other way round.
fn against_the_paper() -> Curves {
    planted(|scheme, depth| {
        let time = 40.0 + 4.0 * f64::from(depth) - 3.0 * rank(scheme);
        let is_out = depth >= 8 && rank(scheme) == 0.0;
        (time, 4.0 - rank(scheme), f64::from(u8::from(is_out)))
    })
}

/// Everybody the same but for hairs.
fn level() -> Curves {
    planted(|scheme, depth| {
        let hair = 1.0 + 0.004 * f64::from(depth % 3) - 0.005 * rank(scheme);
        (40.0 * hair, 2.0 * hair, 0.0)
    })
}

#[test]
fn what_the_paper_says_is_found_where_it_is_planted() {
    let cell = as_the_paper_says(4, 1.5);
    assert_eq!(less_travels(&cell), Holds);
    assert_eq!(interior(&cell), Holds);
    assert_eq!(deeper(&as_the_paper_says(8, 1.5), &cell), Holds);
    let growing = [1.1, 1.3, 1.6].map(|gain| as_the_paper_says(4, gain));
    assert_eq!(grows(&growing), Holds);
    assert_eq!(runs_out(&cell), Holds);
    assert_eq!(faster(&cell), Holds);
    assert!((pays(&cell).expect("both were run").mean - 1.1).abs() < 1e-9);
}

#[test]
fn its_opposite_is_found_where_it_is_planted() {
    let cell = against_the_paper();
    assert_eq!(less_travels(&cell), Fails);
    assert_eq!(interior(&cell), Fails);
    assert_eq!(deeper(&as_the_paper_says(2, 1.5), &as_the_paper_says(8, 1.5)), Fails);
    // The same best depth, beyond doubt, is not a deeper one.
    assert_eq!(deeper(&as_the_paper_says(4, 1.5), &as_the_paper_says(4, 1.5)), Fails);
    let shrinking = [1.6, 1.3, 1.1].map(|gain| as_the_paper_says(4, gain));
    assert_eq!(grows(&shrinking), Fails);
    assert_eq!(runs_out(&cell), Fails);
    assert_eq!(faster(&cell), Fails);
}

#[test]
fn hairs_decide_nothing() {
    let cell = level();
    assert_eq!(less_travels(&cell), Open);
    assert_eq!(interior(&cell), Open);
    assert_eq!(deeper(&cell, &level()), Open);
    assert_eq!(grows(&[level(), level(), level()]), Open);
    assert_eq!(runs_out(&cell), Open, "nobody ran out");
    assert_eq!(faster(&cell), Open);
    let nothing = Curves::default();
    assert_eq!([less_travels(&nothing), interior(&nothing), runs_out(&nothing)], [Open; 3]);
    assert_eq!(
        [deeper(&nothing, &cell), grows(std::slice::from_ref(&nothing)), faster(&nothing)],
        [Open; 3]
    );
}

#[test]
fn one_depth_at_which_random_match_moves_less_refutes_the_order_at_every_depth() {
    let cell = planted(|scheme, depth| {
        let is_odd = depth == 8 && scheme == Scheme::RandomMatch;
        (40.0, if is_odd { 0.9 } else { 1.0 + rank(scheme) }, 0.0)
    });
    assert_eq!(less_travels(&cell), Fails);
}

#[test]
fn a_spread_as_wide_as_the_difference_decides_nothing() {
    let wide = Spread { mean: 1.2, deviation: 0.5, count: 16 };
    let narrow = Spread { mean: 1.2, deviation: 0.05, count: 16 };
    let one = Spread { mean: 1.0, deviation: 0.0, count: 1 };
    assert_eq!(compare(&one, &wide), Ordering::Equal);
    assert_eq!(compare(&one, &narrow), Ordering::Less);
    assert_eq!(compare(&narrow, &one), Ordering::Greater);
}

#[test]
fn running_out_at_high_depth_or_of_best_match_is_not_what_the_paper_says() {
    let out_where = |is_out: fn(Scheme, u32) -> bool| {
        planted(move |scheme, depth| (40.0, 1.0, f64::from(u8::from(is_out(scheme, depth)))))
    };
    let is_low = |scheme: Scheme| rank(scheme) > 0.0;
    assert_eq!(runs_out(&out_where(|scheme, depth| rank(scheme) > 0.0 && depth > 2)), Fails);
    assert_eq!(runs_out(&out_where(|scheme, _| rank(scheme) > 0.0)), Fails, "at every depth");
    assert_eq!(runs_out(&out_where(|_, depth| depth <= 1)), Fails, "best match too");
    assert_eq!(runs_out(&out_where(|_, depth| depth == 0)), Open, "of depth 0 nothing is said");
    assert!(is_low(Scheme::LowestMatch));
    let random = out_where(|scheme, depth| scheme == Scheme::RandomMatch && depth <= 1);
    assert_eq!(runs_out(&random), Holds);
}

#[test]
fn buffers_that_help_up_to_a_point_are_told_from_those_that_harm() {
    let with = |speeds: &[f64]| -> Vec<Curves> {
        speeds.iter().map(|speed| planted(|_, _| (100.0 / speed, 1.0, 0.0))).collect()
    };
    assert_eq!(saturates(&with(&[1.0, 1.5, 2.0, 2.01, 1.99]), 4), Holds);
    assert_eq!(saturates(&with(&[1.0, 1.5, 2.0, 1.6, 1.2]), 4), Fails, "it falls again");
    assert_eq!(saturates(&with(&[2.0, 1.9, 1.7, 1.6]), 4), Fails, "it falls");
    assert_eq!(saturates(&with(&[1.0, 1.4, 1.1, 1.8]), 4), Fails, "it does not rise steadily");
    assert_eq!(saturates(&with(&[1.0, 1.01, 0.99, 1.0]), 4), Open);
    assert_eq!(saturates(&with(&[1.0, 1.5, 2.0]), 5), Open, "no such depth");
}
