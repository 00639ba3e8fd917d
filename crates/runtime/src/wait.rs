//! Waiting for everything at once: one epoll over bells, processes, a deadline and signals.

use crate::process::Child;
use crate::{Doing as _, OsError};
use rustix::event::epoll::{self, CreateFlags, Event, EventData, EventFlags};
use rustix::event::{EventfdFlags, Timespec, eventfd};
use std::os::fd::{AsFd, AsRawFd as _, BorrowedFd, FromRawFd as _, OwnedFd};

/// A bell that one process rings and another waits for.
#[derive(Debug)]
pub struct EventFd(OwnedFd);

impl EventFd {
    /// A new bell.
    ///
    /// # Errors
    ///
    /// If the system has no descriptor left.
    pub fn new() -> Result<Self, OsError> {
        let flags = EventfdFlags::CLOEXEC | EventfdFlags::NONBLOCK;
        eventfd(0, flags).map(Self).doing(|| "make an eventfd".to_owned())
    }

    /// A bell that was inherited.
    #[must_use]
    pub fn from_fd(fd: OwnedFd) -> Self {
        Self(fd)
    }

    /// Rings. A bell that rings already rings on.
    pub fn ring(&self) {
        let _rings_already = rustix::io::write(&self.0, &1_u64.to_ne_bytes());
    }

    /// Silences it.
    pub fn hush(&self) {
        let _was_silent = rustix::io::read(&self.0, &mut [0; 8]);
    }
}

impl AsFd for EventFd {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.0.as_fd()
    }
}

/// Takes an inherited descriptor.
///
/// # Errors
///
/// If it is not open.
pub fn inherited(number: i32) -> Result<OwnedFd, OsError> {
    // SAFETY: a system call on a number, which fails if nothing is open there.
    if unsafe { libc::fcntl(number, libc::F_SETFD, libc::FD_CLOEXEC) } < 0 {
        let error = std::io::Error::last_os_error();
        return Err(OsError::new(format!("take over descriptor {number}"), error));
    }
    // SAFETY: open, as was just seen, and given to this process for this purpose; each number is
    // taken once.
    Ok(unsafe { OwnedFd::from_raw_fd(number) })
}

/// What woke the sleeper.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wake {
    /// The bell with this key.
    Bell(u32),
    /// The process with this key has ended.
    Process(u32),
    /// SIGINT or SIGTERM came.
    Signal(i32),
}

const PROCESS: u64 = 1 << 32;
const SIGNAL: u64 = 1 << 33;

/// One place to sleep. While it lives, SIGINT and SIGTERM are its events on this thread.
#[derive(Debug)]
pub struct Poller {
    epoll: OwnedFd,
    signals: Option<Signals>,
}

impl Poller {
    /// Sleeps for bells and processes.
    ///
    /// # Errors
    ///
    /// If the system has no descriptor left.
    pub fn new() -> Result<Self, OsError> {
        let epoll = epoll::create(CreateFlags::CLOEXEC).doing(|| "make an epoll".to_owned())?;
        Ok(Self { epoll, signals: None })
    }

    /// Sleeps for SIGINT and SIGTERM too, which no longer end the process by themselves.
    ///
    /// # Errors
    ///
    /// If the system refuses.
    pub fn take_signals(&mut self) -> Result<(), OsError> {
        let signals = Signals::take()?;
        self.add(signals.fd.as_fd(), SIGNAL)?;
        self.signals = Some(signals);
        Ok(())
    }

    /// Adds a bell.
    ///
    /// # Errors
    ///
    /// If it is here already.
    pub fn add_bell(&self, bell: &EventFd, key: u32) -> Result<(), OsError> {
        self.add(bell.as_fd(), u64::from(key))
    }

    /// Adds a process. Dropping the child takes it out again.
    ///
    /// # Errors
    ///
    /// If it is here already.
    pub fn add_process(&self, child: &Child, key: u32) -> Result<(), OsError> {
        self.add(child.as_fd(), PROCESS | u64::from(key))
    }

