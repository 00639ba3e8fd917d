//! Memory held back for the segments of a successor.
//!
//! Whoever may write to the file system of shared files may fill it. A worker that dies then could
//! not be replaced: its successor's segments are made before its predecessor's are gone, and what
//! these free may be taken by others. So a pool holds some memory in a file that has no name, lets
//! it go right before it starts a successor, and takes it again as soon as it can.
//!
//! Without a name it is gone with its process, however that ends.

use crate::domain::Domain;
use crate::error::OpenError;
use crate::link::Sizes;
use crate::segment::unnamed;
use std::fs::File;

/// What a link takes besides its chunks (bytes): queues, nodes, services, each file in whole pages.
/// Measured: 50 KiB (`link/tests.rs`), of 612 KiB with the engine's default queues. More than twice
/// that is held, because whole pages are taken, and some machines have larger ones.
const MANAGEMENT_BYTES: usize = 128 << 10;

impl Sizes {
    /// Segments of a link: of each of its channels a pool, a connection and what both ends have in
    /// common; and one of both nodes.
    pub const SEGMENTS: usize = 2 * 3 + 1;

    /// Bytes of shared memory that both ends of one link take, at most.
    #[must_use]
    pub fn link_bytes(&self) -> usize {
        self.pool_bytes().saturating_add(MANAGEMENT_BYTES)
    }
}

/// Memory that is held back.
#[derive(Debug)]
pub struct SegmentReserve {
    domain: Domain,
    bytes: usize,
    held: Option<File>,
}

impl SegmentReserve {
    /// For one link of these sizes. Nothing is held yet.
    #[must_use]
    pub fn new(domain: &Domain, sizes: &Sizes) -> Self {
        Self { domain: domain.clone(), bytes: sizes.link_bytes(), held: None }
    }

    /// Holds the memory; nothing happens if it does already.
    ///
    /// # Errors
    ///
    /// If there is no room now.
    pub fn hold(&mut self) -> Result<(), OpenError> {
        if self.held.is_some() {
            return Ok(());
        }
        let folder = self.domain.folder();
        let shown = folder.display().to_string();
        let file = unnamed(folder, self.bytes);
        self.held = Some(file.map_err(OpenError::at("hold memory for a successor in", &shown))?);
        Ok(())
    }

    /// Lets it go: at once there is room for a link.
    pub fn release(&mut self) {
        self.held = None;
    }
}

#[cfg(test)]
mod tests {
    //! What is held is taken, and what is released is there.
    use super::*;
    use protocol::Boot;
    use std::os::unix::fs::MetadataExt as _;

    const SIZES: Sizes = Sizes { job_words: 64, job_queue: 4, result_words: 1024, result_queue: 8 };

    #[test]
    fn memory_is_taken_while_it_is_held_and_leaves_no_name() {
        let domain = Domain::create(None, "reserve", Boot(1)).unwrap();
        let names = || std::fs::read_dir(domain.folder()).unwrap().count();
        let before = names();
        let mut reserve = SegmentReserve::new(&domain, &SIZES);
        for _ in 0..3 {
            reserve.hold().unwrap();
            let blocks = reserve.held.as_ref().unwrap().metadata().unwrap().blocks();
            assert!(blocks * 512 >= SIZES.link_bytes() as u64, "allocated: {blocks}");
            assert_eq!(names(), before);
            reserve.release();
            assert!(reserve.held.is_none());
        }
        let too_much = Sizes { result_queue: usize::MAX / 100_000, ..SIZES };
        let refused = SegmentReserve::new(&domain, &too_much).hold().unwrap_err();
        assert!(refused.to_string().contains("hold memory"), "{refused}");
    }
}
