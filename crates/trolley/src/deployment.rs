//! A deployment file, and what it names beside itself.

use crate::Failure;
use crate::scenario::read_text;
use damage::injury::DEFAULT_CURVES;
use damage::policy::DEFAULT_POLICY;
use damage::{Curves, Policy};
use service::Deployment;
use std::path::{Path, PathBuf};

/// A deployment, and the folder that its paths are relative to.
#[derive(Clone, Debug)]
pub struct OpenDeployment {
    /// What the file says.
    pub deployment: Deployment,
    folder: PathBuf,
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
        Ok(Self { deployment, folder: path.parent().unwrap_or(Path::new("")).to_owned() })
    }

    /// A path that the file names.
    #[must_use]
    pub fn path(&self, written: &Path) -> PathBuf {
        self.folder.join(written)
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
}
