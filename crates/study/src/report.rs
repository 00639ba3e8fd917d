//! The page of a study: who wins where, what flips that, regret, worst cases with their records.
//!
//! ```text
//! shards --gather, one after the other--> counts, a byte per answer, the worst few --page--> HTML
//!                                                               └──ranked again--> records
//! ```

use crate::plan::{Plan, make};
use crate::seal::{Broken, Seal};
use gather::{Gathered, Worst};
use std::path::{Path, PathBuf};
use trolley::{Engine, Failure, FailureKind, Limits, Record, References, Scenario, files};

mod figures;
mod gather;
mod maps;
mod page;

/// Most answers of a study that a page is made of: each is a byte in memory.
const ANSWERS_MAX: u64 = 4 << 30;

/// A worst case, ranked again.
struct Recorded {
    worst: Worst,
    /// Its record and its page, if that is written, relative to the page of the study; none: it was
    /// not the same answer, or could not be ranked.
    files: Vec<String>,
}

/// Writes the page of a study to `out`, and beside it, in a folder called like it with `-records`,
/// the records of the worst cases, with a page each if `has_scenes`; returns what was written.
/// Shards that are not finished are left out, and the page says so. `told`
/// hears of shards that were read, of all.
///
/// # Errors
///
/// If the folder holds no study, a shard is broken, no shard is finished, or a file cannot be
/// written.
pub fn report(
    dir: &Path,
    out: &Path,
    has_scenes: bool,
    told: &dyn Fn(u64, u64),
) -> Result<Vec<PathBuf>, Failure> {
    files::check(out, None)?;
    let plan = Plan::open(dir)?;
    if plan.answers() > ANSWERS_MAX {
        let what = format!("{} answers are more than a page is made of", plan.answers());
        return Err(Failure::setting(what).with_remedy("read the tables: trolley help studies"));
    }
    let mut gathered = Gathered::new(&plan);
    for shard in 0..plan.shards() {
        match Seal::check(&plan, shard) {
            Ok(_) => gathered.add(&plan, shard)?,
            Err(Broken::Absent) => {}
            Err(broken) => {
                let what = format!("shard {shard}: {}", broken.faults().join("; "));
                let help = "rank it again: trolley study check";
                return Err(Failure::input(what).at(dir.display()).with_remedy(help));
            }
        }
        told(u64::from(shard) + 1, plan.shards().into());
    }
    if gathered.scenes == 0 {
        let what = "no shard is finished";
        return Err(Failure::input(what).at(dir.display()).with_remedy("trolley study run"));
    }
    gathered.finish(&plan);
    let mut written = vec![out.to_owned()];
    let mut recorded: Vec<Recorded> = Vec::new();
    for worst in gathered.worst() {
        let known = recorded.iter().find(|known| known.worst.row == worst.row);
        if let Some(files) = known.map(|known| known.files.clone()) {
            recorded.push(Recorded { worst, files });
            continue;
        }
        let found = record(&plan, &worst, out, has_scenes).unwrap_or_else(|failure| {
            tracing::warn!(row = worst.row, %failure, "a worst case has no record");
            Vec::new()
        });
        let files = found.iter().map(|file| relative(out, file)).collect();
        written.extend(found);
        recorded.push(Recorded { worst, files });
    }
    let text = page::page(&plan, &gathered, &recorded, out);
    files::replace(out, text.as_bytes())?;
    Ok(written)
}

/// Ranks a row again, and writes its record and its page; none: this program's answer is another.
fn record(
    plan: &Plan,
    worst: &Worst,
    out: &Path,
    has_scene: bool,
) -> Result<Vec<PathBuf>, Failure> {
    let scratch = tempfile::tempdir()
        .map_err(|error| Failure::new(FailureKind::System, error.to_string()))?;
    let scene = crate::scene::write_scene(plan, worst.row, scratch.path())?;
    let scenario = Scenario::open_with(&scene.scenario, References::Inside)?;
    let scenario =
        if scene.unknown_is_fixed { scenario.assuming_unknown_is_fixed() } else { scenario };
    let mut engine = Engine::builder().in_process().build()?;
    let ranking = engine.rank(&scenario, &Limits::default().with_record())?;
    let same = ranking.answer.best().map(|best| best.name.as_str()) == worst.winner.as_deref();
    if !same {
        return Ok(Vec::new());
    }
    let title = out.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let folder = out.with_file_name(format!("{title}-records"));
    let folder = folder.join(format!("row-{}", worst.row));
    make(&folder)?;
    // A record is added to those that are there; this one stands alone.
    for entry in std::fs::read_dir(&folder).into_iter().flatten().flatten() {
        let _gone = std::fs::remove_file(entry.path());
    }
    Record::prepare(&folder)?;
    let path = Record::write(&folder, &ranking)?;
    if !has_scene {
        return Ok(vec![path]);
    }
    let page = folder.join("scene.html");
    let wanted = report::Wanted { page: Some(page.clone()), ..report::Wanted::default() };
    let models = scene.scenario.parent();
    report::write(&path, models, &wanted, trolley::bodies::SILENT)?;
    Ok(vec![path, page])
}

/// A path beside a page, as a link of it.
fn relative(page: &Path, file: &Path) -> String {
    let folder = page.parent().unwrap_or(Path::new(""));
    file.strip_prefix(folder).unwrap_or(file).display().to_string()
}
