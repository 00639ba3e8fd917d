//! Cases are what drivers read; answers are judged; the page shows who is wrong.

use super::*;
use cases::{poses, stl};
use geometry::Pose;
use log::Measured;
use std::path::Path;

fn line(json: &str) -> Measured {
    serde_json::from_str(json).unwrap()
}

fn truth() -> Measured {
    line(
        r#"{"peer":"cgal","case":"x","build_ms":1,"pose_ms":0,"query_ms":2,"pairs":3,"hash":"0a",
        "nb":0,"np":9,"hits_a":2,"hash_a":"0b","hits_b":1,"hash_b":"0c"}"#,
    )
}

#[test]
fn a_case_is_binary_stl_and_poses_that_come_back() {
    let corners = [[[1.0, 2.0, 3.0], [4.0, 5.0, 6.0], [7.0, 8.0, -9.5]]; 3];
    let bytes = stl(&corners);
    assert_eq!(bytes.len(), 84 + 3 * 50);
    assert_eq!(bytes[80..84], [3, 0, 0, 0]);
    // The last coordinate of the second triangle.
    assert_eq!(bytes[84 + 50 + 44..][..4], (-9.5_f32).to_le_bytes());

    let pose = Pose::from_degrees(12.0, -3.0, 40.0, [1e-9, 0.1, -1e9]);
    let text = poses(&[Pose::IDENTITY, pose]);
    let numbers: Vec<f64> = text.split_whitespace().map(|x| x.parse().unwrap()).collect();
    let rows = pose.rotation.iter().zip(pose.translation).flat_map(|(r, t)| [r[0], r[1], r[2], t]);
    assert_eq!(numbers[12..], rows.collect::<Vec<_>>());
    assert!(text.lines().all(|line| line.split(' ').count() == 4) && text.lines().count() == 6);
}

#[test]
fn answers_are_judged_by_their_question() {
    let (truth, short) = (truth(), r#""peer":"trolley","build_ms":1,"pose_ms":0,"query_ms":1"#);
    let answer = |rest: &str| line(&format!("{{{short},{rest}}}")).agrees(&truth);
    assert!(answer(r#""pairs":3,"hash":"0a""#));
    assert!(!answer(r#""pairs":3,"hash":"0b""#));
    assert!(!answer(r#""pairs":2,"hash":"0a""#));
    assert!(answer(r#""question":"touches","pairs":1,"hash":"""#));
    assert!(!answer(r#""question":"touches","pairs":0,"hash":"""#));
    let sets = r#""question":"sets","hits_a":2,"hash_a":"0b","hits_b":1,"#;
    assert!(answer(&format!(r#"{sets}"hash_b":"0c""#)));
    assert!(!answer(&format!(r#"{sets}"hash_b":"0d""#)));
    assert!(!answer(r#""question":"sets","pairs":3,"hash":"0a""#));
}

#[test]
fn the_page_shows_medians_ratios_and_who_is_wrong() {
    let rows = row::all(Path::new("trolley"), &[("embree", "embree".into())], false);
    let case = Case { name: "cars-10k-deep".into(), folder: "x".into(), triangles: 20_000 };
    let larger = Case { name: "cars-1m-deep".into(), triangles: 2_000_000, ..case.clone() };
    let mut log = Log::default();
    for (round, query_ms) in (1..).zip([9.0, 2.0, 1.0]) {
        for case in [&case, &larger] {
            let right = Measured { query_ms, question: pairs(), ..truth() };
            log.add(&rows[0], &case.name, round, right.clone());
            let embree = rows.iter().find(|row| row.name == "embree").unwrap();
            let slow = Measured { query_ms: 3.0 * query_ms, pose_ms: 4.0, pairs: 4, ..right };
            log.add(embree, &case.name, round, slow.clone());
            let moving =
                rows.iter().find(|row| row.key() == (row::Section::Moving, "embree".into()));
            log.add(moving.unwrap(), &case.name, round, Measured { query_ms: 7.0, ..slow });
        }
    }
    let cases = [case.clone(), larger.clone()];
    let truths = BTreeMap::from([(case.name, truth()), (larger.name, truth())]);
    let page = Page {
        machine: &[("processor", "a fast one".into())],
        versions: &[],
        cases: &cases,
        rows: &rows,
        truths: &truths,
        log: &log,
        rounds: 3,
        skipped: &["fcl: left out".into()],
    };
    let text = page.to_string();
    let cells = |start: &str| -> Vec<&str> {
        let line = text.lines().find(|line| line.starts_with(start)).unwrap();
        line.split('|').map(str::trim).filter(|cell| !cell.is_empty()).collect()
    };
    assert_eq!(cells("| trolley "), ["trolley", "2.00", "1.00", "0", "1.00", "1.00", "right"]);
    assert_eq!(
        cells("| embree "),
        ["embree", "6.00", "3.00", "4.00", "5.00", "1.00", "WRONG: 4 pairs"]
    );
    let moving = &text[text.find("## One core, a moving body").unwrap()..];
    assert!(moving.contains("| embree |     7.00 |  1.00 "), "{moving}");
    assert!(text.contains("### cars-10k-deep: 20,000 triangles, 3 intersecting pairs"), "{text}");
    assert!(text.contains("\n- fcl: left out\n") && !text.contains("## One core, cold"), "{text}");
    let growth = &text[text.find("## Growth").unwrap()..];
    // 2 ms over 20,000 triangles and 3 hits, and over a hundred times as many triangles.
    assert!(growth.contains("100 / 666667") && growth.contains("1.00 / 666667"), "{growth}");
    assert_eq!(page.wrong_of_ours(), [""; 0]);

    let mut wrong = Log::default();
    wrong.add(&rows[0], "cars-10k-deep", 1, Measured { pairs: 2, ..truth() });
    let page = Page { log: &wrong, ..page };
    assert_eq!(page.wrong_of_ours(), ["trolley on cars-10k-deep"]);
}

#[test]
fn sizes_are_no_part_of_a_family() {
    assert_eq!(page::family("cars-10k-deep").as_deref(), Some("cars-deep"));
    assert_eq!(page::family("cars-1m-deep"), page::family("cars-100k-deep"));
    assert_eq!(page::family("comb"), None);
    assert_eq!(page::family("k-comb"), None);
}

#[test]
fn numbers_are_written_for_people() {
    let written = [0.0, 0.00123, 0.1234, 1.234, 12.34, 1234.5].map(page::figures);
    assert_eq!(written, ["0", "0.0012", "0.123", "1.23", "12.3", "1234"]);
    assert_eq!([0, 999, 1000, 1_234_567].map(page::grouped), ["0", "999", "1,000", "1,234,567"]);
}

fn pairs() -> String {
    "pairs".into()
}
