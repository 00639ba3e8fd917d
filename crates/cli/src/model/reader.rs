//! Reading a stranger's mesh in a process of its own, as its parent sees it.
//!
//! ```text
//! parent ── Request (argument) ──▶ child: limits itself, then reads, builds, encodes
//!        ◀── Word per line: Progress*, then Refused, or Read and the model file's bytes ──
//! ```
//!
//! Parsers are others' code, and hostile bytes may make them panic, abort, loop, overflow the
//! stack or ask for all memory. The kernel ends such a child; here its end becomes a sentence. The
//! child opens files for reading only, so nothing is left behind whatever ends it, and it dies with
//! its parent.

pub(super) mod child;

use super::{LimitArgs, MeshArgs, open};
use crate::output::Output;
use crate::progress::Progress;
use body::{Build, Kind, file};
use bvh::BuildOptions;
use mesh::import::{Axis, Unit};
use runtime::{Child, Exit, Spawn, process};
use serde::{Deserialize, Serialize};
use std::io::{self, BufRead as _, BufReader, PipeReader, Read};
use std::os::fd::AsFd as _;
use std::path::Path;
use trolley::Failure;

/// How the operating system says ENOMEM.
const NO_MEMORY: &str = "(os error 12)";
/// A megabyte of `--memory-mb`.
const MB: u64 = 1 << 20;
/// Memory that reading takes at most, if nothing was said `[MB]`: room for millions of triangles,
/// and not all of a small computer.
const MEMORY_MB: [u64; 2] = [2048, 8192];
/// Memory for each byte of the file: a million triangles as OBJ, PLY or STL took at most 11.
const MEMORY_RATIO: u64 = 64;
/// Heap in large pages for each byte of the file: all that is needed.
const HEAP_RATIO: u64 = 12;
/// Bytes of a file for each triangle, at least: binary PLY takes 19, STL 50.
const TRIANGLE_BYTES: u64 = 16;
/// Longest line that a child may send: reports hold no list longer than the notes of a file.
const LINE_MAX: u64 = 16 << 20;
/// How much of a child's last words on stderr is kept.
const STDERR_MAX: u64 = 64 << 10;
/// A child that has closed its pipe ends within this time, even while the kernel dumps it `[ms]`.
const END_MS: u64 = 10_000;

/// What to read, and what for.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Request {
    file: String,
    /// Whether every triangle is taken as it stands: no side file, nothing dropped, any size.
    as_it_stands: bool,
    unit_m: Option<f64>,
    up: Option<String>,
    forward: Option<String>,
    only: Vec<String>,
    kind: Option<Kind>,
    name: Option<String>,
    /// The tree to build; without one, this is a trial and no model file is made.
    tree: Option<(Build, u32)>,
    /// Threads that build it: no more than a file of this length is worth.
    threads: usize,
    memory_bytes: u64,
    /// Heap to have in large pages. What is not used of it takes addresses, and no memory.
    heap_bytes: usize,
    cpu_s: u64,
}

/// One line from the child.
#[derive(Debug, Serialize, Deserialize)]
enum Word {
    /// Triangles in the tree so far.
    Progress { done: u64, total: u64 },
    /// The file is at fault.
    Refused { what: String, remedy: Option<String> },
    /// The file was read; so many bytes of a model file follow.
    Read { report: Box<Report>, build_ns: u64, model_bytes: u64 },
}

/// What a child made of a mesh file.
#[derive(Debug)]
pub(crate) struct Outcome {
    pub(super) report: Report,
    /// The model file; empty for a trial.
    pub(crate) bytes: file::Aligned,
    /// Time that building the tree took.
    pub(crate) build_ns: u64,
}

/// What was found in a mesh file.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Report {
    pub(super) format: String,
    pub(super) unit_m: f64,
    pub(super) up: String,
    pub(super) forward: String,
    pub(super) triangles_in_file: usize,
    pub(super) triangles_selected: usize,
    pub(super) triangles: usize,
    pub(super) duplicates_dropped: usize,
    pub(super) degenerate_kept: u32,
    pub(super) size_m: [f64; 3],
    /// Size and guess in words.
    pub(super) sentence: String,
    pub(super) doubts: Vec<String>,
    pub(super) notes: Vec<String>,
    /// The side file that was used.
    pub(super) side_file: Option<String>,
}

