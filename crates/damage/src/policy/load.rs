//! Reading a policy from TOML, and the checks that refuse an unsound one.

use super::{Composition, DEFAULT_POLICY, Policy, Property, Step, TieBreak};
use crate::curve::Level;
use crate::fault::{DataFileError, Source};
use crate::rule::{Measure, Rule, Term};
use serde::Deserialize;
use toml::Spanned;

/// Weights sum to 1 within this.
const SUM_SLACK: f64 = 1e-9;

const KEYS: &str = "a policy has schema, name, board, outcome, composition, property, tie_break, \
                    tolerance, [[level]] (rule, tolerance, accept) and, if weighted, [[term]] \
                    (rule, weight)";

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    schema: Spanned<u32>,
    name: String,
    board: String,
    outcome: Level,
    composition: Spanned<Kind>,
    property: Property,
    tie_break: Spanned<Vec<TieBreak>>,
    tolerance: Option<Spanned<f64>>,
    #[serde(default)]
    level: Vec<Spanned<LevelText>>,
    #[serde(default)]
    term: Vec<Spanned<TermText>>,
}

#[derive(Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Kind {
    Weighted,
    Lexicographic,
    Leximin,
}

#[derive(Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum LevelRule {
    Bayes,
    Equality,
    Maximin,
    Responsibility,
    EgoOnly,
    Precaution,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct LevelText {
    rule: LevelRule,
    tolerance: Option<Spanned<f64>>,
    accept: Option<Spanned<f64>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct TermText {
    rule: Rule,
    weight: Spanned<f64>,
}

impl LevelRule {
    fn rule(self) -> Option<Rule> {
        match self {
            Self::Bayes => Some(Rule::Bayes),
            Self::Equality => Some(Rule::Equality),
            Self::Maximin => Some(Rule::Maximin),
            Self::Responsibility => Some(Rule::Responsibility),
            Self::EgoOnly => Some(Rule::EgoOnly),
            Self::Precaution => None,
        }
    }
}

impl Policy {
    /// The policy that ships with the program.
    ///
    /// # Errors
    ///
    /// Never for the file as shipped: a test reads it.
    pub fn shipped() -> Result<Self, DataFileError> {
        Self::parse("config/policies/default.toml", DEFAULT_POLICY)
    }

    /// Reads and checks a policy. `file` is only named in errors.
    ///
    /// # Errors
    ///
    /// Line, column, fault and remedy, for: text that is not TOML, a missing or unknown key (age,
    /// sex and condition among them), an unknown rule, weights that are negative, not finite or do
    /// not sum to 1, more weight on equality than half of that on Bayes, a tolerance or accepted
    /// risk out of [0, 1], keys that do not go together, and a tie-break that leaves ties.
    pub fn parse(file: &str, text: &str) -> Result<Self, DataFileError> {
        let source = Source { file, text };
        let read: File = toml::from_str(text).map_err(|e| source.malformed(&e, KEYS))?;
        if *read.schema.get_ref() != 1 {
            return Err(source.fault(read.schema.span(), "unknown schema", "write schema = 1"));
        }
        let kind = *read.composition.get_ref();
        let span = read.composition.span();
        let mut levels = Vec::with_capacity(read.level.len());
        for level in &read.level {
            let step = step(&source, level)?;
            if kind != Kind::Lexicographic && matches!(step, Step::Least { .. }) {
                let fault = "only precaution can come before a weighted sum or leximin";
                let remedy = "take the rule into a [[term]], or compose lexicographically";
                return Err(source.fault(level.span(), fault, remedy));
            }
            levels.push(step);
        }
        if kind != Kind::Weighted
            && let Some(term) = read.term.first()
        {
            let remedy = "write composition = \"weighted\", or [[level]] instead";
            return Err(source.fault(term.span(), "[[term]] needs a weighted sum", remedy));
        }
        let tolerance = match (&read.tolerance, kind) {
            (Some(t), Kind::Lexicographic) => {
                let fault = "a lexicographic policy has a tolerance per level";
                return Err(source.fault(t.span(), fault, "move it into [[level]]"));
            }
            (t, _) => t.as_ref().map_or(Ok(0.0), |t| share(&source, t))?,
        };
        let composition = match kind {
            Kind::Weighted => {
                Composition::Weighted { terms: weights(&source, &read.term, span)?, tolerance }
            }
            Kind::Leximin => Composition::Leximin { tolerance },
            Kind::Lexicographic if !levels.iter().any(|s| matches!(s, Step::Least { .. })) => {
                let remedy = "add a [[level]] with rule = \"bayes\" or another";
                return Err(source.fault(span, "no rule compares the candidates", remedy));
            }
            Kind::Lexicographic => Composition::Lexicographic,
        };
        let tie_break = read.tie_break.get_ref();
        let is_total = tie_break.last() == Some(&TieBreak::Request)
            && tie_break.iter().filter(|t| **t == TieBreak::Request).count() == 1;
        if !is_total {
            let remedy = "end tie_break with \"request\", and name it once: it leaves no tie";
            return Err(source.fault(read.tie_break.span(), "ties could remain", remedy));
        }
        Ok(Self {
            name: read.name,
            board: read.board,
            outcome: read.outcome,
            levels,
            composition,
            property: read.property,
            tie_break: read.tie_break.into_inner(),
        })
    }
}

/// A number in [0, 1].
fn share(source: &Source<'_>, number: &Spanned<f64>) -> Result<f64, DataFileError> {
    let value = *number.get_ref();
    if (0.0..=1.0).contains(&value) {
        return Ok(value + 0.0);
    }
    Err(source.fault(number.span(), "not a number in [0, 1]", "write a risk between 0 and 1"))
}

fn step(source: &Source<'_>, text: &Spanned<LevelText>) -> Result<Step, DataFileError> {
    let level = text.get_ref();
    match (level.rule.rule(), &level.accept, &level.tolerance) {
        (Some(rule), None, tolerance) => Ok(Step::Least {
            measure: Measure::Rule(rule),
            tolerance: tolerance.as_ref().map_or(Ok(0.0), |t| share(source, t))?,
        }),
        (None, Some(accept), None) => Ok(Step::Accept { at_most: share(source, accept)? }),
        (Some(_), Some(accept), _) => {
            let remedy = "remove accept, or write rule = \"precaution\"";
            Err(source.fault(accept.span(), "accept belongs to precaution", remedy))
        }
        (None, _, _) => {
            let remedy = "write accept = the greatest acceptable risk, and no tolerance";
            Err(source.fault(text.span(), "precaution needs accept alone", remedy))
        }
    }
}

fn weights(
    source: &Source<'_>,
    texts: &[Spanned<TermText>],
    place: core::ops::Range<usize>,
) -> Result<Vec<Term>, DataFileError> {
    let mut terms: Vec<Term> = Vec::with_capacity(texts.len());
    for text in texts {
        let term = Term { rule: text.get_ref().rule, weight: *text.get_ref().weight.get_ref() };
        if !(term.weight >= 0.0 && term.weight.is_finite()) {
            let span = text.get_ref().weight.span();
            return Err(source.fault(span, "not a weight", "write a finite number ≥ 0"));
        }
        if terms.iter().any(|t| t.rule == term.rule) {
            return Err(source.fault(text.span(), "a rule occurs twice", "add the weights up"));
        }
        terms.push(term);
    }
    let sum: f64 = terms.iter().map(|t| t.weight).sum();
    if (sum - 1.0).abs() > SUM_SLACK {
        let fault = format!("weights sum to {sum}, not to 1");
        return Err(source.fault(place, fault, "write weights that sum to 1"));
    }
    let weight = |rule: Rule| terms.iter().filter(|t| t.rule == rule).map(|t| t.weight).sum();
    let (equality, bayes): (f64, f64) = (weight(Rule::Equality), weight(Rule::Bayes));
    if equality > 0.5 * bayes {
        let fault = format!("equality weighs {equality}, more than half of bayes ({bayes})");
        let remedy = "lower it: beyond that, hurting the best-off person improves the sum";
        return Err(source.fault(place, fault, remedy));
    }
    Ok(terms)
}
