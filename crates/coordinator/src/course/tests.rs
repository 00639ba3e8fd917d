//! Whole rankings over a horizon of scenes whose answer follows from the scene.

use super::assessed_contact::{assessed, contact, settle};
use super::member::Member;
use super::persons::People;
use super::way::Scenery;
use super::*;
use crate::fixtures::{body, cuboid, sedan_of};
use crate::in_process::InProcessExecutor;
use crate::request::Request;
use crate::work::SurveyRun;
use body::{Body, BodyView, Meta, Shape};
use bvh::support::support_near;
use damage::{AnswerState, Criteria, Policy};
use executor::encounter::Encounters;
use geometry::DVec3;
use scenario::Members;
use std::ops::ControlFlow;
use std::sync::Arc;

mod mirrors;

/// Ranks a scenario whose parties, by name, have these bodies; and its replay gives that answer.
fn ranked_within(text: &str, bodies: &[&Body], limits: RequestLimits) -> Answer {
    worked_within(text, bodies, limits).answer
}

/// The answer, and what a picture of it is drawn from.
pub(super) fn drawn(text: &str, bodies: &[&Body]) -> (Answer, PlanScene) {
    let ranked = worked_within(text, bodies, RequestLimits::default());
    (ranked.answer, ranked.scene.expect("it was requested"))
}

/// What all the work on it gave.
pub(super) fn worked_within(text: &str, bodies: &[&Body], limits: RequestLimits) -> RankedCourses {
    attempted(text, bodies, limits).expect("it can be ranked")
}

/// The same of what may be refused.
pub(super) fn attempted(
    text: &str,
    bodies: &[&Body],
    limits: RequestLimits,
) -> Result<RankedCourses, RunError> {
    with_request(text, bodies, |stage, request| {
        let executor = InProcessExecutor::with_room_for(stage.bodies);
        let mut backend = Backend::InProcess(Box::new(executor));
        let ranked = rank_courses(stage, request, limits, &mut backend)?;
        let history = ranked.history.as_ref().expect("it was requested");
        let again = replay_courses(stage, request, history).expect("it can be ranked again");
        assert_eq!(format!("{:?}", again.answer), format!("{:?}", ranked.answer));
        assert_eq!(again.explanation, ranked.explanation);
        Ok(ranked)
    })
}

