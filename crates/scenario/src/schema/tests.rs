//! The schema describes what the parser reads: never stricter, nothing missing, no stale default.

use crate::engine::EngineSettings;
use crate::names::Named;
use crate::testing::{FULL, parse, settings, with_line};
use proptest::prelude::*;
use serde_json::Value;

fn the_schema() -> Value {
    serde_json::from_str(&crate::schema()).unwrap()
}

/// A validator for the words that this schema uses; another word is a failure of the test itself.
pub(crate) fn violations(schema: &Value, root: &Value, value: &Value) -> Vec<String> {
    let Some(rules) = schema.as_object() else { panic!("a schema is an object: {schema}") };
    let mut found = Vec::new();
    let number = |limit: &Value| limit.as_f64().unwrap();
    for (rule, limit) in rules {
        let holds = match rule.as_str() {
            "$schema" | "$defs" | "title" | "description" | "format" | "properties" => true,
            "$ref" => {
                let target = limit.as_str().unwrap().trim_start_matches('#');
                found.extend(violations(root.pointer(target).unwrap(), root, value));
                true
            }
            "type" => match limit.as_str().unwrap() {
                "object" => value.is_object(),
                "array" => value.is_array(),
                "string" => value.is_string(),
                "number" => value.is_number(),
                "boolean" => value.is_boolean(),
                "integer" => value.is_i64() || value.is_u64(),
                other => panic!("type {other}"),
            },
            "const" => value == limit,
            "enum" => limit.as_array().unwrap().contains(value),
            "minimum" => value.as_f64().is_none_or(|x| x >= number(limit)),
            "maximum" => value.as_f64().is_none_or(|x| x <= number(limit)),
            "minLength" | "maxLength" | "minItems" | "maxItems" | "minProperties"
            | "maxProperties" => {
                let size = match rule.as_str() {
                    "minLength" | "maxLength" => value.as_str().map(|s| s.chars().count()),
                    "minItems" | "maxItems" => value.as_array().map(Vec::len),
                    _ => value.as_object().map(serde_json::Map::len),
                };
                let limit = usize::try_from(limit.as_u64().unwrap()).unwrap();
                size.is_none_or(|n| if rule.starts_with("min") { n >= limit } else { n <= limit })
            }
            "required" => limit.as_array().unwrap().iter().all(|key| {
                value.as_object().is_none_or(|table| table.contains_key(key.as_str().unwrap()))
            }),
            "oneOf" => {
                let fits = |choice: &&Value| violations(choice, root, value).is_empty();
                limit.as_array().unwrap().iter().filter(fits).count() == 1
            }
            "allOf" => {
                for choice in limit.as_array().unwrap() {
                    found.extend(violations(choice, root, value));
                }
                true
            }
            "not" => !violations(limit, root, value).is_empty(),
            "items" => {
                for item in value.as_array().into_iter().flatten() {
                    found.extend(violations(limit, root, item));
                }
                true
            }
            "additionalProperties" => {
                for (key, item) in value.as_object().into_iter().flatten() {
                    let known = rules.get("properties").and_then(|known| known.get(key));
                    match known.or(limit.is_object().then_some(limit)) {
                        Some(schema) => found.extend(violations(schema, root, item)),
                        None => found.push(format!("unknown key {key}")),
                    }
                }
                true
            }
            other => panic!("the schema uses {other}, which this validator does not know"),
        };
        if !holds {
            found.push(format!("{rule} {limit}: {value}"));
        }
    }
    found
}

fn violated(text: &str) -> Vec<String> {
    let value: toml::Value = toml::from_str(text).unwrap();
    let schema = the_schema();
    violations(&schema, &schema, &serde_json::to_value(value).unwrap())
}

#[test]
fn the_shipped_examples_are_valid() {
    for (name, text) in [
        ("minimal.toml", include_str!("../../config/scenarios/minimal.toml")),
        ("demo.toml", include_str!("../../config/scenarios/demo.toml")),
        ("full", FULL),
    ] {
        crate::Scenario::parse(name, text).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(violated(text), Vec::<String>::new(), "{name}");
    }
}

/// Every object of the schema with its name: the root and the definitions.
pub(crate) fn objects(schema: &Value) -> Vec<(&str, &Value)> {
    let defined = schema["$defs"].as_object().unwrap().iter();
    [("Scenario", schema)]
        .into_iter()
        .chain(defined.map(|(name, def)| (name.as_str(), def)))
        .collect()
}

#[test]
fn every_key_of_the_schema_stands_in_the_full_scenario_and_is_described() {
    let schema = the_schema();
    let tables =
        ["engine", "parties", "candidates", "ego", "other", "generate", "persons", "crush"];
    let written: Vec<&str> = settings().iter().map(|(_, _, key, _)| *key).collect();
    for (name, object) in objects(&schema) {
        assert_eq!(object["additionalProperties"], Value::Bool(false), "{name}");
        assert!(object["description"].is_string(), "{name}");
        for (key, property) in object["properties"].as_object().unwrap() {
            assert!(written.contains(&key.as_str()) || tables.contains(&key.as_str()), "{key}");
            let described = property.get("description").or(property.get("$ref"));
            assert!(described.is_some_and(Value::is_string), "{name}.{key}");
        }
    }
    assert!(!crate::schema().contains("null"));
}

