//! A segment exists whole or not at all, for its owner alone.

use super::*;
use std::os::unix::fs::PermissionsExt as _;
use std::sync::atomic::AtomicU64;

#[derive(Debug)]
#[repr(C)]
struct Count(AtomicU64);

// SAFETY: one atomic word, without pointers.
unsafe impl ZeroCopySend for Count {}

type Counter = Segment<Count>;
type CounterBuilder<'b> = <Counter as DynamicStorage<Count>>::Builder<'b>;

fn folder() -> tempfile::TempDir {
    tempfile::tempdir_in("/dev/shm").unwrap()
}

fn config(folder: &tempfile::TempDir) -> SegmentConfig<Count> {
    let path = IceoryxPath::new(folder.path().to_str().unwrap().as_bytes()).unwrap();
    SegmentConfig::default().path_hint(&path)
}

fn name() -> FileName {
    FileName::new(b"counter").unwrap()
}

fn builder<'b>(folder: &tempfile::TempDir) -> CounterBuilder<'b> {
    CounterBuilder::new(&name()).config(&config(folder))
}

fn seven(value: &mut MaybeUninit<Count>, _: &mut BumpAllocator) -> bool {
    value.write(Count(AtomicU64::new(7)));
    true
}

#[test]
fn what_one_writes_the_other_reads_and_the_owner_removes_it() {
    let folder = folder();
    assert!(matches!(
        builder(&folder).open(AccessMode::ReadWrite),
        Err(DynamicStorageOpenError::DoesNotExist)
    ));
    let made = builder(&folder).initializer(seven).create().unwrap();
    let found = builder(&folder).open(AccessMode::ReadWrite).unwrap();
    assert_eq!(found.get().0.fetch_add(1, Ordering::SeqCst), 7);
    assert_eq!(made.get().0.load(Ordering::SeqCst), 8);
    assert!(made.has_ownership() && !found.has_ownership());
    assert_eq!(Counter::list_cfg(&config(&folder)).unwrap(), [name()]);
    assert!(matches!(
        builder(&folder).initializer(seven).create(),
        Err(DynamicStorageCreateError::AlreadyExists)
    ));
    drop(found);
    assert!(Counter::does_exist_cfg(&name(), &config(&folder)).unwrap());
    drop(made);
    assert!(!Counter::does_exist_cfg(&name(), &config(&folder)).unwrap());
}

#[test]
fn no_other_user_can_open_one_whatever_is_asked_for() {
    let folder = folder();
    let _made = builder(&folder).enable_global_access(true).initializer(seven).create().unwrap();
    let entry = fs::read_dir(folder.path()).unwrap().next().unwrap().unwrap();
    assert_eq!(entry.metadata().unwrap().permissions().mode() & 0o777, 0o600);
}

#[test]
fn while_it_is_made_it_has_no_name_and_if_that_fails_nothing_is_left() {
    let folder = folder();
    let path = folder.path().to_owned();
    let count = move || fs::read_dir(&path).unwrap().count();
    let looks = count.clone();
    let failed = builder(&folder)
        .initializer(move |_, _| {
            assert_eq!(looks(), 0);
            false
        })
        .create();
    assert!(matches!(failed, Err(DynamicStorageCreateError::InitializationFailed)));
    assert_eq!(count(), 0);
    // More than any memory.
    let failed = builder(&folder).supplementary_size(1 << 60).initializer(seven).create();
    assert!(matches!(failed, Err(DynamicStorageCreateError::InternalError)));
    assert_eq!(count(), 0);
}

#[test]
fn all_of_its_memory_is_allocated() {
    use std::os::unix::fs::MetadataExt as _;
    let folder = folder();
    let _made = builder(&folder).supplementary_size(1 << 20).initializer(seven).create().unwrap();
    let entry = fs::read_dir(folder.path()).unwrap().next().unwrap().unwrap();
    assert!(entry.metadata().unwrap().blocks() * 512 >= 1 << 20);
}

#[test]
fn what_is_no_segment_is_refused_at_once() {
    let folder = folder();
    let made = builder(&folder).has_ownership(false).initializer(seven).create().unwrap();
    let path = made.path.clone();
    let opened = || builder(&folder).open(AccessMode::ReadWrite);
    drop(made);
    drop(opened().unwrap());
    // Cut short, of another layout, or no file.
    fs::write(&path, [0; 15]).unwrap();
    assert!(matches!(opened(), Err(DynamicStorageOpenError::InternalError)));
    fs::write(&path, []).unwrap();
    assert!(matches!(opened(), Err(DynamicStorageOpenError::InternalError)));
    fs::write(&path, [0; 16]).unwrap();
    assert!(matches!(opened(), Err(DynamicStorageOpenError::VersionMismatch)));
    fs::remove_file(&path).unwrap();
    rustix::fs::mkfifoat(CWD, &path, Mode::RUSR | Mode::WUSR).unwrap();
    assert!(matches!(opened(), Err(DynamicStorageOpenError::InternalError)));
    fs::remove_file(&path).unwrap();
    fs::create_dir(&path).unwrap();
    assert!(matches!(opened(), Err(DynamicStorageOpenError::InternalError)));
    fs::remove_dir(&path).unwrap();
    std::os::unix::fs::symlink("/dev/zero", &path).unwrap();
    assert!(matches!(opened(), Err(DynamicStorageOpenError::InternalError)));
}
