//! The shipped file is sound; unsound ones are refused with their place.

use super::*;

fn refused(from: &str, to: &str) -> DataFileError {
    assert!(DEFAULT_PARAMETERS.contains(from), "{from}");
    let text = DEFAULT_PARAMETERS.replacen(from, to, 1);
    Parameters::parse("my.toml", &text).expect_err(to)
}

#[test]
fn the_shipped_file_gives_every_value_a_source() {
    let shipped = Parameters::shipped().expect("sound");
    assert_eq!((shipped.restitution.nominal, shipped.friction.nominal), (0.1, 0.6));
    assert_eq!(shipped.sources.len(), 10);
}

#[test]
fn unsound_files_are_refused_with_their_place() {
    for (from, to, expected) in [
        ("schema = 1", "schema = 2", "unknown schema"),
        ("nominal = 0.1", "nominal = 0.4", "not a range"),
        ("nominal = 0.1", "nominal = nan", "not a range"),
        ("high = 0.3", "high = 1.3", "not a range"),
        ("value = 0.15", "value = 1.0", "out of its range"),
        ("value = 0.15", "value = -0.1", "out of its range"),
        ("value = 10.0", "value = 90.0", "out of its range"),
        ("value = 0.2", "value = 0.9", "together with face_restitution"),
        ("source = \"assumption: load\"", "source = \" \"", "the source is empty"),
        ("[mass_share]", "[mass_shares]", "unknown field"),
        ("[speed_share]\nvalue = 0.05", "[speed_share]", "value"),
    ] {
        let fault = refused(from, to);
        assert!(fault.what.contains(expected), "{to}: {fault}");
        assert!(fault.line >= 1 && !fault.remedy.is_empty(), "{to}: {fault}");
    }
}

/// What is known of a party takes the place of what holds for all.
#[test]
fn parties_have_parameters_of_their_own() {
    let shipped = Parameters::shipped().expect("sound");
    let range = |nominal: f64| Some(Setting { low: 0.0, nominal, high: 0.5 });
    let none = OwnParameters::default();
    let a = OwnParameters { restitution: range(0.2), mass_share: Some(0.02), ..none };
    let b = OwnParameters { restitution: range(0.4), friction: range(0.5), ..none };
    let usual = shipped.of_pair([&none, &none]);
    assert_eq!((usual.restitution, usual.friction), (shipped.restitution, shipped.friction));
    assert_eq!((usual.mass_share, usual.gyration_share), ([0.1; 2], [0.15; 2]));
    let one = shipped.of_pair([&a, &none]);
    assert_eq!((Some(one.restitution), one.friction), (a.restitution, shipped.friction));
    assert_eq!(one.mass_share, [0.02, 0.1]);
    let both = shipped.of_pair([&a, &b]);
    assert!((both.restitution.nominal - 0.3).abs() < 1e-12);
    assert_eq!((Some(both.friction), Some(both.flat_friction)), (b.friction, b.friction));
    let turned = shipped.of_pair([&b, &a]);
    assert_eq!((turned.restitution, turned.mass_share), (both.restitution, [0.1, 0.02]));
}
