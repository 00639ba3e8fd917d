//! `trolley serve`: a service from a deployment file.

use crate::output::Output;
use crate::reference_args::ReferenceArgs;
use clap::Args;
use std::path::PathBuf;
use std::process::ExitCode;
use trolley::record::Signer;
use trolley::{Failure, Greeting, Idle, OpenDeployment, ServeOptions};

pub(crate) const EXAMPLES: &str = "\
Examples:
  trolley serve config/deployments/minimal.toml            in one terminal, and in another:
  trolley query config/deployments/minimal.toml config/scenarios/minimal.toml
  trolley serve /etc/trolley/deployment.toml --require-rt  as the systemd unit does

SIGTERM, SIGINT, SIGQUIT and SIGHUP end it within 2 s, whatever hangs; nothing is left in shared \
memory, unless a client still uses it. If it does not end in order within 1.6 s, or a second \
signal comes, it ends by force, with exit code 128 + signal.";

/// The arguments of `serve`.
#[derive(Clone, Debug, Args)]
pub(crate) struct ServeArgs {
    /// Deployment, TOML: see config/deployments.
    deployment: PathBuf,
    /// Instance name, overriding the file's.
    #[arg(long, value_name = "NAME")]
    instance: Option<String>,
    #[command(flatten)]
    references: ReferenceArgs,
    /// What to do while idle, overriding the file's: park (sleep) or spin.
    #[arg(long, value_name = "HOW", value_parser = idle)]
    idle: Option<Idle>,
    /// Refuse to start without locked memory and real-time priorities.
    #[arg(long)]
    require_rt: bool,
    /// Do all work in this process, without workers: a body that crashes the kernel crashes the
    /// service.
    #[arg(long)]
    in_process: bool,
    /// Sign the decisions that the deployment keeps with this secret key: Ed25519, PEM, as
    /// `openssl genpkey -algorithm ed25519` writes it. Nobody else may read the file.
    #[arg(long, value_name = "KEY")]
    sign: Option<PathBuf>,
}

fn idle(text: &str) -> Result<Idle, String> {
    match text {
        "park" => Ok(Idle::Park),
        "spin" => Ok(Idle::Spin),
        _ => Err("write park or spin".to_owned()),
    }
}

pub(crate) fn run(args: &ServeArgs, output: &Output) -> Result<ExitCode, Failure> {
    let (instance, references) = (args.instance.as_deref(), args.references.references());
    let deployment = OpenDeployment::open_with(&args.deployment, instance, references)?;
    let options = ServeOptions {
        idle: args.idle,
        require_realtime: args.require_rt,
        in_process: args.in_process,
        signer: args.sign.as_deref().map(Signer::open).transpose()?,
    };
    trolley::serve(deployment, options, |greeting| greet(greeting, output))?;
    Ok(ExitCode::SUCCESS)
}

fn greet(greeting: &Greeting<'_>, output: &Output) {
    for missing in greeting.missing {
        tracing::warn!("{}: {}", missing.what, missing.why);
    }
    let Greeting { instance, models, triangles, workers, .. } = greeting;
    let workers = match workers {
        0 => "no workers, all work in-process".to_owned(),
        workers => format!("{workers} workers"),
    };
    output.say(&format!(
        "serving as \"{instance}\": {models} models · {triangles} triangles · {workers}. \
         Ctrl-C ends it."
    ));
}
