//! Encounters: when two bodies on their ways first touch.
//!
//! Bodies that are never as near as their radii reach are excluded without a look at their trees.
//! All others go through `bvh::query::first_contact_in_motion`, which proves that they never touch,
//! or finds when they do. Where neither body turns, the time is then made exact by the straight
//! sweep.

use body::{BodyView, Shells};
use bvh::query::{
    Containment, MotionContact, MotionLimits, MotionWorkspace, QueryWatch, RelativeMotion,
    SweepWorkspace, Workspace, containment, first_contact, first_contact_in_motion_watched,
    least_pair_watched, touches,
};
use bvh::support::support_near;
use bvh::{Counters, SweepTask, Witness};
use core::ops::{ControlFlow, Range};
use geometry::motion::MotionPath;
use geometry::{Bounds, DVec3, Directions, RelativePose, Sweep, Triangle};
use protocol::result::{SeenKind, WireSeen};

/// How far around a pose the triangles that touch there are sought again (m).
const AROUND_M: f64 = 1e-6;

/// A contact of two bodies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Touching {
    /// When (s).
    pub time_s: f64,
    /// Nothing touches before (s).
    pub excluded_before_s: f64,
    /// Whether triangles touch at that time; else they come as near as the resolution.
    pub is_certain: bool,
    /// Source ids of the two triangles.
    pub ids: [u32; 2],
    /// Their numbers in leaf order, and where they touch in A's frame (m).
    pub triangles: [u32; 2],
    /// See `triangles`.
    pub point: DVec3,
}

/// What a look at two bodies on their ways shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LookOutcome {
    /// They never touch in that time: a proof.
    Never,
    /// Their first contact.
    Contact(Touching),
    /// They have touched before, and do so still.
    Still(Touching),
    /// They have touched before, no triangle does any more, and one may lie inside the other.
    Hidden,
}

impl LookOutcome {
    /// As encoded.
    #[must_use]
    pub fn to_wire(&self) -> WireSeen {
        let (kind, touching) = match self {
            Self::Never => (SeenKind::Never, None),
            Self::Contact(touching) => (SeenKind::Contact, Some(touching)),
            Self::Still(touching) => (SeenKind::Still, Some(touching)),
            Self::Hidden => (SeenKind::Hidden, None),
        };
        let kind = kind as u32;
        touching.map_or(WireSeen { kind, ..WireSeen::default() }, |touching| WireSeen {
            kind,
            is_certain: u32::from(touching.is_certain),
            time_s: touching.time_s,
            excluded_before_s: touching.excluded_before_s,
            triangles: touching.triangles,
            point: touching.point.to_array(),
            ids: touching.ids,
        })
    }

    /// What a look showed, as encoded; `None` if that cannot be.
    #[must_use]
    pub fn from_wire(wire: &WireSeen, look: &Look<'_>) -> Option<Self> {
        let kind = SeenKind::from_number(wire.kind)?;
        let touching = || {
            let [a, b] = [0, 1].map(|side: usize| {
                look.ways.bodies[side].source_ids.get(wire.triangles[side] as usize).copied()
            });
            let is_possible = [a?, b?] == wire.ids
                && look.from_s <= wire.excluded_before_s
                && wire.excluded_before_s <= wire.time_s
                && wire.time_s <= look.end_s.max(look.from_s)
                && wire.point.iter().all(|x| x.is_finite());
            is_possible.then(|| Touching {
                time_s: wire.time_s,
                excluded_before_s: wire.excluded_before_s,
                is_certain: wire.is_certain == 1,
                ids: wire.ids,
                triangles: wire.triangles,
                point: DVec3::from_array(wire.point),
            })
        };
        Some(match kind {
            SeenKind::Never => Self::Never,
            SeenKind::Contact => Self::Contact(touching()?),
            SeenKind::Still if look.may_touch => Self::Still(touching()?),
            SeenKind::Hidden if look.may_touch => Self::Hidden,
            SeenKind::Still | SeenKind::Hidden => return None,
        })
    }
}

/// Why a look shows nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unseen {
    /// It was ended.
    Stopped,
    /// There is no such motion, or no such resolution. Paths that a scenario's reader accepts have
    /// one.
    NoMotion,
}

