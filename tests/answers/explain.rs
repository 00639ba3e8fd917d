//! An explanation can be checked by hand: every figure follows from those before it in the text,
//! and the last ones are those of the answer.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use crate::support::{Place, json, run, text, ways};
use serde_json::Value;

fn near(value: &Value, expected: f64, what: &str) {
    let value = value.as_f64().unwrap();
    assert!(
        (value - expected).abs() <= 1e-9 + 1e-9 * expected.abs(),
        "{what}: {value}, {expected}"
    );
}

fn numbers(value: &Value) -> [f64; 2] {
    [value[0].as_f64().unwrap_or(0.0), value[1].as_f64().unwrap_or(0.0)]
}

/// Recomputes changes of velocity from speeds, masses and arms.
fn check_impact(chain: &Value) {
    let inverse = [0, 1].map(|i| chain["mass_kg"][i].as_f64().map_or(0.0, |m| 1.0 / m));
    let k = numbers(&chain["gyration_m"]);
    let arms = [numbers(&chain["arms_m"][0]), numbers(&chain["arms_m"][1])];
    let [e, mu] = numbers(&chain["surface"]);
    let sum = |of: &dyn Fn([f64; 2]) -> f64| -> f64 {
        (0..2).map(|i| of(arms[i].map(|arm| arm / k[i])) * inverse[i]).sum()
    };
    let reduced: f64 = 1.0 / inverse.iter().sum::<f64>();
    let v_n = chain["normal_m_s"].as_f64().unwrap();
    let v_t = chain["tangential_m_s"].as_f64().unwrap();
    let [k_nn, k_tt, k_nt] = if chain["long_face_of"].is_null() {
        [sum(&|[_, t]| 1.0 + t * t), sum(&|[n, _]| 1.0 + n * n), sum(&|[n, t]| -n * t)]
    } else {
        [1.0 / reduced, 1.0 / reduced, 0.0]
    };
    let wanted = (1.0 + e) * v_n;
    let [j_n, j_t] = if chain["origin"] == "graze" || chain["origin"] == "weak-part" {
        [0.0, 0.0]
    } else if chain["long_face_of"].is_null() {
        let d = k_nn * k_tt - k_nt * k_nt;
        let stick = [(wanted * k_tt - k_nt * v_t) / d, (k_nn * v_t - k_nt * wanted) / d];
        if stick[1].abs() <= mu * stick[0] {
            stick
        } else {
            let slid = wanted / (k_nn + v_t.signum() * mu * k_nt);
            [slid, v_t.signum() * mu * slid]
        }
    } else {
        [wanted * reduced, v_t.signum() * (mu * wanted).min(v_t.abs()) * reduced]
    };
    let (response, name) = (&chain["response"], chain["other"].as_str().unwrap());
    near(&response["normal_n_s"], j_n, name);
    near(&response["tangential_n_s"], j_t, name);
    for i in 0..2 {
        near(&response["delta_v_m_s"][i], j_n.hypot(j_t) * inverse[i], name);
    }
    let lost = j_n * v_n + j_t * v_t
        - 0.5 * (k_nn * j_n * j_n + 2.0 * k_nt * j_n * j_t + k_tt * j_t * j_t);
    near(&response["energy_j"], lost.max(0.0), name);
}

/// Recomputes a probability from a speed, by the curve that the explanation states.
fn check_person(person: &Value, curves: &[Value], chain: &Value) -> f64 {
    let curve = curves.iter().find(|curve| curve["id"] == person["curve"]).unwrap();
    let unit = match curve["unit"].as_str().unwrap() {
        "m/s" => 1.0,
        "km/h" => 3.6,
        "mph" => 1.0 / 0.447_04,
        other => panic!("{other}"),
    };
    let x = match person["x"].as_str().unwrap() {
        "delta-v" => {
            let ego = person["party"] == "ego";
            chain["response"]["delta_v_m_s"][usize::from(!ego)].as_f64().unwrap()
        }
        "closing-normal" => chain["normal_m_s"].as_f64().unwrap(),
        other => panic!("{other}"),
    };
    near(&person["x_m_s"], x, "x");
    let (a, b) = (curve["a"].as_f64().unwrap(), curve["b"].as_f64().unwrap());
    let height = 100.0 * person["front_m"].as_f64().unwrap();
    let tall = |x: f64| {
        let front = &curve["front"];
        if front.is_null() {
            return 0.0;
        }
        let term = |key: &str| front[key].as_f64().unwrap();
        let per_cm = term("per_cm") + term("per_cm_and_unit") * (unit * x - term("at"));
        per_cm.max(0.0) * (height - term("from_cm")).max(0.0)
    };
    let p = |x: f64| 1.0 / (1.0 + (-(a + b * unit * x + tall(x))).exp());
    near(&person["published"], p(x), "P(x)");
    near(&person["at_rest"], p(0.0), "P(0)");
    let harm = (p(x) - p(0.0)) / (1.0 - p(0.0));
    near(&person["harm"][1], harm, "H");
    assert!(curve["source"].as_str().unwrap().len() > 5 && curve["year"].as_u64().unwrap() > 1990);
    harm * chain["probability"].as_f64().unwrap()
}

