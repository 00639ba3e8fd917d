//! Shipped policies load; unsound ones are refused with their place.

use super::*;

fn refused(text: &str) -> crate::fault::DataFileError {
    Policy::parse("my.toml", text).expect_err(text)
}

const WEIGHTED: &str =
    include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/config/policies/weighted.toml"));
const LEXIMIN: &str =
    include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/config/policies/worst-off-first.toml"));
const PRECAUTION: &str =
    include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/config/policies/precaution.toml"));

const BINDING: &str = "\n[[level]]\nrule = \"precaution\"\naccept = 0.1\notherwise = \"refuse\"\n";

fn least(rule: Rule, tolerance: f64) -> Step {
    Step::Least { measure: Measure::Rule(rule), tolerance }
}

const ENERGY: Step = Step::Least { measure: Measure::Energy, tolerance: 0.0 };

#[test]
fn the_default_is_bayes_then_the_worst_off_then_property() {
    let policy = Policy::shipped().expect("the shipped policy is sound");
    let expected = [least(Rule::Bayes, 0.0), least(Rule::Maximin, 0.0), ENERGY];
    assert_eq!(policy.steps(3), expected);
    assert_eq!(policy.outcome, Level::Mais3);
    assert!(!policy.is_ego_only());
}

#[test]
fn every_shipped_policy_loads_and_weighs_property_last() {
    for text in [DEFAULT_POLICY, WEIGHTED, LEXIMIN, PRECAUTION] {
        let policy = Policy::parse("shipped", text).expect("sound");
        let steps = policy.steps(4);
        assert_eq!(steps.last(), Some(&ENERGY));
        assert_eq!(steps.iter().filter(|s| **s == ENERGY).count(), 1);
    }
    assert_eq!(Policy::parse("", LEXIMIN).expect("sound").steps(4).len(), 5);
}

/// A tolerance must not let property outweigh the persons that it let pass.
#[test]
fn before_property_persons_are_compared_again_without_tolerance() {
    let policy = Policy::parse("", PRECAUTION).expect("sound");
    let expected = [
        Step::Accept { at_most: 0.1, otherwise: Otherwise::NextRule },
        least(Rule::Responsibility, 0.005),
        least(Rule::Maximin, 0.0),
        least(Rule::Responsibility, 0.0),
        ENERGY,
    ];
    assert_eq!(policy.steps(2), expected);
}

#[test]
fn unsound_policies_are_refused_with_their_place() {
    let default = |from: &str, to: &str| DEFAULT_POLICY.replacen(from, to, 1);
    let weighted = |from: &str, to: &str| WEIGHTED.replacen(from, to, 1);
    let precaution =
        |more: &str| PRECAUTION.replacen("accept = 0.1", &format!("accept = 0.1\n{more}"), 1);
    let preferred = |names: &str| {
        let tie_break = format!("preferred = {names}\ntie_break = [\"brake-in-lane\", ");
        DEFAULT_POLICY.replacen("tie_break = [\"energy\", ", &tie_break, 1)
    };
    let cases = [
        (default("schema = 1", "schema = 7"), "unknown schema"),
        (default("\"bayes\"", "\"bayesian\""), "bayesian"),
        (default("tolerance = 0.0", "tolerance = -0.1"), "[0, 1]"),
        (default("tolerance = 0.0", "tolerance = nan"), "[0, 1]"),
        (default("tolerance = 0.0", "accept = 0.1"), "accept belongs to precaution"),
        (default("rule = \"bayes\"", "rule = \"precaution\""), "accept alone"),
        (default("\"request\"]", "\"energy\"]"), "ties could remain"),
        (default("composition", "age = 30\ncomposition"), "unknown field `age`"),
        (default("property = \"last\"", "property = \"first\""), "first"),
        (DEFAULT_POLICY.split("[[level]]").next().unwrap_or("").to_owned(), "no rule"),
        (format!("{DEFAULT_POLICY}\n[[term]]\nrule = \"bayes\"\nweight = 1.0\n"), "weighted"),
        (weighted("weight = 0.5", "weight = -0.5"), "not a weight"),
        (weighted("weight = 0.5", "weight = 0.0"), "sum to"),
        (weighted("weight = 0.5", "weight = inf"), "not a weight"),
        (weighted("rule = \"equality\"", "rule = \"bayes\""), "twice"),
        (weighted("tolerance = 0.0", "tolerance = 2.0"), "[0, 1]"),
        (format!("{WEIGHTED}\n[[level]]\nrule = \"bayes\"\n"), "only precaution"),
        (default("tolerance = 0.0", "otherwise = \"refuse\""), "otherwise belongs to precaution"),
        (default("tolerance = 0.0", "fall_back = \"brake\""), "fall_back belongs to precaution"),
        (precaution("otherwise = \"fall-back\""), "on what to fall back"),
        (precaution("fall_back = \"brake\""), "fall_back says nothing here"),
        (precaution("otherwise = \"refuse\"\nfall_back = \"brake\""), "fall_back says nothing"),
        (precaution("otherwise = \"fall-back\"\nfall_back = \" \""), "without a name"),
        (precaution("otherwise = \"stop\""), "stop"),
        (format!("{DEFAULT_POLICY}{BINDING}"), "binds behind another rule"),
        (default("\"energy\"", "\"brake-in-lane\""), "not said to be any candidate"),
        (default("tie_break", "preferred = [\"a\"]\ntie_break"), "preferred decides nothing"),
        (preferred("[\"a\", \"a\"]"), "preferred twice"),
        (preferred("[\"\"]"), "without a name"),
        (preferred("[]"), "not said to be any candidate"),
        (preferred("[\"a\"]").replace("\"high\"", "\"brake-in-lane\""), "occurs twice"),
    ];
    for (text, expected) in cases {
        let fault = refused(&text);
        assert!(fault.what.contains(expected), "{expected}: {fault}");
        assert!(fault.line >= 1 && !fault.remedy.is_empty(), "{fault}");
    }
}

