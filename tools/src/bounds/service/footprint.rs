//! What processes and a folder of shared memory take, as the kernel says; and requests that ask for
//! as much as a request may. For a test, and for `cargo x bounds`.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

/// What a process has taken.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Taken {
    /// Most resident memory but for mapped files (bytes).
    pub(crate) own_bytes: u64,
    /// Mapped files: the program and its libraries (bytes).
    pub(crate) program_bytes: u64,
    /// Most open descriptors that were seen.
    pub(crate) descriptors: u64,
    /// Most threads that were seen.
    pub(crate) threads: u64,
}

impl Taken {
    /// Looks at a process; one that has gone changes nothing.
    pub(crate) fn look(&mut self, pid: u32) {
        let Ok(status) = fs::read_to_string(format!("/proc/{pid}/status")) else { return };
        let field = |name: &str| {
            let line = status.lines().find_map(|line| line.strip_prefix(name))?;
            line.split_whitespace().next()?.parse::<u64>().ok()
        };
        let kib = |name: &str| field(name).unwrap_or(0) << 10;
        let files = kib("RssFile:");
        self.own_bytes = self.own_bytes.max(kib("VmHWM:").saturating_sub(files));
        self.program_bytes = self.program_bytes.max(files);
        self.threads = self.threads.max(field("Threads:").unwrap_or(0));
        let open = fs::read_dir(format!("/proc/{pid}/fd")).map_or(0, |fds| fds.count() as u64);
        self.descriptors = self.descriptors.max(open);
    }
}

/// Segments below a folder, and the bytes of all files there.
pub(crate) fn folder(of: &Path) -> (u64, u64) {
    use std::os::unix::fs::MetadataExt as _;
    const SEGMENTS: [&str; 5] = [".data", ".connection", ".dynamic", ".event_mgmt", ".global_mgmt"];
    let (mut segments, mut bytes) = (0, 0);
    let mut folders = vec![of.to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
            let Ok(about) = entry.path().symlink_metadata() else { continue };
            if about.is_dir() {
                folders.push(entry.path());
                continue;
            }
            bytes += about.blocks() * 512;
            let name = entry.file_name().to_string_lossy().into_owned();
            segments += u64::from(SEGMENTS.iter().any(|ending| name.ends_with(ending)));
        }
    }
    (segments, bytes)
}

/// A scenario with as many candidates, parties, paths and states as a request may have.
pub(crate) fn largest_request(triangles: u32, members: u32) -> String {
    const STATES: u32 = 64;
    let mut text = format!(
        "schema = \"trolley.scenario/2\"\nname = \"as much as may be asked\"\nmembers = {members}\n\
         members_max = {members}\n[parties]\n\
         ego = {{ generate = {{ shape = \"sedan\", triangles = {triangles} }} }}\n"
    );
    let time = |state: u32| f64::from(state) * 5.0 / f64::from(STATES - 1);
    for party in 0..31 {
        let (x, y) = (10.0 + f64::from(party % 8) * 8.0, f64::from(party / 8) * 9.0 - 14.0);
        let path = |share: f64, sway: f64| {
            let mut states = format!("{{ probability = {share}, states = [");
            for t in (0..STATES).map(time) {
                let place = [x - 3.0 * t, y + sway * t.sin(), 0.0];
                let _ok = write!(states, "{{ t_s = {t:.4}, position_m = {place:?} }}, ");
            }
            states + "] }"
        };
        let paths = [path(0.4, 0.3), path(0.3, 0.6), path(0.3, -0.3)].join(", ");
        let _ok = write!(
            text,
            "[parties.p{party}]\ngenerate = {{ shape = \"suv\", triangles = {triangles} }}\n\
             paths = [{paths}]\n"
        );
    }
    for candidate in 0..16 {
        let bend = f64::from(candidate) * 1.6 - 12.0;
        let _ok = write!(text, "[[candidates]]\nname = \"c{candidate}\"\npath = {{ states = [");
        for t in (0..STATES).map(time) {
            let yaw = (bend * t / 2.0).atan2(18.0).to_degrees();
            let place = [18.0 * t, bend * t * t / 4.0, 0.0];
            let _ok =
                write!(text, "{{ t_s = {t:.4}, position_m = {place:?}, yaw_deg = {yaw:.4} }}, ");
        }
        text += "] }\n";
    }
    text
}
