//! Rows held against `trolley rank`: the scene of a row, written as files, read and ranked anew.

use crate::plan::Plan;
use crate::ranker::is_of_processes;
use crate::rows::Answered;
use crate::scene::write_scene;
use crate::seal::{self, Seal};
use columns::{ReadColumn, read};
use runtime::machine;
use serde::Serialize;
use std::fs::File;
use std::path::Path;
use trolley::{Engine, Failure, FailureKind, Limits, Scenario, Worlds};

/// Bytes of bodies that are kept from row to row.
const CACHE_BYTES: usize = 256 << 20;

/// What came of ranking rows again.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Reranked {
    /// Rows that were ranked again.
    pub rows: u64,
    /// Of these, rows that are refusals.
    pub refused: u64,
    /// Rows that were due and are left out: of these scenes processes died, or they took too long.
    pub left_out: u64,
    /// Those that `trolley rank` has otherwise.
    pub differ: Vec<RowFault>,
}

/// A row that differs from its ranking.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct RowFault {
    /// Its number.
    pub row: u64,
    /// How it differs.
    pub what: String,
}

impl Reranked {
    /// Returns all that in lines.
    #[must_use]
    pub fn text(&self) -> String {
        let Self { rows, refused, left_out, differ } = self;
        let equal = rows - differ.len() as u64;
        let mut text = format!("{equal} of {rows} rows equal trolley rank, {refused} refused.");
        if *left_out > 0 {
            text += &format!(" Left out: {left_out} that took processes down, or too long.");
        }
        for RowFault { row, what } in differ {
            text += &format!("\nRow {row}: {what}");
        }
        text
    }
}

/// Ranks every row again whose number is a multiple of `every`, in shards that are finished. `told`
/// hears of shards that were looked at, of all.
pub(crate) fn reranked(
    plan: &Plan,
    every: u64,
    told: &dyn Fn(u64, u64),
) -> Result<Reranked, Failure> {
    let mut engine = Engine::builder().in_process().body_cache(CACHE_BYTES).build()?;
    let host = machine::host_name();
    // As that of a shard that is being written: who dies here leaves it to the next run.
    let folder = plan.dir().join("tmp").join(format!("rank-{host}-{}-0", std::process::id()));
    let mut reranked = Reranked::default();
    for shard in 0..plan.shards() {
        if Seal::read(plan, shard).is_ok() {
            let path = seal::folder(plan.dir(), shard).join("answers.parquet");
            let opened = File::open(&path);
            let file = opened.map_err(|error| {
                Failure::new(FailureKind::System, error.to_string()).at(path.display())
            })?;
            let columns = read(file, ["row", "answer_hash", "refusal"])?;
            let done = reranked.shard(plan, every, &columns, &folder, &mut engine);
            let _gone = std::fs::remove_dir_all(&folder);
            done?;
        }
        told(u64::from(shard) + 1, plan.shards().into());
    }
    Ok(reranked)
}

impl Reranked {
    fn shard(
        &mut self,
        plan: &Plan,
        every: u64,
        [rows, hashes, refusals]: &[ReadColumn; 3],
        folder: &Path,
        engine: &mut Engine,
    ) -> Result<(), Failure> {
        for place in 0..rows.rows() {
            let Some(row) = rows.whole(place).and_then(|row| u64::try_from(row).ok()) else {
                continue;
            };
            if row % every != 0 {
                continue;
            }
            let refusal = refusals.text(place);
            if refusal.is_some_and(is_of_processes) {
                self.left_out += 1;
                continue;
            }
            self.rows += 1;
            self.refused += u64::from(refusal.is_some());
            let now = ranked(plan, row, &folder.join(row.to_string()), engine);
            let what = match (refusal, now) {
                (_, Err(failure)) if failure.kind() == FailureKind::System => return Err(failure),
                (Some(_), Err(_)) => continue,
                (None, Ok(hash)) if hashes.text(place) == Some(hash.as_str()) => continue,
                (None, Ok(hash)) => format!("the hash of the answer is {hash} by trolley rank"),
                (None, Err(failure)) => format!("trolley rank refuses it: {failure}"),
                (Some(_), Ok(_)) => "it is a refusal, and trolley rank has an answer".to_owned(),
            };
            self.differ.push(RowFault { row, what });
        }
        Ok(())
    }
}

/// The hash of the answer to the scene of a row, as `trolley rank` gives it.
fn ranked(plan: &Plan, row: u64, folder: &Path, engine: &mut Engine) -> Result<String, Failure> {
    let written = write_scene(plan, row, folder)?;
    let scenario = Scenario::open(&written.scenario)?;
    let scenario =
        if written.unknown_is_fixed { scenario.assuming_unknown_is_fixed() } else { scenario };
    let worlds = Worlds::new(written.worlds.into(), 0).unwrap_or(Worlds::USUAL);
    let ranking = engine.rank(&scenario, &Limits::default().with_worlds(worlds))?;
    Ok(Answered::new(ranking.answer)?.hash)
}

#[cfg(test)]
mod tests;
