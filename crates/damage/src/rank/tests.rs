//! The order and its certainty: worked cases, and laws against complete runs (`laws.rs`).

use super::interval::{Outlook, least};
use super::standing::standing;
use super::*;
use crate::assess::CandidateBounds;
use crate::dynamics::Response;
use crate::harm::{CandidateHarm, DeltaV, PersonHarm};
use crate::injury::{Quantity, Victim};
use crate::policy::DEFAULT_POLICY;
use std::sync::Arc;

mod laws;

pub(in crate::rank) use laws::{policies, risks};

/// A candidate with these risks over open work, and ranges twice as wide about them.
pub(in crate::rank) fn candidate(risks: &[Interval], energy_j: Interval) -> CandidateHarm {
    let person = |(i, work): (usize, &Interval)| PersonHarm {
        id: PersonId(i),
        party: 0,
        seat: None,
        victim: Victim::Pedestrian,
        curve: String::new().into(),
        x: Quantity::ClosingNormal,
        x_m_s: Interval::ZERO,
        front_m: 0.0,
        work: *work,
        range: Range::new(work.lo(), work.hi()),
        high_at_least: work.lo(),
        intrusion: false,
        extrapolated: false,
    };
    let is_open = !energy_j.is_settled() || risks.iter().any(|r| !r.is_settled());
    CandidateHarm {
        probability: 1.0,
        closing_m_s: 1.0,
        normal_m_s: 0.0,
        tangential_m_s: 0.0,
        contact: None,
        delta_v: [DeltaV::default(); 2],
        response: Response::default(),
        arms_m: [[0.0; 2]; 2],
        surface: [0.0; 2],
        yaw_rad_s: [[0.0; 2]; 2],
        crush: None,
        force_degrees: [0.0; 2],
        impulse_n_s: [0.0; 3],
        energy_j,
        persons: risks.iter().enumerate().map(person).collect(),
        unevaluable: None,
        is_open,
    }
}

pub(in crate::rank) fn settled(risks: &[f64]) -> CandidateHarm {
    let risks: Vec<Interval> = risks.iter().map(|r| Interval::exactly(*r)).collect();
    candidate(&risks, Interval::exactly(1000.0))
}

#[test]
fn states_are_named_as_answers_write_them() {
    use AnswerState::{Certified, Complete, Degraded, Refused};
    for state in [Complete, Certified, Degraded, Refused] {
        let written = toml::Value::try_from(state).map(|value| value.as_str().map(str::to_owned));
        assert_eq!(written, Ok(Some(state.name().to_owned())));
    }
}

fn open(ends: &[(f64, f64)]) -> CandidateHarm {
    let risks: Vec<Interval> = ends.iter().map(|e| Interval::new(e.0, e.1)).collect();
    candidate(&risks, Interval::ZERO)
}

/// A policy with these lines in place of the default's levels.
pub(in crate::rank) fn policy(composition: &str, rest: &str) -> Policy {
    let head = DEFAULT_POLICY.split("[[level]]").next().unwrap_or_default();
    let head = head.replace("\"lexicographic\"", &format!("\"{composition}\""));
    Policy::parse("test.toml", &format!("{head}{rest}")).expect("a sound policy")
}

pub(in crate::rank) fn level(rule: &str, tolerance: f64) -> String {
    format!("[[level]]\nrule = \"{rule}\"\ntolerance = {tolerance:?}\n")
}

pub(in crate::rank) fn weighted(bayes: f64, equality: f64, maximin: f64) -> Policy {
    let terms = [("bayes", bayes), ("equality", equality), ("maximin", maximin)];
    let text = terms.map(|(r, w)| format!("[[term]]\nrule = \"{r}\"\nweight = {w:?}\n"));
    policy("weighted", &text.concat())
}

/// The first of `n` is in the ego vehicle, every third on foot.
pub(in crate::rank) fn stakes(n: usize) -> Vec<Stake> {
    let stake = |i: usize| Stake { is_ego: i == 0, is_vulnerable: i % 3 == 2, responsibility: 0.0 };
    (0..n).map(stake).collect()
}

/// A policy for candidates whose names are their numbers, from 0.
pub(in crate::rank) fn among(policy: &Policy, count: usize) -> Arc<Policy> {
    let names: Vec<String> = (0..count).map(|k| k.to_string()).collect();
    Arc::new(policy.clone()).among(names.iter().map(String::as_str))
}

