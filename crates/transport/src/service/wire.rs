//! The public structs as iceoryx2 carries them: this crate gives it the promise that `protocol`
//! cannot, and the name under which every language knows them.

use bytemuck::{Pod, Zeroable};
use core::fmt::Debug;
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

wire!(Ask, public::Ask, "trolley.Ask.v1");
wire!(WireAnswer, public::WireAnswer, "trolley.Answer.v1");
wire!(Health, public::Health, "trolley.Health.v1");

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
