//! A row that `trolley rank` has otherwise is named.

use super::*;
use crate::{plan, run_shard};

const SPEC: &str = r#"schema = "trolley.study/1"
name = "Test"
policies = ["default"]
[[scenarios]]
files = ["a.scenario"]
[sweep]
speed = { values = [0.9, 1, 1.1] }
"#;

const POLE: &str = r#"schema = "trolley.scenario/2"
name = "Pole"
horizon_s = 2
[parties]
ego = { generate = { shape = "sedan", triangles = 600 } }
[parties.pole]
generate = { shape = "pole", triangles = 600 }
place = { position_m = [12, 0, 0] }
[[candidates]]
name = "straight on"
state = { position_m = [0, 0, 0], speed_m_s = 9 }
"#;

#[test]
fn a_row_that_is_ranked_otherwise_is_named() {
    let place = tempfile::tempdir().unwrap();
    let path = |name: &str| place.path().join(name);
    std::fs::write(path("spec.toml"), SPEC).unwrap();
    std::fs::write(path("a.scenario"), POLE).unwrap();
    let plan = plan(&path("spec.toml"), &path("study")).unwrap();
    run_shard(plan.dir(), 0).unwrap();
    assert_eq!(reranked(&plan, 2, &|_, _| {}).unwrap(), Reranked { rows: 2, ..equal() });

    let file = File::open(path("study/shards/000000/answers.parquet")).unwrap();
    let written = read(file, ["row", "answer_hash", "refusal"]).unwrap();
    let mut engine = Engine::builder().in_process().build().unwrap();
    let mut compared = |columns: &[ReadColumn; 3]| {
        let mut found = Reranked::default();
        found.shard(&plan, 1, columns, &path("ranked"), &mut engine).unwrap();
        found
    };
    assert_eq!(compared(&written), Reranked { rows: 3, ..equal() });
    let [rows, ReadColumn::Text(hashes), ReadColumn::Text(none)] = written else {
        panic!("columns are of other forms")
    };
    let mut swapped = hashes.clone();
    swapped.swap(0, 1);
    let found = compared(&[rows.clone(), ReadColumn::Text(swapped), ReadColumn::Text(none)]);
    let named: Vec<u64> = found.differ.iter().map(|fault| fault.row).collect();
    assert_eq!((named, found.rows), (vec![0, 1], 3));

    let refusals = ["of another kind", "the process that ranked it died, 3 times"];
    let refusals = refusals.iter().map(|why| Some((*why).to_owned())).chain([None]).collect();
    let found = compared(&[rows, ReadColumn::Text(hashes), ReadColumn::Text(refusals)]);
    assert_eq!((found.differ.len(), found.differ[0].row), (1, 0), "it has an answer");
    assert_eq!((found.rows, found.refused, found.left_out), (2, 1, 1));
}

fn equal() -> Reranked {
    Reranked::default()
}
