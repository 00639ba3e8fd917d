//! Long test of the bounds: random scenes, stopped anywhere, under every policy.

use super::requests::{self, POLICIES, Pool};
use crate::progress::{Progress, SyncProgress};
use body::{Shape, Shells};
use coordinator::{BodySet, CourseFlaw, CourseRequest, TrialResult, random_courses, trial_courses};
use geometry::rng::Rng;
use rayon::prelude::*;
use scenario::{Scenario, Source};
use serde::Serialize;
use std::fmt::Write as _;
use trolley::Failure;

/// Bodies of the scenes: small, so that there are many.
const BODIES: [(Shape, &str); 7] = [
    (Shape::Sedan, "sedan:600"),
    (Shape::Suv, "suv:600"),
    (Shape::Cyclist, "cyclist:600"),
    (Shape::Pedestrian, "pedestrian:600"),
    (Shape::Truck, "truck:600"),
    (Shape::Pole, "pole:600"),
    (Shape::Wall, "wall:600"),
];

/// What to test.
#[derive(Clone, Debug)]
pub struct BoundsOptions {
    /// Number of stops; at each, all that is said is held against the finished run.
    pub stops: u64,
    /// Stops per scene.
    pub per_scene: u64,
    /// Seed of the random scenes.
    pub seed: u64,
    /// Distribution depth.
    pub depth: u32,
    /// Makes answers wrong on purpose, so that violations must be found.
    pub flaw: Option<CourseFlaw>,
}

/// What was found.
#[derive(Clone, Debug, Serialize)]
pub struct BoundsReport {
    schema: &'static str,
    policies: usize,
    seed: u64,
    scenes: u64,
    stops: u64,
    /// Those of scenes with members.
    over_members: u64,
    intervals: u64,
    open_intervals: u64,
    certified: u64,
    /// Answers over fewer members than in the end, and those of them with open work.
    late: [u64; 2],
    violations: usize,
    is_flawed: bool,
    /// The seed of the first scene that was not right, and what was not.
    first: Option<(u64, String)>,
}

/// Scenes that are tried before their results are added up: enough that no core waits long for the
/// last of them.
const BLOCK: u64 = 256;

/// Runs the test, a scene on each core at a time. `told` is called with the stops done.
///
/// # Errors
///
/// If a scene cannot be ranked. Violations are no error: see [`BoundsReport::is_right`].
pub fn bounds(options: &BoundsOptions, told: SyncProgress<'_>) -> Result<BoundsReport, Failure> {
    let pool = Pool::load(&BODIES.map(|(_, name)| name.to_owned()))?;
    let views = pool.bodies.views()?;
    let shells: Vec<Shells> = views.iter().map(|(_, view)| Shells::of(view.corners)).collect();
    let set = BodySet { bodies: &views, extremes: None, depth: options.depth };
    let bar = Progress::new(options.stops, told);
    let mut all = TrialResult::default();
    let (mut scenes, mut first) = (0, None);
    while all.stops < options.stops {
        let missing = (options.stops - all.stops).div_ceil(options.per_scene.max(1));
        let block = scenes..scenes + missing.min(BLOCK);
        let tried = block.into_par_iter().map(|scene| {
            let one = try_scene(options, scene, &set, &shells)?;
            bar.add(one.stops);
            Ok(one)
        });
        // In order, however many cores there are.
        for one in tried.collect::<Result<Vec<_>, Failure>>()? {
            if let (Some(what), None) = (one.violations.first(), &first) {
                first = Some((options.seed.wrapping_add(scenes), what.clone()));
            }
            all.add(one);
            scenes += 1;
        }
    }
    Ok(BoundsReport {
        schema: "trolley.certify-bounds/2",
        policies: POLICIES.len(),
        seed: options.seed,
        scenes,
        stops: all.stops,
        over_members: all.over_members,
        intervals: all.intervals,
        open_intervals: all.open_intervals,
        certified: all.certified,
        late: [all.late, all.late_open],
        violations: all.violations.len(),
        is_flawed: options.flaw.is_some(),
        first,
    })
}

/// Stops one scene, counted from 0: it has a seed of its own, so that it can be made again alone.
fn try_scene(
    options: &BoundsOptions,
    scene: u64,
    set: &BodySet<'_>,
    shells: &[Shells],
) -> Result<TrialResult, Failure> {
    let seed = options.seed.wrapping_add(scene);
    let text = random_courses(&mut Rng::new(seed));
    let scenario = Scenario::parse("random.toml", &text)
        .map_err(|error| Failure::from(error).of_kind(trolley::FailureKind::Internal))?;
    let model = |source: &Source| match source {
        Source::Generate { shape, .. } => BODIES.iter().position(|(known, _)| known == shape),
        Source::File(_) => None,
    };
    let models = scenario.parties.iter().map(|party| model(&party.source));
    let models: Option<Vec<usize>> = models.collect();
    let models = models.ok_or_else(|| Failure::internal("a scene has a body of no known shape"))?;
    let request = CourseRequest {
        scenario: &scenario,
        models: &models,
        shells,
        criteria: requests::criteria(scene as usize)?,
        members: scenario.members(),
        worlds: scenario::Worlds::USUAL,
        history: false,
        explanation: false,
        scene: false,
    };
    Ok(trial_courses(set, &request, (seed, options.per_scene), options.flaw)?)
}

impl BoundsReport {
    /// Whether the result is as expected: no violations, unless answers were made wrong.
    #[must_use]
    pub fn is_right(&self) -> bool {
        (self.violations > 0) == self.is_flawed
    }

    /// The report as text.
    #[must_use]
    pub fn text(&self) -> String {
        let made = if self.is_flawed { " of answers made wrong on purpose" } else { "" };
        let mut text = format!(
            "{} stops, {} of them over members, in {} scenes, {} policies, seed {}: {} intervals \
             compared with the finished run, {} of them open, {} stops with a certain winner and \
             open work, {} in time for fewer members alone, {} of these with open work.\n{} \
             violations{made}.\n",
            self.stops,
            self.over_members,
            self.scenes,
            self.policies,
            self.seed,
            self.intervals,
            self.open_intervals,
            self.certified,
            self.late[0],
            self.late[1],
            self.violations,
        );
        if let Some((seed, what)) = &self.first {
            // Writing to a string cannot fail.
            let _written = writeln!(text, "First, in the scene of seed {seed}: {what}");
        }
        text
    }
}
