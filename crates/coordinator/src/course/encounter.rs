//! Encounters: when the ego on its way first touches a party on its own.
//!
//! Bodies that are never as near as their radii reach are excluded without a look at their trees.
//! All others go through `bvh::query::first_contact_in_motion`, which proves that they never touch,
//! or finds when they do. Where neither body turns, the time is then made exact by the straight
//! sweep.

use body::{BodyView, Zones};
use bvh::query::{
    Containment, MotionContact, MotionLimits, MotionWorkspace, RelativeMotion, Shells,
    SweepWorkspace, Workspace, containment, first_contact, first_contact_in_motion, least_pair,
    touches,
};
use bvh::support::support;
use bvh::{Counters, SweepTask, Witness};
use core::ops::{ControlFlow, Range};
use geometry::motion::MotionPath;
use geometry::{Bounds, DVec3, Directions, RelativePose, Sweep, Triangle};
use serde::Serialize;

/// Tests of the first look at an encounter where there is a deadline; each further look may do
/// twice as many.
const BUDGET: u64 = 1 << 18;
/// How far around a pose the triangles that touch there are sought again (m).
const AROUND_M: f64 = 1e-6;

/// A contact of the ego with a party.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Touching {
    /// When (s).
    pub(crate) time_s: f64,
    /// Nothing touches before (s).
    pub(crate) excluded_before_s: f64,
    /// Whether triangles touch at that time; else they come as near as the resolution.
    pub(crate) is_certain: bool,
    /// Source ids of the two triangles.
    pub(crate) ids: [u32; 2],
    /// Their numbers in leaf order, and where they touch in A's frame (m).
    pub(crate) triangles: [u32; 2],
    pub(crate) point: DVec3,
}

/// What is known of an encounter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Encountered {
    /// They never touch in that time: a proof.
    Never,
    Contact(Touching),
    /// Nothing touches before; from then on everything is open.
    Open {
        from_s: f64,
    },
}

/// How bodies lie to each other at the start, if their triangles do not touch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Nested {
    No,
    /// One lies wholly inside the other.
    Yes(Touching),
    /// The outer one is open, so that this has no answer.
    Undecided,
}

/// What the search has taken.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct EncounterEffort {
    /// Encounters: a candidate's way and a party, each time that it was looked at.
    pub encounters: u64,
    /// Those whose bodies came so near that their trees were looked at.
    pub in_trees: u64,
    /// Tests of boxes there.
    pub nb: u64,
    /// Tests of triangles there.
    pub np: u64,
}

/// Buffers of the search.
#[derive(Debug, Default)]
pub(crate) struct EncounterSearch {
    motion: MotionWorkspace,
    poses: Workspace,
    sweep: SweepWorkspace,
    pub(crate) effort: EncounterEffort,
}

