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
