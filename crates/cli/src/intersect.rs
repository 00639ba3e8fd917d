//! `trolley intersect`: the exact kernel alone, on two bodies at one pose or in motion, timed.
//! [`trolley::intersect`] does the work.

use crate::model::{BuildName, LimitArgs, reading};
use crate::output::Output;
use crate::print;
use clap::{Args as ClapArgs, ValueEnum};
use report::body_text::{shown, thousands};
use std::path::PathBuf;
use std::process::ExitCode;
use trolley::Failure;
use trolley::intersect::{Cast, FirstContact, Found, Intersect, Intersected, NEAREST_MAX};
use trolley::intersect::{QueryResult, Question, Simd, TRAVEL_MAX, Walk, hex};
use trolley::model::{BuildOptions, LEAF_SIZE_MAX};

pub(crate) const EXAMPLES: &str = "\
Examples:
  D=crates/trolley/examples/data P=config/examples/poses.txt
  trolley intersect $D/step.stl $D/pole.stl --poses $P
  trolley intersect $D/step.stl $D/pole.stl --poses $P --question sets --threads 2 --json
  trolley intersect $D/step.stl $D/pole.stl --poses $P --cast -1,0,0 --reach 10 --nearest 3

POSES holds the world poses of A and of B, each as three lines of four numbers, R | t in metres.
The long help (--help) explains the fields of --json.";

pub(crate) const HELP: &str = "\
Examples:
  D=crates/trolley/examples/data P=config/examples/poses.txt
  trolley intersect $D/step.stl $D/pole.stl --poses $P
  trolley intersect $D/step.stl $D/pole.stl --poses $P --question sets --threads 2 --json
  trolley intersect $D/step.stl $D/pole.stl --poses $P --cast -1,0,0 --reach 10 --nearest 3

POSES holds the world poses of A and of B, each as three lines of four numbers, R | t in metres; a #
begins a comment. Everything is computed in A's frame: R = RaᵀRb and t = Raᵀ(tb − ta) in f64, sums
left to right, and a vertex of B is ((R₀x + R₁y) + R₂z) + t, never fused, never rounded again. On
these triangles the answer is exact: triangles are closed, touching counts, and a degenerate
triangle is the segment or point that it is.

A mesh (STL, OBJ, PLY, glTF, GLB) is used as it is: its coordinates are metres, nothing is dropped
or merged, and ids number the triangles in file order, from 0. In a model file (.trolley) ids are
those of the mesh that it was imported from.

With --cast, B moves along a straight line without turning, and the query is when it first touches
A: continuously, so that nothing slips between two poses. Travel is in metres along X,Y,Z, a
direction in the world of any length but 0; 0 is the pose given, and the motion goes from -back to
reach. The travel is within 1 nm of the true one. Contact that begins within 1 nm of the end of the
motion, or ends within 1 nm of its begin, may be missed or counted. Of pairs that touch at the same
travel, that with the least ids is the witness. Trees are built on --threads; the query takes one.

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
  hash_a, hash_b     sets: sums modulo 2^64 of splitmix64(id)
or with --cast, where question is \"first-contact\":
  first_contact_m    travel of B at first contact (m), or null: never
  witness            [id of A, id of B]: the triangles that touch then, or null
  bracket            [least, greatest] travel at which first contact may be (m), or null
  exact_tests        pairs of triangles that were decided one by one
  nearest            with --nearest K: up to K earliest pairs, {travel_m, ids}, in their order

Exit codes: 2 for a bad flag, 65 for a file that is not valid, 78 for missing vector instructions.";

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
    /// Move B along this direction in the world, and find when it first touches A.
    #[arg(long, value_name = "X,Y,Z", value_parser = direction, allow_hyphen_values = true,
          requires = "reach", conflicts_with = "question")]
    cast: Option<Direction>,
    /// Where the motion ends: this far beyond the pose (m).
    #[arg(long, value_name = "M", value_parser = metres, requires = "cast",
          allow_negative_numbers = true)]
    reach: Option<f64>,
    /// Where the motion begins: this far before the pose (m).
    #[arg(long, value_name = "M", value_parser = metres, requires = "cast", default_value = "0",
          allow_negative_numbers = true)]
    back: f64,
    /// List up to K pairs that touch first.
    #[arg(long, value_name = "K", requires = "cast",
          value_parser = clap::value_parser!(u32).range(1..=i64::from(NEAREST_MAX)))]
    nearest: Option<u32>,
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
    /// Number of threads that build and query; the query of --cast takes one.
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

