//! The worked vectors I1 to I5, and files that must be refused.

use super::*;
use crate::fault::DataFileError;

/// Severity levels of one study beside each other, and fatal pedestrian accidents.
const LEVELS: &str =
    include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/config/curves/levels.toml"));

fn shipped() -> Curves {
    Curves::shipped().expect("the shipped curves are sound")
}

fn risk(curves: &Curves, victim: Victim, level: Level, v: f64) -> f64 {
    let rung = curves.rung(victim, level).expect("has a curve");
    curves.nominal(rung).risk(v)
}

fn near(value: f64, expected: f64) {
    assert!((value - expected).abs() <= 1e-5, "{value} is not {expected}");
}

#[test]
fn i1_occupants_at_12_m_s_by_struck_side() {
    let curves = shipped();
    near(risk(&curves, Victim::OccupantFront, Level::Mais3, 12.0), 0.07785);
    near(risk(&curves, Victim::OccupantSide, Level::Mais3, 12.0), 0.09700);
    near(risk(&curves, Victim::OccupantRear, Level::Mais3, 12.0), 0.05221);
}

#[test]
fn i2_levels_of_one_study_at_12_m_s() {
    let curves = Curves::parse("levels.toml", LEVELS).expect("sound");
    for side in [Victim::OccupantFront, Victim::OccupantSide, Victim::OccupantRear] {
        near(risk(&curves, side, Level::Mais2, 12.0), 0.23363);
        near(risk(&curves, side, Level::Mais3, 12.0), 0.07089);
        near(risk(&curves, side, Level::Fatal, 12.0), 0.00908);
    }
    // Fed with m/s as if they were mph, the same curve gives a tenth: that is the trap.
    let rung = curves.rung(Victim::OccupantFront, Level::Mais3).expect("has a curve");
    near(curves.nominal(rung).risk(12.0 * 0.44704), 0.00581);
}

#[test]
fn i3_persons_outside_at_12_m_s() {
    let curves = shipped();
    near(risk(&curves, Victim::Pedestrian, Level::Mais3, 12.0), 0.21833);
    near(risk(&curves, Victim::Cyclist, Level::Mais3, 12.0), 0.07640);
    near(risk(&curves, Victim::Motorcyclist, Level::Mais3, 12.0), 0.06612);
}

#[test]
fn i4_pedestrians_killed_at_50_km_h() {
    let curves = Curves::parse("levels.toml", LEVELS).expect("sound");
    near(risk(&curves, Victim::Pedestrian, Level::Fatal, 50.0 / 3.6), 0.08225);
}

#[test]
fn i5_range_of_a_pedestrian_at_12_m_s() {
    let curves = shipped();
    let rung = curves.rung(Victim::Pedestrian, Level::Mais3).expect("has a curve");
    let speeds = Speeds { delta_v: 0.0, normal: 12.0, closing: 12.0 };
    near(curves.low(rung, &speeds), 0.15482);
    near(curves.high(rung, &speeds), 0.27649);
}

#[test]
fn a_person_without_a_curve_is_refused_and_not_given_anothers() {
    let curves = shipped();
    assert_eq!(curves.covers(Level::Mais3), Ok(()));
    let missing = MissingCurve { victim: Victim::OccupantFront, level: Level::Fatal };
    assert_eq!(curves.covers(Level::Fatal), Err(missing));
    let levels = Curves::parse("levels.toml", LEVELS).expect("sound");
    let missing = levels.covers(Level::Fatal).expect_err("cyclists have no fatal curve");
    assert_eq!(missing.victim, Victim::Cyclist);
    assert!(missing.to_string().contains("no curve for cyclist at level fatal"));
}

#[test]
fn ranges_of_a_level_stay_within_the_ladder() {
    let levels = Curves::parse("levels.toml", LEVELS).expect("sound");
    for k in 0..400 {
        let v = f64::from(k) * 0.1;
        let speeds = Speeds { delta_v: v, normal: v, closing: v };
        for side in [Victim::OccupantFront, Victim::OccupantSide, Victim::OccupantRear] {
            let rung = |level| levels.rung(side, level).expect("has a curve");
            for pair in Level::ALL.windows(2) {
                let (mild, severe) = (rung(pair[0]), rung(pair[1]));
                assert!(levels.low(severe, &speeds) <= levels.low(mild, &speeds));
                assert!(levels.high(severe, &speeds) <= levels.high(mild, &speeds));
            }
        }
    }
}

/// Hussain's meta-analysis of fatalities tests the range alone: the upper intercept covers the
/// first three of its anchors.
#[test]
fn the_upper_fatal_curve_covers_another_study() {
    let text = include_str!("../../config/curves/levels.toml");
    let levels = Curves::parse("levels.toml", text).expect("sound");
    let curve = |id: &str| levels.curves.iter().find(|c| *c.id == *id).expect("shipped");
    let (low, high) = (curve("rosen-sander-2009-low"), curve("rosen-sander-2009-high"));
    for (p, km_h) in [(0.05, 30.0), (0.10, 37.0), (0.50, 59.0)] {
        let v = km_h / 3.6;
        assert!(low.published(v) <= p && p <= high.published(v), "{km_h} km/h");
    }
}

