//! A policy and curves in place of those that scenarios name, read once for many of them.

use crate::{Failure, Scenario, SourceText};
use damage::{Criteria, Curves, Policy};
use std::sync::Arc;

/// A policy, a set of curves, or both, to judge scenarios by in place of their own.
///
/// ```
/// use trolley::{Judge, Scenario};
///
/// let scenario = Scenario::open("../../config/scenarios/small.toml")?;
/// let judge = Judge::new(Some(&trolley::read_policy("worst-off-first".as_ref())?), None)?;
/// let criteria = judge.criteria(&scenario)?;
/// assert_eq!((criteria.policy.name.as_str(), criteria.curves.name.as_str()),
///            ("worst-off-first", "default"));
/// # Ok::<(), trolley::Failure>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct Judge {
    policy: Option<Arc<Policy>>,
    curves: Option<Arc<Curves>>,
}

impl Judge {
    /// Reads both; `None`: that of the scenario.
    ///
    /// ```
    /// # use trolley::{Judge, SourceText};
    /// let text = SourceText { name: "own.toml".to_owned(), text: "schema = 3".to_owned() };
    /// assert!(Judge::new(Some(&text), None).is_err());
    /// assert!(Judge::new(None, None).is_ok());
    /// ```
    ///
    /// # Errors
    ///
    /// If one is not valid: file, place, fault and remedy.
    pub fn new(policy: Option<&SourceText>, curves: Option<&SourceText>) -> Result<Self, Failure> {
        let policy = policy.map(|policy| Policy::parse(&policy.name, &policy.text));
        let curves = curves.map(|curves| Curves::parse(&curves.name, &curves.text));
        let (policy, curves) = (policy.transpose()?, curves.transpose()?);
        Ok(Self { policy: policy.map(Arc::new), curves: curves.map(Arc::new) })
    }

    /// Returns what a scenario is judged by.
    ///
    /// ```
    /// # let scenario = trolley::Scenario::open("../../config/scenarios/small.toml")?;
    /// let criteria = trolley::Judge::default().criteria(&scenario)?;
    /// assert_eq!(criteria.policy.name, scenario.criteria().policy.name);
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    ///
    /// # Errors
    ///
    /// If the curves do not cover the outcome of the policy.
    pub fn criteria(&self, scenario: &Scenario) -> Result<Criteria, Failure> {
        let own = scenario.criteria();
        let policy = self.policy.as_ref().unwrap_or(&own.policy);
        let curves = self.curves.as_ref().unwrap_or(&own.curves);
        let covered = curves.covers(policy.outcome);
        covered.map_err(|missing| Failure::input(missing.to_string()).at(scenario.file()))?;
        let (policy, curves) = (Arc::clone(policy), Arc::clone(curves));
        Ok(Criteria { policy, curves, parameters: Arc::clone(&own.parameters) })
    }
}
