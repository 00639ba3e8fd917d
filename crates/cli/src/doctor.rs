//! `trolley doctor`: what this machine lacks for the service, and the remedy.

use crate::output::Output;
use crate::print;
use serde::Serialize;
use std::fmt::Write as _;
use std::process::ExitCode;
use trolley::doctor::{self, Finding, FindingLevel};
use trolley::{BUILD, Failure, FailureKind};

/// What `--json` prints.
#[derive(Serialize)]
struct Document<'a> {
    schema: &'static str,
    build: &'static str,
    findings: &'a [Finding],
}

pub(crate) fn run(output: &Output) -> Result<ExitCode, Failure> {
    let findings = doctor::look();
    if output.json {
        let document = Document { schema: "trolley.doctor/1", build: BUILD, findings: &findings };
        print::out(&print::json(&document)?)?;
    } else {
        print::lines(&page(&findings))?;
    }
    let has_problem = findings.iter().any(|finding| finding.level == FindingLevel::Problem);
    Ok(if has_problem { FailureKind::CheckFailed.into() } else { ExitCode::SUCCESS })
}

fn page(findings: &[Finding]) -> String {
    let mut text = String::new();
    for Finding { subject, level, found, remedy } in findings {
        let mark = match level {
            FindingLevel::Ok => "ok",
            FindingLevel::Note => "note",
            FindingLevel::Problem => "PROBLEM",
        };
        // Writing to a string cannot fail.
        let _ok = writeln!(text, "{mark:<8} {subject:<16} {found}");
        if !remedy.is_empty() {
            let _ok = writeln!(text, "{:25} → {remedy}", "");
        }
    }
    text
}
