//! The machine: its name, and what it grants this process: file descriptors, shared memory.

use crate::error::{OsError, Result};
use rustix::process::{Resource, getrlimit};

/// Maximum number of file descriptors that this process may have open; `None`: unlimited.
#[must_use]
pub fn files_max() -> Option<u64> {
    getrlimit(Resource::Nofile).current
}

/// How many file descriptors this process has open; `None` if the kernel does not say.
#[must_use]
pub fn files_open() -> Option<usize> {
    // The descriptor with which the folder is read is one of them.
    std::fs::read_dir("/proc/self/fd").ok().map(|entries| entries.count().saturating_sub(1))
}

/// Bytes of memory of this process that are resident; `None` if the kernel does not say.
#[must_use]
pub fn resident_bytes() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/self/statm").ok()?;
    let pages: u64 = text.split(' ').nth(1)?.parse().ok()?;
    Some(pages * rustix::param::page_size() as u64)
}

/// Bytes of memory that new programs can take without swapping; `None` if the kernel does not say.
#[must_use]
pub fn available_bytes() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/meminfo").ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    let kib: u64 = line.trim().strip_suffix(" kB")?.parse().ok()?;
    Some(kib << 10)
}

/// Bytes that can still be written to the file system of this path.
///
/// # Errors
///
/// If there is no such path.
pub fn free_bytes(path: &str) -> Result<u64> {
    let found = rustix::fs::statvfs(path).map_err(OsError::at("look at", path))?;
    Ok(found.f_bavail.saturating_mul(found.f_frsize))
}

/// The host name, as the kernel has it.
#[must_use]
pub fn host_name() -> String {
    rustix::system::uname().nodename().to_string_lossy().into_owned()
}

#[cfg(test)]
mod tests {
    //! What is said of this process is so.
    use super::*;

    #[test]
    fn an_open_file_is_counted_and_closed_again() {
        // Other tests of this process open files too, so only a lower bound holds.
        let files: Vec<_> = (0..50).map(|_| std::fs::File::open("/dev/null").unwrap()).collect();
        assert!(files_open().unwrap() >= files.len());
        assert!(files_max().is_none_or(|most| most >= 50));
        assert!(resident_bytes().unwrap() > 100_000);
        assert!(available_bytes().is_none_or(|bytes| bytes > 1_000_000));
        assert!(free_bytes("/dev/shm").is_ok());
        assert!(free_bytes("/no/such/path").is_err());
        let name = std::fs::read_to_string("/proc/sys/kernel/hostname").unwrap();
        assert_eq!(host_name(), name.trim_end());
    }
}
