//! One shard: its scenes ranked, and its tables written as a whole or not at all.
//!
//! ```text
//! scenes --engine--> answers --rows--> three tables in DIR/tmp --seal, fsync, rename--> DIR/shards
//! ```

use crate::attempts::{Attempt, Watcher};
use crate::plan::{Plan, make};
use crate::ranker::{self, Ranker};
use crate::rows::{self, ANSWERS, CANDIDATES, PERSONS, Row, Tables};
use crate::scene::Scenes;
use crate::seal::{self, Broken, SEAL, Seal, SealedFile, TABLES};
use columns::TableWriter;
use runtime::machine;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use trolley::{Failure, FailureKind, files};

/// So many answers are in memory until they are written.
const PIECE: usize = 512;

/// A shard that is finished.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct ShardDone {
    /// Its number.
    pub shard: u32,
    /// Rows of `answers`, `candidates` and `persons`.
    pub rows: [u64; 3],
    /// Rows of `answers` that are refusals.
    pub refused: u64,
    /// Hash of all its rows: the same on every machine.
    pub rows_hash: String,
    /// Whether it was finished before, and nothing was done.
    pub was_finished: bool,
}

/// Runs shards of one study, one after the other, with one engine: for a thread or a process.
pub struct Runner {
    plan: Plan,
    ranker: Ranker,
    watcher: Watcher,
}

/// Runs one shard of the study in a folder, whoever asks, and however often: a finished one is
/// skipped, and what is not finished leaves no trace but its attempt.
///
/// # Errors
///
/// If the folder holds no study, another build planned it, there is no such shard, or it cannot be
/// written, or the machine refuses what a scene needs. That a scene cannot be ranked is a row.
pub fn run_shard(dir: &Path, shard: u32) -> Result<ShardDone, Failure> {
    Runner::open(dir)?.run(shard, &mut |_| {})
}

impl Runner {
    /// Opens the folder of a study.
    ///
    /// # Errors
    ///
    /// If it holds none, or another build planned it.
    pub fn open(dir: &Path) -> Result<Self, Failure> {
        Self::watched(dir, Watcher::Next)
    }

    pub(crate) fn watched(dir: &Path, watcher: Watcher) -> Result<Self, Failure> {
        let plan = Plan::open(dir)?;
        plan.check_build()?;
        let ranker = Ranker::new(&plan)?;
        Ok(Self { plan, ranker, watcher })
    }

    /// The plan.
    #[must_use]
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// Runs a shard, as [`run_shard`]; `told` hears how many of its scenes are done.
    ///
    /// # Errors
    ///
    /// As [`run_shard`].
    pub fn run(&mut self, shard: u32, told: &mut dyn FnMut(u64)) -> Result<ShardDone, Failure> {
        match Seal::check(&self.plan, shard) {
            Ok(seal) => return Ok(done(&seal, true)),
            Err(Broken::Absent) => {}
            Err(Broken::Damaged(_) | Broken::Foreign(_)) => set_aside(&self.plan, shard)?,
        }
        // Before anything is noted of it.
        self.plan.scenes_of(shard)?;
        let (folder, seal) = self.written(shard, told)?;
        publish(&self.plan, shard, &folder)?;
        Ok(done(&seal, false))
    }

    /// Ranks a shard into a folder below `DIR/tmp`.
    pub(crate) fn written(
        &mut self,
        shard: u32,
        told: &mut dyn FnMut(u64),
    ) -> Result<(PathBuf, Seal), Failure> {
        let attempt = Attempt::begin(self.plan.dir(), shard, self.watcher)?;
        let written = self.ranked(shard, &attempt, told);
        // Nobody died of the scene in hand, whatever came out.
        attempt.end();
        written
    }

    fn ranked(
        &mut self,
        shard: u32,
        attempt: &Attempt,
        told: &mut dyn FnMut(u64),
    ) -> Result<(PathBuf, Seal), Failure> {
        let scenes = self.plan.scenes_of(shard)?;
        let (plan, ranker) = (&self.plan, &mut self.ranker);
        let mut source = Scenes::new(plan);
        let mut writer = ShardWriter::new(plan, shard, [scenes.start, scenes.end])?;
        let mut rows = Vec::new();
        for scene in scenes.clone() {
            let is_poison = attempt.takes(scene)?;
            let key = plan.scene(scene)?;
            let outcomes = if is_poison {
                ranker::died(plan)
            } else {
                ranker.outcomes(plan, &mut source, &key)?
            };
            for (answer, outcome) in (0..).zip(outcomes) {
                let (policy, curves) = plan.judges_of(answer);
                let row = scene * plan.answers_per_scene() + answer;
                rows.push(Row { row, key: key.clone(), policy, curves, outcome });
            }
            if rows.len() >= PIECE {
                writer.append(plan, &rows)?;
                rows.clear();
            }
            told(scene + 1 - scenes.start);
        }
        writer.append(plan, &rows)?;
        writer.finish(plan)
    }
}