impl Request {
    pub(super) fn new(
        file: &Path,
        mesh: &MeshArgs,
        name: Option<&str>,
        tree: Option<&BuildOptions>,
        limits: LimitArgs,
    ) -> Result<Self, Failure> {
        let Some(text) = file.to_str() else {
            let fault = format!("{}: its name is not UTF-8", file.display());
            return Err(Failure::input(fault).with_remedy("rename the file"));
        };
        // A missing file is the child's to report.
        let length = std::fs::metadata(file).map_or(0, |about| about.len());
        let usual = (length.saturating_mul(MEMORY_RATIO) / MB).clamp(MEMORY_MB[0], MEMORY_MB[1]);
        let memory_bytes = limits.memory_mb.unwrap_or(usual) * MB;
        let heap_bytes = length.saturating_mul(HEAP_RATIO).min(memory_bytes / 4);
        let threads = tree.map_or(1, |options| options.threads);
        Ok(Self {
            file: text.to_owned(),
            as_it_stands: false,
            unit_m: mesh.unit.map(Unit::metres),
            up: mesh.up.map(|axis| axis.to_string()),
            forward: mesh.forward.map(|axis| axis.to_string()),
            only: mesh.only.clone(),
            kind: mesh.kind,
            name: name.map(str::to_owned),
            tree: tree.map(|options| (options.build, options.leaf_size)),
            threads: bvh::worth_starting(threads, (length / TRIANGLE_BYTES) as usize),
            memory_bytes,
            heap_bytes: heap_bytes as usize,
            cpu_s: limits.cpu_s,
        })
    }

    /// To take every triangle of a mesh as it stands: the coordinates of the file are metres of
    /// the body's own frame, ids count from 0 in file order, nothing is left out, and the size
    /// may be any.
    pub(crate) fn as_it_stands(
        file: &Path,
        tree: &BuildOptions,
        limits: LimitArgs,
    ) -> Result<Self, Failure> {
        let mesh = MeshArgs {
            unit: Some(Unit::METRE),
            up: Some(Axis::Z),
            forward: Some(Axis::X),
            only: Vec::new(),
            // The kind does not matter here; this one has no mass, no seats and any shape.
            kind: Some(Kind::Building),
        };
        let request = Self::new(file, &mesh, None, Some(tree), limits)?;
        Ok(Self { as_it_stands: true, ..request })
    }

    /// Reads the file in a child.
    pub(crate) fn run(&self, output: &Output) -> Result<Outcome, Failure> {
        let (mut child, words, stderr) = self.start()?;
        let heard = hear(words, self.memory_bytes, output);
        let exit = child.wait_ms(END_MS)?;
        drop(child);
        let last_words = stderr.join().unwrap_or_default();
        match heard {
            Some((Word::Read { report, build_ns, .. }, bytes)) => {
                Ok(Outcome { report: *report, bytes, build_ns })
            }
            // The limit may strike while the file is read, which is an error and no abort.
            Some((Word::Refused { what, .. }, _)) if what.contains(NO_MEMORY) => {
                Err(self.took_too_much())
            }
            Some((Word::Refused { what, remedy: None }, _)) => Err(Failure::input(what)),
            Some((Word::Refused { what, remedy: Some(remedy) }, _)) => {
                Err(Failure::input(what).with_remedy(remedy))
            }
            _ => Err(self.ended(exit, &last_words)),
        }
    }

    fn start(&self) -> Result<(Child, PipeReader, std::thread::JoinHandle<String>), Failure> {
        let pipe =
            |error: io::Error| Failure::new(diagnostic::Kind::System, format!("no pipe: {error}"));
        let (words, says) = io::pipe().map_err(pipe)?;
        let (complaints, complains) = io::pipe().map_err(pipe)?;
        let request =
            serde_json::to_string(self).map_err(|error| Failure::internal(error.to_string()))?;
        let child = process::spawn(Spawn {
            program: process::self_exe(),
            args: &["model".to_owned(), "import-child".to_owned(), request],
            fds: &[(says.as_fd(), 1), (complains.as_fd(), 2)],
            core: None,
        })?;
        Ok((child, words, std::thread::spawn(move || start_of(complaints))))
    }

