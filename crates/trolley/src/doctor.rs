//! Checks of this machine: what the service needs, what is missing, and what to do about it.
//!
//! The checks change nothing, and use nothing that the service would not use. A *problem* stops the
//! service from working or from keeping its promises; a *note* makes it slower or less predictable.
//!
//! ```
//! use trolley::doctor::{self, FindingLevel};
//!
//! for finding in doctor::look() {
//!     if finding.level != FindingLevel::Ok {
//!         println!("{}: {}; {}", finding.subject, finding.found, finding.remedy);
//!     }
//! }
//! ```

mod adversary;
mod cost;
mod deployment;

pub use cost::{KindCost, TestCosts};
pub use deployment::{DeploymentBounds, TimeBound};
pub use service::{ProcessBound, ResourceBounds};

use crate::BUILD;
use runtime::{affinity, realtime};
use serde::Serialize;
use std::fmt::{self, Display, Formatter};
use std::fs;

/// Shared memory that a service of four workers and sixteen clients takes at most (bytes).
const SHM_BYTES: u64 = 64 << 20;
/// Locked memory below which no service can lock what it has (bytes).
const LOCKED_BYTES: u64 = 1 << 30;
/// Descriptors that a service with sixteen clients may open.
const FILES: u64 = 1024;
/// Priority of the coordinator in the deployments that are shipped.
const PRIORITY: u64 = 60;

/// How serious a [`Finding`] is.
///
/// ```
/// use trolley::doctor::{FindingLevel, look};
///
/// let is_able = look().iter().all(|finding| finding.level != FindingLevel::Problem);
/// println!("the service can run: {is_able}");
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum FindingLevel {
    /// As it should be.
    Ok,
    /// Slower or less predictable.
    Note,
    /// The service cannot work, or cannot keep its promises.
    Problem,
}

/// The result of one check.
///
/// ```
/// let mut findings = trolley::doctor::look().into_iter();
/// let versions = findings.find(|finding| finding.subject == "versions");
/// assert!(versions.is_some_and(|finding| finding.found.contains(trolley::BUILD)));
/// ```
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Finding {
    /// What was checked.
    pub subject: &'static str,
    /// How serious it is.
    pub level: FindingLevel,
    /// What was found.
    pub found: String,
    /// What it costs, and what to do about it; empty if nothing needs to be done.
    pub remedy: String,
}

fn finding(
    subject: &'static str,
    level: FindingLevel,
    found: impl Into<String>,
    remedy: &str,
) -> Finding {
    let remedy = if level == FindingLevel::Ok { String::new() } else { remedy.to_owned() };
    Finding { subject, level, found: found.into(), remedy }
}

/// Everything that was found: about this machine, and about a deployment on it.
///
/// ```
/// let report = trolley::doctor::DoctorReport::with(None);
/// assert!(report.to_string().contains("cores"));
/// println!("something is missing: {}", report.has_problem());
/// ```
#[derive(Clone, Debug, Serialize)]
pub struct DoctorReport {
    schema: &'static str,
    build: &'static str,
    /// About this machine.
    pub findings: Vec<Finding>,
    /// About a deployment.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub deployment: Option<DeploymentBounds>,
}

impl DoctorReport {
    /// Checks this machine, beside what was found about a deployment.
    ///
    /// ```
    /// let report = trolley::doctor::DoctorReport::with(None);
    /// assert!(!report.findings.is_empty() && report.deployment.is_none());
    /// ```
    #[must_use]
    pub fn with(deployment: Option<DeploymentBounds>) -> Self {
        Self { schema: "trolley.doctor/1", build: BUILD, findings: look(), deployment }
    }

    /// Whether the service, or the deployment, cannot work here or cannot keep its promises.
    ///
    /// ```
    /// # use trolley::doctor::{FindingLevel, DoctorReport};
    /// let report = DoctorReport::with(None);
    /// let is_problem = |found: &trolley::doctor::Finding| found.level == FindingLevel::Problem;
    /// assert_eq!(report.has_problem(), report.findings.iter().any(is_problem));
    /// ```
    #[must_use]
    pub fn has_problem(&self) -> bool {
        let of_deployment = self.deployment.iter().flat_map(|bounds| &bounds.findings);
        let mut all = self.findings.iter().chain(of_deployment);
        all.any(|finding| finding.level == FindingLevel::Problem)
    }
}

impl Display for DoctorReport {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        self.findings.iter().try_for_each(|finding| finding.fmt(f))?;
        self.deployment.iter().try_for_each(|bounds| write!(f, "\n{bounds}"))
    }
}

impl Display for Finding {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Self { subject, level, found, remedy } = self;
        let mark = match level {
            FindingLevel::Ok => "ok",
            FindingLevel::Note => "note",
            FindingLevel::Problem => "PROBLEM",
        };
        writeln!(f, "{mark:<8} {subject:<16} {found}")?;
        if !remedy.is_empty() {
            writeln!(f, "{:25} → {remedy}", "")?;
        }
        Ok(())
    }
}

