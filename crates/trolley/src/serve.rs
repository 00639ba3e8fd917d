//! A service from a deployment: bodies sealed, workers started, planners answered.

use crate::bodies::Bodies;
use crate::deployment::OpenDeployment;
use crate::engine::{pin_coordinator, worker_cores};
use crate::record::Signer;
use crate::{BUILD, Failure, dispatch_options};
use coordinator::Options;
use dispatch::{Intensity, Queues};
use service::{Deployment, Idle, MissingRealtime, ServiceConfig};

/// Options of [`serve`], in place of what the deployment says.
///
/// ```
/// use trolley::ServeOptions;
///
/// let options = ServeOptions { require_realtime: true, ..ServeOptions::default() };
/// assert!(options.idle.is_none(), "as the deployment says");
/// ```
#[derive(Clone, Debug, Default)]
pub struct ServeOptions {
    /// What the service does between requests; `None`: as the deployment says.
    pub idle: Option<Idle>,
    /// Whether to refuse to start without locked memory and fixed priorities.
    pub require_realtime: bool,
    /// Whether all work is done in this process. A body that crashes the kernel then crashes it.
    pub in_process: bool,
    /// Signs the decisions that the deployment keeps; `None`: nobody does.
    pub signer: Option<Signer>,
}

/// What a service reports when it has started.
///
/// ```
/// fn greet(greeting: &trolley::Greeting<'_>) -> String {
///     format!("{}: {} models, {} workers", greeting.instance, greeting.models, greeting.workers)
/// }
/// ```
#[derive(Clone, Debug)]
pub struct Greeting<'s> {
    /// Name of the instance.
    pub instance: &'s str,
    /// Bodies that requests may name.
    pub models: usize,
    /// Their triangles.
    pub triangles: usize,
    /// Worker processes; 0 if all work is done in this process.
    pub workers: usize,
    /// What this machine lacks for real time.
    pub missing: &'s [MissingRealtime],
}

/// Runs the service until a signal ends it (TERM, INT, QUIT, HUP). Calls `ready` once, when it can
/// answer requests.
///
/// The signal ends the process, within 2 s of it and whatever hangs: if the service and the rest of
/// the program have not ended after 1.6 s, or a second signal comes, a thread of the service's own
/// kills the workers, removes the files, and exits with 128 + signal. That works for threads that
/// were started after this call; call it before there are any.
///
/// ```no_run
/// use trolley::{OpenDeployment, ServeOptions};
///
/// let deployment = OpenDeployment::open("/etc/trolley/deployment.toml".as_ref(), None)?;
/// trolley::serve(deployment, ServeOptions::default(), |greeting| {
///     println!("{} is ready", greeting.instance);
/// })?;
/// # Ok::<(), trolley::Failure>(())
/// ```
///
/// # Errors
///
/// If a body, a policy or the curves cannot be used, the machine refuses what it needs, or this
/// process runs a service already; with a signer, if the deployment keeps no decisions, or in a
/// folder whose chain another key signs.
pub fn serve(
    mut opened: OpenDeployment,
    options: ServeOptions,
    ready: impl FnOnce(&Greeting<'_>),
) -> Result<(), Failure> {
    // Before any other thread is started, here or in what follows.
    let _guard = runtime::Guard::start(transport::remove_own_files)?;
    opened.deployment.idle = options.idle.unwrap_or(opened.deployment.idle);
    opened.deployment.realtime.require |= options.require_realtime;
    if let Some(metrics) = &opened.deployment.metrics {
        let file = opened.path(&metrics.file);
        opened.deployment.metrics = Some(service::Metrics { file, ..metrics.clone() });
    }
    if let Some(kept) = &opened.deployment.decisions {
        let folder = opened.path(&kept.folder);
        opened.deployment.decisions = Some(service::Decisions { folder, ..kept.clone() });
    }
    if options.signer.is_some() && opened.deployment.decisions.is_none() {
        return Err(Failure::setting("the deployment keeps no decisions that could be signed")
            .with_remedy("add to it: [decisions] folder = \"…\", per_file = 10000, files = 16"));
    }
    let group = opened.group_id()?;
    let signer = options.signer.map(|signer| signer.with_deployment(&opened).of_decisions());
    let criteria = opened.criteria()?;
    if let Some(expiry) = crate::policy::expiry(&criteria.policy, crate::policy::today()) {
        tracing::warn!("{expiry}");
    }
    let bodies = Bodies::of_deployment(&opened)?;
    let views = bodies.views()?;
    let engine = &opened.deployment.engine;
    pin_coordinator(engine)?;
    let cores = worker_cores(engine, &runtime::affinity::allowed_cores())?;
    let worker_pool = Options {
        matching: dispatch_options::matching(engine),
        queues: Queues { capacity: engine.queue as u32, batch: engine.batch as u32, linger_ns: 0 },
        intensity: Intensity {
            core_deaths: opened.deployment.restarts.core_in_10_s as usize,
            all_deaths: opened.deployment.restarts.all_in_60_s as usize,
            ..Intensity::default()
        },
        folder: opened.deployment.folder.clone(),
        ..Options::new(opened.deployment.instance.clone(), BUILD, cores)
    };
    let config = ServiceConfig {
        deployment: &opened.deployment,
        group,
        criteria: &criteria,
        bodies: &views,
        store: bodies.store(),
        options: (!options.in_process).then_some(&worker_pool),
        depth: engine.depth,
        signer,
    };
    runtime::process::set_name("trolley-serve");
    service::serve(&config, |missing| {
        ready(&Greeting {
            instance: &opened.deployment.instance,
            models: opened.deployment.models.len(),
            triangles: views.iter().map(|(_, body)| body.corners.len()).sum(),
            workers: if options.in_process { 0 } else { worker_pool.cores.len() },
            missing,
        });
    })?;
    Ok(())
}

/// Runs the service of a deployment in a child process, and starts it again whenever it dies or
/// falls silent: what systemd does, where there is no systemd.
///
/// `args` are the arguments with which this program serves that deployment, without supervision.
/// Every signal that ends a service ends it and this function, within 2 s. Returns the exit code
/// with which this process should end.
///
/// ```no_run
/// use std::process::ExitCode;
/// use trolley::{Failure, OpenDeployment};
///
/// fn watched(file: &str) -> Result<ExitCode, Failure> {
///     let deployment = OpenDeployment::open(file.as_ref(), None)?;
///     let code = trolley::supervise(&deployment, &["serve".to_owned(), file.to_owned()])?;
///     Ok(code.into())
/// }
/// ```
///
/// # Errors
///
/// If a manager watches this process already, the service was started ten times within a minute, or
/// the operating system refuses a process or a socket.
pub fn supervise(opened: &OpenDeployment, args: &[String]) -> Result<u8, Failure> {
    let Deployment { folder, instance, .. } = &opened.deployment;
    let address = transport::Address::new(folder.as_deref(), instance)?;
    let address = address.with_group(opened.group_id()?);
    runtime::process::set_name("trolley-watch");
    Ok(service::supervise(&address, runtime::process::self_exe(), args)?)
}
