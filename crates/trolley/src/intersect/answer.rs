//! What a query found, and its line of JSON.

use super::FirstContact;
use body::Build;
use bvh::kernel::Walk;
use bvh::{BuildOptions, Counters, Question};
use serde::{Serialize, Serializer};
use std::path::{Path, PathBuf};

/// What a query found. It depends on the triangles and the poses alone.
///
/// ```
/// # use trolley::bodies::{ModelFile, SILENT};
/// # use trolley::intersect::Intersect;
/// # use trolley::model::{BuildOptions, Shape};
/// # let folder = std::env::temp_dir().join(format!("trolley-found-{}", std::process::id()));
/// # std::fs::create_dir_all(&folder).ok();
/// # let [a, b, poses] = ["a.trolley", "b.trolley", "poses.txt"].map(|name| folder.join(name));
/// # let pole = ModelFile::generate(Shape::Pole, 600, 0, &BuildOptions::default())?;
/// # trolley::files::replace(&a, pole.bytes())?;
/// # trolley::files::replace(&b, pole.bytes())?;
/// # let text = "1 0 0 0\n0 1 0 0\n0 0 1 0\n1 0 0 0.1\n0 1 0 0\n0 0 1 0\n";
/// # trolley::files::replace(&poses, text.as_bytes())?;
/// let asked = Intersect::new(&a, &b, &poses).run(SILENT)?.asked;
/// println!("{} pairs of {:?} triangles", asked.found.pairs, asked.found.hits);
/// assert!(asked.found.hits[0] <= 600);
/// # std::fs::remove_dir_all(&folder).ok();
/// # Ok::<(), trolley::Failure>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Found {
    /// Pairs that intersect, for [`Question::Pairs`]; whether any does, for [`Question::Touches`].
    pub pairs: u64,
    /// Of the pairs: the sum modulo 2⁶⁴ of splitmix64(id of A · 2³² + id of B).
    pub hash: u64,
    /// Triangles hit, of A and of B.
    pub hits: [usize; 2],
    /// Of the triangles hit: the sums modulo 2⁶⁴ of splitmix64(id).
    pub hashes: [u64; 2],
}

/// The result of a query, or of the last of several with the medians of their times.
///
/// ```
/// # use trolley::bodies::{ModelFile, SILENT};
/// # use trolley::intersect::Intersect;
/// # use trolley::model::{BuildOptions, Shape};
/// # let folder = std::env::temp_dir().join(format!("trolley-result-{}", std::process::id()));
/// # std::fs::create_dir_all(&folder).ok();
/// # let [a, b, poses] = ["a.trolley", "b.trolley", "poses.txt"].map(|name| folder.join(name));
/// # let pole = ModelFile::generate(Shape::Pole, 600, 0, &BuildOptions::default())?;
/// # trolley::files::replace(&a, pole.bytes())?;
/// # trolley::files::replace(&b, pole.bytes())?;
/// # let text = "1 0 0 0\n0 1 0 0\n0 0 1 0\n1 0 0 0.1\n0 1 0 0\n0 0 1 0\n";
/// # trolley::files::replace(&poses, text.as_bytes())?;
/// let asked = Intersect::new(&a, &b, &poses).run(SILENT)?.asked;
/// println!("{} ns in {} parts", asked.query_ns, asked.jobs);
/// assert_eq!(asked.jobs, 1);
/// # std::fs::remove_dir_all(&folder).ok();
/// # Ok::<(), trolley::Failure>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct QueryResult {
    /// What it found.
    pub found: Found,
    /// Numbers of box tests and of triangle tests.
    pub counters: Counters,
    /// Parts that the query was divided into: 1 unless several threads shared the work.
    pub jobs: u64,
    /// Time to compute the relative pose (ns).
    pub pose_ns: u64,
    /// Time of the query (ns).
    pub query_ns: u64,
}