/// Two walkers one behind the other, then a wall: the driver is in three contacts.
const THREE: &str = r#"
schema = "trolley.scenario/2"
name = "three"
members = 1
[parties.ego]
generate = { shape = "sedan", triangles = 900 }
persons = [{ seat = "front-left" }]
[parties.a]
generate = { shape = "pedestrian", triangles = 900 }
place = { position_m = [20, 0, 0] }
[parties.b]
generate = { shape = "pedestrian", triangles = 900 }
place = { position_m = [30, 0.3, 0] }
[parties.wall]
generate = { shape = "wall", triangles = 900 }
place = { position_m = [40, 0, 0], yaw_deg = 90 }
[[candidates]]
name = "go on"
state = { position_m = [0, 0, 0], speed_m_s = 15 }
[[candidates]]
name = "slower"
state = { position_m = [0, 0, 0], speed_m_s = 9 }
[[candidates]]
name = "stand"
state = { position_m = [0, 0, 0], speed_m_s = 0 }
"#;

#[test]
fn every_figure_follows_from_those_before_it() {
    let place = Place::new();
    let crossing = concat!(env!("CARGO_MANIFEST_DIR"), "/../../config/scenarios/crossing.toml");
    let three = place.write("three.toml", THREE);
    let (mut contacts, mut several) = (0, 0);
    for path in [crossing, three.to_str().unwrap()] {
        let output =
            run(&["rank", path, "--json", "--explain", "--workers", "2", "--members", "1"]);
        assert!(output.status.success(), "{}", text(&output.stderr));
        let document = json(&output);
        let explanation = &document["explanation"];
        let parameters = &explanation["parameters"];
        assert!(parameters["friction"]["nominal"].as_f64().is_some_and(|mu| mu > 0.0));
        let curves = explanation["curves"].as_array().unwrap();
        let persons = explanation["persons"].as_f64().unwrap();
        let rows = document["answer"]["ranking"].as_array().unwrap();
        let chains = explanation["chains"].as_array().unwrap();
        assert_eq!(chains.len(), rows.len());
        for (chain, row) in chains.iter().zip(rows) {
            assert_eq!((&chain["name"], &chain["why"]), (&row["name"], &row["why"]));
            // Contact by contact: from speeds to the risk of each person.
            let mut risks = Vec::new();
            let told = row["contacts"].as_array().unwrap();
            let steps = chain["contacts"].as_array().unwrap();
            assert_eq!(steps.len(), told.len());
            for (number, (contact, told)) in steps.iter().zip(told).enumerate() {
                assert_eq!(contact["other"], told["party"]);
                for same in ["time_s", "severity", "closing_m_s"] {
                    assert_eq!(contact[same], told[same], "{same}");
                }
                check_impact(contact);
                let heavy = contact["response"]["delta_v_m_s"][0].as_f64().unwrap()
                    >= explanation["heavy_from_m_s"].as_f64().unwrap();
                assert_eq!(contact["severity"], if heavy { "heavy" } else { "light" });
                assert_eq!(contact["counts"], true, "all is known");
                for person in contact["persons"].as_array().unwrap() {
                    let risk = check_person(person, curves, contact);
                    near(&person["risk"], risk, "R");
                    risks.push((number, [&person["party"], &person["seat"]], risk));
                }
                contacts += 1;
            }
            // Person by person: from the contacts to the risk that ranks.
            let mut all = Vec::new();
            for person in chain["persons"].as_array().unwrap() {
                let own = risks.iter().filter(|risk| risk.1 == [&person["party"], &person["seat"]]);
                let own: Vec<(usize, f64)> =
                    own.map(|(number, _, risk)| (*number, *risk)).collect();
                for (listed, (number, risk)) in
                    person["contacts"].as_array().unwrap().iter().zip(&own)
                {
                    assert_eq!(listed[0], *number);
                    near(&listed[1], *risk, "R of a contact");
                }
                assert_eq!(person["contacts"].as_array().unwrap().len(), own.len());
                let risk = 1.0 - own.iter().map(|(_, risk)| 1.0 - risk).product::<f64>();
                near(&person["risk"][1], risk, "1 - Π(1 - R)");
                several += u32::from(own.len() > 1);
                all.push(risk);
            }
            assert_eq!(row["persons"].as_array().unwrap().len(), all.len());
            // And the policy's first step.
            assert_eq!(chain["steps"][0]["step"], "least bayes");
            let said = chain["steps"][0]["value"][1].as_f64().unwrap();
            let bayes = all.iter().sum::<f64>() / persons;
            assert!((said - bayes).abs() < 2e-8, "{said} {bayes}");
            assert_eq!(chain["steps"][0]["value"], row["work"]);
        }
        let stability = &explanation["stability"];
        let winner = stability["winner"].as_u64().unwrap() as usize;
        assert_eq!(explanation["names"][winner], rows[0]["name"]);
        assert!(stability["reserves"].as_array().unwrap().len() > 2 * curves.len());
        // What is not requested is not told.
        let bare = run(&["rank", path, "--json", "--in-process", "--members", "1"]);
        assert_eq!(json(&bare)["explanation"], Value::Null);
    }
    assert!(contacts >= 7 && several >= 2, "{contacts} contacts, {several} persons in several");
    let output = run(&["rank", three.to_str().unwrap(), "--explain", "--in-process"]);
    let words = text(&output.stdout);
    let from = words.find("How the order came about").unwrap();
    assert!(words[from..].lines().all(|line| line.chars().count() <= 100), "{words}");
    for said in ["Lubbe et al.", "J_n", "together  ego front-left: 0.", "heavy"] {
        assert!(words[from..].contains(said), "{said}: {words}");
    }
}

