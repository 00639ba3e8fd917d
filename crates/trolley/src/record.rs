//! Decision records: an answer with everything it was made from, so that it can be replayed.
//!
//! The records of a folder are `000000.record`, `000001.record`, ...: one chain. A record is
//! written under a temporary name and then renamed, so a folder never holds half a record, and two
//! writers never use the same number. A [`Signer`] signs each, and how many there are, in
//! `chain.head`. Without one, the chain shows accidents, not forgery.
//!
//! ```
//! # use trolley::{Engine, Limits, Record, Scenario};
//! # let folder = std::env::temp_dir().join(format!("trolley-record-{}", std::process::id()));
//! # std::fs::create_dir_all(&folder).ok();
//! # let scenario = Scenario::open("../../config/scenarios/small.toml")?;
//! # let mut engine = Engine::builder().in_process().build()?;
//! Record::prepare(&folder)?;
//! let ranking = engine.rank(&scenario, &Limits::default().with_record())?;
//! let path = Record::write(&folder, &ranking)?;
//! assert!(path.ends_with("000000.record"));
//! # std::fs::remove_dir_all(&folder).ok();
//! # Ok::<(), trolley::Failure>(())
//! ```

use crate::engine::Ranking;
use crate::files::{self, InputKind};
use crate::{Failure, FailureKind};
use std::path::{Path, PathBuf};

mod content;
mod replay;
mod sign;
mod verify;
mod write;

/// The place of a [`Record`] in its chain.
///
/// ```
/// # use trolley::{Engine, Limits, Record, Scenario};
/// # let folder = std::env::temp_dir().join(format!("trolley-link-{}", std::process::id()));
/// # std::fs::create_dir_all(&folder).ok();
/// # let scenario = Scenario::open("../../config/scenarios/small.toml")?;
/// # let mut engine = Engine::builder().in_process().build()?;
/// # let ranking = engine.rank(&scenario, &Limits::default().with_record())?;
/// # let path = Record::write(&folder, &ranking)?;
/// let next = Record::write(&folder, &ranking)?;
/// let [first, second] = [Record::read(&path)?.link, Record::read(&next)?.link];
/// assert_eq!((second.number, second.previous), (1, first.hash));
/// # std::fs::remove_dir_all(&folder).ok();
/// # Ok::<(), trolley::Failure>(())
/// ```
pub use record::Link;

/// The content of a [`Record`].
///
/// ```
/// # use trolley::{Engine, Limits, Record, Scenario};
/// # let folder = std::env::temp_dir().join(format!("trolley-content-{}", std::process::id()));
/// # std::fs::create_dir_all(&folder).ok();
/// # let scenario = Scenario::open("../../config/scenarios/small.toml")?;
/// # let mut engine = Engine::builder().in_process().build()?;
/// # let ranking = engine.rank(&scenario, &Limits::default().with_record())?;
/// # let path = Record::write(&folder, &ranking)?;
/// # let record = Record::read(&path)?;
/// assert_eq!(record.content.build, trolley::BUILD);
/// assert!(record.content.answer.starts_with('{'), "JSON");
/// # std::fs::remove_dir_all(&folder).ok();
/// # Ok::<(), trolley::Failure>(())
/// ```
pub use record::RecordContent;

/// A body in a [`RecordContent`].
///
/// ```
/// # use trolley::{Engine, Limits, Record, Scenario};
/// # let folder = std::env::temp_dir().join(format!("trolley-body-{}", std::process::id()));
/// # std::fs::create_dir_all(&folder).ok();
/// # let scenario = Scenario::open("../../config/scenarios/small.toml")?;
/// # let mut engine = Engine::builder().in_process().build()?;
/// # let ranking = engine.rank(&scenario, &Limits::default().with_record())?;
/// # let path = Record::write(&folder, &ranking)?;
/// # let record = Record::read(&path)?;
/// for body in &record.content.bodies {
///     println!("{}: {}", body.party, body.hash);
/// }
/// # assert_eq!(record.content.bodies.len(), 5);
/// # std::fs::remove_dir_all(&folder).ok();
/// # Ok::<(), trolley::Failure>(())
/// ```
pub use record::RecordedBody;

/// How a job in a [`RecordContent`] ended.
///
/// ```
/// # use trolley::{Engine, Limits, Record, Scenario};
/// # let folder = std::env::temp_dir().join(format!("trolley-end-{}", std::process::id()));
/// # std::fs::create_dir_all(&folder).ok();
/// # let scenario = Scenario::open("../../config/scenarios/small.toml")?;
/// # let mut engine = Engine::builder().in_process().build()?;
/// # let ranking = engine.rank(&scenario, &Limits::default().with_record())?;
/// # let path = Record::write(&folder, &ranking)?;
/// # let record = Record::read(&path)?;
/// use trolley::record::RecordedEnd;
///
/// assert!(record.content.all_jobs().any(|job| job.end == RecordedEnd::Done));
/// # std::fs::remove_dir_all(&folder).ok();
/// # Ok::<(), trolley::Failure>(())
/// ```
pub use record::RecordedEnd;

