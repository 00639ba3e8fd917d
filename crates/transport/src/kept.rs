//! What iceoryx2 shares between a port and the messages that it lends, in memory that is kept.
//!
//! iceoryx2 0.10 makes one shared value per loan, through the policy of its service variant. Its
//! own policies take each from the heap. This one takes it from a list of places that earlier loans
//! of the same thread have left, so that a loan allocates nothing once as many were open at a time.
//!
//! As with iceoryx2's policy for one thread, nothing here can be sent to another one.

use core::alloc::Layout;
use core::cell::{Cell, RefCell};
use core::fmt::Debug;
use core::marker::PhantomData;
use core::ops::Deref;
use core::ptr::NonNull;
use iceoryx2_bb_elementary_traits::testing::abandonable::Abandonable;
use iceoryx2_cal::arc_sync_policy::{ArcSyncPolicy, ArcSyncPolicyCreationError, LockGuard};
use std::alloc::{alloc, dealloc, handle_alloc_error};

/// What is no larger is kept: the state of a loan has 40 bytes. A port's own state, made once, is
/// larger.
const PLACE: Layout = match Layout::from_size_align(128, 16) {
    Ok(layout) => layout,
    Err(_) => panic!("16 is a power of two"),
};
/// Maximum number of places that a thread keeps: far more loans than are open at a time.
const KEPT_MAX: usize = 64;

/// Places of this thread that nobody uses.
struct Places(RefCell<Vec<NonNull<u8>>>);

impl Drop for Places {
    fn drop(&mut self) {
        for place in self.0.get_mut().drain(..) {
            // SAFETY: it was allocated with this layout, and nobody else has it.
            unsafe { dealloc(place.as_ptr(), PLACE) };
        }
    }
}

thread_local! {
    static PLACES: Places = const { Places(RefCell::new(Vec::new())) };
}

/// Whether values of this layout are put into places that are kept.
const fn is_kept(layout: Layout) -> bool {
    layout.size() <= PLACE.size() && layout.align() <= PLACE.align()
}

/// A place for a value of this layout, which is not empty.
fn take(layout: Layout) -> NonNull<u8> {
    let kept = || PLACES.try_with(|places| places.0.borrow_mut().pop()).ok().flatten();
    if is_kept(layout)
        && let Some(place) = kept()
    {
        return place;
    }
    let layout = if is_kept(layout) { PLACE } else { layout };
    // SAFETY: the layout is not empty.
    let place = unsafe { alloc(layout) };
    NonNull::new(place).unwrap_or_else(|| handle_alloc_error(layout))
}

/// Gives back a place for a value of this layout.
///
/// # Safety
///
/// It comes from [`take`] with this layout, and is not used any more.
unsafe fn give_back(place: NonNull<u8>, layout: Layout) {
    if !is_kept(layout) {
        // SAFETY: it was allocated with this layout.
        unsafe { dealloc(place.as_ptr(), layout) };
        return;
    }
    let keep = |places: &Places| {
        let mut places = places.0.borrow_mut();
        let has_room = places.len() < KEPT_MAX;
        if has_room {
            places.push(place);
        }
        has_room
    };
    // A thread that is ending keeps nothing.
    if !PLACES.try_with(keep).unwrap_or(false) {
        // SAFETY: what is kept was allocated with this layout, by whichever thread.
        unsafe { dealloc(place.as_ptr(), PLACE) };
    }
}

/// A value, and how many share it.
struct Counted<T> {
    count: Cell<usize>,
    value: T,
}

/// A value that is shared within a thread, and lies in memory that is kept.
#[derive(Debug)]
pub(crate) struct Kept<T: Send + Debug + Abandonable> {
    counted: NonNull<Counted<T>>,
    owns: PhantomData<Counted<T>>,
}

impl<T: Send + Debug + Abandonable> Kept<T> {
    const LAYOUT: Layout = Layout::new::<Counted<T>>();

    fn counted(&self) -> &Counted<T> {
        // SAFETY: it was initialised by `new`, and lives until the last who shares it is dropped.
        unsafe { self.counted.as_ref() }
    }
}

impl<T: Send + Debug + Abandonable> Clone for Kept<T> {
    fn clone(&self) -> Self {
        let count = &self.counted().count;
        // It cannot overflow: there is no room for so many clones.
        count.set(count.get() + 1);
        Self { counted: self.counted, owns: PhantomData }
    }
}

impl<T: Send + Debug + Abandonable> Drop for Kept<T> {
    fn drop(&mut self) {
        let left = self.counted().count.get() - 1;
        self.counted().count.set(left);
        if left > 0 {
            return;
        }
        // SAFETY: nobody else has it, and it is dropped once.
        unsafe { self.counted.drop_in_place() };
        // SAFETY: its place comes from `take` with this layout.
        unsafe { give_back(self.counted.cast(), Self::LAYOUT) };
    }
}

impl<T: Send + Debug + Abandonable> Abandonable for Kept<T> {
    unsafe fn abandon_in_place(this: NonNull<Self>) {
        // SAFETY: the caller passes a value that it does not use again.
        let this = core::mem::ManuallyDrop::new(unsafe { this.read() });
        if this.counted().count.get() > 1 {
            // Others have it still.
            drop(core::mem::ManuallyDrop::into_inner(this));
            return;
        }
        let value = NonNull::from(&this.counted().value);
        // SAFETY: nobody else has the value, and it is not used again: its place is not given back,
        // as that of a process that dies.
        unsafe { T::abandon_in_place(value) };
    }
}

