//! `trolley intersect`: the exact kernel alone, on two bodies at one pose, with its times.
//!
//! ```text
//! mesh ──▶ reader::child ──▶ model file ──▶ view ─┐
//! model file ─────────────────────────────▶ view ─┴▶ bvh::together ──▶ Answer ──▶ text or JSON
//! poses ──▶ poses::parse ──▶ RelativePose ────────┘
//! ```
//!
//! No scenario, no workers, no harm. A mesh is taken as it stands: no unit, no axes, nothing
//! dropped or merged, and a triangle's id is its number in the file. So other programs can be
//! compared with this one, in what they find and in how long they take.

mod answer;
mod bodies;

use crate::model::{BuildName, LimitArgs, open};
use crate::output::Output;
use crate::print;
use answer::{Answer, Asked, Found};
use bodies::Body;
use body::BodyView;
use bvh::kernel::Walk;
use bvh::together::{self, Together};
use bvh::{Kernel, Outcome, Question, Side, Task};
use clap::{Args as ClapArgs, ValueEnum};
use geometry::hash::splitmix64;
use geometry::simd::{self, Level, Simd};
use geometry::{Pose, RelativePose};
use runtime::clock::now_ns;
use serde::Serialize;
use std::hint::black_box;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use trolley::Failure;

/// What is written to push everything else out of the caches: more than a last level holds.
const STREAMED_BYTES: usize = 64 << 20;

/// How long several threads warm up. One that has just been started may share the core of the one
/// that started it for some ticks of the scheduler, though another core is idle: without this,
/// nine queries of 0.3 ms on two threads took as long as on one in 13 runs of 30.
const WARM_UP_NS: u64 = 60_000_000;

pub(crate) const EXAMPLES: &str = "\
Examples:
  trolley intersect a.stl b.stl --poses pose.txt
  trolley intersect a.stl b.stl --poses pose.txt --question sets --threads 2 --repeat 9 --json

POSES holds the world poses of A and of B, each as three lines of four numbers, R | t in metres.
The long help (--help) says what the fields of --json mean.";

pub(crate) const HELP: &str = "\
Examples:
  trolley intersect a.stl b.stl --poses pose.txt
  trolley intersect a.stl b.stl --poses pose.txt --question sets --threads 2 --repeat 9 --json

POSES holds the world poses of A and of B, each as three lines of four numbers, R | t in metres; a #
begins a remark. All happens in A's frame: R = RaᵀRb and t = Raᵀ(tb − ta) in f64, sums left to
right, and a vertex of B is ((R₀x + R₁y) + R₂z) + t, never fused, never rounded again. On these
triangles the answer is exact: closed triangles, touching counts, a degenerate one is the segment
or point that it is.

A mesh (STL, OBJ, PLY, glTF, GLB) is taken as it stands: its coordinates are metres, nothing is
dropped or merged, and ids are numbers of triangles in file order, from 0. In a model file
(.trolley) ids are those of the mesh that it was imported from.

With --json, one line:
  peer, schema       \"trolley\", 1
  case               name of the folder of A
  question, build, leaf_size, simd, walk, threads, cold, moving
                     as asked for, or what was chosen
  triangles_a, triangles_b
                     triangles of the bodies
  build_ms           time to build both trees; 0 where a model file has the tree already
  pose_ms            what a new pose costs before the query, median
  query_ms           median over the repeats, after one more that warms up; several threads are
                     warmed up for 60 ms, until each has a core of its own. With --moving B stands
                     up to 4 mm before or behind its pose along x each time: a processor learns the
                     branches of a query that is only repeated. What is found is of its pose
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
    /// What is asked for.
    #[arg(long, default_value = "pairs")]
    question: QuestionName,
    /// How the trees are built [default: as in the first model file named, else sah].
    #[arg(long)]
    build: Option<BuildName>,
    /// Triangles in a leaf at most [default: as in the first model file named, else 4].
    #[arg(long, value_name = "N",
          value_parser = clap::value_parser!(u32).range(1..=i64::from(bvh::build::LEAF_SIZE_MAX)))]
    leaf_size: Option<u32>,
    /// How often the query is timed.
    #[arg(long, value_name = "N", default_value_t = 1,
          value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    repeat: u32,
    /// Empty the caches before each timed query: the first crash of the day meets them so.
    #[arg(long)]
    cold: bool,
    /// Put B some millimetres elsewhere for each timed query, as a moving body is.
    #[arg(long)]
    moving: bool,
    /// Threads that build and query.
    #[arg(long, value_name = "N", default_value_t = 1,
          value_parser = clap::value_parser!(u16).range(1..=256))]
    threads: u16,
    /// Vector instructions of the kernel: auto, avx512, avx2, sse4, sse2 or neon.
    #[arg(long, default_value_t)]
    simd: Simd,
    /// How the trees are walked.
    #[arg(long, default_value = "wide")]
    walk: WalkName,
    #[command(flatten)]
    limits: LimitArgs,
}

