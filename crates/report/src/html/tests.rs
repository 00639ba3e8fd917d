//! A page fetches nothing, escapes foreign markup, and states the decision first.

use super::*;
use crate::glb::tests::shot;

fn made() -> String {
    let (shot, bodies) = shot();
    let candidate = |name: &str, touches: bool, work: f64| CandidateRow {
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
        candidates: vec![
            candidate("pass & go", false, 0.0),
            candidate("</script><b>hit", true, 0.25),
        ],
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
    let place_of = |text: &str| page.find(text).unwrap_or_else(|| panic!("{text} is missing"));
    assert!(page.contains("<title>Least harm: pass &amp; go</title>"));
    assert!(place_of("<h1>Least harm: pass &amp; go</h1>") < place_of("How sure"));
    assert!(
        place_of("How sure") < place_of("<dt>Why</dt>")
            && place_of("<dt>Why</dt>") < place_of("The ranking")
    );
    assert!(
        place_of("<b>Complete.</b>") < place_of("The ranking")
            && place_of("The ranking") < place_of("id=\"view\"")
    );
    assert!(place_of("id=\"view\"") < place_of("The record"));
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
