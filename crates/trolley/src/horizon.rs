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

use crate::Failure;
use crate::bodies::PartyBody;
use crate::files::{self, InputKind};
use crate::references::{References, beside};
use crate::scenario::{SourceText, Texts, check_models, read_text, rule_texts, rules, unknown};
use damage::{Curves, Policy};
use scenario::{FileRef, HorizonDraft, HorizonScenario};
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
    pub(crate) texts: Texts,
    /// The CSV files that paths name, each once, as the scenario names them.
    pub(crate) files: Vec<SourceText>,
    parsed: HorizonScenario,
    policy: Arc<Policy>,
    curves: Arc<Curves>,
    pub(crate) unknown_is_fixed: bool,
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
        let mut files: Vec<SourceText> = Vec::new();
        for reference in draft.files() {
            if files.iter().any(|known| known.name == reference.path) {
                continue;
            }
            let place = format!("{name}:{}: csv", reference.place);
            references.check(file, &place, reference.path.as_ref())?;
            let path = beside(file, reference.path.as_ref());
            let text =
                files::text(&path, InputKind::MotionPath).map_err(|failure| failure.at(place))?;
            files.push(SourceText { name: reference.path.clone(), text });
        }
        let parsed = finish(name, draft, &files)?;
        let named = [&parsed.policy, &parsed.curves];
        let [policy, curves] = rule_texts(name, named, references)?;
        let scenario = SourceText { name: name.to_owned(), text: text.to_owned() };
        let texts = Texts { scenario, policy, curves };
        let horizon = Self { references, ..Self::of_parts(parsed, texts, files)? };
        horizon.check_references()?;
        Ok(horizon)
    }

    /// Checks texts that were read elsewhere; opens no file.
    ///
    /// # Errors
    ///
    /// If one is not valid, or is missing: the error has file, place, fault and remedy.
    pub(crate) fn of_texts(texts: Texts, files: Vec<SourceText>) -> Result<Self, Failure> {
        let name = &texts.scenario.name;
        let parsed = finish(name, HorizonDraft::parse(name, &texts.scenario.text)?, &files)?;
        Self::of_parts(parsed, texts, files)
    }

    fn of_parts(
        parsed: HorizonScenario,
        texts: Texts,
        files: Vec<SourceText>,
    ) -> Result<Self, Failure> {
        let (policy, curves) = rules(&texts.policy, &texts.curves)?;
        let references = References::Inside;
        Ok(Self { texts, files, parsed, policy, curves, unknown_is_fixed: false, references })
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
        &self.texts.scenario.name
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
        beside(Path::new(self.file()), reference.path.as_ref())
    }

    /// Refuses model files that this scenario may not name.
    pub(crate) fn check_references(&self) -> Result<(), Failure> {
        check_models(&self.bodies(), Path::new(self.file()), self.references)
    }

    /// Refuses parties of unknown kind, unless they may be taken as fixed.
    pub(crate) fn check_unknown(&self) -> Result<(), Failure> {
        let Some(party) = self.parsed.parties.iter().find(|party| party.is_unknown) else {
            return Ok(());
        };
        if self.unknown_is_fixed {
            return Ok(self.parsed.check_fixed(self.file())?);
        }
        Err(unknown(&party.name, format!("{}:{}", self.file(), party.place)))
    }
}

/// A scenario whose CSV files are read.
fn finish(
    name: &str,
    draft: HorizonDraft,
    files: &[SourceText],
) -> Result<HorizonScenario, Failure> {
    draft.finish(|reference: &FileRef| {
        let found = files.iter().find(|known| known.name == reference.path);
        found.map(|known| known.text.clone()).ok_or_else(|| {
            let place = format!("{name}:{}: csv", reference.place);
            Failure::input(format!("the text of \"{}\" is missing", reference.path))
                .at(place)
                .with_remedy("it was changed and hashed again: use another copy")
        })
    })
}
