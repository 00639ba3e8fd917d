//! Reads an untrusted mesh in a separate process; this is the parent's side.
//!
//! ```text
//! parent ── ReadRequest (argument) ──▶ child: limits itself, then reads, builds, encodes
//!        ◀── Word per line: Progress*, then Refused, or Read and the model file's bytes ──
//! ```
//!
//! Only this module accesses files and processes; the parsers in [`import`](crate::import) are
//! pure. Parsers are third-party code, and hostile bytes may make them panic, abort, loop, overflow
//! the stack or exhaust memory. The kernel ends such a child; here its end becomes an error
//! message. The child opens files for reading only, so it leaves nothing behind however it ends,
//! and it dies with its parent.

mod child;
pub mod open;

use crate::import::{Axis, LengthUnit};
use body::{BodyKind, Build, file};
use bvh::BuildOptions;
use diagnostic::Failure;
use runtime::{Child, Exit, Spawn, process};
use serde::{Deserialize, Serialize};
use std::io::{self, BufRead as _, BufReader, PipeReader, Read};
use std::os::fd::AsFd as _;
use std::path::Path;

pub use child::play;

/// How the parent starts its own program as a child: `PROGRAM model import-child REQUEST`. A
/// program started with these two words passes the third to [`play()`].
pub const ROLE: [&str; 2] = ["model", "import-child"];

/// Called with the number of triangles in the tree so far and their total.
pub type OnProgress<'p> = &'p dyn Fn(u64, u64);

/// How long the child may take to begin (ms).
const EXEC_MS: u64 = 10_000;
/// How the operating system reports ENOMEM.
const NO_MEMORY: &str = "(os error 12)";
/// A megabyte of `--memory-mb`.
const MB: u64 = 1 << 20;
/// Default limits of memory for reading `[MB]`: enough for millions of triangles, but not all of a
/// small computer.
const MEMORY_MB: [u64; 2] = [2048, 8192];
/// Memory per byte of the file: a million triangles as OBJ, PLY or STL took at most 11.
const MEMORY_RATIO: u64 = 64;
/// Heap in large pages per byte of the file: all that is needed.
const HEAP_RATIO: u64 = 12;
/// Minimum number of bytes of a file per triangle: binary PLY takes 19, STL 50.
const TRIANGLE_BYTES: u64 = 16;
/// Maximum length of a line from a child: the longest list in a report is the notes of a file.
const LINE_MAX: u64 = 16 << 20;
/// How much of a child's output on stderr is kept.
const STDERR_MAX: u64 = 64 << 10;
/// A child that has closed its pipe ends within this time, even while the kernel writes a core dump
/// `[ms]`.
const END_MS: u64 = 10_000;

/// How to interpret a mesh file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshOptions {
    /// Unit of the coordinates; `None`: that of a COLLADA file, else metres. An LS-DYNA deck
    /// requires one.
    pub unit: Option<LengthUnit>,
    /// Axis of the file that points up; `None`: +y for glTF, that of a COLLADA file, else +z.
    pub up: Option<Axis>,
    /// Axis of the file that points forward; `None`: +z for glTF, else +x.
    pub forward: Option<Axis>,
    /// Parts, groups, objects, materials or nodes to keep; empty for all.
    pub only: Vec<String>,
    /// The kind of body; `None`: that of the TOML file beside the mesh.
    pub kind: Option<BodyKind>,
}

/// Limits of the process that reads a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ReadLimits {
    /// Memory (MB); `None`: 64 times the file, 2048 to 8192.
    pub memory_mb: Option<u64>,
    /// CPU time (s).
    pub cpu_s: u64,
}

impl ReadLimits {
    /// Default CPU time (s).
    pub const CPU_S: u64 = 120;
}

impl Default for ReadLimits {
    fn default() -> Self {
        Self { memory_mb: None, cpu_s: Self::CPU_S }
    }
}

/// What to read, and for which purpose.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct ReadRequest {
    file: String,
    /// Whether every triangle is taken as stored: no side file, nothing dropped, any size.
    as_it_stands: bool,
    unit_m: Option<f64>,
    up: Option<String>,
    forward: Option<String>,
    only: Vec<String>,
    kind: Option<BodyKind>,
    name: Option<String>,
    /// The tree to build; without one, this is a trial and no model file is made.
    tree: Option<(Build, u32)>,
    /// Threads for building the tree: no more than a file of this length is worth.
    threads: usize,
    memory_bytes: u64,
    /// Heap to reserve in large pages. The unused part takes address space, but no memory.
    heap_bytes: usize,
    cpu_s: u64,
}

