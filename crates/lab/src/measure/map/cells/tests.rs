//! A planted map: each claim's region is known, and found.

use super::*;
use crate::measure::map::machine::SCHEMES;
use crate::measure::map::table::{Place, Point, Spread};
use scenario::Scheme;

fn grid() -> Grid {
    Grid {
        sizes: vec![1_000, 10_000],
        larger: Vec::new(),
        memories: vec![10, 100],
        bytes: vec![0.0, 1.0, 10.0],
        depths: vec![0, 2, 4, 6],
        cores: vec![4],
        size_max: vec![u32::MAX],
        buffers: vec![16],
        more_buffers: vec![1, 64],
        seeds: 16,
    }
}

/// A map in which schemes differ only where a byte costs 1 ns or more, in time and bytes; deep
/// contacts are fastest at depth 4, scratches at 2; a memory of 10 % is too little for random and
/// lowest match at depth 2 where nothing costs anything, and for all at depth 6 otherwise.
fn planted() -> Sheets {
    let grid = grid();
    let mut sheets = Sheets::new();
    for subject in grid.subjects() {
        for key in grid.sheets(subject) {
            let mut sheet = Sheet { alone_us: 100.0, ..Sheet::default() };
            for (scheme, matching) in SCHEMES.into_iter().enumerate() {
                if grid.is_light(&key) && matching != Scheme::BestMatchLoad {
                    continue;
                }
                let bytes = if key.machine.copies() { grid.bytes.len() } else { 1 };
                for (byte, depth) in
                    (0..bytes).flat_map(|byte| grid.depths.iter().map(move |d| (byte, *d)))
                {
                    let is_match = matches!(matching, Scheme::BestMatch | Scheme::BestMatchLoad);
                    let step = match matching {
                        Scheme::RandomMatch => 1.0,
                        Scheme::LowestMatch => 2.0,
                        _ => 0.0,
                    };
                    let differs = if grid.bytes[byte] >= 1.0 { step } else { 0.0 };
                    let best = if subject.is_deep { 4.0 } else { 2.0 };
                    let slow = if key.buffer == 1 { 2.0 } else { 1.0 };
                    let time = 40.0 + 8.0 * (f64::from(depth) - best).abs() + 5.0 * differs;
                    let grown = 1.0 + f64::from(subject.size) / 10_000.0;
                    let spread = |mean| Spread { mean, deviation: 0.0, count: 16 };
                    let point = Point {
                        time_us: spread(time * slow),
                        moved: spread(1.0 + differs * grown),
                        ..Point::default()
                    };
                    let place = Place { byte, short: None, depth, scheme };
                    sheet.points.insert(place, point);
                    let is_out = match byte {
                        0 => !is_match && depth == 2,
                        _ => depth == 6,
                    };
                    if key.machine.copies() && is_out {
                        for beyond in Beyond::ALL {
                            let short = Some((beyond, 0));
                            let point = Point { out: 1.0, ..point };
                            sheet.points.insert(Place { short, ..place }, point);
                        }
                    }
                }
            }
            sheets.insert(key, sheet);
        }
    }
    sheets
}

fn shares(cells: &[Cell], claim: char, is_in: impl Fn(&Cell) -> bool) -> Shares {
    Shares::over(cells.iter().filter(|cell| cell.claim == claim && is_in(cell)))
}

#[test]
fn every_claim_gets_its_planted_verdict_in_its_planted_region() {
    let cells = judge(&planted(), &grid());
    let copying = |cell: &Cell| cell.machine == Machine::Copying;
    let costs = |cell: &Cell| cell.byte_ns.is_some_and(|ns| ns >= 1.0);
    for claim in ['a', 'g'] {
        let inside = shares(&cells, claim, |cell| copying(cell) && costs(cell));
        let outside = shares(&cells, claim, |cell| copying(cell) && !costs(cell));
        assert!(inside.holds > 0 && inside.holds == inside.all(), "{claim} {inside:?}");
        assert!(outside.open > 0 && outside.open == outside.all(), "{claim} {outside:?}");
        assert_eq!(outside.verdict(), "nobody can tell");
        // On ours nothing is copied, so there the schemes are level.
        let ours = shares(&cells, claim, |cell| cell.machine == Machine::Sealed);
        assert_eq!((ours.holds, ours.fails), (0, 0), "{claim}");
    }
    for claim in ['b', 'c', 'f'] {
        let all = shares(&cells, claim, |_| true);
        assert!(all.holds > 0 && all.holds == all.all(), "{claim} {all:?}");
        assert_eq!(all.verdict(), "holds");
    }
    let grows = shares(&cells, 'd', |cell| copying(cell) && costs(cell));
    assert!(grows.holds > 0 && grows.holds == grows.all(), "{grows:?}");
    let level = shares(&cells, 'd', |cell| copying(cell) && !costs(cell));
    assert_eq!(level.open, level.all());
    // Out of memory: as the paper says where nothing costs anything, and not where it does.
    let little = |cell: &Cell| copying(cell) && cell.memory == Some(10);
    let free = shares(&cells, 'e', |cell| little(cell) && !costs(cell));
    let dear = shares(&cells, 'e', |cell| little(cell) && costs(cell));
    assert!(free.holds > 0 && free.holds == free.all(), "{free:?}");
    assert!(dear.fails > 0 && dear.fails == dear.all(), "{dear:?}");
    let much = shares(&cells, 'e', |cell| cell.memory == Some(100));
    assert_eq!(much.open, much.all());
    assert_eq!(shares(&cells, 'e', |cell| cell.machine == Machine::Sealed).all(), 0);
}

#[test]
fn the_region_of_a_verdict_is_found_in_words() {
    let grid = grid();
    let cells = judge(&planted(), &grid);
    let of_claim = |claim| -> Vec<&Cell> {
        let here = |cell: &&Cell| cell.claim == claim && cell.machine == Machine::Copying;
        cells.iter().filter(here).collect()
    };
    let found = region(&of_claim('a'), Verdict::Holds, &grid).expect("there is one");
    assert_eq!(found.words, "a byte costs 1 ns or more");
    assert!(found.inside > 0.999 && found.covered > 0.999, "{found:?}");
    let found = region(&of_claim('e'), Verdict::Fails, &grid).expect("there is one");
    assert_eq!(found.words, "a byte costs 1 ns or more and memory is less than 100 %");
    assert_eq!(region(&of_claim('b'), Verdict::Holds, &grid), None, "it holds everywhere");
}
