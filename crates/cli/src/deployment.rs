//! Deployment files, and the bodies that they name.

use crate::bodies::{self, Loaded};
use crate::failure::Failure;
use crate::inputs::text;
use bvh::BuildOptions;
use damage::injury::DEFAULT_CURVES;
use damage::policy::DEFAULT_POLICY;
use damage::{Curves, Policy};
use service::{Deployment, Source};
use std::path::{Path, PathBuf};

/// A deployment, and the folder that its paths are relative to.
pub(crate) struct Opened {
    pub(crate) deployment: Deployment,
    folder: PathBuf,
}

/// Reads a deployment file; `instance` replaces the one that it names.
pub(crate) fn open(path: &Path, instance: Option<&str>) -> Result<Opened, Failure> {
    let name = path.display().to_string();
    let mut deployment = Deployment::parse(&name, &text(path)?)?;
    if let Some(instance) = instance {
        transport::Address::new(&deployment.folder, instance)
            .map_err(|error| crate::failure::unopened(&error))?;
        deployment.instance = instance.to_owned();
    }
    Ok(Opened { deployment, folder: path.parent().unwrap_or(Path::new("")).to_owned() })
}

impl Opened {
    /// A path that the file names.
    pub(crate) fn path(&self, written: &Path) -> PathBuf {
        self.folder.join(written)
    }

    /// The policy and the curves.
    pub(crate) fn rules(&self) -> Result<(Policy, Curves), Failure> {
        let broken = |fault: damage::Fault| Failure::input(fault.to_string());
        let or_shipped = |path: &Option<PathBuf>, name: &str, shipped: &str| match path {
            None => Ok((name.to_owned(), shipped.to_owned())),
            Some(path) => {
                let path = self.path(path);
                Ok::<_, Failure>((path.display().to_string(), text(&path)?))
            }
        };
        let Deployment { policy, curves, .. } = &self.deployment;
        let (name, policy) = or_shipped(policy, "config/policies/default.toml", DEFAULT_POLICY)?;
        let policy = Policy::parse(&name, &policy).map_err(broken)?;
        let (name, curves) = or_shipped(curves, "config/curves/default.toml", DEFAULT_CURVES)?;
        let curves = Curves::parse(&name, &curves).map_err(broken)?;
        curves.covers(policy.outcome).map_err(|missing| Failure::input(missing.to_string()))?;
        Ok((policy, curves))
    }

    /// Opens or generates every model.
    pub(crate) fn bodies(&self) -> Result<Vec<Loaded>, Failure> {
        let engine = &self.deployment.engine;
        let options = BuildOptions {
            build: engine.build,
            leaf_size: engine.leaf_size,
            threads: runtime::affinity::allowed_cores().len(),
        };
        let load = |model: &service::Model| match &model.source {
            Source::File(path) => {
                bodies::open(&self.path(path), None, &options).map_err(|failure| Failure {
                    fault: format!("model \"{}\": {}", model.name, failure.fault),
                    ..failure
                })
            }
            Source::Generate { shape, triangles, seed } => {
                let body = bodies::generate_body(*shape, *triangles, *seed, &options, &|_| {})?;
                bodies::encoded(&body)
            }
        };
        self.deployment.models.iter().map(load).collect()
    }
}
