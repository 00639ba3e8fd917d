//! All shards of a study, in children of this process: a scene that kills one takes nothing else
//! away.
//!
//! ```text
//! parent  --"SHARD\n"-->  child: `trolley study work DIR`
//!         <--"at SHARD SCENES\n" "done SHARD\n" "failed SHARD why\n"--
//! ```
//!
//! Each child is served by a thread of its own, which gives it one shard after the other. A child
//! that ends in the middle of a shard is noted with the scene that it had in hand, and another one
//! is started. Children die with their parent.

use crate::attempts::{TRIES, Watcher, note_death};
use crate::plan::Plan;
use crate::seal::Seal;
use crate::shard::Runner;
use runtime::process::{Child, Spawn, spawn};
use std::collections::{BTreeMap, VecDeque};
use std::io::{BufRead as _, BufReader, PipeReader, PipeWriter, Write as _};
use std::os::fd::AsFd as _;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};
use trolley::{Failure, FailureKind};

/// Most children.
const JOBS_MAX: usize = 256;
/// Seconds of CPU time of a child: ten years, so no limit.
const CPU_S: u64 = 315_360_000;
/// A child that said that it ends, or whose pipe is closed, ends within this time (ms).
const END_MS: u64 = 10_000;

/// How to run a study.
#[derive(Clone, Debug)]
pub struct RunOptions {
    /// The program whose `study work DIR` is a child.
    pub program: PathBuf,
    /// Number of children; `None`: one for each core that this process may use.
    pub jobs: Option<usize>,
    /// Address space of each child at most (bytes).
    pub memory_bytes: u64,
}

/// How a run went.
#[derive(Clone, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct RunDone {
    /// Shards that were finished before.
    pub skipped: u32,
    /// Shards that were finished now.
    pub finished: u32,
    /// Shards that are not finished, and why.
    pub failed: BTreeMap<u32, String>,
    /// How many children died in the middle of a shard.
    pub deaths: u64,
}

/// Runs what is not finished. `told` hears of scenes that are done, of all; it is called from
/// several threads.
///
/// # Errors
///
/// If the folder holds no study, another build planned it, or no child can be started. A shard that
/// cannot be finished is in [`RunDone::failed`].
pub fn run(
    dir: &Path,
    options: &RunOptions,
    told: &(dyn Fn(u64, u64) + Sync),
) -> Result<RunDone, Failure> {
    let plan = Plan::open(dir)?;
    plan.check_build()?;
    sweep_up(&plan);
    let jobs = options
        .jobs
        .unwrap_or_else(|| std::thread::available_parallelism().map_or(1, std::num::NonZero::get));
    if !(1..=JOBS_MAX).contains(&jobs) {
        let what = format!("--jobs is {jobs}");
        return Err(Failure::setting(what).with_remedy(format!("write 1 to {JOBS_MAX}")));
    }
    let mut open = VecDeque::new();
    let mut done = RunDone::default();
    let mut scenes_done = 0;
    for shard in spread(plan.shards()) {
        if Seal::read(&plan, shard).is_ok() {
            done.skipped += 1;
            let scenes = plan.scenes_of(shard)?;
            scenes_done += scenes.end - scenes.start;
        } else {
            open.push_back(shard);
        }
    }
    let jobs = jobs.min(open.len());
    let share = Share {
        plan: &plan,
        options,
        open: Mutex::new(open),
        done: Mutex::new(done),
        scenes_done: AtomicU64::new(scenes_done),
        told,
    };
    told(scenes_done, plan.scenes());
    let served: Vec<Result<(), Failure>> = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..jobs).map(|_| scope.spawn(|| share.serve())).collect();
        let joined = threads.into_iter().map(|thread| {
            thread.join().unwrap_or_else(|_| Err(Failure::internal("a thread panicked")))
        });
        joined.collect()
    });
    served.into_iter().collect::<Result<(), Failure>>()?;
    Ok(share.done.into_inner().unwrap_or_else(PoisonError::into_inner))
}

