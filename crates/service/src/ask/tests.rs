//! Every request is accepted or refused with a reason; a scenario's request survives the round
//! trip.

use super::*;
use body::Shape;
use proptest::prelude::*;
use protocol::public::{WirePersons, WireReaction};

const DEPLOYMENT: &str = include_str!("../../config/deployments/minimal.toml");
const SCENARIO: &str = include_str!("../../config/scenarios/wall-or-pole.toml");

pub(crate) fn deployment() -> Deployment {
    Deployment::parse("minimal.toml", DEPLOYMENT).unwrap()
}

/// Facts about the three models; these tests do not look at triangles.
pub(crate) fn bodies() -> Vec<(Meta, BodyView<'static>)> {
    let empty = BodyView {
        nodes: &[],
        wide: &[],
        wide_of: &[],
        corners: &[],
        source_ids: &[],
        part_of: &[],
        zones: &[],
        dropped: &[],
    };
    let meta = |shape: Shape| Meta {
        name: shape.name().to_owned(),
        kind: shape.kind(),
        mass_kg: None,
        centre_m: [0.0; 3],
        gyration_m: 1.0,
        mass_source: String::new(),
        impact: body::OwnParameters::default(),
        impact_source: String::new(),
        occupants: None,
        parts: Vec::new(),
        origin: String::new(),
        origin_hash: String::new(),
        degenerate: 0,
        build: body::Build::Paper,
        leaf_size: 4,
        depth: 1,
        outlines: Default::default(),
        front_height_m: None,
    };
    [Shape::Sedan, Shape::Wall, Shape::Pole].map(|shape| (meta(shape), empty)).to_vec()
}

/// Party 0 the ego, 1 the pole, 2 the wall: scenarios sort by name. Paths 0 and 1 are those of pole
/// and wall, 2 to 4 the ego's.
fn minimal() -> Box<Ask> {
    let scenario = Scenario::parse("wall-or-pole.toml", SCENARIO).unwrap();
    of_scenario(&scenario, &[1, 3, 2], false).unwrap()
}

fn checked(ask: &Ask) -> Result<Checked, Refusal> {
    check(ask, &deployment(), (&bodies(), &[7; 32]))
}

#[test]
fn what_a_scenario_asks_is_what_the_engine_gets() {
    let more = SCENARIO.replacen(
        "[parties.wall]",
        "[parties.car]\n\
         generate = { shape = \"sedan\", triangles = 20000 }\n\
         persons = [{ seat = \"front-left\" }, { count = 3 }]\n\
         mass_kg = 1400\nresponsibility = 0.3\n\
         paths = [\n\
         { probability = 0.3, states = [{ t_s = -1, position_m = [40, 3, 0], yaw_deg = 180 }, \
         { t_s = 4, position_m = [-20, 3.5, 0], yaw_deg = 180, velocity_m_s = [-12, 0.1] }] },\n\
         { probability = 0.7, states = [{ t_s = 0, position_m = [28, 3.1, 0], yaw_deg = 180, \
         velocity_m_s = [-12, 0] }] }]\n\
         [parties.wall]",
        1,
    );
    let reacts = "name = \"brake\"\nreactions.car = { state = { position_m = [28, 3.1, 0], \
                  yaw_deg = 180, speed_m_s = 7, yaw_rate_deg_s = 10 } }";
    let more = more.replacen("name = \"brake\"", reacts, 1);
    let more = more
        .replacen("schema =", "members = 8\nmembers_max = 64\nschema =", 1)
        .replacen(
            "mass_kg = 1400",
            "mass_kg = 1400\nerrors = { lateral_m = 0.25, longitudinal_m = 0, correlation = -0.5, \
             yaw_deg = 3, speed_share = 0.125 }",
            1,
        )
        .replacen("[parties.wall]", "[parties.wall]\nerrors = { lateral_m = 0.01 }", 1);
    for (text, ids, models, members) in [
        (SCENARIO, &[1, 3, 2][..], &[0, 2, 1][..], (32, 128)),
        (&more, &[1, 1, 3, 2], &[0, 0, 2, 1], (8, 64)),
    ] {
        let scenario = Scenario::parse("wall-or-pole.toml", text).unwrap();
        let checked = checked(&of_scenario(&scenario, ids, false).unwrap()).unwrap();
        assert_eq!(checked.models, models);
        let followed = checked.scenario.members();
        assert_eq!((followed.count, followed.most), members);
        assert_eq!((checked.scenario.ego.0, checked.scenario.horizon_s), (models.len() - 3, 5.0));
        let motion = |motion: &Motion| (motion.path.clone(), motion.ends_s);
        for (ours, theirs) in checked.scenario.candidates.iter().zip(&scenario.candidates) {
            assert_eq!(motion(&ours.ego), motion(&theirs.ego));
            assert_eq!(ours.reactions.len(), theirs.reactions.len());
            for (ours, theirs) in ours.reactions.iter().zip(&theirs.reactions) {
                assert_eq!(
                    (ours.party, motion(&ours.motion)),
                    (theirs.party, motion(&theirs.motion))
                );
            }
        }
        for (ours, theirs) in checked.scenario.parties.iter().zip(&scenario.parties) {
            assert_eq!((&ours.occupancy, ours.mass_kg), (&theirs.occupancy, theirs.mass_kg));
            assert_eq!(ours.responsibility.to_bits(), theirs.responsibility.to_bits());
            assert_eq!(ours.errors, theirs.errors);
            assert_eq!(ours.predictions.len(), theirs.predictions.len());
            for (ours, theirs) in ours.predictions.iter().zip(&theirs.predictions) {
                assert_eq!(ours.probability.to_bits(), theirs.probability.to_bits());
                assert_eq!(motion(&ours.motion), motion(&theirs.motion));
            }
        }
    }
}

