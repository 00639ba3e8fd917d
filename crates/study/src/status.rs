//! How far a study is, and whether what is there is what was written.

use crate::attempts;
use crate::plan::Plan;
use crate::reranked::{Reranked, reranked};
use crate::seal::{self, Broken, Seal, TABLES};
use crate::shard::{Runner, publish, set_aside};
use runtime::InputKind;
use serde::Serialize;
use std::num::NonZeroU64;
use std::path::Path;
use trolley::{Failure, files};

/// How far a study is.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Status {
    /// What people call it.
    pub name: String,
    /// Hash of specification, inputs and build.
    pub study: String,
    /// The program that planned it, and alone can run it.
    pub build: String,
    /// Shards in all.
    pub shards: u32,
    /// Shards that are finished.
    pub finished: u32,
    /// Shards that are there, and not as they were written.
    pub broken: u32,
    /// Scenes in all.
    pub scenes: u64,
    /// Scenes of finished shards.
    pub scenes_finished: u64,
    /// Rows of the tables `answers`, `candidates` and `persons`.
    pub rows: [u64; 3],
    /// Rows of `answers` that are refusals.
    pub refused: u64,
    /// How often shards were begun.
    pub attempts: u64,
    /// How often a process died of a scene.
    pub deaths: u64,
    /// Hash of all rows in their order, once all shards are finished.
    pub rows_hash: Option<String>,
}

/// What a check found.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Checked {
    /// Shards that were looked at.
    pub shards: u32,
    /// Shards that are as they were written.
    pub sound: u32,
    /// Shards that are not there yet.
    pub absent: u32,
    /// Those that are there and are not sound.
    pub broken: Vec<BrokenShard>,
    /// What came of ranking rows again, if that was wanted.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reranked: Option<Reranked>,
}

/// A shard that was not as it was written.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct BrokenShard {
    /// Its number.
    pub shard: u32,
    /// What is wrong with it: files, and bytes as far as they are known.
    pub faults: Vec<String>,
    /// Whether it was ranked again, and put in place.
    pub is_redone: bool,
}

impl Status {
    /// Returns all that in lines.
    #[must_use]
    pub fn text(&self) -> String {
        let Self { shards, finished, scenes, scenes_finished, rows, refused, .. } = self;
        let mut text = format!(
            "{}: {finished} of {shards} shards, {scenes_finished} of {scenes} scenes\n\
             rows       {} answers ({refused} refused), {} candidates, {} persons\n\
             attempts   {}, {} processes died of a scene\n\
             study      {}",
            self.name, rows[0], rows[1], rows[2], self.attempts, self.deaths, self.study
        );
        if self.broken > 0 {
            text += &format!("\nbroken     {} shards: trolley study check", self.broken);
        }
        if let Some(hash) = &self.rows_hash {
            text += &format!("\nrows hash  {hash}");
        }
        text
    }
}

impl Checked {
    /// Returns whether nothing was found to be wrong.
    #[must_use]
    pub fn is_sound(&self) -> bool {
        let differs = |reranked: &Reranked| !reranked.differ.is_empty();
        self.broken.is_empty() && !self.reranked.as_ref().is_some_and(differs)
    }

    /// Returns all that in lines, a line for each shard that was not sound.
    #[must_use]
    pub fn text(&self) -> String {
        let Self { shards, sound, absent, broken, reranked } = self;
        let mut text = format!("{sound} of {shards} shards are sound, {absent} not finished.");
        for BrokenShard { shard, faults, is_redone } in broken {
            let redone = if *is_redone { ", ranked again" } else { "" };
            text += &format!("\nShard {shard}{redone}: {}", faults.join("; "));
        }
        if let Some(reranked) = reranked {
            text += &format!("\n{}", reranked.text());
        }
        text
    }
}

/// Says how far the study in a folder is. Files are not read, but for seals: see [`check`].
///
/// # Errors
///
/// If the folder holds no study.
pub fn status(dir: &Path) -> Result<Status, Failure> {
    let plan = Plan::open(dir)?;
    let mut status = Status {
        name: plan.name().to_owned(),
        study: plan.id().to_owned(),
        build: plan.file().build.clone(),
        shards: plan.shards(),
        finished: 0,
        broken: 0,
        scenes: plan.scenes(),
        scenes_finished: 0,
        rows: [0; 3],
        refused: 0,
        attempts: 0,
        deaths: 0,
        rows_hash: None,
    };
    let mut hasher = blake3::Hasher::new();
    for shard in 0..plan.shards() {
        match Seal::read(&plan, shard) {
            Ok(seal) => {
                status.finished += 1;
                status.scenes_finished += seal.scenes[1] - seal.scenes[0];
                status.refused += seal.refused;
                for (sum, rows) in status.rows.iter_mut().zip(seal.rows) {
                    *sum += rows;
                }
                hasher.update(seal.rows_hash.as_bytes());
            }
            Err(Broken::Absent) => {}
            Err(_) => status.broken += 1,
        }
        let [begun, died] = attempts::counts(dir, shard);
        status.attempts += begun;
        status.deaths += died;
    }
    let is_finished = status.finished == status.shards;
    status.rows_hash = is_finished.then(|| hasher.finalize().to_hex().to_string());
    Ok(status)
}

