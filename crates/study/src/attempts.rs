//! Who began which shard, and which scenes processes died of: a scene that kills three times is a
//! row with its refusal.
//!
//! Per shard there are two small files. The log has a line for each attempt and for each death; the
//! other one says which scene is in hand, and is gone when the shard is finished. Whoever watches a
//! process notes its death ([`note_death`]); a process that nobody watches is noted by the next
//! one, which finds its scene still in hand.

use runtime::machine;
use std::fs::{File, OpenOptions};
use std::io::Write as _;
use std::os::unix::fs::FileExt as _;
use std::path::{Path, PathBuf};
use trolley::{Failure, FailureKind};

/// So often a scene is tried.
pub(crate) const TRIES: usize = 3;

/// Who notes that a process died.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Watcher {
    /// Its parent, which sees how it ended.
    Parent,
    /// Whoever begins the shard next.
    Next,
}

/// An attempt at a shard.
pub(crate) struct Attempt {
    hand: File,
    path: PathBuf,
    died: Vec<u64>,
}

impl Attempt {
    pub(crate) fn begin(dir: &Path, shard: u32, watcher: Watcher) -> Result<Self, Failure> {
        let path = hand(dir, shard);
        if watcher == Watcher::Next && in_hand(&path).is_some() {
            note_death(dir, shard, "nobody saw how")?;
        }
        let who = format!("begin {} {}", machine::host_name(), std::process::id());
        append(&log(dir, shard), &who)?;
        let died = lines(dir, shard).filter_map(|line| death(&line)).collect();
        let hand = OpenOptions::new().create(true).write(true).truncate(true).open(&path);
        Ok(Self { hand: hand.map_err(|error| failed(&path, &error))?, path, died })
    }

    /// Notes which scene comes next; returns whether processes died of it too often.
    pub(crate) fn takes(&self, scene: u64) -> Result<bool, Failure> {
        // Always as long, so that a shorter number leaves nothing of a longer one.
        let text = format!("{scene:020}");
        let written = self.hand.write_all_at(text.as_bytes(), 0);
        written.map_err(|error| failed(&self.path, &error))?;
        Ok(self.died.iter().filter(|died| **died == scene).count() >= TRIES)
    }

    /// The shard is finished, or was left in good order.
    pub(crate) fn end(self) {
        // One that is left behind names a scene that is finished: nothing is lost.
        let _gone = std::fs::remove_file(&self.path);
    }
}

/// Notes that the process that had a shard in hand died, and of which scene; returns the scene, if
/// there was one.
pub(crate) fn note_death(dir: &Path, shard: u32, how: &str) -> Result<Option<u64>, Failure> {
    let path = hand(dir, shard);
    let Some(scene) = in_hand(&path) else { return Ok(None) };
    append(&log(dir, shard), &format!("died {scene} {how}"))?;
    let _gone = std::fs::remove_file(&path);
    Ok(Some(scene))
}

/// How often a shard was begun, and how often a process died of it.
pub(crate) fn counts(dir: &Path, shard: u32) -> [u64; 2] {
    lines(dir, shard).fold([0, 0], |[begun, died], line| {
        let is_begin = u64::from(line.starts_with("begin "));
        [begun + is_begin, died + u64::from(death(&line).is_some())]
    })
}

fn hand(dir: &Path, shard: u32) -> PathBuf {
    dir.join("attempts").join(format!("{shard:06}.hand"))
}

fn log(dir: &Path, shard: u32) -> PathBuf {
    dir.join("attempts").join(format!("{shard:06}.log"))
}

fn in_hand(path: &Path) -> Option<u64> {
    std::fs::read_to_string(path).ok()?.trim().parse().ok()
}

/// The scene of a line about a death.
fn death(line: &str) -> Option<u64> {
    line.strip_prefix("died ")?.split(' ').next()?.parse().ok()
}

fn lines(dir: &Path, shard: u32) -> impl Iterator<Item = String> + use<> {
    let text = std::fs::read_to_string(log(dir, shard)).unwrap_or_default();
    text.lines().map(str::to_owned).collect::<Vec<_>>().into_iter()
}

/// Adds a line in one write, so that lines of several processes do not mix.
fn append(path: &Path, line: &str) -> Result<(), Failure> {
    let opened = OpenOptions::new().create(true).append(true).open(path);
    opened
        .and_then(|mut file| file.write_all(format!("{line}\n").as_bytes()))
        .map_err(|error| failed(path, &error))
}

fn failed(path: &Path, error: &std::io::Error) -> Failure {
    Failure::new(FailureKind::System, error.to_string())
        .at(path.display())
        .with_remedy("the study's folder must be writable and have room")
}