pub(in crate::rank) fn ranked(policy: &Policy, candidates: &[CandidateHarm]) -> RankedCandidates {
    let policy = among(policy, candidates.len());
    rank(&policy, &stakes(candidates[0].persons.len()), candidates).expect("sound candidates")
}

/// The winner's number, if the policy lets one be chosen.
fn winner(ranking: &RankedCandidates) -> Option<usize> {
    (!ranking.is_refused()).then(|| ranking.places[0].candidate)
}

fn order(ranking: &RankedCandidates) -> Vec<usize> {
    ranking.places.iter().map(|p| p.candidate + 1).collect()
}

/// Ego occupant, occupant of the other car, pedestrian.
pub(in crate::rank) fn k() -> [CandidateHarm; 3] {
    [[0.01, 0.0, 0.40], [0.20, 0.18, 0.0], [0.35, 0.0, 0.0]].map(|risks| settled(&risks))
}

#[test]
fn k_every_composition_gives_its_worked_order() {
    let by = |p: &Policy| order(&ranked(p, &k()));
    let single_level = |rule: &str| policy("lexicographic", &level(rule, 0.0));
    assert_eq!(by(&single_level("bayes")), [3, 2, 1]);
    assert_eq!(by(&single_level("equality")), [2, 3, 1]);
    // No mask: a person who is unharmed in one candidate is not thereby preferred.
    assert_eq!(by(&single_level("maximin")), [2, 3, 1]);
    let ego = single_level("ego-only");
    assert_eq!(by(&ego), [1, 2, 3]);
    assert_eq!(ranked(&ego, &k()).notes, [Note::EgoOnly]);
    let two = level("bayes", 0.015) + &level("maximin", 0.0);
    assert_eq!(by(&policy("lexicographic", &two)), [2, 3, 1]);
    assert_eq!(by(&policy("leximin", "")), [2, 3, 1]);
    assert_eq!(by(&weighted(0.5, 0.2, 0.3)), [2, 3, 1]);
}

#[test]
fn k_the_weight_of_bayes_flips_the_winner_where_it_should() {
    let winner = |bayes: f64| {
        let rest = 1.0 - bayes;
        order(&ranked(&weighted(bayes, 0.4 * rest, 0.6 * rest), &k()))[0]
    };
    assert_eq!([0.5, 0.9, 0.9285, 0.9286, 0.99].map(winner), [2, 2, 2, 3, 3]);
}

#[test]
fn k_precaution_filters_and_says_when_it_cannot() {
    let accept = |at_most: f64| {
        let first = format!("[[level]]\nrule = \"precaution\"\naccept = {at_most:?}\n");
        ranked(&policy("lexicographic", &(first + &level("bayes", 0.0))), &k())
    };
    let some = accept(0.3);
    assert_eq!((some.places[0].candidate, some.notes.len()), (1, 0));
    assert!(matches!(some.places[0].why, Some(Ground::Accept { .. })), "{:?}", some.places[0].why);
    let none = accept(0.1);
    assert_eq!(order(&none), [3, 2, 1]);
    assert_eq!(none.notes, [Note::NobodyAcceptable { at_most: 0.1 }]);
    assert!(!none.is_refused());
}

#[test]
fn k_a_binding_precaution_refuses_or_falls_back_and_says_so() {
    let accept = |otherwise: &str| {
        let first = "[[level]]\nrule = \"precaution\"\naccept = 0.1\n";
        let text = format!("{first}{otherwise}\n{}", level("bayes", 0.0));
        ranked(&policy("lexicographic", &text), &k())
    };
    let refused = accept("otherwise = \"refuse\"");
    assert_eq!((order(&refused), refused.state), (vec![3, 2, 1], AnswerState::Complete));
    assert_eq!(refused.notes, [Note::Refused { at_most: 0.1, missing: None }]);
    assert!(refused.is_refused() && refused.notes[0].sentence().starts_with("none is acceptable"));
    let fell_back = accept("otherwise = \"fall-back\"\nfall_back = \"1\"");
    assert_eq!((order(&fell_back), fell_back.is_refused()), (vec![2, 3, 1], false));
    let why = fell_back.places[0].why.as_ref().expect("there is a next");
    assert!(why.sentence("brake", "swerve").ends_with("and the policy falls back on it"));
    assert!(fell_back.notes[0].sentence().ends_with("falls back on \"1\""));
    let missing = accept("otherwise = \"fall-back\"\nfall_back = \"brake\"");
    assert_eq!((order(&missing), missing.is_refused()), (vec![3, 2, 1], true));
    assert!(missing.notes[0].sentence().contains("\"brake\" is not among them"));
}

