//! Scenarios and deployments name files of their own folders alone, unless the user allows others.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use crate::support::service::shipped;
use crate::support::{Place, instance, text, trolley, ways};
use crate::traffic::crossing;
use std::path::Path;
use std::process::Output;
use trolley::{Engine, Limits, References, Scenario, SourceText, Texts};

const EGO: &str = "generate = { shape = \"sedan\", triangles = 600 }";

fn utf8(path: &Path) -> &str {
    path.to_str().unwrap()
}

fn ended(args: &[&str]) -> Output {
    trolley().args(args).output().unwrap()
}

/// A folder `own` for scenarios, beside `policy.toml`, `curves.toml` and `ego.trolley`; in it the
/// links `away` to all of these, and `policy.toml` to a policy.
fn laid_out() -> Place {
    let place = Place::new();
    let own = place.path().join("own");
    std::fs::create_dir(&own).unwrap();
    for (name, from) in [
        ("policy", "config/policies"),
        ("curves", "config/curves"),
        ("parameters", "config/parameters"),
    ] {
        let from = shipped(from).join("default.toml");
        std::fs::copy(from, place.path().join(format!("{name}.toml"))).unwrap();
    }
    let ego = place.path().join("ego.trolley");
    let made = ["model", "generate", "sedan", "--triangles", "600", "-o", utf8(&ego)];
    assert!(ended(&made).status.success());
    std::os::unix::fs::symlink("..", own.join("away")).unwrap();
    std::os::unix::fs::symlink("../policy.toml", own.join("policy.toml")).unwrap();
    place
}

/// A scenario that names a file, and the key with which it does.
fn naming(place: &Place, key: &str, path: &str) -> String {
    let line = format!("{key} = \"{path}\"");
    let scenario = match key {
        "file" => ways(600).replacen(EGO, &line, 1),
        _ => ways(600).replacen("[parties.ego]", &format!("{line}\n[parties.ego]"), 1),
    };
    let at = place.path().join("own/scenario.toml");
    std::fs::write(&at, scenario).unwrap();
    utf8(&at).to_owned()
}

/// Keys, and paths with which they lead out.
fn leading_out(place: &Place) -> Vec<(&'static str, String)> {
    let absolute = |name: &str| utf8(&place.path().join(name)).to_owned();
    vec![
        ("policy", "../policy.toml".to_owned()),
        ("policy", "away/policy.toml".to_owned()),
        ("policy", "policy.toml".to_owned()),
        ("policy", absolute("policy.toml")),
        ("curves", "../own/../curves.toml".to_owned()),
        ("parameters", "../parameters.toml".to_owned()),
        ("file", "../ego.trolley".to_owned()),
        ("file", "away/ego.trolley".to_owned()),
        ("file", absolute("ego.trolley")),
    ]
}

#[test]
fn what_leads_out_of_the_folder_is_refused_unless_it_is_allowed() {
    let place = laid_out();
    let deployment = shipped("config/deployments/minimal.toml");
    for (key, path) in leading_out(&place) {
        let scenario = naming(&place, key, &path);
        let name = instance();
        let plan = place.path().join("plan.toml");
        let faults = "schema = \"trolley.faults/1\"\nscenario = \"own/scenario.toml\"\n\
                      asked = \"own/scenario.toml\"\nworkers = 1\ndepth = 4\nat_once = 1\n\
                      [faults]\nkill = 0\n";
        std::fs::write(&plan, faults).unwrap();
        for args in [
            &["rank", &scenario, "--in-process"][..],
            &["measure", "--scenario", &scenario, "--workers", "1", "--instance", &name],
            &["inject", utf8(&plan)],
        ] {
            let output = ended(args);
            let said = text(&output.stderr);
            assert_eq!(output.status.code(), Some(65), "{args:?}: {path}: {said}");
            for part in ["scenario.toml:", key, &path, "out of the folder", "--allow-outside"] {
                assert!(said.contains(part), "{args:?}: {part}: {said}");
            }
            let output = ended(&[args, &["--allow-outside"]].concat());
            let said = text(&output.stderr);
            assert!(output.status.success(), "{args:?}: {path}: {said}");
        }
        if key == "file" {
            let over_a_horizon = format!(
                "schema = \"trolley.scenario/2\"\nname = \"w\"\n[parties]\n\
                 ego = {{ file = {path:?} }}\n\
                 p = {{ generate = {{ shape = \"pole\", triangles = 600 }}, \
                 place = {{ position_m = [9, 0, 0] }} }}\n[[candidates]]\nname = \"on\"\n\
                 state = {{ position_m = [0, 0, 0], speed_m_s = 9 }}\n"
            );
            let asked = place.path().join("own/asked.toml");
            std::fs::write(&asked, over_a_horizon).unwrap();
            let output = ended(&["query", utf8(&deployment), utf8(&asked)]);
            let said = text(&output.stderr);
            assert_eq!(output.status.code(), Some(65), "{said}");
            assert!(said.contains("--allow-outside"), "{said}");
        }
    }
}

