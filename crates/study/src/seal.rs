//! What a finished shard says of itself: whose it is, which rows it has, and the hashes of its
//! files, in blocks, so that a flipped byte has a place.

use crate::plan::{Plan, hash};
use crate::rows::TABLES_SCHEMA;
use runtime::InputKind;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use trolley::files;

/// Name of the seal in the folder of a shard.
pub(crate) const SEAL: &str = "seal.json";
/// Names of its tables.
pub(crate) const TABLES: [&str; 3] = ["answers.parquet", "candidates.parquet", "persons.parquet"];
/// Bytes of a block that has a hash of its own.
const BLOCK: usize = 1 << 12;

/// The seal of a shard: the same bytes whoever ranks it, and however often.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Seal {
    pub(crate) schema: String,
    pub(crate) study: String,
    pub(crate) shard: u32,
    /// The scenes: from, and up to but not including.
    pub(crate) scenes: [u64; 2],
    /// Rows of each table.
    pub(crate) rows: [u64; 3],
    /// Rows of `answers` that are refusals.
    pub(crate) refused: u64,
    /// Hash of all rows, table after table.
    pub(crate) rows_hash: String,
    pub(crate) files: Vec<SealedFile>,
    /// Hash of all before.
    pub(crate) seal: String,
}

/// A file of a shard.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct SealedFile {
    pub(crate) name: String,
    pub(crate) bytes: u64,
    pub(crate) hash: String,
    /// The first 8 digits of the hash of each block of 4,096 bytes.
    pub(crate) blocks: Vec<String>,
}

/// Why a shard does not count as finished.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Broken {
    /// There is none.
    Absent,
    /// Its files are not those that were written; each fault in a sentence.
    Damaged(Vec<String>),
    /// It belongs to another study, shard or build.
    Foreign(String),
}

impl SealedFile {
    pub(crate) fn new(name: &str, bytes: &[u8]) -> Self {
        let blocks = bytes.chunks(BLOCK).map(|block| hash(block)[..8].to_owned());
        Self {
            name: name.to_owned(),
            bytes: bytes.len() as u64,
            hash: hash(bytes),
            blocks: blocks.collect(),
        }
    }

    /// What is wrong with the bytes that are there.
    fn faults(&self, found: &[u8], faults: &mut Vec<String>) {
        if hash(found) == self.hash {
            return;
        }
        let name = &self.name;
        if found.len() as u64 != self.bytes {
            let how = if (found.len() as u64) < self.bytes { "truncated" } else { "too long" };
            faults.push(format!("{name}: {how}: {} bytes, not {}", found.len(), self.bytes));
        }
        for (number, block) in found.chunks(BLOCK).enumerate() {
            let is_same = self.blocks.get(number).is_some_and(|known| hash(block)[..8] == **known);
            let is_last = number + 1 >= self.blocks.len();
            // The end of a file of another length is said already.
            let is_said = is_last && found.len() as u64 != self.bytes;
            if !(is_same || is_said) {
                let from = number * BLOCK;
                faults.push(format!(
                    "{name}: changed within bytes {from} to {}",
                    from + block.len() - 1
                ));
            }
        }
        if faults.is_empty() {
            faults.push(format!("{name}: changed"));
        }
    }
}

impl Seal {
    pub(crate) fn new(plan: &Plan, shard: u32, scenes: [u64; 2]) -> Self {
        Self {
            schema: TABLES_SCHEMA.to_owned(),
            study: plan.id().to_owned(),
            shard,
            scenes,
            rows: [0; 3],
            refused: 0,
            rows_hash: String::new(),
            files: Vec::new(),
            seal: String::new(),
        }
    }

    fn hash(&self) -> String {
        let open = Self { seal: String::new(), ..self.clone() };
        hash(serde_json::to_string(&open).unwrap_or_default().as_bytes())
    }

    /// The text of the seal, closed.
    pub(crate) fn text(mut self) -> String {
        self.seal = self.hash();
        serde_json::to_string_pretty(&self).unwrap_or_default() + "\n"
    }

    /// Reads the seal of a shard, and holds every byte of its files against it.
    pub(crate) fn check(plan: &Plan, shard: u32) -> Result<Self, Broken> {
        let folder = folder(plan.dir(), shard);
        let seal = Self::read(plan, shard)?;
        let mut faults = Vec::new();
        for file in &seal.files {
            match files::bytes(&folder.join(&file.name), InputKind::Model) {
                Ok(found) => file.faults(&found, &mut faults),
                Err(_) => faults.push(format!("{}: missing, or not readable", file.name)),
            }
        }
        if faults.is_empty() { Ok(seal) } else { Err(Broken::Damaged(faults)) }
    }

    /// Reads the seal of a shard, and looks only whether its files are there in full length.
    pub(crate) fn read(plan: &Plan, shard: u32) -> Result<Self, Broken> {
        let folder = folder(plan.dir(), shard);
        if !folder.is_dir() {
            return Err(Broken::Absent);
        }
        let path = folder.join(SEAL);
        let damaged = |fault: String| Broken::Damaged(vec![format!("{SEAL}: {fault}")]);
        if !path.exists() {
            return Err(damaged("missing".to_owned()));
        }
        let text = files::text(&path, InputKind::Scenario);
        let text = text.map_err(|failure| damaged(failure.what().to_owned()))?;
        let seal: Self = serde_json::from_str(&text).map_err(|error| damaged(error.to_string()))?;
        // Its own text, to the last byte.
        if seal.clone().text() != text {
            return Err(damaged("changed".to_owned()));
        }
        let Ok(scenes) = plan.scenes_of(shard) else {
            return Err(Broken::Foreign(format!("the study has no shard {shard}")));
        };
        if seal.schema != TABLES_SCHEMA || seal.study != plan.id() {
            return Err(Broken::Foreign(format!("it is of study {}", short(&seal.study))));
        }
        if seal.shard != shard || seal.scenes != [scenes.start, scenes.end] {
            return Err(Broken::Foreign(format!("it is shard {}", seal.shard)));
        }
        let names: Vec<&str> = seal.files.iter().map(|file| file.name.as_str()).collect();
        if names != TABLES {
            return Err(damaged("it does not name the three tables".to_owned()));
        }
        let short: Vec<String> = seal
            .files
            .iter()
            .filter_map(|file| {
                let found = folder.join(&file.name).metadata().map_or(0, |found| found.len());
                let what = format!("{}: {found} bytes, not {}", file.name, file.bytes);
                (found != file.bytes).then_some(what)
            })
            .collect();
        if short.is_empty() { Ok(seal) } else { Err(Broken::Damaged(short)) }
    }
}

impl Broken {
    /// Every fault, in a sentence.
    pub(crate) fn faults(&self) -> Vec<String> {
        match self {
            Self::Absent => Vec::new(),
            Self::Damaged(faults) => faults.clone(),
            Self::Foreign(fault) => vec![format!("foreign: {fault}")],
        }
    }
}

/// The folder of a shard.
pub(crate) fn folder(dir: &Path, shard: u32) -> PathBuf {
    dir.join("shards").join(format!("{shard:06}"))
}

/// The beginning of a hash, for people.
pub(crate) fn short(hash: &str) -> &str {
    hash.get(..16).unwrap_or(hash)
}