/// Does something with a scene and the request to rank it.
pub(super) fn with_request<T>(
    text: &str,
    bodies: &[&Body],
    work: impl FnOnce(&BodySet<'_>, &CourseRequest<'_>) -> T,
) -> T {
    let head = "schema = \"trolley.scenario/2\"\nname = \"test\"\n";
    let scenario = Scenario::parse("test.toml", &format!("{head}{text}"))
        .unwrap_or_else(|error| panic!("{error}\n{text}"));
    let views: Vec<(Meta, BodyView<'_>)> =
        bodies.iter().map(|body| (body.meta.clone(), body.view())).collect();
    let models: Vec<usize> = (0..views.len()).collect();
    let stage = BodySet { bodies: &views, extremes: None, depth: 3 };
    let policy = Policy::shipped().expect("sound");
    let criteria = Criteria::with_policy(policy).expect("sound");
    let shells: Vec<Shells> = views.iter().map(|(_, view)| Shells::of(view.corners)).collect();
    let request = CourseRequest {
        scenario: &scenario,
        models: &models,
        shells: &shells,
        criteria,
        members: scenario.members.unwrap_or(Members::NOMINAL),
        worlds: scenario::Worlds::USUAL,
        history: true,
        explanation: true,
        scene: true,
    };
    work(&stage, &request)
}

fn ranked(text: &str, bodies: &[&Body]) -> Answer {
    ranked_within(text, bodies, RequestLimits::default())
}

/// A party of any body, as the reader wants it: bodies are passed beside the text.
pub(super) fn party(name: &str, shape: &str, rest: &str) -> String {
    format!("[parties.{name}]\ngenerate = {{ shape = \"{shape}\", triangles = 900 }}\n{rest}\n")
}

pub(super) fn ego() -> String {
    party("ego", "sedan", "persons = [{ seat = \"front-left\" }]")
}

pub(super) fn go_on(speed_m_s: f64) -> String {
    format!(
        "[[candidates]]\nname = \"go on\"\nstate = {{ position_m = [0, 0, 0], speed_m_s = \
         {speed_m_s:?} }}\n"
    )
}

fn only(answer: &Answer) -> &CourseRow {
    assert_eq!((answer.ranking.len(), answer.state), (1, AnswerState::Complete), "{answer:#?}");
    &answer.ranking[0]
}

fn met(row: &CourseRow) -> Vec<&str> {
    row.contacts.iter().map(|contact| contact.party.as_str()).collect()
}

#[test]
fn who_pulls_away_or_walks_behind_is_not_struck() {
    let (sedan, person) = (body(Shape::Sedan, 900), body(Shape::Pedestrian, 900));
    let lead = party("lead", "sedan", "state = { position_m = [5.5, 0, 0], speed_m_s = 15 }");
    let behind =
        party("behind", "pedestrian", "state = { position_m = [-5.3, 0, 0], speed_m_s = 1 }");
    // Sorted by name: behind, ego, lead.
    let answer =
        ranked(&format!("{behind}{}{lead}{}", ego(), go_on(12.0)), &[&person, &sedan, &sedan]);
    let row = only(&answer);
    assert!(row.touches_nobody(), "{row:#?}");
    let near = row.nearest.as_ref().expect("somebody is there");
    assert!(near.party == "lead" && near.time_s == 0.0 && near.gap_m > 0.5, "{near:?}");
}

#[test]
fn who_is_13_m_ahead_is_struck() {
    let (sedan, person) = (body(Shape::Sedan, 900), body(Shape::Pedestrian, 900));
    let walker = party("walker", "pedestrian", "place = { position_m = [13, 0, 0], yaw_deg = 90 }");
    let answer = ranked(&format!("{}{walker}{}", ego(), go_on(20.0)), &[&sedan, &person]);
    let row = only(&answer);
    assert_eq!(met(row), ["walker"]);
    assert_eq!(row.contacts[0].severity, Severity::Light, "75 kg hardly slow a car down");
    let walker = row.persons.iter().find(|person| person.party == "walker").expect("at stake");
    assert!(walker.work.lo() > 0.1, "{walker:?}");
    assert!(
        row.run_outs.is_empty() && row.at_horizon.as_ref().is_some_and(|end| end.time_s == 5.0)
    );
}

#[test]
fn persons_are_there_though_they_stand_still() {
    let (sedan, bus) = (body(Shape::Sedan, 900), body(Shape::Bus, 900));
    let (cyclist, motorcycle) = (body(Shape::Cyclist, 900), body(Shape::Motorcycle, 900));
    let place = |x: f64| format!("place = {{ position_m = [{x:?}, 0, 0] }}");
    let count = |row: &CourseRow, party: &str| {
        row.persons.iter().filter(|person| person.party == party).count()
    };
    for (name, kind, other, said, expected) in [
        ("cyclist", "cyclist", &cyclist, "", 1),
        ("queue", "sedan", &sedan, "", 1),
        ("bus", "bus", &bus, "", 10),
        ("bus", "bus", &bus, "persons = [{ seat = \"front-left\" }, { count = 49 }]\n", 50),
        ("parked", "sedan", &sedan, "empty = true\n", 0),
        (
            "two",
            "motorcycle",
            &motorcycle,
            "persons = [{ seat = \"rider\" }, { seat = \"pillion\" }]\n",
            2,
        ),
    ] {
        let other_party = party(name, kind, &format!("{said}{}", place(30.0)));
        let text = format!("{}{other_party}{}", ego(), go_on(15.0));
        // Parties are sorted by name.
        let bodies = if name < "ego" { [other, &sedan] } else { [&sedan, other] };
        let answer = ranked(&text, &bodies);
        let row = only(&answer);
        assert_eq!(met(row), [name]);
        assert_eq!(count(row, name), expected, "{name}");
        let harmed = row.persons.iter().filter(|person| person.party == name);
        assert!(harmed.clone().all(|person| person.work.lo() > 0.0), "{name}: {row:#?}");
        // Where nobody said who is there, the range begins at nobody.
        if said.is_empty() {
            assert!(harmed.clone().all(|person| person.range.low() == 0.0), "{name}");
            assert!(!answer.assumptions.is_empty());
        }
    }
}

#[test]
fn a_standing_ego_has_its_persons_and_is_struck() {
    let sedan = body(Shape::Sedan, 900);
    let other = party("other", "sedan", "state = { position_m = [-20, 0, 0], speed_m_s = 15 }");
    let stand =
        "[[candidates]]\nname = \"stand\"\nstate = { position_m = [0, 0, 0], speed_m_s = 0 }\n";
    let answer = ranked(&format!("{}{other}{stand}", ego()), &[&sedan, &sedan]);
    let row = only(&answer);
    assert_eq!(met(row), ["other"]);
    let contact = &row.contacts[0];
    assert_eq!((contact.sides.as_str(), contact.severity), ("rear ↔ front", Severity::Heavy));
    assert!(row.persons.iter().any(|person| person.party == "ego" && person.work.lo() > 0.0));
    // Struck from behind, it runs out ahead, at about half the speed of the other one.
    let run_out = row.run_outs.first().expect("a heavy contact");
    assert!((run_out.velocity_m_s[0] - 8.25).abs() < 0.2, "{run_out:?}");
}

#[test]
fn a_light_contact_drives_on_and_a_heavy_one_runs_out() {
    let (sedan, person, wall) =
        (body(Shape::Sedan, 900), body(Shape::Pedestrian, 900), body(Shape::Wall, 900));
    let walker = |name: &str, x: f64| {
        party(name, "pedestrian", &format!("place = {{ position_m = [{x:?}, 0, 0] }}"))
    };
    let wall_ahead = party("wall", "wall", "place = { position_m = [40, 0, 0], yaw_deg = 90 }");
    let text =
        format!("{}{}{}{wall_ahead}{}", ego(), walker("a", 20.0), walker("b", 30.0), go_on(15.0));
    let answer = ranked(&text, &[&person, &person, &sedan, &wall]);
    let row = only(&answer);
    assert_eq!(met(row), ["a", "b", "wall"]);
    let severities: Vec<Severity> = row.contacts.iter().map(|contact| contact.severity).collect();
    assert_eq!(severities, [Severity::Light, Severity::Light, Severity::Heavy]);
    let times: Vec<f64> = row.contacts.iter().map(|contact| contact.time_s).collect();
    assert!(times.is_sorted() && (times[1] - times[0] - 10.0 / 15.0).abs() < 1e-6, "{times:?}");
    // A person's risk is that of all contacts together: the driver is in all three.
    let driver = row.persons.iter().find(|person| person.party == "ego").expect("at stake");
    let alone = |contact: &ContactRow| {
        let driver = contact.persons.iter().find(|person| person.party == "ego");
        1.0 - driver.map_or(0.0, |driver| driver.work.hi())
    };
    let expected = 1.0 - row.contacts.iter().map(alone).product::<f64>();
    assert!((driver.work.hi() - expected).abs() < 1e-12, "{} {expected}", driver.work.hi());
    // It bounces off the wall at a tenth of its speed, backwards, and stands.
    let run_out = row.run_outs.first().expect("a heavy contact");
    assert!((run_out.velocity_m_s[0] + 1.5).abs() < 0.05, "{run_out:?}");
    let end = row.at_horizon.as_ref().expect("all is known");
    assert!(end.time_s < 5.0 && end.speed_m_s == 0.0);
}

#[test]
fn a_run_out_meets_whom_the_plan_would_have_missed() {
    let (sedan, person) = (body(Shape::Sedan, 900), body(Shape::Pedestrian, 900));
    // The plan stops before the walker; a truck-like push from behind does not let it.
    let walker = party("walker", "pedestrian", "place = { position_m = [4, 0, 0] }");
    let other = party("other", "sedan", "state = { position_m = [-20, 0, 0], speed_m_s = 20 }");
    let stand =
        "[[candidates]]\nname = \"stand\"\nstate = { position_m = [0, 0, 0], speed_m_s = 0 }\n";
    let answer = ranked(&format!("{}{other}{walker}{stand}", ego()), &[&sedan, &sedan, &person]);
    let row = only(&answer);
    assert_eq!(met(row), ["other", "walker"]);
    assert_eq!(row.run_outs.len(), 1);
}

#[test]
fn a_touch_of_a_mirror_does_not_hide_the_crash_that_follows() {
    // A mirror strikes a walker who stands beside the way; the car ahead is struck all the same.
    let mut corners = cuboid([-2.2, -0.9, 0.3], [2.2, 0.9, 1.5]);
    corners.extend(cuboid([-0.01, 0.9, 1.0], [0.01, 1.1, 1.15]));
    let ego_body = sedan_of(corners);
    let (sedan, person) = (body(Shape::Sedan, 900), body(Shape::Pedestrian, 900));
    let place = "place = { position_m = [10, 1.15, 0], yaw_deg = 90 }";
    let walker = party("walker", "pedestrian", place);
    let ahead = party("queue", "sedan", "place = { position_m = [20, 0, 0] }\nempty = true");
    let text = format!("{}{ahead}{walker}{}", ego(), go_on(10.0));
    let answer = ranked(&text, &[&ego_body, &sedan, &person]);
    let row = only(&answer);
    assert_eq!(met(row), ["walker", "queue"], "{row:#?}");
    assert_eq!(row.contacts[1].severity, Severity::Heavy);
}

#[test]
fn who_touches_at_the_start_closes_parts_or_is_refused() {
    let sedan = body(Shape::Sedan, 900);
    let state = |speed: f64| {
        let state = format!("state = {{ position_m = [4.2, 0, 0], speed_m_s = {speed:?} }}");
        party("other", "sedan", &state)
    };
    // Half a metre into the other one's rear.
    let answer = ranked(&format!("{}{}{}", ego(), state(0.0), go_on(10.0)), &[&sedan, &sedan]);
    let row = only(&answer);
    assert!(row.contacts[0].is_at_start && row.contacts[0].time_s == 0.0, "{row:#?}");
    assert!(row.remarks.iter().any(|remark| remark.contains("they close")), "{:?}", row.remarks);
    let answer = ranked(&format!("{}{}{}", ego(), state(20.0), go_on(10.0)), &[&sedan, &sedan]);
    let row = only(&answer);
    // It is no crash, and no proof that nobody was touched.
    assert!(row.contacts.is_empty() && !row.touches_nobody(), "{row:#?}");
    assert_eq!(row.parts_from, ["other"]);
    assert!(row.remarks.iter().any(|remark| remark.contains("they part")), "{:?}", row.remarks);
    let answer = ranked(&format!("{}{}{}", ego(), state(0.0), go_on(0.0)), &[&sedan, &sedan]);
    assert_eq!(answer.state, AnswerState::Refused, "{answer:#?}");
    assert!(answer.missing[0].contains("overlap at the start"), "{:?}", answer.missing);
}

#[test]
fn who_creeps_into_a_car_and_then_goes_is_in_a_crash() {
    // A touch at walking pace is light; within half a second it becomes a crash, in the same place.
    let sedan = body(Shape::Sedan, 900);
    let queue = party("queue", "sedan", "place = { position_m = [4.7, 0, 0] }\nempty = true");
    let creep = "[[candidates]]\nname = \"creep\"\npath = { states = [ \
                 { t_s = 0, position_m = [0, 0, 0] }, { t_s = 2, position_m = [0.3, 0, 0] }, \
                 { t_s = 3, position_m = [12.3, 0, 0] } ] }\n";
    let answer = ranked(&format!("{}{queue}{creep}", ego()), &[&sedan, &sedan]);
    let row = only(&answer);
    assert_eq!(met(row), ["queue"], "{row:#?}");
    let contact = &row.contacts[0];
    assert_eq!(contact.severity, Severity::Heavy, "{contact:#?}");
    assert!(contact.first_touch_s < 2.0 && contact.time_s > 2.0, "{contact:#?}");
}

#[test]
fn who_parts_at_the_start_and_turns_back_is_in_a_crash() {
    let sedan = body(Shape::Sedan, 900);
    let queue = party("queue", "sedan", "place = { position_m = [4.2, 0, 0] }\nempty = true");
    let back = "[[candidates]]\nname = \"back and forth\"\npath = { states = [ \
                { t_s = 0, position_m = [0, 0, 0] }, { t_s = 0.2, position_m = [-0.1, 0, 0] }, \
                { t_s = 1.2, position_m = [9.9, 0, 0] } ] }\n";
    let answer = ranked(&format!("{}{queue}{back}", ego()), &[&sedan, &sedan]);
    let row = only(&answer);
    assert!(row.remarks.iter().any(|remark| remark.contains("they part")), "{:?}", row.remarks);
    assert_eq!(met(row), ["queue"], "{row:#?}");
    assert_eq!(row.contacts[0].severity, Severity::Heavy);
    assert!(row.contacts[0].time_s > 0.2, "{row:#?}");
}

#[test]
fn a_body_inside_another_is_in_contact_at_the_start() {
    let ego_body = sedan_of(cuboid([-3.0, -2.0, 0.0], [3.0, 2.0, 3.0]));
    let small = sedan_of(cuboid([-0.5, -0.5, 0.5], [0.5, 0.5, 1.0]));
    let inside = party("inside", "sedan", "place = { position_m = [1, 0, 0] }");
    let answer = ranked(&format!("{}{inside}{}", ego(), go_on(10.0)), &[&ego_body, &small]);
    let row = only(&answer);
    assert_eq!(met(row), ["inside"], "{row:#?}");
    assert!(row.contacts[0].is_at_start);
    // An open box holds nothing for sure, and says so.
    let mut open = cuboid([-3.0, -2.0, 0.0], [3.0, 2.0, 3.0]);
    open.pop();
    let answer = ranked(&format!("{}{inside}{}", ego(), go_on(10.0)), &[&sedan_of(open), &small]);
    let row = only(&answer);
    assert!(!row.touches_nobody() && row.maybe_inside == ["inside"], "{row:#?}");
    let said = &row.remarks;
    assert!(said.iter().any(|remark| remark.contains("was not decided")), "{said:?}");
}

#[test]
fn what_is_late_is_open_and_holds_what_the_finished_work_gives() {
    let (sedan, person) = (body(Shape::Sedan, 900), body(Shape::Pedestrian, 900));
    let walker = party("walker", "pedestrian", "place = { position_m = [13, 0.4, 0] }");
    let swerve = "[[candidates]]\nname = \"swerve\"\nstate = { position_m = [0, 0, 0], \
                  speed_m_s = 20, \
                  yaw_rate_deg_s = 20 }\n";
    let text = format!("{}{walker}{}{swerve}", ego(), go_on(20.0));
    let bodies = [&sedan, &person];
    let whole = ranked(&text, &bodies);
    let limits = RequestLimits { deadline_ns: Some(0), ..RequestLimits::default() };
    let late = ranked_within(&text, &bodies, limits);
    assert_ne!(late.state, AnswerState::Complete);
    for row in &late.ranking {
        let same = |other: &&CourseRow| other.name == row.name;
        let complete = whole.ranking.iter().find(same).expect("ranked in both");
        assert!(row.work.holds(complete.work), "{} {:?} {:?}", row.name, row.work, complete.work);
    }
}

#[test]
fn an_unfinished_contact_that_may_give_way_raises_no_lower_end() {
    // A touch at walking pace, whose survey was not begun; the crash that follows replaces it.
    let sedan = body(Shape::Sedan, 900);
    let head = "schema = \"trolley.scenario/2\"\nname = \"test\"\n";
    let queue = party("queue", "sedan", "place = { position_m = [5.2, 0, 0] }");
    for (speed_m_s, is_light) in [(0.5, true), (15.0, false)] {
        let text = format!("{head}{}{queue}{}", ego(), go_on(speed_m_s));
        let scenario = Scenario::parse("test.toml", &text).expect("sound");
        let views = [&sedan, &sedan].map(|body| (body.meta.clone(), body.view()));
        let shells: Vec<Shells> = views.iter().map(|(_, view)| Shells::of(view.corners)).collect();
        let scenery =
            Scenery { scenario: &scenario, bodies: &views, models: &[0, 1], shells: &shells };
        let people = People::of(&scenario, &|party| scenery.body(party));
        let member = Arc::new(Member::nominal(&scenery));
        let mut course = Course::new(scenery, member, 0);
        let mut encounters = Encounters::default();
        let (party, look) = course.way.looks().next().expect("nothing is known yet");
        let (seen, _) = encounters.look(&look, &mut |_| ControlFlow::Continue(())).expect("seen");
        course.way.learn(party, Some(seen), &mut encounters);
        let meeting = course.way.next().expect("they meet");
        let support_of = |model: usize, d: DVec3, near: &mut Option<[f32; 3]>| {
            support_near(&views[model].1, d, near)
        };
        let candidate = contact(&scenery, &people, &course, &meeting, &support_of, false);
        let candidate = candidate.expect("it closes");
        let request = Request {
            candidates: vec![Box::new(candidate)],
            persons: people.list.clone(),
            criteria: Criteria::with_policy(Policy::shipped().expect("sound")).expect("sound"),
        };
        let work = SurveyRun::new(&request, &views, 3);
        let (mut harms, _) = work.judge().expect("it can be assessed");
        let assessed = assessed(&request, &work, 0, meeting, harms.remove(0));
        assert!(!assessed.harm.is_settled() || assessed.harm.is_open, "its survey is open");
        settle(&mut course, &request.candidates[0], assessed);
        let alone = &course.contacts[0].harm;
        let is_above_zero =
            alone.energy_j.lo() > 0.0 || alone.persons.iter().any(|person| person.work.lo() > 0.0);
        assert!(is_above_zero, "{speed_m_s} m/s: {alone:#?}");
        let harm = harm_of(&people, &course, None);
        assert!(harm.is_open);
        if is_light {
            assert_eq!(harm.energy_j.lo(), 0.0, "{alone:#?}");
            assert!(harm.persons.iter().all(|risk| risk.work.lo() == 0.0), "{harm:#?}");
        }
    }
}

#[test]
fn whoever_may_be_aboard_may_be_harmed_in_what_is_open() {
    // Nobody said who is in the bus: any more than the usual ten run the greatest risk there.
    let (sedan, bus) = (body(Shape::Sedan, 900), body(Shape::Bus, 900));
    let ahead = party("bus", "bus", "place = { position_m = [30, 0, 0] }");
    let head = "schema = \"trolley.scenario/2\"\nname = \"test\"\n";
    let text = format!("{head}{ahead}{}{}", ego(), go_on(15.0));
    let scenario = Scenario::parse("test.toml", &text).expect("sound");
    let views = [&bus, &sedan].map(|body| (body.meta.clone(), body.view()));
    let shells: Vec<Shells> = views.iter().map(|(_, view)| Shells::of(view.corners)).collect();
    let scenery = Scenery { scenario: &scenario, bodies: &views, models: &[0, 1], shells: &shells };
    let people = People::of(&scenario, &|party| scenery.body(party));
    let mut course = Course::new(scenery, Arc::new(Member::nominal(&scenery)), 0);
    course.way.open_from_s = Some(0.0);
    let harm = harm_of(&people, &course, None);
    let (more, greatest) = harm.others.all;
    assert!(more > 0);
    assert_eq!(greatest, f64::from(more), "each of them may be harmed for sure");
    let mut ranges = harm.persons.iter().map(|risk| risk.range);
    assert!(ranges.all(|range| range.low() == 0.0 && range.high() == 1.0));
}

#[test]
fn what_follows_the_end_of_a_path_is_said_as_it_is() {
    // Both paths end after 2 s, the other one's where it has stood for a second.
    let sedan = body(Shape::Sedan, 900);
    let other = format!(
        "{}[[parties.other.paths]]\nprobability = 1.0\nstates = [ \
         {{ t_s = 0, position_m = [40, 9, 0] }}, {{ t_s = 1, position_m = [45, 9, 0] }}, \
         {{ t_s = 2, position_m = [45, 9, 0] }} ]\n",
        party("other", "sedan", "")
    );
    let drive = |to_m: [f64; 2]| {
        let [before, end] = to_m;
        format!(
            "[[candidates]]\nname = \"drive\"\npath = {{ states = [ \
             {{ t_s = 0, position_m = [0, 0, 0] }}, \
             {{ t_s = 1, position_m = [{before:?}, 0, 0] }}, \
             {{ t_s = 2, position_m = [{end:?}, 0, 0] }} ] }}\n"
        )
    };
    for (to_m, then) in [([5.0, 10.0], "goes straight on"), ([5.0, 5.0], "stays there")] {
        let answer = ranked(&format!("{}{other}{}", ego(), drive(to_m)), &[&sedan, &sedan]);
        let row = only(&answer);
        let said = format!("the path of \"ego\" ends after 2.00 s: it {then}");
        assert!(row.remarks.iter().any(|remark| remark.starts_with(&said)), "{:?}", row.remarks);
        let stays = "these stay there: \"other\" (2.00 s)";
        let assumed = &answer.assumptions;
        assert!(assumed.iter().any(|said| said.ends_with(stays)), "{assumed:?}");
    }
}

#[test]
fn other_predicted_paths_are_said_and_the_likeliest_is_followed() {
    let sedan = body(Shape::Sedan, 900);
    let path = |probability: f64, y: f64| {
        format!(
            "[[parties.other.paths]]\nprobability = {probability:?}\nstates = [ \
             {{ t_s = 0, position_m = [40, 6, 0], yaw_deg = 180 }}, \
             {{ t_s = 2, position_m = [20, {y:?}, 0], yaw_deg = 180 }} ]\n"
        )
    };
    let other = party("other", "sedan", "");
    let text = format!("{}{other}{}{}{}", ego(), path(0.6, 6.0), path(0.4, 0.0), go_on(10.0));
    let answer = ranked(&text, &[&sedan, &sedan]);
    let row = only(&answer);
    assert!(row.touches_nobody(), "{row:#?}");
    let [alternative] = row.alternatives.as_slice() else { panic!("{:?}", row.alternatives) };
    assert_eq!((alternative.party.as_str(), alternative.path), ("other", 2));
    assert!((alternative.time_s - 1.5).abs() < 0.5 && alternative.is_certain);
    assert!(answer.assumptions.iter().any(|said| said.contains("number 1 was followed")));
}

#[test]
fn of_a_body_above_the_way_the_first_time_is_said() {
    let sedan = body(Shape::Sedan, 900);
    let above = party("above", "sedan", "place = { position_m = [20, 0, 5] }");
    let answer = ranked(&format!("{}{above}{}", ego(), go_on(10.0)), &[&sedan, &sedan]);
    let row = only(&answer);
    assert!(row.touches_nobody(), "{row:#?}");
    let nearest = row.nearest.as_ref().expect("one is near");
    assert_eq!(nearest.gap_m, 0.0);
    // It is right below after 2 s; outlines of some 4.6 m overlap 0.46 s before.
    assert!(nearest.time_s > 1.4 && nearest.time_s < 1.7, "{nearest:?}");
}
