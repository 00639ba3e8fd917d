//! `trolley model`: bodies on the command line; [`trolley::model`] does the work.

use crate::output::Output;
use crate::print;
use clap::builder::NonEmptyStringValueParser;
use clap::{Args as ClapArgs, Subcommand, ValueEnum};
use report::body_text as text;
use std::path::PathBuf;
use std::process::ExitCode;
use trolley::model::{
    self, Axis, BodyKind, Build, BuildOptions, Export, ExportFormat, Generate, Import, Info,
    LengthUnit, MeshOptions, ReadLimits, Shape, TRIANGLES_MAX, TRIANGLES_MIN,
};
use trolley::{Failure, FailureKind};

const IMPORT: &str = "\
Examples:
  trolley model import config/examples/car.stl --unit cm --up z --forward -y --kind sedan \\
      -o car.trolley
  trolley model import tests/data/hatchback.obj --unit inch --up z --forward -y --kind sedan \\
      -o hatchback.trolley
  trolley model import tests/data/jersey_barrier.dae --forward y --kind wall -o barrier.trolley
  trolley model import FILE.k --unit mm --only PART --kind sedan -o shells.trolley

Mass, centre of mass, inertia and seats come from a TOML file beside the mesh (car.toml), else from
defaults by kind; `trolley model info` says which.";

