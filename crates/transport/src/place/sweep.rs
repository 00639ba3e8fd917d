//! Removing places whose owner is dead.

use super::{UNBORN, lock_dead, lock_out_guests};
use rustix::thread::nanosleep;
use rustix::time::Timespec;
use std::fs;
use std::path::Path;

/// Removes dead places in a folder; returns how many. `is_place` tells by their names which entries
/// are places; all others stay.
///
/// A place is dead if no process holds the lock of its owner or that of its guests: files must not
/// be removed while a process could still open them. If a guest does not leave, its place stays for
/// the next sweep.
pub(crate) fn sweep_places(folder: &Path, is_place: impl Fn(&str) -> bool, looks: usize) -> usize {
    let Ok(entries) = fs::read_dir(folder) else { return 0 };
    let names = entries.flatten().filter_map(|entry| entry.file_name().into_string().ok());
    let mut removed = 0;
    for name in names.collect::<Vec<_>>() {
        let path = folder.join(&name);
        if let Some(rest) = name.strip_prefix(UNBORN) {
            sweep_unborn(&path, rest);
        } else if is_place(&name)
            && let Some(_owned) = lock_dead(&path)
            && remove(&path, looks)
        {
            removed += 1;
        }
    }
    removed
}

/// Names of places in a folder whose owner is dead; nothing is removed.
pub(crate) fn dead_places(folder: &Path, is_place: impl Fn(&str) -> bool) -> Vec<String> {
    let Ok(entries) = fs::read_dir(folder) else { return Vec::new() };
    let names = entries.flatten().filter_map(|entry| entry.file_name().into_string().ok());
    // A live owner holds the lock; if free, it is released at once.
    let is_dead = |name: &String| is_place(name) && lock_dead(&folder.join(name)).is_some();
    let mut names: Vec<String> = names.filter(is_dead).collect();
    names.sort_unstable();
    names
}

/// Removes a place, after at most `looks` checks whether its guests have gone. The caller holds the
/// owner's lock.
pub(super) fn remove(root: &Path, looks: usize) -> bool {
    let Some(_alone) = (0..looks).find_map(|look| {
        if look > 0 {
            let _early = nanosleep(&Timespec { tv_sec: 0, tv_nsec: 1_000_000 });
        }
        lock_out_guests(root).ok()
    }) else {
        return false;
    };
    fs::remove_dir_all(root).is_ok()
}

/// A place that never got its name: its maker is dead, or was about to lock it.
fn sweep_unborn(path: &Path, rest: &str) {
    let maker = rest.split('.').next().unwrap_or_default();
    if !Path::new("/proc").join(maker).exists()
        && let Some(_owned) = lock_dead(path)
        && let Err(error) = fs::remove_dir_all(path)
    {
        tracing::debug!(path = %path.display(), %error, "stays");
    }
}