/// A policy may know the names of more candidates than are ranked.
#[test]
fn a_policy_does_not_fall_back_on_who_is_not_ranked() {
    let first = "[[level]]\nrule = \"precaution\"\naccept = 0.1\n";
    let on = |name: &str| {
        let otherwise = format!("otherwise = \"fall-back\"\nfall_back = \"{name}\"\n");
        let policy = policy("lexicographic", &format!("{first}{otherwise}{}", level("bayes", 0.0)));
        rank(&among(&policy, 5), &stakes(3), &k()).expect("sound candidates")
    };
    assert!(!on("2").is_refused());
    for beyond in ["3", "4"] {
        let missing = Some(beyond.into());
        assert_eq!(on(beyond).notes, [Note::Refused { at_most: 0.1, missing }]);
    }
}

#[test]
fn the_first_is_certain_where_the_ranges_are_further_apart_than_the_tolerance() {
    let policy = policy("lexicographic", &level("bayes", 0.05));
    for (next, certain) in [(0.13, false), (0.149, false), (0.16, true)] {
        let ranking = ranked(&policy, &[settled(&[0.1]), settled(&[next])]);
        assert_eq!(ranking.places[0].certain, certain, "{next}");
    }
}

/// One candidate may turn out to be acceptable or not: then it is not certain that it wins, though
/// no other can.
#[test]
fn a_refusal_that_open_work_can_change_is_not_certain() {
    let first = "[[level]]\nrule = \"precaution\"\naccept = 0.4\notherwise = \"refuse\"\n";
    let policy = policy("lexicographic", &(first.to_owned() + &level("bayes", 0.0)));
    let with = |ends: (f64, f64)| {
        let mut candidate = open(&[ends]);
        candidate.persons[0].high_at_least = ends.0;
        let ranking = ranked(&policy, &[candidate]);
        (ranking.state, ranking.settled, ranking.is_refused())
    };
    assert_eq!(with((0.1, 0.3)), (AnswerState::Certified, 1, false));
    assert_eq!(with((0.1, 0.5)), (AnswerState::Degraded, 0, true));
    assert_eq!(with((0.5, 0.6)), (AnswerState::Certified, 1, true));
}

#[test]
fn responsibility_comes_from_the_request() {
    let stakes = [0.0, 0.0, 0.5].map(|responsibility| Stake { responsibility, ..Stake::default() });
    let policy = policy("lexicographic", &level("responsibility", 0.0));
    let ranking = rank(&policy, &stakes, &k()).expect("sound");
    assert_eq!(order(&ranking), [1, 3, 2]);
    assert!((ranking.places[0].work.hi() - 0.07).abs() < 1e-9);
}

/// Pairwise, the first would beat the third, the third the second, the second the first.
#[test]
fn a_tolerance_does_not_go_round_in_circles() {
    let candidates = [
        settled(&[0.3, 0.3, 0.0, 0.0, 0.0, 0.0]),
        settled(&[0.2, 0.2, 0.2, 0.06, 0.0, 0.0]),
        settled(&[0.13, 0.13, 0.13, 0.13, 0.13, 0.07]),
    ];
    let two = level("bayes", 0.012) + &level("maximin", 0.0);
    let policy = policy("lexicographic", &two);
    assert_eq!(order(&ranked(&policy, &candidates)), [2, 1, 3]);
    let [a, b, c] = candidates;
    assert_eq!(order(&ranked(&policy, &[c, a, b])), [3, 2, 1]);
}

#[test]
fn open_work_certifies_or_degrades_as_worked_out() {
    let policy = policy("lexicographic", &level("bayes", 0.0));
    let with = |third: (f64, f64)| {
        ranked(&policy, &[open(&[(0.10, 0.14)]), open(&[(0.15, 0.30)]), open(&[third])])
    };
    let sure = with((0.145, 0.16));
    assert_eq!((sure.state, sure.places[0].candidate), (AnswerState::Certified, 0));
    assert_eq!(sure.possible, [0]);
    let unsure = with((0.13, 0.16));
    assert_eq!((unsure.state, order(&unsure)), (AnswerState::Degraded, vec![1, 3, 2]));
    assert_eq!(unsure.possible, [0, 2]);
}