/// Holds every byte of every shard against its seal. A shard that is not sound is ranked again,
/// which shows each byte that was changed, and put in place of what was there.
///
/// `redo`: whether to rank again; else faults are only named, bytes to a block of 4,096.
/// `ranked_every`: then rows whose numbers are multiples of it are held against `trolley rank` of
/// their scenes. `told` hears of shards that were looked at, of all, twice if rows are ranked.
///
/// # Errors
///
/// If the folder holds no study; if `redo`, also if another build planned it, or it cannot be
/// written.
pub fn check(
    dir: &Path,
    redo: bool,
    ranked_every: Option<NonZeroU64>,
    told: &dyn Fn(u64, u64),
) -> Result<Checked, Failure> {
    let plan = Plan::open(dir)?;
    let mut checked =
        Checked { shards: plan.shards(), sound: 0, absent: 0, broken: Vec::new(), reranked: None };
    if ranked_every.is_some() {
        plan.check_build()?;
    }
    let mut runner: Option<Runner> = None;
    for shard in 0..plan.shards() {
        match Seal::check(&plan, shard) {
            Ok(_) => checked.sound += 1,
            Err(Broken::Absent) => checked.absent += 1,
            Err(broken) => {
                let mut faults = broken.faults();
                if redo {
                    let runner = match &mut runner {
                        Some(runner) => runner,
                        none => none.insert(Runner::open(dir)?),
                    };
                    let (folder, _) = runner.written(shard, &mut |_| {})?;
                    if !matches!(broken, Broken::Foreign(_)) {
                        let exact = compared(&seal::folder(dir, shard), &folder);
                        if !exact.is_empty() {
                            faults = exact;
                        }
                    }
                    set_aside(&plan, shard)?;
                    publish(&plan, shard, &folder)?;
                }
                checked.broken.push(BrokenShard { shard, faults, is_redone: redo });
            }
        }
        told(u64::from(shard) + 1, plan.shards().into());
    }
    let strangers = strangers(&plan)?;
    checked.broken.extend(strangers);
    if let Some(every) = ranked_every {
        checked.reranked = Some(reranked(&plan, every.get(), told)?);
    }
    Ok(checked)
}

/// Folders that are no shard of this study.
fn strangers(plan: &Plan) -> Result<Vec<BrokenShard>, Failure> {
    let folder = plan.dir().join("shards");
    let unread = |error: std::io::Error| Failure::input(error.to_string()).at(folder.display());
    let mut found = Vec::new();
    for entry in std::fs::read_dir(&folder).map_err(unread)? {
        let name = entry.map_err(unread)?.file_name().to_string_lossy().into_owned();
        let number = name.parse::<u32>().ok();
        if number.is_none_or(|shard| shard >= plan.shards() || format!("{shard:06}") != name) {
            let faults = vec![format!("shards/{name}: the study has no such shard; remove it")];
            found.push(BrokenShard { shard: number.unwrap_or(u32::MAX), faults, is_redone: false });
        }
    }
    found.sort_by(|a, b| a.faults.cmp(&b.faults));
    Ok(found)
}

/// Every byte in which files differ from those that were ranked again.
fn compared(found: &Path, right: &Path) -> Vec<String> {
    /// So many bytes are listed; more are counted.
    const LISTED: usize = 16;
    let mut faults = Vec::new();
    for name in TABLES.into_iter().chain([seal::SEAL]) {
        let read = |folder: &Path| files::bytes(&folder.join(name), InputKind::Model);
        let Ok(right) = read(right) else { continue };
        let Ok(found) = read(found) else {
            faults.push(format!("{name}: missing, or not readable"));
            continue;
        };
        if found.len() != right.len() {
            let how = if found.len() < right.len() { "truncated" } else { "too long" };
            faults.push(format!("{name}: {how}: {} bytes, not {}", found.len(), right.len()));
        }
        let differs = found.iter().zip(&right).enumerate().filter(|(_, (a, b))| a != b);
        let differs: Vec<(usize, (&u8, &u8))> = differs.collect();
        for (place, (is, was)) in differs.iter().take(LISTED) {
            faults.push(format!("{name}: byte {place} is {is:#04x}, not {was:#04x}"));
        }
        if differs.len() > LISTED {
            faults.push(format!("{name}: {} more bytes differ", differs.len() - LISTED));
        }
    }
    faults
}