/// All shards, neighbours far from each other, so that what is finished is spread over the study at
/// any time: steps of the golden section.
fn spread(shards: u32) -> impl Iterator<Item = u32> {
    let count = u64::from(shards.max(1));
    let divides = |step: u64| {
        let (mut a, mut b) = (count, step);
        while b > 0 {
            (a, b) = (b, a % b);
        }
        a == 1
    };
    let golden = (count * 618 / 1000).max(1);
    let step = (golden..=count).find(|step| divides(*step)).unwrap_or(1);
    // Below a count that is a u32.
    (0..u64::from(shards)).map(move |number| (number * step % count) as u32)
}

/// Plays the child: runs the shards that the standard input names, and tells on the standard
/// output, until that ends.
///
/// # Errors
///
/// If the folder holds no study, or the parent is gone.
pub fn work(dir: &Path, memory_bytes: u64) -> Result<(), Failure> {
    if let Err(error) = runtime::process::limit_self(memory_bytes, CPU_S) {
        tracing::debug!(%error, "the limits of a child stay as they are");
    }
    let mut runner = Runner::watched(dir, Watcher::Parent)?;
    let gone = |error: std::io::Error| Failure::new(FailureKind::System, error.to_string());
    for line in std::io::stdin().lock().lines() {
        let line = line.map_err(gone)?;
        let Ok(shard) = line.trim().parse::<u32>() else {
            return Err(Failure::setting(format!("\"{line}\" is no shard")));
        };
        let tell = |text: String| {
            let mut out = std::io::stdout().lock();
            out.write_all(text.as_bytes()).and_then(|()| out.flush())
        };
        // A parent that is gone is found out below.
        let ran = runner.run(shard, &mut |scenes| {
            let _told = tell(format!("at {shard} {scenes}\n"));
        });
        let said = match ran {
            Ok(_) => format!("done {shard}\n"),
            Err(failure) => format!("failed {shard} {}\n", failure.what().replace('\n', " ")),
        };
        tell(said).map_err(gone)?;
    }
    Ok(())
}

/// What the threads share.
struct Share<'s> {
    plan: &'s Plan,
    options: &'s RunOptions,
    open: Mutex<VecDeque<u32>>,
    done: Mutex<RunDone>,
    scenes_done: AtomicU64,
    told: &'s (dyn Fn(u64, u64) + Sync),
}

/// What became of a shard that a child was given.
enum Outcome {
    Done,
    /// The child lives.
    Failed(String),
    /// The child is dead.
    Died,
}

impl Share<'_> {
    /// Serves children until no shard is open.
    fn serve(&self) -> Result<(), Failure> {
        let mut worker: Option<Worker> = None;
        loop {
            let next = self.open.lock().unwrap_or_else(PoisonError::into_inner).pop_front();
            let Some(shard) = next else { break };
            self.finish(shard, &mut worker)?;
        }
        if let Some(worker) = worker {
            worker.end();
        }
        Ok(())
    }

    /// Has a shard ranked, however many children that takes: each death counts against a scene, and
    /// a scene has [`TRIES`] tries; deaths between scenes count against the shard.
    fn finish(&self, shard: u32, worker: &mut Option<Worker>) -> Result<(), Failure> {
        let mut tries = 0;
        loop {
            let mut child = match worker.take() {
                Some(child) => child,
                None => Worker::start(self.plan.dir(), self.options)?,
            };
            let outcome = self.asked(shard, &mut child);
            let failed = match outcome {
                Outcome::Done => {
                    self.done(|done| done.finished += 1);
                    *worker = Some(child);
                    return Ok(());
                }
                Outcome::Failed(why) => {
                    *worker = Some(child);
                    tries += 1;
                    why
                }
                Outcome::Died => {
                    let how = child.ended();
                    self.done(|done| done.deaths += 1);
                    let scene = note_death(self.plan.dir(), shard, &how)?;
                    tracing::warn!(shard, scene, how, "a child died");
                    if scene.is_some() {
                        continue;
                    }
                    tries += 1;
                    format!("its process died between scenes ({how})")
                }
            };
            if tries >= TRIES {
                self.done(|done| drop(done.failed.insert(shard, failed)));
                return Ok(());
            }
        }
    }

    fn done(&self, change: impl FnOnce(&mut RunDone)) {
        change(&mut self.done.lock().unwrap_or_else(PoisonError::into_inner));
    }

    /// Gives a shard to a child, and listens until it is done.
    fn asked(&self, shard: u32, child: &mut Worker) -> Outcome {
        let mut counted = 0;
        if child.tell.write_all(format!("{shard}\n").as_bytes()).is_err() {
            return Outcome::Died;
        }
        let outcome = loop {
            let mut line = String::new();
            match child.hear.read_line(&mut line) {
                Ok(0) | Err(_) => break Outcome::Died,
                Ok(_) => {}
            }
            let mut words = line.trim_end().splitn(3, ' ');
            match (words.next(), words.next(), words.next()) {
                (Some("at"), Some(_), Some(scenes)) => {
                    let scenes: u64 = scenes.parse().unwrap_or(counted);
                    self.count(scenes.saturating_sub(counted));
                    counted = counted.max(scenes);
                }
                (Some("done"), ..) => break Outcome::Done,
                (Some("failed"), _, why) => break Outcome::Failed(why.unwrap_or("").to_owned()),
                _ => {}
            }
        };
        if matches!(outcome, Outcome::Done) {
            let all = self.plan.scenes_of(shard).map_or(0, |scenes| scenes.end - scenes.start);
            self.count(all.saturating_sub(counted));
        } else {
            // It begins anew.
            self.scenes_done.fetch_sub(counted, Ordering::Relaxed);
        }
        outcome
    }

    fn count(&self, scenes: u64) {
        let done = self.scenes_done.fetch_add(scenes, Ordering::Relaxed) + scenes;
        (self.told)(done, self.plan.scenes());
    }
}

