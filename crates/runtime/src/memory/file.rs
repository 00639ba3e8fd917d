//! A file as page-aligned bytes.
//!
//! It is read into private memory, not mapped: the bytes that are checked are the bytes that are
//! used, whatever happens to the file meanwhile, and a file that is cut short is an error and not a
//! SIGBUS. Pages of a mapping would have to be read once, too.

use crate::input::{self, InputError, InputKind};
use memmap2::{Mmap, MmapMut};
use std::io::Read as _;
use std::path::Path;

/// The contents of a regular file at the time of opening.
#[derive(Debug)]
pub struct FileMap {
    map: Option<Mmap>,
}

impl FileMap {
    /// Reads the whole file.
    ///
    /// # Errors
    ///
    /// If it cannot be opened or read, is not a regular file, is longer than its kind may be, or
    /// became shorter while it was read.
    pub fn open(path: &Path, kind: InputKind) -> Result<Self, InputError> {
        let fail = |error| InputError::of_io(path, error);
        let (mut file, length) = input::open(path, kind)?;
        let len = usize::try_from(length).unwrap_or(usize::MAX);
        if len == 0 {
            return Ok(Self { map: None });
        }
        let mut map = MmapMut::map_anon(len).map_err(fail)?;
        file.read_exact(&mut map).map_err(fail)?;
        Ok(Self { map: Some(map.make_read_only().map_err(fail)?) })
    }

    /// The bytes, from the start of a page.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        self.map.as_deref().unwrap_or(&[])
    }
}