/// Two bodies on their ways.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ways<'p> {
    pub(crate) bodies: [BodyView<'p>; 2],
    pub(crate) shells: [&'p Shells; 2],
    pub(crate) paths: [&'p MotionPath; 2],
}

impl Ways<'_> {
    /// B in A's frame at a time (s).
    pub(crate) fn pose_at(&self, time_s: f64) -> RelativePose {
        let [a, b] = self.paths.map(|path| path.pose_at(time_s));
        RelativePose::between(&a, &b)
    }

    /// Whether the bodies stay apart in that time because their origins never come as near as both
    /// radii reach.
    pub(crate) fn are_far(&self, span_s: &Range<f64>) -> bool {
        let reach = self.bodies.iter().map(radius_m).sum::<f64>() * (1.0 + 1e-9) + 1e-6;
        let mut times: Vec<f64> = self
            .paths
            .iter()
            .flat_map(|path| path.states().iter().map(|state| state.time_s))
            .filter(|time| span_s.start < *time && *time < span_s.end)
            .chain([span_s.start, span_s.end])
            .collect();
        times.sort_by(f64::total_cmp);
        let between = |time_s: f64| {
            let [a, b] = self.paths.map(|path| DVec3::from(path.state_at(time_s).position_m));
            b - a
        };
        // Between two states of either path the way from origin to origin is straight.
        times.windows(2).all(|pair| {
            let (from, to) = (between(pair[0]), between(pair[1]));
            let along = to - from;
            let square = along.dot(along);
            let share =
                if square > 0.0 { (-from.dot(along) / square).clamp(0.0, 1.0) } else { 0.0 };
            (from + along * share).length() > reach
        })
    }
}

/// Whether a plane parallel to one of a few directions lies between two bodies; `pose` is that of B
/// in A's frame. Shells are asked only where there is none: that takes longer.
fn are_apart([a, b]: [BodyView<'_>; 2], pose: &RelativePose) -> bool {
    let at = DVec3::from(pose.translation);
    Directions::around(DVec3::X, DVec3::Z).d.iter().any(|d| {
        let of_b = support(&b, pose.direction_to_b(-*d)) - d.dot(at);
        support(&a, *d) + of_b < -AROUND_M
    })
}

/// The distance of the farthest corner of a body's box from its origin (m).
fn radius_m(body: &BodyView<'_>) -> f64 {
    let bounds = body.bounds();
    let far = |axis: usize| f64::from(bounds.min[axis].abs().max(bounds.max[axis].abs()));
    DVec3::new(far(0), far(1), far(2)).length()
}

impl EncounterSearch {
    /// Whether triangles of both touch at a time (s).
    pub(crate) fn touch_at(&mut self, ways: &Ways<'_>, time_s: f64) -> bool {
        let [a, b] = ways.bodies;
        // A path keeps poses far within what is accepted.
        touches(a, b, &ways.pose_at(time_s), &mut self.poses).unwrap_or(true)
    }

    /// Whether one body lies wholly inside the other at a time (s), without a triangle that meets
    /// another one.
    pub(crate) fn nested(&mut self, ways: &Ways<'_>, time_s: f64) -> Nested {
        let pose = ways.pose_at(time_s);
        let [a, b] = ways.bodies;
        let box_of_a = a.bounds();
        let corner = |[x, y, z]: [f32; 3]| DVec3::new(x.into(), y.into(), z.into());
        let own = Bounds { min: corner(box_of_a.min), max: corner(box_of_a.max) };
        if !own.overlaps(&pose.bounds(&b.bounds())) {
            return Nested::No;
        }
        if are_apart(ways.bodies, &pose) {
            return Nested::No;
        }
        match containment(a, b, ways.shells, &pose, &mut self.poses) {
            Ok(Containment::BInA | Containment::AInB) => {
                let inside = pose.bounds(&b.bounds());
                Nested::Yes(Touching {
                    time_s,
                    excluded_before_s: time_s,
                    is_certain: true,
                    ids: [a.source_ids[0], b.source_ids[0]],
                    triangles: [0, 0],
                    point: (inside.min + inside.max) * 0.5,
                })
            }
            Ok(Containment::Undecided { .. }) | Err(_) => Nested::Undecided,
            Ok(Containment::Apart | Containment::Touching) => Nested::No,
        }
    }

    /// The first contact in a span of time (s); contact that cannot be decided within
    /// `resolution_m` (m) counts. `is_due` says whether to give up.
    pub(crate) fn first(
        &mut self,
        ways: &Ways<'_>,
        span_s: Range<f64>,
        resolution_m: f64,
        is_due: Option<&dyn Fn() -> bool>,
    ) -> Encountered {
        self.effort.encounters += 1;
        if ways.are_far(&span_s) {
            return Encountered::Never;
        }
        self.effort.in_trees += 1;
        let [path_a, path_b] = ways.paths;
        let motion = RelativeMotion::new(path_a, path_b)
            .and_then(|motion| motion.between(span_s.start, span_s.end));
        // The reader accepts no path and no resolution that the search does not.
        let Ok(motion) = motion else { return Encountered::Open { from_s: span_s.start } };
        within_due(is_due, |budget| {
            let limits = MotionLimits { resolution_m, budget };
            let [a, b] = ways.bodies;
            let found = first_contact_in_motion(a, b, &motion, &limits, &mut self.motion);
            let Counters { nb, np } = self.motion.effort().counters;
            self.effort.nb += nb;
            self.effort.np += np;
            match found {
                Ok(MotionContact::Excluded) => ControlFlow::Break(Encountered::Never),
                Ok(MotionContact::Certain { time_s, excluded_before_s, ids }) => {
                    let touching = self.at(ways, (time_s, excluded_before_s), true, ids);
                    ControlFlow::Break(Encountered::Contact(touching))
                }
                Ok(MotionContact::Possible { time_s, to_s, ids }) => {
                    let middle_s = 0.5 * (time_s + to_s);
                    let touching = self.at(ways, (middle_s, time_s), false, ids);
                    ControlFlow::Break(Encountered::Contact(touching))
                }
                Ok(MotionContact::OutOfBudget { excluded_before_s }) => {
                    ControlFlow::Continue(excluded_before_s)
                }
                Err(_) => ControlFlow::Break(Encountered::Open { from_s: span_s.start }),
            }
        })
    }

    /// The contact at a time, made exact where neither body turns.
    fn at(
        &mut self,
        ways: &Ways<'_>,
        (time_s, excluded_before_s): (f64, f64),
        is_certain: bool,
        ids: [u32; 2],
    ) -> Touching {
        if is_certain
            && time_s > excluded_before_s
            && let Some(touching) = self.exact(ways, (time_s, excluded_before_s))
        {
            return touching;
        }
        let [a, b] = ways.bodies;
        let number = |body: &BodyView<'_>, id: u32| {
            body.source_ids.iter().position(|known| *known == id).unwrap_or(0) as u32
        };
        let triangles = [number(&a, ids[0]), number(&b, ids[1])];
        let pose = ways.pose_at(time_s);
        let point = touching_point(ways, &pose, triangles);
        Touching { time_s, excluded_before_s, is_certain, ids, triangles, point }
    }

    /// The first contact shortly before a time at which they touch, if neither body turns then.
    fn exact(
        &mut self,
        ways: &Ways<'_>,
        (time_s, excluded_before_s): (f64, f64),
    ) -> Option<Touching> {
        let steady = |path: &MotionPath| {
            let is_within = |state: &geometry::motion::State| {
                excluded_before_s < state.time_s && state.time_s < time_s
            };
            let (_, rate) = path.velocity_before(time_s, [0.0; 3]);
            !path.states().iter().any(is_within) && rate == DVec3::ZERO
        };
        if !ways.paths.iter().all(|path| steady(path)) {
            return None;
        }
        let [a, b] = ways.bodies;
        let (from, to) = (ways.pose_at(excluded_before_s), ways.pose_at(time_s));
        let moved = DVec3::from(to.translation) - DVec3::from(from.translation);
        let length = moved.length();
        if !(length > 0.0) {
            return None;
        }
        let sweep = Sweep::new(moved, -length - AROUND_M, AROUND_M).ok()?;
        let witness = first_contact(a, b, &to, &sweep, &mut self.sweep).ok()??;
        let lasts_s = time_s - excluded_before_s;
        let at_s = (time_s + witness.travel_m / length * lasts_s).clamp(excluded_before_s, time_s);
        Some(Touching {
            time_s: at_s,
            excluded_before_s: at_s,
            is_certain: true,
            ids: witness.ids,
            triangles: witness.triangles,
            point: witness.point,
        })
    }

    /// The contact of bodies that touch at a time (s), if a triangle does. `is_due` says whether to
    /// give up.
    pub(crate) fn still(
        &mut self,
        ways: &Ways<'_>,
        time_s: f64,
        is_due: Option<&dyn Fn() -> bool>,
    ) -> Encountered {
        let [a, b] = ways.bodies;
        let pose = ways.pose_at(time_s);
        within_due(is_due, |budget| match least_pair(a, b, &pose, budget, &mut self.poses) {
            Ok(ControlFlow::Continue(Some(ids))) => {
                let touching = self.at(ways, (time_s, time_s), true, ids);
                ControlFlow::Break(Encountered::Contact(touching))
            }
            Ok(ControlFlow::Continue(None)) | Err(_) => ControlFlow::Break(Encountered::Never),
            Ok(ControlFlow::Break(())) => ControlFlow::Continue(time_s),
        })
    }
}

/// Looks with ever larger budgets until it is due; without `is_due` once, with all that it takes.
/// `look` says from when on (s) everything is open if its budget does not suffice.
fn within_due(
    is_due: Option<&dyn Fn() -> bool>,
    mut look: impl FnMut(u64) -> ControlFlow<Encountered, f64>,
) -> Encountered {
    let mut budget = if is_due.is_some() { BUDGET } else { u64::MAX };
    loop {
        match look(budget) {
            ControlFlow::Break(found) => return found,
            ControlFlow::Continue(from_s) if is_due.is_none_or(|is_due| is_due()) => {
                return Encountered::Open { from_s };
            }
            ControlFlow::Continue(_) => budget = budget.saturating_mul(2),
        }
    }
}

/// A point at which two triangles touch at a pose, in A's frame (m), or nearly so.
fn touching_point(ways: &Ways<'_>, pose: &RelativePose, [a, b]: [u32; 2]) -> DVec3 {
    let [body_a, body_b] = ways.bodies;
    let corners_a = Triangle::stored(&body_a.corners[a as usize]);
    let corners_b = pose.triangle(&body_b.corners[b as usize]);
    for direction in DVec3::AXES {
        let sweep = Sweep::new(direction, -AROUND_M, AROUND_M);
        let found = sweep.ok().and_then(|sweep| {
            let task = SweepTask { a: body_a, b: body_b, pose: *pose, sweep };
            Witness::of(&task, [a, b])
        });
        if let Some(witness) = found {
            return witness.point;
        }
    }
    // Only within the resolution: between the nearest corners.
    let corners = |triangle: &Triangle| triangle.0;
    let (mut best, mut square) = (DVec3::ZERO, f64::INFINITY);
    for p in corners(&corners_a) {
        for q in corners(&corners_b) {
            let apart = (p - q).length_squared();
            if apart < square {
                (best, square) = ((p + q) * 0.5, apart);
            }
        }
    }
    best
}

/// Zones of the triangles of a contact: of A's, of B's.
pub(crate) fn zones(bodies: [&BodyView<'_>; 2], triangles: [u32; 2]) -> [Zones; 2] {
    let zone = |side: usize| bodies[side].zones.get(triangles[side] as usize).copied();
    [0, 1].map(|side| zone(side).unwrap_or(Zones(0)))
}
