//! Days are those of the calendar; dossiers are read, and unsound ones refused with their place.

use super::*;
use crate::policy::{DEFAULT_POLICY, Policy};
use proptest::prelude::*;

const DOSSIER: &str = r#"
[dossier]
signed = [{ name = "A. Ash", role = "chair", date = "2026-01-15" }]
dissent = [{ name = "B. Birch", text = "the worst-off should come first" }]
evidence = ["https://example.org/report"]
valid_until = "2028-02-29"

[[regression]]
scenario = "../scenarios/small.toml"
winner = "wall"
worst = "pedestrian"
reason = "nobody on foot is hit"
"#;

fn parsed(from: &str, to: &str) -> Result<Policy, DataFileError> {
    assert!(DOSSIER.contains(from), "{from}");
    Policy::parse("my.toml", &format!("{DEFAULT_POLICY}{}", DOSSIER.replacen(from, to, 1)))
}

#[test]
fn a_dossier_is_read_and_knows_its_last_day() {
    let policy = parsed("[dossier]", "[dossier]").expect("sound");
    let dossier = policy.dossier.expect("there is one");
    assert_eq!((dossier.signed.len(), dossier.dissent.len(), dossier.evidence.len()), (1, 1, 1));
    let day = |text: &str| Day::parse(text).expect("a day");
    let (last, line) = dossier.valid_until.expect("stated");
    assert_eq!(last, day("2028-02-29"));
    let text = format!("{DEFAULT_POLICY}{DOSSIER}");
    assert!(text.lines().nth(line - 1).is_some_and(|line| line.starts_with("valid_until")));
    assert_eq!(dossier.expired(day("2028-02-29")), None);
    assert_eq!(dossier.expired(day("2028-03-01")), Some((last, line)));
    let regression = &dossier.regressions[0];
    assert_eq!(text.lines().nth(regression.line - 1), Some("[[regression]]"));
    assert_eq!(Policy::shipped().expect("sound").dossier, None);
}

#[test]
fn unsound_dossiers_are_refused_with_their_place() {
    for (from, to, says) in [
        ("2028-02-29", "2027-02-29", "is no day"),
        ("2028-02-29", "soon", "is no day"),
        ("2026-01-15", "15.01.2026", "is no day"),
        ("2026-01-15", "2028-03-01", "signed after"),
        ("A. Ash", " ", "name is empty"),
        ("chair", "", "role is empty"),
        ("the worst-off should come first", "", "text is empty"),
        ("https://example.org/report", "", "evidence is empty"),
        ("\"2028-02-29\"", "2028-02-29", "expected a string"),
        ("valid_until = \"2028-02-29\"", "", "valid_until"),
        ("evidence", "proof", "proof"),
        ("role = \"chair\"", "rank = \"chair\"", "rank"),
        ("nobody on foot is hit", "", "reason is empty"),
        ("../scenarios/small.toml", "", "scenario is empty"),
        ("worst = \"pedestrian\"", "worst = \"wall\"", "the worst too"),
        ("winner = \"wall\"", "winner = \"\"", "winner is empty"),
        ("winner = \"wall\"", "", "states one outcome"),
        ("winner = \"wall\"", "winner = \"wall\"\nrefused = true", "states one outcome"),
        ("reason", "because", "because"),
    ] {
        let fault = parsed(from, to).expect_err(to);
        assert!(fault.what.contains(says), "{to}: {fault}");
        assert!(fault.line > 10 && !fault.remedy.is_empty(), "{fault}");
    }
}

/// Counts one day after the other, as a calendar on a wall does.
#[test]
fn days_since_1970_are_those_of_the_calendar() {
    let (mut year, mut month, mut day) = (1970_u16, 1_u8, 1_u8);
    for days in 0..200_000 {
        let found = Day::of_unix_days(days).expect("before the year 10000");
        assert_eq!(found, Day::new(year, month, day).expect("a day"), "{days}");
        assert_eq!(Day::parse(&found.to_string()), Some(found));
        (year, month, day) = if Day::new(year, month, day + 1).is_some() {
            (year, month, day + 1)
        } else if month < 12 {
            (year, month + 1, 1)
        } else {
            (year + 1, 1, 1)
        };
    }
    // `date -ud @4102444800`
    assert_eq!(Day::of_unix_days(47_482).map(|day| day.to_string()), Some("2100-01-01".into()));
    assert_eq!((Day::of_unix_days(u64::MAX), Day::of_unix_days(4_000_000)), (None, None));
}

proptest! {
    #[test]
    fn only_days_are_read(text in "[0-9]{4}-[0-9]{2}-[0-9]{2}|[0-9+-]{8,11}|\\PC{0,12}") {
        if let Some(day) = Day::parse(&text) {
            prop_assert_eq!(day.to_string(), text);
        }
    }
}
