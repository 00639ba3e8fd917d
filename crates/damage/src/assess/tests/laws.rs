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

/// A fixed seed: N has sharp edges, and a crash within rounding of one would differ in the last
/// test run of a year.
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
        prop_assert_eq!(one.contact.touch, other.contact.touch);
        prop_assert!((one.energy_j.hi() - other.energy_j.hi()).abs() <= 1e-3 * one.energy_j.hi());
        for person in &one.persons {
            let same = other.persons.iter().find(|p| p.id == person.id);
            let same = same.ok_or_else(|| TestCaseError::fail("a person is lost"))?;
            prop_assert!((person.work.hi() - same.work.hi()).abs() <= 1e-3);
            prop_assert!((person.range.low() - same.range.low()).abs() <= 1e-3);
            prop_assert!((person.range.high() - same.range.high()).abs() <= 1e-3);
        }
        if let (Some(p), Some(q)) = (&one.contact.patch, &other.contact.patch) {
            let lengths = |p: &ContactPatch| {
                [p.width_m, p.height_m, p.span_m, p.penetration_m, p.depth_m]
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
        prop_assert_eq!(one.contact.touch, other.contact.touch);
        for (a, b) in figures(&one).iter().zip(&figures(&other)) {
            prop_assert!((a - b).abs() <= 1e-3);
        }
        if let (Some(p), Some(q)) = (&one.contact.patch, &other.contact.patch) {
            prop_assert!((p.width_m.hi() - q.width_m.hi()).abs() <= 1e-3);
            prop_assert!((p.depth_m.hi() - q.depth_m.hi()).abs() <= 1e-3);
        }
    }

    /// From the first question to the last hit, whatever comes first: work intervals nest, the last
    /// one is a point, model ranges hold work intervals, and the upper end lands where it was said.
    #[test]
    fn intervals_only_nest_while_work_is_done(scene in scenes(), order in any::<u64>()) {
        let approach = scene.approach();
        let meeting = plan(&approach)?;
        let Meeting::Path(path) = &meeting else { return Ok(()) };
        let mut stages = Vec::new();
        let first = scene.first(path, &approach);
        // The search comes nearer from both sides, and knows of contact before it knows the first.
        let end = first.unwrap_or(path.to_m);
        for part in [0.0, 0.3, 0.7, 0.99] {
            let lo = path.from_m + part * (end - path.from_m);
            let hi = if part < 0.5 { path.to_m } else { end + (1.0 - part) * (path.to_m - end) };
            let mut evidence = Evidence::none((lo, hi));
            evidence.add_open_everywhere();
            if first.is_some() && part >= 0.5 {
                evidence.touched();
            }
            stages.push(evidence);
        }
        if let Some(f) = first {
            let stops = path.survey(f);
            for done in 0..=stops.len() {
                let mut evidence = Evidence::none((f, f));
                evidence.touched();
                for k in 0..stops.len() {
                    // Some permutation of the stops, by the drawn number.
                    let k = (k + order as usize % stops.len()) % stops.len();
                    let stop = stops[k];
                    let is_done = (k + order as usize / 64) % stops.len() < done;
                    let mut seen = Seen::NOTHING;
                    for point in scene.hits(stop.travel_m, &approach) {
                        if stop.patch {
                            seen.patch.add(&approach.directions, point);
                        }
                        if stop.depth {
                            seen.end.add(&approach.directions, point);
                        }
                    }
                    (seen.zones_a, seen.zones_b) = (Zones(1), Zones(1));
                    if is_done {
                        evidence.add_hits(stop.travel_m, &seen);
                    } else if stop.patch {
                        // What open work may reach: a little more than it will.
                        for supports in [&mut seen.patch, &mut seen.end] {
                            supports.0.iter_mut().for_each(|s| *s += 0.3);
                        }
                        (seen.zones_a, seen.zones_b) = (Zones(u16::MAX), Zones(u16::MAX));
                        evidence.add_open(stop.travel_m, &seen);
                    } else {
                        evidence.add_open(stop.travel_m, &Seen { patch: Supports::EMPTY, ..seen });
                    }
                }
                stages.push(evidence);
            }
        } else {
            stages.push(Evidence::none((path.from_m, path.to_m)));
        }
        let mut harms = Vec::new();
        for evidence in &stages {
            harms.push(scene.harm_by(&approach, &meeting, evidence)?);
        }
        for pair in harms.windows(2) {
            prop_assert!(pair[0].energy_j.hi() >= pair[1].energy_j.hi() * (1.0 - 1e-12));
            prop_assert!(pair[0].energy_j.lo() <= pair[1].energy_j.lo() * (1.0 + 1e-12));
            for (before, after) in pair[0].persons.iter().zip(&pair[1].persons) {
                prop_assert!(before.work.lo() <= after.work.lo() + 1e-12, "{before:?} {after:?}");
                prop_assert!(after.work.hi() <= before.work.hi() + 1e-12, "{before:?} {after:?}");
            }
        }
        let Some(last) = harms.last() else { return Ok(()) };
        prop_assert!(last.is_settled() && !last.is_open);
        for harm in &harms {
            for (person, end) in harm.persons.iter().zip(&last.persons) {
                prop_assert!(person.range.low() <= person.work.lo());
                prop_assert!(person.work.hi() <= person.range.high());
                let high = end.range.high();
                // A near miss is known only at the end: until then its upper end may be anything.
                if last.contact.touch == Touch::Yes {
                    prop_assert!(person.high_at_least <= high + 1e-12, "{person:?} {end:?}");
                    prop_assert!(high <= person.range.high() + 1e-12, "{person:?} {end:?}");
                }
            }
        }
    }
}
