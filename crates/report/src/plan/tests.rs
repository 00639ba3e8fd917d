//! A page fetches nothing, escapes foreign markup, opens on the first candidate, says "least harm"
//! only where that is so, draws what was followed, and folds what there is nothing to tell of.

use super::drawing::{PlanWindow, pose_at};
use super::*;
use crate::pictures;
use geometry::rng::Rng;
use std::path::Path;
use trolley::plan::PlanSample;
use trolley::{AnswerState, Engine, Limits, Run, Scenario};

mod drawings;
mod labels;

const SCENE: &str = r#"
schema = "trolley.scenario/2"
name = "A \"test\" <script>alert(1)</script>"
members = 1
horizon_s = 3
[parties]
ego = { generate = { shape = "sedan", triangles = 900 } }
[parties.suv]
generate = { shape = "suv", triangles = 900 }
place = { position_m = [30, 0, 0] }
[parties.walker]
generate = { shape = "pedestrian", triangles = 900 }
place = { position_m = [20, 0, 0], yaw_deg = 90 }
[[candidates]]
name = "go on"
state = { position_m = [0, 0, 0], speed_m_s = 14 }
[[candidates]]
name = "creep"
state = { position_m = [0, 0, 0], speed_m_s = 3 }
"#;

fn ranked() -> (Answer, Run, PlanScene) {
    ranked_of(&Scenario::parse("test.toml", SCENE).expect("sound"))
}

/// The same scene in members.
fn ranked_in_members() -> (Answer, Run, PlanScene) {
    let text = SCENE.replace("members = 1", "members = 4\nmembers_max = 4");
    ranked_of(&Scenario::parse("test.toml", &text).expect("sound"))
}

fn ranked_of(scenario: &Scenario) -> (Answer, Run, PlanScene) {
    let mut engine = Engine::builder().in_process().build().expect("an engine");
    let mut scene = PlanScene::default();
    let limits = Limits::default();
    let ranking = engine.rank_drawn(scenario, &limits, &|_, _| {}, Some(&mut scene));
    let ranking = ranking.expect("it can be ranked");
    (ranking.answer, ranking.run, scene)
}

/// The page, in which a number may be parted from its unit.
fn made(answer: &Answer, run: &Run, scene: &PlanScene) -> String {
    let page = page(&PlanPage {
        scenario: "A \"test\" <script>alert(1)</script>",
        answer,
        work: &WorkDone::of_run(run),
        scene,
        bodies: &[],
        shots: &[],
        explanation: Some("1 < 2 & so on"),
    });
    page.replace('\u{a0}', " ")
}

/// A body of as many triangles as those of the scene, each a metre wide.
fn body(name: &str) -> ShotBody {
    let corners = vec![[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 1.0]]; 900];
    ShotBody { name: name.to_owned(), corners }
}

#[test]
fn every_contact_has_a_picture() {
    let (answer, run, scene) = ranked();
    let shots = pictures::shots(&scene, &answer);
    assert_eq!(shots.len(), 2, "the walker, and then the suv");
    assert!(shots.iter().all(|shot| shot.candidate == "go on" && shot.patch.is_some()));
    assert!(shots.iter().all(|shot| shot.hits.iter().all(|hits| !hits.is_empty())));
    let bodies = ["sedan", "suv", "pedestrian"].map(body);
    let text = page(&PlanPage {
        scenario: "pictures",
        answer: &answer,
        work: &WorkDone::of_run(&run),
        scene: &scene,
        bodies: &bodies,
        shots: &shots,
        explanation: None,
    });
    let place_of = |text_: &str| text.find(text_).unwrap_or_else(|| panic!("{text_} is missing"));
    assert!(place_of("id=\"plan\"") < place_of("id=\"view\""));
    assert!(place_of("id=\"view\"") < place_of("For engineers"));
    // Opened and closed: data, plan, library, view.
    assert_eq!((text.matches("<script").count(), text.matches("</script>").count()), (4, 4));
    assert!(text.contains("default-src 'none'"));
}

