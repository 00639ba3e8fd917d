//! A survey of a member asks for less, and finds the same of what counts.

use super::SurveyRun;
use crate::fixtures;
use crate::request::{Request, Wanted};
use crate::run_in_process;
use body::{BodyView, Meta, Zones};
use damage::{CandidateHarm, Evidence};
use geometry::rng::Rng;

/// Evidence and harm of every candidate, and the tests of its jobs, once all work is done.
fn surveyed(
    request: &Request,
    bodies: &[(Meta, BodyView<'_>)],
    depth: u32,
) -> (Vec<Evidence>, Vec<CandidateHarm>, u64) {
    let mut run = SurveyRun::new(request, bodies, depth);
    run_in_process(&mut run, bodies);
    let evidence = (0..request.candidates.len()).map(|k| run.evidence(k)).collect();
    (evidence, run.harms().expect("sound"), run.effort().jobs.tests())
}

/// The same contacts somewhere near where they are, in other places of the bodies.
fn moved(request: &Request, rng: &mut Rng) -> Request {
    let mut request = request.clone();
    for candidate in &mut request.candidates {
        let by: [f64; 2] = [0, 1].map(|_| rng.between(-1.5, 1.5));
        for (axis, by) in by.into_iter().enumerate() {
            candidate.pose.translation[axis] += by;
        }
    }
    request
}

#[test]
fn zones_that_are_wanted_are_found_as_by_a_whole_survey() {
    fixtures::with(|request, bodies| {
        let mut rng = Rng::new(34);
        let mut hit = 0;
        for depth in [0, 3, 6] {
            for _ in 0..20 {
                let mut request = moved(request, &mut rng);
                let (whole, ..) = surveyed(&request, bodies, depth);
                let mut asked = Vec::new();
                for candidate in &mut request.candidates {
                    let bits =
                        [0, 1].map(|_| Zones((rng.below(1 << 16) & rng.below(1 << 16)) as u16));
                    candidate.wanted = Wanted::Zones(bits);
                    asked.push(bits);
                }
                let (part, ..) = surveyed(&request, bodies, depth);
                for (k, wanted) in asked.iter().enumerate() {
                    let first = request.candidates[k].first.zones;
                    for side in 0..2 {
                        let bits = |evidence: &Evidence| {
                            evidence.zones()[side].0 & (wanted[side].0 | first[side].0)
                        };
                        assert_eq!(bits(&part[k]), bits(&whole[k]), "depth {depth}, {wanted:?}");
                        hit += (bits(&part[k]) & !first[side].0).count_ones();
                    }
                    assert_eq!(part[k].zones(), part[k].zones_at_most(), "nothing is open");
                }
            }
        }
        assert!(hit > 100, "{hit} zones");
    });
}

#[test]
fn harm_is_that_of_a_whole_survey() {
    fixtures::with(|request, bodies| {
        let mut rng = Rng::new(35);
        let (mut intruded, mut tests) = (0, [0, 0]);
        for _ in 0..60 {
            let mut request = moved(request, &mut rng);
            let (_, whole, all) = surveyed(&request, bodies, 4);
            for candidate in &mut request.candidates {
                candidate.wanted = Wanted::beside([&candidate.a, &candidate.b], &candidate.first);
            }
            let (_, part, some) = surveyed(&request, bodies, 4);
            tests = [tests[0] + all, tests[1] + some];
            for (part, whole) in part.iter().zip(&whole) {
                assert_eq!(part.persons, whole.persons);
                assert_eq!((part.delta_v, part.energy_j), (whole.delta_v, whole.energy_j));
                assert_eq!((part.impulse_n_s, part.is_open), (whole.impulse_n_s, whole.is_open));
                intruded += part.persons.iter().filter(|person| person.intrusion).count();
            }
        }
        assert!(intruded > 20 && 2 * tests[1] < tests[0], "{intruded}, {tests:?} tests");
    });
}
