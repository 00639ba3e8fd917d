//! Properties of harm over random crashes of prisms.

use super::*;

fn scenes() -> impl Strategy<Value = Scene> {
    let place = (3.0..6.0_f64, -2.5..2.5_f64, -180.0..180.0_f64);
    let motion = (1.0..30.0_f64, -20.0..20.0_f64);
    let masses = (600.0..3000.0_f64, 600.0..3000.0_f64);
    (place, motion, masses, 0..3_u8).prop_map(|((x, y, turned), (v, w), (m, n), kind)| {
        let base =
            Scene { velocity: [v, w], party_a: car(0, m, [-0.2, 0.05], 0.0), ..head_on(0.0) };
        match kind {
            0 => Scene {
                b: Prism::cuboid(4.0, 1.7, [x, y], turned),
                party_b: car(1, n, [x, y], turned),
                ..base
            },
            1 => Scene { b: Prism::round(0.25, [x, y]), party_b: walker(1, [x, y]), ..base },
            _ => Scene {
                b: Prism::cuboid(0.4, 6.0, [x, y], turned),
                party_b: fixed(BodyKind::Wall, [x, y]),
                ..base
            },
        }
    })
}

/// Every figure that must not fall, of persons in order.
fn figures(harm: &CandidateHarm) -> Vec<f64> {
    let of =
        |p: &PersonHarm| [p.work.lo(), p.work.hi(), p.range.low(), p.range.high(), p.high_at_least];
    harm.persons.iter().flat_map(of).collect()
}

fn never_fall(before: &CandidateHarm, after: &CandidateHarm) -> bool {
    let (before, after) = (figures(before), figures(after));
    before.iter().zip(&after).all(|(b, a)| *a >= *b - 1e-12)
}

/// A fixed seed: sides have sharp edges, and a crash within rounding of one would differ in the
/// last test run of a year.
fn fixed_seed() -> ProptestConfig {
    ProptestConfig { cases: 96, rng_seed: RngSeed::Fixed(41), ..ProptestConfig::default() }
}

proptest! {
    #![proptest_config(fixed_seed())]

    #[test]
    fn harm_never_falls_with_speed(scene in scenes(), factor in 1.0..3.0_f64) {
        let faster = Scene { velocity: scene.velocity.map(|v| v * factor), ..scene.clone() };
        prop_assert!(never_fall(&harm(&scene), &harm(&faster)));
    }

    #[test]
    fn harm_never_falls_with_the_partners_mass(scene in scenes(), factor in 1.0..5.0_f64) {
        let mut heavier = scene.clone();
        heavier.party_b.mass_kg = scene.party_b.mass_kg.map(|m| m * factor);
        let (before, after) = (harm(&scene), harm(&heavier));
        let ego = |harm: CandidateHarm| {
            CandidateHarm { persons: harm.persons[..1].to_vec(), ..harm }
        };
        let holds = never_fall(&ego(before), &ego(after));
        prop_assert!(holds);
    }

    /// Swapping A and B changes no figure.
    #[test]
    fn swapping_the_parties_changes_nothing(scene in scenes()) {
        let (one, other) = (harm(&scene), harm(&scene.swapped()));
        prop_assert_eq!(
            one.contact.as_ref().map(|c| c.origin),
            other.contact.as_ref().map(|c| c.origin)
        );
        prop_assert!((one.energy_j.hi() - other.energy_j.hi()).abs() <= 1e-3 * one.energy_j.hi());
        for person in &one.persons {
            let same = other.persons.iter().find(|p| p.id == person.id);
            let same = same.ok_or_else(|| TestCaseError::fail("a person is lost"))?;
            prop_assert!((person.work.hi() - same.work.hi()).abs() <= 1e-3);
            prop_assert!((person.range.low() - same.range.low()).abs() <= 1e-3);
            prop_assert!((person.range.high() - same.range.high()).abs() <= 1e-3);
        }
        if let (Some(p), Some(q)) = (&one.contact, &other.contact) {
            let lengths = |p: &ContactPatch| {
                [p.height_m]
            };
            for (a, b) in lengths(p).iter().zip(&lengths(q)) {
                prop_assert!((a.hi() - b.hi()).abs() <= 1e-3, "{p:?} {q:?}");
            }
        }
    }

    #[test]
    fn moving_everything_changes_nothing(
        scene in scenes(),
        turned in -180.0..180.0_f64,
        x in -50.0..50.0_f64,
    ) {
        let (one, other) = (harm(&scene), harm(&scene.displaced(turned, [x, 7.0])));
        prop_assert_eq!(
            one.contact.as_ref().map(|c| c.origin),
            other.contact.as_ref().map(|c| c.origin)
        );
        for (a, b) in figures(&one).iter().zip(&figures(&other)) {
            prop_assert!((a - b).abs() <= 1e-3);
        }
        if let (Some(p), Some(q)) = (&one.contact, &other.contact) {
            prop_assert!((p.width_m.hi() - q.width_m.hi()).abs() <= 1e-3);
            prop_assert!((p.depth_m - q.depth_m).abs() <= 1e-3);
        }
    }

    /// As depths are done, ranges nest; the nominal figures do not depend on them at all.
    #[test]
    fn intervals_only_nest_while_work_is_done(scene in scenes(), order in any::<usize>()) {
        let Some(touching) = scene.touching() else { return Ok(()) };
        let stops = survey(&touching.approach);
        let mut harms = Vec::new();
        for done in 0..=stops.len() {
            let mut evidence = Evidence::none();
            for (k, stop) in stops.iter().enumerate() {
                let zones = Zones((1 << 8) << ((order >> k) & 3));
                let seen = Seen { zones_a: zones, zones_b: zones, ..Seen::NOTHING };
                if (k + order) % stops.len() < done {
                    evidence.add_hits(stop.travel_m, &seen);
                } else {
                    let all = Zones(u16::MAX);
                    let reach = Seen { zones_a: all, zones_b: all, ..Seen::NOTHING };
                    evidence.add_open(stop.travel_m, &reach);
                }
            }
            harms.push(touching.harm_by(&evidence)?);
        }
        for pair in harms.windows(2) {
            prop_assert_eq!(&pair[0].delta_v, &pair[1].delta_v);
            for (before, after) in pair[0].persons.iter().zip(&pair[1].persons) {
                prop_assert_eq!(before.work, after.work);
                prop_assert!(after.range.high() <= before.range.high());
                prop_assert!(after.high_at_least >= before.high_at_least);
                prop_assert!(after.range.low() <= after.work.lo());
                prop_assert!(after.work.hi() <= after.range.high());
            }
        }
        let last = &harms[harms.len() - 1];
        prop_assert!(last.is_settled() && !last.is_open);
        for person in &last.persons {
            prop_assert!(person.high_at_least == person.range.high());
        }
    }
}