/// One line from the child.
#[derive(Debug, Serialize, Deserialize)]
enum ChildMessage {
    /// Triangles in the tree so far.
    Progress { done: u64, total: u64 },
    /// The file is invalid.
    Refused { what: String, remedy: Option<String> },
    /// The file was read; a model file of this many bytes follows.
    Read { report: Box<Report>, build_ns: u64, model_bytes: u64 },
}

/// The result of reading a mesh file.
#[derive(Debug)]
pub struct ReadMesh {
    /// The report.
    pub report: Report,
    /// The model file; empty for a trial. A corrupted child may send an invalid one.
    pub bytes: file::Aligned,
    /// Time that building the tree took (ns).
    pub build_ns: u64,
}

/// The report on a mesh file.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Report {
    /// Name of the format.
    pub format: String,
    /// The unit used (m).
    pub unit_m: f64,
    /// The unit (m) and the up axis that the file states, used or not.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub stated: Option<(f64, String)>,
    /// The axis of the file used as up.
    pub up: String,
    /// The axis of the file used as forward.
    pub forward: String,
    /// Triangles before any selection.
    pub triangles_in_file: usize,
    /// Triangles of the selected parts.
    pub triangles_selected: usize,
    /// Triangles of the body.
    pub triangles: usize,
    /// Triangles dropped because another one has the same corners.
    pub duplicates_dropped: usize,
    /// Triangles of zero area, which are kept.
    pub degenerate_kept: u32,
    /// Pieces that hang together by edges.
    pub shells: usize,
    /// Edges of an odd number of triangles; 0 if the body is watertight.
    pub open_edges: usize,
    /// Extent forward, left and up (m).
    pub size_m: [f64; 3],
    /// Size and guess in words.
    pub sentence: String,
    /// Doubts about unit and axes.
    pub doubts: Vec<String>,
    /// Observations about the file.
    pub notes: Vec<String>,
    /// The side file used.
    pub side_file: Option<String>,
}

