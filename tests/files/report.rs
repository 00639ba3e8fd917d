//! `trolley report`: from a recorded decision to a page, .glb files and stills; and the page in a
//! real browser, without a network.
//!
//! The browser is chromium, if installed; else the test is skipped with a visible message.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use crate::support::service::shipped;
use crate::support::{Place, instance, left_in_shm, skipped, text, trolley};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Runs a command that must succeed.
fn done(args: &[&str]) -> String {
    let output = trolley().args(args).output().unwrap();
    assert!(output.status.success(), "{args:?}: {}", text(&output.stderr));
    text(&output.stdout)
}

fn path(place: &Path, name: &str) -> String {
    place.join(name).to_str().unwrap().to_owned()
}

const SMALL: &str = r#"schema = "trolley.scenario/2"
name = "Wall or pole"
[parties.ego]
generate = { shape = "sedan", triangles = 3000 }
[parties.pole]
generate = { shape = "pole", triangles = 1000 }
place = { position_m = [14, -3, 0] }
[parties.wall]
generate = { shape = "wall", triangles = 1000 }
place = { position_m = [20, 0, 0], yaw_deg = 90 }
[[candidates]]
name = "wall <b>"
state = { position_m = [0, 0, 0], speed_m_s = 10 }
[[candidates]]
name = "pole"
path = { states = [ { t_s = 0, position_m = [0, 0, 0] }, { t_s = 1.4, position_m = [14, -3, 0] } ] }
"#;

/// Ranks and records a scenario; returns the record.
fn recorded(place: &Place, scenario: &Path, more: &[&str]) -> String {
    let folder = path(place.path(), "records");
    let name = instance();
    let mut args = vec!["rank", scenario.to_str().unwrap(), "--record", &folder];
    args.extend(["--workers", "2", "--instance", &name, "--quiet"]);
    args.extend(more);
    done(&args);
    assert!(left_in_shm(&name).is_empty());
    format!("{folder}/000000.record")
}

#[test]
fn a_record_becomes_a_page_meshes_and_stills() {
    let place = Place::new();
    let scenario = place.write("small.toml", SMALL);
    let record = recorded(&place, &scenario, &[]);
    let (out, glb, png) =
        (path(place.path(), "a.html"), path(place.path(), "glb"), path(place.path(), "png"));
    let json = path(place.path(), "a.json");
    done(&["report", &record, "--out", &out, "--glb", &glb, "--png", &png, "--report-json", &json]);
    let page = std::fs::read_to_string(&out).unwrap();
    let document: Value = serde_json::from_str(&std::fs::read_to_string(&json).unwrap()).unwrap();
    assert_eq!(document["schema"], "trolley.page/1");
    let title = document["title"].as_str().unwrap();
    let markup = title.replace('<', "&lt;").replace('>', "&gt;");
    assert!(page.contains(&format!("<h1><bdi>{markup}</bdi></h1>")), "no title: {title}");
    assert_eq!(document["is_least_harm"], title.starts_with("Least harm: "), "{title}");
    assert!(page.contains("wall &lt;b&gt;") && !page.contains("wall <b>"));
    // Workers did the jobs, and the record says which worker, and when.
    assert!(page.contains("aria-label=\"Jobs on each worker over time\""));
    assert!(page.contains("<td>worker 1</td><td>coordinator</td>"));
    for (folder, start, count) in [(&glb, &b"glTF"[..], 2), (&png, &b"\x89PNG"[..], 4)] {
        let files: Vec<PathBuf> =
            std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
        assert_eq!(files.len(), count, "{files:?}");
        assert!(files.iter().all(|file| std::fs::read(file).unwrap().starts_with(start)));
    }
    // The written file can be imported again as a body.
    let files = std::fs::read_dir(&glb).unwrap().map(|entry| entry.unwrap().path());
    let mesh = files.into_iter().find(|file| file.to_string_lossy().contains("pole")).unwrap();
    let mesh = mesh.to_str().unwrap().to_owned();
    let said = done(&["model", "check", &mesh]);
    assert!(said.starts_with("ok"), "{said}");
}

#[test]
fn what_cannot_be_shown_is_refused_with_a_remedy() {
    let place = Place::new();
    let scenario = place.write("small.toml", SMALL);
    let record = recorded(&place, &scenario, &[]);
    let out = path(place.path(), "a.html");
    let folder = place.path().to_str().unwrap();
    for (args, code, says) in [
        (&["report", &record][..], 78, "nothing to write"),
        (&["report", &record, "--glb", folder, "--candidate", "lake"], 65, "no candidate \"lake\""),
        (&["report", scenario.to_str().unwrap(), "--out", &out], 65, "small.toml"),
        (&["report", folder, "--out", &out], 65, "README.md"),
        (&["report", "no.record", "--out", &out], 65, "no.record"),
    ] {
        let output = trolley().args(args).output().unwrap();
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "{args:?}: {said}");
        assert!(said.contains(says), "{args:?}: {said}");
    }
    assert!(!Path::new(&out).exists());
}

