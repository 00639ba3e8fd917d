//! A scenario over a horizon with the policy and the curves that judge it: where everybody is now,
//! where they may go, and what the ego could do.
//!
//! ```
//! use trolley::{Engine, Horizon, Limits};
//!
//! let horizon = Horizon::open("../../config/scenarios/crossing.toml")?;
//! let mut engine = Engine::builder().in_process().build()?;
//! let ranking = engine.rank_horizon(&horizon, &Limits::default())?;
//! for row in &ranking.answer.ranking {
//!     match row.contacts.first() {
//!         Some(contact) => println!("{}: {} after {} s", row.name, contact.party, contact.time_s),
//!         None => println!("{}: touches nobody", row.name),
//!     }
//! }
//! # Ok::<(), trolley::Failure>(())
//! ```

use crate::bodies::PartyBody;
use crate::files::{self, InputKind};
use crate::references::{References, beside};
use crate::scenario::{SourceText, named, read_text};
use crate::{Failure, FailureKind};
use damage::injury::DEFAULT_CURVES;
use damage::policy::DEFAULT_POLICY;
use damage::{Curves, Policy};
use scenario::{FileRef, HorizonDraft, HorizonScenario, Source};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A scenario over a horizon, and the policy and curves to rank it by: read and checked.
///
/// ```
/// let horizon = trolley::Horizon::open("../../config/scenarios/crossing.toml")?;
/// assert_eq!(horizon.parsed().candidates.len(), 3);
/// # Ok::<(), trolley::Failure>(())
/// ```
#[derive(Clone, Debug)]
pub struct Horizon {
    file: String,
    parsed: HorizonScenario,
    policy: Arc<Policy>,
    curves: Arc<Curves>,
    unknown_is_fixed: bool,
    references: References,
}

