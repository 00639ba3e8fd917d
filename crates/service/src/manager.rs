//! What the service tells systemd, or a supervisor that speaks the same protocol: sd_notify(3).
//!
//! A manager that does not read what it is sent must not hold the service up: a ping of the
//! watchdog is not waited for, and its loss is made good by the next one; whatever else there is to
//! say is waited for a tenth of a second at most.

use core::cell::Cell;
use core::time::Duration;
use runtime::clock;
use std::ffi::OsStr;
use std::io;
use std::os::linux::net::SocketAddrExt as _;
use std::os::unix::ffi::OsStrExt as _;
use std::os::unix::net::{SocketAddr, UnixDatagram};

/// Where the manager listens.
const SOCKET: &str = "NOTIFY_SOCKET";
/// How long it waits for a ping (µs), and whose.
const WATCHDOG_US: &str = "WATCHDOG_USEC";
const WATCHDOG_PID: &str = "WATCHDOG_PID";
/// How long a message that is no ping may take (ms).
const SEND_MS: u64 = 100;
/// How much more often than it must the service pings: two in a row may be late.
const PINGS: u64 = 3;

/// Who started this service and watches it, if anybody does.
#[derive(Debug)]
pub(crate) struct Manager {
    socket: Option<(UnixDatagram, SocketAddr)>,
    /// Interval between pings (ns); `None`: nobody waits for them.
    every_ns: Option<u64>,
    pinged_ns: Cell<u64>,
}

impl Manager {
    /// The one that the environment names.
    pub(crate) fn from_environment() -> Self {
        let socket = std::env::var_os(SOCKET).filter(|path| !path.is_empty());
        let number = |name| std::env::var_os(name)?.to_str()?.parse::<u64>().ok();
        let is_meant = number(WATCHDOG_PID).is_none_or(|pid| pid == u64::from(std::process::id()));
        let wait_us = number(WATCHDOG_US).filter(|wait_us| *wait_us > 0 && is_meant);
        let manager = Self::new(socket.as_deref(), wait_us);
        if manager.socket.is_none()
            && let Some(path) = socket
        {
            tracing::warn!(path = %path.display(), "{SOCKET} cannot be used");
        }
        manager
    }

    fn new(socket: Option<&OsStr>, wait_us: Option<u64>) -> Self {
        let socket = socket.and_then(|path| {
            let address = match path.as_bytes().strip_prefix(b"@") {
                Some(name) => SocketAddr::from_abstract_name(name),
                None => SocketAddr::from_pathname(path),
            };
            let socket = UnixDatagram::unbound().ok()?;
            socket.set_write_timeout(Some(Duration::from_millis(SEND_MS))).ok()?;
            Some((socket, address.ok()?))
        });
        let every_ns = wait_us.map(|wait_us| wait_us.saturating_mul(1_000) / PINGS);
        Self { socket, every_ns, pinged_ns: Cell::new(0) }
    }

    /// The service answers requests from now on.
    pub(crate) fn ready(&self) {
        self.say(b"READY=1\n", false);
    }

    /// The service is ending.
    pub(crate) fn stopping(&self) {
        self.say(b"STOPPING=1\n", false);
    }

    /// The calling thread is at work. To be called again and again; says so when it is time.
    pub(crate) fn ping(&self) {
        let Some(every_ns) = self.every_ns else { return };
        let now_ns = clock::now_ns();
        if now_ns - self.pinged_ns.get() >= every_ns {
            self.pinged_ns.set(now_ns);
            self.say(b"WATCHDOG=1\n", true);
        }
    }

    fn say(&self, message: &[u8], is_ping: bool) {
        let Some((socket, address)) = &self.socket else { return };
        let said =
            socket.set_nonblocking(is_ping).and_then(|()| socket.send_to_addr(message, address));
        match said {
            Ok(_) => {}
            // Whoever has not read the last ten pings needs no other.
            Err(error) if is_ping && error.kind() == io::ErrorKind::WouldBlock => {}
            Err(error) => tracing::debug!(%error, "the manager of this service cannot be told"),
        }
    }
}

#[cfg(test)]
mod tests {
    //! What is said arrives; a manager that does not read holds nobody up.
    use super::*;

    const MS: u64 = 1_000_000;

    fn listener(folder: &tempfile::TempDir) -> (UnixDatagram, std::path::PathBuf) {
        let path = folder.path().join("notify");
        let listener = UnixDatagram::bind(&path).unwrap();
        listener.set_nonblocking(true).unwrap();
        (listener, path)
    }

    fn heard(listener: &UnixDatagram) -> Option<String> {
        let mut message = [0; 64];
        let len = listener.recv(&mut message).ok()?;
        Some(String::from_utf8_lossy(&message[..len]).into_owned())
    }

    #[test]
    fn a_manager_hears_three_pings_in_its_time_and_what_else_there_is() {
        let folder = tempfile::tempdir().unwrap();
        let (listener, path) = listener(&folder);
        let manager = Manager::new(Some(path.as_os_str()), Some(60_000));
        manager.ready();
        let begun_ns = clock::now_ns();
        while clock::now_ns() - begun_ns < 60 * MS {
            manager.ping();
        }
        manager.stopping();
        let said: Vec<String> = core::iter::from_fn(|| heard(&listener)).collect();
        assert_eq!(said.first().map(String::as_str), Some("READY=1\n"));
        assert_eq!(said.last().map(String::as_str), Some("STOPPING=1\n"));
        let pings = said.iter().filter(|said| *said == "WATCHDOG=1\n").count();
        assert!((1..=4).contains(&pings), "{said:?}");
    }

    #[test]
    fn a_manager_that_does_not_read_holds_nobody_up() {
        let folder = tempfile::tempdir().unwrap();
        let (_never_read, path) = listener(&folder);
        let manager = Manager::new(Some(path.as_os_str()), Some(3));
        let begun_ns = clock::now_ns();
        for _ in 0..1_000 {
            manager.ping();
        }
        manager.ready();
        let took_ms = (clock::now_ns() - begun_ns) / MS;
        assert!((SEND_MS..10 * SEND_MS).contains(&took_ms), "{took_ms} ms");
    }

    #[test]
    fn without_a_manager_nothing_is_said() {
        let manager = Manager::new(None, None);
        manager.ready();
        manager.ping();
        let gone = Manager::new(Some("/nowhere/at/all".as_ref()), Some(1));
        gone.ready();
        gone.ping();
    }
}