/// A direction of motion.
#[derive(Clone, Copy, Debug)]
struct Direction([f64; 3]);

fn direction(text: &str) -> Result<Direction, String> {
    let numbers: Result<Vec<f64>, _> = text.split(',').map(|word| word.trim().parse()).collect();
    match numbers.ok().and_then(|numbers| <[f64; 3]>::try_from(numbers).ok()) {
        Some(d) if d.iter().all(|x| x.is_finite()) && d.iter().any(|x| *x != 0.0) => {
            Ok(Direction(d))
        }
        _ => Err("write three finite numbers that are not all 0, such as -1,0,0.5".into()),
    }
}

/// A length of travel.
fn metres(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(metres) if (0.0..=TRAVEL_MAX).contains(&metres) => Ok(metres + 0.0),
        _ => Err(format!("write a number of metres, 0 to {TRAVEL_MAX}")),
    }
}

pub(crate) fn run(args: &IntersectArgs, output: &Output) -> Result<ExitCode, Failure> {
    let intersect = Intersect {
        files: [args.a.clone(), args.b.clone()],
        poses: args.poses.clone(),
        question: args.question.into(),
        cast: args.cast.zip(args.reach).map(|(Direction(direction), reach_m)| Cast {
            direction,
            back_m: args.back,
            reach_m,
            nearest: args.nearest,
        }),
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
    if output.json {
        return print::out(&print::line(&intersected)?);
    }
    print::lines(&text(&intersected))
}

/// The result, and how it was computed.
fn text(of: &Intersected) -> String {
    let mut rows = how(of);
    let verdict = match &of.first {
        Some(first) => {
            rows.insert(2, ("motion", motion(&first.cast)));
            contact(first)
        }
        None => {
            let (verdict, hash) = verdict(of);
            rows.push(("hash", hash));
            verdict
        }
    };
    let rows: Vec<String> =
        rows.iter().map(|(name, value)| format!("  {name:<8}{value}\n")).collect();
    format!("{verdict}\n\n{}", rows.concat())
}

/// First contact, and the earliest pairs if they were asked for.
fn contact(of: &FirstContact) -> String {
    let Some(first) = of.earliest.first() else {
        return "They never touch on that way.".to_owned();
    };
    let [a, b] = first.ids;
    let mut text = format!("First contact at {} m: triangle {a} of A, {b} of B.", first.travel_m);
    if of.cast.nearest.is_some() {
        text.push('\n');
        for pair in &of.earliest {
            let ([a, b], travel_m) = (pair.ids, pair.travel_m);
            text.push_str(&format!("\n  {travel_m:>12.9} m  {a} of A, {b} of B"));
        }
    }
    text
}

fn motion(of: &Cast) -> String {
    let [x, y, z] = of.direction;
    format!("along {x}, {y}, {z} from {} to {} m", 0.0 - of.back_m, of.reach_m)
}

/// What was found at one pose, and its hash.
fn verdict(of: &Intersected) -> (String, String) {
    let Found { pairs, hash, hits, hashes } = of.asked.found;
    let pairs = usize::try_from(pairs).unwrap_or(usize::MAX);
    match of.question {
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
    }
}

/// How a result was computed.
fn how(of: &Intersected) -> Vec<(&'static str, String)> {
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
    let mut tests = format!("{} of boxes, {} of triangles", count(counters.nb), count(counters.np));
    if let Some(first) = &of.first {
        tests.push_str(&format!(", {} of them one by one", count(first.exact_tests)));
    }
    let trees = format!(
        "{}, {leaf_size} triangles in a leaf at most, built in {}",
        build.name(),
        time(of.build_ns)
    );
    let vectors = match of.walk {
        Walk::Wide => of.simd.to_owned(),
        Walk::Plain => "none: the plain walk".to_owned(),
    };
    vec![
        ("A", body(0)),
        ("B", body(1)),
        ("query", query),
        ("tests", tests),
        ("trees", trees),
        ("threads", format!("{threads}, jobs {jobs}")),
        ("vectors", vectors),
    ]
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
