//! Memory that was placed in advance costs no page fault. In a process of its own: nothing else
//! takes from the heap meanwhile.

#![cfg(target_env = "gnu")]

use std::hint::black_box;
use trolley_runtime::realtime::{page_faults, share_heap};

const BYTES: usize = 16 << 20;

/// Page faults of writing `bytes` bytes of the heap.
fn faults(bytes: usize) -> u64 {
    let (before, _) = page_faults();
    drop(black_box(vec![black_box(1_u8); bytes]));
    page_faults().0 - before
}

#[test]
fn what_the_heap_takes_soon_is_there_when_it_is_taken() {
    let soon = share_heap(BYTES);
    // By another thread, as it will be.
    std::thread::scope(|scope| scope.spawn(|| soon.place(BYTES / 2)).join()).expect("no panic");
    let placed = faults(BYTES / 4);
    // Large pages or small ones, the rest costs some.
    let rest = faults(BYTES - 4096);
    let again = faults(BYTES - 4096);
    assert!(rest > 0 && again == 0, "{rest} for the rest, {again} when it was used before");
    assert_eq!(placed, 0);
    // More than available does no harm.
    soon.place(usize::MAX);
}