#[test]
fn traits_of_persons_are_refused_by_name() {
    for key in ["age", "sex", "condition"] {
        let text = DEFAULT_POLICY.replacen("[[level]]", &format!("[[level]]\n{key} = 1"), 1);
        let fault = refused(&text);
        assert!(fault.remedy.contains(&format!("never weighed by {key}")), "{fault}");
        let line = text.lines().position(|l| l.starts_with(key)).map(|l| l + 1);
        assert_eq!(Some(fault.line), line);
    }
}

/// With a third each, risks (.2, .2, .1) would count as better than (.2, .2, 0).
#[test]
fn equality_may_not_make_harm_an_improvement() {
    let third = "weight = 0.333333333333";
    let text = WEIGHTED
        .replace("weight = 0.5", third)
        .replace("weight = 0.2", third)
        .replace("weight = 0.3\n", "weight = 0.333333333334\n");
    assert!(refused(&text).what.contains("more than half of bayes"));
    let stakes = [crate::rule::Stake::default(); 3];
    let sum = |risks: &[f64]| {
        let rules = [Rule::Bayes, Rule::Equality, Rule::Maximin];
        rules.iter().map(|r| r.value(risks, &stakes) / 3.0).sum::<f64>()
    };
    assert!((sum(&[0.2, 0.2, 0.0]) - 0.15556).abs() < 1e-5);
    assert!((sum(&[0.2, 0.2, 0.1]) - 0.14444).abs() < 1e-5);
}

#[test]
fn a_policy_finds_the_candidates_that_it_names_by_their_exact_names() {
    let head = DEFAULT_POLICY.replace(
        "tie_break = [\"energy\"",
        "preferred = [\"brake in lane\", \"brake\"]\ntie_break = [\"brake-in-lane\"",
    );
    let (head, levels) = head.split_at(head.find("[[level]]").expect("it has levels"));
    let first = "[[level]]\nrule = \"precaution\"\naccept = 0.1\notherwise = \"fall-back\"\n";
    let text = format!("{head}{first}fall_back = \"brake\"\n{levels}");
    let policy = Arc::new(Policy::parse("", &text).expect("sound"));
    let numbers = |names: &[&str]| {
        let policy = policy.among(names.iter().copied());
        let Step::Accept { otherwise, .. } = &policy.levels[0] else { panic!("{policy:?}") };
        let preferred = policy.preferred.iter().map(|named| named.number);
        (otherwise.fall_back(), preferred.collect::<Vec<_>>())
    };
    assert_eq!(numbers(&["swerve", "brake", "brake in lane"]), (Some(1), vec![Some(2), Some(1)]));
    assert_eq!(numbers(&["Brake", "brake "]), (None, vec![None, None]));
    assert_eq!(policy.levels[0].to_string(), "nobody's upper end above 0.1, or \"brake\"");
    // What names nobody is not copied.
    let shipped = Arc::new(Policy::shipped().expect("sound"));
    assert!(Arc::ptr_eq(&shipped, &shipped.among(["brake"].into_iter())));
}