#[test]
fn what_a_request_does_not_say_is_as_the_deployment_or_the_usual() {
    let text = DEPLOYMENT.replacen("[engine]", "members = 4\nmembers_max = 16\n[engine]", 1);
    let deployment = Deployment::parse("d.toml", &text).unwrap();
    let check = |ask: &Ask| check(ask, &deployment, (&bodies(), &[7; 32])).unwrap().scenario;
    let followed = |count: u32, most: u32| {
        let mut ask = minimal();
        ask.set_members(count, most);
        let members = check(&ask).members();
        (members.count, members.most)
    };
    assert_eq!([followed(0, 0), followed(0, 8), followed(0, 4)], [(4, 16), (4, 8), (4, 4)]);
    assert_eq!([followed(1, 0), followed(2, 0), followed(200, 0)], [(1, 1), (2, 128), (200, 200)]);
    // A scenario that says nothing leaves it to the service.
    assert_eq!((minimal().members, minimal().members_max), (0, 0));
    let mut ask = minimal();
    for party in &mut ask.parties[..3] {
        *party = party.with_errors(&PartyErrors::default());
    }
    ask.parties[1] =
        ask.parties[1].with_errors(&PartyErrors { yaw_deg: Some(0.0), ..PartyErrors::default() });
    ask.parties[1].flags |= WireParty::UNKNOWN;
    ask.flags = Ask::UNKNOWN_IS_FIXED;
    let parties = check(&ask).parties;
    assert_eq!(parties[0].errors, Errors::usual(true));
    assert_eq!(parties[1].errors, Errors { yaw_deg: 0.0, ..Errors::usual(false) });
    assert_eq!(parties[2].errors, Errors::usual(false));
}

#[test]
fn seats_have_the_same_names_on_the_wire() {
    for (number, seat) in SEATS.iter().enumerate() {
        let name = WirePersons::seat_name(number as u32);
        assert_eq!((name, seat_number(*seat)), (seat.map(Seat::name), number as u32));
    }
    assert_eq!(WirePersons::seat_name(SEATS.len() as u32), None);
}

