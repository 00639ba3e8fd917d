//! A copy of bytes on large pages, where the kernel grants them.
//!
//! A walk through two trees of a million triangles touches tens of thousands of pages of 4 KiB, and
//! looking their places up takes a few per cent of its time. Large pages are asked for, never
//! needed: without them everything works as it did.

use crate::error::{OsError, Result};
use memmap2::{Advice, Mmap, MmapMut};

/// Bytes that do not change, from the start of a page.
#[derive(Debug)]
pub struct LargePages(Option<Mmap>);

impl LargePages {
    /// Copies bytes.
    ///
    /// # Errors
    ///
    /// If memory ran out.
    pub fn copy_of(bytes: &[u8]) -> Result<Self> {
        if bytes.is_empty() {
            return Ok(Self(None));
        }
        let fail = |source| OsError::new("take memory for", "bodies", source);
        let mut map = MmapMut::map_anon(bytes.len()).map_err(fail)?;
        // Before the first byte is written: pages that are there stay as they are. Kernels and
        // limits may refuse.
        let _refused = map.advise(Advice::HugePage);
        map.copy_from_slice(bytes);
        Ok(Self(Some(map.make_read_only().map_err(fail)?)))
    }

    /// The bytes.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        self.0.as_deref().unwrap_or(&[])
    }
}

#[cfg(test)]
mod tests {
    //! What is copied is what was there, of any length.
    use super::*;

    #[test]
    fn a_copy_is_what_was_copied() {
        for length in [0, 1, 4096, 4097, 5 << 20] {
            let bytes: Vec<u8> = (0..length).map(|at| (at % 251) as u8).collect();
            assert!(LargePages::copy_of(&bytes).is_ok_and(|copy| copy.bytes() == bytes));
        }
    }
}
