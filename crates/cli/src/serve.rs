//! `trolley serve`: a service from a deployment file.

use crate::BUILD;
use crate::args::Output;
use crate::deployment;
use crate::failure::{Code, Failure};
use crate::run::{pin_coordinator, worker_cores};
use crate::{print, transfer};
use clap::Args;
use coordinator::Options;
use dispatch::{Intensity, Queues};
use runtime::error::chain;
use service::{Idle, Lack, Site};
use std::path::PathBuf;
use std::process::ExitCode;

pub(crate) const EXAMPLES: &str = "\
Examples:
  trolley serve config/deployments/minimal.toml            in one terminal, and in another:
  trolley query config/deployments/minimal.toml config/scenarios/minimal.toml
  trolley serve /etc/trolley/deployment.toml --require-rt  what the systemd unit does

SIGTERM and SIGINT end it; nothing is left in /dev/shm, unless a client still uses it.";

/// How to serve.
#[derive(Clone, Debug, Args)]
pub(crate) struct ServeArgs {
    /// Deployment, TOML: see config/deployments.
    deployment: PathBuf,
    /// Name of the instance instead of the file's.
    #[arg(long, value_name = "NAME")]
    instance: Option<String>,
    /// What it does while nothing is asked, instead of the file's: park (sleep), or spin.
    #[arg(long, value_name = "HOW", value_parser = idle)]
    idle: Option<Idle>,
    /// Refuse to start without locked memory and fixed priorities.
    #[arg(long)]
    require_rt: bool,
    /// Do all work in this process, without workers: a body that crashes the kernel crashes it.
    #[arg(long)]
    in_process: bool,
}

fn idle(text: &str) -> Result<Idle, String> {
    match text {
        "park" => Ok(Idle::Park),
        "spin" => Ok(Idle::Spin),
        _ => Err("write park or spin".to_owned()),
    }
}

pub(crate) fn run(options: &ServeArgs, output: &Output) -> Result<ExitCode, Failure> {
    let mut opened = deployment::open(&options.deployment, options.instance.as_deref())?;
    opened.deployment.idle = options.idle.unwrap_or(opened.deployment.idle);
    opened.deployment.realtime.require |= options.require_rt;
    if let Some(metrics) = &opened.deployment.metrics {
        let file = opened.path(&metrics.file);
        opened.deployment.metrics = Some(service::Metrics { file, ..metrics.clone() });
    }
    if let Some(kept) = &opened.deployment.decisions {
        let folder = opened.path(&kept.folder);
        opened.deployment.decisions = Some(service::Decisions { folder, ..kept.clone() });
    }
    let (policy, curves) = opened.rules()?;
    let bodies = opened.bodies()?;
    let files: Vec<&[u8]> = bodies.iter().map(|body| body.bytes.bytes()).collect();
    let store = coordinator::seal(&files)?;
    drop(bodies);
    let views = body::store::open(store.bytes())
        .map_err(|error| Failure::new(Code::Internal, chain(&error)))?;
    let engine = &opened.deployment.engine;
    pin_coordinator(engine)?;
    let cores = worker_cores(engine, &runtime::affinity::allowed_cores())?;
    let crew = Options {
        matching: transfer::matching(engine.scheme, engine.alpha, engine.seed)?,
        queues: Queues { capacity: engine.queue as u32, batch: engine.batch as u32, linger_ns: 0 },
        intensity: Intensity {
            core_deaths: opened.deployment.restarts.core_in_10_s as usize,
            all_deaths: opened.deployment.restarts.all_in_60_s as usize,
            ..Intensity::default()
        },
        ..Options::new(opened.deployment.instance.clone(), BUILD, cores)
    };
    let site = Site {
        deployment: &opened.deployment,
        policy: &policy,
        curves: &curves,
        bodies: &views,
        store: &store,
        options: (!options.in_process).then_some(&crew),
        depth: engine.depth,
    };
    runtime::process::set_name("trolley-serve");
    service::serve(&site, |lacks| greet(&site, lacks, output))?;
    Ok(ExitCode::SUCCESS)
}

fn greet(site: &Site<'_>, lacks: &[Lack], output: &Output) {
    for lack in lacks {
        tracing::warn!("{}: {}", lack.what, lack.why);
    }
    if output.quiet || output.json {
        return;
    }
    let deployment = site.deployment;
    let triangles: usize = site.bodies.iter().map(|(_, body)| body.corners.len()).sum();
    let workers = match site.options {
        Some(options) => format!("{} workers", options.cores.len()),
        None => "no workers: all work is done in this process".to_owned(),
    };
    let models = deployment.models.len();
    print::err(&format!(
        "serving as \"{}\": {models} models · {triangles} triangles · {workers}. Ctrl-C ends it.",
        deployment.instance
    ));
}
