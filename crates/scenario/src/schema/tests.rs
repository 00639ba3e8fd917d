//! The schema describes what the parser reads: tools for the tests of the form, and its defaults.

use crate::engine::EngineSettings;
use crate::names::Named;
use proptest::prelude::*;
use serde_json::Value;

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

/// Every object of the schema with its name: the root and the definitions.
pub(crate) fn objects(schema: &Value) -> Vec<(&str, &Value)> {
    let defined = schema["$defs"].as_object().unwrap().iter();
    [("Scenario", schema)]
        .into_iter()
        .chain(defined.map(|(name, def)| (name.as_str(), def)))
        .collect()
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
    let schema: Value = serde_json::from_str(&crate::schema()).unwrap();
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