/// Where a [`RecordedBody`] comes from.
///
/// ```
/// # use trolley::{Engine, Limits, Record, Scenario};
/// # let folder = std::env::temp_dir().join(format!("trolley-source-{}", std::process::id()));
/// # std::fs::create_dir_all(&folder).ok();
/// # let scenario = Scenario::open("../../config/scenarios/small.toml")?;
/// # let mut engine = Engine::builder().in_process().build()?;
/// # let ranking = engine.rank(&scenario, &Limits::default().with_record())?;
/// # let path = Record::write(&folder, &ranking)?;
/// # let record = Record::read(&path)?;
/// use trolley::record::RecordedSource;
///
/// let bodies = &record.content.bodies;
/// assert!(bodies.iter().all(|body| body.source == RecordedSource::Generated));
/// # std::fs::remove_dir_all(&folder).ok();
/// # Ok::<(), trolley::Failure>(())
/// ```
pub use record::RecordedSource;

/// What [`Record::verify`] has proved, and what not, in words.
///
/// ```
/// use trolley::record::Proof;
///
/// let words = Proof::Unsigned.to_string();
/// assert!(words.contains("shows accidents, not forgery"));
/// ```
pub use record::Proof;

/// What the signer of a [`Record`] states: which record it is, and when, where and by what program
/// it was written.
///
/// ```
/// # use trolley::{Engine, Limits, Scenario};
/// # use trolley::{Record, record::Signer};
/// # let folder = std::env::temp_dir().join(format!("trolley-stated-{}", std::process::id()));
/// # std::fs::create_dir_all(&folder).ok();
/// # let key = folder.join("key.pem");
/// # std::fs::copy("examples/data/rfc8032.pem", &key).ok();
/// # use std::os::unix::fs::PermissionsExt;
/// # std::fs::set_permissions(&key, PermissionsExt::from_mode(0o600)).ok();
/// # let scenario = Scenario::open("../../config/scenarios/small.toml")?;
/// # let mut engine = Engine::builder().in_process().build()?;
/// # let ranking = engine.rank(&scenario, &Limits::default().with_record())?;
/// # let records = folder.join("records");
/// # let signer = Signer::open(&key)?;
/// # signer.prepare(&records)?;
/// let path = signer.write(&records, &ranking)?;
/// let stated = Record::read(&path)?.statement.map(|signed| signed.statement);
/// let provenance = stated.expect("it is signed").provenance;
/// println!("{} on {}", provenance.time(), provenance.host);
/// assert_eq!(provenance.build, trolley::BUILD);
/// # std::fs::remove_dir_all(&folder).ok();
/// # Ok::<(), trolley::Failure>(())
/// ```
pub use record::SignedStatement;

/// The public key of a signer, from [`public_key`].
///
/// ```
/// # let file = std::env::temp_dir().join(format!("trolley-public-{}", std::process::id()));
/// // What `openssl pkey -in key.pem -pubout` wrote.
/// std::fs::write(&file, "-----BEGIN PUBLIC KEY-----\n\
///     MCowBQYDK2VwAyEA11qYAYKxCrfVS/7TyWQHOg7hcvPapiMlrwIaaPcHURo=\n\
///     -----END PUBLIC KEY-----\n").expect("written");
/// let key: trolley::record::VerifyingKey = trolley::record::public_key(&file)?;
/// assert!(key.to_string().starts_with("d75a980182b10ab7"));
/// # std::fs::remove_file(&file).ok();
/// # Ok::<(), trolley::Failure>(())
/// ```
pub use record::VerifyingKey;
pub use replay::Replay;
pub use sign::{Signer, public_key};
pub use verify::{Verified, VerifyOptions, holds_decisions, verify_decisions};

/// What [`verify_decisions`] has found.
///
/// ```
/// # let folder = std::env::temp_dir().join(format!("trolley-kept-{}", std::process::id()));
/// # std::fs::create_dir_all(&folder).ok();
/// use trolley::record::{VerifiedDecisions, VerifyOptions, verify_decisions};
///
/// let options = VerifyOptions::default();
/// let VerifiedDecisions { count, first, .. } = verify_decisions(&folder, &options)?;
/// assert_eq!((count, first), (0, 0), "the folder is empty");
/// # std::fs::remove_dir_all(&folder).ok();
/// # Ok::<(), trolley::Failure>(())
/// ```
pub use service::VerifiedDecisions;

/// A decision record, and its place in its chain.
///
/// ```
/// # use trolley::{Engine, Limits, Record, Scenario};
/// # let folder = std::env::temp_dir().join(format!("trolley-struct-{}", std::process::id()));
/// # std::fs::create_dir_all(&folder).ok();
/// # let scenario = Scenario::open("../../config/scenarios/small.toml")?;
/// # let mut engine = Engine::builder().in_process().build()?;
/// # let ranking = engine.rank(&scenario, &Limits::default().with_record())?;
/// let path = Record::write(&folder, &ranking)?;
/// let record = Record::read(&path)?;
/// assert_eq!(record.link.number, 0);
/// # std::fs::remove_dir_all(&folder).ok();
/// # Ok::<(), trolley::Failure>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    /// Everything about one request.
    pub content: RecordContent,
    /// Its number and hash, and the hash of the one before it.
    pub link: Link,
    /// What its signer states; `None`: nobody signed it. [`Record::read`] checks the signature
    /// against the key that the statement names; whose key that is, [`Record::verify`] checks.
    pub statement: Option<SignedStatement>,
}

