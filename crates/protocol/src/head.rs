//! The header in front of every message, and the checksum over both.
//!
//! | bytes | field | meaning |
//! |--:|---|---|
//! | 0 | magic, layout: u32 | what this is and which version of it |
//! | 8 | boot, request: u64 | which run, which request |
//! | 24 | inc, seq, job, len: u32 | incarnation; +1 per message; job or batch; payload words |
//! | 40 | part, count: u16 | part, from 0; jobs in a batch, 1 in the last part of a result |
//! | 44 | attempt, worker, kind, flags: u8 | of the job; of the worker's end; [`MessageKind`]; 0 |
//! | 48 | hits: u32, spare: u32 | hits in this part; 0 |
//! | 56 | crc: u64 | CRC-64/NVME over header (crc = 0) and payload |

use crate::id::{Boot, Incarnation, RequestId};
use bytemuck::{Pod, Zeroable};

/// "TRLY", little endian.
pub const MAGIC: u32 = u32::from_le_bytes(*b"TRLY");

/// The header of every message: one cache line.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct Head {
    /// [`MAGIC`].
    pub magic: u32,
    /// [`crate::LAYOUT`].
    pub layout: u32,
    /// The start of the coordinator.
    pub boot: u64,
    /// Request.
    pub request: u64,
    /// Incarnation of the worker at either end.
    pub inc: u32,
    /// Counted up by the sender.
    pub seq: u32,
    /// Job that this part belongs to; in a batch, the batch's number.
    pub job: u32,
    /// Payload, in 64-bit words.
    pub len: u32,
    /// Number of this part of a result, from 0.
    pub part: u16,
    /// Jobs in a batch; 1 in the last part of a result, else 0.
    pub count: u16,
    /// Attempt of the job.
    pub attempt: u8,
    /// Worker at either end.
    pub worker: u8,
    /// A [`MessageKind`].
    pub kind: u8,
    /// 0.
    pub flags: u8,
    /// Hits in this part of a result; pairs of nodes in a [`MessageKind::Rest`].
    pub hits: u32,
    /// 0.
    pub spare: u32,
    /// Checksum: see [`seal`].
    pub crc: u64,
}

const _: () = {
    assert!(size_of::<Head>() == 64);
    assert!(core::mem::offset_of!(Head, boot) == 8);
    assert!(core::mem::offset_of!(Head, crc) == 56);
};

/// The kind of a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum MessageKind {
    /// Jobs for a worker.
    Batch = 1,
    /// One part of the result of one job.
    Result = 2,
    /// A worker's first message: its results channel works.
    Hello = 3,
    /// A job that failed without killing the worker: a caught panic.
    Nack = 4,
    /// Pieces of bodies for a worker that copies.
    Section = 5,
    /// One part of what a job left open: sent like a part of its result, never the last.
    Rest = 6,
}

impl MessageKind {
    /// The kind with this number.
    #[must_use]
    pub fn from_number(number: u8) -> Option<Self> {
        [Self::Batch, Self::Result, Self::Hello, Self::Nack, Self::Section, Self::Rest]
            .into_iter()
            .find(|kind| *kind as u8 == number)
    }
}

/// Why a message was rejected.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, thiserror::Error)]
pub enum Reject {
    /// Another program, or another version of this one.
    #[error("foreign magic or layout")]
    Foreign,
    /// From an earlier run, or of an unknown kind.
    #[error("from another run")]
    Stale,
    /// The stated length does not match what arrived.
    #[error("stated length does not fit")]
    Length,
    /// The stated sender does not own the channel.
    #[error("sender is not the owner of the channel")]
    NotOwner,
    /// The checksum does not match.
    #[error("checksum does not fit")]
    Corrupt,
}

impl Head {
    /// Creates a header with everything zero except magic, layout, run, request, peer and kind.
    #[must_use]
    pub fn new(boot: Boot, request: RequestId, peer: Incarnation, kind: MessageKind) -> Self {
        Self {
            magic: MAGIC,
            layout: crate::LAYOUT,
            boot: boot.0,
            request: request.0,
            inc: peer.inc,
            worker: peer.worker,
            kind: kind as u8,
            ..Self::zeroed()
        }
    }

    /// The worker at its end of the channel, as stated by the sender.
    #[must_use]
    pub fn peer(&self) -> Incarnation {
        Incarnation { worker: self.worker, inc: self.inc }
    }

    /// Whether this is the last part of a result.
    #[must_use]
    pub fn is_last(&self) -> bool {
        self.count == 1
    }

    /// Checks everything that does not need the payload; `words` is what arrived.
    ///
    /// Call it on a copy: the value checked must be the value used.
    ///
    /// # Errors
    ///
    /// The check that failed.
    pub fn accept(
        &self,
        boot: Boot,
        peer: Incarnation,
        words: usize,
    ) -> Result<MessageKind, Reject> {
        if self.magic != MAGIC || self.layout != crate::LAYOUT {
            return Err(Reject::Foreign);
        }
        if self.boot != boot.0 {
            return Err(Reject::Stale);
        }
        if self.len as usize > words {
            return Err(Reject::Length);
        }
        if self.peer() != peer {
            return Err(Reject::NotOwner);
        }
        MessageKind::from_number(self.kind).ok_or(Reject::Foreign)
    }
}

fn checksum(head: &Head, payload: &[u64]) -> u64 {
    let mut digest = crc_fast::Digest::new(crc_fast::CrcAlgorithm::Crc64Nvme);
    digest.update(bytemuck::bytes_of(&Head { crc: 0, ..*head }));
    digest.update(bytemuck::cast_slice(payload));
    digest.finalize()
}

/// Writes length and checksum into the header. This must be the sender's last step.
#[must_use]
pub fn seal(head: Head, payload: &[u64]) -> Head {
    let head = Head { len: u32::try_from(payload.len()).unwrap_or(u32::MAX), ..head };
    Head { crc: checksum(&head, payload), ..head }
}

/// Verifies the checksum of a private copy.
///
/// # Errors
///
/// [`Reject::Length`] if the header states another length, [`Reject::Corrupt`] if a bit differs.
pub fn verify(head: &Head, payload: &[u64]) -> Result<(), Reject> {
    if head.len as usize != payload.len() {
        return Err(Reject::Length);
    }
    if checksum(head, payload) == head.crc { Ok(()) } else { Err(Reject::Corrupt) }
}

#[cfg(test)]
mod tests;
