//! Laws of the order and of its certainty, against complete runs.

use super::*;
use crate::rank::standing::needs_high;
use proptest::prelude::*;

pub(in crate::rank) fn policies() -> impl Strategy<Value = Policy> {
    let rules =
        ["bayes", "equality", "maximin", "responsibility", "ego-only", "vulnerable", "uninvolved"];
    let tolerance = prop_oneof![Just(0.0), Just(0.05)];
    let one = (0..rules.len(), tolerance).prop_map(move |(r, t)| level(rules[r], t));
    let accept = Just("[[level]]\nrule = \"precaution\"\naccept = 0.4\n".to_owned());
    let levels = prop::collection::vec(prop_oneof![4 => one, 1 => accept], 1..4);
    let levels = (prop_oneof![2 => Just(String::new()), 1 => binding()], levels);
    prop_oneof![
        4 => levels.prop_map(|(first, l)| {
            policy("lexicographic", &(first + &l.concat() + &level("bayes", 0.0)))
        }),
        1 => binding().prop_map(|first| policy("leximin", &first)),
        2 => (0.5..0.9_f64).prop_map(|w| weighted(w, 0.4 * (1.0 - w), 1.0 - w - 0.4 * (1.0 - w))),
        1 => Just(policy("leximin", "")),
    ]
}

/// A first level that binds: it refuses, or falls back on a candidate that may be there.
fn binding() -> impl Strategy<Value = String> {
    let otherwise = prop_oneof![
        Just("otherwise = \"refuse\"\n".to_owned()),
        (0..6_usize).prop_map(|k| format!("otherwise = \"fall-back\"\nfall_back = \"{k}\"\n")),
    ];
    otherwise.prop_map(|text| format!("[[level]]\nrule = \"precaution\"\naccept = 0.4\n{text}"))
}

/// Risks on a coarse grid, so that ties are common; an open end; and where the truth lies.
pub(in crate::rank) fn risks() -> impl Strategy<Value = Vec<Vec<(f64, f64, bool)>>> {
    let risk = (0..10_u8, prop_oneof![3 => Just(0_u8), 1 => 0..4_u8], any::<bool>());
    let risk = risk.prop_map(|(lo, width, top)| {
        (f64::from(lo) * 0.1, f64::from(lo + width).min(10.0) * 0.1, top)
    });
    (1..4_usize)
        .prop_flat_map(move |n| prop::collection::vec(prop::collection::vec(risk.clone(), n), 1..6))
}

/// Candidates with these risks, as far as they are known.
fn open_candidates(risks: &[Vec<(f64, f64, bool)>]) -> Vec<CandidateHarm> {
    let known = |risks: &Vec<(f64, f64, bool)>| {
        open(&risks.iter().map(|(lo, hi, _)| (*lo, *hi)).collect::<Vec<_>>())
    };
    risks.iter().map(known).collect()
}