/// The result of [`Intersect::run`](super::Intersect::run).
///
/// As JSON it is one object; `trolley intersect --help` explains its keys.
///
/// ```
/// # use trolley::bodies::{ModelFile, SILENT};
/// # use trolley::intersect::Intersect;
/// # use trolley::model::{BuildOptions, Shape};
/// # let folder = std::env::temp_dir().join(format!("trolley-intersected-{}", std::process::id()));
/// # std::fs::create_dir_all(&folder).ok();
/// # let [a, b, poses] = ["a.trolley", "b.trolley", "poses.txt"].map(|name| folder.join(name));
/// # let pole = ModelFile::generate(Shape::Pole, 600, 0, &BuildOptions::default())?;
/// # trolley::files::replace(&a, pole.bytes())?;
/// # trolley::files::replace(&b, pole.bytes())?;
/// # let text = "1 0 0 0\n0 1 0 0\n0 0 1 0\n1 0 0 0.1\n0 1 0 0\n0 0 1 0\n";
/// # trolley::files::replace(&poses, text.as_bytes())?;
/// let result = Intersect::new(&a, &b, &poses).run(SILENT)?;
/// let json = serde_json::to_value(&result);
/// assert!(json.is_ok_and(|json| json["pairs"] == result.asked.found.pairs));
/// # std::fs::remove_dir_all(&folder).ok();
/// # Ok::<(), trolley::Failure>(())
/// ```
#[derive(Clone, Debug)]
pub struct Intersected {
    /// A and B.
    pub files: [PathBuf; 2],
    /// Triangles of A and of B.
    pub triangles: [usize; 2],
    /// What was asked, unless there was a cast.
    pub question: Question,
    /// How the trees are built.
    pub tree: BuildOptions,
    /// Vector instructions of the kernel.
    pub simd: &'static str,
    /// How the trees were walked.
    pub walk: Walk,
    /// Time to build both trees (ns); 0 where a model file had the tree already.
    pub build_ns: u64,
    /// How often the query was timed.
    pub repeat: u32,
    /// Whether the caches were emptied before each timed query.
    pub cold: bool,
    /// Whether B was moved for each timed query.
    pub moving: bool,
    /// What was found.
    pub asked: QueryResult,
    /// What was found for a cast.
    pub first: Option<FirstContact>,
}

#[derive(Serialize)]
struct Line<'a> {
    peer: &'static str,
    case: &'a str,
    build_ms: f64,
    pose_ms: f64,
    query_ms: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    pairs: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    hash: Option<String>,
    #[serde(flatten)]
    sets: Option<Sets>,
    #[serde(flatten)]
    first: Option<&'a FirstContact>,
    nb: u64,
    np: u64,
    question: &'static str,
    build: Build,
    leaf_size: u32,
    simd: &'static str,
    walk: &'static str,
    threads: usize,
    cold: bool,
    moving: bool,
    jobs: u64,
    triangles_a: usize,
    triangles_b: usize,
    schema: u32,
}

#[derive(Serialize)]
struct Sets {
    hits_a: usize,
    hits_b: usize,
    hash_a: String,
    hash_b: String,
}

impl Serialize for Intersected {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let Found { pairs, hash, hits, hashes } = self.asked.found;
        let (pairs, hash, sets) = match self.question {
            _ if self.first.is_some() => (None, None, None),
            Question::Pairs => (Some(pairs), Some(hex(hash)), None),
            Question::Touches => (Some(pairs), Some(String::new()), None),
            Question::Sets => {
                let ([hits_a, hits_b], [hash_a, hash_b]) = (hits, hashes.map(hex));
                (None, None, Some(Sets { hits_a, hits_b, hash_a, hash_b }))
            }
        };
        let folder = std::path::absolute(&self.files[0]).unwrap_or_default();
        let folder = folder.parent().and_then(Path::file_name).unwrap_or_default();
        let line = Line {
            peer: "trolley",
            case: &folder.to_string_lossy(),
            build_ms: milliseconds(self.build_ns),
            pose_ms: milliseconds(self.asked.pose_ns),
            query_ms: milliseconds(self.asked.query_ns),
            pairs,
            hash,
            sets,
            first: self.first.as_ref(),
            nb: self.asked.counters.nb,
            np: self.asked.counters.np,
            question: match self.question {
                _ if self.first.is_some() => "first-contact",
                Question::Pairs => "pairs",
                Question::Sets => "sets",
                Question::Touches => "touches",
            },
            build: self.tree.build,
            leaf_size: self.tree.leaf_size,
            simd: self.simd,
            walk: match self.walk {
                Walk::Wide => "wide",
                Walk::Plain => "plain",
            },
            threads: self.tree.threads,
            cold: self.cold,
            moving: self.moving,
            jobs: self.asked.jobs,
            triangles_a: self.triangles[0],
            triangles_b: self.triangles[1],
            schema: 1,
        };
        line.serialize(serializer)
    }
}

/// Returns a hash as 16 hexadecimal digits.
///
/// ```
/// assert_eq!(trolley::intersect::hex(255), "00000000000000ff");
/// ```
#[must_use]
pub fn hex(hash: u64) -> String {
    format!("{hash:016x}")
}

fn milliseconds(ns: u64) -> f64 {
    ns as f64 / 1e6
}
