//! How first contact used to be sought: whether the bodies touch at 16 poses, from where their
//! hulls meet in plan view to 0.6 m past that, and then by halving down to 1 mm.
//!
//! It is here to be compared with. It misses whatever happens between two poses.

use super::encounter::Encounter;
use body::BodyView;
use geometry::plan::hull_of;
use geometry::{Corners, DVec3, RelativePose};
use std::ops::ControlFlow;
use trolley_bvh::{Counters, Kernel, NodePair, Question, Side, Sink, Task};

/// Poses of the grid.
const POSES: usize = 16;
/// How far the grid continues after the hulls meet (m).
const PAST_M: f64 = 0.6;
/// Coarsest step of the grid unless it is long (m).
const STEP_M: f64 = 0.1;
/// Where halving ends (m).
const FIRST_CONTACT_M: f64 = 0.001;

/// Which poses of the grid are tried.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Grid {
    /// All, as they were asked for together.
    Whole,
    /// In order, until one touches.
    UntilTouching,
}

/// Travels of the grid (m).
pub(crate) fn grid(encounter: &Encounter, [a, b]: [&[Corners]; 2]) -> Vec<f64> {
    let stored = |corner: &[f32; 3]| DVec3::from_array(corner.map(f64::from));
    let in_plan = |p: DVec3| [p.x, p.y];
    let hull_a = hull_of(a.as_flattened().iter().map(|p| in_plan(stored(p))).collect());
    let posed = b.as_flattened().iter().map(|corner| encounter.pose.point(*corner));
    let hull_b = hull_of(posed.map(in_plan).collect());
    let [entry, exit] = meeting(&hull_a, &hull_b, encounter.direction);
    if entry > exit {
        // They pass: the search was left out then. Here all of the passing is looked at.
        return (0..POSES).map(|k| -4.5 + 9.0 * (k as f64 / (POSES - 1) as f64)).collect();
    }
    let end = (entry + PAST_M).max(0.0);
    let step = STEP_M.max((end - entry) / (POSES - 1) as f64);
    let steps = (0..POSES).map(|k| entry + k as f64 * step);
    let mut grid: Vec<f64> = steps.take_while(|travel| *travel < end - 1e-9).collect();
    grid.push(end);
    grid
}

/// The first pose that touches, to 1 mm, and the tests that it took.
pub(crate) fn search(
    kernel: &mut Kernel,
    [a, b]: [BodyView<'_>; 2],
    encounter: &Encounter,
    travels: &[f64],
    tried: Grid,
) -> (Option<f64>, Counters) {
    let mut counters = Counters::default();
    let mut touches = |travel: f64| {
        let pose: RelativePose = encounter.pose.moved(encounter.direction * travel);
        let task = Task { a, b, pose, question: Question::Touches, directions: None };
        let outcome = kernel.run(&task, NodePair::ROOTS, u64::MAX, &mut Deaf);
        counters.add(&outcome.counters);
        outcome.pairs > 0
    };
    let first = match tried {
        Grid::UntilTouching => travels.iter().position(|travel| touches(*travel)),
        Grid::Whole => {
            let all: Vec<bool> = travels.iter().map(|travel| touches(*travel)).collect();
            all.iter().position(|touching| *touching)
        }
    };
    let Some(first) = first else { return (None, counters) };
    let mut touching = travels[first];
    if let Some(before) = first.checked_sub(1) {
        let mut apart = travels[before];
        while touching - apart > FIRST_CONTACT_M {
            let mid = 0.5 * (apart + touching);
            *if touches(mid) { &mut touching } else { &mut apart } = mid;
        }
    }
    (Some(touching), counters)
}

/// Ignores all hits.
struct Deaf;

impl Sink for Deaf {
    fn hit(&mut self, _: Side, _: u32) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }

    fn beat(&mut self, _: u64) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}

/// Between which travels two convex polygons overlap; descending if they never do.
fn meeting(a: &[[f64; 2]], b: &[[f64; 2]], direction: DVec3) -> [f64; 2] {
    let mut meeting = [f64::NEG_INFINITY, f64::INFINITY];
    let normals = [a, b].into_iter().flat_map(|polygon| {
        let next = polygon.iter().cycle().skip(1);
        polygon.iter().zip(next).map(|(p, q)| [q[1] - p[1], p[0] - q[0]])
    });
    for normal in normals {
        let along = |p: &[f64; 2]| normal[0] * p[0] + normal[1] * p[1];
        let range = |polygon: &[[f64; 2]]| {
            let spread = |[low, high]: [f64; 2], x: f64| [low.min(x), high.max(x)];
            polygon.iter().map(along).fold([f64::INFINITY, f64::NEG_INFINITY], spread)
        };
        let ([a_low, a_high], [b_low, b_high]) = (range(a), range(b));
        let speed = along(&[direction.x, direction.y]);
        if speed.abs() < 1e-12 {
            if a_low > b_high || b_low > a_high {
                return [1.0, 0.0];
            }
            continue;
        }
        let (s, t) = ((a_low - b_high) / speed, (a_high - b_low) / speed);
        meeting = [meeting[0].max(s.min(t)), meeting[1].min(s.max(t))];
    }
    meeting
}
