//! A cast: B moves along a straight line, and the query is when it first touches A.

use super::bodies::Body;
use super::{Found, Intersect, QueryResult, repeated};
use crate::Failure;
use bvh::query::{SweepWorkspace, Witness, earliest_pairs};
use geometry::simd::Level;
use geometry::sweep::TOLERANCE_M;
use geometry::{DVec3, Pose, RelativePose, Sweep};
use runtime::clock::now_ns;
use serde::{Serialize, Serializer};
use std::hint::black_box;

/// Greatest number of earliest pairs of a [`Cast`].
///
/// ```
/// use trolley::intersect::{Cast, NEAREST_MAX};
///
/// let cast = Cast { nearest: Some(NEAREST_MAX), ..Cast::new([-1.0, 0.0, 0.0], 10.0) };
/// ```
pub const NEAREST_MAX: u32 = 1024;

/// How B moves, for an [`Intersect`]: along a straight line, without turning.
///
/// ```
/// # use trolley::bodies::{ModelFile, SILENT};
/// # use trolley::intersect::Intersect;
/// # use trolley::model::{BuildOptions, Shape};
/// # let folder = std::env::temp_dir().join(format!("trolley-cast-{}", std::process::id()));
/// # std::fs::create_dir_all(&folder).ok();
/// # let [a, b, poses] = ["a.trolley", "b.trolley", "poses.txt"].map(|name| folder.join(name));
/// # let pole = ModelFile::generate(Shape::Pole, 600, 0, &BuildOptions::default())?;
/// # trolley::files::replace(&a, pole.bytes())?;
/// # trolley::files::replace(&b, pole.bytes())?;
/// # let text = "1 0 0 0\n0 1 0 0\n0 0 1 0\n1 0 0 4\n0 1 0 0\n0 0 1 0\n";
/// # trolley::files::replace(&poses, text.as_bytes())?;
/// use trolley::intersect::Cast;
///
/// // Two poles stand 4 m apart.
/// let cast = Cast::new([-1.0, 0.0, 0.0], 10.0);
/// let query = Intersect { cast: Some(cast), ..Intersect::new(&a, &b, &poses) };
/// let first = query.run(SILENT)?.first.and_then(|first| first.travel_m());
/// assert!(first.is_some_and(|travel_m| 3.0 < travel_m && travel_m < 4.0));
/// # std::fs::remove_dir_all(&folder).ok();
/// # Ok::<(), trolley::Failure>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cast {
    /// Where B moves, in the world; of any length but 0.
    pub direction: [f64; 3],
    /// How far before its pose the motion begins (m).
    pub back_m: f64,
    /// How far beyond its pose the motion ends (m).
    pub reach_m: f64,
    /// How many of the earliest pairs to list, at most [`NEAREST_MAX`]; `None`: only the first.
    pub nearest: Option<u32>,
}

impl Cast {
    /// A motion from the pose on.
    ///
    /// ```
    /// let cast = trolley::intersect::Cast::new([0.0, -2.0, 0.0], 10.0);
    /// assert_eq!((cast.back_m, cast.nearest), (0.0, None));
    /// ```
    #[must_use]
    pub fn new(direction: [f64; 3], reach_m: f64) -> Self {
        Self { direction, back_m: 0.0, reach_m, nearest: None }
    }

    /// The motion in the frame of A.
    pub(super) fn sweep(&self, a: &Pose) -> Result<Sweep, Failure> {
        // Scaled by a power of two where sums of products could over- or underflow.
        let largest = self.direction.iter().fold(0.0_f64, |largest, x| largest.max(x.abs()));
        let scale = match largest {
            ..1e-100 => f64::from_bits((1023 + 1000) << 52),
            ..1e100 => 1.0,
            _ => f64::from_bits((1023 - 600) << 52),
        };
        let [x, y, z] = self.direction.map(|x| x * scale);
        let r = &a.rotation;
        let along = |i: usize| (r[0][i] * x + r[1][i] * y) + r[2][i] * z;
        let direction = DVec3::new(along(0), along(1), along(2));
        Ok(Sweep::new(direction, 0.0 - self.back_m, self.reach_m)?)
    }
}

