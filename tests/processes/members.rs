//! A real service over members: expected harm as `trolley rank` has it, late stages, and decisions
//! that replay.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use crate::serve::{WALL, connect, into_a_wall};
use crate::support::service::{deployment, serve, shipped};
use crate::support::service::{expected_harm, with_members};
use crate::support::{Place, patience, run, text, wait_for};
use client::public::{
    Ask, PartyErrors, WireAnswer, WireParty, WirePath, WirePathKind, WirePathState, WirePlace,
    WireState, flag,
};
use std::time::Duration;

/// States how far the wall may be to its left (m).
pub(crate) fn known_by(ask: &mut Ask, lateral_m: f64) {
    let errors = PartyErrors { lateral_m: Some(lateral_m), ..PartyErrors::default() };
    ask.parties[1] = ask.parties[1].with_errors(&errors);
}

#[test]
fn expected_harm_is_that_of_rank_in_every_bit_with_workers_and_without() {
    let place = Place::new();
    let stated = shipped("config/scenarios/wall-or-pole.toml");
    let text_of = std::fs::read_to_string(&stated).unwrap();
    let drawn = place.write("members.toml", &with_members(&text_of, 8, 16));
    let rank = |scenario: &std::path::Path, more: &[&str]| {
        expected_harm(&run(&[&["rank", scenario.to_str().unwrap(), "--json"], more].concat()))
    };
    let three = ["--members", "3", "--members-max", "3"];
    let expected = rank(&drawn, &[]);
    assert!(expected.contains("\"worlds\"") && expected.contains("\"lead\""), "{expected}");
    let of_errors = rank(&drawn, &three);
    let usual = rank(&stated, &three);
    assert_ne!(of_errors, usual, "errors that are stated count");
    let table = text(&run(&["rank", drawn.to_str().unwrap()]).stdout);
    let file = deployment(&place, 2, &[("sedan", 20_000, 0), ("pole", 2000, 0), ("wall", 2000, 0)]);
    let text_of = std::fs::read_to_string(&file).unwrap();
    for extra in [&[][..], &["--in-process"]] {
        let serving = serve(&file, extra);
        let query = |scenario: &std::path::Path, more: &[&str]| {
            expected_harm(&serving.query(scenario, &[&["--json"], more].concat()))
        };
        assert_eq!(query(&drawn, &[]), expected, "{extra:?}");
        assert_eq!(query(&drawn, &three), of_errors, "{extra:?}");
        assert_eq!(query(&stated, &three), usual, "{extra:?}");
        let people = text(&serving.query(&drawn, &[]).stdout);
        let mut rows = table.lines().skip_while(|line| !line.starts_with('#'));
        let rows: Vec<&str> = rows.by_ref().take_while(|line| !line.is_empty()).collect();
        assert!(rows.len() >= 4 && people.starts_with(&rows.join("\n")), "{people} {table}");
        for words in ["Harm is the mean over", "give or take", "Of 200 worlds"] {
            assert!(people.contains(words), "{words}: {people}");
        }
        serving.end();
    }
    // The deployment says how many where a scenario says nothing.
    let usually = "members = 3\nmembers_max = 3\n";
    let file = place.write("deployment.toml", &text_of.replacen("members = 1\n", usually, 1));
    let serving = serve(&file, &["--in-process"]);
    let query = |scenario: &std::path::Path| expected_harm(&serving.query(scenario, &["--json"]));
    assert_eq!((query(&stated), query(&drawn)), (usual, expected));
    serving.end();
}

/// Two ways that are each other's mirror image, each into an oncoming car whose speed is not well
/// known: with four and with eight members too close to call, with sixteen not.
fn close_call(members: u32, members_max: u32) -> Box<Ask> {
    let mut ask = Ask::new(3.0);
    let known = PartyErrors { speed_share: Some(0.3), ..PartyErrors::default() };
    let goes_on = WirePath::of_kind(WirePathKind::Onward);
    for y in [-4.0, 4.0] {
        let car = WirePathState::at(0.0, [20.0, y], 180.0).with_velocity([-8.0, 0.0]);
        ask.add_party_on(WireParty::of_model(1).with_errors(&known), goes_on, &[car]).unwrap();
    }
    ask.ego = ask.add_party(WireParty::of_model(1)).unwrap();
    for y in [-3.0, 3.0] {
        let now = WirePathState::at(0.0, [0.0, 0.0], 0.0).with_velocity([12.0, y]);
        let path = ask.add_path(goes_on, &[now]).unwrap();
        ask.add_candidate(path, &[]).unwrap();
    }
    ask.set_members(members, members_max);
    ask
}

