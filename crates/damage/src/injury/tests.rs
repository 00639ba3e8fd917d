//! The worked vectors I1 to I5, and files that must be refused.

use super::*;
use crate::curve::Dose;
use crate::fault::DataFileError;

/// Severity levels of one study beside each other, and fatal pedestrian accidents.
const LEVELS: &str =
    include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/config/curves/levels.toml"));

fn shipped() -> Curves {
    Curves::shipped().expect("the shipped curves are sound")
}

fn speeds(v: f64, front_m: f64) -> Speeds {
    Speeds { delta_v: v, normal: v, closing: v, front_m }
}

fn risk(curves: &Curves, victim: Victim, level: Level, v: f64) -> f64 {
    let rung = curves.rung(victim, level).expect("has a curve");
    curves.risk(rung, &speeds(v, 0.0))
}

fn near(value: f64, expected: f64) {
    assert!((value - expected).abs() <= 1e-5, "{value} is not {expected}");
}

const OCCUPANTS: [Victim; 4] =
    [Victim::OccupantFront, Victim::OccupantNear, Victim::OccupantFar, Victim::OccupantRear];

/// P(x) anchored, by hand.
fn by_hand(a: f64, b: f64, x: f64) -> f64 {
    let p = |x: f64| 1.0 / (1.0 + libm::exp(-(a + b * x)));
    (p(x) - p(0.0)) / (1.0 - p(0.0))
}

#[test]
fn nominal_curves_at_12_m_s() {
    let curves = shipped();
    let mph = 12.0 / 0.44704;
    for (victim, expected) in [
        (Victim::OccupantFront, by_hand(-6.9774, 0.162, mph)),
        (Victim::OccupantNear, by_hand(-5.910, 0.1637, mph)),
        (Victim::OccupantFar, by_hand(-8.606, 0.1637, mph)),
        (Victim::OccupantRear, by_hand(-8.0329, 0.1793, mph)),
        (Victim::Pedestrian, by_hand(-4.442, 0.078, 43.2)),
        (Victim::Cyclist, by_hand(-5.634, 0.079, 43.2)),
        (Victim::Motorcyclist, by_hand(-5.989, 0.079, 43.2)),
    ] {
        near(risk(&curves, victim, Level::Mais3, 12.0), expected);
    }
}

/// What the studies publish of themselves: 10 % at these speeds.
#[test]
fn curves_pass_through_what_their_authors_publish() {
    let curves = shipped();
    let published = |id: &str, km_h: f64| {
        let curve = curves.curves.iter().find(|c| *c.id == *id).expect("shipped");
        curve.published(Dose::at(km_h / 3.6))
    };
    for (id, km_h) in [
        ("lubbe-pedestrian", 29.0),
        ("lubbe-cyclist", 44.0),
        ("motorcyclist", 48.0),
        ("lubbe-driver", 56.0),
    ] {
        assert!((published(id, km_h) - 0.10).abs() < 0.006, "{id}: {}", published(id, km_h));
    }
    for (mph, p) in [(17.1, 0.1), (33.0, 0.5), (48.1, 0.9)] {
        assert!((published("tefft-severe", mph * 1.609_344) - p).abs() < 0.012, "{mph}");
    }
}

/// Monfort & Mueller's own form, at any height: ours is the same from 75 cm on.
#[test]
fn the_term_for_tall_fronts_is_the_studys_own() {
    let levels = Curves::parse("levels.toml", LEVELS).expect("sound");
    let curve = |id: &str| levels.curves.iter().find(|c| *c.id == *id).expect("shipped");
    for v in [30.0, 50.0, 70.0] {
        for h in [75.0, 85.25, 101.6, 124.0] {
            let (a, b) = (v - 42.79, h - 85.25);
            for (id, z) in [
                ("monfort-mueller-mais2", 0.686 + 0.083 * a + 0.034 * b + 0.001 * a * b),
                ("monfort-mueller-mais3", -0.460 + 0.091 * a + 0.039 * b + 0.002 * a * b),
                ("monfort-mueller-fatal", -3.280 + 0.123 * a + 0.047 * b),
            ] {
                let dose = Dose { speed_m_s: v / 3.6, front_m: h / 100.0 };
                let p = 1.0 / (1.0 + libm::exp(-z));
                assert!((curve(id).published(dose) - p).abs() < 2e-3, "{id} {v} {h}");
            }
        }
    }
}

/// The bands in which a nominal curve must lie: from the least to the greatest of what the studies
/// say, not anchored.
#[test]
fn nominal_risks_lie_among_the_studies() {
    let curves = shipped();
    let logistic = |z: f64| 1.0 / (1.0 + libm::exp(-z));
    for km_h in [30.0_f64, 50.0, 70.0] {
        for h in [75.0, 110.0] {
            let (a, b) = (km_h - 42.79, h - 85.25);
            let studies = [
                logistic(-4.442 + 0.078 * km_h),
                logistic(-0.460 + 0.091 * a + 0.039 * b + 0.002 * a * b),
                logistic(-4.678 + 0.1418 * km_h / 1.609_344),
            ];
            let [least, most] =
                [studies.into_iter().fold(1.0, f64::min), studies.into_iter().fold(0.0, f64::max)];
            let rung = curves.rung(Victim::Pedestrian, Level::Mais3).expect("has a curve");
            let risk = curves.risk(rung, &speeds(km_h / 3.6, h / 100.0));
            // Anchoring takes P(0), up to 2 %, away.
            assert!(least - 0.02 <= risk && risk <= most, "{km_h} {h}: {least} {risk} {most}");
        }
    }
    for km_h in [10.0, 30.0, 50.0] {
        let wang = logistic(-6.9774 + 0.162 * km_h / 1.609_344);
        let lubbe = logistic(-6.835 + 0.082 * km_h);
        let risk = risk(&curves, Victim::OccupantFront, Level::Mais3, km_h / 3.6);
        let [least, most] = [wang.min(lubbe), wang.max(lubbe)];
        assert!(least - 0.001 <= risk && risk <= most, "{km_h}: {least} {risk} {most}");
    }
}

