//! Removing the files of domains whose coordinator is dead.

use super::place::{
    OURS, SHM, UNBORN, boot_of, lock_out_guests, lock_root, names_in_shm, prefix_of,
};
use rustix::thread::nanosleep;
use rustix::time::Timespec;
use std::fs;
use std::path::Path;

/// Workers die with their coordinator, but a moment later: how often to check a run of another
/// coordinator, 1 ms apart.
const LOOKS: usize = 200;
/// How often to check one's own run: its workers were told to end, or killed, and a busy machine
/// may be slow to end them.
pub(super) const OWN_LOOKS: usize = 5_000;

/// Removes what dead runs of every instance left in /dev/shm; returns the number of runs.
///
/// A run is dead if no process holds the lock of its root or that of its guests: files must not be
/// removed while a process of the run could still open them. If a worker does not die, its run
/// stays for the next sweep. Files of other programs stay.
#[must_use]
pub fn sweep_leftovers() -> usize {
    let Ok(names) = names_in_shm() else { return 0 };
    let mut removed = 0;
    for name in &names {
        let path = format!("{SHM}/{name}");
        if let Some(rest) = name.strip_prefix(UNBORN) {
            sweep_unborn(&path, rest);
        } else if boot_of(name).is_some()
            && let Some(_owned) = lock_root(&path)
            && remove(name, LOOKS)
        {
            removed += 1;
        }
    }
    sweep_orphans(&names);
    removed
}

/// Names of runs and services whose process is dead, in a folder; nothing is removed.
#[must_use]
pub fn dead_instances(folder: &Path) -> Vec<String> {
    let Ok(entries) = fs::read_dir(folder) else { return Vec::new() };
    let names = entries.flatten().filter_map(|entry| entry.file_name().into_string().ok());
    let is_dead = |name: &String| {
        let is_root = boot_of(name).is_some() || name.starts_with("trolley-");
        let path = folder.join(name);
        // A live owner holds the lock; if free, it is released at once.
        is_root && path.is_dir() && path.to_str().and_then(lock_root).is_some()
    };
    let mut names: Vec<String> = names.filter(is_dead).collect();
    names.sort_unstable();
    names
}

/// Removes a domain, after at most `looks` checks whether its guests have gone. The caller holds
/// the lock of its root.
///
/// The memory is removed first: while the root exists, its lock shows others that removal is in
/// progress.
pub(super) fn remove(name: &str, looks: usize) -> bool {
    let root = format!("{SHM}/{name}");
    let Some(_alone) = (0..looks).find_map(|look| {
        if look > 0 {
            let _early = nanosleep(&Timespec { tv_sec: 0, tv_nsec: 1_000_000 });
        }
        lock_out_guests(&root).ok()
    }) else {
        return false;
    };
    let prefix = prefix_of(name);
    let mut all = true;
    for file in names_in_shm().unwrap_or_default() {
        if file.starts_with(&prefix) {
            all &= fs::remove_file(format!("{SHM}/{file}")).is_ok();
        }
    }
    all && fs::remove_dir_all(&root).is_ok()
}

/// A root that never got its name: its maker is dead, or was about to lock it.
fn sweep_unborn(path: &str, rest: &str) {
    let maker = rest.split('.').next().unwrap_or_default();
    if !Path::new("/proc").join(maker).exists()
        && let Some(_owned) = lock_root(path)
        && let Err(error) = fs::remove_dir_all(path)
    {
        tracing::debug!(path, %error, "stays");
    }
}

/// Memory without a root: a domain has its root before it has memory, and loses it after.
fn sweep_orphans(names: &[String]) {
    for name in names {
        if let Some((root, _)) = name.strip_prefix(OURS).and_then(|_| split_root(name))
            && boot_of(root).is_some()
            && !Path::new(SHM).join(root).exists()
            && let Err(error) = fs::remove_file(Path::new(SHM).join(name))
        {
            tracing::debug!(name, %error, "stays");
        }
    }
}

/// Root and rest of the name of a piece of memory; the instance may itself hold dashes.
fn split_root(name: &str) -> Option<(&str, &str)> {
    let boot = name.match_indices('.').nth(1)?.0 + 1;
    let dash = boot + name.get(boot..)?.find('-')?;
    Some((name.get(..dash)?, name.get(dash..)?))
}
