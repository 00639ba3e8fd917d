//! A scene with trees, ready for queries.

use crate::scene::Scene;
use body::{Body, BodyKind, BodyView, Build, Mesh, Meta, Zones};
use geometry::{Corners, Directions, Pose, RelativePose};
use std::ops::{ControlFlow, Range};
use trolley_bvh::{
    BuildOptions, Counters, Kernel, NodePair, Outcome, Question, Sink, Task, body, front,
};

/// Two bodies with trees, one pose, and scratch for queries.
pub(crate) struct Posed {
    a: Body,
    b: Body,
    pose: RelativePose,
    kernel: Kernel,
}

impl Posed {
    /// Builds the bodies of a scene with trees of this kind.
    pub(crate) fn new(scene: &str, build: Build, leaf_size: u32) -> Self {
        let Scene { a, b, pose_a, pose_b } = Scene::named(scene);
        let options = BuildOptions { build, leaf_size, threads: 1 };
        let [a, b] = [a, b].map(|corners| with_tree(corners, &options));
        let kernel =
            Kernel::with_room(a.meta.depth, b.meta.depth, a.corners.len(), b.corners.len());
        Self { pose: RelativePose::between(&pose_a, &pose_b), kernel, a, b }
    }

    /// One query over all of both bodies.
    pub(crate) fn ask(&mut self, question: Question, directions: Option<&Directions>) -> Outcome {
        let (a, b, pose) = (self.a.view(), self.b.view(), self.pose);
        let task = Task { a, b, pose, question, directions };
        self.kernel.run(&task, NodePair::ROOTS, u64::MAX, &mut Deaf)
    }

    /// All pairs of leaves whose boxes overlap: the walk over boxes alone.
    pub(crate) fn leaves(&self) -> Vec<NodePair> {
        let (a, b) = (self.a.view(), self.b.view());
        let (mut pairs, mut counters) = (Vec::new(), Counters::default());
        front(&a, &b, &self.pose, u32::MAX, &mut pairs, &mut counters);
        pairs
    }

    /// The pairs of triangles that a query has to test. Trees must have one triangle to a leaf.
    pub(crate) fn candidates(&self) -> Vec<[u32; 2]> {
        self.leaf_pairs().into_iter().map(|(a, b)| [a.start, b.start]).collect()
    }

    /// The triangles of every pair of leaves whose boxes overlap.
    pub(crate) fn leaf_pairs(&self) -> Vec<(Range<u32>, Range<u32>)> {
        let triangles = |body: &Body, node: u32| {
            let leaf = body.nodes[node as usize];
            leaf.link..leaf.link + leaf.count
        };
        let pair = |pair: &NodePair| (triangles(&self.a, pair.a), triangles(&self.b, pair.b));
        self.leaves().iter().map(pair).collect()
    }

    /// A, B, and the pose of B relative to A.
    pub(crate) fn parts(&self) -> (BodyView<'_>, BodyView<'_>, &RelativePose) {
        (self.a.view(), self.b.view(), &self.pose)
    }
}

/// Ignores all hits.
struct Deaf;

impl Sink for Deaf {
    fn hit(&mut self, _: trolley_bvh::Side, _: u32) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }

    fn beat(&mut self, _: u64) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}

fn with_tree(corners: Vec<Corners>, options: &BuildOptions) -> Body {
    let count = corners.len();
    let mesh = Mesh {
        corners,
        source_ids: (0..count as u32).collect(),
        part_of: vec![0; count],
        parts: vec!["all".into()],
        dropped: Vec::new(),
        degenerate: 0,
    };
    // Only the tree matters here.
    let meta = Meta {
        name: "benchmark".into(),
        kind: BodyKind::Sedan,
        mass_kg: None,
        centre_m: Pose::IDENTITY.translation,
        gyration_m: 1.0,
        mass_source: String::new(),
        impact: body::OwnParameters::default(),
        impact_source: String::new(),
        occupants: None,
        parts: Vec::new(),
        origin: String::new(),
        origin_hash: String::new(),
        degenerate: 0,
        build: options.build,
        leaf_size: options.leaf_size,
        depth: 1,
        outlines: Default::default(),
        front_height_m: None,
    };
    let zones = vec![Zones::default(); count];
    body(mesh, meta, zones, options, &|_| ()).expect("a scene has triangles")
}
