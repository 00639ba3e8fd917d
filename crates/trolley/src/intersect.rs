//! The exact kernel alone, on two bodies at one pose, with its times.
//!
//! ```text
//! mesh --> mesh::reader --> model file --> view -.
//! model file -------------------------> view -+--> bvh::parallel --> Intersected
//! poses --> poses::read --> RelativePose ------'
//! ```
//!
//! No scenario, no workers, no harm. A mesh is taken as it stands: no unit, no axes, nothing
//! dropped or merged, and a triangle's id is its number in the file. So other programs can be
//! compared with this one, in what they find and in how long they take.

mod answer;
mod bodies;

pub use answer::{Found, Intersected, QueryResult, hex};
pub use bvh::kernel::Walk;
pub use bvh::{Counters, Question};
pub use geometry::simd::Simd;

use crate::model::open;
use crate::{Failure, poses};
use bodies::Body;
use body::{BodyView, Build};
use bvh::parallel::{self, Parallel};
use bvh::{Kernel, Outcome, Side, Task};
use geometry::hash::splitmix64;
use geometry::simd::{self, Level};
use geometry::{Pose, RelativePose};
use mesh::reader::{OnProgress, ReadLimits};
use runtime::clock::now_ns;
use std::hint::black_box;
use std::path::PathBuf;

/// What is written to push everything else out of the caches: more than a last level holds.
const STREAMED_BYTES: usize = 64 << 20;

/// How long several threads warm up. One that has just been started may share the core of the one
/// that started it for some ticks of the scheduler, though another core is idle: without this,
/// nine queries of 0.3 ms on two threads took as long as on one in 13 runs of 30.
const WARM_UP_NS: u64 = 60_000_000;

/// Asks which triangles of two bodies intersect.
#[derive(Clone, Debug)]
pub struct Intersect {
    /// A and B: meshes, whose coordinates are metres, or model files.
    pub files: [PathBuf; 2],
    /// A file with their [poses].
    pub poses: PathBuf,
    /// What is asked for.
    pub question: Question,
    /// How the trees are built; none: as in the first model file named, else by surface area.
    pub build: Option<Build>,
    /// Triangles in a leaf at most; none: as in the first model file named, else the usual number.
    pub leaf_size: Option<u32>,
    /// How often the query is timed, at least once.
    pub repeat: u32,
    /// Whether the caches are emptied before each timed query.
    pub cold: bool,
    /// Whether B stands some millimetres elsewhere for each timed query, as a moving body does.
    pub moving: bool,
    /// Threads that build and query.
    pub threads: usize,
    /// Vector instructions of the kernel.
    pub simd: Simd,
    /// How the trees are walked.
    pub walk: Walk,
    /// What reading a mesh may take.
    pub limits: ReadLimits,
}

impl Intersect {
    /// All pairs of triangles of A and B that intersect, asked once, by this thread alone.
    #[must_use]
    pub fn new(a: impl Into<PathBuf>, b: impl Into<PathBuf>, poses: impl Into<PathBuf>) -> Self {
        Self {
            files: [a.into(), b.into()],
            poses: poses.into(),
            question: Question::Pairs,
            build: None,
            leaf_size: None,
            repeat: 1,
            cold: false,
            moving: false,
            threads: 1,
            simd: Simd::default(),
            walk: Walk::default(),
            limits: ReadLimits::default(),
        }
    }

