//! Reading a policy from TOML, and the checks that refuse an unsound one.

use super::dossier::{DossierText, RegressionText, dossier};
use super::{
    Composition, DEFAULT_POLICY, NamedCandidate, Otherwise, Policy, Property, Step, TieBreak,
};
use crate::curve::Level;
use crate::fault::{DataFileError, Source};
use crate::rule::{Measure, Rule, Term};
use serde::Deserialize;
use std::sync::Arc;
use toml::Spanned;

/// Weights sum to 1 within this.
const SUM_SLACK: f64 = 1e-9;

const KEYS: &str = "a policy has schema, name, board, outcome, composition, property, tie_break, \
                    preferred, tolerance, [[level]] (rule, tolerance, accept, otherwise, \
                    fall_back), if weighted, [[term]] (rule, weight), and, if signed, [dossier] \
                    (signed, dissent, evidence, valid_until) and [[regression]] (scenario, \
                    winner or refused, worst, reason)";

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
    preferred: Option<Spanned<Vec<String>>>,
    tolerance: Option<Spanned<f64>>,
    #[serde(default)]
    level: Vec<Spanned<LevelText>>,
    #[serde(default)]
    term: Vec<Spanned<TermText>>,
    dossier: Option<Spanned<DossierText>>,
    #[serde(default)]
    regression: Vec<Spanned<RegressionText>>,
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
    Vulnerable,
    Uninvolved,
    Precaution,
}

#[derive(Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum OtherwiseText {
    NextRule,
    Refuse,
    FallBack,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct LevelText {
    rule: LevelRule,
    tolerance: Option<Spanned<f64>>,
    accept: Option<Spanned<f64>>,
    otherwise: Option<Spanned<OtherwiseText>>,
    fall_back: Option<Spanned<String>>,
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
            Self::Vulnerable => Some(Rule::Vulnerable),
            Self::Uninvolved => Some(Rule::Uninvolved),
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
    /// risk out of [0, 1], keys that do not go together, a tie-break that leaves ties, an accepted
    /// risk that binds behind another rule, and a dossier without names or with a bad date.
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
            let next = Otherwise::NextRule;
            let binds = matches!(&step, Step::Accept { otherwise, .. } if *otherwise != next);
            if binds && !levels.is_empty() {
                let fault = "an accepted risk binds behind another rule";
                let remedy = "make it the first [[level]]: what binds comes before what compares";
                return Err(source.fault(level.span(), fault, remedy));
            }
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
        let preferred = preferred(&source, &read.tie_break, read.preferred.as_ref())?;
        let dossier = dossier(&source, read.dossier, read.regression)?;
        Ok(Self {
            name: read.name,
            board: read.board,
            outcome: read.outcome,
            levels,
            composition,
            property: read.property,
            tie_break: read.tie_break.into_inner(),
            preferred,
            dossier: dossier.map(Arc::new),
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
    let keys = [
        level.otherwise.as_ref().map(|key| ("otherwise", key.span())),
        level.fall_back.as_ref().map(|key| ("fall_back", key.span())),
    ];
    if let Some((key, span)) = keys.into_iter().flatten().next()
        && level.rule != LevelRule::Precaution
    {
        let remedy = format!("remove {key}, or write rule = \"precaution\"");
        return Err(source.fault(span, format!("{key} belongs to precaution"), remedy));
    }
    match (level.rule.rule(), &level.accept, &level.tolerance) {
        (Some(rule), None, tolerance) => Ok(Step::Least {
            measure: Measure::Rule(rule),
            tolerance: tolerance.as_ref().map_or(Ok(0.0), |t| share(source, t))?,
        }),
        (None, Some(accept), None) => Ok(Step::Accept {
            at_most: share(source, accept)?,
            otherwise: otherwise(source, level)?,
        }),
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

/// What a precaution says if no candidate is acceptable.
fn otherwise(source: &Source<'_>, level: &LevelText) -> Result<Otherwise, DataFileError> {
    let said = level.otherwise.as_ref();
    match (said.map(|said| *said.get_ref()), &level.fall_back) {
        (None | Some(OtherwiseText::NextRule), None) => Ok(Otherwise::NextRule),
        (Some(OtherwiseText::Refuse), None) => Ok(Otherwise::Refuse),
        (Some(OtherwiseText::FallBack), Some(name)) => {
            named(source, name.get_ref(), name.span()).map(Otherwise::FallBack)
        }
        (Some(OtherwiseText::FallBack), None) => {
            let remedy = "write fall_back = the name of a candidate, as scenarios write it";
            let span = said.map_or(0..0, Spanned::span);
            Err(source.fault(span, "it is not said on what to fall back", remedy))
        }
        (_, Some(name)) => {
            let remedy = "write otherwise = \"fall-back\", or remove fall_back";
            Err(source.fault(name.span(), "fall_back says nothing here", remedy))
        }
    }
}

/// A candidate that is named.
fn named(
    source: &Source<'_>,
    name: &str,
    span: core::ops::Range<usize>,
) -> Result<NamedCandidate, DataFileError> {
    if name.trim().is_empty() {
        let remedy = "write the name of a candidate, as scenarios write it";
        return Err(source.fault(span, "a candidate without a name", remedy));
    }
    Ok(NamedCandidate::new(name))
}

/// The candidates that the tie-break prefers: there are some where it does, and none where not.
fn preferred(
    source: &Source<'_>,
    tie_break: &Spanned<Vec<TieBreak>>,
    names: Option<&Spanned<Vec<String>>>,
) -> Result<Vec<NamedCandidate>, DataFileError> {
    let uses = tie_break.get_ref().iter().filter(|by| **by == TieBreak::BrakeInLane).count();
    let names = match (uses, names) {
        (0, None) => return Ok(Vec::new()),
        (1, Some(names)) if !names.get_ref().is_empty() => names,
        (1, _) => {
            let remedy = "write preferred = [\"brake in lane\"], names as scenarios write them";
            return Err(source.fault(
                tie_break.span(),
                "brake-in-lane is not said to be any candidate",
                remedy,
            ));
        }
        (0, Some(names)) => {
            let remedy = "add \"brake-in-lane\" to tie_break, or remove preferred";
            return Err(source.fault(names.span(), "preferred decides nothing", remedy));
        }
        _ => {
            let remedy = "name brake-in-lane once";
            return Err(source.fault(tie_break.span(), "a tie-break occurs twice", remedy));
        }
    };
    let mut preferred: Vec<NamedCandidate> = Vec::with_capacity(names.get_ref().len());
    for name in names.get_ref() {
        if preferred.iter().any(|known| *known.name == **name) {
            let fault = format!("\"{name}\" is preferred twice");
            return Err(source.fault(names.span(), fault, "name each candidate once"));
        }
        preferred.push(named(source, name, names.span())?);
    }
    Ok(preferred)
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
