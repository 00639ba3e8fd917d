//! Checking records: every byte, their chain, and their signatures.

use super::{Link, Record, bytes, records};
use crate::files::{self, InputKind};
use crate::{Failure, FailureKind};
use record::chain::{Chain, HEAD_FILE};
use record::{Proof, SignedStatement, VerifyingKey};
use service::VerifiedDecisions;
use std::path::{Path, PathBuf};

/// What [`Record::verify`] compares records with.
///
/// ```
/// use trolley::record::VerifyOptions;
///
/// let options = VerifyOptions { head: Some("kept/chain.head".into()), ..Default::default() };
/// assert!(options.key.is_none(), "it shows accidents, not forgery");
/// ```
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct VerifyOptions {
    /// The public key of the signer.
    pub key: Option<VerifyingKey>,
    /// A copy of an earlier `chain.head`: its records must still be there.
    pub head: Option<PathBuf>,
}

/// What [`Record::verify`] has found.
///
/// ```
/// # let folder = std::env::temp_dir().join(format!("trolley-verified-{}", std::process::id()));
/// # std::fs::create_dir_all(&folder).ok();
/// let verified = trolley::Record::verify(&folder, &trolley::record::VerifyOptions::default())?;
/// assert_eq!((verified.count, verified.last), (0, None));
/// # std::fs::remove_dir_all(&folder).ok();
/// # Ok::<(), trolley::Failure>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Verified {
    /// How many records there are.
    pub count: u64,
    /// The last one's place in its chain.
    pub last: Option<Link>,
    /// What the signer of the last one states; `None`: nobody signed it.
    pub statement: Option<SignedStatement>,
    /// What was proved.
    pub proof: Proof,
}

impl Record {
    /// Checks every byte of a record, or of all records of a folder and that each follows the one
    /// before it; and their signatures.
    ///
    /// ```
    /// # use trolley::{Engine, Limits, Record, Scenario};
    /// use trolley::record::{Proof, VerifyOptions};
    /// # let folder = std::env::temp_dir().join(format!("trolley-verify-{}", std::process::id()));
    /// # std::fs::create_dir_all(&folder).ok();
    /// # let scenario = Scenario::open("../../config/scenarios/small.toml")?;
    /// # let mut engine = Engine::builder().in_process().build()?;
    /// # let ranking = engine.rank(&scenario, &Limits::default().with_record())?;
    /// # let path = Record::write(&folder, &ranking)?;
    /// let verified = Record::verify(&folder, &VerifyOptions::default())?;
    /// assert_eq!((verified.count, verified.last.map(|link| link.number)), (1, Some(0)));
    /// assert_eq!(verified.proof, Proof::Unsigned);
    /// # std::fs::remove_dir_all(&folder).ok();
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    ///
    /// # Errors
    ///
    /// If one was changed, exchanged, renamed or removed, or with a key, if one is not signed with
    /// it. What a writer leaves that was killed is no error.
    pub fn verify(path: &Path, options: &VerifyOptions) -> Result<Verified, Failure> {
        let mut chain = Chain::new(options.key);
        if !path.is_dir() {
            if options.head.is_some() {
                return Err(Failure::setting("the head of a chain says nothing of one record")
                    .at(path.display())
                    .with_remedy("name the folder of the chain"));
            }
            let bytes = bytes(path)?;
            chain.single(&path.display().to_string(), &bytes)?;
            let Self { link, statement, .. } = Self::read(path)?;
            let proof = chain.finish_single();
            return Ok(Verified { count: 1, last: Some(link), statement, proof });
        }
        let name = path.join(HEAD_FILE).display().to_string();
        let (head, files) = snapshot(path)?;
        if let Some(bytes) = head {
            chain.head(&name, &bytes)?;
        }
        if let Some(copy) = &options.head {
            let bytes = files::bytes(copy, InputKind::ChainHead)?;
            chain.copy_of_head(&copy.display().to_string(), &bytes)?;
        }
        let (mut count, mut last, mut stated) = (0, None, None);
        for file in files {
            let bytes = bytes(&file)?;
            let (link, statement) = chain.next(&file.display().to_string(), &bytes)?;
            // The content must decode, too.
            record::decode(&bytes).map_err(|error| Failure::from(error).at(file.display()))?;
            (count, last, stated) = (count + 1, Some(link), statement);
        }
        let proof = chain.finish(&name)?;
        Ok(Verified { count, last, statement: stated, proof })
    }
}

/// Whether a folder holds the decisions of a service, and no records.
///
/// ```
/// assert!(!trolley::record::holds_decisions("../../config".as_ref()));
/// ```
#[must_use]
pub fn holds_decisions(folder: &Path) -> bool {
    let names = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let names: Vec<String> =
        names.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    let any = |is: &dyn Fn(&String) -> bool| names.iter().any(is);
    any(&|name| {
        name.starts_with("decisions") && (name.ends_with(".bin") || name.ends_with(".head"))
    }) && !any(&|name| name.ends_with(".record") || *name == HEAD_FILE)
}

/// Checks a folder of decisions that a service kept: every byte, their chain, and their signatures.
///
/// ```
/// # let folder = std::env::temp_dir().join(format!("trolley-decided-{}", std::process::id()));
/// # std::fs::create_dir_all(&folder).ok();
/// use trolley::record::{Proof, VerifyOptions, verify_decisions};
///
/// let verified = verify_decisions(&folder, &VerifyOptions::default())?;
/// assert_eq!(verified.proof, Proof::Unsigned);
/// # std::fs::remove_dir_all(&folder).ok();
/// # Ok::<(), trolley::Failure>(())
/// ```
///
/// # Errors
///
/// As [`Record::verify`]; that whole files are missing from the front is no error, since the
/// service deletes its oldest ones.
pub fn verify_decisions(
    folder: &Path,
    options: &VerifyOptions,
) -> Result<VerifiedDecisions, Failure> {
    Ok(service::verify_decisions(folder, options.key, options.head.as_deref())?)
}

/// The head of a folder and its records, as they were at one time: a writer may add to them.
fn snapshot(folder: &Path) -> Result<(Option<Vec<u8>>, Vec<PathBuf>), Failure> {
    let path = folder.join(HEAD_FILE);
    let head = || match path.try_exists() {
        Ok(false) => Ok(None),
        _ => files::bytes(&path, InputKind::ChainHead).map(Some),
    };
    let mut before = head()?;
    for _ in 0..1000 {
        let files = records(folder)?;
        let after = head()?;
        if before == after {
            return Ok((before, files));
        }
        before = after;
    }
    Err(Failure::new(FailureKind::TryAgain, "records are added faster than they can be listed")
        .at(folder.display())
        .with_remedy("try again, or verify a copy"))
}
