//! `trolley model info`: what a model file holds.

use super::facts::Facts;
use super::open;
use crate::args::Output;
use crate::failure::Failure;
use crate::print;
use serde::Serialize;
use std::path::Path;
use std::process::ExitCode;

#[derive(Serialize)]
struct Document<'a> {
    schema: &'static str,
    file: String,
    body: &'a Facts,
}

pub(super) fn run(path: &Path, output: &Output) -> Result<ExitCode, Failure> {
    let map = open::bytes(path)?;
    let (meta, view) = open::view(path, map.bytes())?;
    let facts = Facts::new(meta, &view, map.bytes())?;
    if output.json {
        let schema = "trolley.model-info/1";
        let file = path.display().to_string();
        return print::out(&super::json(&Document { schema, file, body: &facts })?);
    }
    print::out(&facts.table(None, &[]))
}
