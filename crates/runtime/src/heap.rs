//! An allocator that counts: the system's, and a number per thread. If the system has no memory,
//! it says so and ends the process with the exit code of resources that ran out, instead of an
//! abort with a trace: no part of the program could go on.
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
use diagnostic::FailureKind;
use std::alloc::{GlobalAlloc, Layout, System};

/// The system's allocator, with a count of what each thread asks of it.
#[derive(Clone, Copy, Debug, Default)]
pub struct Counting;

thread_local! {
    // Without a destructor and made when compiling: to touch it never allocates.
    static COUNT: Cell<u64> = const { Cell::new(0) };
    /// Whether whoever allocates here can go on without.
    static MAY_FAIL: Cell<bool> = const { Cell::new(false) };
}

/// Does something that can go on if it gets no memory, as with [`Vec::try_reserve`].
pub(crate) fn fallible<T>(work: impl FnOnce() -> T) -> T {
    let before = MAY_FAIL.with(|may| may.replace(true));
    let done = work();
    MAY_FAIL.with(|may| may.set(before));
    done
}

/// The place, if there is one.
fn found(place: *mut u8, bytes: usize) -> *mut u8 {
    if place.is_null() && !MAY_FAIL.try_with(Cell::get).unwrap_or(false) {
        out_of_memory(bytes);
    }
    place
}

/// Ends the process, without allocating anything.
#[cold]
fn out_of_memory(bytes: usize) -> ! {
    let mut digits = [0_u8; 20];
    let mut from = digits.len();
    let mut rest = bytes;
    for place in (0..digits.len()).rev() {
        from = place;
        digits[place] = b'0' + (rest % 10) as u8;
        rest /= 10;
        if rest == 0 {
            break;
        }
    }
    let parts: [&[u8]; 3] = [
        b"error: out of memory: memory allocation of ",
        &digits[from..],
        b" bytes failed\n  help: allow more (ulimit -v, the limits of a container), or make the \
          bodies smaller\n",
    ];
    for part in parts {
        // SAFETY: the part is memory of its length. If stderr is gone, nobody can be told.
        let _told = unsafe { libc::write(libc::STDERR_FILENO, part.as_ptr().cast(), part.len()) };
    }
    // SAFETY: it ends the process, and runs nothing that could need memory.
    unsafe { libc::_exit(i32::from(FailureKind::Resources.exit_code())) }
}

/// What the C library asks the system for if its heap has no room: M_TOP_PAD of malloc(3), and the
/// request.
const LEAST_GROWTH: usize = (128 << 10) + 4096;

/// Lets an abort end the process as allocations that fail do if there is no memory. The C library
/// itself takes some, as when a thread first uses a value that has a destructor, and aborts if it
/// gets none. Every other abort stays what it is.
///
/// ```
/// trolley_runtime::heap::explain_aborts();
/// ```
pub fn explain_aborts() {
    // SAFETY: all zeros is an action: no flags, no signal blocked meanwhile.
    let mut action: libc::sigaction = unsafe { core::mem::zeroed() };
    let handler: extern "C" fn(libc::c_int) = on_abort;
    action.sa_sigaction = handler as libc::sighandler_t;
    // The next such signal ends the process.
    action.sa_flags = libc::SA_RESETHAND;
    // SAFETY: the handler calls mmap, munmap, write, raise and _exit alone, which change nothing
    // that the interrupted code may be at; the old action is not asked for.
    let set = unsafe { libc::sigaction(libc::SIGABRT, &raw const action, core::ptr::null_mut()) };
    debug_assert_eq!(set, 0, "SIGABRT is a signal that can be caught");
}

/// If there is memory, the signal comes again, whoever sent it, and does what it does without a
/// handler.
extern "C" fn on_abort(number: libc::c_int) {
    let kind = libc::MAP_PRIVATE | libc::MAP_ANONYMOUS;
    let rights = libc::PROT_READ | libc::PROT_WRITE;
    // SAFETY: a new mapping, wherever there is room, that nobody else knows of.
    let place = unsafe { libc::mmap(core::ptr::null_mut(), LEAST_GROWTH, rights, kind, -1, 0) };
    if place == libc::MAP_FAILED {
        out_of_memory(LEAST_GROWTH);
    }
    // SAFETY: the mapping made above, which nothing points into.
    let _gone = unsafe { libc::munmap(place, LEAST_GROWTH) };
    // SAFETY: the signal has no handler any more, and is blocked until this one returns.
    let _raised = unsafe { libc::raise(number) };
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
        found(unsafe { System.alloc(layout) }, layout.size())
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        count();
        // SAFETY: as above.
        found(unsafe { System.alloc_zeroed(layout) }, layout.size())
    }

    unsafe fn dealloc(&self, place: *mut u8, layout: Layout) {
        // SAFETY: as above; the place came from the system's allocator, through this one.
        unsafe { System.dealloc(place, layout) }
    }

    unsafe fn realloc(&self, place: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        count();
        // SAFETY: as above.
        found(unsafe { System.realloc(place, layout, size) }, size)
    }
}
