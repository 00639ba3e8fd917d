//! What keeps a process from being late: memory that stays, a fixed priority, no page faults.
//!
//! Each is asked for, and each may be refused: by a limit, a container, or a missing right. What
//! was refused is said; whether that matters is for the caller to decide.

use crate::error::{OsError, Result};
use crate::heap;
use rustix::mm::MlockAllFlags;
use std::hint::black_box;

/// Stack that is touched in advance (bytes).
const STACK: usize = 512 * 1024;
/// A page (bytes); larger ones are touched more often than needed.
const PAGE: usize = 4096;

/// Keeps all memory of this process in place, what it has and what it will get.
///
/// Memory that is mapped later is taken at once: running out shows when it is mapped.
///
/// # Errors
///
/// If the limit on locked memory (RLIMIT_MEMLOCK) is too low and there is no CAP_IPC_LOCK.
pub fn lock_memory() -> Result<()> {
    rustix::mm::mlockall(MlockAllFlags::CURRENT | MlockAllFlags::FUTURE)
        .map_err(OsError::at("lock", "memory"))
}

/// Gives a process, or the calling thread (pid 0), SCHED_FIFO with this priority, 1 to 99.
///
/// # Errors
///
/// If the limit on priority (RLIMIT_RTPRIO) is too low and there is no CAP_SYS_NICE.
pub fn fifo(pid: u32, priority: i32) -> Result<()> {
    let parameters = libc::sched_param { sched_priority: priority };
    let pid = i32::try_from(pid).unwrap_or(i32::MAX);
    // SAFETY: `parameters` is valid for reads; a wrong pid or priority is an error.
    let done = unsafe { libc::sched_setscheduler(pid, libc::SCHED_FIFO, &raw const parameters) };
    if done == 0 {
        return Ok(());
    }
    let error = std::io::Error::last_os_error();
    Err(OsError::new(
        "set SCHED_FIFO for",
        if pid == 0 { "us".into() } else { pid.to_string() },
        error,
    ))
}

/// Lets the heap keep what it got, and touches so many bytes of it and some stack: what is asked
/// for later within these bounds costs no page fault.
pub fn prefault(heap_bytes: usize) {
    keep_heap();
    let mut heap = vec![0_u8; heap_bytes];
    for page in heap.chunks_mut(PAGE) {
        page[0] = black_box(1);
    }
    drop(black_box(heap));
    touch_stack();
}

/// Makes every page present and writable: those that a fork has left marked to be copied when they
/// are written, and those of channels that are new. After a process was started, each would cost a
/// page fault at its first use.
///
/// # Errors
///
/// If the system does not say what is mapped. A kernel that cannot do it (before 5.14) is none.
pub fn unshare_after_fork() -> Result<()> {
    let maps = std::fs::read_to_string("/proc/self/maps")
        .map_err(OsError::at("read", "/proc/self/maps"))?;
    for line in maps.lines() {
        let mut words = line.split(' ');
        let (Some(range), Some("rw-p" | "rw-s")) = (words.next(), words.next()) else {
            continue;
        };
        let Some((start, end)) = range.split_once('-') else { continue };
        let number = |text: &str| usize::from_str_radix(text, 16).ok();
        let (Some(start), Some(end)) = (number(start), number(end)) else { continue };
        populate(start, end.saturating_sub(start));
    }
    Ok(())
}

/// Makes `len` bytes from this page on present and writable, as far as they are mapped.
fn populate(start: usize, bytes: usize) {
    let pages = core::ptr::with_exposed_provenance_mut(start);
    let advice = rustix::mm::Advice::LinuxPopulateWrite;
    // SAFETY: it changes no content; what is not mapped is an error that changes nothing.
    let _refused = unsafe { rustix::mm::madvise(pages, bytes, advice) };
}

#[inline(never)]
fn touch_stack() {
    let mut stack = [0_u8; STACK];
    for page in stack.chunks_mut(PAGE) {
        page[0] = black_box(1);
    }
    black_box(&stack);
}

/// No memory goes back to the kernel, and none comes from it in pieces of its own.
fn keep_heap() {
    #[cfg(target_env = "gnu")]
    [(libc::M_TRIM_THRESHOLD, -1), (libc::M_MMAP_MAX, 0)].into_iter().for_each(tune);
}

/// From now on the heap keeps what it got, and all threads share it: memory that was freed is used
/// again without a page fault. For work in which threads seldom allocate, since they wait for each
/// other there. What the heap takes from the system next, up to `soon` bytes, is in large pages
/// where the system has them. It does nothing where the C library is not GNU's. Returns where those
/// bytes will be.
#[must_use]
pub fn share_heap(soon: usize) -> Soon {
    if !cfg!(target_env = "gnu") {
        return Soon::default();
    }
    keep_heap();
    #[cfg(target_env = "gnu")]
    tune((libc::M_ARENA_MAX, 1));
    let mut room: Vec<u8> = Vec::new();
    if heap::fallible(|| room.try_reserve_exact(soon)).is_err() {
        return Soon::default();
    }
    // The advice stays with the addresses when they are freed, and the heap keeps those.
    large_pages(room.spare_capacity_mut());
    Soon { start: room.as_ptr().expose_provenance().next_multiple_of(PAGE), bytes: soon }
}

