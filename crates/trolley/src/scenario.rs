//! A scenario with the policy and the curves that judge it: as named texts and as checked values.
//!
//! Texts come from files, from a caller or from a decision record; all are checked alike.
//!
//! ```
//! use trolley::{Engine, Limits, Scenario};
//!
//! let scenario = Scenario::open("../../config/scenarios/crossing.toml")?;
//! let mut engine = Engine::builder().in_process().build()?;
//! let ranking = engine.rank(&scenario, &Limits::default())?;
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
use crate::model::open;
use crate::references::{References, beside};
use crate::texts::{self, Part, SourceText, Texts, read_text};
use crate::{Failure, FailureKind};
use damage::{Criteria, Curves, Policy};
use mesh::import::Format;
use scenario::{FileRef, ScenarioDraft, Source};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The scenario that `trolley demo` ranks; its bodies are generated.
const DEMO: &str = include_str!("../config/scenarios/demo.toml");
/// Its name.
const DEMO_NAME: &str = "config/scenarios/demo.toml";

/// What to rank, and the policy and curves to rank it by: read and checked.
///
/// ```
/// use trolley::Scenario;
///
/// let scenario = Scenario::open("../../config/scenarios/small.toml")?;
/// assert_eq!(scenario.parsed().candidates.len(), 4);
/// # Ok::<(), trolley::Failure>(())
/// ```
#[derive(Clone, Debug)]
pub struct Scenario {
    pub(crate) texts: Texts,
    /// The CSV files that paths name, each once, as the scenario names them.
    pub(crate) files: Vec<SourceText>,
    parsed: scenario::Scenario,
    criteria: Criteria,
    pub(crate) unknown_is_fixed: bool,
    references: References,
}

impl Scenario {
    /// Returns the built-in scenario: seven ways among seven others, whose bodies are generated.
    ///
    /// ```
    /// let scenario = trolley::Scenario::demo()?;
    /// assert_eq!(scenario.parsed().candidates.len(), 7);
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Never: tests make sure of that.
    pub fn demo() -> Result<Self, Failure> {
        Self::parse(DEMO_NAME, DEMO)
    }