#[test]
fn what_does_not_fit_into_a_request_is_said() {
    let csv = "path = { csv = \"long.csv\" }\n";
    let text =
        SCENARIO.replacen("state = { position_m = [0, 0, 0], velocity_m_s = [14, 0] }", csv, 1);
    let draft = scenario::ScenarioDraft::parse("w.toml", &text).unwrap();
    let rows = (0..65).map(|k| format!("{k},{k},0,0\n")).collect::<String>();
    let read =
        draft.finish(|_| Ok::<_, scenario::ScenarioError>(format!("t_s,x_m,y_m,yaw_deg\n{rows}")));
    let error = of_scenario(&read.unwrap(), &[1, 3, 2], false).unwrap_err();
    assert!(error.contains("65 states"), "{error}");
    let sized = SCENARIO.replacen("[parties.pole]", "[parties.pole]\nsize_m = [0.4, 0.4, 3]", 1);
    let scenario = Scenario::parse("w.toml", &sized).unwrap();
    let error = of_scenario(&scenario, &[1, 3, 2], false).unwrap_err();
    assert!(error.contains("\"pole\" has size_m"), "{error}");
}

#[test]
fn every_mistake_has_its_reason_and_says_where() {
    let nan = f64::NAN;
    type Mistake = (fn(&mut Ask, f64), Reason, &'static str);
    let mistakes: &[Mistake] = &[
        (|ask, _| ask.version = 1, Reason::Malformed, "layout 1"),
        (|ask, _| ask.candidate_count = 0, Reason::Malformed, "candidate_count"),
        (|ask, _| ask.candidate_count = 17, Reason::Malformed, "candidate_count"),
        (|ask, _| ask.candidate_count = u32::MAX, Reason::Malformed, "candidate_count"),
        (|ask, _| ask.party_count = 33, Reason::Malformed, "party_count"),
        (|ask, _| ask.party_count = 1, Reason::Malformed, "party_count"),
        (|ask, _| ask.person_count = 257, Reason::Malformed, "person_count"),
        (|ask, _| ask.path_count = 257, Reason::Malformed, "path_count"),
        (|ask, _| ask.path_count = 4, Reason::Malformed, "candidate 2: a path"),
        (|ask, _| ask.reaction_count = 129, Reason::Malformed, "reaction_count"),
        (|ask, _| ask.state_count = 7_169, Reason::Malformed, "state_count"),
        (|ask, _| ask.state_count = 13, Reason::Malformed, "path 4: a state"),
        (|ask, _| ask.ego = 3, Reason::Malformed, "the ego is party 3"),
        (|ask, _| ask.ego = 1, Reason::Malformed, "party 0: path_count is 0"),
        (|ask, _| ask.flags = 2, Reason::Malformed, "flags 0x2"),
        (|ask, _| ask.spare = 1, Reason::Malformed, "spare"),
        (|ask, _| ask.room = 1, Reason::Malformed, "spare"),
        (|ask, _| ask.members = 1025, Reason::OutOfRange, "the request: members is 1025"),
        (|ask, _| ask.members = u32::MAX, Reason::OutOfRange, "members may be 1 to 1024"),
        (|ask, _| ask.set_members(8, 4), Reason::OutOfRange, "the request: members_max is 4"),
        (|ask, _| ask.set_members(8, 1025), Reason::OutOfRange, "members_max is 1025"),
        (|ask, _| ask.set_members(0, 2), Reason::OutOfRange, "members is 32"),
        (|ask, _| ask.set_members(1, 2), Reason::OutOfRange, "nothing is drawn"),
        (|ask, _| ask.model_set[31] = 6, Reason::OtherModels, "other bodies"),
        (|ask, v| ask.horizon_s = v, Reason::OutOfRange, "horizon_s"),
        (|ask, v| ask.resolution_m = v, Reason::OutOfRange, "resolution_m"),
        (|ask, _| ask.parties[1].flags = 512, Reason::Malformed, "party 1: unknown flags"),
        (|ask, v| ask.parties[1].size_m[2] = v, Reason::Malformed, "not used by this version"),
        (|ask, _| ask.parties[1].room = 1, Reason::Malformed, "not used by this version"),
        (|ask, v| ask.parties[1].lateral_m = v, Reason::OutOfRange, "party 1: lateral_m"),
        (|ask, v| ask.parties[0].longitudinal_m = v, Reason::OutOfRange, "party 0: longitudinal_m"),
        (|ask, v| ask.parties[2].correlation = v, Reason::OutOfRange, "party 2: correlation"),
        (|ask, v| ask.parties[0].yaw_deg = v, Reason::OutOfRange, "party 0: yaw_deg"),
        (|ask, v| ask.parties[1].speed_share = v, Reason::OutOfRange, "party 1: speed_share"),
        (|ask, _| ask.parties[1].lateral_m = -1e-9, Reason::OutOfRange, "lateral_m is -1e-9"),
        (|ask, _| ask.parties[1].lateral_m = 10.5, Reason::OutOfRange, "may be 0 to 10 m"),
        (|ask, _| ask.parties[1].correlation = 1.1, Reason::OutOfRange, "may be -1 to 1"),
        (|ask, _| ask.parties[1].yaw_deg = 91.0, Reason::OutOfRange, "may be 0 to 90°"),
        (|ask, _| ask.parties[1].speed_share = 0.6, Reason::OutOfRange, "may be 0 to 0.5"),
        (
            |ask, v| {
                ask.parties[1].flags &= !WireParty::CORRELATION;
                ask.parties[1].correlation = v;
            },
            Reason::Malformed,
            "party 1: correlation is",
        ),
        (
            |ask, _| {
                ask.parties[2] = ask.parties[2].with_errors(&PartyErrors::default());
                ask.parties[2].speed_share = 0.1;
            },
            Reason::Malformed,
            "its flag is not set",
        ),
        (|ask, _| ask.parties[2].model = 77, Reason::UnknownModel, "no model 77"),
        (|ask, _| ask.parties[0].path_count = 1, Reason::Malformed, "party 0: it is the ego"),
        (|ask, _| ask.parties[1].path_count = 4, Reason::Malformed, "party 1: path_count is 4"),
        (|ask, _| ask.parties[1].first_path = u32::MAX, Reason::Malformed, "party 1: a path"),
        (|ask, _| ask.candidates[1].path = 9, Reason::Malformed, "candidate 1"),
        (|ask, _| ask.candidates[0].reaction_count = 1, Reason::Malformed, "candidate 0: a reac"),
        (|ask, _| ask.candidates[0].first_reaction = u32::MAX, Reason::Malformed, "candidate 0"),
        (|ask, _| ask.paths[2].kind = 4, Reason::Malformed, "path 2: kind 4"),
        (|ask, _| ask.paths[3].state_count = 65, Reason::Malformed, "path 3: state_count"),
        (|ask, _| ask.paths[3].first_state = u32::MAX, Reason::Malformed, "path 3: a state"),
        (|ask, _| ask.states[2].flags = 0, Reason::Malformed, "path 2: what goes on"),
        (|ask, _| ask.states[4].flags = 2, Reason::Malformed, "path 3: state 1: unknown flags"),
        (|ask, v| ask.states[4].t_s = v, Reason::OutOfRange, "path 3, state 1: t_s"),
        (|ask, v| ask.states[4].position_m[1] = v, Reason::OutOfRange, "path 3, state 1"),
        (|ask, v| ask.states[2].angles_deg[0] = v, Reason::OutOfRange, "path 2: yaw_deg"),
        (|ask, v| ask.states[2].velocity_m_s[1] = v, Reason::OutOfRange, "path 2: velocity"),
        (|ask, _| ask.states[4].t_s = 0.0, Reason::OutOfRange, "times rise"),
        (|ask, _| ask.states[4].position_m[0] = 900.0, Reason::OutOfRange, "path 3, state 1: from"),
        (|ask, _| ask.states[3].position_m[0] = 3.0, Reason::Misfit, "path 3: at 0 s party"),
        (|ask, v| ask.paths[2].yaw_rate_deg_s = v, Reason::OutOfRange, "path 2: yaw_rate_deg_s"),
        (|ask, v| ask.paths[0].probability = v, Reason::OutOfRange, "party 1: probability"),
        (|ask, _| ask.paths[0].probability = 0.5, Reason::OutOfRange, "sum to 0.5"),
        (|ask, v| ask.parties[0].responsibility = v, Reason::OutOfRange, "party 0"),
        (
            |ask, v| {
                ask.parties[0].flags |= WireParty::MASS;
                ask.parties[0].mass_kg = v;
            },
            Reason::OutOfRange,
            "mass_kg",
        ),
        (|ask, _| ask.parties[0].model = 2, Reason::Misfit, "party 0: a wall cannot be the ego"),
        (
            |ask, _| {
                ask.paths[0].kind = WirePathKind::Onward as u32;
                ask.states[0] = ask.states[0].with_velocity([1.0, 0.0]);
            },
            Reason::Misfit,
            "path 0: a pole is fixed",
        ),
        (|ask, _| ask.parties[1].flags |= WireParty::UNKNOWN, Reason::UnknownKind, "unknown kind"),
        (
            |ask, _| ask.parties[1].flags |= WireParty::UNKNOWN | WireParty::MASS,
            Reason::Misfit,
            "party 1: a party of unknown kind has a shape",
        ),
        (
            |ask, _| {
                ask.add_candidate(2, &[WireReaction { party: 0, path: 0 }]);
            },
            Reason::Malformed,
            "candidate 3: party 0 cannot react",
        ),
        (
            |ask, _| {
                ask.add_candidate(2, &[WireReaction { party: 1, path: 0 }; 2]);
            },
            Reason::Malformed,
            "candidate 3: party 1 reacts twice",
        ),
        (|ask, _| persons_of(ask, 1, 1, 1), Reason::Misfit, "party 1: a pole holds nobody"),
        (|ask, _| persons_of(ask, 0, 8, 1), Reason::Malformed, "seat 8 does not exist"),
        (|ask, _| persons_of(ask, 0, 1, 2), Reason::Misfit, "2 persons cannot have the seat"),
        (|ask, _| persons_of(ask, 0, 0, 10), Reason::Misfit, "holds 9 persons at most"),
        (|ask, _| persons_of(ask, 0, 0, u32::MAX), Reason::Malformed, "not 256 at most"),
        (|ask, _| persons_of(ask, 0, 0, 0), Reason::Misfit, "count"),
        (
            |ask, _| {
                persons_of(ask, 0, 1, 1);
                ask.parties[0].flags = 0;
            },
            Reason::Malformed,
            "no PERSONS flag",
        ),
    ];
    for (make, reason, said) in mistakes {
        for value in [nan, f64::INFINITY, -1e12] {
            let mut ask = minimal();
            make(&mut ask, value);
            let refusal = checked(&ask).unwrap_err();
            assert_eq!(refusal.reason, *reason, "{said}: {refusal:?}");
            assert!(refusal.text.contains(said), "{refusal:?} says nothing of {said}");
        }
    }
}

fn persons_of(ask: &mut Ask, party: u32, seat: u32, count: u32) {
    ask.parties[party as usize].flags |= WireParty::PERSONS;
    ask.add_persons(WirePersons { party, seat, count, spare: 0 }).unwrap();
}

proptest! {
    /// No bytes make the check panic, or let a value through that a scenario could not hold.
    #[test]
    fn any_bytes_are_checked_or_refused(
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..40),
        to_head in any::<bool>(),
    ) {
        let mut ask = minimal();
        let used = if to_head { 128 } else { ask.used_bytes() };
        let bytes = bytemuck::bytes_of_mut(&mut *ask);
        for (at, byte) in changes {
            bytes[at.index(used)] = byte;
        }
        if let Ok(checked) = checked(&ask) {
            prop_assert!(checked.scenario.candidates.len() <= CANDIDATES_MAX);
            for candidate in &checked.scenario.candidates {
                let path = &candidate.ego.path;
                prop_assert_eq!((path.from_s(), path.to_s()), (0.0, checked.scenario.horizon_s));
                prop_assert!(path.pose_at(0.0).translation.iter().all(|m| m.abs() <= 1e6));
            }
            let members = checked.scenario.members();
            prop_assert!((1..=members.most).contains(&members.count) && members.most <= 1024);
            for party in &checked.scenario.parties {
                let Errors { lateral_m, longitudinal_m, correlation, yaw_deg, speed_share } =
                    party.errors;
                prop_assert!((0.0..=10.0).contains(&lateral_m));
                prop_assert!((0.0..=10.0).contains(&longitudinal_m));
                prop_assert!((-1.0..=1.0).contains(&correlation));
                prop_assert!((0.0..=90.0).contains(&yaw_deg));
                prop_assert!((0.0..=0.5).contains(&speed_share));
            }
        }
    }
}
