//! A page fetches nothing, escapes foreign markup, says first what follows, and draws what was
//! followed; labels do not cover each other.

use super::drawing::{PlanWindow, TakenRoom, overlap, pose_at};
use super::*;
use crate::pictures;
use geometry::rng::Rng;
use trolley::{Engine, Limits, PlanSample, Run, Scenario};

const SCENE: &str = r#"
schema = "trolley.scenario/2"
name = "A \"test\" <script>alert(1)</script>"
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
    let scenario = Scenario::parse("test.toml", SCENE).expect("sound");
    let mut engine = Engine::builder().in_process().build().expect("an engine");
    let mut scene = PlanScene::default();
    let limits = Limits::default();
    let ranking = engine.rank_drawn(&scenario, &limits, &|_, _| {}, Some(&mut scene));
    let ranking = ranking.expect("it can be ranked");
    (ranking.answer, ranking.run, scene)
}

fn made(answer: &Answer, run: &Run, scene: &PlanScene) -> String {
    page(&PlanPage {
        scenario: "A \"test\" <script>alert(1)</script>",
        answer,
        work: &WorkDone::of_run(run),
        scene,
        bodies: &[],
        shots: &[],
        explanation: Some("1 < 2 & so on"),
    })
}

#[test]
fn every_contact_has_a_picture() {
    let (answer, run, scene) = ranked();
    let shots = pictures::shots(&scene, &answer);
    assert_eq!(shots.len(), 2, "the walker, and then the suv");
    assert!(shots.iter().all(|shot| shot.candidate == "go on" && shot.patch.is_some()));
    assert!(shots.iter().all(|shot| shot.hits.iter().all(|hits| !hits.is_empty())));
    let body = |name: &str| ShotBody { name: name.to_owned(), corners: vec![[[0.0; 3]; 3]; 900] };
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
        let order = ["<h1>", "How sure", "The ranking", "id=\"plan\"", "For engineers"];
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
    assert!(made(&answer, &run, &scene).contains("<title>Least harm: go on</title>"));
    answer.ranking.clear();
    assert!(made(&answer, &run, &scene).contains("<title>Nothing to rank</title>"));
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
    assert_eq!(page.matches("class=\"hit\"").count(), 2);
    assert_eq!(page.matches("class=\"way out\"").count(), 1, "one run-out, after the suv");
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
    let (mut answer, run, mut scene) = ranked();
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
        }
        scene.parties.iter_mut().for_each(|party| party.name = (*bad).to_owned());
        let page = made(&answer, &run, &scene);
        let (markup, rest) = page.split_once("<script type").expect("data follows");
        for wrong in ["<script>alert", "<b>hit", "<i>", "<u>", "</script>\""] {
            assert!(!markup.contains(wrong) && !rest.contains(wrong), "{wrong}");
        }
        assert!(!markup.contains(['\u{202e}', '\u{2066}']));
        // Opened and closed: data, script.
        assert_eq!((page.matches("<script").count(), page.matches("</script>").count()), (2, 2));
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

#[test]
fn labels_lie_inside_and_cover_neither_each_other_nor_what_is_marked() {
    let (_, _, scene) = ranked();
    let window = PlanWindow::of(&scene);
    let mut rng = Rng::new(7);
    for _ in 0..200 {
        let mut room = TakenRoom::default();
        let mut kept: Vec<[f64; 4]> = Vec::new();
        let spread = rng.between(1.0, 40.0);
        for k in 0..12 {
            let at =
                [400.0 + spread * rng.between(-1.0, 1.0), 150.0 + spread * rng.between(-1.0, 1.0)];
            let text = "x".repeat(3 + k);
            if let Some(taken) = room.placed(&window, at, &text) {
                assert!(taken[0] >= 0.0 && taken[2] <= 1000.0 && taken[1] >= 0.0, "{taken:?}");
                assert!(kept.iter().all(|other| !overlap(other, &taken)), "{taken:?}");
                kept.push(taken);
            }
        }
        assert!(kept.len() >= 6, "there is room for half of them");
    }
}

#[test]
fn the_window_holds_every_way_and_contact_and_is_neither_flat_nor_tall() {
    let (_, _, mut scene) = ranked();
    let mut rng = Rng::new(3);
    for _ in 0..100 {
        let (x, y) = (rng.between(-200.0, 200.0), rng.between(-200.0, 200.0));
        let samples = [[0.0, 0.0, 0.0, 1.0, 0.0], [3.0, x, y, 1.0, 0.0]];
        scene.courses[0].ego = samples.map(PlanSample).to_vec();
        scene.courses[0].contacts[0].at_m = [y, x];
        let window = PlanWindow::of(&scene);
        for at in [[0.0, 0.0], [x, y], [y, x]] {
            assert!(window.shows(at), "{at:?} in {window:?}");
        }
        let share = window.share();
        assert!((0.299..=0.751).contains(&share), "{share}");
    }
}

#[test]
fn a_track_is_linear_between_samples_and_still_after_the_last() {
    let track = [[0.0, 0.0, 2.0, 1.0, 0.0], [2.0, 4.0, 2.0, 1.0, 0.0]].map(PlanSample);
    for (time_s, x) in [(-1.0, 0.0), (0.0, 0.0), (0.5, 1.0), (2.0, 4.0), (9.0, 4.0)] {
        assert_eq!(pose_at(&track, time_s)[1..3], [x, 2.0], "after {time_s} s");
    }
}
