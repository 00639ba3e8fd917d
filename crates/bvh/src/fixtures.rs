//! Bodies, poses and the oracle of this crate's tests: every triangle against every other.

use crate::query::Workspace;
use crate::{
    BuildOptions, Counters, End, Kernel, NodePair, Outcome, Question, Side, Sink, Task, Walk, body,
};
use body::{Body, BodyKind, BodyView, Build, Mesh, Meta, Zones};
use geometry::simd::{self, Level};
use geometry::{Corners, DVec3, Directions, Pose, RelativePose, Supports, hash, triangle};
use proptest::prelude::*;
use std::collections::BTreeSet;
use std::ops::ControlFlow;

/// A body over `corners`, with source ids that are neither dense nor in order.
pub(crate) fn body_of(corners: &[Corners], options: &BuildOptions) -> Body {
    let count = corners.len() as u32;
    let mesh = Mesh {
        corners: corners.to_vec(),
        source_ids: (0..count).map(|i| 3 * (count - i) + 7).collect(),
        part_of: (0..count).map(|i| (i % 3) as u16).collect(),
        parts: ["a", "b", "c"].map(String::from).to_vec(),
        dropped: vec![(4, 7)],
        degenerate: 0,
    };
    let zones = (0..count).map(|i| Zones(1 << (i % 16))).collect();
    body(mesh, meta(), zones, options, &|_| ()).unwrap()
}

pub(crate) fn meta() -> Meta {
    Meta {
        name: "test".into(),
        kind: BodyKind::Sedan,
        mass_kg: Some(1000.0),
        centre_m: [0.0; 3],
        gyration_m: 1.0,
        mass_source: "test".into(),
        impact: body::OwnParameters::default(),
        impact_source: String::new(),
        occupants: None,
        parts: Vec::new(),
        origin: "test".into(),
        origin_hash: String::new(),
        degenerate: 0,
        build: Build::Paper,
        leaf_size: 1,
        depth: 1,
        outlines: Default::default(),
        front_height_m: None,
    }
}

pub(crate) fn options(build: Build, leaf_size: u32) -> BuildOptions {
    BuildOptions { build, leaf_size, threads: 1 }
}

/// SplitMix64, for bodies that are too large for proptest to write down.
pub(crate) struct Random(u64);

impl Random {
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// Uniform in [0, 1).
    pub(crate) fn unit(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(1);
        (hash::splitmix64(self.0) >> 40) as f32 / (1 << 24) as f32
    }
}

/// `count` small triangles, scattered over a cube of 2 m.
pub(crate) fn soup(count: usize, size: f32, seed: u64) -> Vec<Corners> {
    let mut random = Random::new(seed << 32);
    (0..count)
        .map(|_| {
            let centre = [0; 3].map(|_| 2.0 * random.unit() - 1.0);
            [0; 3].map(|_| centre.map(|c| c + size * (random.unit() - 0.5)))
        })
        .collect()
}

/// A closed torus of `2 u v` triangles around z, radii 1 m and `tube` m.
pub(crate) fn torus(u: u32, v: u32, tube: f64) -> Vec<Corners> {
    let point = |i: u32, j: u32| {
        let turn = |k: u32, n: u32| {
            let degrees = f64::from(k % n) / f64::from(n) * 360.0;
            let [cos, sin] =
                [0, 1].map(|row| Pose::from_degrees(degrees, 0.0, 0.0, [0.0; 3]).rotation[row][0]);
            (sin, cos)
        };
        let ((si, ci), (sj, cj)) = (turn(i, u), turn(j, v));
        let r = 1.0 + tube * cj;
        [r * ci, r * si, tube * sj].map(|x| x as f32)
    };
    (0..u)
        .flat_map(|i| (0..v).map(move |j| (i, j)))
        .flat_map(|(i, j)| {
            let [a, b, c, d] =
                [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)].map(|(i, j)| point(i, j));
            [[a, b, c], [a, c, d]]
        })
        .collect()
}

/// Triangles on a coarse lattice, with many touching, coplanar, degenerate and equal ones.
pub(crate) fn lattice(most: usize) -> impl Strategy<Value = Vec<Corners>> {
    let coordinate = (-4_i8..=4).prop_map(|x| f32::from(x) * 0.5);
    let point = prop::array::uniform3(coordinate);
    prop::collection::vec(prop::array::uniform3(point), 1..=most)
}

/// Triangles anywhere: from needles to some that span the whole body.
pub(crate) fn loose(most: usize) -> impl Strategy<Value = Vec<Corners>> {
    (1..=most, 0.01_f32..2.0, any::<u32>())
        .prop_map(|(count, size, seed)| soup(count, size, u64::from(seed)))
}