    /// The limit on memory struck.
    fn took_too_much(&self) -> Failure {
        let megabytes = self.memory_bytes / MB;
        let fault = format!("reading it needed more than {megabytes} MB of memory");
        Failure::input(format!("{}: {fault}", self.file)).with_remedy(format!(
            "allow more with --memory-mb {}, or reduce the mesh",
            4 * megabytes
        ))
    }

    /// Why a child ended without a report; `exit` is none if it did not end at all.
    fn ended(&self, exit: Option<Exit>, last_words: &str) -> Failure {
        let refuse = |fault: &str, help: String| {
            Failure::input(format!("{}: {fault}", self.file)).with_remedy(help)
        };
        if last_words.contains("memory allocation of") {
            return self.took_too_much();
        }
        if last_words.contains("overflowed its stack") {
            let help = "something in it is nested too deeply: export the mesh again";
            return refuse("reading it ran out of stack", help.to_owned());
        }
        match exit {
            Some(Exit::Code(code)) if code == diagnostic::Kind::System as i32 => {
                let fault = last_words.trim().trim_start_matches("error: ");
                Failure::new(diagnostic::Kind::System, format!("{}: {fault}", self.file))
                    .with_remedy(
                        "a limit of this session is lower: see ulimit -a, or use --memory-mb",
                    )
            }
            Some(Exit::Signal(_)) if exit.is_some_and(|exit| exit.to_string() == "SIGXCPU") => {
                refuse(
                    &format!("reading it was stopped after {} s of CPU time", self.cpu_s),
                    "allow more with --cpu-s, or reduce the mesh".to_owned(),
                )
            }
            Some(exit @ Exit::Signal(_)) => refuse(
                &format!("its reader crashed ({exit})"),
                "export the mesh again, or in another format".to_owned(),
            ),
            Some(exit @ Exit::Code(_)) => refuse(
                &format!("its reader gave up ({exit}) {}", last_words.trim()),
                "export the mesh again, or in another format".to_owned(),
            ),
            None => refuse(
                "its reader did not end and was killed",
                "export the mesh again, or in another format".to_owned(),
            ),
        }
    }
}

/// Follows a child's words to the last one, and takes the model file behind it, of at most
/// `bytes_max`. None if the child ended in mid-sentence, or says that it has more.
fn hear(words: PipeReader, bytes_max: u64, output: &Output) -> Option<(Word, file::Aligned)> {
    let mut words = BufReader::with_capacity(1 << 16, words);
    let begun_ns = runtime::clock::now_ns();
    let mut progress: Option<(Progress, u64)> = None;
    loop {
        let mut line = Vec::new();
        words.by_ref().take(LINE_MAX).read_until(b'\n', &mut line).ok()?;
        match serde_json::from_slice(&line).ok()? {
            Word::Progress { done, total } => {
                let (bar, before) = progress.get_or_insert_with(|| {
                    let bar = Progress::new("building the tree: triangles", total, output);
                    (bar.since(begun_ns), 0)
                });
                bar.add(done.saturating_sub(*before));
                *before = done;
            }
            Word::Read { report, build_ns, model_bytes } => {
                // It cannot have more than it was allowed: whoever says so speaks nonsense.
                let len = usize::try_from(model_bytes).ok().filter(|_| model_bytes <= bytes_max)?;
                let mut bytes = open::room(len);
                words.read_exact(bytes.bytes_mut()).ok()?;
                return Some((Word::Read { report, build_ns, model_bytes }, bytes));
            }
            word @ Word::Refused { .. } => return Some((word, file::Aligned::default())),
        }
    }
}

/// The start of what a child says on stderr; the rest is read, so that it never waits, and lost.
fn start_of(mut complaints: PipeReader) -> String {
    let mut start = Vec::new();
    // A pipe that breaks says no more.
    let _end = complaints.by_ref().take(STDERR_MAX).read_to_end(&mut start);
    let _rest = io::copy(&mut complaints, &mut io::sink());
    String::from_utf8_lossy(&start).into_owned()
}

#[cfg(test)]
mod tests;
