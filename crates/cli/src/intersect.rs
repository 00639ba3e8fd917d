//! `trolley intersect`: the exact kernel alone, on two bodies at one pose, timed.
//! [`trolley::intersect`] does the work.

use crate::model::{BuildName, LimitArgs, reading, shown, thousands};
use crate::output::Output;
use crate::print;
use clap::{Args as ClapArgs, ValueEnum};
use std::path::PathBuf;
use std::process::ExitCode;
use trolley::Failure;
use trolley::intersect::{Found, Intersect, Intersected, QueryResult, Question, Simd, Walk, hex};
use trolley::model::{BuildOptions, LEAF_SIZE_MAX};

pub(crate) const EXAMPLES: &str = "\
Examples:
  trolley intersect a.stl b.stl --poses pose.txt
  trolley intersect a.stl b.stl --poses pose.txt --question sets --threads 2 --repeat 9 --json

POSES holds the world poses of A and of B, each as three lines of four numbers, R | t in metres.
The long help (--help) explains the fields of --json.";

pub(crate) const HELP: &str = "\
Examples:
  trolley intersect a.stl b.stl --poses pose.txt
  trolley intersect a.stl b.stl --poses pose.txt --question sets --threads 2 --repeat 9 --json

POSES holds the world poses of A and of B, each as three lines of four numbers, R | t in metres; a #
begins a comment. Everything is computed in A's frame: R = RaᵀRb and t = Raᵀ(tb − ta) in f64, sums
left to right, and a vertex of B is ((R₀x + R₁y) + R₂z) + t, never fused, never rounded again. On
these triangles the answer is exact: triangles are closed, touching counts, and a degenerate
triangle is the segment or point that it is.

A mesh (STL, OBJ, PLY, glTF, GLB) is used as it is: its coordinates are metres, nothing is dropped
or merged, and ids number the triangles in file order, from 0. In a model file (.trolley) ids are
those of the mesh that it was imported from.

With --json, one line:
  peer, schema       \"trolley\", 1
  case               name of the folder of A
  question, build, leaf_size, simd, walk, threads, cold, moving
                     as requested, or as chosen
  triangles_a, triangles_b
                     triangles of the bodies
  build_ms           time to build both trees; 0 where a model file already has the tree
  pose_ms            setup of a new pose before the query, median
  query_ms           median over the repeats, after one warm-up; several threads warm up for 60 ms,
                     until each has a core of its own. With --moving, B is shifted by up to 4 mm
                     along x each time, because a processor learns the branches of a query that is
                     only repeated; the results are those of the unshifted pose
  nb, np             tests of boxes and of triangles in one query
  jobs               parts of the last query: 1 unless several threads share the work
and according to the question:
  pairs              pairs: how many intersect; touches: 1 if any does, else 0
  hash               pairs: sum modulo 2^64 of splitmix64(idA << 32 | idB), 16 hexadecimal digits;
                     touches: empty
  hits_a, hits_b     sets: triangles of A and of B that are hit
  hash_a, hash_b     sets: sums modulo 2^64 of splitmix64(id)";

#[derive(Debug, ClapArgs)]
pub(crate) struct IntersectArgs {
    /// The first body: .stl, .obj, .ply, .gltf, .glb, or a model file.
    a: PathBuf,
    /// The second body, likewise.
    b: PathBuf,
    /// World poses of A and B: six lines of four numbers, R | t (m).
    #[arg(long)]
    poses: PathBuf,
    /// What to find.
    #[arg(long, default_value = "pairs")]
    question: QuestionName,
    /// How trees are built [default: as in the first model file, else sah].
    #[arg(long)]
    build: Option<BuildName>,
    /// Maximum number of triangles in a leaf [default: as in the first model file, else 4].
    #[arg(long, value_name = "N",
          value_parser = clap::value_parser!(u32).range(1..=i64::from(LEAF_SIZE_MAX)))]
    leaf_size: Option<u32>,
    /// Number of timed queries.
    #[arg(long, value_name = "N", default_value_t = 1,
          value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    repeat: u32,
    /// Empty the caches before each timed query, as before a first request.
    #[arg(long)]
    cold: bool,
    /// Shift B by a few millimetres for each timed query, like a moving body.
    #[arg(long)]
    moving: bool,
    /// Number of threads that build and query.
    #[arg(long, value_name = "N", default_value_t = 1,
          value_parser = clap::value_parser!(u16).range(1..=256))]
    threads: u16,
    /// Vector instructions of the kernel: auto, avx512, avx2, sse4, sse2 or neon.
    #[arg(long, default_value_t)]
    simd: Simd,
    /// How the trees are traversed.
    #[arg(long, default_value = "wide")]
    walk: WalkName,
    #[command(flatten)]
    limits: LimitArgs,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum WalkName {
    /// Eight boxes against eight at a time.
    Wide,
    /// Two boxes at a time, without vectors: the reference.
    Plain,
}

