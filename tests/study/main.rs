//! Studies: rows do not depend on who ranks them, on kills or on damage; each row is what `trolley
//! rank` says of its scene.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod planned;
#[path = "../support/mod.rs"]
mod support;

use ::trolley::{Engine, FailureKind, Limits, Scenario, Worlds};
use geometry::rng::Rng;
use planned::{POLE, Planned, SPEC};
use std::collections::BTreeMap;
use std::fs;
use std::os::unix::fs::PermissionsExt as _;
use std::path::{Path, PathBuf};
use study::{Plan, RunOptions, run_shard, status};
use support::{text, trolley, wait_for};

#[test]
fn rows_do_not_depend_on_who_ranks_them() {
    let [here, children, one_by_one] = [(); 3].map(|()| Planned::usual());
    let ids = [&here, &children, &one_by_one].map(|it| status(&it.dir).unwrap().study);
    assert!(ids.iter().all(|id| *id == ids[0]), "one specification is one study: {ids:?}");
    let rows = here.run_here();
    let ran = children.command(&["run", "--jobs", "2"]);
    assert!(ran.status.success(), "{}", text(&ran.stderr));
    assert_eq!(children.rows(), rows);
    for shard in (0..8).rev() {
        let ran = one_by_one.command(&["run", "--shard", &shard.to_string()]);
        assert!(ran.status.success(), "{}", text(&ran.stderr));
    }
    assert_eq!(one_by_one.rows(), rows);
    // The files, too, to the byte; and a second run touches none.
    let bytes = |planned: &Planned| -> Vec<Vec<u8>> {
        planned.files().into_values().map(|(_, bytes)| bytes).collect()
    };
    assert_eq!(bytes(&here), bytes(&children));
    assert_eq!(bytes(&here), bytes(&one_by_one));
    let before = here.files();
    assert_eq!(here.run_here(), rows);
    assert_eq!(here.files(), before);
    assert_eq!(status(&here.dir).unwrap().attempts, 8, "a finished shard is no attempt");
}

#[test]
fn a_run_that_is_killed_at_any_moment_ends_with_the_same_rows() {
    let rows = Planned::usual().run_here();
    for seed in 0..6 {
        let mut rng = Rng::new(seed);
        let planned = Planned::usual();
        let finished = || fs::read_dir(planned.dir.join("shards")).unwrap().count();
        for _ in 0..2 {
            let mut command = trolley();
            command.args(["study", "run", "--jobs", "2"]).arg(&planned.dir);
            let mut child = command.spawn().unwrap();
            let wanted = finished() + rng.below(4) as usize;
            let is_due = |child: &mut std::process::Child| {
                (finished() >= wanted || child.try_wait().unwrap().is_some()).then_some(())
            };
            wait_for(60_000, || is_due(&mut child));
            runtime::clock::nap_ns(rng.below(10_000_000));
            // One that has ended already needs no kill.
            let _ended = child.kill();
            child.wait().unwrap();
        }
        let ran = planned.command(&["run", "--jobs", "2"]);
        assert!(ran.status.success(), "{}", text(&ran.stderr));
        assert_eq!(planned.rows(), rows, "seed {seed}");
        let left = fs::read_dir(planned.dir.join("tmp")).unwrap().count();
        assert!(left <= 4, "{left} unfinished shards of two kills and two children");
    }
}

#[test]
fn what_was_changed_is_named_and_it_alone_is_ranked_again() {
    let planned = Planned::usual();
    let rows = planned.run_here();
    let mut rng = Rng::new(7);
    for name in ["answers.parquet", "candidates.parquet", "persons.parquet", "seal.json"] {
        let before = planned.files();
        let shard = rng.below(8) as u32;
        let path = planned.shard(shard).join(name);
        let mut bytes = fs::read(&path).unwrap();
        let place = rng.below(bytes.len() as u64) as usize;
        bytes[place] ^= 1 << rng.below(8);
        fs::write(&path, &bytes).unwrap();
        let kept = planned.command(&["check", "--keep"]);
        assert_eq!(kept.status.code(), Some(1), "it is found");
        let said = text(&kept.stdout);
        assert!(said.contains(&format!("Shard {shard}: {name}")), "{said}");
        assert_eq!(fs::read(&path).unwrap(), bytes, "it is left as it is");

        let redone = planned.command(&["check"]);
        assert_eq!(redone.status.code(), Some(1));
        let said = text(&redone.stdout).replace("\n", " ");
        let byte = format!("{name}: byte {place} is {:#04x}", bytes[place]);
        assert!(said.contains(&byte), "{byte}: {said}");
        others_stand(&planned, &before, shard);
    }
    assert_eq!(planned.rows(), rows);
    assert!(planned.command(&["check"]).status.success(), "all is sound");
}

