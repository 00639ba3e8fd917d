//! A side file is read whole or refused with file, line and column.

use super::*;

#[test]
fn every_fault_has_line_and_column() {
    let cases = [
        ("mass_kg = 1.0\nmas_kg = 1.0\n", "a.toml:2:1: unknown field `mas_kg`"),
        ("\n  mass_kg = -1.0\n", "a.toml:2:13: mass_kg = -1 is not in (0, 1000000]"),
        ("mass_kg = nan", "a.toml:1:11: mass_kg = NaN is not in (0, 1000000]"),
        ("mass_kg = inf", "a.toml:1:11: mass_kg = inf is not in (0, 1000000]"),
        ("gyration_m = 0.0", "a.toml:1:14: gyration_m = 0 is not in (0, 1000000]"),
        ("centre_m = [0.0, nan, 1.0]", "a.toml:1:12: centre_m [0.0, NaN, 1.0] is not finite"),
        (
            "yaw_inertia_kg_m2 = 9.0\ngyration_m = 1.0",
            "a.toml:1:21: yaw_inertia_kg_m2 and gyration_m",
        ),
        ("name = \"  \"", "a.toml:1:8: the name is empty"),
        ("kind = \"boat\"", "a.toml:1:8: unknown variant `boat`"),
        ("occupants = [{ chair = 1 }]", "a.toml:1:16: unknown field `chair`"),
        ("name = \"\u{e9}\" mass", "a.toml:1:12: "),
        ("mass_kg = 1.0\nmass_kg = 2.0", "a.toml:2:1: duplicate key"),
    ];
    for (text, expected) in cases {
        let fault = Side::parse("a.toml", text).expect_err(text);
        assert!(fault.to_string().starts_with(expected), "{text:?}: {fault}");
        assert!(!fault.help.is_empty());
    }
}

#[test]
fn an_empty_file_says_nothing() {
    let side = Side::parse("a.toml", "# nothing is known\n").expect("valid");
    assert_eq!((side.name(), side.kind()), (None, None));
}

#[test]
fn the_documented_example_is_read() {
    let text = "name = \"sedan\"\nkind = \"sedan\"\nmass_kg = 1550.0\ncentre_m = [0.0, 0.0, 0.7]\n\
                yaw_inertia_kg_m2 = 1053.5\noccupants = [{ seat = \"front-left\" }]\n\
                source = \"maker's data sheet, 2024\"\n";
    let side = Side::parse("a.toml", text).expect("valid");
    assert_eq!((side.name(), side.kind()), (Some("sedan"), Some(Kind::Sedan)));
}
