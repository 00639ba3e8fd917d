//! Names, locks, and that nothing is left behind.

use super::*;
use std::fs;
use std::path::Path as FsPath;

/// Everything in the default folder whose name holds this.
fn left(instance: &str) -> Vec<String> {
    let names = names_in(&default_folder());
    names.into_iter().filter(|name| name.contains(instance)).collect()
}

fn names_in(folder: &FsPath) -> Vec<String> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let mut names: Vec<_> =
        entries.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    names.sort_unstable();
    names
}

/// A folder for one test, and the place that its domains share: what lies dead in the default one
/// is removed by whatever else runs, even while a test still puts it there.
fn own_folder() -> (tempfile::TempDir, PathBuf) {
    let above = tempfile::tempdir().unwrap();
    let folder = above.path().join("trolley");
    (above, folder)
}

#[test]
fn a_dropped_domain_leaves_nothing() {
    let domain = Domain::create(None, "t-leaves", Boot(1)).unwrap();
    let guest = Domain::open(domain.text()).unwrap();
    let copy = domain.clone();
    assert_eq!(left("t-leaves").len(), 1);
    drop(guest);
    drop(domain);
    assert!(!left("t-leaves").is_empty(), "a copy still lives");
    drop(copy);
    assert_eq!(left("t-leaves"), [""; 0]);
}

#[test]
fn names_are_checked() {
    for bad in ["", "Big", "a/b", "..", "thirteen-long", "ä", "a b", "a.b"] {
        let error = Domain::create(None, bad, Boot(2)).unwrap_err();
        assert!(matches!(error, OpenError::Name { .. }), "{bad}: {error}");
    }
    for bad in [
        "",
        "/",
        "/dev/shm",
        "trolley.x.0000000000000001",
        "/dev/shm/trolley.x",
        "/dev/shm/trolley.x.12",
        "/dev/shm/trolley.x.00000000000000zz",
        "/dev/shm/trolley.x.0000000000000001/..",
        "/dev/shm/../tmp/trolley.x.0000000000000001",
    ] {
        let error = Domain::open(bad).unwrap_err();
        assert!(matches!(error, OpenError::Text { .. }), "{bad}: {error}");
    }
}

#[test]
fn the_longest_name_fits_iceoryx2() {
    let domain = Domain::create(None, "twelve-chars", Boot(u64::MAX)).unwrap();
    assert!(domain.text().ends_with("/trolley.twelve-chars.ffffffffffffffff"));
    let guest = Domain::open(domain.text()).unwrap();
    assert_eq!((guest.boot(), guest.text()), (Boot(u64::MAX), domain.text()));
}

#[test]
fn a_name_is_taken_once() {
    let domain = Domain::create(None, "t-once", Boot(4)).unwrap();
    assert!(Domain::create(None, "t-once", Boot(4)).is_err());
    let other = Domain::create(None, "t-once", Boot(5)).unwrap();
    drop(domain);
    assert!(Domain::open(&other.text().replace("0000000005", "0000000004")).is_err());
    assert!(Domain::open(other.text()).is_ok());
}

#[test]
fn a_sweep_spares_the_living() {
    let (_above, folder) = own_folder();
    let domain = Domain::create(Some(&folder), "t-living", Boot(6)).unwrap();
    let before = names_in(&folder);
    assert_eq!((before.len(), sweep_leftovers(&folder)), (1, 0));
    assert_eq!(names_in(&folder), before);
    assert!(Domain::open(domain.text()).is_ok());
}

/// What a run leaves that was killed at any point: the files without the locks.
#[test]
fn a_sweep_removes_what_the_dead_left() {
    let (_above, folder) = own_folder();
    let _living = Domain::create(Some(&folder), "t-dead", Boot(11)).unwrap();
    let root = folder.join("trolley.t-dead.0000000000000007");
    fs::create_dir_all(root.join("0.0/nodes/1")).unwrap();
    fs::write(root.join("guests"), "").unwrap();
    fs::write(root.join("0.0/pool.data"), "x").unwrap();
    // A removal that was interrupted: no guests' file any more.
    fs::create_dir(folder.join("trolley.t-dead.0000000000000008")).unwrap();
    // A root that was never finished, by a process that is gone.
    fs::create_dir(folder.join(".trolley-new.4194305.t-dead")).unwrap();
    // Under the name of a root, but no folder.
    let pipe = folder.join("trolley.t-dead.0000000000000009");
    rustix::fs::mkfifoat(rustix::fs::CWD, &pipe, rustix::fs::Mode::RUSR).unwrap();
    // Not ours, or not in our form.
    fs::write(folder.join("trolley.t-dead.not-a-boot"), "x").unwrap();

    let _runs = sweep_leftovers(&folder);
    let expected = [
        "trolley.t-dead.0000000000000009",
        "trolley.t-dead.000000000000000b",
        "trolley.t-dead.not-a-boot",
    ];
    assert_eq!(names_in(&folder), expected);
    assert_eq!(sweep_leftovers(&folder), 0);
}

#[test]
fn what_a_guest_still_holds_stays() {
    let (_above, folder) = own_folder();
    let domain = Domain::create(Some(&folder), "t-guest", Boot(10)).unwrap();
    let text = domain.text().to_owned();
    let guest = Domain::open(&text).unwrap();
    // The owner goes first, as when it is killed; its worker lives a moment longer.
    drop(domain);
    assert!(FsPath::new(&text).exists());
    assert_eq!(sweep_leftovers(&folder), 0);
    assert!(FsPath::new(&text).exists());
    drop(guest);
    assert_eq!(sweep_leftovers(&folder), 1);
    assert_eq!(names_in(&folder), [""; 0]);
}