#[test]
fn two_levels_certify_what_one_cannot() {
    let levels = [
        ([(0.10, 0.12), (0.11, 0.13), (0.20, 0.25)], 0.025),
        ([(0.30, 0.35), (0.40, 0.50), (0.0, 0.0)], 0.0),
    ];
    let all = [0, 1, 2].as_slice();
    let mut outlook = Outlook { possible: all.into(), sure: all.into(), may_refuse: false };
    for (ends, tolerance) in levels {
        least(&mut outlook, &ends.map(|e| Interval::new(e.0, e.1)), tolerance);
    }
    assert_eq!(outlook.possible[..], [0]);
}

#[test]
fn finished_equals_are_certified_by_the_tie_break_over_open_work() {
    let candidates = [
        candidate(&[Interval::exactly(0.1)], Interval::exactly(9.0)),
        candidate(&[Interval::exactly(0.1)], Interval::exactly(9.0)),
        open(&[(0.2, 0.3)]),
    ];
    let ranking = ranked(&Policy::shipped().expect("sound"), &candidates);
    assert_eq!((ranking.state, ranking.possible.as_slice()), (AnswerState::Certified, &[0, 1][..]));
    assert_eq!(order(&ranking), [1, 2, 3]);
    let why = ranking.places[0].why.as_ref().expect("there is a next");
    assert!(matches!(why, Ground::TieBreak { by: TieBreak::Request, .. }), "{why:?}");
}

/// Whoever is named wins if surely nobody is acceptable; if somebody may be, nobody else can win;
/// and where the one named may have fallen out before, nothing is known.
#[test]
fn a_fall_back_encloses_what_the_finished_run_may_find() {
    let with = |is_first: bool, accept: f64, name: &str, ends: &[(f64, f64)]| {
        let first = format!("[[level]]\nrule = \"precaution\"\naccept = {accept:?}\n");
        let otherwise = format!("otherwise = \"fall-back\"\nfall_back = \"{name}\"\n");
        let text = format!("{first}{otherwise}{}", level("bayes", 0.0));
        let mut policy = policy("lexicographic", &text);
        // No file may say so, but whoever makes a policy may.
        policy.levels.rotate_left(usize::from(!is_first));
        let candidate = |end: &(f64, f64)| {
            let mut candidate = open(&[*end]);
            candidate.persons[0].high_at_least = end.0;
            candidate
        };
        let ranking = ranked(&policy, &ends.iter().map(candidate).collect::<Vec<_>>());
        (ranking.state, ranking.possible)
    };
    let surely_nobody = with(true, 0.4, "1", &[(0.5, 0.6), (0.7, 0.7)]);
    assert_eq!(surely_nobody, (AnswerState::Certified, vec![1]));
    let perhaps_one = with(true, 0.4, "2", &[(0.3, 0.5), (0.6, 0.6), (0.7, 0.7)]);
    assert_eq!(perhaps_one, (AnswerState::Degraded, vec![0, 2]));
    let may_be_out = with(false, 0.2, "1", &[(0.1, 0.5), (0.3, 0.3), (0.25, 0.5)]);
    assert_eq!(may_be_out, (AnswerState::Degraded, vec![0, 1, 2]));
    let nobody = with(false, 0.2, "1", &[(0.25, 0.5), (0.3, 0.3)]);
    assert_eq!(nobody, (AnswerState::Degraded, vec![0, 1]));
}

#[test]
fn a_weighted_sum_is_explained_by_the_rule_that_gains_most_and_by_no_percent() {
    // Bayes has the larger weight, ratio and sum; maximin the larger gain, 0.2 · 0.5.
    let text = "tolerance = 0.01\n".to_owned()
        + &{
            let terms = [("bayes", 0.8), ("maximin", 0.2)];
            terms.map(|(r, w)| format!("[[term]]\nrule = \"{r}\"\nweight = {w:?}\n")).concat()
        };
    let candidates = [[0.4, 0.4, 0.0, 0.0], [0.9, 0.1, 0.1, 0.1]].map(|risks| settled(&risks));
    let ranking = ranked(&policy("weighted", &text), &candidates);
    let why = ranking.places[0].why.as_ref().expect("there is a next");
    assert!(matches!(why, Ground::Least { rule: Some(Rule::Maximin), .. }), "{why:?}");
    let said = why.sentence("a", "b");
    assert!(said.contains(", more than 0.01 above the least, mostly from"), "{said}");
    let levels = level("bayes", 0.01);
    let why = ranked(&policy("lexicographic", &levels), &candidates).places[0].why.clone();
    let said = why.expect("there is a next").sentence("a", "b");
    assert!(said.ends_with(", more than 1 percentage points above the least"), "{said}");
}

