//! `cargo x scenarios`: alternatives derived from recorded traffic, ranked with real bodies, and
//! compared with overlapping boxes and a published harm formula.
//!
//! ```text
//! derived_alternatives.json ─ cases ─▶ scenario files ─ trolley rank ─▶ answers ─┐
//! models ─ bodies: imported, scaled to the stated size ─▲     boxes, formula ───┴─▶ page, pictures
//! ```
//!
//! The data is third-party: it is read in place, and only figures from it are kept.

mod bodies;
mod cases;
mod page;
mod picture;
mod rivals;

use crate::built::{self, Workspace, write};
use crate::machine;
use crate::step::cargo;
use anyhow::{Context as _, Result, bail};
use bodies::Bodies;
use cases::{Alternative, Scene};
use serde_json::Value;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

/// What to rank.
#[derive(Debug, clap::Args)]
pub(crate) struct Options {
    /// The data: a folder with scenarios/derived_alternatives.json and models.
    #[arg(long, value_name = "DIR", default_value = "../shared/data")]
    data: PathBuf,
    /// The page to write; pictures are written into a folder of its name beside it.
    #[arg(long, value_name = "FILE", default_value = "tools/results/scenarios.md")]
    out: PathBuf,
}

/// One scenario, ranked.
#[derive(Debug)]
pub(crate) struct Ranked {
    pub(crate) scene: Scene,
    /// The refusal without any assumption, if there is one.
    pub(crate) refusal: Option<String>,
    /// The JSON document of `trolley rank --json --explain`.
    pub(crate) document: Value,
}

pub(crate) fn run(options: &Options) -> Result<ExitCode> {
    let workspace = Workspace::find()?;
    let build = &["build", "--release", "--package", "trolley-cli", "--bin", "trolley"];
    let program = built::executable(cargo().args(build))?;
    let folder = workspace.target.join("scenarios");
    std::fs::create_dir_all(&folder)?;
    let data = workspace.root.join(&options.data);
    let list = data.join("scenarios/derived_alternatives.json");
    let text = std::fs::read_to_string(&list).with_context(|| list.display().to_string())?;
    let scenes = cases::scenes(&text)?;
    let mut bodies = Bodies::new(&program, &data.join("models"), &folder);
    let mut ranked = Vec::new();
    for scene in scenes {
        for body in scene.alternatives.iter().flat_map(Alternative::bodies) {
            bodies.make(body)?;
        }
        let path = folder.join(format!("{}.toml", scene.name));
        write(&path, &scene.text(&bodies))?;
        ranked.push(rank(&program, &path, scene)?);
    }
    let pictures = picture::pictures(&ranked, &bodies)?;
    let out = workspace.root.join(&options.out);
    let beside = out.with_extension("");
    for picture in &pictures {
        write(&beside.join(&picture.file), &picture.svg)?;
    }
    let folder = beside.file_name().map(|name| name.to_string_lossy().into_owned());
    let facts = machine::describe(&workspace.root)?;
    let page = page::page(&ranked, &pictures, &folder.unwrap_or_default(), &facts);
    write(&out, &page)?;
    let (scenes, drawn) = (ranked.len(), pictures.len());
    writeln!(std::io::stdout(), "{}: {scenes} scenes, {drawn} pictures", out.display())?;
    Ok(ExitCode::SUCCESS)
}

/// Ranks a scenario; what is refused for an unknown kind is ranked again with the assumption.
fn rank(program: &Path, path: &Path, scene: Scene) -> Result<Ranked> {
    let ask = |more: &[&str]| -> Result<std::process::Output> {
        let mut command = Command::new(program);
        command.arg("rank").arg(path).args(["--json", "--explain", "--in-process"]).args(more);
        command.output().with_context(|| format!("cannot start {command:?}"))
    };
    let mut said = ask(&[])?;
    let mut refusal = None;
    if said.status.code() == Some(4) && scene.has_unknown() {
        let text = String::from_utf8_lossy(&said.stderr).into_owned();
        refusal = text
            .lines()
            .next()
            .map(|line| line.rsplit_once(": ").map_or(line, |(_, fault)| fault).to_owned());
        said = ask(&["--assume", "unknown=fixed"])?;
    }
    if !matches!(said.status.code(), Some(0 | 3)) {
        bail!("{}: {}", path.display(), String::from_utf8_lossy(&said.stderr));
    }
    let document = serde_json::from_slice(&said.stdout)?;
    Ok(Ranked { scene, refusal, document })
}
