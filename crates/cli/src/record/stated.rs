//! What the signer of a record states, in words and as a document.

use serde::Serialize;
use std::fmt;
use trolley::record::{SignedStatement, hex};

/// What a signer states, for people and as JSON.
#[derive(Serialize)]
pub(super) struct Stated {
    pub(super) key: String,
    time: String,
    host: String,
    deployment: Option<String>,
    deployment_hash: Option<String>,
    build: String,
    chain: String,
}

impl Stated {
    pub(super) fn of(signed: &SignedStatement) -> Self {
        let SignedStatement { statement, signer } = signed;
        let provenance = &statement.provenance;
        let deployment = provenance.deployment.as_ref();
        Self {
            key: signer.to_string(),
            time: provenance.time(),
            host: provenance.host.clone(),
            deployment: deployment.map(|known| known.name.clone()),
            deployment_hash: deployment.and_then(|known| known.hash).map(|hash| hex(&hash)),
            build: provenance.build.clone(),
            chain: statement.chain.iter().map(|byte| format!("{byte:02x}")).collect(),
        }
    }
}

impl fmt::Display for Stated {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { time, host, build, chain, .. } = self;
        write!(f, "at {time} on {host} by build {build}, ")?;
        match (&self.deployment, &self.deployment_hash) {
            (None, _) => f.write_str("without a deployment")?,
            (Some(name), None) => write!(f, "instance {name}")?,
            (Some(name), Some(hash)) => write!(f, "deployment {name} ({hash})")?,
        }
        write!(f, ", chain {chain}")
    }
}
