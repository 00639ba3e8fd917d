//! The header as iceoryx2 carries it, and the types of a service.

use crate::ipc::Ipc;
use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::prelude::ZeroCopySend;
use iceoryx2::service::port_factory::publish_subscribe::PortFactory;
use protocol::Head;

/// A [`Head`] as plain words: this crate gives iceoryx2 the promise that `protocol` cannot.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, ZeroCopySend)]
#[type_name("trolley.Head.v1")]
pub(crate) struct Wire {
    words: [u64; 8],
}

pub(crate) type Service = PortFactory<Ipc, [u64], Wire>;
pub(crate) type Output = Publisher<Ipc, [u64], Wire>;
pub(crate) type Input = Subscriber<Ipc, [u64], Wire>;

impl Wire {
    pub(crate) fn new(head: Head) -> Self {
        Self { words: bytemuck::cast(head) }
    }

    /// The header, read from shared memory once: what is checked is what is used, even if the
    /// sender writes meanwhile.
    pub(crate) fn read(&self) -> Head {
        let mut words = [0; 8];
        for (word, place) in words.iter_mut().zip(&self.words) {
            // SAFETY: a reference is valid for reads, and every bit pattern is a `u64`.
            *word = unsafe { core::ptr::read_volatile(place) };
        }
        bytemuck::cast(words)
    }
}
