//! A file is replaced as a whole; nothing but a regular file is ever replaced.

use super::*;
use std::os::unix::fs::{FileTypeExt as _, MetadataExt as _, symlink};

type Writer = fn(&Path, &[u8]) -> Result<(), OutputError>;
const WRITERS: [Writer; 2] = [replace, publish];

#[test]
fn a_file_is_made_replaced_and_reached_through_links() {
    for writer in WRITERS {
        let folder = tempfile::tempdir().unwrap();
        let (file, link) = (folder.path().join("file"), folder.path().join("link"));
        symlink("file", &link).unwrap();
        writer(&file, b"first").unwrap();
        writer(&file, b"second").unwrap();
        assert_eq!(fs::read(&file).unwrap(), b"second");
        writer(&link, b"third").unwrap();
        assert_eq!(fs::read(&file).unwrap(), b"third");
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2, "nothing else is left");
    }
}

/// What is at a path, without following it.
fn identity(path: &Path) -> (u64, fs::FileType) {
    let about = fs::symlink_metadata(path).unwrap();
    (about.ino(), about.file_type())
}

#[test]
fn devices_pipes_sockets_folders_and_links_to_them_stay() {
    let folder = tempfile::tempdir().unwrap();
    let named = |name: &str| folder.path().join(name);
    let mode = rustix::fs::Mode::RUSR | rustix::fs::Mode::WUSR;
    let make = |name: &str, is| {
        rustix::fs::mknodat(rustix::fs::CWD, named(name), is, mode, rustix::fs::makedev(1, 3))
    };
    make("pipe", rustix::fs::FileType::Fifo).unwrap();
    // A /dev/null of our own, where this user may make one.
    let device = make("null", rustix::fs::FileType::CharacterDevice).is_ok();
    let _listens = std::os::unix::net::UnixListener::bind(named("socket")).unwrap();
    fs::create_dir(named("folder")).unwrap();
    for (name, to) in [("to-pipe", "pipe"), ("to-folder", "folder"), ("to-none", "none")] {
        symlink(to, named(name)).unwrap();
    }
    symlink("/dev/null", named("to-null")).unwrap();
    let mut all = vec![
        ("pipe", "a pipe"),
        ("socket", "a socket"),
        ("folder", "a folder"),
        ("to-pipe", "a pipe"),
        ("to-folder", "a folder"),
        ("to-null", "a device"),
        ("to-none", "a link to nothing"),
    ];
    all.extend(device.then_some(("null", "a device")));
    let null = identity(Path::new("/dev/null"));
    for (name, says) in all {
        let path = named(name);
        let before = identity(&path);
        for writer in WRITERS {
            for error in [writer(&path, b"x").unwrap_err(), check(&path, None).unwrap_err()] {
                assert!(error.to_string().contains(says), "{error}");
                assert!(error.to_string().contains(name) && error.remedy().is_some(), "{error}");
            }
        }
        assert!(identity(&path) == before, "{name} is another now");
    }
    assert!(identity(Path::new("/dev/null")) == null && null.1.is_char_device());
}

#[test]
fn the_input_and_a_missing_folder_are_no_targets() {
    let folder = tempfile::tempdir().unwrap();
    let (file, link) = (folder.path().join("file"), folder.path().join("link"));
    fs::write(&file, "x").unwrap();
    symlink(&file, &link).unwrap();
    assert!(matches!(check(&link, Some(&file)), Err(OutputError::Input { .. })));
    check(&file, Some(&folder.path().join("other"))).unwrap();
    let inside = folder.path().join("no/file");
    assert!(matches!(check(&inside, None), Err(OutputError::NoFolder { .. })));
    let error = replace(&inside, b"x").unwrap_err();
    assert_eq!(error.kind(), FailureKind::System);
}
