//! A short time of a motion: where boxes and triangles may be meanwhile.

use super::{PathPiece, RelativeMotion};
use crate::{Aabb, Bounds, Corners, DVec3, Pose, RelativePose};
use glam::Vec3A;

/// Two bodies as far as their motion needs to know them: the boxes that they lie in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MovingBodies {
    /// How far their points are from the origins of their frames, at most (m).
    reaches: [f64; 2],
    /// The same as the sum of the coordinates' magnitudes (m).
    sums: [f64; 2],
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
    /// Both in the world, at the begin and at the end.
    worlds: [[Pose; 2]; 2],
    /// B in A's frame.
    poses: [RelativePose; 2],
    /// A in B's frame.
    backs: [RelativePose; 2],
    /// What moves boxes of B, and of A, in the same way.
    pub(super) movers: [Movers; 2],
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
        let sums = sides.map(|b| b.min.abs().max(b.max.abs()).element_sum());
        let slack_m = ROUNDING * motion.magnitude_m(sums);
        Self {
            reaches: sides.map(|b| b.min.abs().max(b.max.abs()).length()),
            sums,
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
        let times = [piece.from_s, piece.to_s];
        Self::within(bodies, piece, times, &times.map(|time_s| motion.poses_at(time_s)))
    }

    /// The time that divides it (s); `None` if none lies between its begin and its end.
    #[must_use]
    pub fn middle_s(&self) -> Option<f64> {
        let middle_s = self.from_s + (self.to_s - self.from_s) * 0.5;
        (self.from_s < middle_s && middle_s < self.to_s).then_some(middle_s)
    }

    /// Its halves, if there is a [middle](TimeInterval::middle_s).
    #[must_use]
    pub fn halves(
        &self,
        motion: &RelativeMotion<'_>,
        bodies: &MovingBodies,
        piece: &PathPiece,
    ) -> Option<[Self; 2]> {
        self.middle_s().map(|middle_s| {
            let ([begin, end], middle) = (self.worlds, motion.poses_at(middle_s));
            [
                Self::within(bodies, piece, [self.from_s, middle_s], &[begin, middle]),
                Self::within(bodies, piece, [middle_s, self.to_s], &[middle, end]),
            ]
        })
    }

    /// Between these times, at which both are at `worlds`.
    fn within(
        bodies: &MovingBodies,
        piece: &PathPiece,
        times: [f64; 2],
        worlds: &[[Pose; 2]; 2],
    ) -> Self {
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
            movers: [
                Movers::new(&poses, margins_m[0] + LONGER * slack_m, bodies.sums[1]),
                Movers::new(&backs, margins_m[1] + LONGER * slack_m, bodies.sums[0]),
            ],
            worlds: *worlds,
            backs,
            poses,
            margins_m,
            travel_m: travel_m + 2.0 * margins_m[0],
            distance_m: distance_m(bodies, worlds, piece, bend),
            slack_m,
        }
    }

    /// How long it is (s).
    #[must_use]
    pub fn lasts_s(&self) -> f64 {
        self.to_s - self.from_s
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

    /// Whether a box of A and a box of B may overlap at any time.
    ///
    /// They may if those of two triangles within them may: [`TimeInterval::moved_b`] and
    /// [`TimeInterval::moved_a`].
    #[must_use]
    #[inline]
    pub fn may_meet(&self, a: &Aabb, b: &Aabb) -> bool {
        let [of_b, of_a] = &self.movers;
        of_b.may_reach(b, a) && of_a.may_reach(a, b)
    }

    /// A triangle of B, in A's frame.
    #[must_use]
    #[inline]
    pub fn moved_b(&self, corners: &Corners) -> Moved {
        Moved::of(&self.poses, corners, self.lasting_margins_m()[0])
    }

    /// A triangle of A, in B's frame.
    #[must_use]
    #[inline]
    pub fn moved_a(&self, corners: &Corners) -> Moved {
        Moved::of(&self.backs, corners, self.lasting_margins_m()[1])
    }
}

