//! `trolley model`: bodies on the command line.
//!
//! ```text
//! import, check ──starts──▶ reader::child (limits itself, reads the mesh, builds the tree)
//!       ▲                       │ progress, then a report and the model file, through a pipe
//!       └── verify, write ◀─────┘
//! info, export, check ──▶ open: a model file, verified     generate ──▶ bodies ──▶ write
//! ```
//!
//! Whatever a mesh file does to its reader happens in the child. A file is replaced only by a
//! finished and verified one, so a failure leaves nothing behind and nothing damaged.

mod check;
mod export;
pub(crate) mod facts;
mod generate;
mod import;
mod info;
pub(crate) mod open;
pub(crate) mod reader;

use crate::output::Output;
use body::{Build, Kind};
use bvh::BuildOptions;
use clap::{Args as ClapArgs, Subcommand, ValueEnum};
use mesh::import::{Axis, Unit};
use std::path::PathBuf;
use std::process::ExitCode;
use trolley::Failure;

#[derive(Debug, Subcommand)]
pub(crate) enum Verb {
    /// Make a model file from a mesh: OBJ, STL, PLY, glTF, GLB, COLLADA or LS-DYNA.
    #[command(after_help = import::EXAMPLES)]
    Import(import::ImportArgs),
    /// Say what a model file holds (size, mass, parts, tree, origin), or how a mesh might be meant.
    #[command(
        after_help = "Examples:\n  trolley model info car.trolley --json | jq .body.size_m\n  \
        trolley model info hatchback.obj"
    )]
    Info {
        /// Model file, or mesh: then unit and axes are offered.
        file: PathBuf,
        #[command(flatten)]
        limits: LimitArgs,
    },
    /// Verify model files, and try whether meshes could be imported; writes nothing.
    #[command(after_help = check::EXAMPLES)]
    Check(check::CheckArgs),
    /// Make a model file of a shape that the program generates itself.
    #[command(after_help = generate::EXAMPLES)]
    Generate(generate::GenerateArgs),
    /// Write the triangles of a model file as a mesh for other programs.
    #[command(after_help = export::EXAMPLES)]
    Export(export::ExportArgs),
    /// The process that reads a mesh: started by import and check, not by hand.
    #[command(hide = true)]
    ImportChild {
        /// What to read, JSON.
        request: String,
    },
}

/// How a mesh file is to be understood.
#[derive(Clone, Debug, ClapArgs)]
pub(crate) struct MeshArgs {
    /// Unit of the coordinates: m, dm, cm, mm, inch, or a factor to metres [default: what a COLLADA
    /// file states, else m; an LS-DYNA deck needs one].
    #[arg(long, value_name = "UNIT")]
    unit: Option<Unit>,
    /// Axis of the file that points up [default: +y for glTF and GLB, what a COLLADA file states,
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
    /// building. A TOML file beside the mesh may say it, too.
    #[arg(long)]
    kind: Option<Kind>,
}

/// What the process that reads a mesh may use.
#[derive(Clone, Copy, Debug, ClapArgs)]
pub(crate) struct LimitArgs {
    /// Memory for reading one mesh, in MB [default: 64 times the file, 2048 to 8192].
    #[arg(long, value_name = "MB", value_parser = clap::value_parser!(u64).range(16..=1_048_576))]
    memory_mb: Option<u64>,
    /// CPU time for reading one mesh, in seconds.
    #[arg(long, value_name = "S", default_value_t = 120,
          value_parser = clap::value_parser!(u64).range(1..=86_400))]
    cpu_s: u64,
}

/// How the tree is built.
#[derive(Clone, Copy, Debug, ClapArgs)]
pub(crate) struct TreeArgs {
    /// The split: the seed's with a balance rule, the seed's by the letter, or surface area.
    #[arg(long, default_value = "seed")]
    build: BuildName,
    /// Triangles in a leaf at most.
    #[arg(long, value_name = "N", default_value_t = BuildOptions::default().leaf_size,
          value_parser = clap::value_parser!(u32).range(1..=i64::from(bvh::build::LEAF_SIZE_MAX)))]
    leaf_size: u32,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum BuildName {
    Seed,
    Literal,
    Sah,
}

impl TreeArgs {
    fn options(self) -> BuildOptions {
        BuildOptions { build: self.build.into(), leaf_size: self.leaf_size, threads: threads() }
    }
}

impl From<BuildName> for Build {
    fn from(name: BuildName) -> Self {
        match name {
            BuildName::Seed => Self::Seed,
            BuildName::Literal => Self::Literal,
            BuildName::Sah => Self::Sah,
        }
    }
}

/// Threads that build a tree; more than eight gain nothing, but each takes address space.
fn threads() -> usize {
    runtime::affinity::allowed_cores().len().clamp(1, 8)
}

pub(crate) fn run(verb: &Verb, output: &Output) -> Result<ExitCode, Failure> {
    match verb {
        Verb::Import(args) => import::run(args, output),
        Verb::Info { file, limits } => info::run(file, *limits, output),
        Verb::Check(args) => check::run(args, output),
        Verb::Generate(args) => generate::run(args, output),
        Verb::Export(args) => export::run(args, output),
        Verb::ImportChild { request } => reader::child::run(request),
    }
}