#[test]
fn a_ranking_becomes_a_page() {
    let place = Place::new();
    let scenario = shipped("config/scenarios/crossing.toml");
    let out = path(place.path(), "crossing.html");
    let scenario = scenario.to_str().unwrap();
    let args = ["rank", scenario, "--in-process", "--members", "1", "--report", &out];
    let plain = done(&args[..5]);
    let shown = done(&args);
    // The answer is printed all the same; only times differ.
    assert_eq!(plain.lines().count(), shown.lines().count());
    let page = std::fs::read_to_string(&out).unwrap();
    assert!(page.contains("<h1><bdi>Touches nobody: go on</bdi></h1>"), "no title");
    assert_eq!(page.matches("<option ").count(), 3);
    assert_eq!(page.matches("<g data-body=").count(), 6);
}

#[test]
fn a_measurement_becomes_a_page() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let place = Place::new();
    let out = path(place.path(), "m.html");
    let folder = root.join("tools/results/measure");
    done(&["report", folder.to_str().unwrap(), "--out", &out]);
    let page = std::fs::read_to_string(&out).unwrap();
    assert!(page.contains("data:image/png;base64,") && page.contains("<table>"));
    assert!(!page.contains("is missing.</p>"));
}

/// A browser, if there is one.
fn browser() -> Option<&'static str> {
    let found = ["chromium", "chromium-browser", "google-chrome"].into_iter().find(|name| {
        let asked = Command::new(name).arg("--version").stdout(Stdio::null()).status();
        asked.is_ok_and(|status| status.success())
    });
    if found.is_none() {
        skipped("the report page in a browser: there is no chromium");
    }
    found
}

/// Opens a page from disk without any network; returns its console output, and the document after
/// all scripts have run.
fn opened(browser: &str, place: &Place, page: &str) -> (String, String) {
    let profile = format!("--user-data-dir={}", path(place.path(), "profile"));
    let output = Command::new(browser)
        .args(["--headless", "--no-sandbox", "--disable-quic", "--no-first-run", &profile])
        .args(["--disable-background-networking", "--disable-component-update", "--disable-sync"])
        .args(["--proxy-server=127.0.0.1:9", "--host-resolver-rules=MAP * ~NOTFOUND"])
        .args(["--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"])
        .args(["--enable-logging=stderr", "--v=0", "--virtual-time-budget=10000", "--dump-dom"])
        .arg(format!("file://{page}"))
        .output()
        .unwrap();
    let console = text(&output.stderr);
    let console: Vec<&str> = console.lines().filter(|line| line.contains("CONSOLE")).collect();
    (console.join("\n"), text(&output.stdout))
}

/// The 3D view draws both bodies, the hit triangles, and the patch: five objects, six with its
/// frame.
fn assert_drawn(console: &str, document: &str) {
    assert_eq!(console, "", "the page complained");
    let view = document.split("data-view=\"").nth(1).and_then(|rest| rest.split('"').next());
    let view = view.unwrap_or_else(|| panic!("the view did not draw: {}", &document[..400]));
    let (objects, hits) = (view.contains("6 objects"), !view.contains(", 0 hits"));
    assert!(objects && hits, "{view}");
    assert!(document.contains("<canvas"));
}

#[test]
fn the_page_works_in_a_browser_without_a_network() {
    let Some(browser) = browser() else { return };
    let place = Place::new();
    let scenario = place.write("small.toml", SMALL);
    let record = recorded(&place, &scenario, &[]);
    let out = path(place.path(), "a.html");
    done(&["report", &record, "--out", &out]);
    let (console, document) = opened(browser, &place, &out);
    assert_drawn(&console, &document);
    let scenario = shipped("config/scenarios/crossing.toml");
    let args = ["rank", scenario.to_str().unwrap(), "--in-process", "--members", "1"];
    done(&[&args[..], &["--report", &out]].concat());
    let (console, document) = opened(browser, &place, &out);
    assert_eq!(console, "", "the plan complained");
    // It opens on the winner, which touches nobody: where it is nearest.
    assert!(document.contains("data-view=\"shot 0, 4 objects, 0 hits\""), "not the winner");
    // What only the script does.
    assert!(
        document.contains("aria-valuetext=\"0.00 s\"") && document.contains("class=\"controls\">")
    );
}

/// Tries every candidate at every tenth of a second, and counts pairs of texts that overlap, in the
/// plan and in 3D.
const MEASURE: &str = "<script>(() => {
  const [course, time] = ['course', 'time'].map((id) => document.getElementById(id));
  let [seen, overlaps] = [0, []];
  const look = () => {
    for (const texts of ['#plan text', '#over span']) {
      const boxes = [...document.querySelectorAll(texts)].map((text) => {
        const { left, top, right, bottom } = text.getBoundingClientRect();
        return { left, top, right, bottom, text: text.textContent };
      }).filter((box) => box.right > box.left);
      seen += boxes.length;
      boxes.forEach((a, k) => boxes.slice(0, k).forEach((b) => {
        // Boxes of letters may share the edge.
        const by = 1;
        const across = a.left < b.right - by && b.left < a.right - by;
        const upwards = a.top < b.bottom - by && b.top < a.bottom - by;
        if (across && upwards) overlaps.push(`${course.value} ${time.value} ${a.text}/${b.text}`);
      }));
    }
  };
  for (const option of course.options) {
    course.value = option.value;
    course.dispatchEvent(new Event('input'));
    for (let at = 0; at <= Number(time.max); at += 0.1) {
      time.value = at;
      time.dispatchEvent(new Event('input'));
      look();
    }
  }
  document.body.dataset.seen = seen > 200;
  document.body.dataset.overlaps = `${overlaps.length}: ${overlaps.slice(0, 5).join('; ')}`;
})();</script>";

