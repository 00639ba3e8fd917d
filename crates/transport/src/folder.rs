//! Private folders, in which everything lies that processes of one user share.
//!
//! # Threats
//!
//! One user id is one trust domain: whoever may send this process a signal may also write to its
//! files. Other users are strangers. They may plant any name in a folder that everybody may write
//! to (files, pipes, sockets, links, folders of their own), and fill its file system. So
//!
//! - all shared files lie in a folder that its owner alone may enter (0700), made here, or found
//!   and then checked: a folder, not a link to one, of this user, not writable by others;
//! - every folder above it is checked as well, since whoever may write there can exchange it; the
//!   one in which a service makes its own belongs to this user or to root, or is for all;
//! - what is found is never waited for, and nothing is removed through a link.
//!
//! A group of clients, where one is set, is inside the trust domain as far as the folder of its
//! service goes: its members can end the service, but not make it lie about what it computed.

use crate::error::OpenError;
use rustix::fs::{CWD, FileType, Gid, Mode, OFlags, Uid, fstat, openat};
use rustix::io::Errno;
use rustix::process::{getegid, geteuid, getgroups};
use std::fs::File;
use std::os::unix::ffi::OsStrExt as _;
use std::path::{Path, PathBuf};

/// Where memory can be shared on every Linux. Every user may write there.
const SHM: &str = "/dev/shm";
/// The folder's name in a folder of this user.
const NAME: &str = "trolley";
/// `f_type` of a tmpfs, from linux/magic.h.
const TMPFS: u64 = 0x0102_1994;
/// Permissions of a private folder, and of one that a group of clients may enter too.
const PRIVATE: u32 = 0o700;
const SHARED: u32 = 0o2770;
/// Bits that let others, or group and others, write.
const OTHERS_WRITE: u32 = 0o002;
const WRITE: u32 = 0o022;
const STICKY: u32 = 0o1000;

/// Where shared files lie if nothing else was asked for. Nothing is created.
///
/// The first of these that there is: the folder that systemd made for the service
/// (`$RUNTIME_DIRECTORY`), `trolley` in `$XDG_RUNTIME_DIR` if that is a tmpfs, and
/// `/dev/shm/trolley-UID`.
#[must_use]
pub fn default_folder() -> PathBuf {
    let from = |name: &str| std::env::var_os(name).filter(|value| !value.is_empty());
    if let Some(made) = from("RUNTIME_DIRECTORY") {
        // Several are separated by colons.
        let first = made.as_bytes().split(|byte| *byte == b':').next().unwrap_or_default();
        return PathBuf::from(std::ffi::OsStr::from_bytes(first));
    }
    if let Some(user) = from("XDG_RUNTIME_DIR").map(PathBuf::from)
        && user.is_absolute()
        && rustix::fs::statfs(&user).is_ok_and(|fs| fs.f_type.cast_unsigned() == TMPFS)
    {
        return user.join(NAME);
    }
    PathBuf::from(format!("{SHM}/{NAME}-{}", geteuid().as_raw()))
}

/// Makes a private folder, or checks the one that is there. `group` may enter it, too.
///
/// # Errors
///
/// If it cannot be made, or a stranger could write to it or exchange it.
pub(crate) fn make(path: &Path, group: Option<u32>) -> Result<File, OpenError> {
    let shown = path.display().to_string();
    let mode = Mode::from_raw_mode(PRIVATE);
    // Before anything is made where it cannot stay.
    checked_above(path)?;
    let is_new = match rustix::fs::mkdir(path, mode) {
        Ok(()) => true,
        Err(Errno::EXIST) => false,
        Err(error) => return Err(OpenError::at("create", &shown)(error)),
    };
    let folder = open(path)?;
    let stat = fstat(&folder).map_err(OpenError::at("examine", &shown))?;
    let refuse =
        |why: String, remedy: String| OpenError::Untrusted { path: shown.clone(), why, remedy };
    if stat.st_uid != geteuid().as_raw() {
        let why = format!("it belongs to user {}", stat.st_uid);
        return Err(refuse(why, remedy_elsewhere()));
    }
    if let (true, Some(group)) = (is_new, group) {
        // The group first: while it may enter, the folder is empty.
        rustix::fs::fchown(&folder, None, Some(Gid::from_raw(group)))
            .and_then(|()| rustix::fs::fchmod(&folder, Mode::from_raw_mode(SHARED)))
            .map_err(OpenError::at("give to the group of clients", &shown))?;
        return checked_above(path).map(|()| folder);
    }
    let is_open = match group {
        None => stat.st_mode & WRITE != 0,
        Some(group) => stat.st_mode & OTHERS_WRITE != 0 || stat.st_gid != group,
    };
    if is_open {
        let why = format!("others may write to it (mode {:o})", stat.st_mode & 0o7777);
        return Err(refuse(why, format!("chmod 700 {shown}, or remove it")));
    }
    checked_above(path).map(|()| folder)
}