/// What a [`Cast`] finds. It depends on the triangles, the poses and the motion alone, but for the
/// number of tests.
///
/// As JSON it is one object; `trolley intersect --help` explains its keys.
///
/// ```
/// # use trolley::bodies::{ModelFile, SILENT};
/// # use trolley::intersect::Intersect;
/// # use trolley::model::{BuildOptions, Shape};
/// # let folder = std::env::temp_dir().join(format!("trolley-first-{}", std::process::id()));
/// # std::fs::create_dir_all(&folder).ok();
/// # let [a, b, poses] = ["a.trolley", "b.trolley", "poses.txt"].map(|name| folder.join(name));
/// # let pole = ModelFile::generate(Shape::Pole, 600, 0, &BuildOptions::default())?;
/// # trolley::files::replace(&a, pole.bytes())?;
/// # trolley::files::replace(&b, pole.bytes())?;
/// # let text = "1 0 0 0\n0 1 0 0\n0 0 1 0\n1 0 0 4\n0 1 0 0\n0 0 1 0\n";
/// # trolley::files::replace(&poses, text.as_bytes())?;
/// use trolley::intersect::{Cast, FirstContact};
///
/// let cast = Cast { nearest: Some(3), ..Cast::new([-1.0, 0.0, 0.0], 10.0) };
/// let query = Intersect { cast: Some(cast), ..Intersect::new(&a, &b, &poses) };
/// let first: Option<FirstContact> = query.run(SILENT)?.first;
/// assert!(first.is_some_and(|first| first.earliest.len() == 3));
/// # std::fs::remove_dir_all(&folder).ok();
/// # Ok::<(), trolley::Failure>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct FirstContact {
    /// The motion that was asked about.
    pub cast: Cast,
    /// The earliest pairs, by travel and then by ids; empty if they never touch on that way.
    pub earliest: Vec<Witness>,
    /// Pairs of triangles that were decided one by one.
    pub exact_tests: u64,
}

impl FirstContact {
    /// The first travel at which they touch (m); `None`: never.
    ///
    /// ```
    /// use trolley::intersect::{Cast, FirstContact};
    ///
    /// let cast = Cast::new([-1.0, 0.0, 0.0], 10.0);
    /// let never = FirstContact { cast, earliest: Vec::new(), exact_tests: 0 };
    /// assert_eq!((never.travel_m(), never.bracket_m()), (None, None));
    /// ```
    #[must_use]
    pub fn travel_m(&self) -> Option<f64> {
        self.earliest.first().map(|first| first.travel_m)
    }

    /// The travels between which first contact is, whatever was rounded (m).
    ///
    /// ```
    /// use trolley::intersect::{Cast, FirstContact};
    ///
    /// let cast = Cast::new([-1.0, 0.0, 0.0], 10.0);
    /// let never = FirstContact { cast, earliest: Vec::new(), exact_tests: 0 };
    /// assert_eq!(never.bracket_m(), None);
    /// ```
    #[must_use]
    pub fn bracket_m(&self) -> Option<[f64; 2]> {
        let travel_m = self.travel_m()?;
        let begin_m = 0.0 - self.cast.back_m;
        let low = (travel_m - TOLERANCE_M).max(begin_m);
        Some([low, (travel_m + TOLERANCE_M).min(self.cast.reach_m)])
    }
}

impl Serialize for FirstContact {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        #[derive(Serialize)]
        struct Pair {
            travel_m: f64,
            ids: [u32; 2],
        }
        #[derive(Serialize)]
        struct Line {
            first_contact_m: Option<f64>,
            witness: Option<[u32; 2]>,
            bracket: Option<[f64; 2]>,
            exact_tests: u64,
            #[serde(skip_serializing_if = "Option::is_none")]
            nearest: Option<Vec<Pair>>,
        }
        let pair = |of: &Witness| Pair { travel_m: of.travel_m, ids: of.ids };
        let line = Line {
            first_contact_m: self.travel_m(),
            witness: self.earliest.first().map(|first| first.ids),
            bracket: self.bracket_m(),
            exact_tests: self.exact_tests,
            nearest: self.cast.nearest.map(|_| self.earliest.iter().map(pair).collect()),
        };
        line.serialize(serializer)
    }
}

/// Runs the query to warm up, and then as often as it is timed, on this thread.
pub(super) fn ask(
    it: &Intersect,
    cast: &Cast,
    level: Level,
    bodies: [&Body; 2],
    poses: &[Pose; 2],
) -> Result<(QueryResult, Option<FirstContact>), Failure> {
    let [a, b] = [bodies[0].view()?, bodies[1].view()?];
    let nearest = cast.nearest.unwrap_or(1).clamp(1, NEAREST_MAX) as usize;
    let mut workspace = SweepWorkspace::new();
    workspace.set_level(level);
    workspace.set_walk(it.walk);
    let mut query = |poses: &[Pose; 2]| -> Result<(QueryResult, FirstContact), Failure> {
        let begun_ns = now_ns();
        let [of_a, of_b] = black_box(poses);
        let (pose, sweep) = (RelativePose::between(of_a, of_b), cast.sweep(of_a)?);
        let posed_ns = now_ns();
        let earliest = earliest_pairs(a, b, &pose, &sweep, nearest, &mut workspace)?;
        let query_ns = now_ns() - posed_ns;
        let effort = workspace.effort();
        let asked = QueryResult {
            found: Found::default(),
            counters: effort.counters,
            jobs: 1,
            pose_ns: posed_ns - begun_ns,
            query_ns,
        };
        Ok((asked, FirstContact { cast: *cast, earliest, exact_tests: effort.exact_tests }))
    };
    let (_, first) = query(poses)?;
    let (asked, first) = repeated(it, poses, &first, query)?;
    Ok((asked, Some(first)))
}
