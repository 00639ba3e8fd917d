//! `trolley serve`: a service from a deployment file.

use crate::output::Output;
use crate::reference_args::ReferenceArgs;
use clap::Args;
use std::path::PathBuf;
use std::process::ExitCode;
use trolley::record::Signer;
use trolley::{Failure, FailureKind, Greeting, Idle, OpenDeployment, ServeOptions};

pub(crate) const EXAMPLES: &str = "\
Examples:
  trolley serve config/deployments/minimal.toml              in one terminal, and in another:
  trolley query config/deployments/minimal.toml config/scenarios/minimal.toml --wait
  trolley serve DEPLOYMENT.toml --require-rt                 as the systemd unit does
  trolley serve config/deployments/minimal.toml --supervise  without systemd

SIGTERM, SIGINT, SIGQUIT and SIGHUP end it within 2 s, whatever hangs; nothing is left in shared \
memory, unless a client still uses it. If it does not end in order within 1.6 s, or a second \
signal comes, it ends by force, with exit code 128 + signal.

With --supervise, what the service refuses (exit codes 2, 65, 76, 77, 78) is not tried again; \
after ten starts within a minute it is given up (75). A service of systemd has its own watchdog.";

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
    /// Where there is no systemd: start the service in a child process, and start it again when it
    /// dies or says nothing for 2 s, ten times a minute at most.
    #[arg(long)]
    supervise: bool,
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
    if args.supervise {
        return Ok(ExitCode::from(trolley::supervise(&deployment, &without_supervision()?)?));
    }
    let options = ServeOptions {
        idle: args.idle,
        require_realtime: args.require_rt,
        in_process: args.in_process,
        signer: args.sign.as_deref().map(Signer::open).transpose()?,
    };
    trolley::serve(deployment, options, |greeting| greet(greeting, output))?;
    Ok(ExitCode::SUCCESS)
}

/// The arguments of this process but for the one that asks for supervision.
fn without_supervision() -> Result<Vec<String>, Failure> {
    let mut args: Vec<String> = std::env::args_os()
        .skip(1)
        .map(|arg| arg.into_string().map_err(|arg| not_utf8(&arg)))
        .collect::<Result<_, _>>()?;
    if let Some(at) = args.iter().position(|arg| arg == "--supervise") {
        args.remove(at);
    }
    Ok(args)
}

fn not_utf8(arg: &std::ffi::OsStr) -> Failure {
    Failure::new(FailureKind::Configuration, format!("{} is not UTF-8", arg.display()))
        .with_remedy("give the file another name, or leave out --supervise")
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
