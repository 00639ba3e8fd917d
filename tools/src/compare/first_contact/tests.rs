//! The page says who is wrong, and by how much.

use super::page::Page;
use super::{HALVING, Line, OURS};
use std::collections::BTreeMap;

fn line(peer: &str, name: &str, first_contact_m: Option<f64>, query_ms: f64) -> Line {
    let (peer, name) = (peer.to_owned(), name.to_owned());
    Line { peer, name, first_contact_m, query_ms, effort: super::Effort::default() }
}

#[test]
fn every_answer_is_held_against_ours() {
    let lines = [
        line(OURS, "cars-a", Some(1.0), 0.1),
        line(OURS, "cars-b", None, 0.2),
        line(HALVING, "cars-a", Some(1.0005), 0.1),
        line("late", "cars-a", Some(1.25), 5.0),
        line("late", "cars-b", Some(2.0), 0.2),
        line("blind", "cars-a", None, 0.3),
    ];
    let families = BTreeMap::from([("cars", vec!["cars-a".to_owned(), "cars-b".to_owned()])]);
    let page = Page {
        command: "this".into(),
        machine: &[],
        versions: &[],
        families: &families,
        lines: &lines,
        motions: "| rows |\n",
        skipped: &["somebody: left out".to_owned()],
    };
    let page = page.to_string();
    for cell in ["+0.500, 1.00", "+250.000, 50.0", "FALSE, 1.00", "MISSED, 3.00", "not run"] {
        assert!(page.contains(cell), "\"{cell}\" is not in: {page}");
    }
    assert!(page.contains("- somebody: left out"), "{page}");
    assert!(page.ends_with("\n\n| rows |\n"), "{page}");
}

#[test]
fn a_failed_check_of_ours_is_wrong() {
    let right = r#"{"peer":"trolley","name":"x","first_contact_m":null,"query_ms":1,"touching":0,
        "brute_force":true}"#;
    let is_wrong = |text: &str| serde_json::from_str::<Line>(text).map(|line| line.is_wrong());
    assert!(matches!(is_wrong(right), Ok(false)));
    assert!(matches!(is_wrong(&right.replace("true", "false")), Ok(true)));
    assert!(matches!(is_wrong(&right.replace("\"touching\":0", "\"touching\":1")), Ok(true)));
}