impl ReadRequest {
    /// Creates a request to read `file` and make a model file called `name` with this tree; without
    /// a tree, only to check that it can be read.
    ///
    /// # Errors
    ///
    /// The file's name is not UTF-8.
    pub fn new(
        file: &Path,
        mesh: &MeshOptions,
        name: Option<&str>,
        tree: Option<&BuildOptions>,
        limits: ReadLimits,
    ) -> Result<Self, Failure> {
        let Some(text) = file.to_str() else {
            let fault = format!("{}: its name is not UTF-8", file.display());
            return Err(Failure::input(fault).with_remedy("rename the file"));
        };
        // A missing file is reported by the child.
        let length = std::fs::metadata(file).map_or(0, |about| about.len());
        let usual = (length.saturating_mul(MEMORY_RATIO) / MB).clamp(MEMORY_MB[0], MEMORY_MB[1]);
        let memory_bytes = limits.memory_mb.unwrap_or(usual) * MB;
        let heap_bytes = length.saturating_mul(HEAP_RATIO).min(memory_bytes / 4);
        let threads = tree.map_or(1, |options| options.threads);
        Ok(Self {
            file: text.to_owned(),
            as_it_stands: false,
            unit_m: mesh.unit.map(LengthUnit::metres),
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

    /// Creates a request to take every triangle of a mesh as stored: coordinates are metres in the
    /// body's own frame, ids count from 0 in file order, nothing is dropped, and any size is
    /// accepted.
    ///
    /// # Errors
    ///
    /// The file's name is not UTF-8.
    pub fn as_it_stands(
        file: &Path,
        tree: &BuildOptions,
        limits: ReadLimits,
    ) -> Result<Self, Failure> {
        let mesh = MeshOptions {
            unit: Some(LengthUnit::METRE),
            up: Some(Axis::Z),
            forward: Some(Axis::X),
            only: Vec::new(),
            // The kind does not matter here; this one has no mass, no seats and any shape.
            kind: Some(BodyKind::Building),
        };
        let request = Self::new(file, &mesh, None, Some(tree), limits)?;
        Ok(Self { as_it_stands: true, ..request })
    }

    /// Reads the file in a child: this program, started again in its [`ROLE`].
    ///
    /// # Errors
    ///
    /// The file is invalid, reading exceeded a limit, or the child could not be started.
    pub fn run(&self, progress: OnProgress<'_>) -> Result<ReadMesh, Failure> {
        let (mut child, words, stderr) = self.start()?;
        let heard = hear(words, self.memory_bytes, progress);
        let exit = child.wait_ms(END_MS)?;
        drop(child);
        let last_words = stderr.join().unwrap_or_default();
        match heard {
            Some((ChildMessage::Read { report, build_ns, .. }, bytes)) => {
                Ok(ReadMesh { report: *report, bytes, build_ns })
            }
            // The limit may be reached while the file is read, which is an error and not an abort.
            Some((ChildMessage::Refused { what, .. }, _)) if what.contains(NO_MEMORY) => {
                Err(self.took_too_much())
            }
            Some((ChildMessage::Refused { what, remedy: None }, _)) => Err(Failure::input(what)),
            Some((ChildMessage::Refused { what, remedy: Some(remedy) }, _)) => {
                Err(Failure::input(what).with_remedy(remedy))
            }
            _ => Err(self.ended(exit, &last_words)),
        }
    }

    fn start(&self) -> Result<(Child, PipeReader, std::thread::JoinHandle<String>), Failure> {
        let pipe = |error: io::Error| {
            Failure::new(diagnostic::FailureKind::System, format!("no pipe: {error}"))
        };
        let (words, says) = io::pipe().map_err(pipe)?;
        let (complaints, complains) = io::pipe().map_err(pipe)?;
        let request =
            serde_json::to_string(self).map_err(|error| Failure::internal(error.to_string()))?;
        let child = process::spawn(Spawn {
            program: process::self_exe(),
            args: &[ROLE[0].to_owned(), ROLE[1].to_owned(), request],
            fds: &[(says.as_fd(), 1), (complains.as_fd(), 2)],
            core: None,
        })?
        .await_exec(EXEC_MS)?;
        Ok((child, words, std::thread::spawn(move || start_of(complaints))))
    }

    /// The error for reaching the memory limit.
    fn took_too_much(&self) -> Failure {
        let megabytes = self.memory_bytes / MB;
        let fault = format!("reading it needed more than {megabytes} MB of memory");
        Failure::input(format!("{}: {fault}", self.file)).with_remedy(format!(
            "allow more with --memory-mb {}, or reduce the mesh",
            4 * megabytes
        ))
    }

    /// Why a child ended without a report; `exit` is `None` if it did not end at all.
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
            Some(Exit::Code(code)) if code == diagnostic::FailureKind::System as i32 => {
                let fault = last_words.trim().trim_start_matches("error: ");
                Failure::new(diagnostic::FailureKind::System, format!("{}: {fault}", self.file))
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

/// Reads a child's messages up to the last one, and the model file after it, of at most
/// `bytes_max`. `None` if the child ended in mid-message, or claims a longer file.
fn hear(
    words: PipeReader,
    bytes_max: u64,
    progress: OnProgress<'_>,
) -> Option<(ChildMessage, file::Aligned)> {
    let mut words = BufReader::with_capacity(1 << 16, words);
    loop {
        let mut line = Vec::new();
        words.by_ref().take(LINE_MAX).read_until(b'\n', &mut line).ok()?;
        match serde_json::from_slice(&line).ok()? {
            ChildMessage::Progress { done, total } => progress(done, total),
            ChildMessage::Read { report, build_ns, model_bytes } => {
                // A longer file than allowed cannot be valid.
                let len = usize::try_from(model_bytes).ok().filter(|_| model_bytes <= bytes_max)?;
                let mut bytes = open::zeroed_buffer(len);
                words.read_exact(bytes.bytes_mut()).ok()?;
                return Some((ChildMessage::Read { report, build_ns, model_bytes }, bytes));
            }
            word @ ChildMessage::Refused { .. } => return Some((word, file::Aligned::default())),
        }
    }
}

/// The start of a child's stderr; the rest is read, so that the child never blocks, and discarded.
fn start_of(mut complaints: PipeReader) -> String {
    let mut start = Vec::new();
    // A broken pipe ends the output.
    let _end = complaints.by_ref().take(STDERR_MAX).read_to_end(&mut start);
    let _rest = io::copy(&mut complaints, &mut io::sink());
    String::from_utf8_lossy(&start).into_owned()
}

#[cfg(test)]
mod tests;