impl Horizon {
    /// Reads a scenario file, and what it names: policy, curves and paths, all from its folder.
    ///
    /// ```
    /// assert!(trolley::Horizon::open("no-such-file.toml").is_err());
    /// ```
    ///
    /// # Errors
    ///
    /// If a file cannot be read, leads out of the folder, or is not valid: the error has file,
    /// place, fault and remedy.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, Failure> {
        let path = path.as_ref();
        Self::parse_with(&path.display().to_string(), &read_text(path)?, References::Inside)
    }

    /// Reads a scenario from a text. Paths in it are relative to the folder of `name`.
    ///
    /// ```
    /// use trolley::{Horizon, References};
    ///
    /// let text = r#"
    ///     schema = "trolley.scenario/2"
    ///     name = "A post ahead"
    ///     [parties]
    ///     ego = { generate = { shape = "sedan", triangles = 1500 } }
    ///     [parties.post]
    ///     generate = { shape = "pole", triangles = 600 }
    ///     place = { position_m = [30, 0, 0] }
    ///     [[candidates]]
    ///     name = "go on"
    ///     state = { position_m = [0, 0, 0], speed_m_s = 14 }
    /// "#;
    /// let horizon = Horizon::parse_with("post.toml", text, References::Inside)?;
    /// assert_eq!(horizon.parsed().horizon_s, 5.0);
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    ///
    /// # Errors
    ///
    /// As [`Horizon::open`].
    pub fn parse_with(name: &str, text: &str, references: References) -> Result<Self, Failure> {
        let draft = HorizonDraft::parse(name, text)?;
        let file = Path::new(name);
        let parsed = draft.finish(|reference: &FileRef| {
            let place = format!("{name}:{}: csv", reference.place);
            references.check(file, &place, reference.path.as_ref())?;
            let path = beside(file, reference.path.as_ref());
            files::text(&path, InputKind::MotionPath).map_err(|failure| failure.at(place))
        })?;
        let rule = |key: &str, reference: &Option<FileRef>, kind, shipped: (&str, &str)| {
            let Some(reference) = reference else {
                return Ok(SourceText { name: shipped.0.to_owned(), text: shipped.1.to_owned() });
            };
            let place = format!("{name}:{}: {key}", reference.place);
            references.check(file, &place, reference.path.as_ref())?;
            named(file, reference, kind)
        };
        let shipped = ("config/policies/default.toml", DEFAULT_POLICY);
        let policy = rule("policy", &parsed.policy, InputKind::Policy, shipped)?;
        let shipped = ("config/curves/default.toml", DEFAULT_CURVES);
        let curves = rule("curves", &parsed.curves, InputKind::Curves, shipped)?;
        let policy = Policy::parse(&policy.name, &policy.text)?;
        let curves = Curves::parse(&curves.name, &curves.text)?;
        let covered = curves.covers(policy.outcome);
        covered.map_err(|missing| Failure::input(missing.to_string()))?;
        let (policy, curves) = (Arc::new(policy), Arc::new(curves));
        let file = name.to_owned();
        let horizon = Self { file, parsed, policy, curves, unknown_is_fixed: false, references };
        horizon.check_references()?;
        Ok(horizon)
    }

    /// Takes parties of unknown kind as fixed to the ground, with nobody in them; the answer says
    /// so.
    ///
    /// ```
    /// let horizon = trolley::Horizon::open("../../config/scenarios/crossing.toml")?;
    /// let horizon = horizon.assuming_unknown_is_fixed(); // here all are known
    /// # assert_eq!(horizon.parsed().candidates.len(), 3);
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    #[must_use]
    pub fn assuming_unknown_is_fixed(self) -> Self {
        Self { unknown_is_fixed: true, ..self }
    }

    /// Returns what the text says.
    ///
    /// ```
    /// let horizon = trolley::Horizon::open("../../config/scenarios/crossing.toml")?;
    /// assert_eq!(horizon.parsed().horizon_s, 4.0);
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    #[must_use]
    pub fn parsed(&self) -> &HorizonScenario {
        &self.parsed
    }

    /// Returns the name of the file, for messages.
    ///
    /// ```
    /// let horizon = trolley::Horizon::open("../../config/scenarios/crossing.toml")?;
    /// assert!(horizon.file().ends_with("crossing.toml"));
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    #[must_use]
    pub fn file(&self) -> &str {
        &self.file
    }

    /// Returns the policy and the curves.
    ///
    /// ```
    /// let horizon = trolley::Horizon::open("../../config/scenarios/crossing.toml")?;
    /// assert_eq!(horizon.rules().0.name, "default");
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    #[must_use]
    pub fn rules(&self) -> (Arc<Policy>, Arc<Curves>) {
        (self.policy.clone(), self.curves.clone())
    }

    /// The bodies of the parties, in their order.
    pub(crate) fn bodies(&self) -> Vec<PartyBody<'_>> {
        self.parsed.parties.iter().map(PartyBody::of_horizon).collect()
    }

    pub(crate) fn path_of(&self, reference: &FileRef) -> PathBuf {
        beside(Path::new(&self.file), reference.path.as_ref())
    }

    /// Refuses model files that this scenario may not name.
    pub(crate) fn check_references(&self) -> Result<(), Failure> {
        for party in &self.parsed.parties {
            let Source::File(FileRef { path, place }) = &party.source else { continue };
            let place = format!("{}:{place}: party \"{}\": file", self.file, party.name);
            self.references.check(Path::new(&self.file), &place, path.as_ref())?;
        }
        Ok(())
    }

    /// Refuses parties of unknown kind, unless they may be taken as fixed.
    pub(crate) fn check_unknown(&self) -> Result<(), Failure> {
        let Some(party) = self.parsed.parties.iter().find(|party| party.is_unknown) else {
            return Ok(());
        };
        if self.unknown_is_fixed {
            return Ok(self.parsed.check_fixed(&self.file)?);
        }
        let fault = format!("\"{}\" is of unknown kind", party.name);
        Err(Failure::new(FailureKind::Refused, fault)
            .at(format!("{}:{}", self.file, party.place))
            .with_remedy(
                "say what it is, or let it be taken as fixed to the ground with nobody in it: \
                 --assume unknown=fixed",
            ))
    }
}
