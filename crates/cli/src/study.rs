//! `trolley study`: many scenes as tables; the crate `study` does the work.

use crate::output::Output;
use crate::print;
use clap::Subcommand;
use serde::Serialize;
use std::num::NonZeroU64;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use study::RunOptions;
use trolley::{Failure, FailureKind};

pub(crate) const EXAMPLES: &str = "\
Examples:
  trolley study plan config/examples/study.toml -o studies/two
  trolley study run studies/two --jobs 2
  trolley study run studies/two --shard 1
  trolley study check studies/two --ranked-every 500
  trolley study report studies/two -o study.html
  trolley study scene studies/two 100 -o studies/scene
  trolley rank studies/scene/scenario.toml

A study begins with a file that says what to sweep: trolley help studies. Each shard may be run by
whoever has the folder: --shard $SLURM_ARRAY_TASK_ID, --shard $JOB_COMPLETION_INDEX. What was
stopped goes on where it was: run it again.";

/// What to do with a study.
#[derive(Debug, Subcommand)]
pub(crate) enum Verb {
    /// Read a specification and all that it names, and write the folder of a study.
    Plan {
        /// Specification, TOML: see `trolley help studies`.
        spec: PathBuf,
        /// Folder to write.
        #[arg(short, long, value_name = "DIR")]
        out: PathBuf,
    },
    /// Rank what is not finished: all shards in child processes, or one in this process.
    Run {
        /// Folder of the study.
        dir: PathBuf,
        /// Rank this shard alone, in this process.
        #[arg(long, value_name = "K", conflicts_with = "jobs")]
        shard: Option<u32>,
        /// Number of child processes [default: one for each core that this process may use].
        #[arg(long, value_name = "N")]
        jobs: Option<usize>,
        /// Memory (address space) of each child at most, in MiB.
        #[arg(long, value_name = "N", default_value_t = 4096)]
        memory_mb: u64,
    },
    /// Say how far a study is.
    Status {
        /// Folder of the study.
        dir: PathBuf,
    },
    /// Hold every byte of every shard against its seal, and rank broken shards again.
    Check {
        /// Folder of the study.
        dir: PathBuf,
        /// Name what is broken, and leave it as it is.
        #[arg(long)]
        keep: bool,
        /// Rank every Nth row again, from files as `trolley rank` does, and compare the answers.
        #[arg(long, value_name = "N")]
        ranked_every: Option<NonZeroU64>,
    },
    /// Write the page of a study: who wins where, what flips that, regret, worst cases.
    Report {
        /// Folder of the study.
        dir: PathBuf,
        /// HTML page to write; the records of the worst cases go beside it.
        #[arg(short, long, value_name = "FILE.html")]
        out: PathBuf,
        /// Write the records of the worst cases alone, and no page of each (1 MB).
        #[arg(long)]
        no_scenes: bool,
    },
    /// Write the scene of a row of the table `answers`, so that `trolley rank` can rank it.
    Scene {
        /// Folder of the study.
        dir: PathBuf,
        /// Number of the row.
        row: u64,
        /// Folder to write.
        #[arg(short, long, value_name = "DIR")]
        out: PathBuf,
    },
    /// Run as a child of `run`; not started by hand.
    #[command(hide = true)]
    Work {
        dir: PathBuf,
        #[arg(long)]
        memory_bytes: u64,
    },
}

pub(crate) fn run(verb: &Verb, output: &Output) -> Result<ExitCode, Failure> {
    match verb {
        Verb::Plan { spec, out } => plan(spec, out, output),
        Verb::Run { dir, shard: Some(shard), .. } => one_shard(dir, *shard, output),
        Verb::Run { dir, jobs, memory_mb, .. } => all_shards(dir, *jobs, *memory_mb, output),
        Verb::Status { dir } => {
            let status = study::status(dir)?;
            shown(&status, || status.text(), output)
        }
        Verb::Check { dir, keep, ranked_every } => check(dir, *keep, *ranked_every, output),
        Verb::Report { dir, out, no_scenes } => {
            let progress = output.progress("reading shards");
            let told = |done, total| progress.set(done, total);
            let written = study::report(dir, out, !no_scenes, &told)?;
            drop(progress);
            for file in written {
                output.say(&format!("written: {}", file.display()));
            }
            Ok(ExitCode::SUCCESS)
        }
        Verb::Scene { dir, row, out } => {
            let written = study::write_scene(&study::Plan::open(dir)?, *row, out)?;
            shown(&written, || written.command(), output)
        }
        Verb::Work { dir, memory_bytes } => {
            study::work(dir, *memory_bytes).map(|()| ExitCode::SUCCESS)
        }
    }
}

fn shown(
    document: &impl Serialize,
    text: impl FnOnce() -> String,
    output: &Output,
) -> Result<ExitCode, Failure> {
    if output.json { print::out(&print::json(document)?) } else { print::lines(&text()) }
}

fn plan(spec: &Path, out: &Path, output: &Output) -> Result<ExitCode, Failure> {
    let plan = study::plan(spec, out)?;
    for (name, refusal) in plan.inputs() {
        if let Some(refusal) = refusal {
            output.say(&format!("Note: {name} gives no scene: {refusal}"));
        }
    }
    let status = study::status(out)?;
    let text = || {
        format!(
            "{}: {} scenes, {} answers each, in {} shards.\nNext: trolley study run {}",
            plan.name(),
            plan.scenes(),
            plan.answers_per_scene(),
            plan.shards(),
            out.display()
        )
    };
    shown(&status, text, output)
}

fn one_shard(dir: &Path, shard: u32, output: &Output) -> Result<ExitCode, Failure> {
    let mut runner = study::Runner::open(dir)?;
    let scenes = runner.plan().scenes_of(shard)?;
    let total = scenes.end - scenes.start;
    let progress = output.progress("scenes");
    let done = runner.run(shard, &mut |scenes| progress.set(scenes, total))?;
    drop(progress);
    let before = if done.was_finished { ", finished before" } else { "" };
    let [answers, ..] = done.rows;
    let text = || format!("Shard {shard}: {answers} answers, {} refused{before}.", done.refused);
    shown(&done, text, output)
}

fn all_shards(
    dir: &Path,
    jobs: Option<usize>,
    memory_mb: u64,
    output: &Output,
) -> Result<ExitCode, Failure> {
    let program = "/proc/self/exe".into();
    let memory_bytes = memory_mb.saturating_mul(1 << 20);
    let progress = output.progress("scenes");
    let told = |done, total| progress.set(done, total);
    let done = study::run(dir, &RunOptions { program, jobs, memory_bytes }, &told)?;
    drop(progress);
    for (shard, why) in &done.failed {
        output.say(&format!("Shard {shard} is not finished: {why}"));
    }
    let status = study::status(dir)?;
    let code = shown(&status, || status.text(), output)?;
    Ok(if done.failed.is_empty() { code } else { FailureKind::System.into() })
}

fn check(
    dir: &Path,
    keep: bool,
    ranked_every: Option<NonZeroU64>,
    output: &Output,
) -> Result<ExitCode, Failure> {
    let progress = output.progress("shards");
    let told = |done, total| progress.set(done, total);
    let checked = study::check(dir, !keep, ranked_every, &told)?;
    drop(progress);
    let code = shown(&checked, || checked.text(), output)?;
    Ok(if checked.is_sound() { code } else { FailureKind::CheckFailed.into() })
}
