//! Checks a claim of the crate's header: once warm, sending and taking messages allocates nothing.
#![expect(unsafe_code, reason = "an allocator that counts is an allocator")]

use protocol::{Boot, Head, Incarnation, MessageKind, RequestId};
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use trolley_transport::{CoordinatorLink, Domain, Sizes, WorkerLink};

struct Counting;

thread_local! {
    /// Per thread: the test runner's own threads do not count.
    static ALLOCATIONS: Cell<u64> = const { Cell::new(0) };
}

// SAFETY: it is the system's allocator, and counting does not affect it.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // A thread that is ending no longer has a counter.
        let _gone = ALLOCATIONS.try_with(|count| count.set(count.get() + 1));
        // SAFETY: forwarded unchanged.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, place: *mut u8, layout: Layout) {
        // SAFETY: forwarded unchanged.
        unsafe { System.dealloc(place, layout) }
    }
}

#[global_allocator]
static HEAP: Counting = Counting;

const PEER: Incarnation = Incarnation { worker: 0, inc: 0 };
const SIZES: Sizes = Sizes { job_words: 64, job_queue: 4, result_words: 512, result_queue: 4 };

#[test]
fn a_thousand_round_trips_allocate_nothing() -> Result<(), Box<dyn std::error::Error>> {
    let domain = Domain::create(None, "h-loans", Boot(1))?;
    let coordinator = CoordinatorLink::create(&domain, PEER, &SIZES, "heap")?;
    let entered = Domain::open(domain.text())?;
    let worker = WorkerLink::open(&entered, PEER, &SIZES, "heap")?;
    coordinator.connect()?;
    let (mut jobs, mut results) = (Vec::with_capacity(64), Vec::with_capacity(512));
    let mut round = |request: u64| -> Result<(), Box<dyn std::error::Error>> {
        let head = |kind| Head::new(Boot(1), RequestId(request), PEER, kind);
        coordinator.jobs.loan()?.send(head(MessageKind::Batch), 64)?;
        assert!(worker.jobs.take(&mut jobs)?.is_some_and(|taken| taken.is_ok()));
        worker.results.loan()?.send(head(MessageKind::Result), 512)?;
        assert!(coordinator.results.take(&mut results)?.is_some_and(|taken| taken.is_ok()));
        Ok(())
    };
    round(0)?;
    let before = ALLOCATIONS.get();
    for request in 1..=1000 {
        round(request)?;
    }
    assert_eq!(ALLOCATIONS.get() - before, 0);
    Ok(())
}
