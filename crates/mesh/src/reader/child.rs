//! Reads an untrusted mesh, in the process that may crash.
//!
//! It limits itself before it opens anything, opens files for reading only, and communicates only
//! with its parent: one [`ChildMessage`] per line on stdout.

use super::{ChildMessage, ReadRequest, Report, open};
use crate::import::{
    self, Axis, Format, ImportError, ImportOptions, ImportedMesh, LengthUnit, MeshDefect,
    likely_kind,
};
use crate::side::SideFile;
use body::{BodyKind, Mesh, Zones, defaults, file, zones};
use bvh::BuildOptions;
use diagnostic::Failure;
use rayon::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};
use runtime::affinity::{allowed_cores, pin_self};
use runtime::clock::now_ns;
use runtime::realtime::Soon;
use runtime::{InputError, InputKind, input};
use std::io::{self, Write as _};
use std::panic::{self, AssertUnwindSafe};
use std::path::{Path, PathBuf};
use std::sync::Mutex;

/// Minimum time between two progress messages. Each wakes the parent, which may take the core of a
/// thread that builds: with two threads on two cores, without this limit, 4 % of a tree's time.
const BETWEEN_WORDS_NS: u64 = 50_000_000;

/// The part of the heap whose pages are touched while the file is read: the first third. All of it
/// made no difference to a tree of 10,000 triangles.
const PLACED: usize = 3;

/// Fewer triangles are not worth another thread for their zones.
const SHARE_MIN: usize = 1024;

/// The message of a panic, kept for the parent instead of printed.
static PANIC: Mutex<Option<String>> = Mutex::new(None);

/// Runs the child, in a process that a parent started for it, and returns its exit code. `request`
/// is what the parent wrote on the command line.
///
/// Stdout and stderr are the channels to the parent, and limits apply to the whole process: it can
/// do nothing else afterwards.
#[must_use]
pub fn play(request: &str) -> u8 {
    let played = limited(request);
    played.unwrap_or_else(|failure| {
        // The parent repeats it. If the parent has exited, nobody reads this.
        let _gone = writeln!(io::stderr().lock(), "error: {failure}");
        failure.kind().exit_code()
    })
}

/// Limits this process, reads, and reports to the parent.
fn limited(request: &str) -> Result<u8, Failure> {
    runtime::process::set_name("trolley-import");
    let request: ReadRequest = serde_json::from_str(request).map_err(|error| {
        Failure::setting(error.to_string()).with_remedy("use: trolley model import")
    })?;
    runtime::process::limit_self(request.memory_bytes, request.cpu_s)?;
    // Building begins where reading freed its memory: two trees of a million triangles each are
    // built 10 % sooner by one thread, 15 % by two. In large pages, two threads take 8 to 11 % less
    // time for 100,000, and, with some placed in advance, 30 page faults instead of 885.
    let heap = runtime::realtime::share_heap(request.heap_bytes);
    panic::set_hook(Box::new(|info| {
        if let Ok(mut said) = PANIC.lock() {
            said.get_or_insert_with(|| info.to_string().replace('\n', " "));
        }
    }));
    let builders = request.builders(heap);
    let outcome = panic::catch_unwind(AssertUnwindSafe(|| request.read(builders.as_ref())));
    match outcome.unwrap_or_else(|_payload| Err(request.panicked())) {
        Ok((report, build_ns, bytes)) => {
            let model_bytes = bytes.len() as u64;
            say(&ChildMessage::Read { report: Box::new(report), build_ns, model_bytes })?;
            send(&bytes)?;
            Ok(0)
        }
        Err(failure) => {
            let (what, remedy) = (failure.what().to_owned(), failure.remedy().map(str::to_owned));
            say(&ChildMessage::Refused { what, remedy })?;
            Ok(failure.kind().exit_code())
        }
    }
}

/// Zones of every triangle of a mesh, computed by all threads of the caller's pool. These build the
/// tree next: so they are awake and have the triangles in their caches, which for 10,000 of them
/// saves 5 to 9 % of the build.
fn zones_by_all(mesh: &Mesh, kind: BodyKind) -> Vec<Zones> {
    let bounds = mesh.bounds();
    let zones = mesh.corners.par_iter().with_min_len(SHARE_MIN);
    zones.map(|corners| zones::of_triangle(corners, &bounds, kind)).collect()
}

fn say(word: &ChildMessage) -> Result<(), Failure> {
    let line = serde_json::to_string(word).map_err(|error| Failure::internal(error.to_string()))?;
    send(format!("{line}\n").as_bytes())
}