impl From<WalkName> for Walk {
    fn from(name: WalkName) -> Self {
        match name {
            WalkName::Wide => Self::Wide,
            WalkName::Plain => Self::Plain,
        }
    }
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum QuestionName {
    /// All pairs of triangles that intersect: their number, and a hash.
    Pairs,
    /// All triangles that intersect any other.
    Sets,
    /// Whether any pair intersects.
    Touches,
}

impl From<QuestionName> for Question {
    fn from(name: QuestionName) -> Self {
        match name {
            QuestionName::Pairs => Self::Pairs,
            QuestionName::Sets => Self::Sets,
            QuestionName::Touches => Self::Touches,
        }
    }
}

pub(crate) fn run(args: &IntersectArgs, output: &Output) -> Result<ExitCode, Failure> {
    let intersect = Intersect {
        files: [args.a.clone(), args.b.clone()],
        poses: args.poses.clone(),
        question: args.question.into(),
        build: args.build.map(Into::into),
        leaf_size: args.leaf_size,
        repeat: args.repeat,
        cold: args.cold,
        moving: args.moving,
        threads: args.threads.into(),
        simd: args.simd,
        walk: args.walk.into(),
        limits: args.limits.into(),
    };
    let intersected = reading(output, |told| intersect.run(told))?;
    print::out(&if output.json { print::line(&intersected)? } else { text(&intersected) })
}

/// The result, and how it was computed.
fn text(of: &Intersected) -> String {
    let Found { pairs, hash, hits, hashes } = of.asked.found;
    let pairs = usize::try_from(pairs).unwrap_or(usize::MAX);
    let (verdict, hash) = match of.question {
        Question::Pairs if pairs == 1 => {
            ("One pair of triangles intersects.".to_owned(), hex(hash))
        }
        Question::Pairs => {
            (format!("{} pairs of triangles intersect.", thousands(pairs)), hex(hash))
        }
        Question::Sets => {
            let [a, b] = hits.map(thousands);
            let [hash_a, hash_b] = hashes.map(hex);
            (format!("{a} triangles of A and {b} of B are hit."), format!("{hash_a} {hash_b}"))
        }
        Question::Touches if pairs == 0 => ("They do not touch.".to_owned(), "–".to_owned()),
        Question::Touches => ("They touch.".to_owned(), "–".to_owned()),
    };
    let body = |i: usize| {
        let name = shown(&of.files[i].display().to_string());
        format!("{name}, {} triangles", thousands(of.triangles[i]))
    };
    let count = |tests: u64| thousands(usize::try_from(tests).unwrap_or(usize::MAX));
    let BuildOptions { build, leaf_size, threads } = of.tree;
    let QueryResult { counters, jobs, pose_ns, query_ns, .. } = of.asked;
    let query = format!(
        "{}, {}{}median of {}; a new pose {}",
        time(query_ns),
        if of.cold { "cold caches, " } else { "" },
        if of.moving { "B moving, " } else { "" },
        of.repeat,
        time(pose_ns)
    );
    let tests = format!("{} of boxes, {} of triangles", count(counters.nb), count(counters.np));
    let trees = format!(
        "{}, {leaf_size} triangles in a leaf at most, built in {}",
        build.name(),
        time(of.build_ns)
    );
    let vectors = match of.walk {
        Walk::Wide => of.simd.to_owned(),
        Walk::Plain => "none: the plain walk".to_owned(),
    };
    let rows = [
        ("A", body(0)),
        ("B", body(1)),
        ("query", query),
        ("tests", tests),
        ("trees", trees),
        ("threads", format!("{threads}, jobs {jobs}")),
        ("vectors", vectors),
        ("hash", hash),
    ];
    let rows = rows.map(|(name, value)| format!("  {name:<8}{value}\n"));
    format!("{verdict}\n\n{}", rows.concat())
}

/// A time with three digits and its unit.
fn time(ns: u64) -> String {
    let (value, unit) = match ns {
        0..1_000 => return format!("{ns} ns"),
        1_000..1_000_000 => (ns as f64 / 1e3, "µs"),
        1_000_000..1_000_000_000 => (ns as f64 / 1e6, "ms"),
        _ => (ns as f64 / 1e9, "s"),
    };
    let digits = if value < 10.0 { 2 } else { usize::from(value < 100.0) };
    format!("{value:.digits$} {unit}")
}