/// A child with the pipes to it.
struct Worker {
    child: Child,
    tell: PipeWriter,
    hear: BufReader<PipeReader>,
}

impl Worker {
    fn start(dir: &Path, options: &RunOptions) -> Result<Self, Failure> {
        let failed = |error: std::io::Error| {
            Failure::new(FailureKind::Resources, format!("no pipe to a child: {error}"))
        };
        let (input, tell) = std::io::pipe().map_err(failed)?;
        let (hear, output) = std::io::pipe().map_err(failed)?;
        let args = ["study", "work", "--memory-bytes"].map(str::to_owned).into_iter();
        let args = args.chain([options.memory_bytes.to_string(), dir.display().to_string()]);
        let args: Vec<String> = args.collect();
        let child = spawn(Spawn {
            program: &options.program,
            args: &args,
            fds: &[(input.as_fd(), 0), (output.as_fd(), 1)],
            core: None,
        })?;
        Ok(Self { child, tell, hear: BufReader::new(hear) })
    }

    /// Lets it end by itself.
    fn end(self) {
        let Self { mut child, tell, hear } = self;
        drop((tell, hear));
        let _killed_by_drop_otherwise = child.wait_ms(END_MS);
    }

    /// How a dead child ended.
    fn ended(self) -> String {
        let Self { mut child, tell, hear } = self;
        drop((tell, hear));
        match child.wait_ms(END_MS) {
            Ok(Some(exit)) => exit.to_string(),
            Ok(None) => "it did not end, and was killed".to_owned(),
            Err(error) => error.to_string(),
        }
    }
}

/// Removes what dead processes of this machine were writing.
fn sweep_up(plan: &Plan) {
    let host = runtime::machine::host_name();
    for entry in std::fs::read_dir(plan.dir().join("tmp")).into_iter().flatten().flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        // SHARD-HOST-PROCESS-NUMBER, and a host's name may have a hyphen.
        let Some((rest, _)) = name.rsplit_once('-') else { continue };
        let Some((rest, process)) = rest.rsplit_once('-') else { continue };
        let is_ours = rest.split_once('-').is_some_and(|(_, known)| known == host);
        if is_ours && !Path::new("/proc").join(process).exists() {
            // If it cannot be removed, it is in nobody's way.
            let _gone = std::fs::remove_dir_all(entry.path());
        }
    }
}

#[cfg(test)]
mod tests {
    //! Every shard has its turn, once.

    use super::spread;

    #[test]
    fn every_shard_has_its_turn() {
        for count in (0..200).chain([216, 1_183, 65_536]) {
            let mut all: Vec<u32> = spread(count).collect();
            all.sort_unstable();
            assert_eq!(all, (0..count).collect::<Vec<_>>());
        }
    }
}
