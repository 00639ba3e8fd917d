//! Who does the work: a crew of worker processes that is replaced when it has lost somebody, or,
//! for comparison and for machines with a single core, this process itself.

use coordinator::{Attendant, Crew, CrewError, CrewReport, Options, Work, run_here};
use model::{BodyView, Meta};
use runtime::{OsError, Poller, SealedMemory, Wake};
use std::os::fd::BorrowedFd;

/// What wakes this process while it has no crew.
const BELL: u32 = 0;

/// The workers, or what stands in their place.
pub(crate) struct Team<'s> {
    /// Before the crew, and longer than it: signals stay caught while a crew is replaced.
    guard: Poller,
    crew: Option<Crew>,
    store: &'s SealedMemory,
    options: Option<&'s Options>,
    attend: Box<dyn Fn() -> Attendant + 's>,
}

/// A signal came.
#[derive(Debug)]
pub(crate) struct Interrupted;

impl<'s> Team<'s> {
    /// Starts the workers; `None` for options: all work is done here.
    pub(crate) fn start(
        store: &'s SealedMemory,
        options: Option<&'s Options>,
        bell: BorrowedFd<'_>,
        attend: impl Fn() -> Attendant + 's,
    ) -> Result<Self, CrewError> {
        let mut guard = Poller::new()?;
        guard.catch_signals()?;
        guard.add_fd(bell, BELL)?;
        let mut team = Self { guard, crew: None, store, options, attend: Box::new(attend) };
        team.renew(bell)?;
        Ok(team)
    }

    /// Ends the crew there is, and starts another.
    pub(crate) fn renew(&mut self, bell: BorrowedFd<'_>) -> Result<(), CrewError> {
        self.crew = None;
        let Some(options) = self.options else { return Ok(()) };
        let mut crew = Crew::start(self.store, options)?;
        crew.listen(bell, (self.attend)())?;
        self.crew = Some(crew);
        Ok(())
    }

    /// Process ids of the workers.
    pub(crate) fn pids(&self) -> Vec<u32> {
        self.crew.as_ref().map(Crew::pids).unwrap_or_default()
    }

    /// Workers that there should be.
    pub(crate) fn size(&self) -> usize {
        self.options.map_or(0, |options| options.cores.len())
    }

    /// Workers that are gone.
    pub(crate) fn missing(&self) -> usize {
        self.crew.as_ref().map_or(self.size(), Crew::missing)
    }

    /// Works a request off; the report of the crew, if there is one.
    pub(crate) fn run(
        &mut self,
        work: &mut Work<'_>,
        bodies: &[(Meta, BodyView<'_>)],
    ) -> Result<Option<CrewReport>, CrewError> {
        match (&mut self.crew, self.options) {
            (Some(crew), _) => crew.run(work).map(Some),
            (None, None) => {
                run_here(work, bodies);
                Ok(None)
            }
            (None, Some(_)) => Err(CrewError::NobodyLeft {
                open: 0,
                jobs: 0,
                lost: "all, and none could be started".to_owned(),
            }),
        }
    }

    /// Sleeps until somebody rings, a worker ends or a signal comes, at most so long; 0: looks.
    pub(crate) fn idle(&mut self, timeout_ns: u64) -> Result<Option<Interrupted>, OsError> {
        if let Some(crew) = &mut self.crew {
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