#[test]
fn an_explanation_in_words_fits_the_terminal_and_names_every_source() {
    let place = Place::new();
    let path = place.write("ways.toml", &ways(800));
    let output = run(&["rank", path.to_str().unwrap(), "--explain", "--in-process"]);
    let words = text(&output.stdout);
    let from = words.find("How the order came about").unwrap();
    for line in words[from..].lines() {
        assert!(line.chars().count() <= 100, "{line}");
    }
    for said in ["Lubbe et al.", "What would flip the winner", "J_n", "v_n", "H 0."] {
        assert!(words[from..].contains(said), "{said}");
    }
}

#[test]
fn parts_and_zones_of_what_was_hit_are_named() {
    let place = Place::new();
    let path = place.write("ways.toml", &ways(800));
    let output = run(&["rank", path.to_str().unwrap(), "--json", "--in-process"]);
    let document = json(&output);
    let rows = document["answer"]["ranking"].as_array().unwrap();
    let contacts = rows.iter().flat_map(|row| row["contacts"].as_array().unwrap());
    let contacts: Vec<&Value> = contacts.collect();
    assert!(contacts.len() >= 5, "{} contacts are too few to tell", contacts.len());
    for row in contacts {
        for side in 0..2 {
            let parts = row["parts"][side].as_array().unwrap();
            assert!(!parts.is_empty(), "{}", row["party"]);
            // What is hit from f to e is the union of what is hit at the poses between.
            let key = ["hits_a", "hits_b"][side];
            let poses = row["poses"].as_array().unwrap();
            let at: Vec<u64> = poses.iter().map(|pose| pose[key].as_u64().unwrap()).collect();
            let (most, sum) = (at.iter().max().copied().unwrap_or(0), at.iter().sum::<u64>());
            let all = row["hits"][side].as_u64().unwrap();
            assert!((most..=sum).contains(&all), "{}: {all} of {at:?}", row["party"]);
        }
    }
}

/// A party of unknown kind is refused, or taken as fixed, and the answer says so.
#[test]
fn an_unknown_party_is_refused_unless_it_may_be_taken_as_fixed() {
    let place = Place::new();
    let good = ways(600);
    let unknown = good.replace("[parties.wall]", "[parties.wall]\nkind = \"unknown\"");
    let path = place.write("unknown.toml", &unknown);
    let path = path.to_str().unwrap();
    let output = run(&["rank", path, "--in-process"]);
    let error = text(&output.stderr);
    assert_eq!(output.status.code(), Some(4), "{error}");
    for said in ["unknown.toml:", "\"wall\" is of unknown kind", "--assume unknown=fixed"] {
        assert!(error.contains(said), "{error}");
    }
    let output = run(&["rank", path, "--in-process", "--json", "--assume", "unknown=fixed"]);
    let document = json(&output);
    let assumed = document["answer"]["assumptions"].as_array().unwrap();
    let said = |of: &Value| of.as_str().unwrap().contains("\"wall\" is of unknown kind");
    assert!(assumed.iter().any(said), "{assumed:?}");
    let moving = good.replace("[parties.suv]", "[parties.suv]\nkind = \"unknown\"");
    let path = place.write("moving.toml", &moving);
    let args = ["rank", path.to_str().unwrap(), "--in-process", "--assume", "unknown=fixed"];
    let output = run(&args);
    let error = text(&output.stderr);
    assert_eq!(output.status.code(), Some(65), "{error}");
    assert!(error.contains("moves") && error.contains("help"), "{error}");
}
