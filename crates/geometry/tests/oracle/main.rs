//! Campaign: the triangle test, alone and in patches, the contact points and the first contact
//! against exact arithmetic.
//!
//! Pair number n of a seed is always the same pair, so a difference can be replayed by its number.
//! The sizes can be set for longer campaigns:
//!
//! ```text
//! ORACLE_PAIRS=1000000 ORACLE_SEED=7 cargo test --release -p geometry --test oracle -- --nocapture
//! ```

mod cases;
mod exact;
mod motions;
mod sweeps;
mod travels;

use cases::{FAMILIES, GROUP, Pair, family, group, pair};
use fearless_simd::dispatch;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread;
use trolley_geometry::patch::{Patches, Posed, meet_all};
use trolley_geometry::triangle::{contact, intersect};
use trolley_geometry::{DVec3, simd};

/// A setting of the campaign from the environment.
#[expect(clippy::disallowed_methods, reason = "a test binary has no command line of its own")]
fn setting(name: &str, default: u64) -> u64 {
    std::env::var(name).map_or(default, |text| text.parse().expect("a whole number"))
}

/// How many pairs of each family there were, and how many met.
type Tally = Vec<(u64, u64)>;

/// Runs `check` on the numbers 0 to `count`, on all cores; it records its findings in the tally, by
/// family.
#[expect(clippy::print_stderr, reason = "a long campaign says how far it is")]
fn campaign(count: u64, families: usize, check: impl Fn(u64, &mut Tally) + Sync) -> Tally {
    let threads = thread::available_parallelism().map_or(1, |n| n.get() as u64);
    let done = AtomicU64::new(0);
    let run = |part: u64| {
        let mut tally = vec![(0, 0); families];
        for number in (part..count).step_by(threads as usize) {
            check(number, &mut tally);
            let before = done.fetch_add(1, Ordering::Relaxed);
            let tenths = |done: u64| 10 * done / count;
            if count >= 100_000 && tenths(before + 1) > tenths(before) {
                eprintln!("{} of {count}", before + 1);
            }
        }
        tally
    };
    let mut tally = vec![(0, 0); families];
    thread::scope(|scope| {
        let run = &run;
        let parts: Vec<_> = (0..threads).map(|part| scope.spawn(move || run(part))).collect();
        for part in parts {
            let part = part.join().expect("a difference, printed above");
            for (sum, more) in tally.iter_mut().zip(part) {
                *sum = (sum.0 + more.0, sum.1 + more.1);
            }
        }
    });
    tally
}

fn count(tally: &mut Tally, family: usize, hit: bool) {
    let (all, hits) = &mut tally[family];
    *all += 1;
    *hits += u64::from(hit);
}

/// Prints a tally of pairs without a difference, by families of these names.
#[expect(clippy::print_stdout, reason = "the tally is what the campaign is run for")]
fn report(tally: &Tally, names: &[&str]) {
    println!("{:<16}{:>10}{:>10}{:>10}", "family", "pairs", "hits", "misses");
    for (name, (all, hits)) in names.iter().zip(tally) {
        println!("{name:<16}{all:>10}{hits:>10}{:>10}", all - hits);
        // A family that never meets, or never misses, would test only half of its claim.
        assert!(*all < 600 || (*hits > 0 && hits < all), "{name}: {hits} of {all}");
    }
    let (all, hits) = tally.iter().fold((0, 0), |sum, part| (sum.0 + part.0, sum.1 + part.1));
    println!("{:<16}{all:>10}{hits:>10}{:>10}   no difference", "all", all - hits);
}

/// The names of the families of pairs.
fn names() -> Vec<&'static str> {
    FAMILIES.iter().map(|family| family.name).collect()
}

// verifies REQ-EXACT
#[test]
fn the_test_equals_exact_arithmetic() {
    let seed = setting("ORACLE_SEED", 1);
    let tally = campaign(setting("ORACLE_PAIRS", 20_000), FAMILIES.len(), |number, tally| {
        let pair = &pair(seed, number);
        let truth = exact::meet(pair);
        assert_eq!(intersect(&pair.a, &pair.b), truth, "pair {number}: {pair:?}");
        assert_eq!(intersect(&pair.b, &pair.a), truth, "pair {number}, exchanged: {pair:?}");
        count(tally, family(number), truth);
    });
    report(&tally, &names());
}

