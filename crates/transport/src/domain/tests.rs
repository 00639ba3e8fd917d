//! Names, locks, and that nothing is left behind.

use super::*;
use std::fs;
use std::path::Path as FsPath;

/// Everything in /dev/shm whose name holds this.
fn left(instance: &str) -> Vec<String> {
    let names = place::names_in_shm().unwrap();
    names.into_iter().filter(|name| name.contains(instance)).collect()
}

#[test]
fn a_dropped_domain_leaves_nothing() {
    let domain = Domain::create("t-leaves", Boot(1)).unwrap();
    let guest = Domain::open(domain.text()).unwrap();
    let copy = domain.clone();
    assert!(left("t-leaves").len() >= 2, "a root and memory");
    drop(guest);
    drop(domain);
    assert!(!left("t-leaves").is_empty(), "a copy still lives");
    drop(copy);
    assert_eq!(left("t-leaves"), [""; 0]);
}

#[test]
fn names_are_checked() {
    for bad in ["", "Big", "a/b", "..", "thirteen-long", "ä", "a b", "a.b"] {
        let error = Domain::create(bad, Boot(2)).unwrap_err();
        assert!(matches!(error, OpenError::Name { .. }), "{bad}: {error}");
    }
    for bad in [
        "",
        "/",
        "/dev/shm",
        "/dev/shm/trolley.x",
        "/dev/shm/trolley.x.12",
        "/dev/shm/trolley.x.00000000000000zz",
        "/dev/shm/trolley.x.0000000000000001/..",
        "/tmp/trolley.x.0000000000000001",
        "/dev/shm/../tmp/trolley.x.0000000000000001",
    ] {
        let error = Domain::open(bad).unwrap_err();
        assert!(matches!(error, OpenError::Text { .. }), "{bad}: {error}");
    }
}

#[test]
fn the_longest_name_fits_iceoryx2() {
    let domain = Domain::create("twelve-chars", Boot(u64::MAX)).unwrap();
    assert_eq!(domain.text(), "/dev/shm/trolley.twelve-chars.ffffffffffffffff");
    assert!(domain.text().len() <= 49);
    let guest = Domain::open(domain.text()).unwrap();
    assert_eq!((guest.boot(), guest.text()), (Boot(u64::MAX), domain.text()));
}

#[test]
fn a_name_is_taken_once() {
    let domain = Domain::create("t-once", Boot(4)).unwrap();
    assert!(Domain::create("t-once", Boot(4)).is_err());
    let other = Domain::create("t-once", Boot(5)).unwrap();
    drop(domain);
    assert!(Domain::open("/dev/shm/trolley.t-once.0000000000000004").is_err());
    assert!(Domain::open(other.text()).is_ok());
}

#[test]
fn a_sweep_spares_the_living() {
    let domain = Domain::create("t-living", Boot(6)).unwrap();
    let before = left("t-living");
    let _other_runs = sweep_leftovers();
    assert_eq!(left("t-living"), before);
    assert!(Domain::open(domain.text()).is_ok());
}

/// What a run leaves that was killed at any point: the files without the locks.
#[test]
fn a_sweep_removes_what_the_dead_left() {
    let name = "trolley.t-dead.0000000000000007";
    let root = format!("{}/{name}", place::SHM);
    fs::create_dir_all(format!("{root}/nodes/1")).unwrap();
    fs::write(format!("{root}/guests"), "").unwrap();
    fs::write(format!("{root}-pool.data"), "x").unwrap();
    // A removal that was interrupted: no guests' file any more.
    let half = format!("{}/trolley.t-dead.0000000000000008", place::SHM);
    fs::create_dir(&half).unwrap();
    // Memory without a root.
    fs::write(format!("{}/trolley.t-dead.0000000000000009-x", place::SHM), "x").unwrap();
    // A root that was never finished, by a process that is gone.
    let unborn = format!("{}/{}4194305.t-dead", place::SHM, place::UNBORN);
    fs::create_dir(&unborn).unwrap();
    // Not ours, or not in our form.
    let foreign = format!("{}/trolley.t-dead.not-a-boot", place::SHM);
    fs::write(&foreign, "x").unwrap();

    let end = 50;
    for _ in 0..end {
        // Another test may be sweeping, too, and hold a lock for a moment.
        let _runs = sweep_leftovers();
        if left("t-dead").len() == 1 {
            break;
        }
    }
    assert_eq!(left("t-dead"), ["trolley.t-dead.not-a-boot"]);
    fs::remove_file(foreign).unwrap();
}

#[test]
fn what_a_guest_still_holds_stays() {
    let domain = Domain::create("t-guest", Boot(10)).unwrap();
    let text = domain.text().to_owned();
    let guest = Domain::open(&text).unwrap();
    // The owner goes first, as when it is killed; its worker lives a moment longer.
    drop(domain);
    assert!(FsPath::new(&text).exists());
    let _other_runs = sweep_leftovers();
    assert!(FsPath::new(&text).exists());
    drop(guest);
    for _ in 0..50 {
        let _runs = sweep_leftovers();
        if !FsPath::new(&text).exists() {
            break;
        }
    }
    assert_eq!(left("t-guest"), [""; 0]);
}
