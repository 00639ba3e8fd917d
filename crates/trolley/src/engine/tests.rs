//! From a scenario to an answer and back from its record, without a process or a channel.

use super::*;
use crate::bodies::SILENT;
use crate::record::{Record, VerifyOptions};
use crate::{Limits, Scenario};
use record::Mode;

fn in_process() -> Engine {
    Engine::builder().in_process().build().unwrap()
}

/// Two crashes of small bodies.
fn text(speed_m_s: f64) -> String {
    format!(
        "schema = \"trolley.scenario/2\"\nname = \"two\"\n[parties.ego]\n\
         generate = {{ shape = \"sedan\", triangles = 1500 }}\n[parties.pole]\n\
         generate = {{ shape = \"pole\", triangles = 600 }}\n\
         place = {{ position_m = [20, 0, 0] }}\n\
         [[candidates]]\nname = \"middle\"\n\
         state = {{ position_m = [0, 0, 0], speed_m_s = {speed_m_s:?} }}\n\
         [[candidates]]\nname = \"past\"\npath = {{ states = [ \
         {{ t_s = 0, position_m = [0, 0, 0] }}, {{ t_s = 2, position_m = [20, 3, 0] }} ] }}\n"
    )
}

fn scenario(speed_m_s: f64) -> Scenario {
    Scenario::parse("two.toml", &text(speed_m_s)).unwrap()
}

#[test]
fn a_scenario_is_ranked_without_a_process() {
    let ranking = in_process().rank(&scenario(12.0), &Limits::default()).unwrap();
    assert_eq!(ranking.answer.state, damage::AnswerState::Complete);
    assert_eq!(ranking.best().map(|best| best.name.as_str()), Some("past"));
    assert_eq!(ranking.run.mode, Mode::InProcess);
    assert!(ranking.run.jobs > 0 && ranking.run.workers.is_empty());
    assert!(ranking.explanation.is_none());
}

/// Whatever a ranking does, some stage counts it. Of several rankings the one counts that was
/// disturbed least.
#[test]
fn stages_leave_no_time_out() {
    let mut engine = in_process();
    let limits = Limits::default().with_members(64, Some(64)).unwrap();
    let left_out = (0..10).map(|_| {
        let begun_ns = runtime::clock::now_ns();
        let stages = engine.rank(&scenario(12.0), &limits).unwrap().run.stages;
        let took_ms = (runtime::clock::now_ns() - begun_ns) as f64 / 1e6;
        let counted = [stages.load_ms, stages.plan_ms, stages.start_ms, stages.work_ms];
        let counted = counted.iter().sum::<f64>() + stages.assess_ms + stages.worlds_ms;
        1.0 - counted / took_ms
    });
    let least = left_out.fold(f64::INFINITY, f64::min);
    assert!((0.0..0.05).contains(&least), "{:.1} % of the time", 100.0 * least);
}

#[test]
fn the_same_bodies_are_kept_and_others_take_their_place() {
    let mut engine = in_process();
    let limits = Limits::default();
    let answers = [12.0, 9.0, 12.0].map(|speed| engine.rank(&scenario(speed), &limits).unwrap());
    assert_eq!(answers[0].answer, answers[2].answer);
    assert!(answers[0].answer != answers[1].answer);
    let kept = engine.loaded.as_ref().and_then(|loaded| loaded.extremes.as_ref());
    assert_eq!(kept.map(Vec::len), Some(2), "bodies asked about again are known better");
    let other = Scenario::parse("two.toml", &text(12.0).replace("600", "700")).unwrap();
    let answer = engine.rank(&other, &limits).unwrap().answer;
    assert_eq!(answer, in_process().rank(&other, &limits).unwrap().answer);
}

#[test]
fn bodies_of_a_cache_give_the_answers_of_new_ones() {
    let mut engine = Engine::builder().in_process().body_cache(16 << 20).build().unwrap();
    let limits = Limits::default();
    for triangles in ["600", "700", "600", "800", "700"] {
        let other = text(12.0).replace("600", triangles);
        let other = Scenario::parse("two.toml", &other).unwrap();
        let answer = engine.rank(&other, &limits).unwrap().answer;
        assert_eq!(answer, in_process().rank(&other, &limits).unwrap().answer);
    }
    assert_eq!(engine.cached_bodies().0, 4, "the ego and three poles");
    let mut small = Engine::builder().in_process().body_cache(100_000).build().unwrap();
    small.rank(&scenario(12.0), &limits).unwrap();
    assert_eq!(small.cached_bodies().0, 1, "the ego alone is larger");
}

#[test]
fn a_ranking_is_recorded_and_made_again() {
    let folder = tempfile::tempdir().unwrap();
    let scenario = scenario(12.0);
    let bare = in_process().rank(&scenario, &Limits::default()).unwrap();
    let refused = Record::write(folder.path(), &bare).unwrap_err();
    assert!(refused.what().contains("job history") && refused.remedy().is_some(), "{refused}");
    let mut paths = Vec::new();
    for _ in 0..2 {
        let ranking = in_process().rank(&scenario, &Limits::default().with_record()).unwrap();
        paths.push(Record::write(folder.path(), &ranking).unwrap());
    }
    let verified = Record::verify(folder.path(), &VerifyOptions::default()).unwrap();
    assert_eq!(verified.count, 2);
    let record = Record::read(&paths[1]).unwrap();
    assert!(record.is_of_this_build() && record.link.number == 1);
    let replay = record.replay(&paths[1], None, SILENT).unwrap();
    assert_eq!(replay.json, record.content.answer);
    assert_eq!(replay.answer, bare.answer);
}

#[test]
fn what_cannot_be_ranked_is_refused_with_a_remedy() {
    let unknown =
        text(12.0).replace("triangles = 600 }\n", "triangles = 600 }\nkind = \"unknown\"\n");
    let unknown = Scenario::parse("two.toml", &unknown).unwrap();
    let failure = in_process().rank(&unknown, &Limits::default()).unwrap_err();
    assert_eq!(failure.kind(), crate::FailureKind::Refused, "{failure}");
    assert!(failure.what().starts_with("two.toml:5:") && failure.remedy().is_some(), "{failure}");
    let answer =
        in_process().rank(&unknown.assuming_unknown_is_fixed(), &Limits::default()).unwrap();
    assert!(!answer.answer.assumptions.is_empty());
    let failure = Engine::builder().workers(17).build().unwrap_err();
    assert_eq!(failure.kind(), crate::FailureKind::Configuration, "{failure}");
}

#[test]
fn the_same_bodies_in_other_parts_are_checked_again() {
    let mut engine = in_process();
    let limits = Limits::default();
    engine.rank(&scenario(12.0), &limits).unwrap();
    let of_pole = "shape = \"pole\", triangles = 600 }\n";
    let text = text(12.0).replace(of_pole, &format!("{of_pole}persons = [{{}}]\n"));
    let wrong = Scenario::parse("two.toml", &text);
    let expected = wrong.clone().and_then(|wrong| in_process().rank(&wrong, &limits).map(drop));
    let found = wrong.and_then(|wrong| engine.rank(&wrong, &limits).map(drop));
    assert_eq!(found.unwrap_err(), expected.unwrap_err());
}

#[test]
fn a_budget_cannot_be_recorded() {
    let limits = Limits::default().with_record().with_budget(100_000).unwrap();
    let failure = in_process().rank(&scenario(12.0), &limits).unwrap_err();
    assert_eq!(failure.kind(), crate::FailureKind::Configuration, "{failure}");
}