    /// Reads a scenario file, and the policy, curves and paths that it names. All files that it
    /// names must be in its folder: see [`References`].
    ///
    /// ```
    /// use trolley::Scenario;
    ///
    /// let scenario = Scenario::open("../../config/scenarios/small.toml")?;
    /// assert!(Scenario::open("no-such-file.toml").is_err());
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    ///
    /// # Errors
    ///
    /// If a file cannot be read, leads out of the folder, or is not valid: the error has file,
    /// place, fault and remedy.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, Failure> {
        Self::open_with(path, References::Inside)
    }

    /// As [`Scenario::open`], which lets the scenario name files of its own folder alone.
    ///
    /// ```
    /// use trolley::{References, Scenario};
    ///
    /// let file = "../../config/scenarios/small.toml";
    /// let scenario = Scenario::open_with(file, References::Anywhere)?;
    /// # assert_eq!(scenario.parsed().candidates.len(), 4);
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    ///
    /// # Errors
    ///
    /// As [`Scenario::open`].
    pub fn open_with(path: impl AsRef<Path>, references: References) -> Result<Self, Failure> {
        let path = path.as_ref();
        let text = read_text(path).map_err(|failure| is_body(path).unwrap_or(failure))?;
        Self::parse_with(&path.display().to_string(), &text, references)
    }

    /// Reads a scenario from a text. Paths in it are relative to the folder of `name`, and must not
    /// lead out of it. If it names no policy or curves, the built-in ones are used.
    ///
    /// ```
    /// use trolley::Scenario;
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
    /// let scenario = Scenario::parse("post.toml", text)?;
    /// assert_eq!((scenario.file(), scenario.parsed().horizon_s), ("post.toml", 5.0));
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    ///
    /// # Errors
    ///
    /// As [`Scenario::open`].
    pub fn parse(name: &str, text: &str) -> Result<Self, Failure> {
        Self::parse_with(name, text, References::Inside)
    }

    /// As [`Scenario::parse`], which lets the scenario name files of its own folder alone.
    ///
    /// ```
    /// use trolley::{References, Scenario};
    ///
    /// let small = trolley::read_text("../../config/scenarios/small.toml".as_ref())?;
    /// let text = format!("policy = \"../policies/weighted.toml\"\n{small}");
    /// let name = "../../config/scenarios/weighted.toml";
    /// let scenario = Scenario::parse_with(name, &text, References::Anywhere)?;
    /// assert_eq!(scenario.criteria().policy.name, "weighted");
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    ///
    /// # Errors
    ///
    /// As [`Scenario::open`].
    pub fn parse_with(name: &str, text: &str, references: References) -> Result<Self, Failure> {
        let draft = ScenarioDraft::parse(name, text)?;
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
        let read = |part: &Part, reference: &Option<FileRef>| {
            let Some(FileRef { path, place }) = reference else { return Ok(part.shipped()) };
            let named = part.of_name(path.as_ref());
            if let Some(named) = named.map_err(|failure| failure.at(format!("{name}:{place}")))? {
                return Ok(named);
            }
            references.check(file, &format!("{name}:{place}: {}", part.key), path.as_ref())?;
            let read = part.read(&beside(file, path.as_ref()));
            read.map_err(|failure| failure.at(format!("{name}:{place}")))
        };
        let policy = read(&texts::POLICY, &parsed.policy)?;
        let curves = read(&texts::CURVES, &parsed.curves)?;
        let parameters = read(&texts::PARAMETERS, &parsed.parameters)?;
        let scenario = SourceText { name: name.to_owned(), text: text.to_owned() };
        let texts = Texts { scenario, policy, curves, parameters };
        let scenario = Self::of_parts(parsed, texts, files)?.with_references(references);
        scenario.check_references()?;
        Ok(scenario)
    }

    /// Reads a scenario, and what it is judged by, from their texts, and the CSV files that paths
    /// name, as the scenario names them; opens no file.
    ///
    /// ```
    /// # let read = |path: &str| {
    /// #     let text = trolley::read_text(path.as_ref())?;
    /// #     Ok::<_, trolley::Failure>(trolley::SourceText { name: path.into(), text })
    /// # };
    /// use trolley::{Scenario, Texts};
    ///
    /// let scenario = Scenario::of_texts(Texts {
    ///     scenario: read("../../config/scenarios/small.toml")?,
    ///     policy: read("../../config/policies/weighted.toml")?,
    ///     curves: read("../../config/curves/default.toml")?,
    ///     parameters: read("../../config/parameters/default.toml")?,
    /// }, Vec::new())?;
    /// # assert_eq!(scenario.parsed().candidates.len(), 4);
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    ///
    /// # Errors
    ///
    /// As [`Scenario::open`].
    pub fn of_texts(texts: Texts, files: Vec<SourceText>) -> Result<Self, Failure> {
        let name = &texts.scenario.name;
        let draft = ScenarioDraft::parse(name, &texts.scenario.text)?;
        let parsed = finish(name, draft, &files)?;
        Self::of_parts(parsed, texts, files)
    }

    fn of_parts(
        parsed: scenario::Scenario,
        texts: Texts,
        files: Vec<SourceText>,
    ) -> Result<Self, Failure> {
        let criteria = texts.criteria()?;
        let references = References::Inside;
        Ok(Self { texts, files, parsed, criteria, unknown_is_fixed: false, references })
    }

    /// Sets which model files the scenario may name; otherwise those of its folder alone.
    ///
    /// ```
    /// # let scenario = trolley::Scenario::open("../../config/scenarios/small.toml")?;
    /// let scenario = scenario.with_references(trolley::References::Anywhere);
    /// # assert_eq!(scenario.parsed().candidates.len(), 4);
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    #[must_use]
    pub fn with_references(self, references: References) -> Self {
        Self { references, ..self }
    }

    /// Takes parties of unknown kind as fixed to the ground, with nobody in them; the answer says
    /// so.
    ///
    /// ```
    /// # let small = trolley::read_text("../../config/scenarios/small.toml".as_ref())?;
    /// # let unknown = "triangles = 600 }\nkind = \"unknown\"";
    /// # let text = small.replace("triangles = 600 }", unknown);
    /// # let scenario = trolley::Scenario::parse("small.toml", &text)?;
    /// # let mut engine = trolley::Engine::builder().in_process().build()?;
    /// let limits = trolley::Limits::default();
    /// assert!(engine.rank(&scenario, &limits).is_err(), "the wall is of unknown kind");
    ///
    /// let answer = engine.rank(&scenario.assuming_unknown_is_fixed(), &limits)?.answer;
    /// assert!(!answer.assumptions.is_empty());
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    #[must_use]
    pub fn assuming_unknown_is_fixed(self) -> Self {
        Self { unknown_is_fixed: true, ..self }
    }

    /// Returns what the text says.
    ///
    /// ```
    /// # let scenario = trolley::Scenario::open("../../config/scenarios/small.toml")?;
    /// for candidate in &scenario.parsed().candidates {
    ///     println!("{}", candidate.name);
    /// }
    /// # assert_eq!(scenario.parsed().parties.len(), 5);
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    #[must_use]
    pub fn parsed(&self) -> &scenario::Scenario {
        &self.parsed
    }

    /// Returns the name of the file, for messages.
    ///
    /// ```
    /// # let scenario = trolley::Scenario::open("../../config/scenarios/small.toml")?;
    /// assert_eq!(scenario.file(), "../../config/scenarios/small.toml");
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    #[must_use]
    pub fn file(&self) -> &str {
        &self.texts.scenario.name
    }

    /// Returns the policy, the curves and the parameters.
    ///
    /// ```
    /// # let scenario = trolley::Scenario::open("../../config/scenarios/small.toml")?;
    /// let criteria = scenario.criteria();
    /// assert_eq!(criteria.policy.name, "default");
    /// assert!(criteria.curves.covers(criteria.policy.outcome).is_ok());
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    #[must_use]
    pub fn criteria(&self) -> &Criteria {
        &self.criteria
    }

    /// Replaces the policy, whichever the scenario names.
    ///
    /// ```
    /// use trolley::{Scenario, SourceText};
    ///
    /// let scenario = Scenario::open("../../config/scenarios/small.toml")?;
    /// let name = "../../config/policies/weighted.toml".to_owned();
    /// let text = trolley::read_text(name.as_ref())?;
    /// let scenario = scenario.with_policy(SourceText { name, text })?;
    /// assert_eq!(scenario.criteria().policy.name, "weighted");
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    ///
    /// # Errors
    ///
    /// If it is not valid, or the curves do not cover its outcome.
    pub fn with_policy(self, policy: SourceText) -> Result<Self, Failure> {
        let texts = Texts { policy, ..self.texts };
        let criteria = texts.criteria()?;
        Ok(Self { texts, criteria, ..self })
    }

    /// Replaces the curves, whichever the scenario names.
    ///
    /// ```
    /// use trolley::{Scenario, SourceText};
    ///
    /// let scenario = Scenario::open("../../config/scenarios/small.toml")?;
    /// let name = "../../config/curves/default.toml".to_owned();
    /// let text = trolley::read_text(name.as_ref())?.replace("\"default\"", "\"own\"");
    /// let scenario = scenario.with_curves(SourceText { name, text })?;
    /// assert_eq!(scenario.criteria().curves.name, "own");
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    ///
    /// # Errors
    ///
    /// If they are not valid, or do not cover the outcome of the policy.
    pub fn with_curves(self, curves: SourceText) -> Result<Self, Failure> {
        let texts = Texts { curves, ..self.texts };
        let criteria = texts.criteria()?;
        Ok(Self { texts, criteria, ..self })
    }

    /// Returns the path of a file that the scenario names.
    ///
    /// ```
    /// # let small = trolley::read_text("../../config/scenarios/small.toml".as_ref())?;
    /// # let text = format!("policy = \"../policies/weighted.toml\"\n{small}");
    /// # let name = "../../config/scenarios/weighted.toml";
    /// # let anywhere = trolley::References::Anywhere;
    /// # let scenario = trolley::Scenario::parse_with(name, &text, anywhere)?;
    /// // The scenario says: policy = "../policies/weighted.toml"
    /// let policy = scenario.parsed().policy.as_ref().map(|reference| scenario.path_of(reference));
    /// assert!(policy.is_some_and(|path| path.exists()));
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    #[must_use]
    pub fn path_of(&self, reference: &FileRef) -> PathBuf {
        beside(Path::new(self.file()), reference.path.as_ref())
    }

    /// Returns the files that the scenario names, but for what judges it: paths and bodies, as they
    /// are named.
    ///
    /// ```
    /// let scenario = trolley::Scenario::open("../../config/scenarios/small.toml")?;
    /// assert!(scenario.named_files().is_empty(), "its bodies are generated");
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    #[must_use]
    pub fn named_files(&self) -> Vec<(String, InputKind)> {
        let paths = self.files.iter().map(|file| (file.name.clone(), InputKind::MotionPath));
        let models = self.parsed.parties.iter().filter_map(|party| match &party.source {
            Source::File(reference) => Some((reference.path.clone(), InputKind::Model)),
            Source::Generate { .. } => None,
        });
        paths.chain(models).collect()
    }

    /// This scenario with these values in place of its own, whatever its texts say: to be ranked,
    /// not to be recorded.
    pub(crate) fn varied(
        &self,
        parsed: scenario::Scenario,
        policy: Policy,
        curves: Curves,
    ) -> Self {
        let (policy, curves) = (Arc::new(policy), Arc::new(curves));
        let criteria = Criteria { policy, curves, ..self.criteria.clone() };
        Self { parsed, criteria, ..self.clone() }
    }

    /// This scenario without a deadline: its outcome does not depend on the machine then.
    pub(crate) fn without_deadline(mut self) -> Self {
        self.parsed.deadline = None;
        self
    }

    /// The bodies of the parties, in their order.
    pub(crate) fn bodies(&self) -> Vec<PartyBody<'_>> {
        self.parsed.parties.iter().map(PartyBody::of).collect()
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

