//! Written values take effect; wrong ones are reported with place and remedy.

use super::*;

const MINIMAL: &str = include_str!("../../config/deployments/minimal.toml");
const QUAD: &str = include_str!("../../config/deployments/quad-core.toml");
const DUAL: &str = include_str!("../../config/deployments/dual-core.toml");

#[test]
fn the_deployments_that_are_shipped_are_accepted() {
    let minimal = Deployment::parse("minimal.toml", MINIMAL).unwrap();
    assert_eq!(minimal.models.len(), 3);
    assert_eq!((minimal.model(3), minimal.model(4)), (Some(2), None));
    assert_eq!((minimal.queue, minimal.idle), (16, Idle::Park));
    let quad = Deployment::parse("quad-core.toml", QUAD).unwrap();
    assert_eq!(quad.engine.workers, 4);
    assert!(quad.realtime.priority > quad.realtime.worker_priority);
    assert_eq!(Deployment::parse("dual-core.toml", DUAL).unwrap().engine.workers, 2);
    for (deployment, limit) in [(&minimal, 1024), (&quad, 128)] {
        assert_eq!((deployment.members, deployment.members_limit), (Members::USUAL, limit));
    }
}

#[test]
fn members_are_those_that_are_written() {
    for (written, members) in [
        ("members = 1", (1, 1)),
        ("members = 32", (32, 128)),
        ("members = 8\nmembers_max = 8", (8, 8)),
    ] {
        let text = MINIMAL.replacen("[engine]", &format!("{written}\n[engine]"), 1);
        let found = Deployment::parse("d.toml", &text).unwrap().members;
        assert_eq!((found.count, found.most), members);
    }
    // A word of a comment is no key.
    let text = MINIMAL.replacen(
        "[engine]",
        "# whose members = all, members_max too\nmembers = 8\nmembers_max = 4\n[engine]",
        1,
    );
    let error = Deployment::parse("d.toml", &text).unwrap_err();
    let line = text.lines().position(|line| line.starts_with("members_max")).unwrap() + 1;
    assert_eq!(diagnostic::Diagnostic::place(&error), Some(format!("d.toml:{line}:1")));
}

#[test]
fn every_mistake_is_named_with_its_place_and_a_remedy() {
    for (from, to, said) in [
        ("trolley.deployment/1", "trolley.deployment/9", "is not known"),
        ("instance = \"minimal\"", "instance = \"Mini mal\"", "must be 1 to 12 letters"),
        ("workers = 2", "workers = 99", "workers is 99"),
        ("workers = 2", "depth = \"auto\"", "expected i64"),
        ("workers = 2", "wrokers = 2", "unknown field"),
        ("id = 2", "id = 1", "has the id or the name of"),
        ("name = \"wall\"", "name = \"pole\"", "has the id or the name of"),
        ("\"pole\", triangles = 2000", "\"pole\", triangles = 2", "triangles is 2"),
        ("shape = \"pole\"", "shape = \"pol\"", "shape \"pol\" is not known"),
        ("[engine]", "queue = 17\n[engine]", "queue is out of range"),
        ("[engine]", "queue = -1\n[engine]", "queue is out of range"),
        ("[engine]", "members = 0\n[engine]", "members is 0"),
        ("[engine]", "members = 1025\n[engine]", "members may be 1 to 1024"),
        ("[engine]", "members = 2.5\n[engine]", "invalid type"),
        ("[engine]", "members = 8\nmembers_max = 4\n[engine]", "members_max is 4"),
        ("[engine]", "members_max = 4\n[engine]", "members_max is 4, and members is 32"),
        ("[engine]", "members = 1\nmembers_max = 4\n[engine]", "nothing is drawn"),
        ("[engine]", "members_limit = 127\n[engine]", "members_limit is 127"),
        ("[engine]", "members_limit = 1025\n[engine]", "members_max (128) to 1024"),
        ("[engine]", "group = -1\n[engine]", "-1 is not a group"),
        ("[engine]", "group = true\n[engine]", "true is not a group"),
        ("[engine]", "[realtime]\npriority = 100\n[engine]", "priority is 100"),
        ("[engine]", "[metrics]\nfile = \"m\"\nevery_s = 0\n[engine]", "every_s is out of range"),
        ("[engine]", "[decisions]\nfolder = \"d\"\nfiles = 1\n[engine]", "per_file or files"),
        (
            "[engine]",
            "[decisions]\nfolder = \"d\"\nper_file = 100001\n[engine]",
            "per_file or files",
        ),
        ("id = 3", "id = 3\nmodel = \"x\"", "has not exactly one of"),
        ("schema =", "schema ==", "deployment.toml:3"),
    ] {
        assert!(MINIMAL.contains(from), "{from}");
        let wrong = MINIMAL.replacen(from, to, 1);
        let error = Deployment::parse("deployment.toml", &wrong).unwrap_err();
        let error = diagnostic::Failure::from(error).to_string();
        assert!(error.contains(said), "{to}: {error}");
        assert!(error.starts_with("deployment.toml:") && error.contains("\n  help: "), "{error}");
    }
    let none = MINIMAL.split("[[models]]").next().unwrap();
    assert!(Deployment::parse("d", none).unwrap_err().to_string().contains("0 models"));
    let long = "#".repeat(TEXT_BYTES_MAX + 1);
    assert!(Deployment::parse("d", &long).unwrap_err().to_string().contains("too many"));
}