proptest! {
    /// Whatever open work finds, the winner of the finished run was among the possible ones; and if
    /// the answer was certified, it was that winner.
    // verifies REQ-RANK
    #[test]
    fn the_winner_of_the_finished_run_was_never_left_out(policy in policies(), risks in risks()) {
        let now = open_candidates(&risks);
        let later: Vec<_> = risks.iter().map(|person| {
            let ends: Vec<f64> = person.iter().map(|r| if r.2 { r.1 } else { r.0 }).collect();
            CandidateHarm { energy_j: Interval::ZERO, ..settled(&ends) }
        }).collect();
        let (before, after) = (ranked(&policy, &now), ranked(&policy, &later));
        let first = after.places[0].candidate;
        prop_assert_eq!(after.state, AnswerState::Complete);
        prop_assert!(before.possible.contains(&first), "{before:?} {after:?}");
        if before.state == AnswerState::Certified {
            prop_assert_eq!(before.places[0].candidate, first);
            prop_assert_eq!(winner(&before), winner(&after));
        }
        // The order's own winner is one of the possible ones.
        prop_assert!(before.possible.contains(&before.places[0].candidate));
        // Every candidate is ranked once.
        let mut all = order(&before);
        all.sort_unstable();
        prop_assert_eq!(all, (1..=risks.len()).collect::<Vec<_>>());
    }

    /// Who is first, and who is equal to that one directly after it, is as in the whole order.
    #[test]
    fn winners_are_those_of_the_whole_order(policy in policies(), risks in risks()) {
        let candidates = open_candidates(&risks);
        let policy = &*among(&policy, candidates.len());
        let stakes = stakes(risks[0].len());
        let answer = rank(policy, &stakes, &candidates).expect("sound candidates");
        let equal = answer.places.iter().take_while(|place| place.steps == answer.places[0].steps);
        let expected: Vec<usize> = equal.map(|place| place.candidate).collect();
        let winners = winners_in(&mut Scratch::default(), policy, &stakes, &candidates);
        prop_assert_eq!(winners.expect("sound candidates").to_vec(), expected);
    }

    /// While work is open, from bounds alone: who can still win, how much is settled, and who would
    /// be first are as in an answer given now; what is compared is the first step of the policy
    /// that is not the same for all possible winners whatever comes.
    #[test]
    fn the_standing_of_bounds_is_that_of_the_answer(policy in policies(), risks in risks()) {
        let candidates = open_candidates(&risks);
        let policy = &*among(&policy, candidates.len());
        let stakes = stakes(risks[0].len());
        let bounds: Vec<_> = candidates.iter().map(CandidateBounds::of).collect();
        let standing = standing(policy, &stakes, &bounds).expect("sound bounds");
        let answer = rank(policy, &stakes, &candidates).expect("sound candidates");
        prop_assert_eq!(&standing.possible, &answer.possible);
        prop_assert_eq!(standing.settled, answer.settled);
        prop_assert_eq!(standing.incumbent, answer.places[0].candidate);
        let has_accepted = policy.levels.iter().any(|step| matches!(step, Step::Accept { .. }));
        prop_assert_eq!(needs_high(policy), has_accepted);
        // By candidate, over open work: what each step compares.
        let steps = |k: usize| {
            &answer.places.iter().find(|place| place.candidate == k).expect("ranked").steps
        };
        let of_step = |step: usize| -> Vec<Interval> {
            (0..candidates.len()).map(|k| steps(k)[step]).collect()
        };
        let count = steps(0).len();
        let is_decided = |compared: &[Interval]| {
            let first = compared[standing.possible[0]];
            standing.possible.iter().all(|k| compared[*k].is_settled() && compared[*k] == first)
        };
        let expected = (0..count).map(of_step).find(|compared| !is_decided(compared));
        prop_assert_eq!(&standing.compared, &expected.unwrap_or_else(|| of_step(count - 1)));
    }

    #[test]
    fn maximin_never_prefers_a_worse_worst(risks in risks()) {
        let candidates: Vec<_> = risks.iter()
            .map(|person| settled(&person.iter().map(|r| r.1).collect::<Vec<_>>())).collect();
        for policy in [policy("lexicographic", &level("maximin", 0.0)), policy("leximin", "")] {
            let ranking = ranked(&policy, &candidates);
            let worst = |place: &Place| {
                risks[place.candidate].iter().map(|r| r.1).fold(0.0, f64::max)
            };
            for pair in ranking.places.windows(2) {
                prop_assert!(worst(&pair[0]) <= worst(&pair[1]) + 1e-9);
            }
        }
    }

    /// An accepted risk that binds is kept by the winner, or nobody wins, or who is named does.
    // verifies REQ-POLICY
    #[test]
    fn what_binds_never_yields_an_unacceptable_winner(first in binding(), risks in risks()) {
        let candidates: Vec<_> = risks.iter()
            .map(|person| settled(&person.iter().map(|r| r.1).collect::<Vec<_>>())).collect();
        let rest = level("maximin", 0.05) + &level("bayes", 0.0);
        let ranking = ranked(&policy("lexicographic", &(first.clone() + &rest)), &candidates);
        let keeps = |k: &usize| risks[*k].iter().all(|r| r.1 <= 0.4 + 1e-9);
        let all = 0..candidates.len();
        let acceptable: Vec<usize> = all.clone().filter(keeps).collect();
        let named = all.clone().find(|k| first.contains(&format!("\"{k}\"")));
        match (acceptable.as_slice(), named) {
            ([], Some(named)) => {
                prop_assert_eq!(winner(&ranking), Some(named));
                let fell_back = |note: &Note| matches!(note, Note::FellBack { .. });
                prop_assert!(ranking.notes.iter().any(fell_back));
                let grounds = ranking.places[0].why.as_ref();
                let is_it = |why: &Ground| matches!(why, Ground::FallBack { .. });
                prop_assert!(grounds.is_none_or(is_it));
            }
            ([], None) => {
                prop_assert_eq!(winner(&ranking), None);
                // They are in order all the same, as by the next rules.
                let next = ranked(&policy("lexicographic", &rest), &candidates);
                prop_assert_eq!(order(&ranking), order(&next));
            }
            (_, _) => {
                prop_assert!(winner(&ranking).is_some_and(|k| acceptable.contains(&k)));
                prop_assert!(ranking.notes.is_empty());
                let places = ranking.places.iter().map(|place| place.candidate);
                let first: Vec<usize> = places.take(acceptable.len()).collect();
                prop_assert!(first.iter().all(|k| acceptable.contains(k)), "{first:?}");
            }
        }
    }

    /// Where every candidate is in the policy's list, their order in the request decides nothing;
    /// and of those whom the rule holds equal, the first in the list wins.
    #[test]
    fn the_order_of_a_request_does_not_matter_to_a_preference(
        risks in risks(), turn in 0..6_usize,
        listed in Just((0..6_usize).collect::<Vec<_>>()).prop_shuffle(),
    ) {
        let names: Vec<String> = listed.iter().map(|k| format!("\"{k}\"")).collect();
        let ties = format!("preferred = [{}]\ntie_break = [\"brake-in-lane\", ", names.join(", "));
        let text = DEFAULT_POLICY.replace("tie_break = [", &ties)
            .replace("property = \"last\"", "property = \"ignored\"");
        let head = text.split("[[level]]").next().unwrap_or_default();
        let policy = Policy::parse("", &(head.to_owned() + &level("bayes", 0.0))).expect("sound");
        let means: Vec<f64> = risks.iter().map(|person| {
            person.iter().map(|r| r.1).sum::<f64>() / person.len() as f64
        }).collect();
        let candidates: Vec<_> = risks.iter()
            .map(|person| settled(&person.iter().map(|r| r.1).collect::<Vec<_>>())).collect();
        let least = means.iter().copied().fold(f64::INFINITY, f64::min);
        let expected = listed.iter().copied()
            .find(|k| means.get(*k).is_some_and(|mean| (mean - least).abs() < 1e-9));
        let count = candidates.len();
        let turned: Vec<usize> = (0..count).map(|k| (k + turn) % count).collect();
        let names: Vec<String> = turned.iter().map(ToString::to_string).collect();
        let bound = Arc::new(policy.clone()).among(names.iter().map(String::as_str));
        let moved: Vec<_> = turned.iter().map(|k| candidates[*k].clone()).collect();
        let ranking = rank(&bound, &stakes(risks[0].len()), &moved).expect("sound");
        prop_assert_eq!(Some(turned[ranking.places[0].candidate]), expected);
        prop_assert_eq!(winner(&ranked(&policy, &candidates)), expected);
    }

    /// A policy changes the order, never a figure; and no candidate's figures depend on the others.
    #[test]
    fn figures_are_the_candidates_own(policy in policies(), risks in risks()) {
        let candidates: Vec<_> = risks.iter()
            .map(|person| settled(&person.iter().map(|r| r.0).collect::<Vec<_>>())).collect();
        let together = ranked(&policy, &candidates);
        for place in &together.places {
            let alone = ranked(&policy, &candidates[place.candidate..=place.candidate]);
            prop_assert_eq!(&alone.places[0].steps, &place.steps);
            prop_assert_eq!(alone.places[0].work, place.work);
        }
    }
}
