//! `trolley init`: a scenario to begin with.

use crate::output::Output;
use crate::print;
use clap::Args;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use trolley::Failure;

pub(crate) const EXAMPLES: &str = "\
Examples:
  trolley init crash.toml && trolley rank crash.toml
  trolley init - > slip.toml
  trolley init FILE.toml --body car.trolley                  with your own car: trolley model import

It replaces no file. `trolley help keys` describes every key, `trolley help tutorial` the way.";

/// What to write.
#[derive(Clone, Debug, Args)]
pub(crate) struct InitArgs {
    /// Scenario to write; - for the standard output.
    file: PathBuf,
    /// Model file of the ego: a vehicle, in the scenario's folder or in one of that.
    #[arg(long, value_name = "FILE.trolley")]
    body: Option<PathBuf>,
}

pub(crate) fn run(asked: &InitArgs, output: &Output) -> Result<ExitCode, Failure> {
    let InitArgs { file, body } = asked;
    let body = body.as_deref().map(|body| beside(file, body)).transpose()?;
    let text = trolley::init::scenario(body.as_deref());
    if file == Path::new("-") {
        return print::out_bytes(text.as_bytes());
    }
    if file.symlink_metadata().is_ok() {
        let failure = Failure::setting("there is such a file, and nothing replaces it");
        return Err(failure.at(file.display()).with_remedy("name another, or move that away"));
    }
    trolley::files::check(file, None)?;
    trolley::files::replace(file, text.as_bytes())?;
    let file = file.display();
    output.say(&format!("written: {file}\nNext: trolley rank {file}"));
    Ok(ExitCode::SUCCESS)
}

/// The path of a body as a scenario beside it names it.
fn beside(scenario: &Path, body: &Path) -> Result<String, Failure> {
    let there = |path: &Path| path.canonicalize().ok();
    let Some(whole) = there(body) else {
        let failure = Failure::input("there is no such file").at(body.display());
        return Err(failure.with_remedy("make it first: trolley model import, or model generate"));
    };
    if !trolley::model::open::is_model(body) {
        let failure = Failure::input("it is no model file").at(body.display());
        return Err(failure.with_remedy("make one of it: trolley model import"));
    }
    let folder = scenario.parent().filter(|folder| !folder.as_os_str().is_empty());
    let folder = there(folder.unwrap_or(Path::new(".")));
    let inside = folder.as_deref().and_then(|folder| whole.strip_prefix(folder).ok());
    inside.and_then(Path::to_str).map(str::to_owned).ok_or_else(|| {
        let failure = Failure::setting("it does not lie in the scenario's folder");
        failure.at(body.display()).with_remedy("write the scenario beside it, or move it there")
    })
}
