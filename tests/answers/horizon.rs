//! Rankings against what is known otherwise: crashes written early and late, and finished work.

use crate::support::shared;
use trolley::{AnswerState, CourseRow, Engine, Limits, Scenario};

/// A crash as the first examples had it, at the impact or near it: heading and speed of the ego at
/// the origin; who else, where (x, y, heading), and how fast.
type Crash = ([f64; 2], &'static str, [f64; 3], f64);

/// Metres, degrees, m/s.
const CRASHES: [Crash; 13] = [
    ([0.0, 10.0], "wall", [3.0, 1.2, 4.0], 0.0),
    ([0.0, 16.0], "suv", [4.65, 0.3, 0.0], 8.0),
    ([0.0, 13.0], "sedan", [3.18, 0.4, -90.0], 6.0),
    ([0.0, 12.0], "pedestrian", [2.5, 0.35, 90.0], 1.4),
    ([0.0, 10.0], "wall", [2.55, 0.0, 90.0], 0.0),
    ([0.0, 10.0], "pole", [2.4, 0.3, 0.0], 0.0),
    ([0.0, 4.0], "cyclist", [2.51, 1.14, 115.0], 7.0),
    ([8.0, 10.0], "wall", [3.0, 1.38, 0.0], 0.0),
    ([3.0, 13.0], "sedan", [4.5, 0.8, 180.0], 12.0),
    ([-12.0, 13.0], "pole", [2.3, -0.6, 0.0], 0.0),
    ([0.0, 13.0], "truck", [7.0, 0.8, 180.0], 12.0),
    ([0.0, 11.0], "motorcycle", [3.2, 0.1, 150.0], 9.0),
    ([0.0, 4.0], "cyclist", [2.51, 0.9, 115.0], 7.0),
];

/// A crash, written so much time earlier (s).
fn text(([heading, ego], shape, [x, y, yaw], other): Crash, earlier_s: f64) -> String {
    let back = |degrees: f64, speed: f64| {
        let (sin, cos) = degrees.to_radians().sin_cos();
        [-speed * cos * earlier_s, -speed * sin * earlier_s]
    };
    let ([a, b], [c, d]) = (back(heading, ego), back(yaw, other));
    let (x, y) = (x + c, y + d);
    let body = |shape: &str| format!("generate = {{ shape = \"{shape}\", triangles = 2000 }}");
    let motion = if other == 0.0 {
        format!("place = {{ position_m = [{x:?}, {y:?}, 0], yaw_deg = {yaw:?} }}")
    } else {
        format!(
            "state = {{ position_m = [{x:?}, {y:?}, 0], yaw_deg = {yaw:?}, speed_m_s = {other:?} }}"
        )
    };
    format!(
        "schema = \"trolley.scenario/2\"\nname = \"early\"\nmembers = 1\nhorizon_s = 30\n\
         [parties.ego]\n{}\n\
         [parties.other]\n{}\n{motion}\n[[candidates]]\nname = \"go on\"\nstate = {{ position_m = \
         [{a:?}, {b:?}, 0], yaw_deg = {heading:?}, speed_m_s = {ego:?} }}\n",
        body("sedan"),
        body(shape)
    )
}

/// Whatever the distance before contact at which a crash is written down, it is the same crash.
#[test]
fn every_crash_is_found_however_early_it_is_written() {
    let mut engine = Engine::builder().in_process().build().unwrap();
    let mut row_of = |crash: Crash, earlier_s: f64| -> CourseRow {
        let scenario = Scenario::parse("early.toml", &text(crash, earlier_s)).unwrap();
        let answer = engine.rank(&scenario, &Limits::default()).unwrap().answer;
        assert_eq!(answer.state, AnswerState::Complete, "{crash:?}");
        answer.ranking.into_iter().next().unwrap()
    };
    let mut crashes = 0;
    for crash in CRASHES {
        // Three seconds before, everybody is apart.
        const FAR_S: f64 = 3.0;
        let far = row_of(crash, FAR_S);
        let Some(first) = far.contacts.first() else {
            assert!(far.touches_nobody(), "{far:#?}");
            continue;
        };
        for before_m in [0.2, 1.0, 3.7, 9.0, 20.0] {
            let contact_s = before_m / first.closing_m_s;
            let earlier_s = FAR_S - first.first_touch_s + contact_s;
            let now = row_of(crash, earlier_s);
            let place = format!("{crash:?}, {before_m} m before");
            assert_eq!(now.contacts.len(), far.contacts.len(), "{place}");
            let contact = &now.contacts[0];
            assert!(!contact.is_at_start, "{place}");
            // A light touch at first may become the crash a little later.
            let crash_s = first.time_s - first.first_touch_s;
            for off_s in [contact.first_touch_s, contact.time_s - crash_s].map(|s| s - contact_s) {
                assert!(off_s.abs() < 1e-6, "{place}: {off_s} s off");
            }
            assert_eq!(contact.persons.len(), first.persons.len(), "{place}");
            for (now, then) in contact.persons.iter().zip(&first.persons) {
                assert_eq!((&now.party, now.seat), (&then.party, then.seat), "{place}");
                let (now, then) = (now.work.hi(), then.work.hi());
                assert!((now - then).abs() <= 1e-3 * then, "{place}: {then} and {now}");
            }
            crashes += 1;
        }
    }
    assert!(crashes >= 60, "{crashes}");
}

/// However early the answer is due, its bounds hold what the finished work gives.
#[test]
fn bounds_of_a_late_answer_hold_the_finished_one() {
    let scenario = Scenario::open("../../config/scenarios/crossing.toml").unwrap();
    let mut engine = Engine::builder().in_process().build().unwrap();
    // Parts of the members are no bounds on the mean over all.
    let as_stated = Limits::default().with_members(1, None).unwrap();
    let whole = engine.rank(&scenario, &as_stated).unwrap().answer;
    let mut states = std::collections::BTreeSet::new();
    // However busy the machine is, the last is enough.
    let dues_ms = (0..120).map(|step| 0.002 * 1.08_f64.powi(step)).chain([60_000.0]);
    for due_ms in dues_ms {
        let limits = as_stated.with_deadline_ms(due_ms).unwrap();
        let late = engine.rank(&scenario, &limits).unwrap().answer;
        states.insert(late.state.name());
        for row in &late.ranking {
            let complete = whole.ranking.iter().find(|whole| whole.name == row.name).unwrap();
            assert!(row.work.holds(complete.work), "{due_ms} ms: {} {row:#?}", row.name);
            // Contacts that are named are those of the finished work, in its order. One whose
            // survey is open may still turn out to be a light touch before the crash.
            for (now, then) in row.contacts.iter().zip(&complete.contacts) {
                let touches = [now.first_touch_s, then.first_touch_s];
                assert_eq!(now.party, then.party, "{due_ms} ms");
                assert_eq!(touches[0], touches[1], "{due_ms} ms");
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
        let answer = engine
            .rank(&scenario, &Limits::default().with_members(1, None).unwrap())
            .unwrap()
            .answer;
        assert_eq!(answer.state, AnswerState::Complete);
        let row = answer.ranking.iter().find(|row| row.name == "go on, right 6").unwrap();
        let contact = &row.contacts[0];
        assert_eq!(contact.party, "car 399");
        assert!((contact.time_s - 1.7).abs() < 0.05, "{}", contact.time_s);
    }
}
