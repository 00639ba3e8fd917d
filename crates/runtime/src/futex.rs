//! Sleeping on a word of shared memory until somebody changes it.

use core::sync::atomic::{AtomicU32, Ordering};
use rustix::thread::futex::{self, Flags, Timespec};

/// Sleeps while `word` is `expected`, at most `timeout_ns`. May wake for no reason.
pub fn wait(word: &AtomicU32, expected: u32, timeout_ns: u64) {
    let timeout = Timespec {
        tv_sec: (timeout_ns / 1_000_000_000) as i64,
        tv_nsec: (timeout_ns % 1_000_000_000) as _,
    };
    // Every way of returning means the same to the caller: look again.
    let _woken = futex::wait(word, Flags::empty(), expected, Some(&timeout));
}

/// Changes `word` and wakes whoever sleeps on it.
pub fn wake(word: &AtomicU32) {
    word.fetch_add(1, Ordering::SeqCst);
    let _count = futex::wake(word, Flags::empty(), u32::MAX >> 1);
}
