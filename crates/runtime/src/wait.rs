//! Waiting for many things at once: one epoll.
//!
//! | source | wakes when | reported |
//! |---|---|---|
//! | eventfd ([`Poller::add_event`]) | a peer rang it | again after each ring; emptied here |
//! | descriptor ([`Poller::add_fd`]) | it can be read | until its owner has read it empty |
//! | child ([`Poller::add_process`]) | it ended | once |
//! | timer ([`Poller::arm_ns`]) | its time came | once per arming |
//! | signals ([`Poller::catch_signals`]) | one came | each; with a [guard] always |
//!
//! Keys are the caller's, and separate for events and processes. A [`Poller`] holds copies of the
//! file descriptors, so dropping a child or an eventfd elsewhere neither wakes nor confuses it.

pub(crate) mod event;
pub(crate) mod signals;

pub use event::EventFd;

use crate::clock;
use crate::error::{OsError, Result};
use crate::guard;
use crate::process::Child;
use core::fmt;
use rustix::event::epoll::{self, EventData, EventFlags};
use rustix::event::{PollFd, PollFlags};
use rustix::io::Errno;
use rustix::time::{Itimerspec, TimerfdClockId, TimerfdFlags, TimerfdTimerFlags, Timespec};
use signals::Signals;
use std::collections::BTreeMap;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};

/// Most wake-ups that one call of [`Poller::wait`] reports; the rest come with the next one.
pub const WAKES_MAX: usize = 64;

/// Something happened.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Wake {
    /// The eventfd with this key was rung, once or more often.
    Event(u32),
    /// The descriptor with this key is readable; its owner must drain it.
    Ready(u32),
    /// The process with this key has ended and waits to be reaped.
    Process(u32),
    /// The time that was armed has come.
    Timer,
    /// This signal came.
    Signal(i32),
}

/// The result of one wait.
#[derive(Clone, Debug)]
pub struct Wakes {
    list: [Wake; WAKES_MAX],
    next: usize,
    len: usize,
}

impl Wakes {
    const NONE: Self = Self { list: [Wake::Timer; WAKES_MAX], next: 0, len: 0 };

    fn push(&mut self, wake: Wake) {
        if let Some(slot) = self.list.get_mut(self.len) {
            *slot = wake;
            self.len += 1;
        }
    }
}

impl Iterator for Wakes {
    type Item = Wake;

