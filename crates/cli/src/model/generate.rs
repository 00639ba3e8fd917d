//! `trolley model generate`: a model file of a generated body.

use super::facts::Facts;
use super::{TreeArgs, open, write};
use crate::output::Output;
use crate::progress::Progress;
use crate::{bodies, print};
use body::Shape;
use body::file;
use clap::Args as ClapArgs;
use serde::Serialize;
use shapes::{TRIANGLES_MAX, TRIANGLES_MIN};
use std::path::PathBuf;
use std::process::ExitCode;
use trolley::{Failure, Kind};

pub(super) const EXAMPLES: &str = "\
Examples:
  trolley model generate wall --triangles 500 -o wall.trolley
  trolley model generate sedan --triangles 100000 --seed 7 -o sedan.trolley

Shapes: sedan, suv, truck, bus, motorcycle, cyclist, pedestrian, wall, pole.";

#[derive(Debug, ClapArgs)]
pub(crate) struct GenerateArgs {
    /// What to generate.
    shape: Shape,
    /// How finely; an odd number gives one triangle less.
    #[arg(long, value_name = "N",
          value_parser = clap::value_parser!(u32)
              .range(i64::from(TRIANGLES_MIN)..=i64::from(TRIANGLES_MAX)))]
    triangles: u32,
    /// Varies size and proportions by a few per cent; 0 is the nominal body.
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    #[command(flatten)]
    tree: TreeArgs,
    /// Model file to write.
    #[arg(short, long, value_name = "OUT.trolley")]
    out: PathBuf,
}

#[derive(Serialize)]
struct Document<'a> {
    schema: &'static str,
    file: String,
    body: &'a Facts,
}

pub(super) fn run(args: &GenerateArgs, output: &Output) -> Result<ExitCode, Failure> {
    write::check(&args.out, None)?;
    let progress = Progress::new("building the tree: triangles", u64::from(args.triangles), output);
    let options = args.tree.options();
    let body = bodies::generate_body(args.shape, args.triangles, args.seed, &options, &|n| {
        progress.add(n)
    })?;
    drop(progress);
    let bytes =
        file::encode(&body).map_err(|error| Failure::from(error).of_kind(Kind::Internal))?;
    drop(body);
    let bytes = file::Aligned::copy_of(&bytes);
    let (meta, view) = open::view(&args.out, bytes.bytes())?;
    let facts = Facts::new(meta, &view, bytes.bytes())?;
    write::replace(&args.out, bytes.bytes())?;
    let name = args.out.display().to_string();
    if output.json {
        let schema = "trolley.model-generate/1";
        return print::out(&print::json(&Document { schema, file: name, body: &facts })?);
    }
    if output.quiet {
        return Ok(ExitCode::SUCCESS);
    }
    print::out(&format!("{name}: {}", facts.table(None, &[])))
}
