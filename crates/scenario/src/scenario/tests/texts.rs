//! No text makes the reader panic, long ones are bounded, and what is accepted fits the schema.

use super::*;

#[test]
fn a_scenario_with_every_key_of_every_state_fits_the_text() {
    let state = |i: usize| {
        format!(
            "{{ t_s = {:.6}, position_m = [{:.6}, -123456.123456, -123.123456], yaw_deg = \
             -123.123456, pitch_deg = -12.123456, roll_deg = -12.123456, velocity_m_s = \
             [-12.123456, -12.123456] }},\n",
            0.543_21 * i as f64,
            -123_456.123_456 - i as f64
        )
    };
    let states: String = (0..64).map(state).collect();
    let path = |key: &str| format!("[{key}]\nstates = [\n{states}]\n");
    let mut text = city(0, 1);
    for i in 0..32 {
        let predicted = path(&format!("[parties.b{i}.paths]"));
        let predicted = predicted.replace("states =", "probability = 0.333333333\nstates =");
        text += &format!("[parties.b{i}]\nfile = 'b'\n{}", predicted.repeat(3));
    }
    text = text.replace("[[candidates]]\nname = 'c'", "");
    text = text.replace("state = { position_m = [0, 0, 0], speed_m_s = 1 }\n", "");
    for way in 0..16 {
        text += &format!("[[candidates]]\nname = '{way}'\n{}", path("candidates.path"));
        for i in 0..12 {
            text += &path(&format!("candidates.reactions.b{i}.path"));
        }
    }
    assert!(text.len() < TEXT_BYTES_MAX, "{}", text.len());
    let read = parse(&text.replace("-12.123456, -12.123456] }", "-2.1, 1.2] }")).unwrap();
    assert_eq!((read.parties.len(), motions(&read).count()), (33, 96 + 16 * 13));

    let long = format!("{text}#{}", "x".repeat(TEXT_BYTES_MAX));
    let error = parse(&long).unwrap_err();
    assert!(error.what.contains("too many for a scenario"), "{error}");
}

#[test]
fn deep_and_long_texts_get_short_answers() {
    let head = "schema = \"trolley.scenario/2\"\n";
    let most = TEXT_BYTES_MAX - 200;
    for text in [
        format!("{head}{}a = 1", "a.".repeat(most / 2)),
        format!("{head}[{}a]\n", "a.".repeat(most / 2)),
        format!("{head}x = {}", "[".repeat(most)),
        format!("{head}x = {}", "{ a = ".repeat(most / 6)),
        format!("{head}x = {{ {}a = 1 }}", "a.".repeat(most / 2)),
        format!("{head}{} = 1", "x".repeat(most)),
        format!("{head}name = [{:?}]", "x".repeat(most)),
        format!("{head}name = 'n'\ncandidates = [{}]\nparties = {{}}", "{},".repeat(most / 3)),
        format!("{head}{}", "[[candidates]]\n".repeat(most / 15)),
    ] {
        let error = parse(&text).unwrap_err();
        assert!(error.to_string().len() < 1000, "{}", error.to_string().len());
    }
}

#[test]
fn the_schema_describes_every_key_and_its_unit() {
    assert_eq!(violated(FULL), Vec::<String>::new());
    let schema = the_schema();
    let tables = [
        "engine",
        "parties",
        "candidates",
        "generate",
        "persons",
        "crush",
        "errors",
        "place",
        "state",
        "paths",
        "path",
        "states",
        "reactions",
    ];
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
    assert_units_are_described(&schema);
    assert!(!crate::schema().contains("null"));
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

    #[test]
    fn no_text_makes_it_panic_and_every_fault_has_a_place_in_the_text(harms in harms()) {
        let text = harmed(FULL, &harms);
        match parse(&text) {
            Err(error) if error.file == "f.toml" => {
                let lines: Vec<&str> = text.split('\n').collect();
                let line = lines.get(error.place.line.wrapping_sub(1));
                let end = line.map_or(0, |line| line.chars().count() + 1);
                prop_assert!((1..=end).contains(&error.place.column), "{error}\n{text}");
                prop_assert!(!error.remedy.is_empty());
                prop_assert_eq!(error.to_string().lines().count(), 1, "{}", error);
            }
            Err(error) => prop_assert!(error.what == "the file is empty", "{}", error),
            Ok(scenario) => {
                prop_assert!((1..=16).contains(&scenario.candidates.len()));
                prop_assert!(scenario.ego.0 < scenario.parties.len());
                for motion in motions(&scenario) {
                    prop_assert_eq!(motion.path.from_s(), 0.0);
                    prop_assert_eq!(motion.path.to_s(), scenario.horizon_s);
                }
            }
        }
    }

    #[test]
    fn no_string_at_all_makes_it_panic(text in any::<String>()) {
        prop_assert!(parse(&text).is_err());
    }
}