/// Checks the machine that this process runs on, with the rights that it has.
///
/// ```
/// let findings = trolley::doctor::look();
/// assert!(findings.iter().any(|finding| finding.subject == "cores"));
/// ```
#[must_use]
pub fn look() -> Vec<Finding> {
    vec![
        cores(),
        isolation(),
        ticks(),
        governor(),
        preemption(),
        throttling(),
        priority(),
        locked_memory(),
        descriptors(),
        swap(),
        shared_memory(),
        leftovers(),
        counters(),
        versions(),
    ]
}

/// The text of a file of /proc or /sys, trimmed.
fn read(path: &str) -> Option<String> {
    fs::read_to_string(path).ok().map(|text| text.trim().to_owned())
}

fn cores() -> Finding {
    let cores = affinity::allowed_cores();
    let found = format!("{} granted: {cores:?}", cores.len());
    let level = if cores.len() >= 4 { FindingLevel::Ok } else { FindingLevel::Note };
    finding(
        "cores",
        level,
        found,
        "four workers want four cores; with fewer use config/deployments/dual-core.toml, or widen \
         the cpuset",
    )
}

fn isolation() -> Finding {
    let isolated = read("/sys/devices/system/cpu/isolated").unwrap_or_default();
    let level = if isolated.is_empty() { FindingLevel::Note } else { FindingLevel::Ok };
    let found = if isolated.is_empty() { "no core is isolated".to_owned() } else { isolated };
    finding(
        "isolation",
        level,
        found,
        "other processes may run in between; kernel command line: \
         isolcpus=managed_irq,domain,1-3 nohz_full=1-3 rcu_nocbs=1-3 irqaffinity=0",
    )
}

fn ticks() -> Finding {
    let line = read("/proc/cmdline").unwrap_or_default();
    let value = |key: &str| {
        let found = line.split(' ').find_map(|word| word.strip_prefix(key)?.strip_prefix('='));
        found.unwrap_or("none").to_owned()
    };
    let [ticks, callbacks] = ["nohz_full", "rcu_nocbs"].map(value);
    let is_quiet = ticks != "none" && callbacks != "none";
    let level = if is_quiet { FindingLevel::Ok } else { FindingLevel::Note };
    let found = format!("nohz_full: {ticks}, rcu_nocbs: {callbacks}");
    let remedy = "timer and callbacks of the kernel interrupt workers; kernel command line: \
                  nohz_full=1-3 rcu_nocbs=1-3";
    finding("kernel ticks", level, found, remedy)
}

fn governor() -> Finding {
    let mut governors = Vec::new();
    for core in affinity::allowed_cores() {
        let path = format!("/sys/devices/system/cpu/cpu{core}/cpufreq/scaling_governor");
        governors.extend(read(&path));
    }
    governors.sort_unstable();
    governors.dedup();
    if governors.is_empty() {
        let remedy = "nothing to do here: a virtual machine, or the firmware decides";
        return finding("governor", FindingLevel::Note, "the kernel does not say", remedy);
    }
    let level = if governors == ["performance"] { FindingLevel::Ok } else { FindingLevel::Note };
    let remedy = "clocks fall while nothing is asked: cpupower frequency-set -g performance";
    finding("governor", level, governors.join(", "), remedy)
}

fn preemption() -> Finding {
    let version = read("/proc/sys/kernel/version").unwrap_or_default();
    let is_realtime = read("/sys/kernel/realtime").as_deref() == Some("1");
    let is_realtime = is_realtime || version.contains("PREEMPT_RT");
    let level = match version.contains("PREEMPT") {
        true => FindingLevel::Ok,
        false => FindingLevel::Note,
    };
    let model = if is_realtime { "PREEMPT_RT, " } else { "" };
    let remedy = "calls of other processes into the kernel may delay the service: use a \
                  kernel with PREEMPT or PREEMPT_RT";
    let release = read("/proc/sys/kernel/osrelease").unwrap_or_default();
    finding("kernel", level, format!("{model}{release} {version}"), remedy)
}

fn throttling() -> Finding {
    let runtime_us = read("/proc/sys/kernel/sched_rt_runtime_us");
    let runtime_us = runtime_us.and_then(|text| text.parse::<i64>().ok()).unwrap_or(-1);
    let level = if runtime_us == -1 { FindingLevel::Ok } else { FindingLevel::Note };
    let found = if level == FindingLevel::Ok {
        "none".to_owned()
    } else {
        format!("fixed priorities run {} ms of each second", runtime_us / 1000)
    };
    let remedy = "with idle = \"spin\" and a fixed priority the service pauses 50 ms each second; \
                  use park, or sysctl kernel.sched_rt_runtime_us=-1";
    finding("RT throttling", level, found, remedy)
}