/// Writes to the parent. It is not an error if the parent has exited.
fn send(bytes: &[u8]) -> Result<(), Failure> {
    let mut stdout = io::stdout().lock();
    match stdout.write_all(bytes).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => Err(Failure::new(
            diagnostic::FailureKind::System,
            format!("cannot write the output: {error}"),
        )),
        _ => Ok(()),
    }
}

impl ReadRequest {
    /// Starts the threads that will build the tree, if there are several. They start now, and while
    /// they wait for the mesh, one of them touches memory: if started for the build, two of them
    /// may be placed on one core and stay there for a large part of a small tree's time. The same
    /// can happen on wake-up: so if there is a core for each, each is pinned to its own.
    fn builders(&self, heap: Soon) -> Option<ThreadPool> {
        if self.threads < 2 {
            return None;
        }
        let cores = allowed_cores();
        let one_each = self.threads == cores.len();
        let pin = move |thread: usize| {
            if one_each {
                // An unpinned thread also works, if more slowly.
                let _pinned = pin_self(cores[thread]);
            }
        };
        let threads = ThreadPoolBuilder::new().num_threads(self.threads).start_handler(pin);
        let threads = threads.build().ok()?;
        let bytes = self.heap_bytes / PLACED;
        threads.spawn(move || heap.place(bytes));
        Some(threads)
    }

    /// Returns the report, the time to build the tree in nanoseconds, and the model file; no bytes
    /// for a trial.
    fn read(&self, builders: Option<&ThreadPool>) -> Result<(Report, u64, Vec<u8>), Failure> {
        let path = Path::new(&self.file);
        let map = open::bytes(path, InputKind::Mesh)?;
        let side = if self.as_it_stands { None } else { self.side(path)? };
        let kind = self.kind.or_else(|| side.as_ref().and_then(SideFile::kind));
        let format = Format::detect(&self.file, map.bytes())?;
        let folder = folder(path);
        let mut resolve = |name: &str| side_file(&folder, name);
        let mut imported = import::read(format, map.bytes(), &mut resolve, &self.options(kind)?)
            .map_err(|error| self.by_import(error))?;
        drop(map);
        if let (Some(flag), Some(said)) = (self.kind, side.as_ref().and_then(SideFile::kind))
            && flag != said
        {
            let note = format!("--kind {flag} was used; the side file says {said}");
            imported.report.notes.push(note);
        }
        let report = report(&imported, side.as_ref().map(|_| side_path(path)));
        let Some((build, leaf_size)) = self.tree else { return Ok((report, 0, Vec::new())) };
        let kind = kind.ok_or_else(|| self.kind_missing(path, &imported))?;
        let options = BuildOptions { build, leaf_size, threads: self.threads };
        let (build_ns, bytes) =
            self.model_file(imported, kind, side.as_ref(), &options, builders)?;
        Ok((report, build_ns, bytes))
    }

    fn options(&self, kind: Option<BodyKind>) -> Result<ImportOptions, Failure> {
        let axis = |text: &Option<String>| text.as_deref().map(str::parse::<Axis>).transpose();
        let unit = self.unit_m.map(|metres| metres.to_string().parse::<LengthUnit>());
        Ok(ImportOptions {
            file: self.file.clone(),
            unit: unit.transpose()?,
            up: axis(&self.up)?,
            forward: axis(&self.forward)?,
            only: self.only.clone(),
            kind,
            // A trial may examine a file of which nothing is known yet.
            any_size: self.as_it_stands || (self.tree.is_none() && kind.is_none()),
            keep_duplicates: self.as_it_stands,
            name: self.name.clone(),
        })
    }

    fn model_file(
        &self,
        imported: ImportedMesh,
        kind: BodyKind,
        side: Option<&SideFile>,
        options: &BuildOptions,
        builders: Option<&ThreadPool>,
    ) -> Result<(u64, Vec<u8>), Failure> {
        let ImportedMesh { mesh, report } = imported;
        let origin = defaults::Origin {
            name: &report.name,
            kind,
            origin: &report.origin,
            hash: &report.hash,
        };
        let assemble = || defaults::assemble(origin, &mesh);
        let mut meta = builders.map_or_else(assemble, |threads| threads.install(assemble));
        if let Some(side) = side {
            side.apply(&mut meta, &mesh.bounds())?;
        }
        if let Some(name) = &self.name {
            name.clone_into(&mut meta.name);
        }
        let total = mesh.corners.len() as u64;
        // Number of triangles placed, and when it was last reported.
        let placed = Mutex::new((0_u64, now_ns()));
        let progress = |more: u64| {
            let Ok(mut placed) = placed.lock() else { return };
            let (done, said_ns) = &mut *placed;
            *done += more;
            if now_ns() - *said_ns >= BETWEEN_WORDS_NS {
                *said_ns = now_ns();
                // If the parent exits, this process ends with it.
                let _told = say(&ChildMessage::Progress { done: *done, total });
            }
        };
        let build = |zones: fn(&Mesh, BodyKind) -> Vec<Zones>| {
            let zones = zones(&mesh, kind);
            let begun_ns = now_ns();
            let body = bvh::body(mesh, meta, zones, options, &progress);
            (body, now_ns() - begun_ns)
        };
        let (body, build_ns) = match builders {
            Some(threads) => threads.install(|| build(zones_by_all)),
            None => build(zones::of_mesh),
        };
        let body = body.map_err(|error| Failure::input(error.to_string()).at(&self.file))?;
        let bytes = file::encode(&body).map_err(|error| Failure::from(error).at(&self.file))?;
        Ok((build_ns, bytes))
    }

