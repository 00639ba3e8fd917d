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
//! A group of clients, where a deployment names one, is inside the trust domain as far as the place
//! of its service goes (`lend`): its members write to memory that the service reads, so they can
//! end it, and answer in its name. What workers share, and all other files, stay closed to them.

use crate::error::OpenError;
use rustix::fs::{AtFlags, CWD, Dir, FileType, Gid, Mode, OFlags, Stat, Uid, fstat, openat};
use rustix::io::Errno;
use rustix::process::{getegid, geteuid, getgroups};
use std::fs::File;
use std::io;
use std::os::fd::{AsFd, AsRawFd as _};
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
const ENTERED: u32 = 0o750;
/// Bits that let the group, others, or both write.
const GROUP_WRITE: u32 = 0o020;
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

/// Whether this process may give files to a group: it is of that group, or root.
#[must_use]
pub fn is_member(group: u32) -> bool {
    geteuid().is_root() || is_of(group)
}

fn is_of(group: u32) -> bool {
    getegid().as_raw() == group
        || getgroups().is_ok_and(|groups| groups.iter().any(|known| known.as_raw() == group))
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
    match rustix::fs::mkdir(path, mode) {
        Ok(()) | Err(Errno::EXIST) => {}
        Err(error) => return Err(OpenError::at("create", &shown)(error)),
    }
    let folder = open(path)?;
    let stat = fstat(&folder).map_err(OpenError::at("examine", &shown))?;
    let refuse =
        |why: String, remedy: String| OpenError::Untrusted { path: shown.clone(), why, remedy };
    if stat.st_uid != geteuid().as_raw() {
        let why = format!("it belongs to user {}", stat.st_uid);
        return Err(refuse(why, remedy_elsewhere()));
    }
    if stat.st_mode & WRITE != 0 {
        let why = format!("others may write to it (mode {:o})", stat.st_mode & 0o7777);
        return Err(refuse(why, format!("chmod 700 {shown}, or remove it")));
    }
    if let Some(group) = group {
        rustix::fs::fchown(&folder, None, Some(Gid::from_raw(group)))
            .and_then(|()| rustix::fs::fchmod(&folder, Mode::from_raw_mode(ENTERED)))
            .map_err(OpenError::at("give to the group of clients", &shown))?;
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
    // Another user's, but for a group of which this process is, where only that user or root could
    // have put it.
    let is_lent = !is_known && is_of(stat.st_gid) && is_out_of_reach(path, stat.st_uid);
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

/// Whether nobody but root and this owner could have put something under this path: so it is up to
/// a folder of root's, to which root alone may write.
fn is_out_of_reach(path: &Path, owner: u32) -> bool {
    let verdict = path.ancestors().skip(1).find_map(|above| {
        let Ok(stat) = rustix::fs::stat(above) else { return Some(false) };
        match stat.st_uid {
            _ if stat.st_mode & WRITE != 0 => Some(false),
            0 => Some(true),
            uid if uid == owner => None,
            _ => Some(false),
        }
    });
    verdict.unwrap_or(false)
}

/// Refuses a folder for shared files which a group of clients could not reach, or would not trust.
///
/// # Errors
///
/// With the first folder on the way that is closed to the group, or if strangers could plant this
/// one before a service makes it: clients of other users refuse such a folder.
pub(crate) fn check_reach(path: &Path, group: u32) -> Result<(), OpenError> {
    for folder in path.ancestors().filter(|folder| !folder.as_os_str().is_empty()) {
        let shown = folder.display().to_string();
        let stat = rustix::fs::stat(folder).map_err(OpenError::at("examine", &shown))?;
        let is_for_group = stat.st_gid == group && stat.st_mode & 0o010 != 0;
        if !is_for_group && stat.st_mode & 0o001 == 0 {
            return Err(OpenError::Closed { path: shown, group });
        }
    }
    let owner = geteuid();
    if owner.is_root() || is_out_of_reach(path, owner.as_raw()) {
        return Ok(());
    }
    Err(OpenError::Untrusted {
        path: path.display().to_string(),
        why: "clients of a group refuse a folder that strangers could make before its service"
            .to_owned(),
        remedy: "set `folder` in the deployment file to one in a folder to which root alone may \
                 write, as systemd's RuntimeDirectory"
            .to_owned(),
    })
}

/// The group to which a folder is [lent](lend), if any, and if this process may lend to it: a
/// client of the service's own user need not be of that group.
pub(crate) fn borrower(folder: &Path) -> Option<u32> {
    let stat = rustix::fs::stat(folder).ok()?;
    (stat.st_mode & GROUP_WRITE != 0 && is_member(stat.st_gid)).then_some(stat.st_gid)
}

/// Gives a group the owner's rights to a file, or to a folder and all in it, which comes
/// first. What is not this user's stays as it is, and so do links and files with several names:
/// a member may have planted them.
pub(crate) fn lend(at: impl AsFd, name: &Path, group: u32) -> io::Result<()> {
    let flags = OFlags::PATH | OFlags::NOFOLLOW | OFlags::CLOEXEC;
    let file = openat(at, name, flags, Mode::empty())?;
    let stat = fstat(&file)?;
    if !is_own(&stat) {
        return Ok(());
    }
    if FileType::from_raw_mode(stat.st_mode).is_dir() {
        let flags = OFlags::DIRECTORY | OFlags::RDONLY | OFlags::CLOEXEC;
        let folder = openat(&file, ".", flags, Mode::empty())?;
        for entry in Dir::read_from(&folder)? {
            let entry = entry?;
            let name = entry.file_name().to_bytes();
            if name == b"." || name == b".." {
                continue;
            }
            match lend(&folder, Path::new(std::ffi::OsStr::from_bytes(name)), group) {
                // Gone meanwhile.
                Err(error) if error.kind() == io::ErrorKind::NotFound => {}
                lent => lent?,
            }
        }
    }
    let gid = Some(Gid::from_raw(group));
    rustix::fs::chownat(&file, c"", None, gid, AtFlags::EMPTY_PATH)?;
    // No call changes the mode of what was opened in this way, but by its name.
    let opened = format!("/proc/self/fd/{}", file.as_raw_fd());
    Ok(rustix::fs::chmod(opened, with_group(stat.st_mode))?)
}

/// Gives a group the owner's rights to an open file of this process.
pub(crate) fn lend_file(file: impl AsFd, group: u32) -> rustix::io::Result<()> {
    let stat = fstat(&file)?;
    rustix::fs::fchown(&file, None, Some(Gid::from_raw(group)))?;
    rustix::fs::fchmod(&file, with_group(stat.st_mode))
}

/// The owner's rights, for the group as well and for nobody else.
fn with_group(mode: u32) -> Mode {
    let owner = mode & 0o700;
    Mode::from_raw_mode(owner | owner >> 3)
}

/// Whether something is of this user, and under one name alone.
fn is_own(stat: &Stat) -> bool {
    let kind = FileType::from_raw_mode(stat.st_mode);
    stat.st_uid == geteuid().as_raw() && !kind.is_symlink() && (kind.is_dir() || stat.st_nlink == 1)
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
