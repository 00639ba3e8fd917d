//! What a stranger may have planted is refused, by name and at once.

use super::*;
use std::fs;
use std::os::unix::fs::{PermissionsExt as _, symlink};
use std::os::unix::net::UnixListener;

fn mode(path: &Path, mode: u32) {
    fs::set_permissions(path, fs::Permissions::from_mode(mode)).unwrap();
}

fn refusal(path: &Path) -> String {
    let error = make(path, None).unwrap_err();
    assert!(matches!(error, OpenError::Untrusted { .. }), "{error}");
    let text = error.to_string();
    assert!(text.contains(path.to_str().unwrap()), "{text}");
    text
}

#[test]
fn one_that_is_made_is_private_and_found_again() {
    let above = tempfile::tempdir().unwrap();
    let path = above.path().join("own");
    drop(make(&path, None).unwrap());
    assert_eq!(fs::metadata(&path).unwrap().permissions().mode() & 0o7777, 0o700);
    drop(make(&path, None).unwrap());
    drop(enter(&path).unwrap());
}

#[test]
fn pipes_links_sockets_and_files_are_refused_and_stay() {
    let above = tempfile::tempdir().unwrap();
    let path = above.path().join("planted");
    let precious = above.path().join("precious");
    fs::create_dir(&precious).unwrap();

    rustix::fs::mkfifoat(CWD, &path, Mode::RUSR | Mode::WUSR).unwrap();
    assert!(refusal(&path).contains("a pipe"));
    fs::remove_file(&path).unwrap();
    symlink(&precious, &path).unwrap();
    assert!(refusal(&path).contains("a link"));
    fs::remove_file(&path).unwrap();
    let socket = UnixListener::bind(&path).unwrap();
    assert!(refusal(&path).contains("a socket"));
    drop(socket);
    fs::remove_file(&path).unwrap();
    fs::write(&path, "x").unwrap();
    assert!(refusal(&path).contains("a file"));
    assert!(precious.exists());
}

#[test]
fn one_that_others_may_write_to_is_refused() {
    let above = tempfile::tempdir().unwrap();
    let path = above.path().join("open");
    fs::create_dir(&path).unwrap();
    for bits in [0o777, 0o1777, 0o720, 0o702] {
        mode(&path, bits);
        assert!(refusal(&path).contains("others may write"), "{bits:o}");
    }
    mode(&path, 0o755);
    drop(make(&path, None).unwrap());
}

#[test]
fn one_below_a_folder_in_which_others_may_exchange_it_is_refused() {
    let above = tempfile::tempdir().unwrap();
    let open = above.path().join("open");
    fs::create_dir(&open).unwrap();
    let path = open.join("own");
    mode(&open, 0o777);
    let error = make(&path, None).unwrap_err();
    assert!(error.to_string().contains("every user may exchange"), "{error}");
    // Sticky, like /tmp: there everybody keeps what is theirs.
    mode(&open, 0o1777);
    drop(make(&path, None).unwrap());
    assert!(enter(&path.join("absent")).unwrap_err().is_absent());
}

/// What a group may do with a file, and what it may not.
fn rights(path: &Path) -> u32 {
    fs::symlink_metadata(path).unwrap().permissions().mode() & 0o7777
}

#[test]
fn what_is_lent_is_open_to_the_group_alone_and_nothing_is_lent_through_a_link() {
    let above = tempfile::tempdir().unwrap();
    let group = getegid().as_raw();
    let lent = above.path().join("lent");
    fs::create_dir_all(lent.join("inner")).unwrap();
    let precious = above.path().join("precious");
    fs::write(&precious, "x").unwrap();
    mode(&precious, 0o600);
    let (text, kept) = (lent.join("inner/text"), lent.join("inner/kept"));
    fs::write(&text, "x").unwrap();
    mode(&text, 0o604);
    fs::write(&kept, "x").unwrap();
    mode(&kept, 0o400);
    symlink(&precious, lent.join("link")).unwrap();
    let _socket = UnixListener::bind(lent.join("socket")).unwrap();
    assert_eq!(borrower(&lent), None);
    lend(CWD, &lent, group).unwrap();
    assert_eq!(borrower(&lent), Some(group));
    assert_eq!([&lent, &lent.join("inner")].map(|path| rights(path)), [0o770; 2]);
    assert_eq!(
        [&text, &kept, &lent.join("socket")].map(|path| rights(path)),
        [0o660, 0o440, 0o770]
    );
    assert_eq!(rights(&precious), 0o600, "through a link");

    // A member may give a file another name in the folder that is lent.
    fs::hard_link(&precious, lent.join("planted")).unwrap();
    lend(CWD, &lent, group).unwrap();
    assert_eq!(rights(&precious), 0o600, "by its other name");
}

#[test]
fn a_segment_is_open_to_the_group_to_which_its_folder_is_lent() {
    let above = tempfile::tempdir_in(SHM).unwrap();
    let rights_of = |file: File| file.metadata().unwrap().permissions().mode() & 0o7777;
    assert_eq!(rights_of(crate::segment::unnamed(above.path(), 64).unwrap()), 0o600);
    lend(CWD, above.path(), getegid().as_raw()).unwrap();
    assert_eq!(rights_of(crate::segment::unnamed(above.path(), 64).unwrap()), 0o660);
}

#[test]
fn a_folder_of_a_service_may_be_entered_by_its_group_and_not_written_to() {
    let above = tempfile::tempdir().unwrap();
    let path = above.path().join("service");
    for _ in 0..2 {
        drop(make(&path, Some(getegid().as_raw())).unwrap());
        assert_eq!(rights(&path), 0o750);
    }
    mode(above.path(), 0o700);
    let other = getegid().as_raw() + 1;
    let error = check_reach(&path, other).unwrap_err();
    assert!(matches!(error, OpenError::Closed { .. }), "{error}");
    assert!(error.to_string().contains(path.to_str().unwrap()), "{error}");
}
