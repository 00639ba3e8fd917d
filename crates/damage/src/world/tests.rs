//! A world's figures are those of the model with its parameters; in the middle they are nominal.

use super::*;
use crate::assess::{assess, nominal};
use crate::evidence::Evidence;
use crate::policy::Policy;
use crate::scene::{Scene, head_on};

fn basis_of<'b>(parameters: &'b Parameters, curves: &'b Curves) -> Basis<'b> {
    Basis { curves, level: Policy::shipped().expect("sound").outcome, parameters }
}

/// The risks and the energy of a scene by some assessment.
fn risks(
    scene: &Scene,
    by: impl FnOnce(&Encounter<'_>, &mut Vec<(PersonId, u64)>) -> f64,
) -> (Vec<(PersonId, u64)>, u64) {
    let mut risks = Vec::new();
    let touching = scene.touching().expect("they meet");
    let energy_j = by(&touching.encounter(), &mut risks);
    (risks, energy_j.to_bits())
}

fn shipped() -> (Parameters, Curves) {
    (Parameters::shipped().expect("sound"), Curves::shipped().expect("sound"))
}

#[test]
fn the_nominal_figures_are_those_of_the_whole_assessment() {
    let (parameters, curves) = shipped();
    let basis = basis_of(&parameters, &curves);
    for across in [0.0, 0.5, 1.2] {
        let scene = head_on(across);
        let all = risks(&scene, |encounter, risks| {
            let harm = assess(encounter, &Evidence::none(), &basis).expect("sound");
            risks.extend(harm.persons.iter().map(|one| (one.id, one.work.hi().to_bits())));
            harm.energy_j.hi()
        });
        let alone = risks(&scene, |encounter, risks| {
            nominal(encounter, &basis, |id, risk| risks.push((id, risk.to_bits()))).expect("sound")
        });
        assert_eq!(alone, all);
        let middle = World::of(WorldDraw::nominal(2), &parameters, &curves);
        let world = risks(&scene, |encounter, risks| {
            let take = |id, risk: f64| risks.push((id, risk.to_bits()));
            middle.assess(encounter, [0, 1], basis.level, take).expect("sound")
        });
        assert_eq!(world, all, "in the middle all is nominal");
        assert!(!all.0.is_empty());
    }
}

/// A world's parameters, applied by hand, give its figures to the bit.
#[test]
fn by_hand_it_is_the_same() {
    let (parameters, curves) = shipped();
    let draw =
        WorldDraw { restitution: 0.1, friction: 0.8, masses: vec![0.9, 0.2], curves: Some(0.6) };
    let world = World::of(draw, &parameters, &curves);
    assert!(world.parameters.restitution.nominal < parameters.restitution.nominal);
    assert!(world.parameters.friction.nominal > parameters.friction.nominal);
    let level = Policy::shipped().expect("sound").outcome;
    let scene = head_on(0.6);
    let drawn = risks(&scene, |encounter, risks| {
        let take = |id, risk: f64| risks.push((id, risk.to_bits()));
        world.assess(encounter, [0, 1], level, take).expect("sound")
    });
    let mut by_hand = head_on(0.6);
    let share = parameters.mass_share;
    by_hand.party_a.mass_kg =
        by_hand.party_a.mass_kg.map(|kg| kg * (1.0 + share * (2.0 * 0.9 - 1.0)));
    by_hand.party_b.mass_kg =
        by_hand.party_b.mass_kg.map(|kg| kg * (1.0 + share * (2.0 * 0.2 - 1.0)));
    let basis = Basis { curves: &world.curves, level, parameters: &world.parameters };
    let whole = risks(&by_hand, |encounter, risks| {
        let harm = assess(encounter, &Evidence::none(), &basis).expect("sound");
        risks.extend(harm.persons.iter().map(|one| (one.id, one.work.hi().to_bits())));
        harm.energy_j.hi()
    });
    assert_eq!(drawn, whole);
}

#[test]
fn draws_stay_within_what_is_stated() {
    let (parameters, curves) = shipped();
    let mut seen = std::collections::BTreeSet::new();
    for k in 0..64 {
        let at = f64::from(k) / 64.0;
        let draw =
            WorldDraw { restitution: at, friction: at, masses: vec![at; 2], curves: Some(at) };
        let World { parameters: of, curves: drawn, .. } =
            World::of(draw.clone(), &parameters, &curves);
        assert!(of.restitution.is_within(1.0) && of.friction.is_within(10.0));
        let share = of.restitution.nominal - parameters.restitution.nominal;
        assert_eq!(share < 0.0, at < 0.5, "{at}");
        for (rung, usual) in drawn.rungs.iter().zip(&curves.rungs) {
            let known =
                [&usual.low, &usual.high].iter().any(|end| end.curves.contains(&rung.nominal));
            assert!(known || rung.nominal == usual.nominal);
            seen.insert((rung.victim, rung.level, rung.nominal));
        }
        assert_eq!(draw.only(Doubt::Friction).restitution, 0.5);
        assert_eq!(draw.only(Doubt::Curves).curves, draw.curves);
    }
    assert!(seen.len() > curves.rungs.len(), "other curves are drawn, too");
}

#[test]
fn worlds_that_are_the_same_have_the_same_figures() {
    let (parameters, curves) = shipped();
    let level = Policy::shipped().expect("sound").outcome;
    let scene = head_on(0.6);
    let mut worlds: Vec<(World, _)> = Vec::new();
    for k in 0..64 {
        let at = (f64::from(k) + 0.5) / 64.0;
        let draw =
            WorldDraw { restitution: at, friction: at, masses: vec![at; 2], curves: Some(at) };
        for doubt in Doubt::ALL {
            let world = World::of(draw.only(doubt), &parameters, &curves);
            let figures = risks(&scene, |encounter, risks| {
                let take = |id, risk: f64| risks.push((id, risk.to_bits()));
                world.assess(encounter, [0, 1], level, take).expect("sound")
            });
            match worlds.iter().find(|(known, _)| known.is_same(&world)) {
                Some((_, known)) => assert_eq!(&figures, known, "{doubt:?} at {at}"),
                None => worlds.push((world, figures)),
            }
        }
    }
    // Each number is another world, but there are few sets of curves.
    assert!((3 * 64 + 2..3 * 64 + 32).contains(&worlds.len()), "{}", worlds.len());
}
