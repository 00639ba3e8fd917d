//! What this process removes if it ends by force: its own places, while other threads of it may
//! stand still and hold any lock of this program.
//!
//! Its list is an array of atomic pointers: whoever takes an entry out owns it.

use super::{default_folder, remove_if_empty, sweep};
use core::ptr;
use core::sync::atomic::{AtomicPtr, Ordering};
use std::fs::{self, File};
use std::path::{Path, PathBuf};

/// How often to look whether the guests of a place, which were killed, have ended, 1 ms apart.
const LOOKS: usize = 200;

/// One without a slot, beyond these, is left for the next run to remove.
static SLOTS: [AtomicPtr<Entry>; 32] = [const { AtomicPtr::new(ptr::null_mut()) }; 32];

#[derive(Debug)]
struct Entry {
    files: Vec<PathBuf>,
    place: Option<PathBuf>,
    /// Removed if it is empty.
    folder: PathBuf,
    /// A copy: while it is removed, no other process takes it.
    _lock: File,
}

/// The number of an entry in the list, taken out when this is dropped.
#[derive(Debug)]
pub(crate) struct OwnFiles(usize);

impl OwnFiles {
    /// Notes files and a place, in a folder that goes with the last of them; `lock` is that of
    /// their owner. `None` if there is no more room in the list, or no file descriptor.
    pub(crate) fn note(
        files: &[PathBuf],
        place: Option<&Path>,
        folder: &Path,
        lock: &File,
    ) -> Option<Self> {
        let entry = Box::into_raw(Box::new(Entry {
            files: files.to_vec(),
            place: place.map(Path::to_owned),
            folder: folder.to_owned(),
            _lock: lock.try_clone().ok()?,
        }));
        let taken = |slot: &AtomicPtr<Entry>| {
            let free = ptr::null_mut();
            slot.compare_exchange(free, entry, Ordering::AcqRel, Ordering::Relaxed).is_ok()
        };
        let number = SLOTS.iter().position(taken);
        if number.is_none() {
            // SAFETY: made above, and in no slot.
            drop(unsafe { Box::from_raw(entry) });
        }
        number.map(Self)
    }
}

impl Drop for OwnFiles {
    fn drop(&mut self) {
        drop(SLOTS.get(self.0).and_then(take));
    }
}

/// What stands in a slot, which is free then.
fn take(slot: &AtomicPtr<Entry>) -> Option<Box<Entry>> {
    let entry = slot.swap(ptr::null_mut(), Ordering::AcqRel);
    // SAFETY: only what `Box` made is ever put into a slot, and only who swaps it out has it.
    (!entry.is_null()).then(|| unsafe { Box::from_raw(entry) })
}

/// Removes the files of this process's places, and the places that no other process has entered:
/// for a process that ends by force, right after it killed its children.
///
/// It neither waits for a lock nor calls iceoryx2, and takes at most 0.2 s for each run of a
/// coordinator. Places with a guest stay for the next run to remove.
pub fn remove_own_files() {
    let entries: Vec<Box<Entry>> = SLOTS.iter().filter_map(take).collect();
    for entry in &entries {
        for file in &entry.files {
            let _for_people = fs::remove_file(file);
        }
        if let Some(place) = &entry.place {
            let _left_for_the_next_run = sweep::remove(place, LOOKS);
        }
    }
    for entry in &entries {
        remove_if_empty(&entry.folder);
    }
    remove_if_empty(&default_folder());
    // What is freed may belong to a region of the heap whose lock somebody holds; the locks of the
    // files are the kernel's, and last as long as the process.
    let _leaked = entries.leak();
}
