//! A page fetches nothing, shows no stranger's markup, and says first what was decided.

use super::*;
use crate::glb::tests::shot;

fn made() -> String {
    let (shot, bodies) = shot();
    let one = |name: &str, touches: bool, work: f64| CandidateRow {
        name: name.into(),
        other: "wall".into(),
        contact: "front ↔ wall".into(),
        touches,
        work: [work, work],
        range: [0.5 * work, 2.0 * work],
        why: Some("because <i>".into()),
        persons: vec![("driver <u>".into(), [work, work], [work, work])],
        ..CandidateRow::default()
    };
    let about = DecisionPage {
        scenario: "A \"test\" <script>alert(1)</script>".into(),
        state: "complete".into(),
        candidates: vec![one("pass & go", false, 0.0), one("</script><b>hit", true, 0.25)],
        ties: vec!["pass & go".into()],
        policy: "default".into(),
        moments: [0, 5]
            .map(|jobs| TimelineMoment { at_ms: 1.0, jobs, work: vec![[0.0, 1.0], [0.1, 0.5]] })
            .to_vec(),
        names: vec!["a".into(), "b".into()],
        workers: vec![Worker {
            name: "worker 0".into(),
            spans: vec![TimelineSpan { from_ms: 0.0, to_ms: 1.0 }],
        }],
        ..DecisionPage::default()
    };
    decision(&about, &bodies, &[shot])
}

#[test]
fn the_first_thing_said_is_which_is_least_harmful_how_sure_and_why() {
    let page = made();
    let at = |text: &str| page.find(text).unwrap_or_else(|| panic!("{text} is missing"));
    assert!(page.contains("<title>Least harm: pass &amp; go</title>"));
    assert!(at("<h1>Least harm: pass &amp; go</h1>") < at("How sure"));
    assert!(at("How sure") < at("<dt>Why</dt>") && at("<dt>Why</dt>") < at("The ranking"));
    assert!(at("<b>Complete.</b>") < at("The ranking") && at("The ranking") < at("id=\"view\""));
    assert!(at("id=\"view\"") < at("The record"));
}

#[test]
fn no_text_of_a_strangers_becomes_markup() {
    let page = made();
    for bad in ["<script>alert", "<i>", "<u>", "</script><b>hit", "</script>\""] {
        assert!(!page.contains(bad), "{bad}");
    }
    // Opened and closed: data, library, view.
    assert_eq!(page.matches("<script").count(), page.matches("</script>").count());
}

#[test]
fn nothing_is_fetched_from_anywhere() {
    let page = made();
    assert!(page.contains("default-src 'none'"));
    for word in ["src=\"http", "href=\"http", "url(http", "@import", "fetch(", "<link"] {
        let library = THREE.matches(word).count();
        assert_eq!(page.matches(word).count(), library, "{word}");
    }
}
