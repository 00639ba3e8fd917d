//! Every request is accepted or refused with a reason; a scenario's request survives the round
//! trip.

use super::*;
use body::Shape;
use proptest::prelude::*;
use protocol::public::Person;

const DEPLOYMENT: &str = include_str!("../../config/deployments/minimal.toml");
const SCENARIO: &str = include_str!("../../config/scenarios/minimal.toml");

fn deployment() -> Deployment {
    Deployment::parse("minimal.toml", DEPLOYMENT).unwrap()
}

/// Facts about the three models; these tests do not look at triangles.
fn bodies() -> Vec<(Meta, BodyView<'static>)> {
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
        occupants: None,
        parts: Vec::new(),
        origin: String::new(),
        origin_hash: String::new(),
        degenerate: 0,
        build: body::Build::Paper,
        leaf_size: 4,
        depth: 1,
    };
    [Shape::Sedan, Shape::Wall, Shape::Pole].map(|shape| (meta(shape), empty)).to_vec()
}

/// Party 0 the ego, 1 the pole, 2 the wall: scenarios sort by name.
fn minimal() -> Ask {
    let scenario = Scenario::parse("minimal.toml", SCENARIO).unwrap();
    of_scenario(&scenario, &[1, 3, 2], false).unwrap()
}

fn refused(ask: &Ask) -> Refusal {
    check(ask, &deployment(), &bodies(), Lists::default()).unwrap_err()
}

#[test]
fn what_a_scenario_asks_is_what_the_engine_gets() {
    let scenario = Scenario::parse("minimal.toml", SCENARIO).unwrap();
    let checked = check(&minimal(), &deployment(), &bodies(), Lists::default()).unwrap();
    assert_eq!(checked.models[..], [0, 2, 1]);
    assert_eq!(checked.scenario.ego, scenario.ego);
    for (ours, theirs) in checked.scenario.candidates.iter().zip(&scenario.candidates) {
        assert_eq!((ours.ego, ours.other), (theirs.ego, theirs.other));
        assert_eq!(ours.probability.to_bits(), theirs.probability.to_bits());
    }
    for (ours, theirs) in checked.scenario.parties.iter().zip(&scenario.parties) {
        assert_eq!((&ours.persons, ours.mass_kg), (&theirs.persons, theirs.mass_kg));
        assert_eq!(ours.responsibility.to_bits(), theirs.responsibility.to_bits());
    }
}

#[test]
fn every_mistake_has_its_reason_and_says_where() {
    let nan = f64::NAN;
    type Mistake = (fn(&mut Ask, f64), Reason, &'static str);
    let mistakes: &[Mistake] = &[
        (|ask, _| ask.version = 2, Reason::Malformed, "layout 2"),
        (|ask, _| ask.candidate_count = 0, Reason::Malformed, "candidate_count"),
        (|ask, _| ask.candidate_count = 17, Reason::Malformed, "candidate_count"),
        (|ask, _| ask.candidate_count = u32::MAX, Reason::Malformed, "candidate_count"),
        (|ask, _| ask.party_count = 18, Reason::Malformed, "party_count"),
        (|ask, _| ask.party_count = 1, Reason::Malformed, "party_count"),
        (|ask, _| ask.person_count = 65, Reason::Malformed, "person_count"),
        (|ask, _| ask.ego = 3, Reason::Malformed, "the ego is party 3"),
        (|ask, _| ask.flags = 2, Reason::Malformed, "flags 0x2"),
        (|ask, _| ask.parties[1].flags = 16, Reason::Malformed, "party 1"),
        (|ask, _| ask.parties[2].model = 77, Reason::UnknownModel, "no model 77"),
        (|ask, _| ask.candidates[1].party = 9, Reason::Malformed, "candidate 1"),
        (|ask, _| ask.candidates[0].party = 0, Reason::Malformed, "candidate 0"),
        (|ask, v| ask.candidates[0].ego.position_m[1] = v, Reason::OutOfRange, "candidate 0"),
        (|ask, v| ask.candidates[1].other.angles_deg[0] = v, Reason::OutOfRange, "candidate 1"),
        (|ask, v| ask.candidates[1].ego.velocity_m_s[1] = v, Reason::OutOfRange, "velocity"),
        (|ask, v| ask.candidates[0].probability = v, Reason::OutOfRange, "probability"),
        (|ask, v| ask.parties[0].responsibility = v, Reason::OutOfRange, "party 0"),
        (
            |ask, v| (ask.parties[0].flags, ask.parties[0].mass_kg) = (WireParty::MASS, v),
            Reason::OutOfRange,
            "mass_kg",
        ),
        (|ask, _| ask.ego = 1, Reason::Malformed, "cannot be hit"),
        (|ask, _| ask.parties[0].model = 2, Reason::Misfit, "party 0: a wall cannot be the ego"),
        (
            |ask, _| ask.candidates[1].other.velocity_m_s = [1.0, 0.0],
            Reason::Misfit,
            "candidate 1: a pole is fixed",
        ),
        (|ask, _| ask.parties[1].flags = WireParty::UNKNOWN, Reason::UnknownKind, "unknown kind"),
        (
            |ask, _| {
                ask.parties[1].flags = WireParty::PERSONS;
                ask.add_person(Person { party: 1, seat: 1 });
            },
            Reason::Misfit,
            "party 1: a pole holds nobody",
        ),
        (
            |ask, _| {
                ask.add_person(Person { party: 0, seat: 1 });
            },
            Reason::Malformed,
            "no PERSONS flag",
        ),
        (
            |ask, _| {
                ask.parties[0].flags = WireParty::PERSONS;
                ask.add_person(Person { party: 0, seat: 8 });
            },
            Reason::Malformed,
            "seat 8 does not exist",
        ),
    ];
    for (make, reason, said) in mistakes {
        for value in [nan, f64::INFINITY, -1e12] {
            let mut ask = minimal();
            make(&mut ask, value);
            let refusal = refused(&ask);
            assert_eq!(refusal.reason, *reason, "{refusal:?}");
            assert!(refusal.text.contains(said), "{refusal:?} says nothing of {said}");
        }
    }
}

proptest! {
    /// No bytes make the check panic, or let a value through that a scenario could not hold.
    #[test]
    fn any_bytes_are_checked_or_refused(
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..40),
    ) {
        let mut ask = minimal();
        let bytes = bytemuck::bytes_of_mut(&mut ask);
        for (at, byte) in changes {
            let at = at.index(bytes.len());
            bytes[at] = byte;
        }
        if let Ok(checked) = check(&ask, &deployment(), &bodies(), Lists::default()) {
            prop_assert!(checked.scenario.candidates.len() <= CANDIDATES_MAX);
            for candidate in &checked.scenario.candidates {
                prop_assert!(candidate.ego.pose.translation.iter().all(|m| m.abs() <= 1e6));
                prop_assert!((0.0..=1.0).contains(&candidate.probability));
            }
        }
    }
}
