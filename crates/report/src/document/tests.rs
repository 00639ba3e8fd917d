//! What is written is what the schema describes, by a validator that is not ours; and the schema
//! describes nothing else.

use super::*;
use serde_json::Value;
use trolley::{AnswerState, Engine, Limits, Scenario};

const SCENE: &str = r#"
schema = "trolley.scenario/2"
name = "Document"
horizon_s = 3
[parties]
ego = { generate = { shape = "sedan", triangles = 900 } }
[parties.suv]
generate = { shape = "suv", triangles = 900 }
place = { position_m = [30, 0, 0] }
[parties.walker]
generate = { shape = "pedestrian", triangles = 900 }
place = { position_m = [20, 9, 0], yaw_deg = 90 }
[[candidates]]
name = "go on"
state = { position_m = [0, 0, 0], speed_m_s = 14 }
[[candidates]]
name = "creep"
state = { position_m = [0, 0, 0], speed_m_s = 3 }
[candidates.reactions.walker]
state = { position_m = [20, 9, 0], yaw_deg = 90, speed_m_s = 1 }
"#;

/// What is done to a document.
type ChangeOfJson = fn(&mut Value);

/// The document of the scene, with so many members.
fn made(members: u32, change: impl Fn(&mut Answer)) -> Value {
    let text = SCENE.replace(
        "horizon_s = 3",
        &format!("horizon_s = 3\nmembers = {members}\nmembers_max = {members}"),
    );
    let scenario = Scenario::parse("test.toml", &text).expect("sound");
    let mut engine = Engine::builder().in_process().build().expect("an engine");
    let mut scene = PlanScene::default();
    let limits = Limits::default();
    let ranking = engine.rank_drawn(&scenario, &limits, &|_, _| {}, Some(&mut scene));
    let mut ranking = ranking.expect("it can be ranked");
    change(&mut ranking.answer);
    let page = PlanPage {
        scenario: "Document",
        answer: &ranking.answer,
        work: &WorkDone::of_run(&ranking.run),
        scene: &scene,
        bodies: &[],
        shots: &[],
        explanation: None,
    };
    serde_json::from_str(&document(&page).expect("encoded")).expect("JSON")
}

fn validator() -> jsonschema::Validator {
    let schema: Value = serde_json::from_str(&schema()).expect("JSON");
    assert!(jsonschema::meta::is_valid(&schema), "the schema is one");
    jsonschema::validator_for(&schema).expect("a schema")
}

#[test]
fn a_document_is_as_its_schema_says() {
    let validator = validator();
    for (members, state) in
        [(1, AnswerState::Complete), (4, AnswerState::Complete), (1, AnswerState::Degraded)]
    {
        let document = made(members, |answer| answer.state = state);
        let faults: Vec<String> =
            validator.iter_errors(&document).map(|fault| fault.to_string()).collect();
        assert!(faults.is_empty(), "{members} {state:?}: {faults:#?}");
        assert_eq!(document["schema"], SCHEMA);
        let drawn = document["scene"]["members"].as_array().expect("a list").len();
        assert_eq!(drawn, if members == 1 { 0 } else { members as usize });
        assert!(document["scene"]["courses"][0]["contacts"].is_array());
    }
}

#[test]
fn what_is_not_a_document_is_refused() {
    let validator = validator();
    let sound = made(4, |_| {});
    let changes: [(&str, ChangeOfJson); 5] = [
        ("another form", |it| it["schema"] = "trolley.page/2".into()),
        ("no answer", |it| {
            it.as_object_mut().expect("an object").remove("answer");
        }),
        ("no such state", |it| it["answer"]["state"] = "done".into()),
        ("a harm without ends", |it| it["answer"]["ranking"][0]["work"] = 0.5.into()),
        ("a sample too short", |it| {
            it["scene"]["courses"][0]["ego"][0] = serde_json::json!([0.0, 1.0]);
        }),
    ];
    for (what, change) in changes {
        let mut changed = sound.clone();
        change(&mut changed);
        assert!(!validator.is_valid(&changed), "{what}");
    }
}

#[test]
fn every_key_is_described() {
    let schema: Value = serde_json::from_str(&schema()).expect("JSON");
    let mut open = vec![&schema];
    let mut keys = 0;
    while let Some(value) = open.pop() {
        if let Some(properties) = value.get("properties").and_then(Value::as_object) {
            for (key, of) in properties {
                keys += 1;
                // That of an enum's variant stands around it.
                let is_described = [of, value].iter().any(|one| one.get("description").is_some());
                assert!(is_described, "{key} has no description: {of}");
            }
        }
        open.extend(value.as_object().into_iter().flat_map(|map| map.values()));
        open.extend(value.as_array().into_iter().flatten());
    }
    assert!(keys > 100, "{keys} keys");
}
