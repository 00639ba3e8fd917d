//! The exact kernel alone: which triangles of two files intersect at one pose, with times.
//!
//! ```text
//! mesh --> mesh::reader --> model file --> view -.
//! model file -------------------------> view -+--> bvh::parallel --> Intersected
//! poses --> poses::read --> RelativePose ------'
//! ```
//!
//! With a [`Cast`], B moves along a straight line, and the query is when they first touch.
//!
//! There is no scenario, no worker and no harm. A mesh is taken as it is: no unit, no axes, nothing
//! dropped or merged, and a triangle's id is its number in the file. So the results and times of
//! other programs can be compared.
//!
//! ```
//! # use trolley::bodies::{ModelFile, SILENT};
//! # use trolley::intersect::Intersect;
//! # use trolley::model::{BuildOptions, Shape};
//! # let folder = std::env::temp_dir().join(format!("trolley-intersect-{}", std::process::id()));
//! # std::fs::create_dir_all(&folder).ok();
//! # let [a, b, poses] = ["a.trolley", "b.trolley", "poses.txt"].map(|name| folder.join(name));
//! # let pole = ModelFile::generate(Shape::Pole, 600, 0, &BuildOptions::default())?;
//! # trolley::files::replace(&a, pole.bytes())?;
//! # trolley::files::replace(&b, pole.bytes())?;
//! # let text = "1 0 0 0\n0 1 0 0\n0 0 1 0\n1 0 0 0.1\n0 1 0 0\n0 0 1 0\n";
//! # trolley::files::replace(&poses, text.as_bytes())?;
//! let query = Intersect { repeat: 3, ..Intersect::new(&a, &b, &poses) };
//! let result = query.run(SILENT)?;
//! println!("{} pairs in {} ns", result.asked.found.pairs, result.asked.query_ns);
//! # assert!(result.asked.found.pairs > 0);
//! # std::fs::remove_dir_all(&folder).ok();
//! # Ok::<(), trolley::Failure>(())
//! ```

mod answer;
mod bodies;
mod cast;

pub use answer::{Found, Intersected, QueryResult, hex};
pub use cast::{Cast, FirstContact, NEAREST_MAX};

/// The counts of a [`QueryResult`].
///
/// ```
/// # use trolley::bodies::{ModelFile, SILENT};
/// # use trolley::intersect::Intersect;
/// # use trolley::model::{BuildOptions, Shape};
/// # let folder = std::env::temp_dir().join(format!("trolley-counters-{}", std::process::id()));
/// # std::fs::create_dir_all(&folder).ok();
/// # let [a, b, poses] = ["a.trolley", "b.trolley", "poses.txt"].map(|name| folder.join(name));
/// # let pole = ModelFile::generate(Shape::Pole, 600, 0, &BuildOptions::default())?;
/// # trolley::files::replace(&a, pole.bytes())?;
/// # trolley::files::replace(&b, pole.bytes())?;
/// # let text = "1 0 0 0\n0 1 0 0\n0 0 1 0\n1 0 0 0.1\n0 1 0 0\n0 0 1 0\n";
/// # trolley::files::replace(&poses, text.as_bytes())?;
/// let asked = Intersect::new(&a, &b, &poses).run(SILENT)?.asked;
/// println!("{} box tests, {} triangle tests", asked.counters.nb, asked.counters.np);
/// assert_eq!(asked.counters.tests(), asked.counters.nb + asked.counters.np);
/// # std::fs::remove_dir_all(&folder).ok();
/// # Ok::<(), trolley::Failure>(())
/// ```
pub use bvh::Counters;