    fn add(&self, fd: BorrowedFd<'_>, key: u64) -> Result<(), OsError> {
        epoll::add(&self.epoll, fd, EventData::new_u64(key), EventFlags::IN)
            .doing(|| format!("wait for descriptor {}", fd.as_raw_fd()))
    }

    /// Takes a process out: it has been buried.
    pub fn remove_process(&self, child: &Child) {
        let _was_out = epoll::delete(&self.epoll, child);
    }

    /// Sleeps until something happens, at most so long; what happened is put into `wakes`.
    ///
    /// # Errors
    ///
    /// If the system refuses.
    pub fn wait(&self, timeout_ns: u64, wakes: &mut Vec<Wake>) -> Result<(), OsError> {
        wakes.clear();
        let timeout = Timespec {
            tv_sec: (timeout_ns / 1_000_000_000) as i64,
            tv_nsec: (timeout_ns % 1_000_000_000) as _,
        };
        let mut events = [Event { flags: EventFlags::empty(), data: EventData::new_u64(0) }; 32];
        let count = match epoll::wait(&self.epoll, &mut events[..], Some(&timeout)) {
            Ok(count) => count,
            Err(rustix::io::Errno::INTR) => 0,
            Err(error) => return Err(OsError::new("wait", error)),
        };
        for event in &events[..count] {
            let key = event.data.u64();
            if key == SIGNAL {
                wakes.extend(self.signals.as_ref().and_then(Signals::read).map(Wake::Signal));
            } else if key & PROCESS != 0 {
                wakes.push(Wake::Process(key as u32));
            } else {
                wakes.push(Wake::Bell(key as u32));
            }
        }
        Ok(())
    }
}

/// SIGINT and SIGTERM as something to read.
#[derive(Debug)]
struct Signals {
    fd: OwnedFd,
    before: libc::sigset_t,
}

impl Signals {
    fn take() -> Result<Self, OsError> {
        let failed =
            || OsError::new("take over SIGINT and SIGTERM", std::io::Error::last_os_error());
        let mut set = core::mem::MaybeUninit::<libc::sigset_t>::uninit();
        let mut before = core::mem::MaybeUninit::<libc::sigset_t>::uninit();
        // SAFETY: fills the set it is given.
        unsafe { libc::sigemptyset(set.as_mut_ptr()) };
        for signal in [libc::SIGINT, libc::SIGTERM] {
            // SAFETY: the set was filled above.
            unsafe { libc::sigaddset(set.as_mut_ptr(), signal) };
        }
        // SAFETY: reads one set and fills the other.
        let code =
            unsafe { libc::pthread_sigmask(libc::SIG_BLOCK, set.as_ptr(), before.as_mut_ptr()) };
        if code != 0 {
            return Err(failed());
        }
        // SAFETY: reads the set, returns a new descriptor or -1.
        let fd =
            unsafe { libc::signalfd(-1, set.as_ptr(), libc::SFD_CLOEXEC | libc::SFD_NONBLOCK) };
        if fd < 0 {
            return Err(failed());
        }
        // SAFETY: filled by pthread_sigmask, which did not fail.
        let before = unsafe { before.assume_init() };
        // SAFETY: new, and nobody else's.
        let fd = unsafe { OwnedFd::from_raw_fd(fd) };
        Ok(Self { fd, before })
    }

    fn read(&self) -> Option<i32> {
        let mut info = [0_u8; size_of::<libc::signalfd_siginfo>()];
        let read = rustix::io::read(&self.fd, &mut info).ok()?;
        // The signal's number is the first field, a u32.
        (read == info.len()).then(|| i32::from_ne_bytes([info[0], info[1], info[2], info[3]]))
    }
}

impl Drop for Signals {
    fn drop(&mut self) {
        // SAFETY: restores the mask that `take` read on this thread; nothing is written.
        unsafe {
            libc::pthread_sigmask(libc::SIG_SETMASK, &raw const self.before, std::ptr::null_mut())
        };
    }
}

#[cfg(test)]
mod tests;