    fn next(&mut self) -> Option<Wake> {
        let wake = self.list.get(..self.len)?.get(self.next).copied()?;
        self.next += 1;
        Some(wake)
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Source {
    Event(u32),
    Ready(u32),
    Process(u32),
    Timer,
    Signals,
}

impl Source {
    fn pack(self) -> u64 {
        let (kind, key) = match self {
            Self::Event(key) => (0, key),
            Self::Process(key) => (1, key),
            Self::Timer => (2, 0),
            Self::Signals => (3, 0),
            Self::Ready(key) => (4, key),
        };
        kind << 32 | u64::from(key)
    }

    fn unpack(word: u64) -> Self {
        let key = (word & 0xffff_ffff) as u32;
        match word >> 32 {
            0 => Self::Event(key),
            1 => Self::Process(key),
            2 => Self::Timer,
            4 => Self::Ready(key),
            _ => Self::Signals,
        }
    }
}

/// Waits for eventfds, children, a timer and signals together.
pub struct Poller {
    epoll: OwnedFd,
    timer: OwnedFd,
    signals: Option<Signals>,
    /// Hears of signals from the guard.
    is_guarded: bool,
    watched: BTreeMap<Source, OwnedFd>,
    /// Kept, so that waiting allocates nothing.
    arrived: Vec<epoll::Event>,
}

impl Poller {
    /// Waits for nothing yet; the timer is not armed.
    ///
    /// # Errors
    ///
    /// If file descriptors ran out.
    pub fn new() -> Result<Self> {
        let epoll =
            epoll::create(epoll::CreateFlags::CLOEXEC).map_err(OsError::at("create", "epoll"))?;
        let flags = TimerfdFlags::CLOEXEC | TimerfdFlags::NONBLOCK;
        let timer = rustix::time::timerfd_create(TimerfdClockId::Monotonic, flags)
            .map_err(OsError::at("create", "timer"))?;
        let poller = Self {
            epoll,
            timer,
            signals: None,
            is_guarded: false,
            watched: BTreeMap::new(),
            arrived: Vec::with_capacity(WAKES_MAX),
        };
        poller.watch(poller.timer.as_fd(), Source::Timer, EventFlags::IN)?;
        Ok(poller)
    }

    /// Makes an eventfd, and wakes whenever it is rung. One under the same key is forgotten.
    ///
    /// # Errors
    ///
    /// If file descriptors ran out.
    pub fn add_event(&mut self, key: u32) -> Result<EventFd> {
        let event = EventFd::create()?;
        self.add(event.fd(), Source::Event(key), EventFlags::IN)?;
        Ok(event)
    }

    /// Wakes whenever a descriptor can be read, which is not done here. One under the same key is
    /// forgotten.
    ///
    /// # Errors
    ///
    /// If file descriptors ran out.
    pub fn add_fd(&mut self, fd: BorrowedFd<'_>, key: u32) -> Result<()> {
        self.add(fd, Source::Ready(key), EventFlags::IN)
    }

    /// Wakes, once, when the child ends. One under the same key is forgotten.
    ///
    /// # Errors
    ///
    /// If file descriptors ran out.
    pub fn add_process(&mut self, child: &Child, key: u32) -> Result<()> {
        // One shot: otherwise it would wake continually until the child is reaped and removed.
        self.add(child.pidfd(), Source::Process(key), EventFlags::IN | EventFlags::ONESHOT)
    }

    /// Forgets the eventfd with this key; nothing happens if there is none.
    pub fn remove_event(&mut self, key: u32) {
        self.remove(Source::Event(key));
    }

    /// Forgets the process with this key; nothing happens if there is none.
    pub fn remove_process(&mut self, key: u32) {
        self.remove(Source::Process(key));
    }

    /// Wakes at this time on CLOCK_MONOTONIC \[ns\], at once if it has passed; replaces an earlier
    /// arming.
    ///
    /// # Errors
    ///
    /// If the kernel refuses the time.
    pub fn arm_ns(&mut self, at_ns: u64) -> Result<()> {
        // Zero would switch the timer off.
        self.set_timer(clock::timespec(at_ns.max(1)))
    }

    /// Takes the arming back.
    ///
    /// # Errors
    ///
    /// If the kernel refuses.
    pub fn disarm(&mut self) -> Result<()> {
        self.set_timer(Timespec { tv_sec: 0, tv_nsec: 0 })
    }

    fn set_timer(&self, at: Timespec) -> Result<()> {
        let once = Itimerspec { it_interval: Timespec { tv_sec: 0, tv_nsec: 0 }, it_value: at };
        rustix::time::timerfd_settime(&self.timer, TimerfdTimerFlags::ABSTIME, &once)
            .map_err(OsError::at("set", "timer"))?;
        Ok(())
    }

    /// Reports SIGINT, SIGTERM, SIGQUIT and SIGHUP instead of dying of them, until the poller is
    /// dropped. All but SIGTERM stay ignored where they were: by nohup(1), or by a script's `&`.
    ///
    /// They are blocked in the calling thread and in the threads that it starts from now on. A
    /// thread that was started before still dies of them, and takes the process along: call this
    /// first. Children start with nothing blocked.
    ///
    /// In a process that has a [guard], that one owns the signals: all pollers hear
    /// from it that one came, and from then on every wait reports it.
    ///
    /// # Errors
    ///
    /// If file descriptors ran out.
    pub fn catch_signals(&mut self) -> Result<()> {
        if self.signals.is_some() || self.is_guarded {
            return Ok(());
        }
        if let Some(told) = guard::listen() {
            self.watch(told, Source::Signals, EventFlags::IN)?;
            self.is_guarded = true;
        } else {
            let signals = Signals::catch(&signals::ending())?;
            self.watch(signals.fd(), Source::Signals, EventFlags::IN)?;
            self.signals = Some(signals);
        }
        Ok(())
    }

    /// Waits until something happens, at most `timeout_ns` (`None`: forever, 0: not at all).
    ///
    /// An interruption ends the wait early, with nothing in it.
    ///
    /// # Errors
    ///
    /// If the kernel refuses, which would be a bug here.
    pub fn wait(&mut self, timeout_ns: Option<u64>) -> Result<Wakes> {
        let zero = clock::timespec(0);
        let mut timeout = None;
        if let Some(ns) = timeout_ns {
            // epoll_wait counts in milliseconds, and epoll_pwait2 is not everywhere; ppoll on the
            // epoll itself counts in nanoseconds and costs half a microsecond.
            timeout = Some(&zero);
            if ns > 0 {
                let mut fds = [PollFd::new(&self.epoll, PollFlags::IN)];
                match rustix::event::poll(&mut fds, Some(&clock::timespec(ns))) {
                    Ok(0) | Err(Errno::INTR) => return Ok(Wakes::NONE),
                    Ok(_) => {}
                    Err(source) => return Err(OsError::new("wait on", "epoll", source)),
                }
            }
        }
        self.arrived.clear();
        let room = rustix::buffer::spare_capacity(&mut self.arrived);
        match epoll::wait(&self.epoll, room, timeout) {
            Ok(_) | Err(Errno::INTR) => {}
            Err(source) => return Err(OsError::new("wait on", "epoll", source)),
        }
        Ok(self.collect())
    }

    fn collect(&self) -> Wakes {
        let mut wakes = Wakes::NONE;
        for event in &self.arrived {
            // A copy: the kernel's struct is packed.
            let data = event.data;
            match Source::unpack(data.u64()) {
                Source::Event(key) => {
                    if let Some(fd) = self.watched.get(&Source::Event(key))
                        && event::drain(fd.as_fd())
                    {
                        wakes.push(Wake::Event(key));
                    }
                }
                Source::Ready(key) => wakes.push(Wake::Ready(key)),
                Source::Process(key) => wakes.push(Wake::Process(key)),
                Source::Timer => {
                    if event::drain(self.timer.as_fd()) {
                        wakes.push(Wake::Timer);
                    }
                }
                Source::Signals => {
                    let taken = self.signals.as_ref().map_or_else(guard::told, Signals::take);
                    if let Some(number) = taken {
                        wakes.push(Wake::Signal(number));
                    }
                }
            }
        }
        wakes
    }

    fn add(&mut self, fd: BorrowedFd<'_>, source: Source, flags: EventFlags) -> Result<()> {
        self.remove(source);
        let own = rustix::io::fcntl_dupfd_cloexec(fd, 3)
            .map_err(OsError::at("copy", "file descriptor"))?;
        self.watch(own.as_fd(), source, flags)?;
        self.watched.insert(source, own);
        Ok(())
    }

    fn watch(&self, fd: BorrowedFd<'_>, source: Source, flags: EventFlags) -> Result<()> {
        epoll::add(&self.epoll, fd, EventData::new_u64(source.pack()), flags)
            .map_err(OsError::at("watch", "file descriptor"))
    }

    fn remove(&mut self, source: Source) {
        if let Some(fd) = self.watched.remove(&source)
            && let Err(error) = epoll::delete(&self.epoll, &fd)
        {
            tracing::warn!(?source, %error, "cannot stop watching");
        }
    }
}

impl fmt::Debug for Poller {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Poller").field("watched", &self.watched).finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests;