/// The refusal of a party of unknown kind at a place.
fn unknown(party: &str, place: String) -> Failure {
    let fault = format!("\"{party}\" is of unknown kind");
    Failure::new(FailureKind::Refused, fault).at(place).with_remedy(
        "say what it is, or let it be taken as fixed to the ground with nobody in it: --assume \
         unknown=fixed",
    )
}

/// Refuses model files of a scenario that it may not name.
pub(crate) fn check_models(
    parties: &[PartyBody<'_>],
    file: &Path,
    references: References,
) -> Result<(), Failure> {
    for party in parties {
        let Source::File(FileRef { path, place }) = party.source else { continue };
        let place = format!("{}:{place}: party \"{}\": file", file.display(), party.name);
        references.check(file, &place, path.as_ref())?;
    }
    Ok(())
}

/// A scenario whose CSV files are read.
fn finish(
    name: &str,
    draft: ScenarioDraft,
    files: &[SourceText],
) -> Result<scenario::Scenario, Failure> {
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
/// The refusal of a body where a scenario is expected, which names one.
fn is_body(path: &Path) -> Option<Failure> {
    let is_mesh = |format: Format| {
        let end = path.extension().map(|end| end.to_ascii_lowercase());
        path.is_file() && end.is_some_and(|end| end == format.extension())
    };
    let what = match Format::ALL.into_iter().find(|format| is_mesh(*format)) {
        _ if open::is_model(path) => "a model file",
        Some(_) => "a mesh",
        None => return None,
    };
    let failure = Failure::input(format!("it is {what}, and no scenario")).at(path.display());
    Some(failure.with_remedy("a scenario says who moves where: trolley help tutorial"))
}