/// Of an open candidate, only what open work cannot take away decides a tie.
#[test]
fn a_tie_break_takes_open_work_at_its_lower_end() {
    let by = |tie_break: &str, open: CandidateHarm| {
        let text = DEFAULT_POLICY.replace("property = \"last\"", "property = \"ignored\"");
        let line = text.lines().find(|line| line.starts_with("tie_break")).expect("it has one");
        let text = text.replace(line, &format!("tie_break = [\"{tie_break}\", \"request\"]"));
        let policy = Policy::parse("", &text.replace("tolerance = 0.0", "tolerance = 0.3"));
        let done = candidate(&[Interval::exactly(0.1)], Interval::exactly(1_000.0));
        let ranking = ranked(&policy.expect("sound"), &[open, done]);
        (ranking.state == AnswerState::Certified).then(|| ranking.places[0].candidate)
    };
    let energy = |lo: f64| candidate(&[Interval::exactly(0.1)], Interval::new(lo, 3_000.0));
    assert_eq!((by("energy", energy(1_001.0)), by("energy", energy(999.0))), (Some(1), None));
    let high = |lo: f64| open(&[(lo, 0.3)]);
    assert_eq!((by("high", high(0.11)), by("high", high(0.09))), (Some(1), None));
}

/// Whether the second candidate passes the first step depends on the open third, which itself drops
/// out at the second: so the tie-break may not take the second as certain, though both are
/// finished.
#[test]
fn a_tie_break_certifies_only_who_was_surely_kept() {
    let with = |ends: &[(f64, f64)], energy_j: f64| {
        let mut risks = vec![Interval::ZERO; 10];
        for (risk, end) in risks.iter_mut().zip(ends) {
            *risk = Interval::new(end.0, end.1);
        }
        candidate(&risks, Interval::exactly(energy_j))
    };
    let point = |r: f64| (r, r);
    let first = with(&[point(0.3), point(0.3), point(0.3), point(0.1)], 9.0);
    let second = with(&[point(0.3); 4], 1.0);
    let third = with(&[point(0.5), (0.0, 1.0), (0.0, 0.5)], 0.0);
    let text = DEFAULT_POLICY.replace("property = \"last\"", "property = \"ignored\"");
    let policy = Policy::parse("", &text.replacen("tolerance = 0.0", "tolerance = 0.05", 1));
    let ranking = ranked(&policy.expect("sound"), &[first, second, third]);
    assert_eq!((ranking.state, ranking.possible), (AnswerState::Degraded, vec![0, 1]));
    assert_eq!(ranking.places[0].candidate, 1);
}

#[test]
fn property_decides_only_between_equal_persons() {
    let with =
        |risk: f64, energy: f64| candidate(&[Interval::exactly(risk)], Interval::exactly(energy));
    let candidates = [with(0.1, 9e5), with(0.1, 8e5), with(0.100_001, 0.0)];
    let ranking = ranked(&Policy::shipped().expect("sound"), &candidates);
    assert_eq!((ranking.state, order(&ranking)), (AnswerState::Complete, vec![2, 1, 3]));
    let why = ranking.places[0].why.as_ref().expect("there is a next");
    assert!(why.sentence("wall", "pole").contains("less property is damaged (800.0 against 900.0"));
    assert!(matches!(why, Ground::Least { person: None, .. }), "{why:?}");
}

#[test]
fn no_contact_ranks_like_any_other() {
    let candidates = [settled(&[0.1, 0.0]), settled(&[0.0, 0.0]), settled(&[0.0, 0.0])];
    let ranking = ranked(&Policy::shipped().expect("sound"), &candidates);
    assert_eq!((ranking.state, order(&ranking)), (AnswerState::Complete, vec![2, 3, 1]));
    assert_eq!(ranking.places[0].work.hi().to_bits(), 0);
    assert_eq!(ranking.tie_class, [1, 2]);
    assert!(!ranking.places[0].certain && ranking.places[1].certain);
}

#[test]
fn who_cannot_be_evaluated_is_ranked_last_and_may_still_win() {
    let mut lost = open(&[(0.0, 1.0)]);
    lost.unevaluable = Some(crate::harm::Unevaluable::AlreadyOverlapping);
    lost.is_open = false;
    let policy = Policy::shipped().expect("sound");
    let ranking = ranked(&policy, &[lost.clone(), settled(&[0.2])]);
    assert_eq!((ranking.state, order(&ranking)), (AnswerState::Degraded, vec![2, 1]));
    assert_eq!(ranking.possible, [0, 1]);
    assert_eq!(ranked(&policy, &[lost.clone(), lost]).state, AnswerState::Refused);
}