fn done(seal: &Seal, was_finished: bool) -> ShardDone {
    ShardDone {
        shard: seal.shard,
        rows: seal.rows,
        refused: seal.refused,
        rows_hash: seal.rows_hash.clone(),
        was_finished,
    }
}

/// The tables of a shard while they grow.
struct ShardWriter {
    seal: Seal,
    hasher: [blake3::Hasher; 3],
    answers: TableWriter<38>,
    candidates: TableWriter<18>,
    persons: TableWriter<9>,
}

impl ShardWriter {
    fn new(plan: &Plan, shard: u32, scenes: [u64; 2]) -> Result<Self, Failure> {
        Ok(Self {
            seal: Seal::new(plan, shard, scenes),
            hasher: core::array::from_fn(|_| blake3::Hasher::new()),
            answers: TableWriter::new(ANSWERS)?,
            candidates: TableWriter::new(CANDIDATES)?,
            persons: TableWriter::new(PERSONS)?,
        })
    }

    fn append(&mut self, plan: &Plan, rows: &[Row]) -> Result<(), Failure> {
        if rows.is_empty() {
            return Ok(());
        }
        let tables = Tables::of(plan, rows);
        let Tables { answers, candidates, persons } = &tables;
        let counts = [answers.rows().len(), candidates.rows().len(), persons.rows().len()];
        for (sum, count) in self.seal.rows.iter_mut().zip(counts) {
            *sum += count as u64;
        }
        self.seal.refused += rows.iter().filter(|row| row.outcome.is_err()).count() as u64;
        let [of_answers, of_candidates, of_persons] = &mut self.hasher;
        rows::hash_rows(answers, of_answers);
        rows::hash_rows(candidates, of_candidates);
        rows::hash_rows(persons, of_persons);
        self.answers.append(answers)?;
        self.candidates.append(candidates)?;
        self.persons.append(persons)
    }

    /// Writes all files to a folder of their own, the seal last; they are on the disk then.
    fn finish(self, plan: &Plan) -> Result<(PathBuf, Seal), Failure> {
        static NUMBER: AtomicU64 = AtomicU64::new(0);
        let Self { mut seal, hasher, answers, candidates, persons } = self;
        let number = NUMBER.fetch_add(1, Ordering::Relaxed);
        let (host, process) = (machine::host_name(), std::process::id());
        let name = format!("{:06}-{host}-{process}-{number}", seal.shard);
        let folder = plan.dir().join("tmp").join(name);
        make(&folder)?;
        let mut all = blake3::Hasher::new();
        for hasher in &hasher {
            all.update(hasher.finalize().as_bytes());
        }
        seal.rows_hash = all.finalize().to_hex().to_string();
        let tables = [answers.finish()?, candidates.finish()?, persons.finish()?];
        for (name, bytes) in TABLES.into_iter().zip(&tables) {
            files::replace(&folder.join(name), bytes)?;
            seal.files.push(SealedFile::new(name, bytes));
        }
        files::replace(&folder.join(SEAL), seal.clone().text().as_bytes())?;
        flush(&folder)?;
        Ok((folder, seal))
    }
}

/// Renames a finished folder to its place. If somebody else was faster, theirs stays.
pub(crate) fn publish(plan: &Plan, shard: u32, folder: &Path) -> Result<(), Failure> {
    let target = seal::folder(plan.dir(), shard);
    let renamed = std::fs::rename(folder, &target).or_else(|error| {
        if Seal::check(plan, shard).is_ok() {
            return std::fs::remove_dir_all(folder);
        }
        Err(error)
    });
    renamed.map_err(|error| failed(&target, &error))?;
    flush(target.parent().unwrap_or(&target))
}

/// Puts a shard away that is damaged or not ours, so that it can be ranked again.
pub(crate) fn set_aside(plan: &Plan, shard: u32) -> Result<(), Failure> {
    let folder = seal::folder(plan.dir(), shard);
    std::fs::remove_dir_all(&folder).map_err(|error| failed(&folder, &error))
}

/// Waits until the entries of a folder are on the disk.
fn flush(folder: &Path) -> Result<(), Failure> {
    let flushed = File::open(folder).and_then(|folder| folder.sync_all());
    flushed.map_err(|error| failed(folder, &error))
}

fn failed(path: &Path, error: &std::io::Error) -> Failure {
    Failure::new(FailureKind::System, error.to_string())
        .at(path.display())
        .with_remedy("the study's folder must be writable and have room")
}
