//! `trolley model import`: from a mesh to a model file.

use super::facts::{Facts, thousands, triangles};
use super::reader::{Outcome, Report, Request};
use super::{LimitArgs, MeshArgs, TreeArgs, open, write};
use crate::output::Output;
use crate::print;
use clap::Args as ClapArgs;
use clap::builder::NonEmptyStringValueParser;
use serde::Serialize;
use std::path::PathBuf;
use std::process::ExitCode;
use trolley::{Failure, Kind};

pub(super) const EXAMPLES: &str = "\
Examples:
  trolley model import car.obj --unit cm --up z --forward -y --kind sedan -o car.trolley
  trolley model import human.obj --unit dm --up y --forward z --only body --kind pedestrian \\
      -o human.trolley
  trolley model import pickup.dae --forward y --kind suv -o pickup.trolley
  trolley model import shells.k --unit mm --only roof --kind sedan -o shells.trolley

Mass, centre of mass, inertia and seats come from a TOML file beside the mesh (car.toml), else from
defaults by kind; `trolley model info` says which.";

#[derive(Debug, ClapArgs)]
pub(crate) struct ImportArgs {
    /// Mesh: .obj, .stl, .ply, .gltf, .glb, .dae, .k or .key.
    file: PathBuf,
    #[command(flatten)]
    mesh: MeshArgs,
    /// Name of the body [default: the side file's, else the file's].
    #[arg(long, value_parser = NonEmptyStringValueParser::new())]
    name: Option<String>,
    #[command(flatten)]
    tree: TreeArgs,
    #[command(flatten)]
    limits: LimitArgs,
    /// Model file to write.
    #[arg(short, long, value_name = "OUT.trolley")]
    out: PathBuf,
}

#[derive(Serialize)]
struct Document<'a> {
    schema: &'static str,
    file: String,
    body: &'a Facts,
    import: &'a Report,
}

pub(super) fn run(args: &ImportArgs, output: &Output) -> Result<ExitCode, Failure> {
    write::check(&args.out, Some(&args.file))?;
    let options = args.tree.options();
    let name = args.name.as_deref();
    let request = Request::new(&args.file, &args.mesh, name, Some(&options), args.limits)?;
    let Outcome { report, bytes, .. } = request.run(output)?;
    // What a damaged child sent is not written.
    let (meta, view) =
        open::view(&args.file, bytes.bytes()).map_err(|failure| failure.of_kind(Kind::Internal))?;
    let facts = Facts::new(meta, &view, bytes.bytes())?;
    write::replace(&args.out, bytes.bytes())?;
    let out = args.out.display().to_string();
    if output.json {
        return print::out(&print::json(&Document {
            schema: "trolley.model-import/1",
            file: out,
            body: &facts,
            import: &report,
        })?);
    }
    if output.quiet {
        return Ok(ExitCode::SUCCESS);
    }
    let read = read(&report);
    print::out(&format!("{out}: {}", facts.table(Some(&read), &report.notes)))
}

/// "OBJ, 36,972 triangles, of which 26,756 in the selected parts; body.toml".
fn read(report: &Report) -> String {
    let mut text = format!("{}, {}", report.format, triangles(report.triangles_in_file));
    if report.triangles_selected != report.triangles_in_file {
        let selected = thousands(report.triangles_selected);
        text += &format!(", of which {selected} in the parts that were asked for");
    }
    if let Some(side) = &report.side_file {
        text += &format!("; side file {side}");
    }
    text
}