impl Record {
    /// Creates a folder for records if it does not exist, and checks that a record can be added:
    /// call it before work is spent on a ranking.
    ///
    /// ```
    /// # let folder = std::env::temp_dir().join(format!("trolley-prepare-{}", std::process::id()));
    /// # std::fs::create_dir_all(&folder).ok();
    /// let records = folder.join("records");
    /// trolley::Record::prepare(&records)?;
    /// assert!(records.is_dir());
    /// # std::fs::remove_dir_all(&folder).ok();
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    ///
    /// # Errors
    ///
    /// If the folder cannot be written to, its last record cannot be read, or it is signed: see
    /// [`Signer::prepare`].
    pub fn prepare(folder: &Path) -> Result<(), Failure> {
        write::prepare(folder, None)
    }

    /// Adds a ranking to a folder's records, and returns the path of the new one. The ranking must
    /// have been made with [`Limits::with_record`](crate::Limits::with_record).
    ///
    /// ```
    /// # use trolley::{Engine, Limits, Record, Scenario};
    /// # let folder = std::env::temp_dir().join(format!("trolley-write-{}", std::process::id()));
    /// # std::fs::create_dir_all(&folder).ok();
    /// # let scenario = Scenario::open("../../config/scenarios/small.toml")?;
    /// # let mut engine = Engine::builder().in_process().build()?;
    /// let ranking = engine.rank(&scenario, &Limits::default().with_record())?;
    /// let path = Record::write(&folder, &ranking)?;
    ///
    /// let bare = engine.rank(&scenario, &Limits::default())?;
    /// assert!(Record::write(&folder, &bare).is_err(), "nothing was recorded");
    /// # std::fs::remove_dir_all(&folder).ok();
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    ///
    /// # Errors
    ///
    /// If the ranking holds no record, or the folder cannot be written to.
    pub fn write(folder: &Path, ranking: &Ranking) -> Result<PathBuf, Failure> {
        write::write(folder, ranking, None)
    }

    /// Reads a record, and checks every byte of it.
    ///
    /// ```
    /// # use trolley::{Engine, Limits, Record, Scenario};
    /// # let folder = std::env::temp_dir().join(format!("trolley-read-{}", std::process::id()));
    /// # std::fs::create_dir_all(&folder).ok();
    /// # let scenario = Scenario::open("../../config/scenarios/small.toml")?;
    /// # let mut engine = Engine::builder().in_process().build()?;
    /// # let ranking = engine.rank(&scenario, &Limits::default().with_record())?;
    /// # let path = Record::write(&folder, &ranking)?;
    /// let record = Record::read(&path)?;
    /// println!("{} by {}", record.content.scenario.name, record.content.build);
    /// # std::fs::remove_dir_all(&folder).ok();
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    ///
    /// # Errors
    ///
    /// If it cannot be read, is not a record, was changed since it was written, or has the name of
    /// another one.
    pub fn read(path: &Path) -> Result<Self, Failure> {
        let read = record::decode(&bytes(path)?);
        let (content, link, statement) =
            read.map_err(|error| Failure::from(error).at(path.display()))?;
        record::chain::named_alike(&path.to_string_lossy(), link.number)?;
        Ok(Self { content, link, statement })
    }
}

fn unwritable(path: &Path, error: &std::io::Error) -> Failure {
    Failure::new(FailureKind::System, error.to_string())
        .at(path.display())
        .with_remedy("--record needs a folder that can be written to")
}

/// A document as JSON on one line.
pub(crate) fn line(document: &impl serde::Serialize) -> Result<String, Failure> {
    serde_json::to_string(document).map_err(|error| Failure::internal(error.to_string()))
}

/// The records of a folder, by name.
fn records(folder: &Path) -> Result<Vec<PathBuf>, Failure> {
    let wrong = |error: std::io::Error| Failure::input(error.to_string()).at(folder.display());
    let mut paths = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(wrong)? {
        let path = entry.map_err(wrong)?.path();
        if path.extension().is_some_and(|end| end == "record") {
            paths.push(path);
        }
    }
    // By number: from a million on, names have one more digit.
    paths.sort_by_key(|path| (path.as_os_str().len(), path.clone()));
    Ok(paths)
}

fn bytes(path: &Path) -> Result<Vec<u8>, Failure> {
    files::bytes(path, InputKind::Record)
}

/// Returns a hash as hexadecimal digits.
///
/// ```
/// assert!(trolley::record::hex(&[10; 32]).starts_with("0a0a"));
/// ```
#[must_use]
pub fn hex(hash: &[u8; 32]) -> String {
    hash.iter().map(|byte| format!("{byte:02x}")).collect()
}