#[test]
fn the_term_that_separates_first_from_second_is_named() {
    let ranking = ranked(&weighted(0.5, 0.2, 0.3), &k());
    let why = ranking.places[0].why.as_ref().expect("there is a next");
    let Ground::Least { first, second, rule, person, .. } = why else { panic!("{why:?}") };
    assert!((first - 0.15).abs() < 1e-9 && (second - 0.21).abs() < 1e-9);
    // .3·(.35 − .2) is more than .2·(.23333 − .13333), and Bayes favours the other.
    assert_eq!((*rule, *person), (Some(Rule::Maximin), Some(PersonId(1))));
    let sentence = why.sentence("swerve", "brake");
    assert_eq!(
        sentence,
        "swerve before brake: weighted sum 0.15 against 0.21, mostly from greatest risk"
    );
}

#[test]
fn a_reason_is_in_percent_with_as_many_digits_as_tell_both_apart() {
    let said = |first: f64, second: f64| {
        let (policy, figures) = (Policy::shipped().expect("sound"), [first, second]);
        let ranking = ranked(&policy, &figures.map(|risk| settled(&[risk])));
        ranking.places[0].why.as_ref().expect("there is a next").sentence("a", "b")
    };
    assert_eq!(said(0.0051, 0.01273), "a before b: mean risk 0.51 % against 1.27 %");
    assert_eq!(said(0.05123, 0.05124), "a before b: mean risk 5.123 % against 5.124 %");
    assert_eq!(said(1e-9, 0.0018), "a before b: mean risk < 0.01 % against 0.18 %");
    assert_eq!(said(0.0, 1.0), "a before b: mean risk 0 % against 100.00 %");
    assert_eq!(said(1e-4, 0.5), "a before b: mean risk 0.01 % against 50.00 %");
}

/// A zero is +0, so that no answer says "-0".
#[test]
fn a_figure_has_no_negative_zero() {
    assert_eq!(rounded(-0.0).to_bits(), 0);
    assert_eq!(rounded(-1e-12).to_bits(), 0);
}

#[test]
fn a_risk_is_the_harm_times_its_probability() {
    let half = CandidateHarm { probability: 0.5, ..settled(&[0.4]) };
    let ranking = ranked(&policy("lexicographic", &level("bayes", 0.0)), &[settled(&[0.3]), half]);
    assert_eq!(order(&ranking), [2, 1]);
    assert_eq!(ranking.places[0].work, Interval::exactly(0.2));
}

#[test]
fn what_cannot_be_ranked_is_refused() {
    let policy = Policy::shipped().expect("sound");
    assert_eq!(rank::<CandidateHarm>(&policy, &[], &[]), Err(RankError::NoCandidates));
    let unknown = rank(&policy, &[Stake::default()], &[settled(&[0.1, 0.2])]);
    let person = PersonId(1);
    assert_eq!(unknown, Err(RankError::UnknownPerson { candidate: 0, person }));
    for responsibility in [-0.1, 1.1, f64::NAN] {
        let stakes = [Stake { responsibility, ..Stake::default() }];
        let error = RankError::Responsibility(PersonId(0));
        assert_eq!(rank(&policy, &stakes, &[settled(&[0.1])]), Err(error));
    }
    let alone = |harm: CandidateHarm| rank(&policy, &[Stake::default()], &[harm]);
    for probability in [-0.1, 1.1, f64::NAN] {
        let harm = CandidateHarm { probability, ..settled(&[0.1]) };
        assert_eq!(alone(harm), Err(RankError::Figure(0)));
    }
    for energy_j in [Interval::new(-1.0, 1.0), Interval::new(0.0, f64::INFINITY)] {
        assert_eq!(alone(candidate(&[Interval::ZERO], energy_j)), Err(RankError::Figure(0)));
    }
    let bounds = CandidateBounds {
        probability: f64::NAN,
        energy_j: Interval::ZERO,
        persons: Vec::new(),
        is_done: false,
    };
    let unsound = standing(&policy, &[Stake::default()], &[bounds]);
    assert_eq!(unsound, Err(RankError::Figure(0)));
    let lost = candidate(&[Interval::new(f64::NAN, 0.3)], Interval::ZERO);
    assert_eq!(rank(&policy, &[Stake::default()], &[lost]), Err(RankError::Figure(0)));
}
