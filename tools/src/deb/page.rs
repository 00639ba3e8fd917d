//! The page of the packages: what is in them, what lintian says, what a clean system saw.

use super::clean::field;
use super::{PROGRAM_MOST, Packages, Tried};
use crate::machine;
use anyhow::Result;
use check::built::CargoWorkspace;
use std::fmt::{self, Display, Formatter};

/// What a reader must not take from it.
const LIMITS: &str = include_str!("limits.md");

/// Everything that is on it.
#[derive(Debug)]
pub(crate) struct Page<'a> {
    machine: Vec<(&'static str, String)>,
    packages: Vec<(&'a Packages, [String; 2], [u64; 2])>,
    tried: &'a [Tried],
}

impl<'a> Page<'a> {
    /// Asks the packages.
    pub(crate) fn new(
        workspace: &CargoWorkspace,
        packages: &[&'a Packages],
        tried: &'a [Tried],
    ) -> Result<Self> {
        let mut all = Vec::new();
        for of in packages {
            let both = [&of.service, &of.developers];
            let needs = [field(both[0], "Depends")?, field(both[1], "Depends")?];
            let sizes = [both[0].metadata()?.len(), both[1].metadata()?.len()];
            all.push((*of, needs, sizes));
        }
        Ok(Self { machine: machine::describe(&workspace.root)?, packages: all, tried })
    }
}

impl Display for Page<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(
            "# Debian packages\n\n\
             Written by `cargo x deb`, which builds them into `target/aarch64/packages`, or \
             `$TROLLEY_AARCH64_ROOT/packages`.\n\n| | |\n|---|---|\n",
        )?;
        for (name, value) in &self.machine {
            writeln!(f, "| {name} | {value} |")?;
        }
        f.write_str(
            "\n| package | needs | package, bytes | program, bytes | built in, s |\n\
             |---|---|--:|--:|--:|\n",
        )?;
        for (of, needs, sizes) in &self.packages {
            let (arch, seconds) = (of.arch, of.seconds);
            let [service, developers] = needs;
            writeln!(
                f,
                "| `trolley`, {arch} | {service} | {} | {} | {seconds:.0} |\n\
                 | `libtrolley-client-dev`, {arch} | {developers} | {} | | |",
                sizes[0], of.program, sizes[1],
            )?;
        }
        let largest = self.packages.iter().map(|(of, ..)| of.program).max().unwrap_or_default();
        writeln!(
            f,
            "\nThe program is stripped and without the laboratory; it may have {PROGRAM_MOST} \
             bytes.{} It is built as\nthe profile `vehicle` says: small, but for what a request \
             goes through.\n\n\
             ## Answers as packed\n\n\
             BLAKE3 of `answer` byte for byte, the first 16 digits: each equals that of the \
             release\nbuild for x86-64.\n\n| scenario | program of | answer |\n|---|---|---|",
            if largest > PROGRAM_MOST { " **It is larger.**" } else { "" },
        )?;
        for (of, ..) in &self.packages {
            for (scenario, answer) in &of.answers {
                writeln!(f, "| {scenario} | {} | {answer} |", of.arch)?;
            }
        }
        f.write_str("\n## lintian\n\n")?;
        for (of, ..) in &self.packages {
            writeln!(f, "{}: no error; all that it says:\n\n```", of.arch)?;
            let said = of.lintian.trim();
            writeln!(f, "{}\n```\n", if said.is_empty() { "nothing" } else { said })?;
        }
        for tried in self.tried {
            let (system, seconds) = (&tried.system, tried.seconds);
            writeln!(f, "## {system}: `tools/deb/try` in {seconds:.0} s\n\n```")?;
            writeln!(f, "{}\n```\n", tried.log.trim())?;
        }
        f.write_str(LIMITS)?;
        for arch in ["amd64", "arm64"] {
            if self.packages.iter().all(|(of, ..)| of.arch != arch) {
                writeln!(f, "- **{arch}**, in this run.")?;
            }
        }
        Ok(())
    }
}
