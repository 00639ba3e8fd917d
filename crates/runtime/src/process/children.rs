//! The children of this process that live, for a thread that must end them without waiting for
//! any lock: see [`guard`](crate::guard).

use core::sync::atomic::{AtomicI32, Ordering};
use std::os::fd::{AsRawFd, OwnedFd};

/// What stands in a slot that is free.
const FREE: i32 = -1;
/// The pidfds of children. One for which there is no slot left is not in it: it dies with the
/// thread that spawned it, as each does.
static PIDFDS: [AtomicI32; 128] = [const { AtomicI32::new(FREE) }; 128];

/// Adds a child.
pub(crate) fn note(pidfd: &OwnedFd) {
    exchange(FREE, pidfd.as_raw_fd());
}

/// Takes a child out, before its pidfd is closed.
pub(crate) fn forget(pidfd: &OwnedFd) {
    exchange(pidfd.as_raw_fd(), FREE);
}

fn exchange(from: i32, to: i32) {
    let exchanged = |slot: &AtomicI32| {
        slot.compare_exchange(from, to, Ordering::AcqRel, Ordering::Relaxed).is_ok()
    };
    let _none_left = PIDFDS.iter().any(exchanged);
}

/// Sends SIGKILL to all of them. Waits for nothing.
pub(crate) fn kill_all() {
    for slot in &PIDFDS {
        let number = slot.load(Ordering::Acquire);
        if number == FREE {
            continue;
        }
        // SAFETY: the kernel looks the number up, and no memory is passed. If the descriptor was
        // closed meanwhile, the call fails, or finds another child: this process has pidfds of its
        // own children alone.
        unsafe {
            let nothing = core::ptr::null::<libc::siginfo_t>();
            libc::syscall(libc::SYS_pidfd_send_signal, number, libc::SIGKILL, nothing, 0);
        }
    }
}
