//! `trolley model export`: the triangles of a model file as a mesh.

use super::facts;
use super::{open, write};
use crate::output::Output;
use crate::print;
use clap::Args as ClapArgs;
use mesh::export::{self, ExportFormat};
use serde::Serialize;
use std::path::PathBuf;
use std::process::ExitCode;
use trolley::Failure;

pub(super) const EXAMPLES: &str = "\
Examples:
  trolley model export car.trolley --format stl -o car.stl
  trolley model export car.trolley -o car.obj

Triangles stand in the order of their source ids, with their exact coordinates, in metres,
x forward, y left, z up: importing the file with --up z --forward x gives the same triangles
again.";

#[derive(Debug, ClapArgs)]
pub(crate) struct ExportArgs {
    /// Model file.
    file: PathBuf,
    /// stl, ply or obj [default: what the output's name ends in].
    #[arg(long)]
    format: Option<ExportFormat>,
    /// Mesh file to write.
    #[arg(short, long, value_name = "OUT")]
    out: PathBuf,
}

#[derive(Serialize)]
struct Document {
    schema: &'static str,
    file: String,
    format: &'static str,
    triangles: usize,
    bytes: usize,
}

pub(super) fn run(args: &ExportArgs, output: &Output) -> Result<ExitCode, Failure> {
    let format = format(args)?;
    write::check(&args.out, Some(&args.file))?;
    let map = open::bytes(&args.file)?;
    let (meta, view) = open::view(&args.file, map.bytes())?;
    let bytes = export::write(format, &meta, &view);
    write::replace(&args.out, &bytes)?;
    let name = args.out.display().to_string();
    let triangles = view.corners.len();
    if output.json {
        return print::out(&print::json(&Document {
            schema: "trolley.model-export/1",
            file: name,
            format: format.name(),
            triangles,
            bytes: bytes.len(),
        })?);
    }
    if output.quiet {
        return Ok(ExitCode::SUCCESS);
    }
    print::out(&format!(
        "{name}: {} as {}, in metres, x forward, y left, z up",
        facts::triangles(triangles),
        format.name().to_uppercase()
    ))
}

fn format(args: &ExportArgs) -> Result<ExportFormat, Failure> {
    if let Some(format) = args.format {
        return Ok(format);
    }
    let end = args.out.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    end.parse().map_err(|_unknown| {
        let fault = format!("{}: its name does not say which format", args.out.display());
        Failure::setting(fault).with_remedy("add --format stl, ply or obj")
    })
}
