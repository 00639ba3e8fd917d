//! Signing records, and the keys for it.

use super::write;
use crate::engine::Ranking;
use crate::files::{self, InputKind};
use crate::{BUILD, Failure, OpenDeployment};
use record::{ChainId, Provenance, RecordedDeployment, SigningKey, VerifyingKey};
use runtime::{clock, input, machine};
use std::path::{Path, PathBuf};

/// Writes signed records, as [`Record`](super::Record) writes unsigned ones.
///
/// The key is Ed25519, in a file that only its owner may read: `openssl genpkey -algorithm ed25519
/// -out key.pem`. With each record, and with the head of the chain, the time of day, the host name,
/// the deployment and the build are signed: as the machine states them.
///
/// ```
/// # use trolley::{Engine, Limits, Scenario};
/// use trolley::record::{Record, Signer, VerifyOptions};
/// # let folder = std::env::temp_dir().join(format!("trolley-signer-{}", std::process::id()));
/// # std::fs::create_dir_all(&folder).ok();
/// # let key = folder.join("key.pem");
/// # std::fs::copy("examples/data/rfc8032.pem", &key).ok();
/// # use std::os::unix::fs::PermissionsExt;
/// # std::fs::set_permissions(&key, PermissionsExt::from_mode(0o600)).ok();
/// # let scenario = Scenario::open("../../config/scenarios/small.toml")?;
/// # let mut engine = Engine::builder().in_process().build()?;
/// # let records = folder.join("records");
///
/// let signer = Signer::open(&key)?;
/// signer.prepare(&records)?;
/// let ranking = engine.rank(&scenario, &Limits::default().with_record())?;
/// signer.write(&records, &ranking)?;
///
/// let options = VerifyOptions { key: Some(signer.public_key()), ..VerifyOptions::default() };
/// let verified = Record::verify(&records, &options)?;
/// assert_eq!((verified.count, verified.proof.name()), (1, "signed"));
/// # std::fs::remove_dir_all(&folder).ok();
/// # Ok::<(), trolley::Failure>(())
/// ```
#[derive(Clone, Debug)]
pub struct Signer {
    key: SigningKey,
    deployment: Option<RecordedDeployment>,
}

/// Reads a public key: what `openssl pkey -in key.pem -pubout` writes.
///
/// ```
/// let error = trolley::record::public_key("no-such-file.pub".as_ref()).unwrap_err();
/// assert!(error.to_string().contains("there is no such file"));
/// ```
///
/// # Errors
///
/// If the file cannot be read, or holds no such key.
pub fn public_key(path: &Path) -> Result<VerifyingKey, Failure> {
    let text = files::text(path, InputKind::Key)?;
    VerifyingKey::from_pem(&text).map_err(|error| Failure::from(error).at(path.display()))
}

impl Signer {
    /// Reads a secret key.
    ///
    /// ```
    /// # let folder = std::env::temp_dir().join(format!("trolley-exposed-{}", std::process::id()));
    /// # std::fs::create_dir_all(&folder).ok();
    /// # let key = folder.join("key.pem");
    /// # std::fs::copy("examples/data/rfc8032.pem", &key).ok();
    /// use std::os::unix::fs::PermissionsExt;
    /// use trolley::record::Signer;
    ///
    /// std::fs::set_permissions(&key, PermissionsExt::from_mode(0o644)).expect("set");
    /// let error = Signer::open(&key).unwrap_err();
    /// assert!(error.to_string().contains("chmod 600"), "others may read it");
    /// # std::fs::remove_dir_all(&folder).ok();
    /// ```
    ///
    /// # Errors
    ///
    /// If the file cannot be read, holds no such key, or can be read or changed by others.
    pub fn open(path: &Path) -> Result<Self, Failure> {
        let text = input::secret_text(path, InputKind::Key)?;
        let key =
            SigningKey::from_pem(&text).map_err(|error| Failure::from(error).at(path.display()))?;
        Ok(Self { key, deployment: None })
    }

    /// Names the instance in what is signed.
    ///
    /// ```no_run
    /// let signer = trolley::record::Signer::open("key.pem".as_ref())?.with_instance("vehicle");
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    #[must_use]
    pub fn with_instance(mut self, name: &str) -> Self {
        self.deployment = Some(RecordedDeployment { name: name.to_owned(), hash: None });
        self
    }

    /// Names the deployment and the hash of its file in what is signed.
    ///
    /// ```no_run
    /// let file = "/etc/trolley/deployment.toml";
    /// let opened = trolley::OpenDeployment::open(file.as_ref(), None)?;
    /// let signer = trolley::record::Signer::open("key.pem".as_ref())?.with_deployment(&opened);
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    #[must_use]
    pub fn with_deployment(mut self, opened: &OpenDeployment) -> Self {
        let (name, hash) = (opened.deployment.instance.clone(), Some(opened.hash()));
        self.deployment = Some(RecordedDeployment { name, hash });
        self
    }

    /// Returns the public key that belongs to the secret one.
    ///
    /// ```no_run
    /// let signer = trolley::record::Signer::open("key.pem".as_ref())?;
    /// println!("{}", signer.public_key());
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    #[must_use]
    pub fn public_key(&self) -> VerifyingKey {
        self.key.verifying_key()
    }

    /// As [`Record::prepare`](super::Record::prepare). Begins the chain if there is none yet, and
    /// writes the head if a writer ended before it did.
    ///
    /// ```no_run
    /// let signer = trolley::record::Signer::open("key.pem".as_ref())?;
    /// signer.prepare("decisions".as_ref())?;
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    ///
    /// # Errors
    ///
    /// If the folder cannot be written to, its records are not signed with this key, or its head
    /// does not fit them.
    pub fn prepare(&self, folder: &Path) -> Result<(), Failure> {
        write::prepare(folder, Some(self))
    }

    /// As [`Record::write`](super::Record::write), signed.
    ///
    /// ```no_run
    /// # let scenario = trolley::Scenario::demo()?;
    /// # let mut engine = trolley::Engine::builder().build()?;
    /// let signer = trolley::record::Signer::open("key.pem".as_ref())?;
    /// let ranking = engine.rank(&scenario, &trolley::Limits::default().with_record())?;
    /// signer.write("decisions".as_ref(), &ranking)?;
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    ///
    /// # Errors
    ///
    /// As [`Signer::prepare`], or if the ranking holds no record.
    pub fn write(&self, folder: &Path, ranking: &Ranking) -> Result<PathBuf, Failure> {
        write::write(folder, ranking, Some(self))
    }

    /// The signer of a service's decisions.
    pub(crate) fn of_decisions(&self) -> service::DecisionSigner {
        service::DecisionSigner { key: self.key.clone(), provenance: self.provenance() }
    }

    pub(crate) fn key(&self) -> &SigningKey {
        &self.key
    }

    /// When, where and by what program something is signed now.
    pub(crate) fn provenance(&self) -> Provenance {
        Provenance {
            written_ns: clock::time_of_day_ns(),
            host: machine::host_name(),
            deployment: self.deployment.clone(),
            build: BUILD.to_owned(),
        }
    }

    /// The identity of a chain that begins.
    pub(super) fn new_chain(&self) -> Result<ChainId, Failure> {
        let halves = [clock::random_u64()?, clock::random_u64()?];
        let mut chain = [0; 16];
        for (half, bytes) in halves.iter().zip(chain.chunks_exact_mut(8)) {
            bytes.copy_from_slice(&half.to_le_bytes());
        }
        Ok(chain)
    }
}
