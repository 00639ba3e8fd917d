//! The crew of a service: between two requests it sleeps on the same epoll as within them, and
//! while it works somebody looks after those who wait.

use super::{Crew, CrewError};
use core::fmt;
use runtime::Wake;
use std::os::fd::BorrowedFd;

/// Called again and again while a request is worked on: whenever the coordinator was about to
/// sleep, and at least each 20 ms.
pub struct Attendant(Box<dyn FnMut()>);

impl Attendant {
    /// It must be quick: a worker may be waiting.
    pub fn new(attend: impl FnMut() + 'static) -> Self {
        Self(Box::new(attend))
    }

    pub(super) fn attend(&mut self) {
        (self.0)();
    }
}

impl fmt::Debug for Attendant {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Attendant")
    }
}

/// The key of the service's bell, apart from those of the workers.
const BELL: u32 = u32::MAX;

impl Crew {
    /// Ends sleeps whenever this descriptor can be read; the caller reads it empty.
    ///
    /// # Errors
    ///
    /// If file descriptors ran out.
    pub fn listen(&mut self, bell: BorrowedFd<'_>, attendant: Attendant) -> Result<(), CrewError> {
        self.poller.add_fd(bell, BELL)?;
        self.attendant = Some(attendant);
        Ok(())
    }

    /// Sleeps until the bell rings or a worker ends, at most so long; 0: looks, and does not sleep.
    ///
    /// # Errors
    ///
    /// [`CrewError::Interrupted`] if a signal came.
    pub fn idle(&mut self, timeout_ns: u64) -> Result<(), CrewError> {
        for wake in self.poller.wait(Some(timeout_ns))? {
            match wake {
                Wake::Process(worker) => self.ended.push(worker as usize),
                Wake::Signal(_) => return Err(CrewError::Interrupted),
                Wake::Event(_) | Wake::Ready(_) | Wake::Timer => {}
            }
        }
        Ok(())
    }

    /// Workers that there should be.
    #[must_use]
    pub fn size(&self) -> usize {
        self.stations.len()
    }

    /// Workers that are gone, and not replaced.
    #[must_use]
    pub fn missing(&self) -> usize {
        let gone = |(number, station): (usize, &super::Station)| {
            !station.is_alive() || self.ended.contains(&number)
        };
        self.stations.iter().enumerate().filter(|station| gone(*station)).count()
    }
}
