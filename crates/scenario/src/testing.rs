//! Texts with one thing wrong, for the tests of all modules.

pub(crate) mod harm;

/// A line that sets a key: number from 1, section header, key, value.
pub(crate) type Setting = (usize, &'static str, &'static str, &'static str);

/// A key, and values that are refused at its own line.
pub(crate) type WrongValues = (&'static str, &'static [&'static str]);

/// The lines of a scenario that set a key.
pub(crate) fn settings_in(text: &'static str) -> Vec<Setting> {
    let mut section = "";
    let mut found = Vec::new();
    for (index, line) in text.lines().enumerate() {
        if line.starts_with('[') {
            section = line;
        } else if let Some((key, value)) = line.split_once(" = ") {
            found.push((index + 1, section, key, value));
        }
    }
    found
}

/// A text with one line replaced.
pub(crate) fn with_line_in(text: &str, number: usize, line: &str) -> String {
    let lines: Vec<&str> =
        text.lines().enumerate().map(|(i, old)| if i + 1 == number { line } else { old }).collect();
    lines.join("\n")
}

/// What a person is told of an error.
pub(crate) fn told(error: impl diagnostic::Diagnostic) -> String {
    diagnostic::Failure::from(error).to_string()
}

/// A fault and a remedy, each on one line, without what only a programmer reads.
pub(crate) fn assert_reads_well(error: &str) {
    let lines: Vec<&str> = error.lines().collect();
    assert!(lines.len() == 2 && lines[1].starts_with("  help: "), "{error:?}");
    assert!(lines[1].len() > "  help: ".len(), "{error:?}");
    for word in ["f64", "i64", "i128", "u32", "struct", "Option", "unknown field", "`None`"] {
        assert!(!error.contains(word), "{word} in {error:?}");
    }
    assert!(!error.chars().any(|c| c.is_control() && c != '\n'), "{error:?}");
}

/// Wrong values by key: the ends of each range, other types, other words, contradictions.
pub(crate) const WRONG: &[WrongValues] = &[
    ("schema", &["\"trolley.scenario/1\"", "\"trolley.scenario/3\"", "1", "\"\""]),
    ("name", &["\"\"", "\" blank\"", "\"two\\nlines\"", "\"\\u001b[2J\"", "4"]),
    ("policy", &["\"\"", "\"a\\u0000b\"", "7"]),
    ("curves", &["\"\"", "\"a\\u0000b\"", "[]"]),
    ("parameters", &["\"\"", "\"a\\u0000b\"", "{}"]),
    ("deadline_ms", &["0", "-50", "nan", "inf", "3600001", "\"50\""]),
    ("ego", &["\"cat\"", "\"post\"", "\"\"", "1"]),
    ("workers", &["0", "-1", "17", "2.0", "\"2\""]),
    ("cores", &["[0]", "[0, 1, 2]", "[0, -1]", "[0, 1024]", "[0, 0.5]", "2", "[\"a\", \"b\"]"]),
    ("coordinator_core", &["-1", "1024", "1.5"]),
    ("depth", &["-1", "21", "6.5", "99999999999999999999", "\"deep\"", "[4]"]),
    ("scheme", &["\"best\"", "\"Best-Match-Load\"", "1"]),
    ("alpha", &["-0.1", "1.1", "nan", "-inf", "\"half\""]),
    ("batch", &["0", "-8", "257", "8.5"]),
    ("queue", &["0", "4097", "7", "true"]),
    ("build", &["\"seeds\"", "\"\"", "2"]),
    ("leaf_size", &["0", "65", "1.0"]),
    ("seed", &["-1", "1e3", "\"x\"", "9223372036854775808"]),
    (
        "size_m",
        &["[]", "[4, 2, 1, 1]", "[0, 2]", "[4, -2]", "[501]", "[nan, 1]", "4.5", "[\"l\", 1]"],
    ),
    ("mass_kg", &["0", "-1500", "nan", "inf", "1000001", "\"heavy\"", "0.09"]),
    ("kind", &["\"sedan\"", "\"\"", "\"Unknown\"", "1"]),
    ("a_n_m", &["-1", "nan", "inf", "1e9", "\"stiff\""]),
    ("b_n_m2", &["0", "-5", "nan", "1e11", "[1]"]),
    ("responsibility", &["-0.01", "1.01", "nan", "\"all\""]),
    ("shape", &["\"building\"", "\"tram\"", "\"SEDAN\"", "3"]),
    ("triangles", &["499", "1000001", "-2000", "2000.0", "nan"]),
    ("seat", &["\"rider\"", "\"front\"", "\"\"", "0"]),
    ("file", &["\"\"", "\"a\\u0000b\"", "3"]),
    ("probability", &["-0.1", "1.5", "nan", "\"likely\""]),
    (
        "position_m",
        &[
            "[0, 0]",
            "[0, 0, 0, 0]",
            "[0, nan, 0]",
            "[inf, 0, 0]",
            "[0, 0, 1000001]",
            "0",
            "[0, \"y\", 0]",
        ],
    ),
    ("yaw_deg", &["361", "-361", "nan", "inf", "\"north\""]),
    ("pitch_deg", &["90.5", "-91", "nan", "[1]"]),
    ("roll_deg", &["181", "-180.5", "nan", "true"]),
    ("speed_m_s", &["151", "-151", "nan", "inf", "\"fast\"", "[1, 2]"]),
    ("velocity_m_s", &["[151, 0]", "[0, -151]", "[110, 110]", "[nan, 0]", "[1]", "[1, 2, 3]", "5"]),
    ("members", &["0", "-1", "1025", "2.5", "\"many\""]),
    ("members_max", &["0", "7", "1025", "64.0"]),
    ("lateral_m", &["-0.1", "10.1", "nan", "\"far\""]),
    ("longitudinal_m", &["-0.1", "10.1", "inf", "[1]"]),
    ("correlation", &["-1.1", "1.1", "nan", "true"]),
    ("speed_share", &["-0.1", "0.51", "nan", "\"fast\""]),
    ("party", &["\"car\"", "\"wall\"", "\"\"", "1"]),
];

/// Values that are wrong for a key, by a form's own table or by that of all forms.
pub(crate) fn wrong_values(key: &str, own: &[WrongValues]) -> &'static [&'static str] {
    let found = own.iter().chain(WRONG).find(|(known, _)| *known == key);
    found.map_or_else(|| panic!("no wrong value is known for {key}"), |(_, values)| *values)
}
