//! A file says the same as states in the scenario, and a fault in it stands at its line.

use super::super::{Motion, ScenarioDraft};
use super::*;
use proptest::prelude::*;

const PLAIN: &str = "t_s,x_m,y_m,yaw_deg\n0,0,0,0\n1,10,0,5\n2,20,1,10\n";

fn refused(text: &str) -> ScenarioError {
    match CsvStates::parse("car.csv", text) {
        Ok(states) => states.error(super::super::path::through(&states.rows, 5.0).unwrap_err()),
        Err(error) => error,
    }
}

#[test]
fn columns_stand_in_any_order_among_remarks_and_blanks() {
    let rows = |text: &str| CsvStates::parse("f", text).unwrap().rows;
    let plain = rows(PLAIN);
    for text in [
        "yaw_deg,t_s,y_m,x_m\n0,0,0,0\n5,1,0,10\n10,2,1,20",
        "# a remark\n\n t_s , x_m,\ty_m , yaw_deg \r\n 0,0,0,0\r\n  # another\n1,10.0,0,5e0\n\n\
         2,+20,1,10\r\n",
        "\u{feff}t_s,x_m,y_m,yaw_deg,z_m,roll_deg\n0,0,0,0,0,0\n1,10,-0,5,0,0\n2,20,1,10,0,-0.0\n",
    ] {
        assert_eq!(rows(text), plain, "{text}");
    }
    let all = "t_s,x_m,y_m,yaw_deg,z_m,pitch_deg,roll_deg,vx_m_s,vy_m_s\n0,1,2,3,4,5,6,7,8\n";
    let row = GivenState {
        time_s: 0.0,
        position_m: [1.0, 2.0, 4.0],
        angles_deg: [3.0, 5.0, 6.0],
        velocity_m_s: Some([7.0, 8.0]),
    };
    assert_eq!(rows(all), [row]);
}

#[test]
fn every_fault_stands_at_its_line() {
    let with = |from: &str, to: &str| {
        assert!(PLAIN.contains(from), "{from}");
        PLAIN.replacen(from, to, 1)
    };
    let cases = [
        (String::new(), "1:1: the file is empty"),
        ("# nothing\n\n".to_owned(), "1:1: the file is empty"),
        (with("t_s,", "t,"), "1:1: column \"t\" is not known"),
        (with("x_m,y_m", "x_m,"), "1:9: column \"\" is not known"),
        (with("y_m", "x_m"), "1:9: column x_m stands twice"),
        (with(",yaw_deg", ""), "1:1: column yaw_deg is missing"),
        (with("yaw_deg", "yaw_deg,vx_m_s"), "1:1: column vy_m_s is missing"),
        (with("1,10,0,5", "1,10,0"), "3:6: 3 values stand under 4 columns"),
        (with("1,10,0,5", "1,10,0,5,"), "3:8: 5 values stand under 4 columns"),
        (with("1,10,0,5", "1, ten,0,5"), "3:4: x_m is \"ten\", not a number"),
        (with("1,10,0,5", "1,,0,5"), "3:3: x_m is \"\", not a number"),
        (with("1,10,0,5", "1,10,nan,5"), "3:6: y_m is NaN"),
        (with("1,10,0,5", "1,inf,0,5"), "3:3: x_m is inf"),
        (with("1,10,0,5", "1,1e7,0,5"), "3:3: x_m is 10000000"),
        (with("1,10,0,5", "1,10,0,361"), "3:8: yaw_deg is 361"),
        (with("1,10,0,5", "5000,10,0,5"), "3:1: t_s is 5000"),
        (with("1,10,0,5", "0,10,0,5"), "3:1: t_s is 0, after 0 in the state before"),
        (with("2,20,1,10", "2,220,1,10"), "4:3: from 1 s to 2 s the body would move at 210 m/s"),
        (with("0,0,0,0\n", ""), "2:1: the path begins at 1 s"),
        ("t_s,x_m,y_m,yaw_deg\n".to_owned(), "1:1: the path has no state"),
        ("t_s,x_m,y_m,yaw_deg\n0,0,0,0\n".to_owned(), "a path of one state does not say"),
        (
            "t_s,x_m,y_m,yaw_deg,vy_m_s,vx_m_s\n0,0,0,0,80,80".to_owned(),
            "2:12: vx_m_s and vy_m_s is 113",
        ),
        (
            "t_s,x_m,y_m,yaw_deg,vx_m_s,vy_m_s\n0,0,0,0,60,0\n1,1,0,0,1,0".to_owned(),
            "2:9: the velocity is [60, 0] m/s",
        ),
        ("é".repeat(600_000), "1:1: 1200000 bytes are too many for a path"),
    ];
    for (text, fault) in cases {
        let error = refused(&text);
        assert!(error.to_string().starts_with("car.csv:"), "{error}");
        assert!(error.to_string().contains(fault), "{fault}: {error}");
        assert!(!error.remedy.is_empty() && !error.to_string().contains('\n'), "{error}");
    }
}