pub(crate) fn triangles(most: usize) -> impl Strategy<Value = Vec<Corners>> {
    prop_oneof![lattice(most), loose(most)]
}

/// Poses on the lattice as well as any other.
pub(crate) fn pose() -> impl Strategy<Value = RelativePose> {
    let aligned = prop::array::uniform3(-4_i8..=4).prop_map(|t| RelativePose {
        rotation: [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]],
        translation: t.map(|x| f64::from(x) * 0.5),
    });
    let turn = -180.0..180.0;
    let any = (turn.clone(), turn.clone(), turn, prop::array::uniform3(-1.5..1.5)).prop_map(
        |(yaw, pitch, roll, t)| {
            RelativePose::between(&Pose::IDENTITY, &Pose::from_degrees(yaw, pitch, roll, t))
        },
    );
    prop_oneof![aligned, any]
}

pub(crate) fn any_build() -> impl Strategy<Value = Build> {
    prop::sample::select(vec![Build::Paper, Build::Literal, Build::Sah])
}

pub(crate) fn directions() -> Directions {
    Directions::around(DVec3::new(0.6, 0.8, 0.0), DVec3::Z)
}

/// What is found, by source ids: it must not depend on the trees.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Found {
    pub(crate) hits: BTreeSet<(Side, u32)>,
    /// Ascending; a pair that was listed twice occurs twice.
    pub(crate) listed: Vec<(u32, u32)>,
    pub(crate) pairs: u64,
    pub(crate) hash: u64,
    pub(crate) zones: (u16, u16),
    pub(crate) supports: Vec<u64>,
}

/// Every triangle of A against every triangle of B.
pub(crate) fn brute_force(a: &BodyView<'_>, b: &BodyView<'_>, pose: &RelativePose) -> Found {
    let mut found = Gathered::default();
    let directions = directions();
    for i in 0..a.corners.len() {
        let of_a = RelativePose::between(&Pose::IDENTITY, &Pose::IDENTITY).triangle(&a.corners[i]);
        for j in 0..b.corners.len() {
            let of_b = pose.triangle(&b.corners[j]);
            if triangle::intersect(&of_a, &of_b) {
                found.hits.insert((Side::A, a.source_ids[i]));
                found.hits.insert((Side::B, b.source_ids[j]));
                found.listed.push((a.source_ids[i], b.source_ids[j]));
                found.pairs += 1;
                found.hash =
                    found.hash.wrapping_add(hash::pair_term(a.source_ids[i], b.source_ids[j]));
                found.zones.0 |= a.zones[i].0;
                found.zones.1 |= b.zones[j].0;
                for point in triangle::contact(&of_a, &of_b).points() {
                    found.supports.add(&directions, *point);
                }
            }
        }
    }
    found.finish()
}

/// The merge of jobs, as done by a coordinator.
pub(crate) struct Gathered {
    pub(crate) hits: BTreeSet<(Side, u32)>,
    pub(crate) listed: Vec<(u32, u32)>,
    pairs: u64,
    hash: u64,
    zones: (u16, u16),
    supports: Supports,
    pub(crate) counters: Counters,
}

impl Default for Gathered {
    fn default() -> Self {
        let (hits, listed) = (BTreeSet::new(), Vec::new());
        let (pairs, hash, zones, counters) = (0, 0, (0, 0), Counters::default());
        Self { hits, listed, pairs, hash, zones, supports: Supports::EMPTY, counters }
    }
}

impl Gathered {
    pub(crate) fn add(&mut self, outcome: &Outcome) {
        self.pairs += outcome.pairs;
        self.hash = self.hash.wrapping_add(outcome.hash);
        self.zones.0 |= outcome.zones_a;
        self.zones.1 |= outcome.zones_b;
        self.supports.merge(&outcome.supports);
        self.counters.add(&outcome.counters);
    }

    /// Adds what a listener received in a job with this outcome.
    pub(crate) fn add_heard(&mut self, task: &Task<'_>, outcome: &Outcome, heard: &Listener) {
        self.hits.append(&mut named(task, &heard.heard));
        if task.question != Question::Pairs {
            assert_eq!(heard.listed, [], "pairs were reported without a request");
            return;
        }
        // Pairs reported after these are open again.
        for &(a, b) in &heard.listed[..outcome.pairs as usize] {
            self.listed.push((task.a.source_ids[a as usize], task.b.source_ids[b as usize]));
        }
    }

