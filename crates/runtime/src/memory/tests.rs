//! Sealed memory cannot be changed by any process; shared memory is seen by all.

use super::*;
use crate::input::InputKind;
use crate::process::{Spawn, spawn};
use crate::testing;
use core::sync::atomic::{AtomicBool, Ordering};
use memmap2::MmapOptions;
use protocol::StatusPage;
use rustix::fs::{FallocateFlags, MemfdFlags, SealFlags};
use rustix::io::Errno;
use std::fs;
use std::io::{ErrorKind, Write};
use std::os::fd::OwnedFd;
use std::path::Path;

fn copy(fd: std::os::fd::BorrowedFd<'_>) -> OwnedFd {
    fd.try_clone_to_owned().unwrap()
}

fn pattern(len: usize) -> Vec<u8> {
    (0..len).map(|i| (i * 7 + i / 251) as u8).collect()
}

fn sealed(len: usize) -> SealedMemory {
    SealedMemory::create("test", len, |bytes| {
        assert!(bytes.iter().all(|byte| *byte == 0));
        bytes.copy_from_slice(&pattern(len));
    })
    .unwrap()
}

#[test]
fn sealed_memory_is_what_was_written() {
    for len in [0, 1, 4095, 4096, 4097, 1_000_000] {
        let memory = sealed(len);
        assert_eq!(memory.bytes(), pattern(len));
        assert_eq!(memory.bytes().as_ptr() as usize % 4096, 0);
        let other = SealedMemory::from_fd(copy(memory.fd())).unwrap();
        drop(memory);
        assert_eq!(other.bytes(), pattern(len), "it outlives its maker");
    }
}

/// A child has a copy of every mapping until it runs its program, and a mapping that may write
/// keeps the kernel from sealing.
#[test]
fn memory_is_sealed_while_children_are_started() {
    let is_done = AtomicBool::new(false);
    std::thread::scope(|scope| {
        scope.spawn(|| {
            while !is_done.load(Ordering::Relaxed) {
                let program = Path::new("/bin/true");
                let child = spawn(Spawn { program, args: &[], fds: &[], core: None }).unwrap();
                testing::must_pass(child);
            }
        });
        let make = |_| SealedMemory::create("test", 100_000, |bytes| bytes.fill(7));
        let made: Vec<_> = (0..300).map(make).collect();
        is_done.store(true, Ordering::Relaxed);
        assert!(made.iter().flatten().all(|memory| memory.bytes() == [7; 100_000]));
        assert_eq!(made.iter().flatten().count(), 300, "{:?}", made.iter().find(|m| m.is_err()));
    });
}

#[test]
fn sealed_memory_cannot_be_changed() {
    let memory = sealed(10_000);
    let fd = memory.fd();
    let refused = Err(Errno::PERM);
    assert_eq!(rustix::io::pwrite(fd, &[1], 0).map(|_| ()), refused);
    assert_eq!(rustix::fs::ftruncate(fd, 9_999), refused);
    assert_eq!(rustix::fs::ftruncate(fd, 10_001), refused);
    assert_eq!(rustix::fs::fallocate(fd, FallocateFlags::empty(), 0, 20_000), refused);
    let punch = FallocateFlags::PUNCH_HOLE | FallocateFlags::KEEP_SIZE;
    assert_eq!(rustix::fs::fallocate(fd, punch, 0, 4096), refused);
    assert_eq!(rustix::fs::fcntl_add_seals(fd, SealFlags::FUTURE_WRITE), refused);
    let error = MmapOptions::new().len(4096).map_raw(&fd).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::PermissionDenied, "no shared writable mapping");
    assert_eq!(memory.bytes(), pattern(10_000));
}

/// The worker may trust what it checked only because no process can change it afterwards.
#[test]
fn memory_with_a_seal_missing_is_not_trusted() {
    let all = [SealFlags::WRITE, SealFlags::GROW, SealFlags::SHRINK, SealFlags::SEAL];
    for missing in all {
        let flags = MemfdFlags::CLOEXEC | MemfdFlags::ALLOW_SEALING;
        let fd = rustix::fs::memfd_create("test", flags).unwrap();
        rustix::fs::ftruncate(&fd, 4096).unwrap();
        let seals = all.into_iter().filter(|seal| *seal != missing).collect();
        rustix::fs::fcntl_add_seals(&fd, seals).unwrap();
        assert_eq!(SealedMemory::from_fd(fd).unwrap_err().io_kind(), ErrorKind::InvalidData);
    }
}

#[test]
fn the_status_page_is_one_page_for_all() {
    let mine = StatusMemory::create().unwrap();
    let theirs = StatusMemory::from_fd(copy(mine.fd())).unwrap();
    assert_ne!(mine.page() as *const StatusPage, theirs.page() as *const StatusPage);
    let line = &theirs.page().workers[5];
    assert_eq!(line.beat.load(Ordering::SeqCst), 0);
    mine.page().workers[5].beat.store(17, Ordering::SeqCst);
    assert_eq!(line.beat.load(Ordering::SeqCst), 17);
    assert_eq!(rustix::fs::ftruncate(mine.fd(), 0), Err(Errno::PERM), "nobody can cut it short");
}

#[test]
fn another_memfd_is_no_status_page() {
    assert!(StatusMemory::from_fd(copy(sealed(size_of::<StatusPage>()).fd())).is_err());
    let flags = MemfdFlags::CLOEXEC | MemfdFlags::ALLOW_SEALING;
    let fd = rustix::fs::memfd_create("test", flags).unwrap();
    rustix::fs::ftruncate(&fd, size_of::<StatusPage>() as u64).unwrap();
    assert!(StatusMemory::from_fd(fd).is_err(), "its size is not sealed");
}

#[test]
fn words_are_written_by_their_maker_alone() {
    let mine = WrittenWords::create("test", 1024).unwrap();
    let theirs = ReadWords::from_fd(copy(mine.fd()), 1024).unwrap();
    mine.write(1000, &[7, 8, 9]);
    let mut words = vec![1];
    assert!(theirs.read(999, 4, &mut words));
    assert_eq!(words, [1, 0, 7, 8, 9]);
    for (first, count) in [(1022, 3), (usize::MAX, 2), (1025, 0)] {
        assert!(!theirs.read(first, count, &mut words), "{first} {count}");
    }
    assert_eq!(rustix::fs::ftruncate(mine.fd(), 0), Err(Errno::PERM), "nobody can cut it short");
    let fd = copy(mine.fd());
    assert!(MmapOptions::new().map_raw(&fd).is_err(), "nobody else can write it");
    assert!(rustix::io::pwrite(&fd, &[1], 0).is_err());
    assert!(ReadWords::from_fd(copy(mine.fd()), 512).is_err(), "it has another size");
    let page = StatusMemory::create().unwrap();
    let len = size_of::<StatusPage>() / 8;
    assert!(ReadWords::from_fd(copy(page.fd()), len).is_err(), "others may write it");
}

#[test]
fn a_file_is_read_as_it_is() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("model");
    for len in [0, 1, 4096, 70_001] {
        fs::write(&path, pattern(len)).unwrap();
        let map = FileMap::open(&path, InputKind::Model).unwrap();
        // What happens to the file afterwards does not matter.
        fs::File::create(&path).unwrap().write_all(b"other").unwrap();
        assert_eq!(map.bytes(), pattern(len));
        assert!(map.bytes().is_empty() || (map.bytes().as_ptr() as usize).is_multiple_of(4096));
    }
}
