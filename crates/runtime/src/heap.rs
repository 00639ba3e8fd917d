//! An allocator that counts: the system's, and a number per thread.
//!
//! ```
//! # use trolley_runtime::heap::{Counting, allocations};
//! #[global_allocator]
//! static HEAP: Counting = Counting;
//!
//! let before = allocations();
//! drop(Box::new([1_u8; 100]));
//! assert_eq!(allocations() - before, 1);
//! ```

use core::cell::Cell;
use std::alloc::{GlobalAlloc, Layout, System};

/// The system's allocator, with a count of what each thread asks of it.
#[derive(Clone, Copy, Debug, Default)]
pub struct Counting;

thread_local! {
    // Without a destructor and made when compiling: to touch it never allocates.
    static COUNT: Cell<u64> = const { Cell::new(0) };
}

/// How often the calling thread has asked for memory: new or larger. It stays at 0 if [`Counting`]
/// is not the program's allocator.
#[must_use]
pub fn allocations() -> u64 {
    COUNT.try_with(Cell::get).unwrap_or(0)
}

fn count() {
    // A thread that is ending counts no more.
    let _gone = COUNT.try_with(|count| count.set(count.get() + 1));
}

// SAFETY: every call goes to the system's allocator as it came.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count();
        // SAFETY: the caller keeps to the contract of this very call.
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        count();
        // SAFETY: as above.
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn dealloc(&self, place: *mut u8, layout: Layout) {
        // SAFETY: as above; the place came from the system's allocator, through this one.
        unsafe { System.dealloc(place, layout) }
    }

    unsafe fn realloc(&self, place: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        count();
        // SAFETY: as above.
        unsafe { System.realloc(place, layout, size) }
    }
}
