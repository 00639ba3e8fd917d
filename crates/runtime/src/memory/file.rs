//! A file as page-aligned bytes.
//!
//! It is read into private memory, not mapped: the bytes that are checked are the bytes that are
//! used, whatever happens to the file meanwhile, and a file that is cut short is an error and not a
//! SIGBUS. Pages of a mapping would have to be read once, too.

use crate::error::{OsError, Result};
use memmap2::{Mmap, MmapMut};
use std::fs::OpenOptions;
use std::io::{self, Read};
use std::os::unix::fs::OpenOptionsExt;
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
    /// If it cannot be opened or read, is not a regular file (a pipe could block forever, a device
    /// never end), or became shorter while it was read.
    pub fn open(path: &Path) -> Result<Self> {
        let name = path.to_string_lossy();
        let fail = |source| OsError::new("read", name.clone(), source);
        // Without O_NONBLOCK, opening a pipe waits for a writer.
        let mut file = OpenOptions::new()
            .read(true)
            .custom_flags(libc::O_NONBLOCK)
            .open(path)
            .map_err(fail)?;
        let metadata = file.metadata().map_err(fail)?;
        if !metadata.is_file() {
            return Err(fail(io::Error::new(io::ErrorKind::InvalidInput, "not a regular file")));
        }
        let len = usize::try_from(metadata.len())
            .map_err(|_overflow| fail(io::ErrorKind::FileTooLarge.into()))?;
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
