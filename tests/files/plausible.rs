//! What is allowed and hardly true is said beside the winner, refused with `--strict`, and the same
//! in a replay.

use crate::support::service::{deployment, of_ways, serve};
use crate::support::{Place, json, run, text, ways};

/// A lorry of 25 kg, in one of six ways.
fn light_lorry() -> String {
    ways(600).replace("[parties.truck]", "[parties.truck]\nmass_kg = 25")
}

// verifies REQ-PLAUSIBLE
#[test]
fn a_lorry_of_25_kg_is_named_beside_the_winner_and_refused_when_strict() {
    let place = Place::new();
    let path = place.write("crash.toml", &light_lorry());
    let file = path.to_str().unwrap();
    let said = "\"truck\" weighs 25 kg, a truck 1000 to 60000 kg: is it in tonnes?";

    let told = run(&["rank", file, "--in-process"]);
    let table = text(&told.stdout);
    assert_eq!(told.status.code(), Some(0), "{}", text(&told.stderr));
    assert!(table.contains(&format!("IMPLAUSIBLE: {said}")), "{table}");
    let row = table.lines().skip_while(|line| !line.starts_with("1 ")).nth(1).unwrap();
    assert!(row.contains("! implausible"), "beside the winner: {table}");

    let document = json(&run(&["rank", file, "--in-process", "--json"]));
    assert_eq!(document["answer"]["implausible"][0]["party"], "truck");
    assert_eq!(document["answer"]["implausible"][0]["says"], said);

    let refused = run(&["rank", file, "--in-process", "--strict"]);
    assert_eq!(refused.status.code(), Some(4));
    assert!(refused.stdout.is_empty(), "no winner: {}", text(&refused.stdout));
    let error = text(&refused.stderr);
    assert!(error.contains("crash.toml") && error.contains(said), "{error}");
    assert!(error.contains("help: "), "{error}");

    let plausible = place.write("true.toml", &ways(600));
    let told = run(&["rank", plausible.to_str().unwrap(), "--in-process", "--strict"]);
    assert_eq!(told.status.code(), Some(0), "{}", text(&told.stderr));
    assert!(!text(&told.stdout).contains("mplausible"), "{}", text(&told.stdout));
}

#[test]
fn a_winner_that_comes_near_nobody_is_doubted() {
    let place = Place::new();
    let far = ways(600).replace("[3, 0, 0]", "[0, 0, 0]").replace(
        "name = \"stop\"\npath = { states = [{ t_s = 0, position_m = [0, 0, 0] }, \
         { t_s = 1, position_m = [8, 0, 0] }, { t_s = 2, position_m = [10, 0, 0] }, \
         { t_s = 2.1, position_m = [10, 0, 0] } ] }",
        "name = \"back\"\nstate = { position_m = [0, 0, 0], velocity_m_s = [-13, 0] }",
    );
    assert!(far.contains("\"back\""), "{far}");
    // Backwards it comes no nearer than it is at the start, where a pole is 13 m away.
    let far = far.replace("[15.0, 4.0, 0]", "[35.0, 4.0, 0]");
    let path = place.write("far.toml", &far);
    let document = json(&run(&["rank", path.to_str().unwrap(), "--in-process", "--json"]));
    let answer = &document["answer"];
    assert_eq!(answer["ranking"][0]["name"], "back", "{answer}");
    assert_eq!(answer["implausible"][0]["candidate"], "back", "{answer}");
}

#[test]
fn a_replay_says_the_same() {
    let place = Place::new();
    let path = place.write("crash.toml", &light_lorry());
    let folder = place.path().join("decisions");
    let folder = folder.to_str().unwrap();
    run(&["rank", path.to_str().unwrap(), "--in-process", "--record", folder]);
    let replayed = crate::support::trolley()
        .args(["record", "replay", folder])
        .spawn()
        .unwrap()
        .wait_with_output()
        .unwrap();
    let (out, error) = (text(&replayed.stdout), text(&replayed.stderr));
    assert_eq!(replayed.status.code(), Some(0), "{error}");
    assert!(out.contains("bit for bit"), "{out}");
}

/// The client says it: a service has no notes, and neither does its answer.
#[test]
fn a_query_says_what_is_hardly_true_as_rank_does() {
    let place = Place::new();
    let scenario = place.write("crash.toml", &light_lorry());
    let file = scenario.to_str().unwrap();
    let doubts = |output: &std::process::Output| {
        let document = json(output);
        let answer = document.get("answer").unwrap_or(&document);
        (answer["implausible"].clone(), answer["ranking"][0]["name"].clone())
    };
    let ranked = doubts(&run(&["rank", file, "--in-process", "--json"]));
    assert_eq!(ranked.0[0]["party"], "truck");

    let serving = serve(&deployment(&place, 2, &of_ways(600)), &[]);
    assert_eq!(doubts(&serving.query(&scenario, &["--json"])), ranked);
    let table = text(&serving.query(&scenario, &[]).stdout);
    let said = "IMPLAUSIBLE: \"truck\" weighs 25 kg, a truck 1000 to 60000 kg: is it in tonnes?";
    assert!(table.contains(said), "{table}");
    let row = table.lines().skip_while(|line| !line.starts_with("1 ")).nth(1).unwrap();
    assert!(row.contains("! implausible"), "beside the winner: {table}");
    let members = text(&serving.query(&scenario, &["--members", "4"]).stdout);
    assert!(members.contains(said) && members.contains("! implausible"), "{members}");

    let plausible = place.write("true.toml", &ways(600));
    let table = text(&serving.query(&plausible, &[]).stdout);
    assert!(table.contains("COMPLETE") && !table.contains("mplausible"), "{table}");
    assert!(json(&serving.query(&plausible, &["--json"])).get("implausible").is_none());
    serving.end();
}