#[test]
fn the_answer_stands_first_and_who_touches_nobody_before_all_others() {
    let (mut answer, run, scene) = ranked();
    for _ in 0..2 {
        let page = made(&answer, &run, &scene);
        let place_of = |text: &str| page.find(text).unwrap_or_else(|| panic!("{text} is missing"));
        assert!(page.contains("<title>Touches nobody: creep</title>"));
        assert!(!page.contains("Least harm"), "one way hits nobody");
        let order = ["<h1>", "How sure", "id=\"plan\"", "The ranking", "For engineers"];
        assert!(order.windows(2).all(|pair| place_of(pair[0]) < place_of(pair[1])));
        assert!(place_of("<td><bdi>creep</bdi>") < place_of("<td><bdi>go on</bdi>"));
        // The plan opens on it: it is the second of the scenario.
        assert!(page.contains("<option value=\"1\" selected>creep</option>"));
        assert!(
            page.contains("<g data-course=\"1\"><") && page.contains("<g data-course=\"0\" st")
        );
        // A policy that puts it last changes nothing of that.
        answer.ranking.reverse();
    }
    answer.ranking.retain(|row| !row.touches_nobody());
    answer.tie_class = vec!["go on".to_owned()];
    let page = made(&answer, &run, &scene);
    assert!(page.contains("<title>The only way: go on</title>") && !page.contains("It wins in"));
    assert!(page.contains("1 way is left; it hits somebody, as far as is known."));
    answer.ranking.push(CourseRow { name: "faster".to_owned(), ..answer.ranking[0].clone() });
    assert!(made(&answer, &run, &scene).contains("<title>Least harm: go on</title>"));
    answer.tie_class.push("faster".to_owned());
    let page = made(&answer, &run, &scene);
    assert!(page.contains("<title>First of 2 that do the same harm: go on</title>"));
    assert!(page.contains("As far as is known these are the same: <bdi>faster</bdi>."));
    answer.ranking.clear();
    assert!(made(&answer, &run, &scene).contains("<title>Nothing to rank</title>"));
}

#[test]
fn long_lists_of_what_is_assumed_are_folded_under_how_they_begin() {
    let (mut answer, run, scene) = ranked();
    answer.assumptions = vec!["the ego is empty".to_owned()];
    let page = made(&answer, &run, &scene);
    assert!(page.contains("Assumed: the ego is empty.") && !page.contains("class=\"assumed\""));
    let cars: Vec<String> = (0..40).map(|number| format!("car {number} 1 of 5")).collect();
    answer.assumptions.push(format!("the usual number is in these: {}", cars.join(", ")));
    let page = made(&answer, &run, &scene);
    let folded = page.split("class=\"assumed\">").nth(1).expect("folded");
    let (summary, all) = folded.split_once("</summary>").expect("a summary");
    assert!(
        summary.contains("the ego is empty") && summary.contains("the usual number is in these")
    );
    assert!(!summary.contains("car 39") && all.contains("car 39"), "{summary}");
}

#[test]
fn every_contact_is_said_with_its_figures_and_drawn() {
    let (answer, run, scene) = ranked();
    let page = made(&answer, &run, &scene);
    let row = answer.ranking.iter().find(|row| row.name == "go on").expect("it is ranked");
    assert_eq!(row.contacts.len(), 2, "the walker, and then the suv");
    for contact in &row.contacts {
        let ego = contact.delta_v_m_s[0].work.hi();
        for said in [
            format!("<b>{:.2} s: <bdi>{}</bdi></b>", contact.time_s, contact.party),
            format!("Closing {:.1} m/s; ΔV ego {ego:.1} m/s", contact.closing_m_s),
            format!("{:.2} s <tspan>{}</tspan>", contact.time_s, contact.party),
            contact.hashes[1].clone(),
        ] {
            assert!(page.contains(&said), "{said}");
        }
    }
    // Once for the screen, and once for paper, where the candidate has a drawing of its own.
    let (screen, paper) = page.split_once("The ranking").expect("the drawing stands before");
    for drawing in [screen, paper] {
        assert_eq!(drawing.matches("class=\"hit\"").count(), 2);
        assert_eq!(drawing.matches("class=\"way out\"").count(), 1, "after the suv");
    }
}

#[test]
fn the_script_gets_the_scene_as_it_is() {
    let (answer, run, scene) = ranked();
    let page = made(&answer, &run, &scene);
    let begin = page.find("id=\"data\">").expect("data") + "id=\"data\">".len();
    let end = begin + page[begin..].find("</script>").expect("its end");
    let data: serde_json::Value = serde_json::from_str(&page[begin..end]).expect("JSON");
    assert_eq!(data["scene"], serde_json::to_value(&scene).expect("plain values"));
    assert_eq!(data["scene"]["courses"][0]["contacts"][0]["party"], 2);
}

