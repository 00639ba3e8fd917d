//! `trolley model info`: what a model file holds, or how a mesh might be meant.

use super::facts::{Facts, shown, thousands};
use super::reader::{Outcome, Request};
use super::{LimitArgs, open};
use crate::output::Output;
use crate::print;
use body::Mesh;
use bvh::BuildOptions;
use mesh::import::{Format, Reading, readings};
use serde::Serialize;
use std::fmt::Write as _;
use std::path::Path;
use std::process::ExitCode;
use trolley::{Failure, Kind};

/// Offers that are shown.
const READINGS_MAX: usize = 4;

#[derive(Serialize)]
struct Document<'a> {
    schema: &'static str,
    file: String,
    body: &'a Facts,
}

/// What `--json` says of a mesh.
#[derive(Serialize)]
struct MeshDocument {
    schema: &'static str,
    file: String,
    format: String,
    triangles: usize,
    /// Extent along x, y and z in the file's own numbers.
    extent: [f64; 3],
    parts: Vec<String>,
    notes: Vec<String>,
    /// Offers, likeliest first; nothing is applied.
    readings: Vec<Offer>,
}

#[derive(Serialize)]
struct Offer {
    unit: &'static str,
    up: String,
    forward: String,
    looks_like: &'static str,
    size_m: [f64; 3],
}

pub(super) fn run(path: &Path, limits: LimitArgs, output: &Output) -> Result<ExitCode, Failure> {
    if !open::is_model(path) {
        return mesh(path, limits, output);
    }
    let map = open::bytes(path)?;
    let (meta, view) = open::view(path, map.bytes())?;
    let facts = Facts::new(meta, &view, map.bytes())?;
    if output.json {
        let schema = "trolley.model-info/1";
        let file = path.display().to_string();
        return print::out(&print::json(&Document { schema, file, body: &facts })?);
    }
    print::out(&facts.table(None, &[]))
}

/// Reads a mesh in a child, as it stands, and says how it might be meant.
fn mesh(path: &Path, limits: LimitArgs, output: &Output) -> Result<ExitCode, Failure> {
    let request = Request::as_it_stands(path, &BuildOptions::default(), limits)?;
    let Outcome { report, bytes, .. } = request.run(output)?;
    let (meta, view) =
        open::view(path, bytes.bytes()).map_err(|failure| failure.of_kind(Kind::Internal))?;
    let format = Format::ALL.into_iter().find(|format| format.name() == report.format);
    let format = format.unwrap_or(Format::Obj);
    let whole = Mesh { corners: view.corners.to_vec(), ..Mesh::default() };
    let readings = readings(&whole, format, READINGS_MAX);
    let file = path.display().to_string();
    if output.json {
        let offer = |r: Reading| Offer {
            unit: r.unit,
            up: r.up,
            forward: r.forward,
            looks_like: r.looks_like,
            size_m: r.size_m,
        };
        return print::out(&print::json(&MeshDocument {
            schema: "trolley.model-info/1",
            file,
            format: report.format,
            triangles: report.triangles,
            extent: report.size_m,
            parts: meta.parts,
            notes: report.notes,
            readings: readings.into_iter().map(offer).collect(),
        })?);
    }
    let [x, y, z] = report.size_m;
    let mut text = format!(
        "{}: {} mesh, {} triangles, {x:.5} × {y:.5} × {z:.5} along x, y, z in its own numbers\n",
        shown(&file),
        report.format,
        thousands(report.triangles)
    );
    for (at, part) in meta.parts.iter().take(12).enumerate() {
        let _w = writeln!(text, "  {:<7}{}", if at == 0 { "parts" } else { "" }, shown(part));
    }
    if meta.parts.len() > 12 {
        let _w = writeln!(text, "         and {} more", meta.parts.len() - 12);
    }
    for note in &report.notes {
        let _w = writeln!(text, "  note   {}", shown(note));
    }
    if readings.is_empty() {
        text +=
            "It looks like nothing known, in no usual unit: say what it is when you import it.\n";
    }
    for (at, reading) in readings.iter().enumerate() {
        let [length, width, height] = reading.size_m;
        let Reading { unit, up, forward, looks_like, .. } = reading;
        let start = if at == 0 { "It looks like" } else { "  or like" };
        let _w = writeln!(
            text,
            "{start} {looks_like} in {unit}, up +{up}, forward {} ({length:.2} × {width:.2} × \
             {height:.2} m): --unit {unit} --up {up} --forward {forward}",
            if forward.starts_with('-') { forward.clone() } else { format!("+{forward}") }
        );
    }
    text +=
        "These are offers: nothing is applied. Which end is the front is told from habits; look.";
    print::out(&text)
}