#[test]
fn near_is_worse_than_front_and_far_and_tall_is_worse_than_low() {
    let curves = shipped();
    for k in 1..300 {
        let v = 0.1 * f64::from(k);
        let risk_of = |victim| risk(&curves, victim, Level::Mais3, v);
        assert!(risk_of(Victim::OccupantNear) > risk_of(Victim::OccupantFront));
        assert!(risk_of(Victim::OccupantNear) > risk_of(Victim::OccupantFar));
        for victim in [Victim::Pedestrian, Victim::Cyclist] {
            let rung = curves.rung(victim, Level::Mais3).expect("has a curve");
            let by_height = |h: f64| curves.risk(rung, &speeds(v, h));
            assert!(by_height(0.97) >= by_height(0.7) && by_height(1.24) >= by_height(0.97));
        }
    }
}

#[test]
fn rear_never_passes_its_milder_level() {
    let curves = shipped();
    let milder = by_hand(-6.1818, 0.1482, 35.0 / 0.44704);
    near(risk(&curves, Victim::OccupantRear, Level::Mais3, 35.0), milder);
}

#[test]
fn levels_of_one_study_at_12_m_s() {
    let curves = Curves::parse("levels.toml", LEVELS).expect("sound");
    for side in OCCUPANTS {
        near(risk(&curves, side, Level::Mais2, 12.0), 0.23363);
        near(risk(&curves, side, Level::Mais3, 12.0), 0.07089);
        near(risk(&curves, side, Level::Fatal, 12.0), 0.00908);
    }
    // Fed with m/s as if they were mph, the same curve gives a tenth: that is the trap.
    let rung = curves.rung(Victim::OccupantFront, Level::Mais3).expect("has a curve");
    near(curves.nominal(rung).risk(Dose::at(12.0 * 0.44704)), 0.00581);
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
        for front_m in [0.0, 0.97, 1.24] {
            let speeds = speeds(f64::from(k) * 0.1, front_m);
            for victim in OCCUPANTS.into_iter().chain([Victim::Pedestrian]) {
                let rung = |level| levels.rung(victim, level).expect("has a curve");
                for pair in Level::ALL.windows(2) {
                    let (mild, severe) = (rung(pair[0]), rung(pair[1]));
                    assert!(levels.low(severe, &speeds) <= levels.low(mild, &speeds));
                    assert!(levels.high(severe, &speeds) <= levels.high(mild, &speeds));
                    assert!(levels.risk(severe, &speeds) <= levels.risk(mild, &speeds) + 1e-12);
                }
            }
        }
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
        ("unit = \"mph\"\n", "", "unit"),
        ("unit = \"mph\"", "unit = \"furlong\"", "furlong"),
        ("b = 0.1620", "b = -0.1620", "slope"),
        ("b = 0.1620", "b = nan", "slope"),
        ("a = -6.9774", "a = inf", "not a number"),
        ("valid = [0.0, 67.0]", "valid = [67.0, 0.0]", "not a range"),
        ("year = 2022", "year = 22", "not a year"),
        ("origin = \"tum\"", "origin = \" \"", "is empty"),
        ("id = \"tum-lr4s-side\"", "id = \"tum-lr4s-front\"", "two curves"),
        ("at = 42.79", "at = -42.79", "not a term for tall fronts"),
        ("at_most = \"wang-rear-mais2\"", "at_most = \"wang-frontal\"", "another outcome"),
        ("nominal = \"wang-frontal\"", "nominal = \"wang\"", "not defined"),
        ("outcome = \"mais3+\"", "outcome = \"fatal\"", "another outcome"),
        ("times = 0.75", "times = 0.0", "not a factor"),
        ("times = 0.75", "times = 1.75", "outside its own range"),
        ("victim = \"occupant-near\"", "victim = \"occupant-front\"", "already"),
        ("victim = \"occupant-near\"", "victim = \"occupant-side\"", "already"),
        ("sample = \"motorcyclists\"", "sample = \"m\"\nage = 0.04", "unknown field `age`"),
    ];
    for (from, to, expected) in cases {
        let fault = refused(from, to);
        assert!(fault.what.contains(expected), "{to}: {fault}");
        assert!(fault.line > 1 && fault.column > 0, "{to}: {fault}");
        assert!(fault.to_string().starts_with(&format!("my.toml:{}:", fault.line)));
    }
    let line =
        1 + DEFAULT_CURVES[..DEFAULT_CURVES.find("b = 0.1620").unwrap()].matches('\n').count();
    let slope = refused("b = 0.1620", "b = 0.0");
    assert_eq!((slope.line, slope.column), (line, 5));
    assert!(
        refused("sample = \"motorcyclists\"", "sex = 1").remedy.contains("kind, body and seat")
    );
}

#[test]
fn several_origins_need_a_reason() {
    let from = DEFAULT_CURVES.find("mixed_origins").expect("states one");
    let to = DEFAULT_CURVES.find("# --- occupants").expect("goes on");
    let silent = format!("{}{}", &DEFAULT_CURVES[..from], &DEFAULT_CURVES[to..]);
    let fault = Curves::parse("my.toml", &silent).expect_err("no reason");
    assert!(fault.what.contains("different origins"), "{fault}");
}
