//! Who does the work: a crew of worker processes, in which whoever is lost has a successor, or, for
//! comparison and for machines with a single core, this process itself.

use body::{BodyView, Meta};
use coordinator::{Attendant, Backend, Crew, CrewError, InProcessExecutor, Mended, Options, Share};
use runtime::{OsError, Poller, SealedMemory, Wake};
use std::os::fd::BorrowedFd;

/// What wakes this process while it has no crew.
const BELL: u32 = 0;

/// The workers, or what stands in their place.
pub(crate) struct Team<'s> {
    /// Where this process sleeps while it has no crew.
    guard: Poller,
    pub(crate) backend: Backend,
    store: &'s SealedMemory,
}

/// A signal came.
#[derive(Debug)]
pub(crate) struct Interrupted;

impl<'s> Team<'s> {
    /// Starts the workers; `None` for options: all work is done here.
    pub(crate) fn start(
        (store, bodies): (&'s SealedMemory, &'s [(Meta, BodyView<'s>)]),
        options: Option<&Options>,
        bell: BorrowedFd<'_>,
        attendant: Attendant,
    ) -> Result<Self, CrewError> {
        let mut guard = Poller::new()?;
        guard.catch_signals()?;
        guard.add_fd(bell, BELL)?;
        let backend = match options {
            Some(options) => {
                let mut crew = Crew::start(store, options)?;
                crew.listen(bell, attendant)?;
                Backend::Workers(Box::new(crew))
            }
            None => Backend::InProcess(Box::new(InProcessExecutor::with_room_for(bodies))),
        };
        Ok(Self { guard, backend, store })
    }

    /// Gives successors to those who were lost, and does not wait for them.
    pub(crate) fn mend(&mut self) -> Result<Mended, CrewError> {
        let store = self.store;
        self.backend.crew_mut().map_or_else(|| Ok(Mended::default()), |crew| crew.mend(store))
    }

    /// Process ids of the workers.
    pub(crate) fn pids(&self) -> Vec<u32> {
        self.backend.crew().map(Crew::pids).unwrap_or_default()
    }

    /// Workers that there should be.
    pub(crate) fn size(&self) -> usize {
        self.backend.crew().map_or(0, Crew::size)
    }

    /// Workers that are gone.
    pub(crate) fn missing(&self) -> usize {
        self.backend.crew().map_or(0, Crew::missing)
    }

    /// What each worker did for the last request.
    pub(crate) fn shares(&self) -> impl Iterator<Item = Share> {
        self.backend.shares()
    }

    /// Sleeps until somebody rings, a worker ends or a signal comes, at most so long; 0: looks.
    pub(crate) fn idle(&mut self, timeout_ns: u64) -> Result<Option<Interrupted>, OsError> {
        if let Some(crew) = self.backend.crew_mut() {
            return match crew.idle(timeout_ns) {
                Ok(()) => Ok(None),
                Err(CrewError::System(error)) => Err(error),
                Err(_) => Ok(Some(Interrupted)),
            };
        }
        let mut wakes = self.guard.wait(Some(timeout_ns))?;
        Ok(wakes.any(|wake| matches!(wake, Wake::Signal(_))).then_some(Interrupted))
    }
}