#[test]
fn no_label_covers_another_at_any_time() {
    let Some(browser) = browser() else { return };
    let place = Place::new();
    let scenario = shipped("config/scenarios/crossing.toml");
    let out = path(place.path(), "labels.html");
    let args = ["rank", scenario.to_str().unwrap(), "--in-process", "--members", "4"];
    done(&[&args[..], &["--members-max", "4", "--report", &out]].concat());
    let page = std::fs::read_to_string(&out).unwrap();
    std::fs::write(&out, page.replace("</body>", &format!("{MEASURE}</body>"))).unwrap();
    let (console, document) = opened(browser, &place, &out);
    assert_eq!(console, "", "the page complained");
    let said = document.split("data-overlaps=\"").nth(1).and_then(|rest| rest.split('"').next());
    assert_eq!(said, Some("0: "), "labels overlap");
    assert!(document.contains("data-seen=\"true\""), "texts were compared");
}

#[test]
fn on_paper_every_candidate_begins_a_page() {
    let Some(browser) = browser() else { return };
    let place = Place::new();
    let scenario = shipped("config/scenarios/small.toml");
    let (out, pdf) = (path(place.path(), "paper.html"), path(place.path(), "paper.pdf"));
    done(&["rank", scenario.to_str().unwrap(), "--in-process", "--report", &out]);
    let page = std::fs::read_to_string(&out).unwrap();
    let sections = page.matches("<section class=\"course\">").count();
    let status = Command::new(browser)
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run"])
        .args(["--disable-background-networking", "--disable-component-update", "--disable-sync"])
        .arg(format!("--user-data-dir={}", path(place.path(), "profile")))
        .args(["--no-pdf-header-footer", &format!("--print-to-pdf={pdf}")])
        .arg(format!("file://{out}"))
        .stderr(Stdio::null())
        .status()
        .unwrap();
    assert!(status.success());
    let bytes = std::fs::read(&pdf).unwrap();
    let plain = String::from_utf8_lossy(&bytes);
    let pages = plain.matches("/Type /Page\n").count();
    assert!(sections >= 2 && pages > sections, "{pages} pages for {sections} candidates");
}

mod shared_data {
    use super::{assert_drawn, browser, done, opened, path, recorded};
    use crate::support::{Place, shared};

    /// Two real bodies, imported, ranked and shown.
    #[test]
    #[ignore = "needs ../shared/data: real bodies"]
    fn a_page_of_real_bodies_works_in_a_browser() {
        let models = shared("models");
        let place = Place::new();
        for (name, mesh, kind) in [
            ("sedan", "chrono_sedan/sedan_chassis_vis.obj", "sedan"),
            ("suv", "chrono_nissan_patrol_suv/suv_chassis.obj", "suv"),
        ] {
            let (mesh, out) = (path(&models, mesh), path(place.path(), &format!("{name}.trolley")));
            done(&["model", "import", &mesh, "--unit", "m", "--kind", kind, "-o", &out, "--quiet"]);
        }
        let text = "schema = \"trolley.scenario/2\"\nname = \"Real bodies\"\n\
            [parties.ego]\nfile = \"sedan.trolley\"\n\
            [parties.suv]\nfile = \"suv.trolley\"\n\
            state = { position_m = [24, 0.3, 0], speed_m_s = 4 }\n\
            [parties.across]\nfile = \"suv.trolley\"\n\
            state = { position_m = [22, -9.5, 0], yaw_deg = 90, speed_m_s = 2 }\n\
            [[candidates]]\nname = \"rear-end the SUV\"\n\
            state = { position_m = [0, 0, 0], speed_m_s = 15 }\n\
            [[candidates]]\nname = \"hit its side\"\n\
            state = { position_m = [0, 0, 0], velocity_m_s = [11, -3] }\n";
        let scenario = place.write("real.toml", text);
        let record = recorded(&place, &scenario, &[]);
        let (out, models) = (path(place.path(), "r.html"), path(place.path(), ""));
        done(&["report", &record, "--models", &models, "--out", &out]);
        let page = std::fs::read_to_string(&out).unwrap();
        assert!(page.contains("\"of\":39170") && page.contains("\"of\":23002"));
        let Some(browser) = browser() else { return };
        let (console, document) = opened(browser, &place, &out);
        assert_drawn(&console, &document);
    }
}