const CHECK: &str = "\
Examples:
  trolley model check config/examples/car.stl tests/data/hatchback.obj
  trolley model check MODELS/*.trolley

One line per file. Exit code 65 if a file was refused. Without --kind, any size is accepted.";

const GENERATE: &str = "\
Examples:
  trolley model generate wall --triangles 500 -o wall.trolley
  trolley model generate sedan --triangles 100000 --seed 7 -o sedan.trolley";

const EXPORT: &str = "\
Examples:
  trolley model generate sedan --triangles 20000 -o car.trolley
  trolley model export car.trolley --format stl -o car.stl
  trolley model export car.trolley -o car.obj

Triangles are in the order of their source ids, with their exact coordinates, in metres,
x forward, y left, z up: importing the file with --up z --forward x gives the same triangles.";

#[derive(Debug, Subcommand)]
pub(crate) enum Verb {
    /// Make a model file from a mesh: OBJ, STL, PLY, glTF, GLB, COLLADA or LS-DYNA.
    #[command(after_help = IMPORT)]
    Import(ImportArgs),
    /// Describe a model file (size, mass, parts, tree, origin), or suggest unit and axes of a mesh.
    #[command(after_help = "Examples:\n  trolley model info config/examples/car.stl\n  \
        trolley model generate sedan --triangles 20000 -o car.trolley\n  \
        trolley model info car.trolley --json")]
    Info {
        /// Model file, or a mesh to suggest unit and axes for.
        file: PathBuf,
        #[command(flatten)]
        limits: LimitArgs,
    },
    /// Verify model files, and check whether meshes can be imported; writes nothing.
    #[command(after_help = CHECK)]
    Check(CheckArgs),
    /// Make a model file of a generated shape.
    #[command(after_help = generate_help())]
    Generate(GenerateArgs),
    /// Write the triangles of a model file as a mesh for other programs.
    #[command(after_help = EXPORT)]
    Export(ExportArgs),
    /// Run as the process that reads a mesh; started by import and check, not by hand.
    #[command(hide = true)]
    ImportChild {
        /// The read request, JSON.
        request: String,
    },
}

#[derive(Debug, ClapArgs)]
pub(crate) struct ImportArgs {
    /// Mesh: .obj, .stl, .ply, .gltf, .glb, .dae, .k or .key.
    file: PathBuf,
    #[command(flatten)]
    mesh: MeshArgs,
    /// Name of the body [default: from the side file, else the file name].
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

#[derive(Debug, ClapArgs)]
pub(crate) struct GenerateArgs {
    /// Shape to generate.
    shape: Shape,
    /// Number of triangles; an odd number gives one less.
    #[arg(long, value_name = "N",
          value_parser = clap::value_parser!(u32)
              .range(i64::from(TRIANGLES_MIN)..=i64::from(TRIANGLES_MAX)))]
    triangles: u32,
    /// Varies size and proportions by a few percent; 0 is the nominal body.
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    #[command(flatten)]
    tree: TreeArgs,
    /// Model file to write.
    #[arg(short, long, value_name = "OUT.trolley")]
    out: PathBuf,
}

#[derive(Debug, ClapArgs)]
pub(crate) struct ExportArgs {
    /// Model file.
    file: PathBuf,
    /// stl, ply or obj [default: from the output's extension].
    #[arg(long)]
    format: Option<ExportFormat>,
    /// Mesh file to write.
    #[arg(short, long, value_name = "OUT")]
    out: PathBuf,
}

/// How to read a mesh file.
#[derive(Clone, Debug, ClapArgs)]
struct MeshArgs {
    /// Unit of the coordinates: m, dm, cm, mm, inch, or a factor to metres [default: as a COLLADA
    /// file states, else m; required for LS-DYNA].
    #[arg(long, value_name = "UNIT")]
    unit: Option<LengthUnit>,
    /// Axis of the file that points up [default: +y for glTF and GLB, as a COLLADA file states,
    /// else +z].
    #[arg(long, allow_hyphen_values = true, value_name = "AXIS")]
    up: Option<Axis>,
    /// Axis of the file that points forward [default: +z for glTF and GLB, else +x].
    #[arg(long, allow_hyphen_values = true, value_name = "AXIS")]
    forward: Option<Axis>,
    /// Keep only this part, group, object, material or node; may be repeated.
    #[arg(long, value_name = "GROUP")]
    only: Vec<String>,
    /// What the body is: sedan, suv, truck, bus, motorcycle, cyclist, pedestrian, wall, pole or
    /// building. A TOML file beside the mesh may state it instead.
    #[arg(long)]
    kind: Option<BodyKind>,
}

/// Limits of the process that reads a mesh.
#[derive(Clone, Copy, Debug, ClapArgs)]
pub(crate) struct LimitArgs {
    /// Memory for reading one mesh, in MB [default: 64 times the file, 2048 to 8192].
    #[arg(long, value_name = "MB", value_parser = clap::value_parser!(u64).range(16..=1_048_576))]
    memory_mb: Option<u64>,
    /// CPU time for reading one mesh, in seconds.
    #[arg(long, value_name = "S", default_value_t = ReadLimits::CPU_S,
          value_parser = clap::value_parser!(u64).range(1..=86_400))]
    cpu_s: u64,
}

fn generate_help() -> String {
    format!("{GENERATE}\n\nShapes: {}.", Shape::ALL.map(Shape::name).join(", "))
}

/// How the tree is built.
#[derive(Clone, Copy, Debug, ClapArgs)]
struct TreeArgs {
    /// How nodes are split: as in the paper with a balance rule, exactly as in the paper, or by
    /// surface area (SAH).
    #[arg(long, default_value = "paper")]
    build: BuildName,
    /// Maximum number of triangles in a leaf.
    #[arg(long, value_name = "N", default_value_t = BuildOptions::default().leaf_size,
          value_parser = clap::value_parser!(u32).range(1..=i64::from(model::LEAF_SIZE_MAX)))]
    leaf_size: u32,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum BuildName {
    #[value(alias = "seed")]
    Paper,
    Literal,
    Sah,
}

impl MeshArgs {
    fn options(&self) -> MeshOptions {
        let Self { unit, up, forward, only, kind } = self.clone();
        MeshOptions { unit, up, forward, only, kind }
    }
}

impl From<LimitArgs> for ReadLimits {
    fn from(LimitArgs { memory_mb, cpu_s }: LimitArgs) -> Self {
        Self { memory_mb, cpu_s }
    }
}

impl TreeArgs {
    fn options(self) -> BuildOptions {
        model::tree(self.build.into(), self.leaf_size)
    }
}

impl From<BuildName> for Build {
    fn from(name: BuildName) -> Self {
        match name {
            BuildName::Paper => Self::Paper,
            BuildName::Literal => Self::Literal,
            BuildName::Sah => Self::Sah,
        }
    }
}

pub(crate) fn run(verb: &Verb, output: &Output) -> Result<ExitCode, Failure> {
    match verb {
        Verb::Import(args) => import(args, output),
        Verb::Info { file, limits } => {
            let info = reading(output, |told| model::info(file, (*limits).into(), told))?;
            if output.json {
                return print::out(&print::json(&info)?);
            }
            print::lines(&match &info {
                Info::Body(info) => text::table(&info.body, None, &[]),
                Info::Mesh(info) => text::mesh(info),
            })
        }
        Verb::Check(args) => check(args, output),
        Verb::Generate(args) => generate(args, output),
        Verb::Export(args) => export(args, output),
        Verb::ImportChild { request } => Ok(trolley::run_reader(request).into()),
    }
}

/// Reads a mesh or builds a tree, and shows the progress.
pub(crate) fn reading<T>(
    output: &Output,
    work: impl FnOnce(&(dyn Fn(u64, u64) + Sync)) -> Result<T, Failure>,
) -> Result<T, Failure> {
    let progress = output.progress("building the tree: triangles");
    work(&|done, total| progress.set(done, total))
}

fn import(args: &ImportArgs, output: &Output) -> Result<ExitCode, Failure> {
    let import = Import {
        mesh: args.file.clone(),
        options: args.mesh.options(),
        name: args.name.clone(),
        tree: args.tree.options(),
        limits: args.limits.into(),
        out: args.out.clone(),
    };
    let made = reading(output, |told| import.run(told))?;
    result(output, &made, || {
        let read = text::read(&made.import);
        format!("{}: {}", made.file, text::table(&made.body, Some(&read), &made.import.notes))
    })
}

fn check(args: &CheckArgs, output: &Output) -> Result<ExitCode, Failure> {
    let checked =
        model::check(&args.files, &args.mesh.options(), args.limits.into(), &mut |verdict| {
            if output.json || output.quiet && verdict.ok {
                return Ok(());
            }
            print::lines(&text::verdict(verdict)).map(drop)
        })?;
    if output.json {
        print::out(&print::json(&checked)?)?;
    }
    Ok(if checked.refused == 0 { ExitCode::SUCCESS } else { FailureKind::Input.into() })
}

fn generate(args: &GenerateArgs, output: &Output) -> Result<ExitCode, Failure> {
    let generate = Generate {
        shape: args.shape,
        triangles: args.triangles,
        seed: args.seed,
        tree: args.tree.options(),
        out: args.out.clone(),
    };
    let made = reading(output, |told| generate.run(told))?;
    result(output, &made, || format!("{}: {}", made.file, text::table(&made.body, None, &[])))
}

fn export(args: &ExportArgs, output: &Output) -> Result<ExitCode, Failure> {
    let ExportArgs { file, format, out } = args;
    let made = Export { file: file.clone(), format: *format, out: out.clone() }.run()?;
    result(output, &made, || {
        let triangles = model::facts::triangles(made.triangles);
        let format = made.format.name().to_uppercase();
        format!("{}: {triangles} as {format}, in metres, x forward, y left, z up", made.file)
    })
}

/// Prints the result as JSON, or as text unless `--quiet` is given.
fn result(
    output: &Output,
    document: &impl serde::Serialize,
    text: impl FnOnce() -> String,
) -> Result<ExitCode, Failure> {
    if output.json {
        return print::out(&print::json(document)?);
    }
    if output.quiet {
        return Ok(ExitCode::SUCCESS);
    }
    print::lines(&text())
}
