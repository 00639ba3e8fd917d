//! What is sealed stays as it is, for everybody.

use super::*;
use core::sync::atomic::Ordering;
use std::io::Write as _;
use std::os::unix::fs::FileExt as _;

#[test]
fn sealed_memory_cannot_be_written_or_resized() {
    let memory = SealedMemory::create("test", 5000, |bytes| bytes[4999] = 7).unwrap();
    let again = SealedMemory::from_fd(memory.as_fd().try_clone_to_owned().unwrap()).unwrap();
    let file = File::from(memory.as_fd().try_clone_to_owned().unwrap());
    assert!(file.write_at(&[1], 0).is_err());
    assert!(file.set_len(1).is_err() && file.set_len(9000).is_err());
    // SAFETY: the mapping must fail; if it did not, the test fails before it is used.
    assert!(unsafe { MmapMut::map_mut(&file) }.is_err());
    assert_eq!((again.bytes().len(), again.bytes()[4999], again.bytes()[0]), (5000, 7, 0));
}

#[test]
fn unsealed_memory_is_not_trusted() {
    let file = memory_file("test", 10, MemfdFlags::ALLOW_SEALING).unwrap();
    assert!(SealedMemory::from_fd(OwnedFd::from(file)).is_err());
}

#[test]
fn the_status_page_is_shared_and_a_page_of_another_size_refused() {
    let here = StatusMemory::create().unwrap();
    let there = StatusMemory::from_fd(here.as_fd().try_clone_to_owned().unwrap()).unwrap();
    here.page().workers[3].beat.store(41, Ordering::Relaxed);
    assert_eq!(there.page().workers[3].beat.load(Ordering::Relaxed), 41);
    let other = memory_file("test", 10, MemfdFlags::ALLOW_SEALING).unwrap();
    assert!(StatusMemory::from_fd(OwnedFd::from(other)).is_err());
}

#[test]
fn files_are_mapped_and_folders_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("some");
    assert!(FileMap::open(&path).is_err());
    assert!(FileMap::open(folder.path()).is_err());
    let mut file = File::create(&path).unwrap();
    assert_eq!(FileMap::open(&path).unwrap().bytes(), b"");
    file.write_all(b"abc").unwrap();
    assert_eq!(FileMap::open(&path).unwrap().bytes(), b"abc");
}