/// A set of two levels for one person.
fn pair(
    unit: &str,
    mild: (&str, f64, f64),
    severe: (&str, f64, f64),
) -> Result<Curves, DataFileError> {
    let mut text = String::from("schema = 1\nname = \"pair\"\nmixed_origins = \"a test\"\n");
    for (level, a, b) in [mild, severe] {
        text += &format!(
            "[[curve]]\nid = \"{level}\"\noutcome = \"{level}\"\nunit = \"{unit}\"\na = {a:?}\nb = \
             {b:?}\nvalid = [0.0, 50.0]\nsource = \"s\"\nyear = 2000\nsample = \"s\"\norigin = \
             \"o\"\n"
        );
    }
    for (level, ..) in [mild, severe] {
        text += &format!(
            "[[person]]\nvictim = \"pedestrian\"\nlevel = \"{level}\"\nx = \"delta-v\"\nnominal = \
             \"{level}\"\nlow = {{ curves = [\"{level}\"], times = 1.0 }}\nhigh = {{ curves = \
             [\"{level}\"], times = 1.0 }}\n"
        );
    }
    Curves::parse("pair.toml", &text)
}

/// Speeds as the message gives them: "from 26.6 to 40.0 m/s".
fn broken(result: Result<Curves, DataFileError>) -> String {
    let fault = result.expect_err("the ladder is broken").what;
    fault.split(" from ").nth(1).unwrap_or_default().to_owned()
}

#[test]
fn published_pairs_that_break_the_ladder_are_refused() {
    let (m2, m3, fatal) = ("mais2+", "mais3+", "fatal");
    // Wang, rear-end.
    let rear = pair("mph", (m2, -6.1818, 0.1482), (m3, -8.0329, 0.1793));
    assert_eq!(broken(rear), "26.6 to 40.0 m/s");
    // TUM front over the GIDAS curve for MAIS2+.
    let mixed = pair("m/s", (m2, -5.82, 0.292), (m3, -4.457, 0.177));
    assert_eq!(broken(mixed), "0.1 to 10.7 m/s");
    // Rosén 2010 under a fit to Hussain's fatalities; cyclists under Nie's.
    let pedestrian = pair("km/h", (m3, -4.6, 0.078), (fatal, -6.157, 0.1044));
    assert_eq!(broken(pedestrian), "16.3 to 40.0 m/s");
    let cyclist = pair("km/h", (m3, -5.824, 0.078), (fatal, -6.929, 0.095));
    assert_eq!(broken(cyclist), "18.0 to 40.0 m/s");
    assert!(pair("km/h", (m3, -4.6, 0.078), (fatal, -6.9, 0.090)).is_ok());
}

/// The shipped file with one text replaced: where and why it is refused.
fn refused(from: &str, to: &str) -> DataFileError {
    assert!(DEFAULT_CURVES.contains(from), "{from}");
    Curves::parse("my.toml", &DEFAULT_CURVES.replacen(from, to, 1)).expect_err(to)
}

#[test]
fn unsound_files_are_refused_with_their_place() {
    let cases = [
        ("schema = 1", "schema = 2", "unknown schema"),
        ("unit = \"m/s\"\n", "", "unit"),
        ("unit = \"m/s\"", "unit = \"furlong\"", "furlong"),
        ("b = 0.177", "b = -0.177", "slope"),
        ("b = 0.177", "b = nan", "slope"),
        ("a = -4.457", "a = inf", "not a number"),
        ("valid = [0.0, 30.0]", "valid = [30.0, 0.0]", "not a range"),
        ("year = 2023", "year = 23", "not a year"),
        ("origin = \"tum\"", "origin = \" \"", "is empty"),
        ("id = \"tum-lr4s-side\"", "id = \"tum-lr4s-front\"", "two curves"),
        ("nominal = \"tum-lr4s-front\"", "nominal = \"tum\"", "not defined"),
        ("outcome = \"mais3+\"", "outcome = \"fatal\"", "another outcome"),
        ("times = 0.75", "times = 0.0", "not a factor"),
        ("times = 0.75", "times = 1.75", "outside its own range"),
        ("victim = \"occupant-side\"", "victim = \"occupant-front\"", "already"),
        ("sample = \"pedestrians\"", "sample = \"p\"\nage = 0.04", "unknown field `age`"),
    ];
    for (from, to, expected) in cases {
        let fault = refused(from, to);
        assert!(fault.what.contains(expected), "{to}: {fault}");
        assert!(fault.line > 1 && fault.column > 0, "{to}: {fault}");
        assert!(fault.to_string().starts_with(&format!("my.toml:{}:", fault.line)));
    }
    let line =
        1 + DEFAULT_CURVES[..DEFAULT_CURVES.find("b = 0.177").unwrap()].matches('\n').count();
    let slope = refused("b = 0.177", "b = 0.0");
    assert_eq!((slope.line, slope.column), (line, 5));
    assert!(refused("sample = \"pedestrians\"", "sex = 1").remedy.contains("kind, body and seat"));
}

#[test]
fn several_origins_need_a_reason() {
    let from = DEFAULT_CURVES.find("mixed_origins").expect("states one");
    let to = DEFAULT_CURVES.find("# --- occupants").expect("goes on");
    let silent = format!("{}{}", &DEFAULT_CURVES[..from], &DEFAULT_CURVES[to..]);
    let fault = Curves::parse("my.toml", &silent).expect_err("no reason");
    assert!(fault.what.contains("different origins"), "{fault}");
}