/// All bytes are as they were, and of this shard alone the files are others.
fn others_stand(planned: &Planned, before: &BTreeMap<PathBuf, (u64, Vec<u8>)>, redone: u32) {
    let redone = planned.shard(redone);
    for (path, (inode, bytes)) in planned.files() {
        let (known, right) = &before[&path];
        assert_eq!(bytes, *right, "{}", path.display());
        assert_eq!(inode != *known, path.starts_with(&redone), "{}", path.display());
    }
}

#[test]
fn a_truncated_and_a_foreign_shard_are_named_and_ranked_again() {
    let planned = Planned::usual();
    let rows = planned.run_here();
    let truncated = planned.shard(2).join("candidates.parquet");
    let bytes = fs::read(&truncated).unwrap();
    fs::write(&truncated, &bytes[..bytes.len() / 2]).unwrap();
    // Shard 3 in the place of shard 4, and one of another study in the place of shard 5.
    let copy = |from: &Path, to: &Path| {
        for file in fs::read_dir(from).unwrap() {
            let file = file.unwrap();
            fs::copy(file.path(), to.join(file.file_name())).unwrap();
        }
    };
    copy(&planned.shard(3), &planned.shard(4));
    let other = Planned::new(&SPEC.replace("count = 3", "count = 4"), &[("a.scenario", POLE)]);
    run_shard(&other.dir, 4).unwrap();
    copy(&other.shard(4), &planned.shard(5));
    fs::create_dir(planned.shard(99)).unwrap();
    let before = planned.files();

    let said = text(&planned.command(&["check"]).stdout).replace('\n', " ");
    for fault in [
        "Shard 2, ranked again: candidates.parquet: truncated",
        "Shard 4, ranked again: foreign: it is shard 3",
        "Shard 5, ranked again: foreign: it is of study",
        "Shard 99: shards/000099: the study has no such shard",
    ] {
        assert!(said.contains(fault), "{fault}: {said}");
    }
    for (path, (inode, _)) in planned.files() {
        let is_redone = [2, 4, 5].iter().any(|shard| path.starts_with(planned.shard(*shard)));
        assert_eq!(before[&path].0 == inode, !is_redone, "{}", path.display());
    }
    assert_eq!(planned.rows(), rows);
    // Who runs a broken shard ranks it again as well.
    fs::write(&truncated, b"").unwrap();
    assert!(planned.command(&["run", "--jobs", "1"]).status.success());
    assert_eq!(planned.rows(), rows);
}

#[test]
fn every_so_many_rows_are_what_rank_says() {
    let planned = Planned::usual();
    planned.run_here();
    are_what_rank_says(&planned, 7);
    let said = planned.command(&["check", "--ranked-every", "7"]);
    assert!(said.status.success(), "{}", text(&said.stderr));
    assert!(text(&said.stdout).contains("11 of 11 rows equal trolley rank, 0 refused."));
}

