//! What was found, and how it is shown: a few lines for people, one line of JSON for programs.

use super::{QuestionName, WalkName};
use crate::model::facts::{shown, thousands};
use crate::print;
use body::Build;
use bvh::{BuildOptions, Counters};
use serde::Serialize;
use std::path::Path;
use trolley::Failure;

/// What a query found. For one pose it is always the same, but for the counters.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Found {
    pub(super) pairs: u64,
    /// Of the pairs.
    pub(super) hash: u64,
    /// Triangles hit, of A and of B.
    pub(super) hits: [usize; 2],
    /// Of these.
    pub(super) hashes: [u64; 2],
}

/// A query, or the last of several and the medians of their times.
#[derive(Clone, Copy, Debug)]
pub(super) struct Asked {
    pub(super) found: Found,
    pub(super) counters: Counters,
    pub(super) jobs: u64,
    pub(super) pose_ns: u64,
    pub(super) query_ns: u64,
}

/// A finished run.
pub(super) struct Answer<'a> {
    pub(super) files: [&'a Path; 2],
    pub(super) triangles: [usize; 2],
    pub(super) question: QuestionName,
    pub(super) tree: BuildOptions,
    pub(super) simd: &'static str,
    pub(super) walk: WalkName,
    /// Both trees.
    pub(super) build_ns: u64,
    pub(super) repeat: u32,
    /// Whether the caches were emptied before each query.
    pub(super) cold: bool,
    /// Whether B stood elsewhere for each query.
    pub(super) moving: bool,
    pub(super) asked: Asked,
}

/// What `--json` prints: see the long help.
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
    nb: u64,
    np: u64,
    question: QuestionName,
    build: Build,
    leaf_size: u32,
    simd: &'static str,
    walk: WalkName,
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

impl Answer<'_> {
    /// One line of JSON.
    pub(super) fn json(&self) -> Result<String, Failure> {
        let Found { pairs, hash, hits, hashes } = self.asked.found;
        let (pairs, hash, sets) = match self.question {
            QuestionName::Pairs => (Some(pairs), Some(hex(hash)), None),
            QuestionName::Touches => (Some(pairs), Some(String::new()), None),
            QuestionName::Sets => {
                let ([hits_a, hits_b], [hash_a, hash_b]) = (hits, hashes.map(hex));
                (None, None, Some(Sets { hits_a, hits_b, hash_a, hash_b }))
            }
        };
        let folder = std::path::absolute(self.files[0]).unwrap_or_default();
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
            nb: self.asked.counters.nb,
            np: self.asked.counters.np,
            question: self.question,
            build: self.tree.build,
            leaf_size: self.tree.leaf_size,
            simd: self.simd,
            walk: self.walk,
            threads: self.tree.threads,
            cold: self.cold,
            moving: self.moving,
            jobs: self.asked.jobs,
            triangles_a: self.triangles[0],
            triangles_b: self.triangles[1],
            schema: 1,
        };
        print::line(&line)
    }

    /// A verdict, and how it was come by.
    pub(super) fn text(&self) -> String {
        let Found { pairs, hash, hits, hashes } = self.asked.found;
        let pairs = usize::try_from(pairs).unwrap_or(usize::MAX);
        let (verdict, hash) = match self.question {
            QuestionName::Pairs if pairs == 1 => {
                ("One pair of triangles intersects.".to_owned(), hex(hash))
            }
            QuestionName::Pairs => {
                (format!("{} pairs of triangles intersect.", thousands(pairs)), hex(hash))
            }
            QuestionName::Sets => {
                let [a, b] = hits.map(thousands);
                let [hash_a, hash_b] = hashes.map(hex);
                (format!("Hit are {a} triangles of A and {b} of B."), format!("{hash_a} {hash_b}"))
            }
            QuestionName::Touches if pairs == 0 => {
                ("They do not touch.".to_owned(), "–".to_owned())
            }
            QuestionName::Touches => ("They touch.".to_owned(), "–".to_owned()),
        };
        let body = |i: usize| {
            let name = shown(&self.files[i].display().to_string());
            format!("{name}, {} triangles", thousands(self.triangles[i]))
        };
        let count = |tests: u64| thousands(usize::try_from(tests).unwrap_or(usize::MAX));
        let BuildOptions { build, leaf_size, threads } = self.tree;
        let Asked { counters, jobs, pose_ns, query_ns, .. } = self.asked;
        let query = format!(
            "{}, {}{}median of {}; a new pose {}",
            time(query_ns),
            if self.cold { "cold caches, " } else { "" },
            if self.moving { "B moving, " } else { "" },
            self.repeat,
            time(pose_ns)
        );
        let tests = format!("{} of boxes, {} of triangles", count(counters.nb), count(counters.np));
        let trees = format!(
            "{}, {leaf_size} triangles in a leaf at most, built in {}",
            build.name(),
            time(self.build_ns)
        );
        let vectors = match self.walk {
            WalkName::Wide => self.simd.to_owned(),
            WalkName::Plain => "none: the plain walk".to_owned(),
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
}

fn hex(hash: u64) -> String {
    format!("{hash:016x}")
}

fn milliseconds(ns: u64) -> f64 {
    ns as f64 / 1e6
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