#[test]
fn units_stand_in_names_and_in_descriptions() {
    assert_units_are_described(&the_schema());
}

/// A key that ends in a unit has it in its description too.
pub(crate) fn assert_units_are_described(schema: &Value) {
    for (name, object) in objects(schema) {
        for (key, property) in object["properties"].as_object().unwrap() {
            let unit = match key.as_str() {
                key if key.ends_with("_n_m") => "[N/m]",
                key if key.ends_with("_n_m2") => "[N/m²]",
                key if key.ends_with("_m_s") => "[m/s]",
                key if key.ends_with("_m") => "[m]",
                key if key.ends_with("_deg") => "[degrees]",
                key if key.ends_with("_kg") => "[kg]",
                key if key.ends_with("_ms") => "[ms]",
                key if key.ends_with("_deg_s") => "[degrees/s]",
                key if key.ends_with("_s") => "[s]",
                _ => continue,
            };
            let description = property["description"].as_str().unwrap();
            assert!(description.contains(unit), "{name}.{key}: {description}");
        }
    }
}

#[test]
fn the_defaults_that_are_described_are_those_that_hold() {
    let schema = the_schema();
    let d = EngineSettings::DEFAULT;
    let expected = [
        ("workers", d.workers.to_string()),
        ("depth", d.depth.to_string()),
        ("scheme", d.scheme.word().to_owned()),
        ("alpha", d.alpha.to_string()),
        ("batch", d.batch.to_string()),
        ("queue", d.queue.to_string()),
        ("build", d.build.word().to_owned()),
        ("leaf_size", d.leaf_size.to_string()),
        ("seed", d.seed.to_string()),
    ];
    for (key, default) in &expected {
        let description = schema["$defs"]["Engine"]["properties"][*key]["description"].as_str();
        let (_, said) = description.and_then(|text| text.split_once("Default ")).unwrap();
        let said = said.trim_end_matches('.').split([':', ';']).next().unwrap();
        assert_eq!(said, default, "{key}");
    }
    for key in ["cores", "coordinator_core"] {
        let description = schema["$defs"]["Engine"]["properties"][key]["description"].as_str();
        assert!(description.unwrap().contains("Default: "), "{key}");
    }
}

#[test]
fn what_the_schema_requires_the_parser_requires() {
    let schema = the_schema();
    for (number, section, key, _) in settings() {
        let object = match section {
            "" => &schema,
            "[engine]" => &schema["$defs"]["Engine"],
            "[parties.car.generate]" | "[parties.post.generate]" => &schema["$defs"]["Generate"],
            "[[parties.car.persons]]" => &schema["$defs"]["Person"],
            "[parties.walker.crush]" => &schema["$defs"]["Crush"],
            "[[candidates]]" => &schema["$defs"]["Candidate"],
            "[candidates.ego]" => &schema["$defs"]["Ego"],
            "[candidates.other]" => &schema["$defs"]["Other"],
            _ => &schema["$defs"]["Party"],
        };
        let required = object["required"]
            .as_array()
            .is_some_and(|keys| keys.iter().any(|required| required.as_str() == Some(key)));
        let error = parse(&with_line(number, "")).err();
        let missed = error.as_ref().is_some_and(|error| {
            let quoted = format!("{key:?} is missing");
            error.what.starts_with(&quoted) || error.what == format!("{key} is missing")
        });
        assert_eq!(required, missed, "{section} {key}: {error:?}");
    }
}

pub(crate) fn values() -> impl Strategy<Value = String> {
    const WORDS: &[&str] = &[
        "auto",
        "sedan",
        "suv",
        "wall",
        "rider",
        "pillion",
        "front-left",
        "sah",
        "car",
        "post",
        "é",
        "",
    ];
    prop_oneof![
        any::<f64>().prop_map(|x| format!("{x:?}")),
        (-1e3..1e3).prop_map(|x: f64| format!("{x:?}")),
        (-3_i64..3000).prop_map(|x| x.to_string()),
        any::<i64>().prop_map(|x| x.to_string()),
        proptest::sample::select(WORDS).prop_map(|word| format!("{word:?}")),
        proptest::collection::vec(-200_i64..2000, 0..5).prop_map(|list| format!("{list:?}")),
        proptest::collection::vec(-2.0..2.0, 0..5).prop_map(|list: Vec<f64>| format!("{list:?}")),
        Just("true".to_owned()),
        Just("{}".to_owned()),
        Just("[{}]".to_owned()),
        Just("[[]]".to_owned()),
        Just("1979-05-27".to_owned()),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4000))]

    /// The parser is stricter than the schema, never laxer.
    #[test]
    fn what_the_parser_accepts_the_schema_accepts(
        line in 0..settings().len(), value in values(),
    ) {
        let (number, _, key, _) = settings()[line];
        let text = with_line(number, &format!("{key} = {value}"));
        if parse(&text).is_ok() {
            prop_assert_eq!(violated(&text), Vec::<String>::new(), "{} = {}", key, value);
        }
    }
}
