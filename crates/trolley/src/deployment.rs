//! A deployment file, and the files it names.

use crate::files::{self, InputKind};
use crate::model::open;
use crate::references::{References, beside};
use crate::scenario::check_models;
use crate::texts::{self, Part};
use crate::{Failure, Scenario};
use damage::Criteria;
use protocol::public::Ask;
use scenario::{Implausible, LoadedBody, Source};
use service::{Deployment, Model};
use std::path::{Path, PathBuf};

/// A deployment file that was read; its paths are relative to it.
///
/// ```
/// use trolley::OpenDeployment;
///
/// let opened = OpenDeployment::open("../../config/deployments/minimal.toml".as_ref(), None)?;
/// assert_eq!(opened.deployment.models.len(), 3);
/// # Ok::<(), trolley::Failure>(())
/// ```
#[derive(Clone, Debug)]
pub struct OpenDeployment {
    /// What the file says.
    pub deployment: Deployment,
    file: PathBuf,
    hash: [u8; 32],
    references: References,
}

impl OpenDeployment {
    /// Reads a deployment file; `instance` replaces the name of the instance in it. Policy, curves
    /// and models that it names must be in its folder: see [`References`].
    ///
    /// ```
    /// use trolley::OpenDeployment;
    ///
    /// let file = "../../config/deployments/minimal.toml";
    /// let opened = OpenDeployment::open(file.as_ref(), Some("second"))?;
    /// assert_eq!(opened.deployment.instance, "second");
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    ///
    /// # Errors
    ///
    /// If the file cannot be read or is not valid, or `instance` is not a valid name.
    pub fn open(path: &Path, instance: Option<&str>) -> Result<Self, Failure> {
        Self::open_with(path, instance, References::Inside)
    }

    /// As [`OpenDeployment::open`], which lets the deployment, and the scenarios of
    /// [`OpenDeployment::ask`], name files of their own folders alone.
    ///
    /// ```
    /// use trolley::{OpenDeployment, References};
    ///
    /// let file = "../../config/deployments/minimal.toml";
    /// let opened = OpenDeployment::open_with(file.as_ref(), None, References::Anywhere)?;
    /// # assert_eq!(opened.deployment.models.len(), 3);
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    ///
    /// # Errors
    ///
    /// As [`OpenDeployment::open`].
    pub fn open_with(
        path: &Path,
        instance: Option<&str>,
        references: References,
    ) -> Result<Self, Failure> {
        let name = path.display().to_string();
        let text = files::text(path, InputKind::Deployment)?;
        let mut deployment = Deployment::parse(&name, &text)?;
        if let Some(instance) = instance {
            transport::Address::new(deployment.folder.as_deref(), instance)?;
            instance.clone_into(&mut deployment.instance);
        }
        let hash = *blake3::hash(text.as_bytes()).as_bytes();
        Ok(Self { deployment, file: path.to_owned(), hash, references })
    }

    /// BLAKE3 of the file.
    pub(crate) fn hash(&self) -> [u8; 32] {
        self.hash
    }

    /// The number of the group of clients, if this user may share files with it.
    pub(crate) fn group_id(&self) -> Result<Option<u32>, Failure> {
        Ok(self.deployment.group_id(&self.file.display().to_string())?)
    }

    /// Returns the path of a file that the deployment names.
    ///
    /// ```
    /// # let file = "../../config/deployments/minimal.toml";
    /// # let opened = trolley::OpenDeployment::open(file.as_ref(), None)?;
    /// let path = opened.path("car.trolley".as_ref());
    /// assert!(path.ends_with("config/deployments/car.trolley"));
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    #[must_use]
    pub fn path(&self, written: &Path) -> PathBuf {
        beside(&self.file, written)
    }

    /// The path of a file that the deployment names with this key, if it may.
    pub(crate) fn checked(&self, key: &str, written: &Path) -> Result<PathBuf, Failure> {
        let place = format!("{}: {key}", self.file.display());
        self.references.check(&self.file, &place, written)?;
        Ok(self.path(written))
    }

    /// Reads policy, curves and parameters: those of the deployment, else the built-in ones.
    ///
    /// ```
    /// # let file = "../../config/deployments/minimal.toml";
    /// # let opened = trolley::OpenDeployment::open(file.as_ref(), None)?;
    /// assert_eq!(opened.criteria()?.policy.name, "default");
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    ///
    /// # Errors
    ///
    /// If a file cannot be read, leads out of the folder or is not valid, or the curves lack the
    /// policy's outcome.
    pub fn criteria(&self) -> Result<Criteria, Failure> {
        let named = |part: &Part, path: &Path| {
            let place = || format!("{}: {}", self.file.display(), part.key);
            part.of_name(path).map_err(|failure| failure.at(place()))
        };
        let read = |part: &Part, path: &Option<PathBuf>| match path {
            None => Ok(part.shipped()),
            Some(path) if let Some(named) = named(part, path)? => Ok(named),
            Some(path) => part.read(&self.checked(part.key, path)?),
        };
        let Deployment { policy, curves, parameters, .. } = &self.deployment;
        let policy = read(&texts::POLICY, policy)?;
        let curves = read(&texts::CURVES, curves)?;
        let parameters = read(&texts::PARAMETERS, parameters)?;
        texts::criteria([&policy, &curves, &parameters])
    }

