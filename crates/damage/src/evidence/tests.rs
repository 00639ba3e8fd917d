//! Laws of evidence: merging, order, nesting.

use super::*;
use crate::approach::opposite;
use geometry::{DVec3, Directions};
use proptest::prelude::*;

fn directions() -> Directions {
    Directions::around(DVec3::X, DVec3::Z)
}

type Piece = (f64, Vec<[f64; 3]>, u16, bool);

fn pieces() -> impl Strategy<Value = Vec<Piece>> {
    let point = prop::array::uniform3(-2.0..2.0_f64);
    let piece = (0.0..0.2_f64, prop::collection::vec(point, 1..5), any::<u16>(), any::<bool>());
    prop::collection::vec(piece, 1..8)
}

fn seen(points: &[[f64; 3]], zones: u16) -> Seen {
    let mut seen = Seen { zones_a: Zones(zones), zones_b: Zones(!zones), ..Seen::NOTHING };
    points.iter().for_each(|p| seen.patch.add(&directions(), DVec3::from_array(*p)));
    seen
}

fn gather<'a>(pieces: impl IntoIterator<Item = &'a Piece>) -> Evidence {
    let mut evidence = Evidence::none();
    for (travel, points, zones, is_open) in pieces {
        let seen = seen(points, *zones);
        if *is_open {
            evidence.add_open(*travel, &seen);
        } else {
            evidence.add_hits(*travel, &seen);
        }
    }
    evidence
}

fn wide() -> Supports {
    Supports([10.0; DIRECTIONS])
}

proptest! {
    #[test]
    fn order_and_repetition_change_nothing(pieces in pieces()) {
        let once = gather(&pieces);
        let twice = gather(pieces.iter().rev().chain(&pieces));
        prop_assert_eq!(once, twice);
        let (left, right) = pieces.split_at(pieces.len() / 2);
        let mut merged = gather(right);
        merged.merge(&gather(left));
        merged.merge(&gather(left));
        prop_assert_eq!(once, merged);
    }

    /// As open work turns into hits within its bounds, every interval nests.
    #[test]
    fn intervals_nest_as_work_is_done(pieces in pieces(), i in 0..72_usize, keep in 0..4_usize) {
        let mut last: Option<[Interval; 1]> = None;
        for done in 0..=pieces.len() {
            // A finished piece finds some of the points that it could have found.
            let now: Vec<Piece> = pieces.iter().enumerate().map(|(k, (s, points, zones, _))| {
                let found = if k < done { points.len().min(keep + 1) } else { points.len() };
                (*s, points[..found].to_vec(), *zones, k >= done)
            }).collect();
            let evidence = gather(&now);
            let j = opposite(i);
            let next = [evidence.span(i, j, &wide())];
            if let Some(last) = last {
                for (before, after) in last.iter().zip(&next) {
                    prop_assert!(before.lo() <= after.lo() + 1e-12, "{before:?} {after:?}");
                    prop_assert!(after.hi() <= before.hi() + 1e-12, "{before:?} {after:?}");
                }
            }
            last = Some(next);
        }
        prop_assert!(last.is_some_and(|l| l.iter().all(|w| w.is_settled())));
    }
}

#[test]
fn what_may_lie_anywhere_is_still_bounded_by_the_hulls() {
    let mut evidence = Evidence::none();
    assert!(!evidence.is_open());
    evidence.add_open_everywhere();
    assert!(evidence.is_open());
    assert_eq!(evidence.span(0, 36, &wide()), Interval::new(0.0, 20.0));
    assert_eq!(evidence.zones_at_most(), [Zones(u16::MAX); 2]);
}