    pub(crate) fn finish(mut self) -> Found {
        self.listed.sort_unstable();
        let supports = self.supports.0.iter().map(|s| (s + 0.0).to_bits()).collect();
        let Self { hits, listed, pairs, hash, zones, .. } = self;
        Found { hits, listed, pairs, hash, zones, supports }
    }
}

/// Receives hits; stops at a given one or at a given beat.
pub(crate) struct Listener {
    /// In the order received, leaf-order numbers.
    pub(crate) heard: Vec<(Side, u32)>,
    /// Pairs, in the order received.
    pub(crate) listed: Vec<(u32, u32)>,
    pub(crate) beats: Vec<u64>,
    pub(crate) hits_max: usize,
    pub(crate) beats_max: usize,
}

impl Listener {
    pub(crate) fn new() -> Self {
        let (heard, listed, beats) = (Vec::new(), Vec::new(), Vec::new());
        Self { heard, listed, beats, hits_max: usize::MAX, beats_max: usize::MAX }
    }
}

impl Sink for Listener {
    fn hit(&mut self, side: Side, triangle: u32) -> ControlFlow<()> {
        if self.heard.len() >= self.hits_max {
            return ControlFlow::Break(());
        }
        self.heard.push((side, triangle));
        ControlFlow::Continue(())
    }

    fn pairs(&mut self, a: &[u32], b: &[u32]) -> ControlFlow<()> {
        assert_eq!(a.len(), b.len());
        self.listed.extend(a.iter().copied().zip(b.iter().copied()));
        ControlFlow::Continue(())
    }

    fn beat(&mut self, tests: u64) -> ControlFlow<()> {
        self.beats.push(tests);
        if self.beats.len() > self.beats_max {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    }
}

pub(crate) fn task<'a>(
    a: &'a Body,
    b: &'a Body,
    pose: RelativePose,
    question: Question,
    directions: &'a Directions,
) -> Task<'a> {
    Task { a: a.view(), b: b.view(), pose, question, directions: Some(directions) }
}

pub(crate) fn kernel_for(a: &Body, b: &Body) -> Kernel {
    Kernel::with_room(a.meta.depth, b.meta.depth, a.corners.len(), b.corners.len())
}

/// The configuration of a kernel: the answer must not depend on it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Way {
    walk: Walk,
    level: Level,
}

impl Way {
    /// The wide walk with all vector levels of this processor, and the plain one.
    pub(crate) fn all() -> Vec<Self> {
        let wide = simd::levels().map(|level| Self { walk: Walk::Wide, level });
        wide.chain([Self { walk: Walk::Plain, level: Level::new() }]).collect()
    }

    pub(crate) fn kernel(self, a: &Body, b: &Body) -> Kernel {
        let mut kernel = kernel_for(a, b);
        kernel.set_walk(self.walk);
        kernel.set_level(self.level);
        kernel
    }

    pub(crate) fn workspace(self) -> Workspace {
        let mut workspace = Workspace::new();
        workspace.set_walk(self.walk);
        workspace.set_level(self.level);
        workspace
    }
}

pub(crate) fn any_way() -> impl Strategy<Value = Way> {
    prop::sample::select(Way::all())
}

/// Source ids of what was received; each triangle at most once.
pub(crate) fn named(task: &Task<'_>, heard: &[(Side, u32)]) -> BTreeSet<(Side, u32)> {
    let once: BTreeSet<_> = heard.iter().collect();
    assert_eq!(once.len(), heard.len(), "a triangle was reported twice");
    let id = |side, triangle: u32| match side {
        Side::A => task.a.source_ids[triangle as usize],
        Side::B => task.b.source_ids[triangle as usize],
    };
    heard.iter().map(|&(side, triangle)| (side, id(side, triangle))).collect()
}

/// Runs the jobs `starts` and, wherever the budget or the listener cuts them, their remainders.
pub(crate) fn run_all(
    kernel: &mut Kernel,
    task: &Task<'_>,
    starts: &[NodePair],
    budget: u64,
    listener: impl Fn() -> Listener,
) -> Gathered {
    let mut gathered = Gathered::default();
    let mut open = starts.to_vec();
    while let Some(start) = open.pop() {
        let mut listener = listener();
        let outcome = kernel.run(task, start, budget, &mut listener);
        assert_eq!(outcome.end == End::Complete, kernel.remaining().is_empty());
        open.extend_from_slice(kernel.remaining());
        gathered.add(&outcome);
        gathered.add_heard(task, &outcome, &listener);
    }
    gathered
}