#[derive(Clone, Copy, Debug, Serialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
enum WalkName {
    /// Eight boxes against eight at once.
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

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
enum QuestionName {
    /// All pairs of triangles that intersect: how many, and a hash of which.
    Pairs,
    /// All triangles that are hit.
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
    // What is quick to refuse comes first.
    let level = args.simd.level()?;
    let poses = read_poses(&args.poses)?;
    let files = [args.a.as_path(), args.b.as_path()];
    for file in files {
        let _there = open::bytes(file)?;
    }
    let tree = bodies::options(args)?;
    let a = Body::load(files[0], &tree, args.limits, output)?;
    let b = Body::load(files[1], &tree, args.limits, output)?;
    let answer = Answer {
        files,
        triangles: [a.view()?.corners.len(), b.view()?.corners.len()],
        question: args.question,
        tree,
        simd: simd::name(level),
        walk: args.walk,
        cold: args.cold,
        moving: args.moving,
        build_ns: a.build_ns + b.build_ns,
        repeat: args.repeat,
        asked: ask(args, level, [&a, &b], &poses)?,
    };
    let text = if output.json { answer.json()? } else { answer.text() };
    print::out(&text)
}

fn read_poses(path: &Path) -> Result<[Pose; 2], Failure> {
    let file = open::bytes(path)?;
    let name = path.display().to_string();
    if file.bytes().len() > poses::BYTES_MAX {
        let fault = format!("{name}: {} bytes are too many for two poses", file.bytes().len());
        return Err(Failure::input(fault).with_remedy("is this the right file?"));
    }
    poses::parse(&name, file.bytes())
}

/// Asks to warm up, and then as often as is said, each time as if the poses were new.
fn ask(
    args: &IntersectArgs,
    level: Level,
    bodies: [&Body; 2],
    poses: &[Pose; 2],
) -> Result<Asked, Failure> {
    let views @ [a, b] = [bodies[0].view()?, bodies[1].view()?];
    let [depth_a, depth_b] = bodies.map(|body| body.meta.depth);
    let kernel = || {
        let mut kernel = Kernel::with_room(depth_a, depth_b, a.corners.len(), b.corners.len());
        kernel.set_level(level);
        kernel.set_walk(args.walk.into());
        kernel
    };
    let question = args.question.into();
    together::with(args.threads.into(), kernel, |together| {
        let begun_ns = now_ns();
        let first = query(together, views, poses, question);
        while args.threads > 1 && now_ns() - begun_ns < WARM_UP_NS {
            query(together, views, poses, question);
        }
        let mut streamed = vec![0_u64; if args.cold { STREAMED_BYTES / 8 } else { 0 }];
        let mut timed = Vec::new();
        for turn in (0..args.repeat).rev() {
            let place = if args.moving { place_m(turn) } else { 0.0 };
            // One word per cache line.
            streamed.iter_mut().step_by(8).for_each(|word| *word += 1);
            black_box(&mut streamed);
            timed.push((place, query(together, views, &moved(*poses, place), question)));
        }
        let mut at_its_pose = timed.iter().filter(|(place, _)| *place == 0.0);
        let (Some((_, last)), true) =
            (timed.last(), at_its_pose.all(|(_, asked)| asked.found == first.found))
        else {
            let fault = "the same query found different things: this is a mistake of ours";
            return Err(Failure::internal(fault));
        };
        let median = |time: fn(&Asked) -> u64| {
            let mut times: Vec<u64> = timed.iter().map(|(_, asked)| time(asked)).collect();
            times.sort_unstable();
            times[times.len() / 2].midpoint(times[(times.len() - 1) / 2])
        };
        Ok(Asked { pose_ns: median(|it| it.pose_ns), query_ns: median(|it| it.query_ns), ..*last })
    })
}

/// With `--moving`, where B stands for the last query (turn 0), the last but one, ...: so far along
/// the world's x from its pose (m), which is where it stands at last. Elsewhere each time, far
/// enough for other branches to be taken, near enough for as much work.
fn place_m(turn: u32) -> f64 {
    0.001 * (f64::from((turn + 4) % 9) - 4.0)
}

/// The poses, with B so far along the world's x (m).
fn moved([a, mut b]: [Pose; 2], metres: f64) -> [Pose; 2] {
    b.translation[0] += metres;
    [a, b]
}

fn query<'t>(
    together: &mut Together<'_, 't>,
    [a, b]: [BodyView<'t>; 2],
    poses: &[Pose; 2],
    question: Question,
) -> Asked {
    let begun_ns = now_ns();
    let [of_a, of_b] = black_box(poses);
    let pose = RelativePose::between(of_a, of_b);
    let posed_ns = now_ns();
    let outcome = together.run(&Task { a, b, pose, question, directions: None });
    let query_ns = now_ns() - posed_ns;
    Asked {
        found: found(&outcome, together, [&a, &b]),
        counters: outcome.counters,
        jobs: together.jobs(),
        pose_ns: posed_ns - begun_ns,
        query_ns,
    }
}

/// What a query found, in terms of the ids that others know.
fn found(outcome: &Outcome, together: &Together<'_, '_>, bodies: [&BodyView<'_>; 2]) -> Found {
    let hits = [Side::A, Side::B].map(|side| together.hits(side));
    let hash = |hits: &[u32], body: &BodyView<'_>| {
        let ids = hits.iter().map(|triangle| body.source_ids[*triangle as usize]);
        ids.fold(0_u64, |sum, id| sum.wrapping_add(splitmix64(id.into())))
    };
    Found {
        pairs: outcome.pairs,
        hash: outcome.hash,
        hits: hits.map(<[u32]>::len),
        hashes: [hash(hits[0], bodies[0]), hash(hits[1], bodies[1])],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_moving_body_never_stays_and_ends_at_its_pose() {
        let places: Vec<f64> = (0..20).rev().map(place_m).collect();
        assert!(places.windows(2).all(|two| two[0] != two[1]), "{places:?}");
        assert!(places.iter().all(|place| place.abs() <= 0.004), "{places:?}");
        assert_eq!(places.last(), Some(&0.0));
        let poses = moved([Pose::IDENTITY; 2], -0.004);
        assert_eq!(poses.map(|pose| pose.translation[0]), [0.0, -0.004]);
    }
}