/// What does not depend on when an answer is given, but for worlds: they are drawn of what is done;
/// and but for whether there was time for members.
fn figures(answer: &WireAnswer) -> Vec<WirePlace> {
    let without = |place: &WirePlace| {
        let mut place = *place;
        place.expected.worlds = f64::NAN;
        place.flags &= !flag::STATED_ALONE;
        place
    };
    answer.ranking().iter().map(without).collect()
}

/// At a deadline the last finished stage is the answer, and says so.
#[test]
fn what_is_late_is_the_stage_before_and_says_so() {
    let place = Place::new();
    let serving = serve(&deployment(&place, 1, WALL), &["--in-process"]);
    let mut client = connect(&serving.instance);
    let complete = client.ask(&close_call(4, 64), patience());
    let took = Duration::from_nanos(complete.worked_ns);
    assert_eq!((complete.verdict(), complete.members), (WireState::Complete, 16));
    let (mean, error) = complete.lead().unwrap();
    assert!(mean > error && complete.worlds == 200 && !complete.is_late());
    let mut tries = 0;
    let (late, open) = wait_for(60_000, || {
        tries = tries % 15 + 1;
        let answer = client.ask(&close_call(4, 64), took * tries / 16);
        // An answer may come after its client has given up, or be complete all the same.
        let is_late = answer.verdict() == WireState::Degraded && answer.is_late();
        // With 1 there was no time for members at all.
        let is_late = is_late && answer.members > 1;
        is_late.then_some((answer, answer.members))
    })
    .expect("a deadline between two stages");
    assert!([4, 8].contains(&open) && late.members_max == 64);
    assert_eq!((late.worlds, late.flags & flag::WORLDS), (0, 0));
    assert!(late.ranking().iter().all(|place| place.expected.worlds.is_nan()));
    let stage = client.ask(&close_call(open, open), patience());
    assert_eq!((stage.verdict(), stage.lead()), (WireState::Complete, late.lead()));
    assert_eq!(figures(&late), figures(&stage));
    // A deadline within the first stage: nothing that is not known is a number.
    let partial = wait_for(60_000, || {
        tries = tries % 15 + 1;
        let answer = client.ask(&close_call(16, 16), took * tries / 32);
        let is_part = answer.verdict() == WireState::Degraded && answer.members < 16;
        is_part.then_some(answer)
    });
    // Then the answer is of the part that was finished: of fewer members, or as stated.
    let partial = partial.expect("a deadline within a stage");
    let count = partial.members;
    assert!([1, 4, 8].contains(&count), "{count}");
    let part = client.ask(&close_call(count, count), patience());
    assert_eq!((partial.is_late(), part.verdict()), (true, WireState::Complete));
    let is_stated_alone = |place: &WirePlace| place.flags & flag::STATED_ALONE != 0;
    assert!(partial.ranking().iter().all(|place| is_stated_alone(place) == (count == 1)));
    let is_known = partial.ranking().iter().all(|place| place.work[0] == place.work[1]);
    if is_known || count > 1 {
        assert_eq!(figures(&partial), figures(&part));
    }
    drop(client);
    serving.end();
}

/// A request of a kept decision, ranked again in this process, has the same answer.
#[test]
fn a_decision_over_members_replays_in_every_bit() {
    let place = Place::new();
    let file = deployment(&place, 2, WALL);
    let text = std::fs::read_to_string(&file).unwrap();
    let kept = "[decisions]\nfolder = \"kept\"\n[engine]";
    std::fs::write(&file, text.replace("[engine]", kept)).unwrap();
    let serving = serve(&file, &[]);
    let mut client = connect(&serving.instance);
    let asked = [close_call(4, 16), close_call(1, 1), into_a_wall(), close_call(3, 3)];
    let answers = asked.each_ref().map(|ask| client.ask(ask, patience()));
    drop(client);
    serving.end();
    let entries = service::read_decisions(&place.path().join("kept/decisions-00000000.bin"));
    let entries = entries.unwrap();
    assert_eq!(entries.len(), asked.len());
    let opened = trolley::OpenDeployment::open(&file, None).unwrap();
    let bodies = trolley::bodies::Bodies::of_deployment(&opened).unwrap();
    let views = bodies.views().unwrap();
    let (criteria, depth) = (opened.criteria().unwrap(), opened.deployment.engine.depth);
    let mut twin = service::InProcess::new(&opened.deployment, &views, criteria, depth);
    for (entry, answer) in entries.iter().zip(&answers) {
        assert_eq!(entry.answer, *answer);
        assert_eq!(answer.verdict(), WireState::Complete, "{}", answer.text());
        let again = twin.answer(&entry.ask);
        // When it was given, and as which one of its service, is no part of it.
        let WireAnswer { request, queued_ns, worked_ns, .. } = *answer;
        let again = WireAnswer { request, queued_ns, worked_ns, ..again }.sealed();
        assert_eq!(again, *answer);
    }
    assert_eq!(answers.map(|answer| answer.members), [16, 1, 1, 3]);
}