/// A look at two bodies on their ways.
#[derive(Clone, Copy, Debug)]
pub struct Look<'p> {
    /// The bodies.
    pub ways: Ways<'p>,
    /// From when on (s).
    pub from_s: f64,
    /// Until when (s).
    pub end_s: f64,
    /// Contact that cannot be decided within this distance (m) counts.
    pub resolution_m: f64,
    /// They have touched before, and may do so still.
    pub may_touch: bool,
}

/// How bodies lie to each other at the start, if their triangles do not touch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Nested {
    /// Neither lies inside the other, or triangles touch.
    No,
    /// One lies wholly inside the other.
    Yes(Touching),
    /// The outer one is open, so that this has no answer.
    Undecided,
}

/// Buffers of looks, reusable for any bodies.
#[derive(Debug, Default)]
pub struct Encounters {
    motion: MotionWorkspace,
    poses: Workspace,
    sweep: SweepWorkspace,
}

/// Two bodies on their ways.
#[derive(Clone, Copy, Debug)]
pub struct Ways<'p> {
    /// A, in whose frame triangles are tested, and B.
    pub bodies: [BodyView<'p>; 2],
    /// Where they go.
    pub paths: [&'p MotionPath; 2],
}

impl Ways<'_> {
    /// B in A's frame at a time (s).
    #[must_use]
    pub fn pose_at(&self, time_s: f64) -> RelativePose {
        let [a, b] = self.paths.map(|path| path.pose_at(time_s));
        RelativePose::between(&a, &b)
    }

    /// Whether the bodies stay apart in that time because their origins never come as near as both
    /// radii reach.
    pub fn are_far(&self, span_s: &Range<f64>) -> bool {
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

/// Whether one body may lie inside the other at a pose of B in A's frame, as far as a quick look
/// tells.
fn may_be_nested(ways: &Ways<'_>, pose: &RelativePose) -> bool {
    let [a, b] = ways.bodies;
    a.bounds().bounds().overlaps(&pose.bounds(&b.bounds())) && !are_apart(ways.bodies, pose)
}

/// Whether a plane across one of a few directions lies between two bodies; `pose` is that of B in
/// A's frame. Shells are asked only where there is none: that takes longer.
fn are_apart([a, b]: [BodyView<'_>; 2], pose: &RelativePose) -> bool {
    let middle = |bounds: Bounds| (bounds.min + bounds.max) * 0.5;
    let towards = middle(pose.bounds(&b.bounds())) - middle(a.bounds().bounds());
    let mut directions = Directions::around(DVec3::X, DVec3::Z).d;
    // From A to B first: there most planes are.
    directions.sort_unstable_by(|d, e| e.dot(towards).total_cmp(&d.dot(towards)));
    let at = DVec3::from(pose.translation);
    let (mut near_a, mut near_b) = (None, None);
    directions.iter().any(|d| {
        let of_b = support_near(&b, pose.direction_to_b(-*d), &mut near_b) - d.dot(at);
        support_near(&a, *d, &mut near_a) + of_b < -AROUND_M
    })
}

/// The number of a triangle in leaf order, by its source id; 0 if there is none.
fn number_of(body: &BodyView<'_>, id: u32) -> u32 {
    /// Ids of which it is asked first whether it is among them: many are compared at once.
    const TOGETHER: usize = 64;
    let mut parts = body.source_ids.chunks(TOGETHER).enumerate();
    let part = parts.find(|(_, ids)| ids.contains(&id));
    let number = part.and_then(|(part, ids)| {
        ids.iter().position(|known| *known == id).map(|at| part * TOGETHER + at)
    });
    number.unwrap_or(0) as u32
}

/// The distance of the farthest corner of a body's box from its origin (m).
fn radius_m(body: &BodyView<'_>) -> f64 {
    let bounds = body.bounds();
    let far = |axis: usize| f64::from(bounds.min[axis].abs().max(bounds.max[axis].abs()));
    DVec3::new(far(0), far(1), far(2)).length()
}

impl Encounters {
    /// Whether triangles of both touch at a time (s).
    pub fn touch_at(&mut self, ways: &Ways<'_>, time_s: f64) -> bool {
        let [a, b] = ways.bodies;
        // A path keeps poses far within what is accepted.
        touches(a, b, &ways.pose_at(time_s), &mut self.poses).unwrap_or(true)
    }

    /// Whether one body lies wholly inside the other at a time (s), without a triangle that meets
    /// another one; `shells` are those of the bodies.
    pub fn nested(&mut self, ways: &Ways<'_>, shells: [&Shells; 2], time_s: f64) -> Nested {
        let pose = ways.pose_at(time_s);
        if may_be_nested(ways, &pose) { self.hidden(ways, shells, time_s) } else { Nested::No }
    }

    /// [`Encounters::nested`] of bodies that a look has found hidden.
    pub fn hidden(&mut self, ways: &Ways<'_>, shells: [&Shells; 2], time_s: f64) -> Nested {
        let pose = ways.pose_at(time_s);
        let [a, b] = ways.bodies;
        match containment(a, b, shells, &pose, &mut self.poses) {
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

    /// Looks at two bodies, and counts the tests that it takes.
    ///
    /// # Errors
    ///
    /// If `watch` ends it, or there is no such motion.
    pub fn look(
        &mut self,
        look: &Look<'_>,
        watch: QueryWatch<'_>,
    ) -> Result<(LookOutcome, Counters), Unseen> {
        if look.may_touch {
            match self.still(&look.ways, look.from_s, &mut *watch)? {
                Some(touching) => return Ok((LookOutcome::Still(touching), Counters::default())),
                None if may_be_nested(&look.ways, &look.ways.pose_at(look.from_s)) => {
                    return Ok((LookOutcome::Hidden, Counters::default()));
                }
                None => {}
            }
        }
        self.first(look, watch)
    }

    /// The first contact in a span of time.
    fn first(
        &mut self,
        look: &Look<'_>,
        watch: QueryWatch<'_>,
    ) -> Result<(LookOutcome, Counters), Unseen> {
        let Look { ways, from_s, end_s, resolution_m, .. } = look;
        if ways.are_far(&(*from_s..*end_s)) {
            return Ok((LookOutcome::Never, Counters::default()));
        }
        let [path_a, path_b] = ways.paths;
        let motion = RelativeMotion::new(path_a, path_b)
            .and_then(|motion| motion.between(*from_s, *end_s))
            .map_err(|_path_error| Unseen::NoMotion)?;
        let limits = MotionLimits { resolution_m: *resolution_m, budget: u64::MAX };
        let [a, b] = ways.bodies;
        let limits = (&limits, watch);
        let found = first_contact_in_motion_watched(a, b, &motion, limits, &mut self.motion);
        let counters = self.motion.effort().counters;
        let touching = match found {
            Ok(MotionContact::Excluded) => return Ok((LookOutcome::Never, counters)),
            Ok(MotionContact::Certain { time_s, excluded_before_s, ids }) => {
                self.at(ways, (time_s, excluded_before_s), true, ids)
            }
            Ok(MotionContact::Possible { time_s, to_s, ids }) => {
                let middle_s = 0.5 * (time_s + to_s);
                self.at(ways, (middle_s, time_s), false, ids)
            }
            Ok(MotionContact::OutOfBudget { .. }) => return Err(Unseen::Stopped),
            Err(_) => return Err(Unseen::NoMotion),
        };
        Ok((LookOutcome::Contact(touching), counters))
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
        let triangles = [number_of(&a, ids[0]), number_of(&b, ids[1])];
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

    /// The contact of bodies that touch at a time (s), if a triangle does.
    fn still(
        &mut self,
        ways: &Ways<'_>,
        time_s: f64,
        watch: QueryWatch<'_>,
    ) -> Result<Option<Touching>, Unseen> {
        let [a, b] = ways.bodies;
        let pose = ways.pose_at(time_s);
        // A path keeps poses far within what is accepted.
        match least_pair_watched(a, b, &pose, (u64::MAX, watch), &mut self.poses) {
            Ok(ControlFlow::Continue(least)) => {
                Ok(least.map(|ids| self.at(ways, (time_s, time_s), true, ids)))
            }
            Ok(ControlFlow::Break(())) => Err(Unseen::Stopped),
            Err(_) => Err(Unseen::NoMotion),
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

#[cfg(test)]
mod tests;
