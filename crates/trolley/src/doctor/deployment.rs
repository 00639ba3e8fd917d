//! What a deployment takes of a machine, and how long its work may take, before it is started.

use super::cost::TestCosts;
use super::{Finding, FindingLevel, finding};
use crate::bodies::Bodies;
use crate::{Failure, OpenDeployment};
use coordinator::RequestLimits;
use runtime::{affinity, machine, realtime};
use serde::Serialize;
use service::{ResourceBounds, SealedModels};
use std::fmt::{self, Display, Formatter};

/// What a deployment takes at most.
///
/// Sizes are computed from the deployment and the models that it names. Times are bounds made of
/// what was measured on this machine, by jobs that are made to be dear: *measured bounds, not
/// WCETs*. [`Display`] shows them as tables.
///
/// ```
/// use trolley::OpenDeployment;
/// use trolley::doctor::DeploymentBounds;
///
/// let opened = OpenDeployment::open("../../config/deployments/minimal.toml".as_ref(), None)?;
/// let bounds = DeploymentBounds::find(&opened, 1_000, false)?;
/// assert_eq!(bounds.footprint.processes.len(), 2);
/// println!("{bounds}");
/// # Ok::<(), trolley::Failure>(())
/// ```
#[derive(Clone, Debug, Serialize)]
pub struct DeploymentBounds {
    /// Name of the instance.
    pub instance: String,
    /// Memory, descriptors, threads, shared memory.
    pub footprint: ResourceBounds,
    /// What jobs cost.
    pub costs: TestCosts,
    /// How long it may take, row by row.
    pub times: Vec<TimeBound>,
    /// Whether this machine grants what the deployment takes.
    pub findings: Vec<Finding>,
}

/// How long something may take.
///
/// ```
/// # let file = "../../config/deployments/minimal.toml";
/// # let opened = trolley::OpenDeployment::open(file.as_ref(), None)?;
/// let bounds = trolley::doctor::DeploymentBounds::find(&opened, 1_000, true)?;
/// let jobs = bounds.times.iter().filter_map(|row| row.bound_ns.zip(row.measured_ns));
/// assert!(jobs.into_iter().all(|(bound_ns, measured_ns)| measured_ns <= bound_ns));
/// # Ok::<(), trolley::Failure>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TimeBound {
    /// What takes it.
    pub what: String,
    /// The measured bound (ns of CPU time); `None`: only what was measured is known.
    pub bound_ns: Option<u64>,
    /// The most that was measured (ns of CPU time), where it was.
    pub measured_ns: Option<u64>,
}

impl DeploymentBounds {
    /// Computes what a deployment takes, with worker processes or, `in_process`, without; and runs
    /// so many jobs to measure what they cost, on as many cores as are granted.
    ///
    /// ```
    /// # let file = "../../config/deployments/minimal.toml";
    /// # let opened = trolley::OpenDeployment::open(file.as_ref(), None)?;
    /// let bounds = trolley::doctor::DeploymentBounds::find(&opened, 1_000, true)?;
    /// assert!(bounds.costs.jobs >= 1_000 && bounds.footprint.total_bytes > 0);
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    ///
    /// # Errors
    ///
    /// If a model cannot be opened or generated.
    pub fn find(opened: &OpenDeployment, jobs: u64, in_process: bool) -> Result<Self, Failure> {
        let deployment = &opened.deployment;
        let bodies = Bodies::of_deployment(opened)?;
        let views = bodies.views()?;
        let triangles = views.iter().map(|(_, body)| body.corners.len());
        let cores = affinity::allowed_cores().len();
        let program = runtime::process::self_exe();
        let models = SealedModels {
            store_bytes: bodies.store().bytes().len(),
            largest_bytes: bodies.largest_bytes(),
            triangles: triangles.clone().sum(),
            largest_triangles: triangles.max().unwrap_or(0),
            program_bytes: std::fs::metadata(program).map_or(0, |file| file.len() as usize),
            cores,
        };
        let footprint = ResourceBounds::of(deployment, &models, in_process);
        let bodies: Vec<_> = views.iter().map(|(_, body)| *body).collect();
        let batch = deployment.engine.batch;
        let costs = TestCosts::measure(&bodies, (jobs, batch, cores))?;
        let findings = findings(opened, &footprint);
        let times = times(&costs, &deployment.engine);
        let instance = deployment.instance.clone();
        Ok(Self { instance, footprint, costs, times, findings })
    }
}

