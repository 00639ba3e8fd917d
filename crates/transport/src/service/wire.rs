//! The public structs as iceoryx2 carries them: this crate gives it the promise that `protocol`
//! cannot, and the name under which every language knows them.

use bytemuck::{Pod, Zeroable};
use core::fmt::Debug;
use core::mem::MaybeUninit;
use iceoryx2::prelude::ZeroCopySend;
use protocol::public;

macro_rules! wire {
    ($name:ident, $inner:ty, $known_as:literal) => {
        /// A public struct as it is transmitted.
        #[repr(transparent)]
        #[derive(Clone, Copy, Debug, Pod, Zeroable)]
        pub(super) struct $name(pub(super) $inner);

        // SAFETY: plain old data with a `repr(C)` layout that assertions pin; it holds no pointers.
        unsafe impl ZeroCopySend for $name {
            unsafe fn type_name() -> &'static str {
                $known_as
            }
        }
    };
}

wire!(Ask, public::Ask, "trolley.Ask.v3");
wire!(WireAnswer, public::WireAnswer, "trolley.Answer.v3");
wire!(Health, public::Health, "trolley.Health.v3");

/// Writes a request into memory that was lent for it: the bytes that count, and no others.
pub(super) fn write_used(lent: &mut MaybeUninit<Ask>, ask: &public::Ask) {
    let used = ask.used();
    // SAFETY: both are valid for that many bytes, which are part of one request, and of different
    // memory, since one is borrowed exclusively.
    unsafe { core::ptr::copy_nonoverlapping(used.as_ptr(), lent.as_mut_ptr().cast(), used.len()) };
}

/// Copies a request out of shared memory, as [`read_once`] does, into `copy`: the bytes that its
/// own count of states says are used.
pub(super) fn read_request(shared: &Ask, copy: &mut public::Ask) {
    const { assert!(public::Ask::BYTES_MIN.is_multiple_of(8)) };
    let words: &[u64] = bytemuck::cast_slice(core::slice::from_ref(&shared.0));
    let read = |copy: &mut public::Ask, from: usize, to: usize| {
        let places: &mut [u64] = bytemuck::cast_slice_mut(core::slice::from_mut(copy));
        for (place, word) in places[from..to].iter_mut().zip(&words[from..to]) {
            // SAFETY: a reference is valid for reads, and every bit pattern is a `u64`.
            *place = unsafe { core::ptr::read_volatile(word) };
        }
    };
    let head = public::Ask::BYTES_MIN / 8;
    read(copy, 0, head);
    let used = copy.used_bytes() / 8;
    read(copy, head, used);
}

/// Copies a value out of shared memory once, word by word: what is checked is what is used, even if
/// a peer writes meanwhile.
pub(super) fn read_once<T: Pod>(shared: &T) -> T {
    const { assert!(align_of::<T>() == 8 && size_of::<T>().is_multiple_of(8)) };
    let words: &[u64] = bytemuck::cast_slice(core::slice::from_ref(shared));
    let mut copy = T::zeroed();
    let places: &mut [u64] = bytemuck::cast_slice_mut(core::slice::from_mut(&mut copy));
    for (place, word) in places.iter_mut().zip(words) {
        // SAFETY: a reference is valid for reads, and every bit pattern is a `u64`.
        *place = unsafe { core::ptr::read_volatile(word) };
    }
    copy
}