/// The pairs of a group are tested alone, and among the others: then sizes of all kinds are in one
/// patch.
// verifies REQ-EXACT
#[test]
fn patches_equal_exact_arithmetic_at_every_level() {
    let seed = setting("ORACLE_SEED", 1);
    let groups = setting("ORACLE_PAIRS", 20_000).div_ceil(GROUP as u64);
    let tally = campaign(groups, FAMILIES.len(), |number, tally| {
        let group = group(seed, number);
        let posed = Posed::new(&group.pose, &group.a, &group.b);
        let mut truth = 0_u64;
        for i in 0..GROUP as u32 {
            let [a, b] = posed.triangles([i; 2]);
            let hit = exact::meet(&Pair { a, b });
            truth |= u64::from(hit) << i;
            count(tally, family(GROUP as u64 * number + u64::from(i)), hit);
        }
        let mut patches = Patches::default();
        for level in simd::levels() {
            for size in [1, 8] {
                let mut found = 0_u64;
                let mut hit = |[a, b]: [u32; 2]| found |= u64::from(a == b) << a;
                for start in (0..GROUP as u32).step_by(size) {
                    let range = start..start + size as u32;
                    dispatch!(level, simd => {
                        let ranges = (range.clone(), range.clone());
                        meet_all(simd, &posed, &mut patches, ranges, &mut hit);
                    });
                }
                let name = simd::name(level);
                assert_eq!(found, truth, "group {number}, {size} at {name}: {group:?}");
            }
        }
    });
    let levels: Vec<_> = simd::levels().map(simd::name).collect();
    println!("patches, at {}", levels.join(", "));
    report(&tally, &names());
}

#[test]
fn contact_points_are_the_corners_of_the_intersection() {
    let seed = setting("ORACLE_SEED", 1);
    let pairs = setting("ORACLE_PAIRS", 20_000) / 16;
    let tally = campaign(pairs, FAMILIES.len(), |number, tally| {
        let pair = &pair(seed, number);
        let corners = exact::corners(pair);
        let found = contact(&pair.a, &pair.b);
        let found = found.points();
        assert_eq!(found.is_empty(), corners.is_empty(), "pair {number}: {pair:?}");
        assert_eq!(exact::meet(pair), !corners.is_empty(), "oracles differ on {number}: {pair:?}");
        let (a, b) = (pair.a.bounds(), pair.b.bounds());
        for point in found {
            let inside = |b: &trolley_geometry::Bounds| {
                b.min.cmple(*point).all() && point.cmple(b.max).all()
            };
            assert!(inside(&a) && inside(&b), "pair {number}: {point} out of the boxes: {pair:?}");
        }
        // Documented bounds: parts in 10^10 of an edge, and a few ulps of the coordinates; per
        // axis.
        let extent = (a.max - a.min).max(b.max - b.min);
        let size = a.min.abs().max(a.max.abs()).max(b.min.abs()).max(b.max.abs());
        let room = extent * 1e-10 + size * 1e-15 + DVec3::splat(1e-322);
        let near = |p: DVec3, q: DVec3| (p - q).abs().cmple(room).all();
        for corner in &corners {
            assert!(
                found.iter().any(|point| near(*point, *corner)),
                "pair {number}: corner {corner} is missing in {found:?}: {pair:?}"
            );
        }
        for point in found {
            assert!(
                corners.iter().any(|corner| near(*point, *corner)),
                "pair {number}: {point} is not one of {corners:?}: {pair:?}"
            );
        }
        count(tally, family(number), !corners.is_empty());
    });
    let (all, hits) = tally.iter().fold((0, 0), |sum, part| (sum.0 + part.0, sum.1 + part.1));
    println!("contact: {all} pairs, {hits} contacts, no difference");
    assert!(pairs < 1_000 || hits > all / 10);
}
