//! Rankings against what is known otherwise: crashes written early and late, and finished work.

use crate::support::shared;
use trolley::{AnswerState, ContactRow, Engine, Limits, Scenario};

/// A crash as it is shortly after contact: who, where (x, y, yaw), and both speeds.
type Crash = (&'static str, [f64; 3], [f64; 2]);

const CRASHES: [Crash; 12] = [
    ("wall", [3.0, 1.2, -4.0], [10.0, 0.0]),
    ("wall", [2.55, 0.0, 90.0], [10.0, 0.0]),
    ("wall", [3.0, 1.38, -8.0], [10.0, 0.0]),
    ("suv", [4.65, 0.3, 0.0], [16.0, 8.0]),
    ("sedan", [3.18, 0.4, -90.0], [13.0, 6.0]),
    ("sedan", [4.5, 0.8, 177.0], [13.0, 12.0]),
    ("truck", [7.0, 0.8, 180.0], [13.0, 12.0]),
    ("cyclist", [2.51, 0.9, 115.0], [4.0, 7.0]),
    ("motorcycle", [3.2, 0.1, 150.0], [11.0, 9.0]),
    ("pedestrian", [2.5, 0.35, 90.0], [12.0, 1.4]),
    ("pole", [2.4, 0.3, 0.0], [10.0, 0.0]),
    ("pole", [2.3, -0.6, 12.0], [13.0, 0.0]),
];

/// A crash, written so much time earlier (s).
fn text((shape, [x, y, yaw], [ego, other]): Crash, earlier_s: f64) -> String {
    let [sin, cos] = [yaw.to_radians().sin(), yaw.to_radians().cos()];
    let (x, y) = (x - other * cos * earlier_s, y - other * sin * earlier_s);
    let body = |shape: &str| format!("generate = {{ shape = \"{shape}\", triangles = 2000 }}");
    let motion = if other == 0.0 {
        format!("place = {{ position_m = [{x:?}, {y:?}, 0], yaw_deg = {yaw:?} }}")
    } else {
        format!(
            "state = {{ position_m = [{x:?}, {y:?}, 0], yaw_deg = {yaw:?}, speed_m_s = {other:?} }}"
        )
    };
    format!(
        "schema = \"trolley.scenario/2\"\nname = \"early\"\nhorizon_s = 30\n[parties.ego]\n{}\n\
         [parties.other]\n{}\n{motion}\n[[candidates]]\nname = \"go on\"\nstate = {{ position_m = \
         [{:?}, 0, 0], speed_m_s = {ego:?} }}\n",
        body("sedan"),
        body(shape),
        -ego * earlier_s
    )
}

/// Whatever the distance at which a crash is written down, it is the same crash.
#[test]
fn every_crash_is_found_however_early_it_is_written() {
    let mut engine = Engine::builder().in_process().build().unwrap();
    let mut crashes = 0;
    for crash in CRASHES {
        let (_, _, [ego, other]) = crash;
        let mut first: Option<(f64, ContactRow)> = None;
        for before_m in [1.0, 1.2, 2.0, 3.7, 9.0, 20.0] {
            let earlier_s = before_m / (ego + other);
            let scenario = Scenario::parse("early.toml", &text(crash, earlier_s)).unwrap();
            let answer = engine.rank(&scenario, &Limits::default()).unwrap().answer;
            assert_eq!(answer.state, AnswerState::Complete, "{crash:?}");
            let row = answer.ranking.into_iter().next().unwrap();
            let contact = row.contacts.into_iter().next();
            let contact = contact.unwrap_or_else(|| panic!("{crash:?}, {before_m} m before"));
            assert!(!contact.is_at_start, "{crash:?}, {before_m} m before");
            let at_s = contact.time_s - earlier_s;
            let (then_s, then) = first.get_or_insert_with(|| (at_s, contact.clone()));
            assert!((at_s - *then_s).abs() < 1e-6, "{crash:?}: {at_s} and {then_s} s");
            for (now, then) in contact.persons.iter().zip(&then.persons) {
                let (now, then) = (now.work.hi(), then.work.hi());
                assert!((now - then).abs() <= 1e-3 * then, "{crash:?}: {then} and {now}");
            }
            crashes += 1;
        }
    }
    assert_eq!(crashes, 72);
}

/// However early the answer is due, its bounds hold what the finished work gives.
#[test]
fn bounds_of_a_late_answer_hold_the_finished_one() {
    let scenario = Scenario::open("../../config/scenarios/crossing.toml").unwrap();
    let mut engine = Engine::builder().in_process().build().unwrap();
    let whole = engine.rank(&scenario, &Limits::default()).unwrap().answer;
    let mut states = std::collections::BTreeSet::new();
    // However busy the machine is, the last is enough.
    let dues_ms = (0..120).map(|step| 0.002 * 1.08_f64.powi(step)).chain([60_000.0]);
    for due_ms in dues_ms {
        let limits = Limits::default().with_deadline_ms(due_ms).unwrap();
        let late = engine.rank(&scenario, &limits).unwrap().answer;
        states.insert(late.state.name());
        for row in &late.ranking {
            let complete = whole.ranking.iter().find(|whole| whole.name == row.name).unwrap();
            assert!(row.work.holds(complete.work), "{due_ms} ms: {} {row:#?}", row.name);
            // Contacts that are named are those of the finished work, in its order.
            for (now, then) in row.contacts.iter().zip(&complete.contacts) {
                assert_eq!((&now.party, now.time_s), (&then.party, then.time_s), "{due_ms} ms");
            }
            assert!(row.contacts.len() <= complete.contacts.len());
        }
        if late.state != AnswerState::Complete && late.state != AnswerState::Degraded {
            assert_eq!(late.ranking[0].name, whole.ranking[0].name, "{due_ms} ms");
        }
    }
    assert!(states.contains("complete") && states.len() > 1, "{states:?}");
}

mod shared_data {
    use super::shared;
    use trolley::traffic::{TrafficOptions, import};
    use trolley::{AnswerState, Engine, Limits, Scenario};

    /// "Go on, right 6" drives on into car 399: at an impact with its first opponent it touched
    /// nothing.
    #[test]
    #[ignore = "needs ../shared/data: recorded traffic"]
    fn who_is_met_later_is_met() {
        let path = shared("scenarios/commonroad/USA_US101-4_1_T-1.xml");
        let imported = import(&path, &TrafficOptions::default()).unwrap();
        let scenario = Scenario::parse("us101.toml", &imported.text).unwrap();
        let mut engine = Engine::builder().in_process().build().unwrap();
        let answer = engine.rank(&scenario, &Limits::default()).unwrap().answer;
        assert_eq!(answer.state, AnswerState::Complete);
        let row = answer.ranking.iter().find(|row| row.name == "go on, right 6").unwrap();
        let contact = &row.contacts[0];
        assert_eq!(contact.party, "car 399");
        assert!((contact.time_s - 1.7).abs() < 0.05, "{}", contact.time_s);
    }
}