/// Access to a [`Kept`] value.
pub(crate) struct Guard<'k, T: Send + Debug + Abandonable> {
    kept: Kept<T>,
    of: PhantomData<&'k ()>,
}

impl<T: Send + Debug + Abandonable> Deref for Guard<'_, T> {
    type Target = T;

    fn deref(&self) -> &T {
        &self.kept.counted().value
    }
}

impl<'k, T: Send + Debug + Abandonable> LockGuard<'k, T> for Guard<'k, T> {}

impl<T: Send + Debug + Abandonable> ArcSyncPolicy<T> for Kept<T> {
    type LockGuard<'k>
        = Guard<'k, T>
    where
        Self: 'k,
        T: 'k;

    fn new(value: T) -> Result<Self, ArcSyncPolicyCreationError> {
        let counted: NonNull<Counted<T>> = take(Self::LAYOUT).cast();
        // SAFETY: the place is large enough and aligned for it, and nobody else has it.
        unsafe { counted.write(Counted { count: Cell::new(1), value }) };
        Ok(Self { counted, owns: PhantomData })
    }

    fn lock(&self) -> Guard<'_, T> {
        Guard { kept: self.clone(), of: PhantomData }
    }
}

#[cfg(test)]
mod tests {
    //! A value is dropped once, by the last who shares it, and its place serves the next.
    use super::*;
    use std::rc::Rc;
    use std::sync::atomic::{AtomicUsize, Ordering};

    /// Counts how often it is dropped or abandoned.
    #[derive(Debug)]
    struct Counts<const BYTES: usize> {
        dropped: &'static AtomicUsize,
        _bytes: [u8; BYTES],
    }

    impl<const BYTES: usize> Drop for Counts<BYTES> {
        fn drop(&mut self) {
            self.dropped.fetch_add(1, Ordering::Relaxed);
        }
    }

    impl<const BYTES: usize> Abandonable for Counts<BYTES> {
        unsafe fn abandon_in_place(this: NonNull<Self>) {
            // SAFETY: the caller passes a value that it does not use again.
            unsafe { this.as_ref() }.dropped.fetch_add(1_000, Ordering::Relaxed);
        }
    }

    fn counter() -> &'static AtomicUsize {
        Box::leak(Box::new(AtomicUsize::new(0)))
    }

    fn made<const BYTES: usize>(dropped: &'static AtomicUsize) -> Kept<Counts<BYTES>> {
        Kept::new(Counts { dropped, _bytes: [7; BYTES] }).unwrap()
    }

    fn last_dropped<const BYTES: usize>() {
        let dropped = counter();
        let first = made::<BYTES>(dropped);
        let shared: Vec<_> = (0..10).map(|_| first.clone()).collect();
        let guard = first.lock();
        assert_eq!(guard._bytes, [7; BYTES]);
        drop(guard);
        drop(first);
        assert_eq!(dropped.load(Ordering::Relaxed), 0);
        assert!(shared.iter().all(|one| one.lock()._bytes == [7; BYTES]));
        drop(shared);
        assert_eq!(dropped.load(Ordering::Relaxed), 1);
    }

    #[test]
    fn a_value_is_dropped_by_the_last_who_shares_it() {
        // Small enough to be kept, and not.
        last_dropped::<24>();
        last_dropped::<4096>();
    }

    #[test]
    fn a_place_serves_the_next_value() {
        let dropped = counter();
        let kept = || PLACES.with(|places| places.0.borrow().len());
        let first = made::<24>(dropped);
        let place = first.counted;
        drop(first);
        assert_eq!(kept(), 1);
        for _ in 0..100 {
            assert_eq!(made::<24>(dropped).counted, place);
        }
        let many: Vec<_> = (0..3 * KEPT_MAX).map(|_| made::<24>(dropped)).collect();
        assert_eq!(kept(), 0);
        drop(many);
        assert_eq!(kept(), KEPT_MAX, "no more are kept");
        drop(made::<4096>(dropped));
        assert_eq!(kept(), KEPT_MAX, "a large value has a place of its own");
    }

    #[test]
    fn what_is_abandoned_is_not_dropped_and_what_is_shared_lives_on() {
        let dropped = counter();
        let mut alone = core::mem::ManuallyDrop::new(made::<24>(dropped));
        // SAFETY: it is not used again.
        unsafe { Kept::abandon_in_place(NonNull::from(&mut *alone)) };
        assert_eq!(dropped.load(Ordering::Relaxed), 1_000);
        let dropped = counter();
        let first = made::<24>(dropped);
        let mut second = core::mem::ManuallyDrop::new(first.clone());
        // SAFETY: as above.
        unsafe { Kept::abandon_in_place(NonNull::from(&mut *second)) };
        assert_eq!(dropped.load(Ordering::Relaxed), 0);
        drop(first);
        assert_eq!(dropped.load(Ordering::Relaxed), 1);
    }

    /// Values may outlive what a thread keeps: other values of the thread are destroyed later.
    #[test]
    fn a_value_may_be_dropped_while_its_thread_ends() {
        thread_local! {
            static LATE: RefCell<Vec<Rc<Kept<Counts<24>>>>> = const { RefCell::new(Vec::new()) };
        }
        let dropped = counter();
        let ended = std::thread::spawn(move || {
            LATE.with(|late| late.borrow_mut().push(Rc::new(made(dropped))));
            drop(made::<24>(dropped));
        });
        ended.join().unwrap();
        assert_eq!(dropped.load(Ordering::Relaxed), 2);
    }
}