#[test]
fn what_is_in_the_folder_or_does_not_exist_is_no_way_out() {
    let place = laid_out();
    let own = place.path().join("own");
    for name in ["policy.toml", "ego.trolley"] {
        std::fs::copy(place.path().join(name), own.join(format!("my-{name}"))).unwrap();
    }
    std::os::unix::fs::symlink("my-policy.toml", own.join("link.toml")).unwrap();
    let absolute = utf8(&own.join("my-policy.toml")).to_owned();
    for (key, path) in [
        ("policy", "my-policy.toml"),
        ("policy", "./../own/my-policy.toml"),
        ("policy", "link.toml"),
        ("policy", &absolute),
        ("file", "my-ego.trolley"),
    ] {
        let output = ended(&["rank", &naming(&place, key, path), "--in-process"]);
        assert!(output.status.success(), "{path}: {}", text(&output.stderr));
    }
    let output = ended(&["rank", &naming(&place, "policy", "none.toml"), "--in-process"]);
    let said = text(&output.stderr);
    assert!(said.contains("no such file") && !said.contains("--allow-outside"), "{said}");
    // Whether a file exists elsewhere is not told, either.
    let output = ended(&["rank", &naming(&place, "policy", "none/../../none.toml")]);
    let said = text(&output.stderr);
    assert!(said.contains("out of the folder"), "{said}");
}

#[test]
fn a_deployment_names_files_of_its_folder_alone() {
    let place = laid_out();
    let minimal = std::fs::read_to_string(shipped("config/deployments/minimal.toml")).unwrap();
    let model = "generate = { shape = \"wall\", triangles = 2000 }";
    let at = place.path().join("own/deployment.toml");
    for (key, path) in leading_out(&place) {
        let changed = match key {
            "file" => minimal.replacen(model, &format!("model = \"{path}\""), 1),
            key => minimal.replacen("[engine]", &format!("{key} = \"{path}\"\n[engine]"), 1),
        };
        assert_ne!(changed, minimal);
        std::fs::write(&at, changed).unwrap();
        let output = ended(&["serve", utf8(&at), "--instance", &instance()]);
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(65), "{said}");
        let key = if key == "file" { "model" } else { key };
        for part in ["deployment.toml", key, &path, "out of the folder", "--allow-outside"] {
            assert!(said.contains(part), "{part}: {said}");
        }
    }
    let opened =
        trolley::OpenDeployment::open_with(&at, None, References::Anywhere).expect("it is sound");
    assert_eq!(trolley::bodies::Bodies::of_deployment(&opened).unwrap().hashes().len(), 3);
}

#[test]
fn the_library_of_traffic_names_models_of_its_folder_alone() {
    let place = laid_out();
    let shipped = std::fs::read_to_string(shipped("config/bodies/default.toml")).unwrap();
    let line = shipped.lines().find(|line| line.contains("sedan")).unwrap();
    let (kind, _) = line.split_once('=').unwrap();
    let file = place.write("crossing.xml", &crossing(0.5, "parkedVehicle"));
    let library = place.path().join("own/bodies.toml");
    for (path, code) in [("../ego.trolley", 65), ("my-ego.trolley", 0)] {
        std::fs::copy(place.path().join("ego.trolley"), place.path().join("own/my-ego.trolley"))
            .unwrap();
        let entry = format!("{}= {{ file = \"{path}\" }}", kind);
        std::fs::write(&library, shipped.replace(line, &entry)).unwrap();
        let args = ["rank", utf8(&file), "--in-process", "--bodies", utf8(&library)];
        let output = ended(&args);
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "{path}: {said}");
        assert_eq!(code == 65, said.contains("--allow-outside"), "{path}: {said}");
        let output = ended(&[&args[..], &["--allow-outside"]].concat());
        assert!(output.status.success(), "{path}: {}", text(&output.stderr));
    }
}

#[test]
fn the_library_asks_as_the_program_does_and_a_replay_opens_no_path() {
    let place = laid_out();
    let scenario = naming(&place, "file", "../ego.trolley");
    assert!(Scenario::open(&scenario).is_err());
    let allowed = Scenario::open_with(&scenario, References::Anywhere).unwrap();
    let mut engine = Engine::builder().in_process().build().unwrap();
    let limits = Limits::default().with_record();
    let ranking = engine.rank(&allowed, &limits).unwrap();

    // Texts that came otherwise are bound, too.
    let read = |path: &Path| SourceText {
        name: utf8(path).to_owned(),
        text: std::fs::read_to_string(path).unwrap(),
    };
    let texts = Texts {
        scenario: read(Path::new(&scenario)),
        policy: read(&place.path().join("policy.toml")),
        curves: read(&place.path().join("curves.toml")),
        parameters: read(&place.path().join("parameters.toml")),
    };
    let bound = Scenario::of_texts(texts, Vec::new()).unwrap();
    let failure = engine.rank(&bound, &limits).unwrap_err();
    assert!(failure.to_string().contains("--allow-outside"), "{failure}");
    engine.rank(&bound.with_references(References::Anywhere), &limits).unwrap();

    // A record names models by their hash, and the user the folder.
    let records = place.path().join("records");
    let record = trolley::Record::write(&records_made(&records), &ranking).unwrap();
    let replay = ["record", "replay", utf8(&record), "--models", utf8(place.path())];
    let output = ended(&replay);
    assert!(output.status.success(), "{}", text(&output.stderr));
}

fn records_made(folder: &Path) -> std::path::PathBuf {
    trolley::Record::prepare(folder).unwrap();
    folder.to_owned()
}