#[test]
fn rows_of_members_and_worlds_are_what_rank_says() {
    let spec = SPEC.replace("scenes_per", "members = 4\nmembers_max = 8\nworlds = 30\nscenes_per");
    let spec = spec.replace("error_sigma = { values = [0, 1] }", "errors = { values = [0.5, 2] }");
    let planned = Planned::new(&spec, &[("a.scenario", POLE)]);
    let ran = planned.command(&["run", "--jobs", "2"]);
    assert!(ran.status.success(), "{}", text(&ran.stderr));
    are_what_rank_says(&planned, 5);
    let (mut shares, mut members) = (0, 0);
    for shard in 0..4 {
        let [contact, best] = ["contact_share", "best_share"].map(|it| planned.column(shard, it));
        let [count, worlds] = ["members", "worlds"].map(|it| planned.column(shard, it));
        for place in 0..count.rows() {
            assert_eq!(worlds.whole(place), Some(30));
            assert!(matches!(count.whole(place), Some(4 | 8)), "{:?}", count.whole(place));
            assert!((0.0..=1.0).contains(&best.real(place).unwrap()));
            let contact = contact.real(place).unwrap();
            shares += u32::from(contact > 0.0 && contact < 1.0);
            members += 1;
        }
    }
    assert_eq!(members, 36);
    assert!(shares > 0, "what is uncertain happens in some members");
    let again = Planned::new(&spec, &[("a.scenario", POLE)]);
    assert_eq!(again.run_here(), planned.rows(), "in one process as in children");
}

/// Multiples of a number among the rows are what `trolley rank` says of their scenes.
fn are_what_rank_says(planned: &Planned, every: i64) {
    let mut engine = Engine::builder().in_process().build().unwrap();
    let mut compared = 0;
    for shard in 0..status(&planned.dir).unwrap().shards {
        let (rows, hashes) = (planned.column(shard, "row"), planned.column(shard, "answer_hash"));
        for (place, row) in (0..rows.rows()).filter_map(|it| Some((it, rows.whole(it)?))) {
            if row % every != 0 {
                continue;
            }
            let out = planned.place.path().join(format!("row-{row}"));
            let written =
                planned.command(&["scene", &row.to_string(), "-o", out.to_str().unwrap()]);
            assert!(written.status.success(), "{}", text(&written.stderr));
            let scenario = out.join("scenario.toml");
            let opened = Scenario::open(&scenario).unwrap();
            let command = text(&written.stdout);
            let worlds = if command.contains("--worlds 30") { 30 } else { 200 };
            let limits = Limits::default().with_worlds(Worlds::new(worlds, 0).unwrap());
            let answer = engine.rank(&opened, &limits).unwrap().answer;
            let answer = serde_json::to_string(&answer).unwrap();
            let hash = blake3::hash(answer.as_bytes()).to_hex().to_string();
            assert_eq!(hashes.text(place), Some(hash.as_str()), "row {row}");
            // The program as well, by the command that `scene` names.
            let words: Vec<&str> = command.split_whitespace().collect();
            let ranked = trolley().args(&words[1..]).args(["--in-process", "--json"]).output();
            let ranked: serde_json::Value = support::json(&ranked.unwrap());
            let answer: serde_json::Value = serde_json::from_str(&answer).unwrap();
            assert_eq!(ranked["answer"], answer, "row {row}");
            compared += 1;
        }
    }
    assert!(compared >= 8);
}

#[test]
fn what_a_machine_refuses_and_a_changed_input_are_no_rows() {
    let rows = Planned::usual().run_here();
    let planned = Planned::usual();
    let input = planned.dir.join("inputs/0001/scenario.toml");
    let right = fs::read_to_string(&input).unwrap();
    for wrong in [None, Some(right.replace("straight on", "straight off"))] {
        fs::remove_file(&input).unwrap();
        if let Some(wrong) = &wrong {
            fs::write(&input, wrong).unwrap();
        }
        let ran = planned.command(&["run", "--jobs", "2"]);
        assert_eq!(ran.status.code(), Some(FailureKind::System as i32));
        let said = text(&ran.stderr);
        for shard in 3..8 {
            assert!(said.contains(&format!("Shard {shard} is not finished: ")), "{said}");
            // More often than a scene that takes its process down.
            for _ in 0..4 {
                let refused = run_shard(&planned.dir, shard).unwrap_err();
                assert_eq!(refused.kind(), FailureKind::System);
                assert!(refused.what().contains("inputs/0001/scenario.toml"), "{refused}");
            }
        }
        let found = status(&planned.dir).unwrap();
        assert_eq!((found.finished, found.refused, found.deaths), (3, 0, 0));
        fs::write(&input, &right).unwrap();
    }
    assert!(planned.command(&["run", "--jobs", "2"]).status.success());
    assert_eq!(planned.rows(), rows);

    // Descriptors for the standard streams and the scene in hand, and none for an input.
    let planned = Planned::usual();
    let mut command = std::process::Command::new("sh");
    command.args(["-c", "ulimit -n 4 && exec \"$@\"", "sh", env!("CARGO_BIN_EXE_trolley")]);
    let ran = command.args(["study", "run", "--shard", "0"]).arg(&planned.dir).output().unwrap();
    assert_eq!(ran.status.code(), Some(FailureKind::System as i32), "{}", text(&ran.stderr));
    assert!(text(&ran.stderr).contains("Too many open files"), "{}", text(&ran.stderr));
    assert_eq!(planned.run_here(), rows);
}

