//! Rankings over a horizon against what is known otherwise: crashes written at impact, and finished
//! work.

use crate::support::shared;
use scenario::{MotionState, Party, Source};
use trolley::{AnswerState, Engine, Horizon, Limits, References, Row, Scenario, Touch};

/// A party as a table of a scenario over a horizon, but for its motion.
fn table(name: &str, party: &Party, row: &Row) -> String {
    let Source::Generate { shape, triangles, seed } = &party.source else {
        panic!("the examples generate their bodies")
    };
    let shape = shape.name();
    let mut text = format!(
        "[parties.{name}]\ngenerate = {{ shape = \"{shape}\", triangles = {triangles}, seed = \
         {seed} }}\n"
    );
    if let Some(mass_kg) = party.mass_kg {
        text += &format!("mass_kg = {mass_kg:?}\n");
    }
    if let Some([a_n_m, b_n_m2]) = party.crush {
        text += &format!("crush = {{ a_n_m = {a_n_m:?}, b_n_m2 = {b_n_m2:?} }}\n");
    }
    let aboard = row.persons.iter().filter(|person| *person.party == *party.name);
    let persons: Vec<String> = aboard
        .map(|person| person.seat.map_or("{}".into(), |seat| format!("{{ seat = \"{seat}\" }}")))
        .collect();
    let is_fixed = ["wall", "pole", "building"].contains(&shape);
    if !persons.is_empty() {
        text += &format!("persons = [{}]\n", persons.join(", "));
    } else if !is_fixed {
        text += "empty = true\n";
    }
    text
}

/// A state as it was some time earlier (s).
fn state(key: &str, at: &MotionState, earlier_s: f64) -> String {
    let [x, y, z] = at.pose.translation;
    let [vx, vy, _] = at.velocity_m_s.to_array();
    let [yaw, pitch, roll] = at.angles_deg;
    let position = format!("[{:?}, {:?}, {z:?}]", x - vx * earlier_s, y - vy * earlier_s);
    let angles = format!("yaw_deg = {yaw:?}, pitch_deg = {pitch:?}, roll_deg = {roll:?}");
    if [vx, vy] == [0.0; 2] {
        return format!("place = {{ position_m = {position}, {angles} }}\n");
    }
    format!("{key} = {{ position_m = {position}, {angles}, velocity_m_s = [{vx:?}, {vy:?}] }}\n")
}

/// Whatever the distance at which a crash is written down, it is the same crash: that which the
/// form at impact finds from there on.
#[test]
fn every_crash_of_the_examples_is_found_however_early_it_is_written() {
    let mut crashes = 0;
    for example in ["small", "minimal", "demo"] {
        let at_impact = Scenario::open(format!("../../config/scenarios/{example}.toml")).unwrap();
        let mut engine = Engine::builder().in_process().build().unwrap();
        let answer = engine.rank(&at_impact, &Limits::default()).unwrap().answer;
        let parsed = at_impact.parsed();
        for candidate in &parsed.candidates {
            let name = format!("{example}, {}", candidate.name);
            let row = answer.ranking.iter().find(|row| *row.name == *candidate.name).unwrap();
            let other = &parsed.parties[candidate.other.party.0];
            for before_m in [0.2, 1.0, 3.7, 9.0, 20.0] {
                // Before contact, or before what is given if there is none.
                let patch = row.contact.patch.as_ref();
                let first_m = patch.map_or(0.0, |patch| patch.first_m.hi());
                let contact_s = before_m / row.closing_m_s;
                let earlier_s = contact_s - first_m / row.closing_m_s;
                let text = format!(
                    "schema = \"trolley.scenario/2\"\nname = \"early\"\nhorizon_s = 30\n{}{}{}\
                     [[candidates]]\nname = \"go on\"\n{}",
                    table("ego", &parsed.parties[parsed.ego.0], row),
                    table("other", other, row),
                    state("state", &candidate.other.state, earlier_s),
                    state("state", &candidate.ego, earlier_s).replace("place = ", "state = ")
                );
                let horizon = Horizon::parse_with("early.toml", &text, References::Inside);
                let horizon = horizon.unwrap_or_else(|error| panic!("{name}: {error}\n{text}"));
                let ranking = engine.rank_horizon(&horizon, &Limits::default()).unwrap();
                assert_eq!(ranking.answer.state, AnswerState::Complete, "{name}");
                let found = &ranking.answer.ranking[0];
                if row.contact.touch == Touch::No {
                    assert!(found.touches_nobody(), "{name}, {before_m} m before: {found:#?}");
                    continue;
                }
                let [contact] = found.contacts.as_slice() else {
                    panic!("{name}, {before_m} m before: {found:#?}")
                };
                let off_s = contact.time_s - contact_s;
                assert!(off_s.abs() < 1e-6, "{name}, {before_m} m before: {off_s} s off");
                for person in &row.persons {
                    let is_ego = person.party == *parsed.parties[parsed.ego.0].name;
                    let same = |other: &&trolley::PersonRow| {
                        (other.party == "ego") == is_ego && other.seat == person.seat
                    };
                    let now = contact.persons.iter().find(same).unwrap().work.hi();
                    let then = person.work.hi();
                    assert!((now - then).abs() <= 1e-3 * then, "{name}: {then} and {now}");
                }
                crashes += 1;
            }
        }
    }
    assert!(crashes >= 60, "{crashes}");
}

/// However early the answer is due, its bounds hold what the finished work gives.
#[test]
fn bounds_of_a_late_answer_hold_the_finished_one() {
    let horizon = Horizon::open("../../config/scenarios/crossing.toml").unwrap();
    let mut engine = Engine::builder().in_process().build().unwrap();
    let whole = engine.rank_horizon(&horizon, &Limits::default()).unwrap().answer;
    let mut states = std::collections::BTreeSet::new();
    // However busy the machine is, the last is enough.
    let dues_ms = (0..120).map(|step| 0.002 * 1.08_f64.powi(step)).chain([60_000.0]);
    for due_ms in dues_ms {
        let limits = Limits::default().with_deadline_ms(due_ms).unwrap();
        let late = engine.rank_horizon(&horizon, &limits).unwrap().answer;
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
    use trolley::{AnswerState, Engine, Horizon, Limits, References};

    /// "Go on, right 6" drives on into car 399: at an impact with its first opponent it touched
    /// nothing.
    #[test]
    #[ignore = "needs ../shared/data: recorded traffic"]
    fn who_is_met_later_is_met() {
        let path = shared("scenarios/commonroad/USA_US101-4_1_T-1.xml");
        let imported = import(&path, &TrafficOptions::default()).unwrap();
        let text = imported.horizon_text.unwrap();
        let horizon = Horizon::parse_with("us101.toml", &text, References::Inside).unwrap();
        let mut engine = Engine::builder().in_process().build().unwrap();
        let answer = engine.rank_horizon(&horizon, &Limits::default()).unwrap().answer;
        assert_eq!(answer.state, AnswerState::Complete);
        let row = answer.ranking.iter().find(|row| row.name == "go on, right 6").unwrap();
        let contact = &row.contacts[0];
        assert_eq!(contact.party, "car 399");
        assert!((contact.time_s - 1.7).abs() < 0.05, "{}", contact.time_s);
    }
}