#[test]
fn no_text_of_a_strangers_becomes_markup_or_turns_what_follows() {
    let (mut answer, run, mut scene) = ranked_in_members();
    let long = "long ".repeat(300);
    let hostile = ["</script><b>hit", "\"'><i>\n", "\u{202e}\u{2066}<u>", &long];
    for (k, bad) in hostile.iter().enumerate() {
        let at = k % 2;
        let old = std::mem::replace(&mut scene.courses[at].name, (*bad).to_owned());
        for row in answer.ranking.iter_mut().filter(|row| row.name == old) {
            row.name = (*bad).to_owned();
            row.why = Some(format!("{bad} before"));
            row.remarks.push((*bad).to_owned());
            for contact in &mut row.contacts {
                contact.party = (*bad).to_owned();
                contact.parts[0].push((*bad).to_owned());
            }
            for met in row.expected.iter_mut().flat_map(|of| &mut of.meets) {
                met.party = (*bad).to_owned();
            }
        }
        answer.tie_class = vec![(*bad).to_owned(); 9];
        scene.parties.iter_mut().for_each(|party| party.name = (*bad).to_owned());
        let page = page(&PlanPage {
            scenario: bad,
            answer: &answer,
            work: &WorkDone::of_run(&run),
            scene: &scene,
            bodies: &["sedan", "suv", "pedestrian"].map(body),
            shots: &pictures::all_shots(&scene, &answer),
            explanation: Some(bad),
        });
        let (markup, rest) = page.split_once("<script type").expect("data follows");
        let (rest, _) = rest.split_once("</script>").expect("its end");
        for wrong in ["<script>alert", "<b>hit", "<i>", "<u>", "</script>\""] {
            assert!(!markup.contains(wrong) && !rest.contains(wrong), "{wrong}");
        }
        assert!(!markup.contains(['\u{202e}', '\u{2066}']));
        // Opened and closed: data, plan, library, view.
        assert_eq!((page.matches("<script").count(), page.matches("</script>").count()), (4, 4));
        let drawing = &markup[markup.find("<svg").expect("a drawing")..];
        let texts = drawing.split("<tspan>").skip(1);
        assert!(texts.clone().count() > 0);
        for text in texts {
            let text = text.split("</tspan>").next().unwrap_or_default();
            assert!(text.chars().count() < 120, "{text}");
        }
    }
}

#[test]
fn nothing_is_fetched_from_anywhere() {
    let (answer, run, scene) = ranked();
    let page = made(&answer, &run, &scene);
    assert!(page.contains("default-src 'none'"));
    for word in ["src=\"", "href=\"", "url(", "@import", "fetch(", "<link"] {
        assert!(!page.replace("-src", "").contains(word), "{word}");
    }
}

/// What is done to an answer.
type ChangeOfAnswer = fn(&mut Answer);

/// The words as a reader sees them, wherever they stand.
fn says_least_harm(page: &str) -> bool {
    page.to_lowercase().contains("least harm")
}

#[test]
fn least_harm_is_said_only_where_that_is_so() {
    let (mut answer, run, scene) = ranked_in_members();
    answer.ranking.retain(|row| !row.touches_nobody());
    answer.ranking.push(CourseRow { name: "faster".to_owned(), ..answer.ranking[0].clone() });
    answer.tie_class = vec!["go on".to_owned()];
    answer.state = AnswerState::Complete;
    let mut lead = answer.members.expect("members").lead.unwrap_or_default();
    (lead.mean, lead.error) = (0.1, 0.001);
    answer.members.as_mut().expect("members").lead = Some(lead);
    answer.ranking[0].expected.as_mut().expect("of members").worlds = Some(1.0);
    assert!(says_least_harm(&made(&answer, &run, &scene)));
    assert!(verdict(&answer).1);
    // Each of these alone takes the words away.
    let changes: [(&str, ChangeOfAnswer); 7] = [
        ("alone", |answer| answer.ranking.truncate(1)),
        ("tied", |answer| answer.tie_class.push("another".to_owned())),
        ("degraded", |answer| answer.state = AnswerState::Degraded),
        ("refused", |answer| answer.state = AnswerState::Refused),
        ("too close", |answer| {
            let lead = answer.members.as_mut().and_then(|members| members.lead.as_mut());
            lead.expect("a lead").error = 9.0;
        }),
        ("worlds", |answer| {
            answer.ranking[0].expected.as_mut().expect("of members").worlds = Some(0.6);
        }),
        ("nothing", |answer| answer.ranking.clear()),
    ];
    for (what, change) in changes {
        let mut changed = answer.clone();
        change(&mut changed);
        let page = made(&changed, &run, &scene);
        assert!(!says_least_harm(&page), "{what}: {}", head::title(&rows(&changed), &changed));
        assert!(!verdict(&changed).1, "{what}");
    }
}

