//! Signals as something to wait for: blocked, and read from a signalfd.

use crate::error::{OsError, Result};
use core::marker::PhantomData;
use core::mem::MaybeUninit;
use core::ptr;
use core::sync::atomic::{AtomicBool, Ordering};
use std::io;
use std::os::fd::{AsFd, BorrowedFd, FromRawFd, OwnedFd};

/// Length of what a signalfd gives per signal.
const INFO_LEN: usize = size_of::<libc::signalfd_siginfo>();

/// Whether this process was told to end, whichever of its [`Signals`] received it.
static TOLD: AtomicBool = AtomicBool::new(false);

/// Blocks some signals in this thread for as long as it lives, and permanently once one of them was
/// taken: a process that is ending must not be interrupted by a second signal.
#[derive(Debug)]
pub(crate) struct Signals {
    fd: OwnedFd,
    before: Mask,
    /// The mask belongs to a thread, so this must be dropped where it was made.
    here: PhantomData<*const ()>,
}

struct Mask(libc::sigset_t);

impl core::fmt::Debug for Mask {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("Mask")
    }
}

impl Signals {
    pub(crate) fn catch(numbers: &[i32]) -> Result<Self> {
        let mask = mask_of(numbers);
        // SAFETY: `mask` is a set; -1 asks for a new descriptor.
        let fd =
            unsafe { libc::signalfd(-1, &raw const mask, libc::SFD_CLOEXEC | libc::SFD_NONBLOCK) };
        if fd < 0 {
            return Err(OsError::new("create", "signalfd", io::Error::last_os_error()));
        }
        // SAFETY: the kernel has just made it, and nothing else owns it.
        let fd = unsafe { OwnedFd::from_raw_fd(fd) };
        let mut before = mask_of(&[]);
        // SAFETY: both are sets, and the second may be written.
        let done =
            unsafe { libc::pthread_sigmask(libc::SIG_BLOCK, &raw const mask, &raw mut before) };
        if done != 0 {
            return Err(OsError::new("block", "signals", io::Error::from_raw_os_error(done)));
        }
        Ok(Self { fd, before: Mask(before), here: PhantomData })
    }

    pub(crate) fn fd(&self) -> BorrowedFd<'_> {
        self.fd.as_fd()
    }

    /// The next signal that came, if one did.
    pub(super) fn take(&self) -> Option<i32> {
        take(self.fd())
    }
}

/// The next signal that came to a signalfd, if one did.
pub(crate) fn take(fd: BorrowedFd<'_>) -> Option<i32> {
    let mut info = [0_u8; INFO_LEN];
    let got = rustix::io::read(fd, &mut info).ok()?;
    let number = info.first_chunk::<4>().filter(|_| got == INFO_LEN)?;
    TOLD.store(true, Ordering::Relaxed);
    i32::try_from(u32::from_ne_bytes(*number)).ok()
}

/// The signals that end a process: SIGTERM, and SIGINT, SIGQUIT and SIGHUP unless they were
/// inherited as ignored, as by nohup(1), or by what a script starts with `&`.
pub(crate) fn ending() -> Vec<i32> {
    let asked = [libc::SIGINT, libc::SIGQUIT, libc::SIGHUP];
    let heard = asked.into_iter().filter(|number| !is_ignored(*number));
    heard.chain([libc::SIGTERM]).collect()
}

impl Drop for Signals {
    fn drop(&mut self) {
        if TOLD.load(Ordering::Relaxed) {
            return;
        }
        // SAFETY: `before` is the set that the kernel gave in `catch`; the old is not asked for.
        unsafe {
            libc::pthread_sigmask(libc::SIG_SETMASK, &raw const self.before.0, ptr::null_mut());
        }
    }
}

/// Whether this process ignores a signal.
fn is_ignored(number: i32) -> bool {
    let mut action = MaybeUninit::<libc::sigaction>::zeroed();
    // SAFETY: without a new action it only writes the present one, for which there is room.
    let got = unsafe { libc::sigaction(number, ptr::null(), action.as_mut_ptr()) };
    // SAFETY: written by the call above, and all zeros is an action, too.
    got == 0 && unsafe { action.assume_init() }.sa_sigaction == libc::SIG_IGN
}

fn mask_of(numbers: &[i32]) -> libc::sigset_t {
    let mut set = MaybeUninit::<libc::sigset_t>::uninit();
    // SAFETY: `set` is a place for a set, and this call writes all of it.
    unsafe { libc::sigemptyset(set.as_mut_ptr()) };
    for number in numbers {
        // SAFETY: `set` is a set since the call above; a bad number gives an error and no change.
        unsafe { libc::sigaddset(set.as_mut_ptr(), *number) };
    }
    // SAFETY: written by `sigemptyset`.
    unsafe { set.assume_init() }
}
