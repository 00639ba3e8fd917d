//! The record survives a round trip; the total is found in callgrind's output.

use super::*;

#[test]
fn a_record_survives_writing_and_reading() -> Result<()> {
    let entry = |benchmark: &str, instructions| Entry {
        benchmark: benchmark.into(),
        instructions,
        commit: "0123abc+".into(),
        rustc: "rustc 1.95.0 (59807616e 2026-04-14)".into(),
    };
    let record = Record(vec![entry("b", 1), entry("a", u64::MAX)]);
    assert_eq!(record.to_string().parse::<Record>()?, record);
    assert_eq!(record.instructions("a"), Some(u64::MAX));
    assert_eq!(record.instructions("c"), None);
    Ok(())
}

#[test]
fn a_damaged_record_is_refused() {
    let whole = Record(vec![Entry {
        benchmark: "a".into(),
        instructions: 7,
        commit: "c".into(),
        rustc: "r".into(),
    }])
    .to_string();
    for damaged in [whole.replace('7', "x"), whole.replace("\tr", ""), whole[1..].to_owned()] {
        assert!(damaged.parse::<Record>().is_err(), "{damaged}");
    }
}

#[test]
fn the_total_is_found_among_the_figures() {
    let figures = "version: 1\nevents: Ir\nsummary: 12\n\nfn=(1) x\n3 12\n\ntotals: 12345\n";
    assert_eq!(total(figures), Some(12345));
    assert_eq!(total("totals: \n"), None);
}
