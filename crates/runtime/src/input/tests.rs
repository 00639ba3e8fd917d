//! Files are read whole up to their limit; what is no regular file, or longer, is refused at once.

use super::*;
use diagnostic::Failure;
use std::fs;
use std::os::unix::net::UnixListener;

const KIND: InputKind = InputKind::Poses;

fn refusal(path: &Path) -> Failure {
    let error = text(path, KIND).expect_err("refused");
    assert!(open(path, KIND).is_err() || matches!(error, InputError::NotText { .. }));
    Failure::from(error)
}

#[test]
fn a_file_is_read_up_to_its_limit_and_no_further() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("poses");
    for length in [0, 1, 4096, KIND.bytes_max()] {
        fs::write(&path, vec![b'x'; length as usize]).unwrap();
        assert_eq!(bytes(&path, KIND).unwrap().len() as u64, length);
        assert_eq!(open(&path, KIND).unwrap().1, length);
    }
    fs::write(&path, vec![b'x'; KIND.bytes_max() as usize + 1]).unwrap();
    let failure = refusal(&path);
    assert!(failure.what().contains("65537 bytes are too many for two poses"), "{failure}");
    assert!(failure.what().contains("the limit is 65536"), "{failure}");
    assert!(failure.remedy().is_some());
}

/// Neither the length that the system states nor one that has grown since is believed.
#[test]
fn a_source_that_does_not_end_is_left_at_the_limit() {
    let path = Path::new("endless");
    let error = bounded(&mut io::repeat(7), path, 10, KIND).expect_err("it has no end");
    assert!(error.to_string().contains("more than 65536 bytes are too many"), "{error}");
    let mut exact = io::repeat(7).take(KIND.bytes_max());
    assert_eq!(bounded(&mut exact, path, u64::MAX, KIND).unwrap().len(), 65_536);
}

#[test]
fn what_is_no_regular_file_is_called_what_it_is() {
    let folder = tempfile::tempdir().unwrap();
    let (pipe, socket) = (folder.path().join("pipe"), folder.path().join("socket"));
    let mode = rustix::fs::Mode::RUSR | rustix::fs::Mode::WUSR;
    rustix::fs::mknodat(rustix::fs::CWD, &pipe, rustix::fs::FileType::Fifo, mode, 0).unwrap();
    let _listens = UnixListener::bind(&socket).unwrap();
    let link = folder.path().join("link");
    std::os::unix::fs::symlink(&pipe, &link).unwrap();
    for (path, says) in [
        (pipe.as_path(), "this is a pipe"),
        (&link, "this is a pipe"),
        (&socket, "this is a socket"),
        (folder.path(), "this is a folder"),
        (Path::new("/dev/zero"), "this is a device"),
        (&folder.path().join("absent"), "there is no such file"),
        (&folder.path().join("no/absent"), "there is no such file"),
    ] {
        let failure = refusal(path);
        assert!(failure.what().starts_with(&*path.to_string_lossy()), "{failure}");
        assert!(failure.what().contains(says) && failure.remedy().is_some(), "{failure}");
        assert_eq!(start(path, &mut [0; 8]), 0);
    }
}

#[test]
fn text_is_utf8_and_the_first_bytes_are_those_of_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("text");
    fs::write(&path, "äx").unwrap();
    assert_eq!(text(&path, KIND).unwrap(), "äx");
    let mut first = [0; 2];
    assert_eq!(start(&path, &mut first), 2);
    assert_eq!(first, *"ä".as_bytes());
    fs::write(&path, [b'x', 0xff]).unwrap();
    assert!(refusal(&path).what().contains("not UTF-8 from byte 1"));
}

#[test]
fn every_kind_has_a_limit_and_a_name_of_its_own() {
    let mut names: Vec<_> = InputKind::ALL.map(InputKind::name).to_vec();
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), InputKind::ALL.len());
    for kind in InputKind::ALL {
        assert!((1 << 16..=1 << 30).contains(&kind.bytes_max()), "{kind:?}");
    }
}

/// Every mode that lets group or others in is refused, also one that lets them write alone.
#[test]
fn a_secret_that_others_may_read_or_change_is_refused() {
    use std::os::unix::fs::PermissionsExt as _;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("key.pem");
    fs::write(&path, "x").unwrap();
    for mode in (0..0o1000).filter(|mode| mode & 0o400 != 0) {
        fs::set_permissions(&path, fs::Permissions::from_mode(mode)).unwrap();
        let read = secret_text(&path, InputKind::Key);
        if mode & 0o077 == 0 {
            assert_eq!(read.unwrap(), "x", "{mode:04o}");
        } else {
            let failure = Failure::from(read.expect_err("exposed"));
            assert!(failure.what().contains("key.pem: this key is secret"), "{failure}");
            assert!(failure.what().contains(&format!("{mode:04o}")), "{failure}");
            assert!(failure.remedy().unwrap().contains("chmod 600"), "{failure}");
        }
    }
}
