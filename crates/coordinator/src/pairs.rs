//! A pair of bodies at given poses: one independent task per pose.
//!
//! Measurements run this: no search, no harm, all pairs of triangles at every pose. It times its
//! own traversals and folds, so that a measurement can report where the time went.

use crate::gather::{Gathered, SetSummary};
use crate::work::{PartOf, TaskSource};
use body::BodyView;
use bvh::{Counters, NodePair, front, section};
use dispatch::{Closed, Job};
use geometry::{DVec3, RelativePose};
use protocol::{Section, TaskId, WireQuestion, WireTask};
use runtime::clock;

/// What was found at one pose.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PoseFound {
    /// Intersecting pairs.
    pub pairs: u64,
    /// Order-free hash of these pairs.
    pub hash: u64,
    /// Triangles of A and of B that are hit.
    pub hits: [u64; 2],
    /// Order-free hashes of these triangles.
    pub hashes: [u64; 2],
}

/// Where the coordinator's time went, as far as the work itself measures it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Spent {
    /// Traversals to the distribution depth (ns).
    pub descent_ns: u64,
    /// Folding results, and closing poses (ns).
    pub fold_ns: u64,
}

/// One pose while it is worked on.
#[derive(Debug, Default)]
struct Pose {
    wire: Option<WireTask>,
    open: u32,
    gathered: Option<Gathered>,
    found: Option<PoseFound>,
    descent_nb: u64,
}

/// A pair of bodies, 0 and 1 of the store, at several poses.
#[derive(Debug)]
pub struct PairWork<'w> {
    bodies: [BodyView<'w>; 2],
    depth: u32,
    poses: Vec<Pose>,
    next: usize,
    fronts: Vec<NodePair>,
    /// Tests of the jobs.
    pub jobs: Counters,
    /// Where time went.
    pub spent: Spent,
    is_unknown: bool,
}

impl<'w> PairWork<'w> {
    /// Nothing done yet.
    #[must_use]
    pub fn new(bodies: [BodyView<'w>; 2], poses: &[RelativePose], depth: u32) -> Self {
        let wire = |(number, pose): (usize, &RelativePose)| WireTask {
            model_a: 0,
            model_b: 1,
            question: WireQuestion::Pairs as u32,
            task: number as u32,
            rotation: pose.rotation,
            translation: pose.translation,
            u: DVec3::X.to_array(),
            z: DVec3::Z.to_array(),
        };
        let wires = poses.iter().enumerate().map(wire);
        Self {
            bodies,
            depth,
            poses: wires.map(|wire| Pose { wire: Some(wire), ..Pose::default() }).collect(),
            next: 0,
            fronts: Vec::new(),
            jobs: Counters::default(),
            spent: Spent::default(),
            is_unknown: false,
        }
    }

    /// What was found at each pose; `None` if a pose is not done.
    #[must_use]
    pub fn found(&self) -> Option<Vec<PoseFound>> {
        if self.is_unknown {
            return None;
        }
        self.poses.iter().map(|pose| pose.found).collect()
    }

    /// Box tests of the traversal at each pose.
    #[must_use]
    pub fn descents(&self) -> Vec<u64> {
        self.poses.iter().map(|pose| pose.descent_nb).collect()
    }

    fn descend(&mut self, number: usize, jobs: &mut Vec<Job>) {
        let [a, b] = &self.bodies;
        let Some(wire) = self.poses[number].wire else { return };
        let pose = RelativePose { rotation: wire.rotation, translation: wire.translation };
        let mut counters = Counters::default();
        self.fronts.clear();
        front(a, b, &pose, self.depth, &mut self.fronts, &mut counters);
        let section = |model, node| Section { model, node };
        jobs.extend(self.fronts.iter().map(|pair| Job {
            task: TaskId(number as u32),
            a: section(0, pair.a),
            b: section(1, pair.b),
        }));
        let pose = &mut self.poses[number];
        pose.descent_nb = counters.nb;
        pose.open = self.fronts.len() as u32;
        pose.gathered = Some(Gathered::with_room(a.corners.len(), b.corners.len()));
        if self.fronts.is_empty() {
            self.finish(number);
        }
    }

    fn finish(&mut self, number: usize) {
        let [a, b] = &self.bodies;
        let pose = &mut self.poses[number];
        let Some(gathered) = pose.gathered.take() else { return };
        let SetSummary { hits_a, hits_b, hash_a, hash_b } = gathered.summary(a, b);
        pose.found = Some(PoseFound {
            pairs: gathered.pairs,
            hash: gathered.hash,
            hits: [hits_a, hits_b],
            hashes: [hash_a, hash_b],
        });
    }
}

impl TaskSource for PairWork<'_> {
    fn task(&self, task: TaskId) -> Option<&WireTask> {
        self.poses.get(task.0 as usize)?.wire.as_ref()
    }

    fn body(&self, model: u32) -> Option<BodyView<'_>> {
        self.bodies.get(model as usize).copied()
    }
}

impl dispatch::JobSource for PairWork<'_> {
    type Part<'p> = PartOf<'p>;

    fn more(&mut self, jobs: &mut Vec<Job>) {
        let begun_ns = clock::now_ns();
        while jobs.is_empty() && self.next < self.poses.len() {
            self.next += 1;
            self.descend(self.next - 1, jobs);
        }
        self.spent.descent_ns += clock::now_ns() - begun_ns;
    }

    fn is_obsolete(&self, _: &Job) -> bool {
        false
    }

    fn fold(&mut self, job: &Job, part: PartOf<'_>) {
        let begun_ns = clock::now_ns();
        let gathered = self.poses.get_mut(job.task.0 as usize).and_then(|p| p.gathered.as_mut());
        let is_sound = gathered.is_some_and(|gathered| gathered.fold(part.0, &mut self.jobs));
        self.is_unknown |= !is_sound || !part.is_whole();
        self.spent.fold_ns += clock::now_ns() - begun_ns;
    }

    fn close(&mut self, job: &Job, how: Closed) {
        self.is_unknown |= matches!(how, Closed::Abandoned | Closed::Late);
        let Some(pose) = self.poses.get_mut(job.task.0 as usize) else { return };
        pose.open -= 1;
        if pose.open == 0 {
            let begun_ns = clock::now_ns();
            self.finish(job.task.0 as usize);
            self.spent.fold_ns += clock::now_ns() - begun_ns;
        }
    }

    fn weight(&self, section: Section) -> u64 {
        let body = self.bodies.get(section.model as usize);
        body.map_or(0, |body| section::bytes(body.nodes, section.node))
    }
}
