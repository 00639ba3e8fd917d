//! A short time of a motion: where boxes and triangles may be meanwhile.

use super::{PathPiece, RelativeMotion};
use crate::{Aabb, Bounds, Corners, DVec3, RelativePose};

/// Two bodies as far as their motion needs to know them: the boxes that they lie in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MovingBodies {
    /// How far their points are from the origins of their frames, at most (m).
    reaches: [f64; 2],
    /// The middles of the boxes, and how far their points are from there, at most (m).
    middles: [DVec3; 2],
    radii: [f64; 2],
    /// B's box.
    box_b: Aabb,
    /// What every position may be off by (m): see [`MovingBodies::new`].
    slack_m: f64,
}

/// The motion between two times of one piece, and how far it is from straight meanwhile.
///
/// The halves of an interval, and theirs, form a tree over each piece of a motion. It is always the
/// same, so whatever is decided for its intervals is a function of the motion and the bodies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimeInterval {
    /// Its begin (s).
    pub from_s: f64,
    /// Its end (s).
    pub to_s: f64,
    /// B in A's frame, at the begin and at the end.
    poses: [RelativePose; 2],
    /// A in B's frame.
    backs: [RelativePose; 2],
    /// What moves boxes of B, and of A, in the same way.
    movers: [[Mover; 2]; 2],
    /// What points of B are off their chords by in A's frame, at most, and points of A in B's (m).
    margins_m: [f64; 2],
    /// How far any point of B's box moves, at most, as seen from A (m).
    travel_m: f64,
    /// How far the spheres around the bodies are apart all the time, at least (m).
    distance_m: f64,
    /// What every position may be off by (m).
    slack_m: f64,
}

/// A triangle at the begin and at the end of an interval, in the frame of the other body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moved {
    /// Its corners, at the begin and at the end (m).
    pub(super) ends: [[DVec3; 3]; 2],
    /// All that it may pass meanwhile.
    pub bounds: Bounds,
}

/// In tests that also hold within parts of the interval, this many times the rounding is allowed
/// for.
const LONGER: f64 = 4.0;

/// 256 ε.
const ROUNDING: f64 = 256.0 * f64::EPSILON;

impl MovingBodies {
    /// MovingBodies within these boxes, each in its own frame, that move in this way.
    ///
    /// A rotation matrix computed for a time is off by about 20ε: in the angle, its sine and
    /// cosine, a product of quaternions, and squares. The product of two is off by 50ε, a point
    /// that it turns by less than 100ε times the sum S of all magnitudes: positions, extents, and
    /// what a time that is off by ε moves. Products with a separating axis add some 10ε. 256ε·S are
    /// allowed.
    #[must_use]
    pub fn new(motion: &RelativeMotion<'_>, boxes: [&Aabb; 2]) -> Self {
        let sides = boxes.map(Aabb::bounds);
        let reaches = sides.map(|b| b.min.abs().max(b.max.abs()).element_sum());
        let slack_m = ROUNDING * motion.magnitude_m(reaches);
        Self {
            reaches: sides.map(|b| b.min.abs().max(b.max.abs()).length()),
            middles: sides.map(|b| (b.min + b.max) * 0.5),
            radii: sides.map(|b| (b.max - b.min).length() * 0.5),
            box_b: *boxes[1],
            slack_m,
        }
    }
}

impl TimeInterval {
    /// The whole of a piece.
    #[must_use]
    pub fn of(motion: &RelativeMotion<'_>, bodies: &MovingBodies, piece: &PathPiece) -> Self {
        Self::within(motion, bodies, piece, [piece.from_s, piece.to_s])
    }

    /// Its halves; `None` if no time lies between its begin and its end.
    #[must_use]
    pub fn halves(
        &self,
        motion: &RelativeMotion<'_>,
        bodies: &MovingBodies,
        piece: &PathPiece,
    ) -> Option<[Self; 2]> {
        let middle_s = self.from_s + (self.to_s - self.from_s) * 0.5;
        let is_between = self.from_s < middle_s && middle_s < self.to_s;
        is_between.then(|| {
            [[self.from_s, middle_s], [middle_s, self.to_s]]
                .map(|times| Self::within(motion, bodies, piece, times))
        })
    }