/// What an [`Intersect`] finds.
///
/// ```
/// # use trolley::bodies::{ModelFile, SILENT};
/// # use trolley::intersect::Intersect;
/// # use trolley::model::{BuildOptions, Shape};
/// # let folder = std::env::temp_dir().join(format!("trolley-question-{}", std::process::id()));
/// # std::fs::create_dir_all(&folder).ok();
/// # let [a, b, poses] = ["a.trolley", "b.trolley", "poses.txt"].map(|name| folder.join(name));
/// # let pole = ModelFile::generate(Shape::Pole, 600, 0, &BuildOptions::default())?;
/// # trolley::files::replace(&a, pole.bytes())?;
/// # trolley::files::replace(&b, pole.bytes())?;
/// # let text = "1 0 0 0\n0 1 0 0\n0 0 1 0\n1 0 0 0.1\n0 1 0 0\n0 0 1 0\n";
/// # trolley::files::replace(&poses, text.as_bytes())?;
/// use trolley::intersect::Question;
///
/// let query = Intersect { question: Question::Touches, ..Intersect::new(&a, &b, &poses) };
/// assert_eq!(query.run(SILENT)?.asked.found.pairs, 1, "they touch");
/// # std::fs::remove_dir_all(&folder).ok();
/// # Ok::<(), trolley::Failure>(())
/// ```
pub use bvh::Question;

/// How an [`Intersect`] walks trees.
///
/// ```
/// # use trolley::bodies::{ModelFile, SILENT};
/// # use trolley::intersect::Intersect;
/// # use trolley::model::{BuildOptions, Shape};
/// # let folder = std::env::temp_dir().join(format!("trolley-walk-{}", std::process::id()));
/// # std::fs::create_dir_all(&folder).ok();
/// # let [a, b, poses] = ["a.trolley", "b.trolley", "poses.txt"].map(|name| folder.join(name));
/// # let pole = ModelFile::generate(Shape::Pole, 600, 0, &BuildOptions::default())?;
/// # trolley::files::replace(&a, pole.bytes())?;
/// # trolley::files::replace(&b, pole.bytes())?;
/// # let text = "1 0 0 0\n0 1 0 0\n0 0 1 0\n1 0 0 0.1\n0 1 0 0\n0 0 1 0\n";
/// # trolley::files::replace(&poses, text.as_bytes())?;
/// use trolley::intersect::Walk;
///
/// let wide = Intersect::new(&a, &b, &poses);
/// let plain = Intersect { walk: Walk::Plain, ..wide.clone() };
/// assert_eq!(wide.run(SILENT)?.asked.found, plain.run(SILENT)?.asked.found);
/// # std::fs::remove_dir_all(&folder).ok();
/// # Ok::<(), trolley::Failure>(())
/// ```
pub use bvh::kernel::Walk;

/// The vector instructions of an [`Intersect`].
///
/// ```
/// # use trolley::bodies::{ModelFile, SILENT};
/// # use trolley::intersect::Intersect;
/// # use trolley::model::{BuildOptions, Shape};
/// # let folder = std::env::temp_dir().join(format!("trolley-simd-{}", std::process::id()));
/// # std::fs::create_dir_all(&folder).ok();
/// # let [a, b, poses] = ["a.trolley", "b.trolley", "poses.txt"].map(|name| folder.join(name));
/// # let pole = ModelFile::generate(Shape::Pole, 600, 0, &BuildOptions::default())?;
/// # trolley::files::replace(&a, pole.bytes())?;
/// # trolley::files::replace(&b, pole.bytes())?;
/// # let text = "1 0 0 0\n0 1 0 0\n0 0 1 0\n1 0 0 0.1\n0 1 0 0\n0 0 1 0\n";
/// # trolley::files::replace(&poses, text.as_bytes())?;
/// use trolley::intersect::Simd;
///
/// let query = Intersect { simd: Simd::Auto, ..Intersect::new(&a, &b, &poses) };
/// println!("with {}", query.run(SILENT)?.simd);
/// # std::fs::remove_dir_all(&folder).ok();
/// # Ok::<(), trolley::Failure>(())
/// ```
pub use geometry::simd::Simd;

/// The greatest travel of a [`Cast`], in either sense (m).
///
/// ```
/// use trolley::intersect::{Cast, TRAVEL_MAX};
///
/// let far = Cast::new([-1.0, 0.0, 0.0], TRAVEL_MAX);
/// ```
pub use geometry::sweep::TRAVEL_MAX;

use crate::files::InputKind;
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