    /// Makes the request that asks the service to rank a scenario, with the ids of the deployment's
    /// models. Its engine, policy, curves and deadline are ignored. With `unknown_is_fixed`,
    /// parties of unknown kind are taken as fixed to the ground, with nobody in them.
    ///
    /// ```
    /// # let file = "../../config/deployments/minimal.toml";
    /// # let opened = trolley::OpenDeployment::open(file.as_ref(), None)?;
    /// let scenario = trolley::Scenario::open("../../config/scenarios/wall-or-pole.toml")?;
    /// let ask = opened.ask(&scenario, false)?;
    /// assert_eq!(ask.candidate_count, 3);
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    ///
    /// # Errors
    ///
    /// If the deployment lacks the model of a party, a model file leads out of its folder, or the
    /// scenario is too large for a request.
    pub fn ask(&self, scenario: &Scenario, unknown_is_fixed: bool) -> Result<Box<Ask>, Failure> {
        let (file, parsed) = (Path::new(scenario.file()), scenario.parsed());
        check_models(&scenario.bodies(), file, self.references)?;
        let models = self.models_of(scenario)?;
        let models: Vec<u32> = models.iter().map(|model| model.id).collect();
        service::of_scenario(parsed, &models, unknown_is_fixed).map_err(Failure::input)
    }

    /// Returns what a scenario states that is allowed and hardly true, of the bodies that it has in
    /// this deployment: what [`Answer::implausible`](crate::Answer::implausible) has, but for what
    /// depends on the answer. A service does not say it.
    ///
    /// ```
    /// # let file = "../../config/deployments/minimal.toml";
    /// # let opened = trolley::OpenDeployment::open(file.as_ref(), None)?;
    /// let scenario = trolley::Scenario::open("../../config/scenarios/wall-or-pole.toml")?;
    /// assert!(opened.implausible(&scenario)?.is_empty());
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    ///
    /// # Errors
    ///
    /// If the deployment lacks the model of a party, or the file of one cannot be read.
    pub fn implausible(&self, scenario: &Scenario) -> Result<Vec<Implausible>, Failure> {
        let models = self.models_of(scenario)?;
        let bodies = models.iter().map(|model| self.loaded(model));
        let bodies = bodies.collect::<Result<Vec<LoadedBody>, Failure>>()?;
        Ok(scenario::implausible(scenario.parsed(), &bodies))
    }

    /// A model as it can be doubted.
    fn loaded(&self, model: &Model) -> Result<LoadedBody, Failure> {
        match &model.source {
            service::ModelSource::File(path) => {
                let path = self.checked(&format!("model \"{}\"", model.name), path)?;
                let copy = open::copy(&path)?;
                let (meta, view) = open::view(&path, copy.bytes())?;
                let (kind, mass_kg) = (meta.kind, meta.mass_kg);
                Ok(LoadedBody { kind, mass_kg, bounds: view.bounds() })
            }
            service::ModelSource::Generate { shape, triangles, seed } => {
                // Its own mass is that of its kind, and takes its outlines, which may take a
                // second: a client has no time for them.
                let bounds = shapes::generate(*shape, *triangles, *seed)?.bounds();
                Ok(LoadedBody { kind: shape.kind(), mass_kg: None, bounds })
            }
        }
    }

    /// The model of each party of a scenario.
    fn models_of(&self, scenario: &Scenario) -> Result<Vec<&Model>, Failure> {
        let file = Path::new(scenario.file());
        let mut models = Vec::new();
        for party in &scenario.parsed().parties {
            let is_same = |model: &&Model| self.is_body_of(file, &party.source, model);
            let Some(model) = self.deployment.models.iter().find(is_same) else {
                let (place, name) = (party.place, &party.name);
                let what = format!("the deployment lacks the model of party \"{name}\"");
                let help = format!("add it to [[models]] of {}", self.file.display());
                let place = format!("{}:{place}", file.display());
                return Err(Failure::input(what).at(place).with_remedy(help));
            };
            models.push(model);
        }
        Ok(models)
    }

    /// Whether a model is the body of a scenario's party: the same file, or generated alike.
    fn is_body_of(&self, scenario: &Path, source: &Source, model: &Model) -> bool {
        match (source, &model.source) {
            (Source::File(reference), service::ModelSource::File(path)) => {
                let theirs = beside(scenario, Path::new(&reference.path)).canonicalize().ok();
                theirs.is_some() && theirs == self.path(path).canonicalize().ok()
            }
            (
                Source::Generate { shape, triangles, seed },
                service::ModelSource::Generate { shape: s, triangles: t, seed: n },
            ) => (shape, triangles, seed) == (s, t, n),
            _ => false,
        }
    }
}
