//! A deployment file, and what it names beside itself.

use crate::Failure;
use crate::scenario::read_text;
use damage::injury::DEFAULT_CURVES;
use damage::policy::DEFAULT_POLICY;
use damage::{Curves, Policy};
use protocol::public::Ask;
use scenario::{Party, Scenario, Source};
use service::{Deployment, Model};
use std::path::{Path, PathBuf};

/// A deployment, and the file that its paths are relative to.
#[derive(Clone, Debug)]
pub struct OpenDeployment {
    /// What the file says.
    pub deployment: Deployment,
    file: PathBuf,
}

impl OpenDeployment {
    /// Reads a deployment file; `instance` replaces the one that it names.
    ///
    /// # Errors
    ///
    /// If the file cannot be read or is not sound, or no instance can have this name.
    pub fn open(path: &Path, instance: Option<&str>) -> Result<Self, Failure> {
        let name = path.display().to_string();
        let mut deployment = Deployment::parse(&name, &read_text(path)?)?;
        if let Some(instance) = instance {
            transport::Address::new(&deployment.folder, instance)?;
            instance.clone_into(&mut deployment.instance);
        }
        Ok(Self { deployment, file: path.to_owned() })
    }

    /// A path that the file names.
    #[must_use]
    pub fn path(&self, written: &Path) -> PathBuf {
        beside(&self.file, written)
    }

    /// The policy and the curves.
    ///
    /// # Errors
    ///
    /// If a file cannot be read or is not sound, or the curves lack the policy's outcome.
    pub fn rules(&self) -> Result<(Policy, Curves), Failure> {
        let or_shipped = |path: &Option<PathBuf>, name: &str, shipped: &str| match path {
            None => Ok((name.to_owned(), shipped.to_owned())),
            Some(path) => {
                let path = self.path(path);
                Ok::<_, Failure>((path.display().to_string(), read_text(&path)?))
            }
        };
        let Deployment { policy, curves, .. } = &self.deployment;
        let (name, policy) = or_shipped(policy, "config/policies/default.toml", DEFAULT_POLICY)?;
        let policy = Policy::parse(&name, &policy)?;
        let (name, curves) = or_shipped(curves, "config/curves/default.toml", DEFAULT_CURVES)?;
        let curves = Curves::parse(&name, &curves)?;
        curves.covers(policy.outcome).map_err(|missing| Failure::input(missing.to_string()))?;
        Ok((policy, curves))
    }

    /// The request that asks what a scenario asks, with the ids of the deployment's models. `file`
    /// is the scenario's, which its paths are relative to; its engine, policy and curves do not
    /// count. With `unknown_is_fixed`, parties of unknown kind are taken as fixed to the ground,
    /// with nobody in them.
    ///
    /// # Errors
    ///
    /// If the deployment has no model as that of a party, or the scenario is larger than a request.
    pub fn ask(
        &self,
        file: &Path,
        scenario: &Scenario,
        unknown_is_fixed: bool,
    ) -> Result<Ask, Failure> {
        let mut models = Vec::new();
        for party in &scenario.parties {
            let is_same = |model: &&Model| self.is_body_of(file, party, model);
            let Some(model) = self.deployment.models.iter().find(is_same) else {
                let (place, name) = (party.place, &party.name);
                let what = format!("the deployment has no model as that of party \"{name}\"");
                let help = format!("add it to [[models]] of {}", self.file.display());
                let place = format!("{}:{place}", file.display());
                return Err(Failure::input(what).at(place).with_remedy(help));
            };
            models.push(model.id);
        }
        service::of_scenario(scenario, &models, unknown_is_fixed).map_err(Failure::input)
    }

    /// Whether a model is the body of a scenario's party: the same file, or made the same way.
    fn is_body_of(&self, scenario: &Path, party: &Party, model: &Model) -> bool {
        match (&party.source, &model.source) {
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

/// A path that a file names, relative to the folder of that file.
fn beside(file: &Path, path: &Path) -> PathBuf {
    file.parent().unwrap_or(Path::new("")).join(path)
}