/// Bytes written to empty the caches: more than a last level holds.
const STREAMED_BYTES: usize = 64 << 20;

/// How long several threads warm up. A new thread may share the core of its parent for some ticks
/// of the scheduler, though another core is idle: without this, nine queries of 0.3 ms on two
/// threads took as long as on one in 13 runs of 30.
const WARM_UP_NS: u64 = 60_000_000;

/// A query: which triangles of two files intersect.
///
/// ```
/// # use trolley::bodies::{ModelFile, SILENT};
/// # use trolley::intersect::Intersect;
/// # use trolley::model::{BuildOptions, Shape};
/// # let folder = std::env::temp_dir().join(format!("trolley-struct-{}", std::process::id()));
/// # std::fs::create_dir_all(&folder).ok();
/// # let [a, b, poses] = ["a.trolley", "b.trolley", "poses.txt"].map(|name| folder.join(name));
/// # let pole = ModelFile::generate(Shape::Pole, 600, 0, &BuildOptions::default())?;
/// # trolley::files::replace(&a, pole.bytes())?;
/// # trolley::files::replace(&b, pole.bytes())?;
/// # let text = "1 0 0 0\n0 1 0 0\n0 0 1 0\n1 0 0 0.1\n0 1 0 0\n0 0 1 0\n";
/// # trolley::files::replace(&poses, text.as_bytes())?;
/// let query = Intersect { threads: 2, repeat: 9, ..Intersect::new(&a, &b, &poses) };
/// assert!(query.run(SILENT)?.asked.found.pairs > 0);
/// # std::fs::remove_dir_all(&folder).ok();
/// # Ok::<(), trolley::Failure>(())
/// ```
#[derive(Clone, Debug)]
pub struct Intersect {
    /// A and B: meshes with coordinates in metres, or model files.
    pub files: [PathBuf; 2],
    /// A file with their [poses].
    pub poses: PathBuf,
    /// What to find, unless there is a cast.
    pub question: Question,
    /// How B moves, to find when it first touches A; `None`: not at all.
    pub cast: Option<Cast>,
    /// How trees are built; `None`: as in the first model file, else by surface area.
    pub build: Option<Build>,
    /// Most triangles in a leaf; `None`: as in the first model file, else the default.
    pub leaf_size: Option<u32>,
    /// How often to time the query, at least once.
    pub repeat: u32,
    /// Whether to empty the caches before each timed query.
    pub cold: bool,
    /// Whether to move B by some millimetres for each timed query.
    pub moving: bool,
    /// Threads that build and query; the query of a cast takes one.
    pub threads: usize,
    /// Vector instructions of the kernel.
    pub simd: Simd,
    /// How the trees are walked.
    pub walk: Walk,
    /// Limits for reading a mesh.
    pub limits: ReadLimits,
}

