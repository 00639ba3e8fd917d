//! The socket on which a supervisor hears from its service, by the protocol of sd_notify(3).
//!
//! It has a name, in a private folder, only while it is made. The service gets a descriptor that
//! refers to its file and reaches it through `/proc/self/fd`, so no other process can write to it,
//! and nothing is left of it, however its supervisor ends.

use super::{Address, place};
use crate::error::OpenError;
use crate::folder;
use crate::place::remove_if_empty;
use rustix::fs::{Mode, OFlags, openat, unlinkat};
use rustix::io::Errno;
use rustix::net::{AddressFamily, SocketAddrUnix, SocketFlags, SocketType};
use std::fs::File;
use std::os::fd::{AsFd, AsRawFd as _, BorrowedFd, OwnedFd};

/// Longest message that is understood (bytes); the rest of a longer one is dropped.
const MESSAGE_MAX: usize = 256;

/// What a service says of itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Notice {
    /// It answers requests from now on.
    Ready,
    /// The thread that answers is at work.
    Alive,
    /// It is ending.
    Stopping,
    /// Something else.
    Other,
}

impl Notice {
    fn of(message: &[u8]) -> Self {
        let says = |line: &[u8]| message.split(|byte| *byte == b'\n').any(|said| said == line);
        match () {
            () if says(b"STOPPING=1") => Self::Stopping,
            () if says(b"READY=1") => Self::Ready,
            () if says(b"WATCHDOG=1") => Self::Alive,
            () => Self::Other,
        }
    }
}

/// The supervisor's end.
#[derive(Debug)]
pub struct NotifySocket {
    socket: OwnedFd,
    /// Its file, which has no name any more.
    file: OwnedFd,
}

impl NotifySocket {
    /// Makes one, in the folder that the service will use.
    ///
    /// # Errors
    ///
    /// If that folder cannot be made or trusted, or file descriptors ran out.
    pub fn create(address: &Address) -> Result<Self, OpenError> {
        let path = address.root().parent().unwrap_or(address.root());
        let shown = path.display().to_string();
        let folder = place::above(address)?;
        let made = Self::create_in(&folder, std::process::id());
        // The service makes it again: if it cannot start, nothing is left.
        if *path == folder::default_folder() {
            remove_if_empty(path);
        }
        made.map_err(OpenError::at("make a socket in", &shown))
    }

    fn create_in(folder: &File, pid: u32) -> Result<Self, Errno> {
        let name = format!(".notify.{pid}");
        let flags = SocketFlags::CLOEXEC | SocketFlags::NONBLOCK;
        let socket = rustix::net::socket_with(AddressFamily::UNIX, SocketType::DGRAM, flags, None)?;
        // Its file gets these permissions, less the umask.
        rustix::fs::fchmod(&socket, Mode::RUSR | Mode::WUSR)?;
        // Of one that was killed here, when this process had another's id.
        match unlinkat(folder, &name, rustix::fs::AtFlags::empty()) {
            Ok(()) | Err(Errno::NOENT) => {}
            Err(error) => return Err(error),
        }
        // Short, whatever the folder: the path of a socket has at most 107 bytes.
        let path = format!("/proc/self/fd/{}/{name}", folder.as_raw_fd());
        rustix::net::bind(&socket, &SocketAddrUnix::new(path)?)?;
        let flags = OFlags::PATH | OFlags::NOFOLLOW | OFlags::CLOEXEC;
        let opened = openat(folder, &name, flags, Mode::empty());
        unlinkat(folder, &name, rustix::fs::AtFlags::empty())?;
        Ok(Self { socket, file: opened? })
    }

    /// Its file, for the service to inherit.
    #[must_use]
    pub fn file(&self) -> BorrowedFd<'_> {
        self.file.as_fd()
    }

    /// The value of `NOTIFY_SOCKET` for a process that inherits the file under this number.
    #[must_use]
    pub fn path_for(number: i32) -> String {
        format!("/proc/self/fd/{number}")
    }

    /// Becomes readable when the service says something.
    #[must_use]
    pub fn fd(&self) -> BorrowedFd<'_> {
        self.socket.as_fd()
    }

    /// The next thing that it said; `None` if there is nothing more. Never waits.
    #[must_use]
    pub fn take(&self) -> Option<Notice> {
        let mut message = [0; MESSAGE_MAX];
        let none = rustix::net::RecvFlags::DONTWAIT;
        let (len, _) = rustix::net::recv(&self.socket, &mut message, none).ok()?;
        Some(Notice::of(message.get(..len).unwrap_or_default()))
    }
}

#[cfg(test)]
mod tests {
    //! What is sent arrives, and no name is left.
    use super::*;
    use std::os::unix::net::UnixDatagram;

    fn address(folder: &tempfile::TempDir) -> Address {
        Address::new(Some(folder.path()), "notify").unwrap()
    }

    #[test]
    fn a_socket_without_a_name_hears_what_its_service_says() {
        let folder = tempfile::tempdir().unwrap();
        let socket = NotifySocket::create(&address(&folder)).unwrap();
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0, "it has no name");
        assert_eq!(socket.take(), None);
        let service = UnixDatagram::unbound().unwrap();
        let path = NotifySocket::path_for(socket.file().as_raw_fd());
        for (said, heard) in [
            ("READY=1\n", Notice::Ready),
            ("STATUS=warm\nWATCHDOG=1\n", Notice::Alive),
            ("STOPPING=1", Notice::Stopping),
            ("READY=10", Notice::Other),
            ("", Notice::Other),
        ] {
            service.send_to(said.as_bytes(), &path).unwrap();
            assert_eq!(socket.take(), Some(heard), "{said}");
        }
        let long = vec![b'x'; 10 * MESSAGE_MAX];
        service.send_to(&long, &path).unwrap();
        assert_eq!(socket.take(), Some(Notice::Other));
        assert_eq!(socket.take(), None);
    }

    #[test]
    fn its_owner_alone_may_write_to_it() {
        let folder = tempfile::tempdir().unwrap();
        let socket = NotifySocket::create(&address(&folder)).unwrap();
        let mode = rustix::fs::fstat(socket.file()).unwrap().st_mode;
        assert_eq!(mode & 0o077, 0, "{mode:o}");
    }

    #[test]
    fn a_name_that_a_killed_supervisor_left_is_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let left = folder.path().join(format!(".notify.{}", std::process::id()));
        let _killed = UnixDatagram::bind(&left).unwrap();
        let _socket = NotifySocket::create(&address(&folder)).unwrap();
        assert!(!left.exists());
    }
}
