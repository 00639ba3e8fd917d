//! The fit finds the costs that samples were made from, and never a negative one.

use super::*;
use proptest::prelude::*;

proptest! {
    #[test]
    fn costs_are_found_again(
        costs in (100.0..5_000.0, 0.2..20.0, 1.0..80.0, 1.0..50.0),
        counts in prop::collection::vec((10_u64..100_000, 0_u64..20_000, 0_u64..4_000), 40..200),
    ) {
        let (job, cb, cp, hit): (f64, f64, f64, f64) = costs;
        let samples: Vec<Sample> = counts.into_iter().map(|(nb, np, hits)| Sample {
            nb, np, hits, ns: job + cb * nb as f64 + cp * np as f64 + hit * hits as f64,
        }).collect();
        let found = fit(&samples);
        for (found, made) in found.iter().zip([job, cb, cp, hit]) {
            prop_assert!((found - made).abs() < 1e-3 * (1.0 + made), "{found} for {made}");
        }
    }

    #[test]
    fn costs_of_copies_are_found_again(
        per_byte in 0.0..5.0_f64, per_section in 0.0..9_000.0_f64,
        counts in prop::collection::vec((1_000_u32..1_000_000, 1_u32..500), 8..30),
    ) {
        prop_assume!(per_byte + per_section > 0.1);
        let samples: Vec<[f64; 3]> = counts.into_iter().map(|(bytes, sections)| {
            let (bytes, sections) = (f64::from(bytes), f64::from(sections));
            [bytes, sections, per_byte * bytes + per_section * sections]
        }).collect();
        let [byte, section] = fit_copies(&samples);
        for [bytes, sections, ns] in samples {
            let found = byte * bytes + section * sections;
            prop_assert!((found - ns).abs() < 1e-4 * (1.0 + ns), "{found} for {ns}");
        }
        prop_assert!(byte >= 0.0 && section >= 0.0);
    }

    #[test]
    fn no_cost_is_negative_whatever_was_measured(
        rows in prop::collection::vec((0_u64..1_000, 0_u64..1_000, 0_u64..100, 0.0..1e6), 0..60),
    ) {
        let sample = |(nb, np, hits, ns)| Sample { nb, np, hits, ns };
        let samples: Vec<Sample> = rows.into_iter().map(sample).collect();
        let found = fit(&samples);
        prop_assert!(found.iter().all(|cost| *cost >= 0.0), "{found:?}");
    }
}
