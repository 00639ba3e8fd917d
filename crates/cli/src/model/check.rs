//! `trolley model check`: which files are sound.

use super::facts::{Facts, shown, thousands, triangles};
use super::reader::{Outcome, Request};
use super::{LimitArgs, MeshArgs, open};
use crate::output::Output;
use crate::print;
use clap::Args as ClapArgs;
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use trolley::{Failure, Kind};

pub(super) const EXAMPLES: &str = "\
Examples:
  trolley model check *.trolley
  trolley model check scans/*.ply --unit mm

One line per file. Exit code 65 if a file was refused. Without --kind, any size is accepted.";

#[derive(Debug, ClapArgs)]
pub(crate) struct CheckArgs {
    /// Model files, or meshes: .obj, .stl, .ply, .gltf, .glb, .dae, .k.
    #[arg(required = true)]
    files: Vec<PathBuf>,
    #[command(flatten)]
    mesh: MeshArgs,
    #[command(flatten)]
    limits: LimitArgs,
}

#[derive(Serialize)]
struct Document {
    schema: &'static str,
    refused: usize,
    files: Vec<Verdict>,
}

#[derive(Serialize)]
struct Verdict {
    file: String,
    ok: bool,
    /// What it is.
    #[serde(skip_serializing_if = "Option::is_none")]
    what: Option<String>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    doubts: Vec<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    fault: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    help: Option<String>,
}

pub(super) fn run(args: &CheckArgs, output: &Output) -> Result<ExitCode, Failure> {
    let mut verdicts = Vec::new();
    for path in &args.files {
        let verdict = match look(path, args, output) {
            Ok((what, doubts)) => Verdict {
                file: path.display().to_string(),
                ok: true,
                what: Some(what),
                doubts,
                fault: None,
                help: None,
            },
            // Not the file's fault, but the machine's or ours: the others would fare no better.
            Err(failure) if failure.kind() != Kind::Input => return Err(failure),
            Err(failure) => Verdict {
                file: path.display().to_string(),
                ok: false,
                what: None,
                doubts: Vec::new(),
                fault: Some(failure.what().to_owned()),
                help: failure.remedy().map(str::to_owned),
            },
        };
        if !(output.json || output.quiet && verdict.ok) {
            print::out(&line(&verdict))?;
        }
        verdicts.push(verdict);
    }
    let refused = verdicts.iter().filter(|verdict| !verdict.ok).count();
    if output.json {
        let schema = "trolley.model-check/1";
        print::out(&print::json(&Document { schema, refused, files: verdicts })?)?;
    }
    Ok(if refused == 0 { ExitCode::SUCCESS } else { Kind::Input.into() })
}

fn line(verdict: &Verdict) -> String {
    let (state, mut text) = match (&verdict.what, &verdict.fault) {
        (Some(what), _) => ("ok", format!("{}: {what}", verdict.file)),
        (None, fault) => ("refused", fault.clone().unwrap_or_default()),
    };
    for doubt in &verdict.doubts {
        text += &format!("; {doubt}");
    }
    if let Some(help) = &verdict.help {
        text += &format!("; help: {help}");
    }
    format!("{state:<8} {}", shown(&text))
}

/// What a file is, and doubts about it.
fn look(path: &Path, args: &CheckArgs, output: &Output) -> Result<(String, Vec<String>), Failure> {
    if open::is_model(path) {
        let map = open::bytes(path)?;
        let (meta, view) = open::view(path, map.bytes())?;
        let facts = Facts::new(meta, &view, map.bytes())?;
        let [x, y, z] = facts.size_m;
        let count = triangles(facts.triangles);
        let what = format!("model file, {}, {x:.2} × {y:.2} × {z:.2} m, {count}", facts.kind);
        return Ok((what, Vec::new()));
    }
    let Outcome { report, .. } =
        Request::new(path, &args.mesh, None, None, args.limits)?.run(output)?;
    let mut what =
        format!("{}, {}, {}", report.format, report.sentence, triangles(report.triangles));
    if report.duplicates_dropped > 0 {
        what += &format!(", {} duplicates left out", thousands(report.duplicates_dropped));
    }
    if report.degenerate_kept > 0 {
        what += &format!(", {} of zero area", thousands(report.degenerate_kept as usize));
    }
    let doubts = [report.notes, report.doubts].concat();
    Ok((what, doubts))
}