impl Intersect {
    /// Makes a query for all pairs of intersecting triangles, timed once, on one thread.
    ///
    /// ```
    /// use trolley::intersect::{Intersect, Question};
    ///
    /// let query = Intersect::new("a.stl", "b.stl", "poses.txt");
    /// assert_eq!((query.question, query.repeat, query.threads), (Question::Pairs, 1, 1));
    /// ```
    #[must_use]
    pub fn new(a: impl Into<PathBuf>, b: impl Into<PathBuf>, poses: impl Into<PathBuf>) -> Self {
        Self {
            files: [a.into(), b.into()],
            poses: poses.into(),
            question: Question::Pairs,
            cast: None,
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

    /// Reads the poses and the bodies, and runs the query.
    ///
    /// ```
    /// # use trolley::bodies::{ModelFile, SILENT};
    /// # use trolley::intersect::Intersect;
    /// # use trolley::model::{BuildOptions, Shape};
    /// # let folder = std::env::temp_dir().join(format!("trolley-run-{}", std::process::id()));
    /// # std::fs::create_dir_all(&folder).ok();
    /// # let [a, b, poses] = ["a.trolley", "b.trolley", "poses.txt"].map(|name| folder.join(name));
    /// # let pole = ModelFile::generate(Shape::Pole, 600, 0, &BuildOptions::default())?;
    /// # trolley::files::replace(&a, pole.bytes())?;
    /// # trolley::files::replace(&b, pole.bytes())?;
    /// # let text = "1 0 0 0\n0 1 0 0\n0 0 1 0\n1 0 0 0.1\n0 1 0 0\n0 0 1 0\n";
    /// # trolley::files::replace(&poses, text.as_bytes())?;
    /// let result = Intersect::new(&a, &b, &poses).run(SILENT)?;
    /// assert_eq!(result.triangles, [600, 600]);
    /// # std::fs::remove_dir_all(&folder).ok();
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    ///
    /// # Errors
    ///
    /// If this machine lacks the vector instructions, the cast is no motion, a file is not valid,
    /// or reading a mesh exceeds its limits.
    pub fn run(&self, progress: OnProgress<'_>) -> Result<Intersected, Failure> {
        // Cheap checks come first.
        let level = self.simd.level()?;
        let poses = poses::read(&self.poses)?;
        self.cast.as_ref().map(|cast| cast.sweep(&poses[0])).transpose()?;
        let files = [self.files[0].as_path(), self.files[1].as_path()];
        for file in files {
            let _there = runtime::input::open(file, InputKind::Mesh)?;
        }
        let tree = bodies::options(files, self.build, self.leaf_size, self.threads)?;
        let a = Body::load(files[0], &tree, self.limits, progress)?;
        let b = Body::load(files[1], &tree, self.limits, progress)?;
        let (asked, first) = match &self.cast {
            Some(cast) => cast::ask(self, cast, level, [&a, &b], &poses)?,
            None => (ask(self, level, [&a, &b], &poses)?, None),
        };
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
            asked,
            first,
        })
    }
}

/// Runs the query to warm up, and then as often as it is timed, each time as if the poses were new.
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
        let query = |poses: &[Pose; 2]| {
            let asked = query(parallel, views, poses, question);
            Ok((asked, asked.found))
        };
        Ok(repeated(it, poses, &first.found, query)?.0)
    })
}

/// Runs a query as often as it is timed; the result of the last, with the medians of the times.
fn repeated<T: PartialEq>(
    it: &Intersect,
    poses: &[Pose; 2],
    first: &T,
    mut query: impl FnMut(&[Pose; 2]) -> Result<(QueryResult, T), Failure>,
) -> Result<(QueryResult, T), Failure> {
    let mut streamed = vec![0_u64; if it.cold { STREAMED_BYTES / 8 } else { 0 }];
    let (mut pose_ns, mut query_ns) = (Vec::new(), Vec::new());
    let mut last = None;
    for turn in (0..it.repeat.max(1)).rev() {
        let place = if it.moving { place_m(turn) } else { 0.0 };
        // One word per cache line.
        streamed.iter_mut().step_by(8).for_each(|word| *word += 1);
        black_box(&mut streamed);
        let (asked, found) = query(&moved(*poses, place))?;
        pose_ns.push(asked.pose_ns);
        query_ns.push(asked.query_ns);
        if place == 0.0 && found != *first {
            break;
        }
        last = (turn == 0).then_some((asked, found));
    }
    let Some((asked, found)) = last else {
        return Err(Failure::internal("internal error: the same query gave different results"));
    };
    let median = |mut times: Vec<u64>| {
        times.sort_unstable();
        times[times.len() / 2].midpoint(times[(times.len() - 1) / 2])
    };
    let (pose_ns, query_ns) = (median(pose_ns), median(query_ns));
    Ok((QueryResult { pose_ns, query_ns, ..asked }, found))
}

/// With `--moving`, how far B is moved along the world's x (m) for the last query (turn 0), the
/// last but one, ...: 0 for the last, and different each time. Far enough for other branches to be
/// taken, near enough for as much work.
fn place_m(turn: u32) -> f64 {
    0.001 * (f64::from((turn + 4) % 9) - 4.0)
}

/// The poses, with B moved along the world's x (m).
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

/// What a query found, by source ids.
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