#[test]
fn a_scene_that_takes_too_long_is_a_row_and_the_study_ends() {
    // More than a millisecond, however quick the machine is.
    let spec = |limit_s: &str| {
        let keys = format!("members = 1024\nscene_limit_s = {limit_s}\nscenes_per");
        SPEC.replace("scenes_per", &keys).replace("count = 3", "count = 1").replace("1.2", "0.8")
    };
    let planned = Planned::new(&spec("0.001"), &[("a.scenario", POLE)]);
    let ran = planned.command(&["run", "--jobs", "2"]);
    assert!(ran.status.success(), "{}", text(&ran.stderr));
    let found = status(&planned.dir).unwrap();
    assert_eq!((found.finished, found.refused, found.rows[0]), (2, 12, 12));
    let refusal = planned.column(1, "refusal");
    let why = "it took longer than 0.001 s, the scene_limit_s of the study";
    assert_eq!(refusal.text(0), Some(why));
    let said = planned.command(&["check", "--ranked-every", "1"]);
    assert!(text(&said.stdout).contains("0 of 0 rows"), "another machine may be quicker");
    assert!(text(&said.stdout).contains("Left out: 12"));
    // A limit that is not reached changes nothing: fewer members, as these take their time.
    let [usual, limited] = ["", "scene_limit_s = 3600\n"].map(|key| {
        let spec = SPEC.replace("scenes_per", &format!("members = 4\n{key}scenes_per"));
        let planned = Planned::new(&spec, &[("a.scenario", POLE)]);
        run_shard(&planned.dir, 0).unwrap();
        planned.column(0, "answer_hash")
    });
    assert!(usual.text(0).is_some());
    assert_eq!(usual, limited);
}

#[test]
fn a_scene_that_cannot_be_ranked_is_a_row_with_the_reason() {
    let unknown = POLE.replace("[parties.pole]", "[parties.pole]\nkind = \"unknown\"");
    let turning = POLE.replace("speed_m_s = 9", "speed_m_s = 9, yaw_rate_deg_s = 5");
    let broken = POLE.replace("shape = \"pole\"", "shape = \"polle\"");
    let spec =
        SPEC.replace("error_sigma = { values = [0, 1] }", "reaction_s = { values = [0, 1] }");
    let inputs = [
        ("a.scenario", POLE),
        ("b.scenario", &unknown),
        ("c.scenario", &turning),
        ("d.scenario", &broken),
    ];
    let planned = Planned::new(&spec, &inputs);
    planned.run_here();
    let mut refusals: BTreeMap<i64, Vec<String>> = BTreeMap::new();
    for shard in 0..Plan::open(&planned.dir).unwrap().shards() {
        let (input, refusal) = (planned.column(shard, "input"), planned.column(shard, "refusal"));
        for place in 0..input.rows() {
            let reasons = refusals.entry(input.whole(place).unwrap()).or_default();
            reasons.extend(refusal.text(place).map(str::to_owned));
        }
    }
    let counts: Vec<usize> = refusals.values().map(Vec::len).collect();
    assert_eq!(counts, [0, 36, 18, 36], "of 36 rows each");
    assert!(refusals[&1][0].contains("inputs/0001/scenario.toml"), "{}", refusals[&1][0]);
    assert!(refusals[&1][0].contains("of unknown kind"), "{}", refusals[&1][0]);
    assert!(refusals[&2][0].contains("reaction_s = 1: candidate"), "{}", refusals[&2][0]);
    assert!(refusals[&3][0].contains("d.scenario:10:22: "), "{}", refusals[&3][0]);
    let said = planned.command(&["check", "--ranked-every", "3"]);
    assert!(text(&said.stdout).contains("48 of 48 rows equal trolley rank, 30 refused."));
}

