//! The rows of the comparison: a program, its options, and on how many cores it runs.

use super::cases::Case;
use super::log::Measured;
use anyhow::{Context as _, Result, bail};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// How the names of all rows of ours begin.
pub(crate) const OURS: &str = "trolley";
/// How often a query is repeated within one run.
const REPEAT: &str = "9";

/// Under which conditions a row runs; each is a section of the page.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Section {
    /// One core, pinned, caches warm, the same query again and again.
    Warm,
    /// One core, pinned, B posed again for each query, like a moving body.
    Moving,
    /// One core, pinned, caches flushed before each query.
    Cold,
    /// Not pinned, on one thread and on two.
    Threads,
}

impl Section {
    /// Its name in files and messages.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Warm => "warm",
            Self::Moving => "moving",
            Self::Cold => "cold",
            Self::Threads => "threads",
        }
    }
}

/// The program to run.
#[derive(Clone, Debug)]
pub(crate) enum Program {
    /// Ours: `trolley intersect`.
    Trolley(PathBuf),
    /// A driver, which takes the folder of the case.
    Driver(PathBuf),
}

/// A program with its options.
#[derive(Clone, Debug)]
pub(crate) struct Row {
    /// What it is called on the page.
    pub(crate) name: String,
    /// Where it stands.
    pub(crate) section: Section,
    program: Program,
    options: Vec<&'static str>,
}

/// What we can be asked, in the order of the page; the first is what the others are compared with.
const OUR_OPTIONS: &[(&str, &[&str])] = &[
    ("", &[]),
    (" paper", &["--build", "paper"]),
    // What every processor of its kind has.
    #[cfg(target_arch = "x86_64")]
    (" sse2", &["--simd", "sse2"]),
    (" sets", &["--question", "sets"]),
    (" touches", &["--question", "touches"]),
];

/// All rows, section by section.
pub(crate) fn all(trolley: &Path, peers: &[(&str, PathBuf)], cold: bool) -> Vec<Row> {
    let ours = |section, suffix: &str, options: &[&[&'static str]]| Row {
        name: format!("{OURS}{suffix}"),
        section,
        program: Program::Trolley(trolley.into()),
        options: options.concat(),
    };
    let theirs = |section, peer: &(&str, PathBuf), suffix: &str, options: &[&'static str]| Row {
        name: format!("{}{suffix}", peer.0),
        section,
        program: Program::Driver(peer.1.clone()),
        options: options.into(),
    };
    let mut rows = Vec::new();
    let mut add = |section, ours_of: &[(&str, &[&'static str])], more: &[&'static str]| {
        rows.extend(ours_of.iter().map(|(suffix, own)| ours(section, suffix, &[own, more])));
        rows.extend(peers.iter().map(|peer| theirs(section, peer, "", more)));
    };
    add(Section::Warm, OUR_OPTIONS, &[]);
    add(Section::Moving, OUR_OPTIONS, &["--moving"]);
    if cold {
        add(Section::Cold, &OUR_OPTIONS[..2], &["--cold"]);
    }
    for (suffix, threads) in [(", 1 thread", "1"), (", 2 threads", "2")] {
        let threads: &[_] = &["--threads", threads];
        rows.push(ours(Section::Threads, suffix, &[threads]));
        // The others have none.
        let embree = peers.iter().filter(|peer| peer.0 == "embree");
        rows.extend(embree.map(|peer| theirs(Section::Threads, peer, suffix, threads)));
    }
    rows
}

/// What is exactly right for a case: by the oracle, once.
pub(crate) fn truth(oracle: &Path, case: &Case, core: usize) -> Result<Measured> {
    let mut command = pinned(core, oracle);
    command.arg(&case.folder).args(["--repeat", "1"]);
    measured(command)
}

impl Row {
    /// Names the row among all sections.
    pub(crate) fn key(&self) -> (Section, String) {
        (self.section, self.name.clone())
    }

    /// Whether it is one of ours.
    pub(crate) fn is_ours(&self) -> bool {
        matches!(self.program, Program::Trolley(_))
    }

    /// Runs it on a case.
    pub(crate) fn run(&self, case: &Case, core: usize) -> Result<Measured> {
        let (Program::Trolley(program) | Program::Driver(program)) = &self.program;
        let mut command = match self.section {
            Section::Warm | Section::Moving | Section::Cold => pinned(core, program),
            Section::Threads => Command::new(program),
        };
        match self.program {
            Program::Trolley(_) => {
                command.arg("intersect").args(["a.stl", "b.stl"].map(|name| case.file(name)));
                command.arg("--poses").arg(case.file("pose.txt")).arg("--json");
            }
            Program::Driver(_) => _ = command.arg(&case.folder),
        }
        command.args(["--repeat", REPEAT]).args(&self.options);
        measured(command)
    }
}

/// `program` on one core, its children too.
fn pinned(core: usize, program: &Path) -> Command {
    let mut command = Command::new("taskset");
    command.args(["--cpu-list", &core.to_string()]).arg(program);
    command
}

/// Runs a command and reads the line of JSON that it prints.
fn measured(mut command: Command) -> Result<Measured> {
    let done = command.stdin(Stdio::null()).output();
    let done = done.with_context(|| format!("cannot start {:?}", command.get_program()))?;
    if !done.status.success() {
        let said = String::from_utf8_lossy(&done.stderr);
        bail!("{}: {}", done.status, said.lines().next().unwrap_or("no output"));
    }
    let said = String::from_utf8(done.stdout)?;
    serde_json::from_str(&said).with_context(|| format!("not a line of results: {said}"))
}