/// Enters a folder that another process made: one of this user, or of one whom this user trusts
/// because only they could have put it there.
///
/// # Errors
///
/// If it is not there ([`OpenError::is_absent`]), or a stranger may have made it.
pub(crate) fn enter(path: &Path) -> Result<File, OpenError> {
    let shown = path.display().to_string();
    let folder = open(path)?;
    let stat = fstat(&folder).map_err(OpenError::at("examine", &shown))?;
    let me = geteuid();
    let is_known = stat.st_uid == me.as_raw() || stat.st_uid == Uid::ROOT.as_raw();
    // Another user's, but for a group of which this process is, at a place that no stranger can
    // write to.
    let is_lent = !is_known
        && (stat.st_gid == getegid().as_raw()
            || getgroups().is_ok_and(|groups| groups.iter().any(|g| g.as_raw() == stat.st_gid)))
        && path.parent().is_some_and(is_closed);
    if !is_known && !is_lent || stat.st_mode & OTHERS_WRITE != 0 {
        return Err(OpenError::Untrusted {
            path: shown,
            why: format!("it belongs to user {}, or others may write to it", stat.st_uid),
            remedy: remedy_elsewhere(),
        });
    }
    checked_above(path).map(|()| folder)
}

/// Refuses a folder that belongs to a stranger, who can exchange what is made in it; but for one
/// like /dev/shm, to which every user may write and which keeps what belongs to whom.
///
/// # Errors
///
/// If it is not there, no folder, or a stranger's.
pub(crate) fn check_owner(path: &Path) -> Result<File, OpenError> {
    let shown = path.display().to_string();
    let folder = open(path)?;
    let stat = fstat(&folder).map_err(OpenError::at("examine", &shown))?;
    let is_known = stat.st_uid == geteuid().as_raw() || stat.st_uid == Uid::ROOT.as_raw();
    let is_public = stat.st_mode & OTHERS_WRITE != 0 && stat.st_mode & STICKY != 0;
    if !is_known && !is_public {
        return Err(OpenError::Untrusted {
            path: shown,
            why: format!("it belongs to user {}", stat.st_uid),
            remedy: remedy_elsewhere(),
        });
    }
    Ok(folder)
}

/// Opens a folder, whatever lies under that name.
fn open(path: &Path) -> Result<File, OpenError> {
    let shown = path.display().to_string();
    let flags = OFlags::DIRECTORY | OFlags::NOFOLLOW | OFlags::NONBLOCK | OFlags::CLOEXEC;
    let opened = openat(CWD, path, flags | OFlags::RDONLY, Mode::empty());
    opened.map(File::from).map_err(|error| match error {
        Errno::LOOP | Errno::NOTDIR => OpenError::Untrusted {
            path: shown.clone(),
            why: format!("it is {}, not a folder", kind_of(path)),
            remedy: remedy_elsewhere(),
        },
        error => OpenError::at("open folder", &shown)(error),
    })
}

fn kind_of(path: &Path) -> &'static str {
    match rustix::fs::lstat(path).map(|stat| FileType::from_raw_mode(stat.st_mode)) {
        Ok(FileType::Symlink) => "a link",
        Ok(FileType::Fifo) => "a pipe",
        Ok(FileType::Socket) => "a socket",
        Ok(FileType::RegularFile) => "a file",
        _ => "something else",
    }
}

fn remedy_elsewhere() -> String {
    "remove it, or set `folder` in the deployment file (or XDG_RUNTIME_DIR) to a folder of this \
     user on a tmpfs"
        .to_owned()
}

/// Whether root and this user alone may write to a folder.
fn is_closed(folder: &Path) -> bool {
    rustix::fs::stat(folder).is_ok_and(|stat| {
        (stat.st_uid == 0 || stat.st_uid == geteuid().as_raw()) && stat.st_mode & WRITE == 0
    })
}

/// Refuses a path on which others may exchange a folder: one that they may write to, and that does
/// not keep what belongs to whom.
fn checked_above(path: &Path) -> Result<(), OpenError> {
    for above in path.ancestors().skip(1).filter(|above| !above.as_os_str().is_empty()) {
        let shown = above.display().to_string();
        let stat = rustix::fs::stat(above).map_err(OpenError::at("examine", &shown))?;
        if stat.st_mode & OTHERS_WRITE != 0 && stat.st_mode & STICKY == 0 {
            return Err(OpenError::Untrusted {
                path: shown.clone(),
                why: "every user may exchange what lies in it".to_owned(),
                remedy: format!("choose another folder, or chmod o-w {shown}"),
            });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests;
