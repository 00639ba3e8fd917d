//! A domain that ends leaves nothing, one that was killed is swept, and a living one is not.

use super::*;
use crate::link::tests::{SIZES, lives_in_child, start_child, unique_boot};
use crate::{CoordinatorLink, WorkerLink};
use protocol::Incarnation;

fn left_of(boot: Boot) -> Vec<String> {
    let boot = format!("{:016x}", boot.0);
    let entries = fs::read_dir(SHM).unwrap().flatten();
    entries
        .map(|entry| entry.file_name().to_string_lossy().into_owned())
        .filter(|name| name.contains(&boot))
        .collect()
}

#[test]
fn a_dropped_domain_leaves_nothing() {
    let boot = unique_boot();
    let domain = Domain::create("tdrop", boot).unwrap();
    assert!(domain.text().len() + SHM.len() + 9 <= 49, "root path too long for iceoryx2");
    let who = Incarnation { worker: 0, inc: 0 };
    let link = CoordinatorLink::create(&domain, who, &SIZES, "b").unwrap();
    let theirs = Domain::open(&domain.text()).unwrap();
    let worker = WorkerLink::open(&theirs, who, &SIZES, "b").unwrap();
    assert!(left_of(boot).len() > 3);
    drop((worker, theirs));
    drop(link);
    drop(domain);
    assert_eq!(left_of(boot), Vec::<String>::new());
}

#[test]
fn a_killed_domain_is_swept_and_a_living_one_stays() {
    if let Some(boot) = lives_in_child() {
        let domain = Domain::create("tsweep", boot).unwrap();
        let who = Incarnation { worker: 0, inc: 0 };
        let _link = CoordinatorLink::create(&domain, who, &SIZES, "b").unwrap();
        println!("ready");
        std::thread::park();
        return;
    }
    let alive = Domain::create("talive", unique_boot()).unwrap();
    let boot = unique_boot();
    let mut child =
        start_child("domain::tests::a_killed_domain_is_swept_and_a_living_one_stays", boot);
    assert!(left_of(boot).len() > 3);
    child.kill().unwrap();
    child.wait().unwrap();
    // Another test's sweep may come first.
    let _swept = sweep();
    assert_eq!(left_of(boot), Vec::<String>::new());
    assert!(!left_of(alive.boot()).is_empty());
}

#[test]
fn instance_names_that_could_leave_the_folder_are_refused() {
    for name in ["", "../x", "a b", "thirteen-long", "Ä"] {
        assert!(matches!(Domain::create(name, Boot(1)), Err(OpenError::Instance(_))), "{name}");
    }
}