#[test]
fn where_nothing_is_known_that_is_said_once_and_everybody_is_drawn() {
    let (mut answer, run, mut scene) = ranked();
    answer.state = AnswerState::Degraded;
    answer.missing.clear();
    for row in &mut answer.ranking {
        row.contacts.clear();
        row.open_from_s = Some(0.0);
        answer.missing.push(format!("{}: whom it meets after 0.000 s", row.name));
    }
    for course in &mut scene.courses {
        course.ego.truncate(1);
        course.contacts.clear();
        course.nearest = None;
        course.open_from_s = Some(0.0);
    }
    let page = made(&answer, &run, &scene);
    assert!(page.contains("<h1><bdi>Nothing is known in time; first as asked: "));
    assert!(page.contains("2 ways are left; of none it is known what happens."));
    assert_eq!(page.matches("Not fully known").count(), 1);
    assert!(page.contains("Not fully known of any way: whom it meets after 0.000 s."));
    let window = PlanWindow::of(&scene);
    for (name, x) in [("walker", 20.0), ("suv", 32.0)] {
        assert!(window.shows([x, 0.0]), "{name}: {window:?}");
    }
}

#[test]
fn where_nobody_is_touched_nothing_else_is_said() {
    let (mut answer, run, scene) = ranked_in_members();
    answer.ranking.retain(CourseRow::touches_nobody);
    answer.ranking.push(CourseRow { name: "stay".to_owned(), ..answer.ranking[0].clone() });
    answer.tie_class = vec!["creep".to_owned(), "stay".to_owned()];
    let page = made(&answer, &run, &scene);
    assert!(page.contains("2 ways are left; none touches anybody."));
    assert!(page.contains("These do no harm either: <bdi>stay</bdi>."));
    assert!(page.contains("Where the road ends is not known"));
    assert!(page.contains("1 more touches nobody, and harms nobody within the range"));
    let (_, members) = page.split_once("<h2>Member by member</h2>").expect("members");
    assert!(members.starts_with("<p>No harm in any member: "), "{}", &members[..200]);
    assert!(!page.contains("0–0"));
}

#[test]
fn who_is_touched_in_some_member_alone_is_named() {
    let (mut answer, run, scene) = ranked_in_members();
    let row = answer.ranking.iter_mut().find(|row| !row.touches_nobody()).expect("go on");
    row.contacts.clear();
    let page = made(&answer, &run, &scene);
    let said = "In the scene as stated it touches nobody. Over the members it meets ";
    assert!(page.contains(said) && page.contains("<bdi>walker</bdi> in "));
}

#[test]
fn how_far_the_first_is_ahead_is_said_beside_its_error() {
    let cases = [
        (0.0, 0.0, "The second is as good in every member."),
        (0.0076, 0.0048, "has 0.76 ± 0.48 percentage points more harm: 1.6 times its sampling"),
        (0.003, 0.0041, "has 0.30 ± 0.41 percentage points more harm: less than its sampling"),
        (0.000_04, 0.000_02, "has 0.0040 ± 0.0020 percentage points more harm: 2.0 times"),
        // A policy's first rule may rank above its leading measure.
        (-0.02, 0.001, "has 2.00 ± 0.10 percentage points less harm: 20.0 times"),
        (0.01, 0.0, "has 1.00 ± 0.00 percentage points more harm: the same in every member."),
    ];
    for (mean, error, expected) in cases {
        let said = head::ahead(mean, error, f64::abs(mean) < error);
        assert!(said.contains(expected), "{said}");
    }
}

#[test]
fn who_does_not_touch_is_not_said_to_be_0_apart() {
    for (gap_m, expected) in [(0.0, "under 0.01 m"), (0.0051, "0.01 m"), (3.2149, "3.21 m")] {
        assert_eq!(apart(gap_m), expected);
    }
}

#[test]
fn neither_none_nor_all_is_said_where_it_is_not_so() {
    let cases =
        [(0.0, "0 %"), (0.001, "&lt; 1 %"), (0.5, "50 %"), (0.999, "&gt; 99 %"), (1.0, "100 %")];
    for (share, expected) in cases {
        assert_eq!(members::of_all(share), expected);
    }
}

