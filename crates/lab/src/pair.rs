//! Two bodies and the poses at which they are measured.
//!
//! A body is a model file, or `shape:triangles` for a generated one. Poses come from a file, or are
//! found: B approaches A from sixteen directions until it touches, then moves in further.

use body::{BodyView, Meta, Shape};
use bvh::{Kernel, NodePair, Question, Task};
use core::ops::ControlFlow;
use geometry::{Pose, RelativePose};
use scenario::EngineSettings;
use std::path::Path;
use trolley::bodies::{Bodies, ModelFile, build_options};
use trolley::{Failure, poses};

/// Number of directions from which B approaches.
const DIRECTIONS: u32 = 16;
/// Step of the approach (m).
const STEP_M: f64 = 0.05;
/// How deep a substantial contact is (m).
const DEEP_M: f64 = 0.5;
/// How deep a scratch is (m).
const SCRATCH_M: f64 = 0.01;

/// A pair as written: A,B,POSES. Bodies are model files, or `shape:triangles`; poses are a file of
/// them, `deep` or `scratch`.
#[derive(Clone, Debug)]
pub struct PairName {
    a: String,
    b: String,
    poses: String,
}

impl std::str::FromStr for PairName {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.split(',').map(str::trim).collect::<Vec<_>>()[..] {
            [a, b, poses] if [a, b, poses].iter().all(|part| !part.is_empty()) => {
                Ok(Self { a: a.to_owned(), b: b.to_owned(), poses: poses.to_owned() })
            }
            _ => Err("write A,B,POSES: bodies as files or shape:triangles; deep, scratch or a \
                      file of poses"
                .to_owned()),
        }
    }
}

impl std::fmt::Display for PairName {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let file = |text: &str| {
            let name = Path::new(text).file_name().unwrap_or_default();
            name.to_string_lossy().into_owned()
        };
        write!(f, "{},{},{}", file(&self.a), file(&self.b), file(&self.poses))
    }
}

/// Two sealed bodies and their poses.
pub(crate) struct Pair {
    pub(crate) name: String,
    pub(crate) bodies: Bodies,
    pub(crate) poses: Vec<RelativePose>,
}

impl PairName {
    /// Loads or generates both bodies, and finds or reads the poses.
    pub(crate) fn load(&self) -> Result<Pair, Failure> {
        let bodies = Bodies::seal(vec![body(&self.a)?, body(&self.b)?])?;
        let poses = match self.poses.as_str() {
            "deep" => found(&bodies.views()?, DEEP_M)?,
            "scratch" => found(&bodies.views()?, SCRATCH_M)?,
            path => written(Path::new(path))?,
        };
        Ok(Pair { name: self.name(), bodies, poses })
    }

    /// A valid file name.
    fn name(&self) -> String {
        let short = |text: &str| {
            let stem = Path::new(text).file_stem().unwrap_or_default().to_string_lossy();
            stem.replace(|c: char| !c.is_ascii_alphanumeric(), "-")
        };
        format!("{}-{}-{}", short(&self.a), short(&self.b), short(&self.poses))
    }
}

/// A body: the model file of that name, or generated.
pub(crate) fn body(text: &str) -> Result<ModelFile, Failure> {
    let generated = text.split_once(':').and_then(|(shape, triangles)| {
        let shape = Shape::ALL.into_iter().find(|known| known.name() == shape)?;
        Some((shape, triangles.parse::<u32>().ok()?))
    });
    match generated {
        Some((shape, triangles)) => {
            ModelFile::generate(shape, triangles, 1, &build_options(&EngineSettings::DEFAULT))
        }
        None => ModelFile::as_it_is(Path::new(text)),
    }
}

fn written(path: &Path) -> Result<Vec<RelativePose>, Failure> {
    let [a, b] = poses::read(path)?;
    Ok(vec![RelativePose::between(&a, &b)])
}

/// Stops at the first hit.
struct Enough;

impl bvh::Sink for Enough {
    fn hit(&mut self, _: bvh::Side, _: u32) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }

    fn beat(&mut self, _: u64) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}

/// Moves B in from every direction, turned a little differently each time, until it is `depth_m`
/// inside A. Directions from which the bodies never touch are left out.
fn found(bodies: &[(Meta, BodyView<'_>)], depth_m: f64) -> Result<Vec<RelativePose>, Failure> {
    let [(meta_a, a), (meta_b, b)] = bodies else {
        return Err(Failure::internal("a pair must have two bodies"));
    };
    let rooms = (a.corners.len(), b.corners.len());
    let mut kernel = Kernel::with_room(meta_a.depth, meta_b.depth, rooms.0, rooms.1);
    let mut touches = |pose: &RelativePose| {
        let task =
            Task { a: *a, b: *b, pose: *pose, question: Question::Touches, directions: None };
        kernel.run(&task, NodePair::ROOTS, u64::MAX, &mut Enough).pairs > 0
    };
    let reach = |body: &BodyView<'_>| {
        let box_ = body.bounds();
        (0..2).map(|i| f64::from(box_.min[i].abs().max(box_.max[i].abs()))).fold(0.0, f64::hypot)
    };
    let far_m = reach(a) + reach(b) + STEP_M;
    let mut poses = Vec::new();
    for number in 0..DIRECTIONS {
        let degrees = 360.0 * f64::from(number) / f64::from(DIRECTIONS);
        let turned = Pose::from_degrees(degrees, 0.0, 0.0, [0.0; 3]).rotation;
        let (x, y) = (turned[0][0], turned[1][0]);
        let yaw = 180.0 + degrees + 25.0 * f64::from(number % 4);
        let pose_at = |r: f64| {
            let placed = Pose::from_degrees(yaw % 360.0, 0.0, 0.0, [r * x, r * y, 0.0]);
            RelativePose::between(&Pose::IDENTITY, &placed)
        };
        let steps = (far_m / STEP_M) as u32;
        let first = (0..steps).map(|step| far_m - STEP_M * f64::from(step));
        let Some(mut inside) = first.into_iter().find(|r| touches(&pose_at(*r))) else { continue };
        let mut outside = inside + STEP_M;
        while outside - inside > 0.001 {
            let middle = f64::midpoint(inside, outside);
            if touches(&pose_at(middle)) { inside = middle } else { outside = middle }
        }
        poses.push(pose_at(inside - depth_m));
    }
    if poses.is_empty() {
        return Err(Failure::input("the bodies do not touch from any direction")
            .with_remedy("name a file of poses instead of deep or scratch"));
    }
    Ok(poses)
}