/// What the heap takes soon.
#[derive(Clone, Copy, Debug, Default)]
pub struct Soon {
    /// A page.
    start: usize,
    bytes: usize,
}

impl Soon {
    /// Puts memory where the heap will take its next bytes, at most so many, for all threads: for
    /// one that waits while another goes on. Clearing it takes longer than asking for it. It is
    /// left undone by kernels before 5.14.
    pub fn place(self, bytes: usize) {
        populate(self.start, bytes.min(self.bytes));
    }
}

#[cfg(target_env = "gnu")]
fn tune((what, value): (libc::c_int, libc::c_int)) {
    // SAFETY: sets a number of the allocator, under its lock.
    let _refused = unsafe { libc::mallopt(what, value) };
}

/// Asks for large pages under memory that has not been written yet: what is then read here and
/// there takes fewer walks through page tables. The system may have none, and nothing else changes.
pub fn large_pages<T>(memory: &mut [T]) {
    let skipped = memory.as_ptr().align_offset(PAGE).min(memory.len());
    let whole = &mut memory[skipped..];
    let advice = rustix::mm::Advice::LinuxHugepage;
    let bytes = size_of_val(whole);
    // SAFETY: it changes no content, and the memory is ours alone.
    let _refused = unsafe { rustix::mm::madvise(whole.as_mut_ptr().cast(), bytes, advice) };
}

/// Page faults of the calling thread since it started: those that needed no disk, and those that
/// did.
#[must_use]
pub fn page_faults() -> (u64, u64) {
    // SAFETY: all zeros is a valid `rusage`.
    let mut usage: libc::rusage = unsafe { core::mem::zeroed() };
    // SAFETY: `usage` may be written.
    let done = unsafe { libc::getrusage(libc::RUSAGE_THREAD, &raw mut usage) };
    if done != 0 {
        return (0, 0);
    }
    (usage.ru_minflt.unsigned_abs(), usage.ru_majflt.unsigned_abs())
}

/// Lets timers of the calling thread fire when they are due: the kernel's default is up to 50 µs
/// late.
pub fn sharpen_timers() {
    // SAFETY: sets a number of the calling thread.
    let _refused = unsafe { libc::prctl(libc::PR_SET_TIMERSLACK, 1_usize) };
}

/// The soft limits that matter here: locked memory, priority, descriptors, in bytes and numbers;
/// `None`: no limit.
#[must_use]
pub fn limits() -> [Option<u64>; 3] {
    use rustix::process::{Resource, getrlimit};
    [Resource::Memlock, Resource::Rtprio, Resource::Nofile].map(|what| getrlimit(what).current)
}

#[cfg(test)]
mod tests {
    //! What was touched in advance costs no fault.
    use super::*;

    /// Whether work has few page faults. Another test of this process may fork meanwhile, and each
    /// page is then copied once more: it adds faults, and takes none.
    fn has_few(mut faults: impl FnMut() -> u64) -> bool {
        (0..50).any(|_| faults() < 64)
    }

    #[test]
    fn a_prefaulted_heap_costs_no_page_fault() {
        prefault(4 << 20);
        // Warm: the allocator's own pages, and this function's.
        drop(black_box(vec![1_u8; 1 << 20]));
        let after_ten = || {
            let before = page_faults().0;
            for _ in 0..10 {
                let mut bytes = vec![0_u8; 1 << 20];
                for page in bytes.chunks_mut(PAGE) {
                    page[0] = black_box(1);
                }
                black_box(&bytes);
            }
            page_faults().0 - before
        };
        assert!(has_few(after_ten), "each time 64 faults or more for 2,560 pages");
    }

    #[test]
    fn a_process_that_was_started_costs_no_page_fault_afterwards() {
        let mut bytes = vec![1_u8; 4 << 20];
        let faults = |bytes: &mut [u8]| {
            let before = page_faults().0;
            bytes.chunks_mut(PAGE).for_each(|page| page[0] = black_box(2));
            page_faults().0 - before
        };
        faults(&mut bytes);
        let after_start = || {
            let mut child = std::process::Command::new("/bin/true");
            // SAFETY: the closure, which makes it a fork, does nothing.
            let child =
                unsafe { std::os::unix::process::CommandExt::pre_exec(&mut child, || Ok(())) };
            assert!(child.status().is_ok_and(|status| status.success()));
            assert!(unshare_after_fork().is_ok());
            faults(&mut bytes)
        };
        assert!(has_few(after_start), "each time 64 faults or more for 1,024 pages");
    }

    #[test]
    fn the_kernel_says_what_the_limits_are() {
        let [_, _, files] = limits();
        assert!(files.is_none_or(|files| files >= 64));
    }
}