#[test]
fn risks_over_all_contacts_say_that_they_are_means() {
    for (is_mean, (mut answer, run, scene)) in [(false, ranked()), (true, ranked_in_members())] {
        let hits = |row: &&mut CourseRow| !row.contacts.is_empty();
        let row = answer.ranking.iter_mut().find(hits).expect("go on");
        row.contacts.truncate(1);
        row.contacts.push(row.contacts[0].clone());
        row.remarks = vec!["a weak part".to_owned(), "a weak part".to_owned()];
        let (party, time_s) = (row.contacts[0].party.clone(), row.contacts[0].time_s);
        let page = made(&answer, &run, &scene);
        let (_, said) = page.split_once("<b>All contacts together").expect("two of them");
        assert_eq!(said.starts_with(", in the mean over members</b>"), is_mean);
        let met = format!("It meets <bdi>{party}</bdi> after {time_s:.2} s, then again after");
        assert!(page.contains(&met), "{met}");
        assert_eq!(page.matches("Note: a weak part.").count(), 1);
    }
}

#[test]
fn the_page_opens_on_the_first_candidate_in_3d_too() {
    let (answer, run, scene) = ranked();
    let shots = pictures::all_shots(&scene, &answer);
    assert!(!shots[0].is_contact(), "who touches nobody is shown where it is nearest");
    let page = page(&PlanPage {
        scenario: "pictures",
        answer: &answer,
        work: &WorkDone::of_run(&run),
        scene: &scene,
        bodies: &["sedan", "suv", "pedestrian"].map(body),
        // The order of shots is not that of the page.
        shots: &shots.iter().rev().cloned().collect::<Vec<_>>(),
        explanation: None,
    });
    let begin = page.find("id=\"data\">").expect("data") + "id=\"data\">".len();
    let end = begin + page[begin..].find("</script>").expect("its end");
    let data: serde_json::Value = serde_json::from_str(&page[begin..end]).expect("JSON");
    let courses: Vec<_> = data["shots"].as_array().expect("a list").iter().collect();
    assert_eq!(courses.len(), 3);
    // "creep" is the second of the scenario.
    assert_eq!(courses[0]["course"], 1);
    assert_eq!(courses[0]["is_nearest"], true);
    assert!(courses[1..].iter().all(|shot| shot["course"] == 0));
    assert!(page.contains("<option value=\"1\" selected>creep</option>"));
    // A still of each: of the contacts, and of the nearest.
    assert_eq!(page.matches("<img class=\"still\"").count(), 3);
}

#[test]
fn what_there_is_nothing_to_tell_of_is_one_line() {
    let (mut answer, run, scene) = ranked();
    let creep = answer.ranking[0].clone();
    assert!(creep.touches_nobody());
    for k in 0..5 {
        let name = format!("creep on {k}");
        answer.ranking.insert(1, CourseRow { name, ..creep.clone() });
    }
    let contact = &mut answer.ranking.last_mut().expect("go on").contacts[0];
    let mut nobody = contact.persons[0].clone();
    nobody.work = creep.work;
    nobody.range = creep.range;
    contact.persons.extend([nobody.clone(), nobody.clone(), nobody]);
    let page = made(&answer, &run, &scene);
    assert_eq!(page.matches("class=\"fold\"").count(), 1);
    assert!(page.contains("<td>2–6</td><td colspan=\"5\">5 more touch nobody"));
    assert!(page.contains("<h2>5 more touch nobody</h2>"));
    assert_eq!(page.matches("<section class=\"course\">").count(), 3, "the first, these, go on");
    assert!(page.contains("3 more persons are at no risk.</p>"));
    assert!(!page.contains(": 0 % risk"));
    for k in 0..5 {
        assert!(page.contains(&format!("<b><bdi>creep on {k}</bdi>.</b>")), "it opens");
    }
}

#[test]
fn a_page_is_made_for_paper() {
    let (answer, run, scene) = ranked();
    let page = made(&answer, &run, &scene);
    let (_, print) = page.split_once("@media print {").expect("rules for paper");
    for rule in [".course { break-before: page; }", "break-inside: avoid", "background: #fff"] {
        assert!(print.contains(rule), "{rule}");
    }
    // Every candidate but the first has its drawing on paper.
    assert_eq!(page.matches("<div class=\"paper\"><svg class=\"plan\"").count(), 1);
}