    fn within(
        motion: &RelativeMotion<'_>,
        bodies: &MovingBodies,
        piece: &PathPiece,
        times: [f64; 2],
    ) -> Self {
        let worlds = times.map(|time_s| motion.poses_at(time_s));
        let poses = worlds.map(|[a, b]| RelativePose::between(&a, &b));
        let backs = poses.map(|pose| reversed(&pose));
        let lasts_s = times[1] - times[0];
        // An eighth, and a third more: see the module documentation.
        let bend = lasts_s * lasts_s * (0.125 * 4.0 / 3.0);

        let [rate_a, rate_b] = piece.rates;
        let rate = rate_b - rate_a;
        let turning = rate.length_squared() + rate_a.cross(rate_b).length();
        let between = worlds
            .map(|[a, b]| DVec3::from_array(b.translation) - DVec3::from_array(a.translation));
        let moving = |rate: DVec3| {
            let at =
                |y: DVec3| (rate.cross(rate.cross(y)) - rate.cross(piece.velocity) * 2.0).length();
            at(between[0]).max(at(between[1]))
        };
        let margin = |reach: f64, rate: DVec3| (turning * reach + moving(rate)) * bend;
        let [reach_a, reach_b] = bodies.reaches;
        let slack_m = bodies.slack_m;
        let margins_m = [margin(reach_b, rate_a) + slack_m, margin(reach_a, rate_b) + slack_m];

        let Bounds { min, max } = bodies.box_b.bounds();
        let corner = |k: usize, pose: &RelativePose| {
            let side = |bit: usize, low: f64, high: f64| if k & bit == 0 { low } else { high };
            turned(
                pose,
                DVec3::new(side(1, min.x, max.x), side(2, min.y, max.y), side(4, min.z, max.z)),
            )
        };
        // The displacement is convex in the point: it is greatest at a corner of the box.
        let travel_m = (0..8)
            .map(|k| (corner(k, &poses[1]) - corner(k, &poses[0])).length())
            .fold(0.0, f64::max);

        Self {
            from_s: times[0],
            to_s: times[1],
            movers: [poses.map(|pose| Mover::of(&pose)), backs.map(|pose| Mover::of(&pose))],
            backs,
            poses,
            margins_m,
            travel_m: travel_m + 2.0 * margins_m[0],
            distance_m: distance_m(bodies, &worlds, piece, bend),
            slack_m,
        }
    }

    /// How far any point of B may move meanwhile, as seen from A (m).
    #[must_use]
    pub fn travel_m(&self) -> f64 {
        self.travel_m
    }

    /// Whether the bodies are apart all the time because the spheres around them are.
    #[must_use]
    pub fn is_far(&self) -> bool {
        self.distance_m > LONGER * self.slack_m
    }

    /// The same up to less rounding: it holds in an interval if [`TimeInterval::is_far`] does in
    /// one that contains it.
    pub(super) fn is_just_far(&self) -> bool {
        self.distance_m > self.slack_m
    }

    /// The margins of tests that also hold within parts of the interval (m).
    pub(super) fn lasting_margins_m(&self) -> [f64; 2] {
        self.margins_m.map(|margin_m| margin_m + (LONGER - 1.0) * self.slack_m)
    }

    /// Whether the interval is short enough not to be divided further: nothing moves by more than
    /// `resolution_m` meanwhile, whatever it leaves in doubt included.
    #[must_use]
    pub fn is_short(&self, resolution_m: f64) -> bool {
        self.travel_m + 2.0 * (self.margins_m[0] + self.margins_m[1]) <= resolution_m
    }

    /// B in A's frame, at the begin and at the end.
    #[must_use]
    pub fn poses(&self) -> &[RelativePose; 2] {
        &self.poses
    }

    /// What points of B are off their chords by in A's frame, at most, and points of A in B's (m).
    #[must_use]
    pub fn margins_m(&self) -> [f64; 2] {
        self.margins_m
    }

    /// A box in A's frame that contains all that a box of B passes.
    #[must_use]
    #[inline]
    pub fn bounds_of_b(&self, box_: &Aabb) -> Bounds {
        self.bounds_of(0, box_)
    }

    /// A box in B's frame that contains all that a box of A passes.
    #[must_use]
    #[inline]
    pub fn bounds_of_a(&self, box_: &Aabb) -> Bounds {
        self.bounds_of(1, box_)
    }

    /// Once more than for triangles, rounding is allowed for: so their bounds lie within.
    #[inline]
    fn bounds_of(&self, body: usize, box_: &Aabb) -> Bounds {
        let box_ = box_.bounds();
        let (middle, half) = ((box_.min + box_.max) * 0.5, (box_.max - box_.min) * 0.5);
        let margin_m = self.margins_m[body] + LONGER * self.slack_m;
        let [p, q] = self.movers[body].each_ref().map(|mover| mover.moved(middle, half));
        hull(&p, &q, margin_m)
    }