    /// Reads poses and bodies, and asks.
    ///
    /// # Errors
    ///
    /// If this machine has no such instructions, a file is at fault, or reading a mesh took more
    /// than it was allowed.
    pub fn run(&self, progress: OnProgress<'_>) -> Result<Intersected, Failure> {
        // What is quick to refuse comes first.
        let level = self.simd.level()?;
        let poses = poses::read(&self.poses)?;
        let files = [self.files[0].as_path(), self.files[1].as_path()];
        for file in files {
            let _there = open::bytes(file)?;
        }
        let tree = bodies::options(files, self.build, self.leaf_size, self.threads)?;
        let a = Body::load(files[0], &tree, self.limits, progress)?;
        let b = Body::load(files[1], &tree, self.limits, progress)?;
        Ok(Intersected {
            files: self.files.clone(),
            triangles: [a.view()?.corners.len(), b.view()?.corners.len()],
            question: self.question,
            tree,
            simd: simd::name(level),
            walk: self.walk,
            cold: self.cold,
            moving: self.moving,
            build_ns: a.build_ns + b.build_ns,
            repeat: self.repeat,
            asked: ask(self, level, [&a, &b], &poses)?,
        })
    }
}

/// Asks to warm up, and then as often as is said, each time as if the poses were new.
fn ask(
    it: &Intersect,
    level: Level,
    bodies: [&Body; 2],
    poses: &[Pose; 2],
) -> Result<QueryResult, Failure> {
    let views @ [a, b] = [bodies[0].view()?, bodies[1].view()?];
    let [depth_a, depth_b] = bodies.map(|body| body.meta.depth);
    let kernel = || {
        let mut kernel = Kernel::with_room(depth_a, depth_b, a.corners.len(), b.corners.len());
        kernel.set_level(level);
        kernel.set_walk(it.walk);
        kernel
    };
    let question = it.question;
    parallel::with(it.threads, kernel, |parallel| {
        let begun_ns = now_ns();
        let first = query(parallel, views, poses, question);
        while it.threads > 1 && now_ns() - begun_ns < WARM_UP_NS {
            query(parallel, views, poses, question);
        }
        let mut streamed = vec![0_u64; if it.cold { STREAMED_BYTES / 8 } else { 0 }];
        let mut timed = Vec::new();
        for turn in (0..it.repeat.max(1)).rev() {
            let place = if it.moving { place_m(turn) } else { 0.0 };
            // One word per cache line.
            streamed.iter_mut().step_by(8).for_each(|word| *word += 1);
            black_box(&mut streamed);
            timed.push((place, query(parallel, views, &moved(*poses, place), question)));
        }
        let mut at_its_pose = timed.iter().filter(|(place, _)| *place == 0.0);
        let (Some((_, last)), true) =
            (timed.last(), at_its_pose.all(|(_, asked)| asked.found == first.found))
        else {
            let fault = "the same query found different things: this is a mistake of ours";
            return Err(Failure::internal(fault));
        };
        let median = |time: fn(&QueryResult) -> u64| {
            let mut times: Vec<u64> = timed.iter().map(|(_, asked)| time(asked)).collect();
            times.sort_unstable();
            times[times.len() / 2].midpoint(times[(times.len() - 1) / 2])
        };
        Ok(QueryResult {
            pose_ns: median(|asked| asked.pose_ns),
            query_ns: median(|asked| asked.query_ns),
            ..*last
        })
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
    parallel: &mut Parallel<'_, 't>,
    [a, b]: [BodyView<'t>; 2],
    poses: &[Pose; 2],
    question: Question,
) -> QueryResult {
    let begun_ns = now_ns();
    let [of_a, of_b] = black_box(poses);
    let pose = RelativePose::between(of_a, of_b);
    let posed_ns = now_ns();
    let outcome = parallel.run(&Task { a, b, pose, question, directions: None });
    let query_ns = now_ns() - posed_ns;
    QueryResult {
        found: found(&outcome, parallel, [&a, &b]),
        counters: outcome.counters,
        jobs: parallel.jobs(),
        pose_ns: posed_ns - begun_ns,
        query_ns,
    }
}

/// What a query found, in limits of the ids that others know.
fn found(outcome: &Outcome, parallel: &Parallel<'_, '_>, bodies: [&BodyView<'_>; 2]) -> Found {
    let hits = [Side::A, Side::B].map(|side| parallel.hits(side));
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