/// Moves boxes of one body into the frame of the other, in single precision: there are many more
/// tests of boxes than of triangles, and what they leave is tested again.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Movers {
    pub(super) ends: [Mover; 2],
    /// By how much the hull of what a box passes is enlarged (m), rounding included.
    pub(super) margin_m: Vec3A,
}

impl Movers {
    /// For boxes with coordinates of these magnitudes in sum (m), which are off their chords by
    /// `margin_m` at most.
    ///
    /// A coordinate is a sum of seven products of numbers that are each off by u = 2⁻²⁴ of
    /// themselves: middles, extents, rotation and shift. With the roundings on the way it is off by
    /// less than 8u times the sum of all magnitudes. 16u are allowed, and so the margin, and the
    /// last additions, may be rounded, too. Where a sum might overflow, no box is told apart.
    fn new(poses: &[RelativePose; 2], margin_m: f64, sum: f64) -> Self {
        const UNIT: f64 = 1.0 / (1 << 24) as f64;
        const MAGNITUDE_MAX: f64 = 1e36;
        let shifts = poses.iter().flat_map(|pose| pose.translation).map(f64::abs);
        let magnitude = shifts.fold(0.0, f64::max) + sum + margin_m;
        let margin_m = if magnitude <= MAGNITUDE_MAX {
            (margin_m + 16.0 * UNIT * magnitude) as f32 + f32::MIN_POSITIVE
        } else {
            f32::INFINITY
        };
        Self { ends: poses.map(|pose| Mover::of(&pose)), margin_m: Vec3A::splat(margin_m) }
    }

    /// Whether `moving`, a box of the body that moves, may overlap `still` at any time.
    #[inline]
    fn may_reach(&self, moving: &Aabb, still: &Aabb) -> bool {
        let [min, max] = self.passed(moving);
        let [least, most] = [still.min, still.max].map(Vec3A::from_array);
        // What is no number is apart from nothing.
        !(min.cmpgt(most) | max.cmplt(least)).any()
    }

    /// The least and greatest coordinates of all that a box passes.
    #[inline]
    pub(super) fn passed(&self, moving: &Aabb) -> [Vec3A; 2] {
        let [min, max] = [moving.min, moving.max].map(Vec3A::from_array);
        let (middle, half) = ((min + max) * 0.5, (max - min) * 0.5);
        let [p, q] = self.ends.each_ref().map(|mover| mover.moved(middle, half));
        [p[0].min(q[0]) - self.margin_m, p[1].max(q[1]) + self.margin_m]
    }
}

/// A pose as columns, which suit boxes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Mover {
    columns: [Vec3A; 3],
    shift: Vec3A,
}

impl Mover {
    fn of(pose: &RelativePose) -> Self {
        let single = |v: [f64; 3]| Vec3A::from_array(v.map(|x| x as f32));
        let r = &pose.rotation;
        let columns = [0, 1, 2].map(|k| single([r[0][k], r[1][k], r[2][k]]));
        Self { columns, shift: single(pose.translation) }
    }

    /// The box around a box given by its middle and half its extents, up to rounding.
    #[inline]
    fn moved(&self, middle: Vec3A, half: Vec3A) -> [Vec3A; 2] {
        let (middle, reach) = self.placed(middle, half);
        [middle - reach, middle + reach]
    }

    /// The same by its middle and half its extents.
    #[inline]
    pub(super) fn placed(&self, middle: Vec3A, half: Vec3A) -> (Vec3A, Vec3A) {
        let [p, q, r] = self.columns;
        // Written out, nothing is fused: on every machine the same boxes are opened.
        let middle = (p * middle.x + q * middle.y) + (r * middle.z + self.shift);
        let reach = (p.abs() * half.x + q.abs() * half.y) + r.abs() * half.z;
        (middle, reach)
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
fn distance_m(bodies: &MovingBodies, worlds: &[[Pose; 2]; 2], piece: &PathPiece, bend: f64) -> f64 {
    let ways = worlds.map(|poses| {
        let [a, b] = [0, 1].map(|k| {
            let Pose { rotation, translation } = poses[k];
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