/// The rows of times for these settings.
fn times(costs: &TestCosts, engine: &scenario::EngineSettings) -> Vec<TimeBound> {
    let job_ns = costs.job_bound_ns(RequestLimits::BUDGET);
    let budget = RequestLimits::BUDGET;
    if costs.jobs == 0 {
        return Vec::new();
    }
    let row = |what: &str, bound_ns: Option<u64>, measured_ns: Option<u64>| TimeBound {
        what: what.to_owned(),
        bound_ns,
        measured_ns,
    };
    let (batch, queue) = (engine.batch as u64, engine.queue as u64);
    let [gap_ns, look_gap_ns] = costs.gaps_ns();
    vec![
        row(&format!("a job of {budget} tests"), Some(job_ns), Some(costs.job_ns())),
        row(&format!("a batch of {batch} such jobs"), Some(batch * job_ns), Some(costs.batch_ns)),
        row(&format!("the {queue} that a worker may hold"), Some(queue * job_ns), None),
        row("a job goes on after the deadline", Some(costs.gap_bound_ns()), Some(gap_ns)),
        row("a look in motion goes on after it", None, Some(look_gap_ns)),
    ]
}

/// Whether this machine grants it.
fn findings(opened: &OpenDeployment, footprint: &ResourceBounds) -> Vec<Finding> {
    let deployment = &opened.deployment;
    let service = footprint.processes[0];
    let level = |is_enough: bool| {
        if is_enough { FindingLevel::Ok } else { FindingLevel::Problem }
    };
    let [locked, _, files] = realtime::limits();
    let mut findings = vec![finding(
        "descriptors",
        level(files.is_none_or(|most| most >= service.descriptors)),
        format!("{} of {}", service.descriptors, shown(files)),
        "raise the limit: LimitNOFILE= of the unit, or ulimit -n",
    )];
    let folder = deployment.folder.clone().unwrap_or_else(super::shared_folder);
    let place = folder.ancestors().find(|above| above.exists()).unwrap_or(&folder);
    let free = machine::free_bytes(&place.display().to_string()).unwrap_or(0);
    let needed = footprint.folder_bytes as u64;
    findings.push(finding(
        "shared memory",
        level(free >= needed),
        format!("{} of {} MiB free in {}", needed >> 20, free >> 20, place.display()),
        "mount a larger tmpfs there; in a container --shm-size",
    ));
    if let Some(available) = machine::available_bytes() {
        let needed = footprint.total_bytes as u64;
        findings.push(finding(
            "total memory",
            level(available >= needed),
            format!("{} of {} MiB available", needed >> 20, available >> 20),
            "lower members_limit or heap_mib, or name smaller models",
        ));
    }
    if deployment.realtime.lock_memory {
        let needed = (service.own_bytes + service.program_bytes) as u64;
        let may = super::has_capability(super::IPC_LOCK);
        let is_enough = may || locked.is_none_or(|most| most >= needed);
        findings.push(finding(
            "lockable memory",
            if is_enough { FindingLevel::Ok } else { FindingLevel::Note },
            format!("{} MiB to lock", needed >> 20),
            "page faults may delay answers: LimitMEMLOCK=infinity in the unit",
        ));
    }
    findings
}

fn shown(limit: Option<u64>) -> String {
    limit.map_or("no limit".to_owned(), |limit| limit.to_string())
}

/// MiB, rounded up.
fn mib(bytes: usize) -> usize {
    bytes.div_ceil(1 << 20)
}

fn microseconds(ns: u64) -> String {
    format!("{:.1}", ns as f64 / 1e3)
}

impl Display for DeploymentBounds {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let ResourceBounds { processes, segments, folder_bytes, unnamed_bytes, .. } =
            &self.footprint;
        writeln!(f, "At most, computed           own MiB  program MiB  descriptors  threads")?;
        for row in processes {
            let process = format!("{} × {}", row.count, row.process);
            let (own, program) = (mib(row.own_bytes), mib(row.program_bytes));
            let (files, threads) = (row.descriptors, row.threads);
            writeln!(f, "  {process:<24} {own:>8} {program:>12} {files:>12} {threads:>8}")?;
        }
        writeln!(
            f,
            "  {segments} segments with {} MiB in the folder, {} MiB without a name",
            mib(*folder_bytes),
            mib(*unnamed_bytes)
        )?;
        let (total, request) = (mib(self.footprint.total_bytes), mib(self.footprint.request_bytes));
        writeln!(
            f,
            "  {total} MiB in all; of these a request takes up to {request} from the heap\n"
        )?;

        if self.costs.jobs > 0 {
            let TestCosts { jobs, threads, test_ns, start_ns, .. } = &self.costs;
            writeln!(f, "Measured bound, not WCET                    µs of CPU: bound   measured")?;
            for TimeBound { what, bound_ns, measured_ns } in &self.times {
                let [bound, measured] =
                    [bound_ns, measured_ns].map(|ns| ns.map_or("-".to_owned(), microseconds));
                writeln!(f, "  {what:40} {bound:>17} {measured:>10}")?;
            }
            writeln!(
                f,
                "  {jobs} jobs, {threads} threads: {test_ns:.1} ns a test, {} µs to begin a job\n",
                microseconds(*start_ns)
            )?;
        }
        self.findings.iter().try_for_each(|finding| finding.fmt(f))
    }
}