#[test]
fn the_number_of_states_is_bounded() {
    let text = |count: usize| {
        let line = |i: usize| format!("{:.4},{i},0,0\n", 0.1 * i as f64);
        format!("t_s,x_m,y_m,yaw_deg\n{}", (0..count).map(line).collect::<String>())
    };
    assert_eq!(CsvStates::parse("f", &text(4096)).unwrap().rows.len(), 4096);
    let error = refused(&text(4097));
    assert_eq!((error.place.line, error.what.contains("4096")), (4098, true), "{error}");
}

/// A scenario whose only candidate is this path.
fn motion(path: &str, csv: &str) -> Result<Motion, ScenarioError> {
    let text = format!(
        "schema = 'trolley.scenario/2'\nname = 'n'\n[parties]\nego = {{ file = 'e' }}\n\
         b = {{ file = 'b', place = {{ position_m = [0, 0, 0] }} }}\n[[candidates]]\nname = 'c'\n\
         path = {path}\n"
    );
    let draft = ScenarioDraft::parse("folder/f.toml", &text)?;
    let scenario = draft.finish(|_| Ok::<_, ScenarioError>(csv.to_owned()))?;
    Ok(scenario.candidates[0].ego.clone())
}

#[test]
fn the_file_is_named_as_the_scenario_names_it_from_its_own_folder() {
    let error = motion("{ csv = 'paths/car.csv' }", "t_s\n").unwrap_err();
    assert_eq!(error.file, "folder/paths/car.csv");
    let error = motion("{ csv = '/data/car.csv' }", "t_s\n").unwrap_err();
    assert_eq!(error.file, "/data/car.csv");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn a_file_gives_the_path_that_the_same_states_give(
        steps in prop::collection::vec(
            (0.2..1.0_f64, [-0.3..0.3_f64, -0.3..0.3, -0.3..0.3], [-20.0..20.0_f64, -20.0..20.0,
                -20.0..20.0]),
            2..30,
        ),
    ) {
        let mut time_s = -0.15;
        let mut states = String::new();
        let mut csv = "roll_deg,t_s,x_m,y_m,z_m,vx_m_s,yaw_deg,pitch_deg,vy_m_s\n".to_owned();
        for (step_s, [x, y, z], [yaw, pitch, roll]) in steps {
            states += &format!(
                "{{ t_s = {time_s:?}, position_m = [{x:?}, {y:?}, {z:?}], yaw_deg = {yaw:?}, \
                 pitch_deg = {pitch:?}, roll_deg = {roll:?}, velocity_m_s = [{x:?}, {y:?}] }}, "
            );
            csv += &format!(
                "{roll:?},{time_s:?},{x:?},{y:?},{z:?},{x:?},{yaw:?},{pitch:?},{y:?}\n"
            );
            time_s += step_s;
        }
        let inline = motion(&format!("{{ states = [{states}] }}"), "").unwrap();
        let from_file = motion("{ csv = 'f.csv' }", &csv).unwrap();
        prop_assert_eq!((inline.path, inline.ends_s), (from_file.path, from_file.ends_s));
    }

    #[test]
    fn no_file_makes_it_panic(
        cells in prop::collection::vec("[-+0-9.einfa, \t\r\n#\"é]{0,12}", 0..20),
        at in 0..PLAIN.len(),
        any_text in any::<String>(),
    ) {
        for text in [
            format!("t_s,x_m,y_m,yaw_deg\n{}", cells.join(",")),
            format!("{}{}{}", &PLAIN[..at], cells.concat(), &PLAIN[at..]),
            any_text,
        ] {
            if let Err(error) = motion("{ csv = 'f.csv' }", &text) {
                let lines = text.lines().count().max(1);
                prop_assert!((1..=lines).contains(&error.place.line), "{}", error);
                prop_assert_eq!(error.to_string().lines().count(), 1);
            }
        }
    }
}
