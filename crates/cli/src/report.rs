//! `trolley report`: a decision record or a measurement as one HTML file; contacts as .glb and PNG.

use crate::output::Output;
use crate::print;
use clap::Args;
use clap::builder::NonEmptyStringValueParser;
use report::Wanted;
use std::path::PathBuf;
use std::process::ExitCode;
use trolley::Failure;

pub(crate) const EXAMPLES: &str = "\
Examples:
  trolley demo --record decisions && trolley report decisions/000000.record --out demo.html
  trolley report decisions/000000.record --out demo.html --glb meshes --png stills
  trolley report tools/results/measure --out measure.html

The page is a single file and needs no network.";

#[derive(Debug, Args)]
pub(crate) struct ReportArgs {
    /// A decision record, or a folder that `trolley measure --out` wrote.
    source: PathBuf,
    /// HTML page to write.
    #[arg(short, long, value_name = "FILE.html")]
    out: Option<PathBuf>,
    /// Write what the page shows as one JSON document: see `trolley schema --report`.
    #[arg(long, value_name = "FILE.json")]
    report_json: Option<PathBuf>,
    /// Folder with the record's model files, which are found by their hash.
    #[arg(long, value_name = "DIR")]
    models: Option<PathBuf>,
    /// Write each contact into this folder as .glb, with damage as vertex colours.
    #[arg(long, value_name = "DIR")]
    glb: Option<PathBuf>,
    /// Write two stills of each contact into this folder: from a corner and from above.
    #[arg(long, value_name = "DIR")]
    png: Option<PathBuf>,
    /// Write the contacts into this file as MCAP, for Foxglove and Lichtblick.
    #[cfg(feature = "mcap")]
    #[arg(long, value_name = "FILE.mcap")]
    mcap: Option<PathBuf>,
    /// Write .glb and stills of this candidate only; may be repeated.
    #[arg(long, value_name = "NAME", value_parser = NonEmptyStringValueParser::new())]
    candidate: Vec<String>,
}

pub(crate) fn run(args: &ReportArgs, output: &Output) -> Result<ExitCode, Failure> {
    let wanted = Wanted {
        page: args.out.clone(),
        json: args.report_json.clone(),
        glb: args.glb.clone(),
        stills: args.png.clone(),
        #[cfg(feature = "mcap")]
        mcap: args.mcap.clone(),
        candidates: args.candidate.clone(),
    };
    let progress = output.progress("building bodies: triangles");
    let told = |done, total| progress.set(done, total);
    let written = report::write(&args.source, args.models.as_deref(), &wanted, &told)?;
    drop(progress);
    if output.json {
        let files: Vec<String> = written.iter().map(|path| path.display().to_string()).collect();
        let document = serde_json::json!({"schema": "trolley.report/1", "files": files});
        return print::out(&print::json(&document)?);
    }
    if output.quiet {
        return Ok(ExitCode::SUCCESS);
    }
    let lines: Vec<String> =
        written.iter().map(|path| format!("written: {}", path.display())).collect();
    print::out(&lines.join("\n"))
}