/// Whether this process has a capability, by its number in `linux/capability.h`.
fn has_capability(number: u32) -> bool {
    let status = read("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("CapEff:"));
    let bits = line.and_then(|line| u64::from_str_radix(line.trim(), 16).ok()).unwrap_or(0);
    bits >> number & 1 == 1
}

/// CAP_IPC_LOCK and CAP_SYS_NICE.
const IPC_LOCK: u32 = 14;
const SYS_NICE: u32 = 23;

fn priority() -> Finding {
    let [_, priority, _] = realtime::limits();
    let may = has_capability(SYS_NICE) || priority.is_none_or(|most| most >= PRIORITY);
    let found = match (has_capability(SYS_NICE), priority) {
        (true, _) => "SCHED_FIFO by CAP_SYS_NICE".to_owned(),
        (false, None) => "SCHED_FIFO at any priority".to_owned(),
        (false, Some(most)) => format!("SCHED_FIFO up to {most}"),
    };
    let remedy = "answers wait for other processes: LimitRTPRIO=80 in the unit, or rtprio in \
                  /etc/security/limits.d";
    finding(
        "fixed priority",
        if may { FindingLevel::Ok } else { FindingLevel::Note },
        found,
        remedy,
    )
}

fn locked_memory() -> Finding {
    let [locked, _, _] = realtime::limits();
    let may = has_capability(IPC_LOCK) || locked.is_none_or(|most| most >= LOCKED_BYTES);
    let found = match (has_capability(IPC_LOCK), locked) {
        (true, _) => "any amount by CAP_IPC_LOCK".to_owned(),
        (false, None) => "no limit".to_owned(),
        (false, Some(most)) => format!("{} kB", most / 1024),
    };
    let remedy = "page faults may delay answers: LimitMEMLOCK=infinity in the unit, or memlock in \
                  /etc/security/limits.d";
    finding("locked memory", if may { FindingLevel::Ok } else { FindingLevel::Note }, found, remedy)
}

fn descriptors() -> Finding {
    let [_, _, files] = realtime::limits();
    let enough = files.is_none_or(|most| most >= FILES);
    let found = files.map_or("no limit".to_owned(), |most| most.to_string());
    let remedy = "clients may be refused: LimitNOFILE=4096 in the unit, or ulimit -n 4096";
    finding(
        "descriptors",
        if enough { FindingLevel::Ok } else { FindingLevel::Problem },
        found,
        remedy,
    )
}

fn swap() -> Finding {
    let swaps = read("/proc/swaps").unwrap_or_default();
    let count = swaps.lines().count().saturating_sub(1);
    let level = if count == 0 { FindingLevel::Ok } else { FindingLevel::Note };
    let found = if count == 0 { "none".to_owned() } else { format!("{count} in use") };
    finding("swap", level, found, "memory that is not locked may be on a disk: swapoff -a")
}

fn shared_memory() -> Finding {
    let folder = shared_folder();
    // The folder itself may not exist yet.
    let place = folder.ancestors().find(|above| above.exists()).unwrap_or(&folder);
    let remedy = "the service needs 64 MiB: mount -o remount,size=256M /dev/shm; in a container \
                  --shm-size=256m";
    match rustix::fs::statvfs(place) {
        Ok(about) => {
            let free = about.f_bavail * about.f_frsize;
            let size = about.f_blocks * about.f_frsize;
            let level = if free >= SHM_BYTES { FindingLevel::Ok } else { FindingLevel::Problem };
            let place = place.display();
            let found = format!("{} of {} MiB free in {place}", free >> 20, size >> 20);
            finding("memory", level, found, remedy)
        }
        Err(error) => {
            let found = format!("{}: {error}", place.display());
            finding("memory", FindingLevel::Problem, found, remedy)
        }
    }
}

fn leftovers() -> Finding {
    let dead = transport::dead_instances(&shared_folder());
    let level = if dead.is_empty() { FindingLevel::Ok } else { FindingLevel::Note };
    let found = if dead.is_empty() { "none".to_owned() } else { dead.join(", ") };
    let remedy = "of runs that were killed; the next run of their kind removes them, or \
                  trolley demo, and of a service: start and stop it";
    finding("leftovers", level, found, remedy)
}

fn counters() -> Finding {
    match runtime::counters::HardwareCounters::of(std::process::id()) {
        Ok(_) => {
            finding("counters", FindingLevel::Ok, "instructions and cache misses are counted", "")
        }
        Err(error) => {
            let cause = std::error::Error::source(&error).map(ToString::to_string);
            let found = format!("not available: {}", cause.unwrap_or_else(|| error.to_string()));
            let remedy = "reports say so and count bytes instead; a virtual machine often has \
                          none, elsewhere CAP_PERFMON";
            finding("counters", FindingLevel::Note, found, remedy)
        }
    }
}

fn versions() -> Finding {
    let found = format!("trolley {BUILD}, iceoryx2 0.10.0, layouts v{}", protocol::public::VERSION);
    finding("versions", FindingLevel::Ok, found, "")
}

/// The folder of all that runs and services of this user share, unless a deployment names another.
///
/// `$RUNTIME_DIRECTORY` under systemd, `trolley` in `$XDG_RUNTIME_DIR` if that is a tmpfs, else
/// `/dev/shm/trolley-UID`. Nothing is created.
///
/// ```
/// assert!(trolley::doctor::shared_folder().is_absolute());
/// ```
#[must_use]
pub fn shared_folder() -> std::path::PathBuf {
    transport::default_folder()
}