    /// A triangle of B, in A's frame. Its bounds lie within those of every box that it lies in.
    #[must_use]
    #[inline]
    pub fn moved_b(&self, corners: &Corners) -> Moved {
        Moved::of(&self.poses, corners, self.lasting_margins_m()[0])
    }

    /// A triangle of A, in B's frame. Its bounds lie within those of every box that it lies in.
    #[must_use]
    #[inline]
    pub fn moved_a(&self, corners: &Corners) -> Moved {
        Moved::of(&self.backs, corners, self.lasting_margins_m()[1])
    }
}

/// A pose as columns, which suit boxes.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Mover {
    columns: [DVec3; 3],
    magnitudes: [DVec3; 3],
    shift: DVec3,
}

impl Mover {
    fn of(pose: &RelativePose) -> Self {
        let r = &pose.rotation;
        let columns = [0, 1, 2].map(|k| DVec3::new(r[0][k], r[1][k], r[2][k]));
        let shift = DVec3::from_array(pose.translation);
        Self { columns, magnitudes: columns.map(DVec3::abs), shift }
    }

    /// The box around a box given by its middle and half its extents, up to rounding.
    #[inline]
    fn moved(&self, middle: DVec3, half: DVec3) -> Bounds {
        let [p, q, r] = &self.columns;
        let middle = (*p * middle.x + *q * middle.y) + (*r * middle.z + self.shift);
        let [p, q, r] = &self.magnitudes;
        let reach = (*p * half.x + *q * half.y) + *r * half.z;
        Bounds { min: middle - reach, max: middle + reach }
    }
}

impl Moved {
    #[inline]
    fn of(poses: &[RelativePose; 2], corners: &Corners, margin_m: f64) -> Self {
        let ends = poses.map(|pose| pose.triangle(corners));
        let bounds = hull(&ends[0].bounds(), &ends[1].bounds(), margin_m);
        Self { ends: ends.map(|end| end.0), bounds }
    }
}

/// What is passed between two boxes along chords, enlarged by a margin (m).
#[inline]
fn hull(p: &Bounds, q: &Bounds, margin_m: f64) -> Bounds {
    Bounds { min: p.min.min(q.min) - margin_m, max: p.max.max(q.max) + margin_m }
}

/// A point of B in A's frame, up to rounding.
fn turned(pose: &RelativePose, p: DVec3) -> DVec3 {
    let [x, y, z] = pose.rotation.map(DVec3::from_array);
    DVec3::new(x.dot(p), y.dot(p), z.dot(p)) + DVec3::from_array(pose.translation)
}

/// The pose of A in B's frame: Rᵀ and −Rᵀt.
fn reversed(pose: &RelativePose) -> RelativePose {
    let (r, t) = (&pose.rotation, &pose.translation);
    RelativePose {
        rotation: core::array::from_fn(|i| [r[0][i], r[1][i], r[2][i]]),
        translation: core::array::from_fn(|i| -(r[0][i] * t[0] + r[1][i] * t[1] + r[2][i] * t[2])),
    }
}

/// How far the spheres around both boxes are apart all the time, at least (m); negative if they may
/// overlap.
///
/// The way from A's middle to B's, in the world, is a line but for what the middles turn about the
/// origins: |x″| ≤ |ωa|² |a| + |ωb|² |b|.
fn distance_m(
    bodies: &MovingBodies,
    worlds: &[[crate::Pose; 2]; 2],
    piece: &PathPiece,
    bend: f64,
) -> f64 {
    let ways = worlds.map(|poses| {
        let [a, b] = [0, 1].map(|k| {
            let crate::Pose { rotation, translation } = poses[k];
            turned(&RelativePose { rotation, translation }, bodies.middles[k])
        });
        b - a
    });
    let turning = [0, 1].map(|k| piece.rates[k].length_squared() * bodies.middles[k].length());
    let margin_m = (turning[0] + turning[1]) * bend;
    let along = ways[1] - ways[0];
    let length = along.dot(along);
    let share = if length > 0.0 { (-ways[0].dot(along) / length).clamp(0.0, 1.0) } else { 0.0 };
    (ways[0] + along * share).length() - (bodies.radii[0] + bodies.radii[1] + margin_m)
}