    /// Without a way to state a unit, a unit is not the remedy.
    fn by_import(&self, error: ImportError) -> Failure {
        let is_too_far = matches!(error.fault, MeshDefect::TooFar { .. });
        let failure = Failure::from(error);
        if is_too_far && self.as_it_stands {
            let remedy = "coordinates are taken as they stand: move the body to its origin";
            return failure.with_remedy(remedy);
        }
        failure
    }

    /// The TOML file beside the mesh, if there is one.
    fn side(&self, path: &Path) -> Result<Option<SideFile>, Failure> {
        let name = side_path(path);
        let text = match input::text(&name, InputKind::SideFile) {
            Err(InputError::Missing { .. }) => return Ok(None),
            read => read?,
        };
        Ok(Some(SideFile::parse(&name.display().to_string(), &text)?))
    }

    fn kind_missing(&self, path: &Path, imported: &ImportedMesh) -> Failure {
        let looks_like = imported.report.guess.looks_like;
        let likely = looks_like.and_then(likely_kind).map_or("K", BodyKind::name);
        let offers = match looks_like {
            Some(_) => String::new(),
            None => {
                format!("; unit, axes and kind are offered by: trolley model info {}", self.file)
            }
        };
        let kinds = BodyKind::ALL.map(BodyKind::name).join(", ");
        let guess = &imported.report.guess;
        let doubts: String = guess.doubts.iter().map(|doubt| format!("; {doubt}")).collect();
        Failure::input(format!(
            "{}: what this body is was not said; it measures {guess}{doubts}",
            self.file
        ))
        .with_remedy(format!(
            "add --kind {likely}, or write kind = \"...\" into {}; kinds: {kinds}{offers}",
            side_path(path).display()
        ))
    }

    fn panicked(&self) -> Failure {
        let said = PANIC.lock().ok().and_then(|mut said| said.take()).unwrap_or_default();
        Failure::input(format!("{}: its reader failed: {said}", self.file))
            .with_remedy("export the mesh again, or in another format")
    }
}

fn report(imported: &ImportedMesh, side: Option<PathBuf>) -> Report {
    let it = &imported.report;
    Report {
        format: it.format.name().to_owned(),
        unit_m: it.frame.unit.metres(),
        stated: it.stated.map(|stated| (stated.unit.metres(), stated.up.to_string())),
        up: it.frame.up.to_string(),
        forward: it.frame.forward.to_string(),
        triangles_in_file: it.triangles_in_file,
        triangles_selected: it.triangles_selected,
        triangles: it.triangles,
        duplicates_dropped: it.duplicates,
        degenerate_kept: it.degenerate,
        shells: it.shells,
        open_edges: it.open_edges,
        size_m: it.guess.size_m,
        sentence: it.guess.to_string(),
        doubts: it.guess.doubts.clone(),
        notes: it.notes.clone(),
        side_file: side.map(|path| path.display().to_string()),
    }
}

fn side_path(path: &Path) -> PathBuf {
    path.with_extension("toml")
}

fn folder(path: &Path) -> PathBuf {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent.to_owned(),
        _ => PathBuf::from("."),
    }
}

/// Reads a file that a mesh names, from the mesh's folder. Names that lead out are rejected before;
/// links that lead out are rejected here.
fn side_file(folder: &Path, name: &str) -> Result<Vec<u8>, String> {
    let path = folder.join(name);
    let real = path.canonicalize().map_err(|error| match error.kind() {
        io::ErrorKind::NotFound => format!("there is no {}", path.display()),
        _ => error.to_string(),
    })?;
    let root = folder.canonicalize().map_err(|error| error.to_string())?;
    if !real.starts_with(&root) {
        return Err(format!("it leads out of the mesh's folder, to {}", real.display()));
    }
    input::bytes(&real, InputKind::Mesh).map_err(|error| diagnostic::chain(&error))
}