#[test]
fn a_scene_that_kills_three_processes_is_a_row_and_the_study_ends() {
    let planned = Planned::new(&SPEC.replace("= 5", "= 100"), &[("a.scenario", POLE)]);
    // A child that dies of scene 7, as long as fewer than three died of it.
    let program = planned.place.write(
        "child",
        &format!(
            "#!/bin/sh\n\
             for last; do :; done\n\
             if [ $(grep -c '^died' $last/attempts/000000.log 2>/dev/null || true) -lt 3 ]; then\n\
               read shard\n\
               printf 00000000000000000007 > $last/attempts/000000.hand\n\
               kill -9 $$\n\
             fi\n\
             exec {} \"$@\"\n",
            env!("CARGO_BIN_EXE_trolley")
        ),
    );
    fs::write(planned.dir.join("attempts/000000.log"), "begin here 1\n").unwrap();
    fs::set_permissions(&program, fs::Permissions::from_mode(0o755)).unwrap();
    let options = RunOptions { program, jobs: Some(1), memory_bytes: 4 << 30 };
    let done = study::run(&planned.dir, &options, &|_, _| {}).unwrap();
    assert_eq!((done.finished, done.deaths, done.failed.len()), (1, 3, 0), "{done:?}");
    let (scene, refusal) = (planned.column(0, "scene"), planned.column(0, "refusal"));
    for place in 0..scene.rows() {
        let is_poison = scene.whole(place) == Some(7);
        assert_eq!(refusal.text(place).is_some(), is_poison);
        assert!(!is_poison || refusal.text(place).is_some_and(|why| why.contains("died, 3 times")));
    }
    let log = fs::read_to_string(planned.dir.join("attempts/000000.log")).unwrap();
    assert_eq!(log.lines().filter(|line| *line == "died 7 SIGKILL").count(), 3, "{log}");
}

#[test]
fn another_specification_or_a_changed_plan_is_refused() {
    let planned = Planned::usual();
    let spec = planned.place.path().join("spec.toml");
    assert!(study::plan(&spec, &planned.dir).is_ok(), "the same study again");
    let other = planned.place.write("other.toml", &SPEC.replace("0.8", "0.9"));
    let refused = study::plan(&other, &planned.dir).unwrap_err();
    assert!(refused.what().contains("another study"), "{refused}");
    let plan = planned.dir.join("plan.json");
    let changed = fs::read_to_string(&plan).unwrap().replacen("0.8", "0.7", 1);
    fs::write(&plan, changed).unwrap();
    let refused = Plan::open(&planned.dir).unwrap_err();
    assert!(refused.what().contains("it was changed"), "{refused}");
}

#[test]
fn a_page_needs_no_network_and_links_to_records_that_replay() {
    let planned = Planned::usual();
    planned.run_here();
    let out = planned.place.path().join("page.html");
    let reported = planned.command(&["report", "-o", out.to_str().unwrap()]);
    assert!(reported.status.success(), "{}", text(&reported.stderr));
    let page = fs::read_to_string(&out).unwrap();
    assert!(page.contains("default-src 'none'"), "it may fetch nothing");
    assert!(!page.contains("://") && !page.contains(" src="), "it fetches nothing");
    let mut replayed = 0;
    for link in page.split("href=\"").skip(1).filter_map(|rest| rest.split('"').next()) {
        let file = planned.place.path().join(link);
        assert!(file.is_file(), "{link}");
        if link.ends_with(".record") {
            let replay = trolley().args(["record", "replay"]).arg(&file).output().unwrap();
            assert!(replay.status.success(), "{link}: {}", text(&replay.stderr));
            replayed += 1;
        }
    }
    assert!(replayed > 0, "there are worst cases");
}
