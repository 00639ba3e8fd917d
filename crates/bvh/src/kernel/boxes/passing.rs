//! Boxes of which some move along a line: when they overlap, eight against eight, in f32.
//!
//! # Rounding
//!
//! A box in the other frame is enlarged as in [`super`], and by the travel T of the motion, at
//! most, times 8u for where it moves to, and times 2·10⁻⁹ for a component of the direction that is
//! taken as 10⁻⁹ ([`geometry::patch::Inverse`]). A travel is a difference, which that covers, times
//! an inverse that is off by u, rounded once more: travels within the motion are off by 4u·T, and
//! the contact of two triangles by 1 nm. So they are widened by 8u·T and 2 nm.

use super::leaves::cells;
use super::{Frames, lanes};
use body::wide::{LANES, Slab};
use body::{BodyView, WideLeaf, WideNode};
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x8, mask32x8};
use fearless_simd_macros::simd;
use geometry::patch::{Boxes, Choice, Close, Inverse, OneBox, Vector, Window, down, same};
use geometry::patch::{side_by_side, travels, up};
use geometry::{Aabb, DVec3, Patch, Posed, RelativePose, Sweep};

/// Two unit roundings for each of four operations: 8u.
const ROUNDING: f64 = 1.0 / (1 << 21) as f64;

/// Twice the least component of a direction.
const COMPONENT: f64 = 2e-9;

/// Below this component of the motion along its normal, a slab bounds no travel.
const SLAB_ALONG_MIN: f64 = 1e-6;

/// More than the travel of two triangles is off by (m).
const TOLERANCE_M: f64 = 2.0 * geometry::sweep::TOLERANCE_M;

/// The boxes of two bodies, B moving along a line.
#[derive(Clone, Copy, Debug)]
pub(in crate::kernel) struct Passing {
    frames: Frames,
    pose: RelativePose,
    /// The direction in A's frame.
    ahead: DVec3,
    /// The direction in A's frame and in B's.
    directions: [[f32; 3]; 2],
    inverses: [Inverse; 2],
    /// Where the motion begins (m), rounded down.
    from: f32,
    /// What travels are widened by (m).
    tolerance: f32,
}

impl Passing {
    /// `None` if f32 cannot hold the intermediate values: see [`Frames::of`].
    pub(in crate::kernel) fn of(
        a: &BodyView<'_>,
        b: &BodyView<'_>,
        pose: &RelativePose,
        sweep: &Sweep,
    ) -> Option<Self> {
        let longest = sweep.from_m().abs().max(sweep.to_m().abs());
        let frames = Frames::of(a, b, pose)?.slackened(longest * (ROUNDING + COMPONENT));
        let direction = sweep.direction();
        let directions = [direction, pose.direction_to_b(direction)].map(|d| d.to_array());
        Some(Self {
            frames,
            pose: *pose,
            ahead: direction,
            directions: directions.map(|d| d.map(|x| x as f32)),
            inverses: directions.map(Inverse::of),
            from: down(sweep.from_m()),
            tolerance: up(longest * ROUNDING + TOLERANCE_M),
        })
    }

    /// Which boxes of `a` may meet which of `b` up to travel `limit`: bit 8i + j for lane i of A
    /// and lane j of B, among the lanes in use. The travels from when on they may go to `first`.
    #[simd]
    pub(in crate::kernel) fn meet<S: Simd>(
        &self,
        simd: S,
        (a, used_a): (&WideNode, u64),
        (b, used_b): (&WideNode, u64),
        limit: f32,
        first: &mut [f32; LANES * LANES],
    ) -> u64 {
        let (of_a, of_b) = (lanes(simd, a), lanes(simd, b));
        let b_in_a = self.frames.to_a.moved(simd, &of_b);
        let Boxes { min: [x, y, z], max: [u, v, w] } = self.frames.to_b.moved(simd, &of_a);
        let (min, max): ([[f32; LANES]; 3], [[f32; LANES]; 3]) =
            ([x.into(), y.into(), z.into()], [u.into(), v.into(), w.into()]);
        let inverse_a = same(simd, &self.inverses[0].0);
        let inverse_b = same(simd, &self.inverses[1].0);
        let mut meeting = 0;
        let mut open = used_a;
        while open != 0 {
            let lane = open.trailing_zeros() as usize;
            open &= open - 1;
            let times = travels(&one(simd, &a.min, &a.max, lane), &b_in_a, &inverse_a);
            let (here, _) = self.within(simd, times, limit);
            if (here.to_bitmask() & used_b) == 0 {
                continue;
            }
            let [p, q] = travels(&one(simd, &min, &max, lane), &of_b, &inverse_b);
            let (here, begin) = self.within(simd, [times[0].max(p), times[1].min(q)], limit);
            begin.store_slice(&mut first[LANES * lane..][..LANES]);
            meeting |= (here.to_bitmask() & used_b) << (LANES * lane);
        }
        meeting
    }

    /// Which boxes of `a` may meet the one box of B up to travel `limit`, and from when on.
    #[simd]
    pub(in crate::kernel) fn meet_one_of_b<S: Simd>(
        &self,
        simd: S,
        a: &WideNode,
        b: &Aabb,
        limit: f32,
    ) -> (u64, [f32; LANES]) {
        self.meet_lanes(simd, &lanes(simd, a), &Boxes::splat(simd, b), limit)
    }

    /// Which boxes of `b` may meet the one box of A up to travel `limit`, and from when on.
    #[simd]
    pub(in crate::kernel) fn meet_one_of_a<S: Simd>(
        &self,
        simd: S,
        a: &Aabb,
        b: &WideNode,
        limit: f32,
    ) -> (u64, [f32; LANES]) {
        self.meet_lanes(simd, &Boxes::splat(simd, a), &lanes(simd, b), limit)
    }

    #[inline(always)]
    fn meet_lanes<S: Simd>(
        &self,
        simd: S,
        of_a: &Boxes<S>,
        of_b: &Boxes<S>,
        limit: f32,
    ) -> (u64, [f32; LANES]) {
        let inverse_a = same(simd, &self.inverses[0].0);
        let inverse_b = same(simd, &self.inverses[1].0);
        let [p, q] = travels(of_a, &self.frames.to_a.moved(simd, of_b), &inverse_a);
        let [r, s] = travels(&self.frames.to_b.moved(simd, of_a), of_b, &inverse_b);
        let (here, begin) = self.within(simd, [p.max(r), q.min(s)], limit);
        (here.to_bitmask(), begin.into())
    }

    /// Which of these travels lie within the motion and before `limit`, and when they begin.
    #[inline(always)]
    fn within<S: Simd>(
        &self,
        _simd: S,
        [first, last]: [f32x8<S>; 2],
        limit: f32,
    ) -> (mask32x8<S>, f32x8<S>) {
        let (first, last) = (first - self.tolerance, last + self.tolerance);
        (first.simd_le(last) & first.simd_le(limit) & last.simd_ge(self.from), first)
    }

    /// From when to when two boxes may meet (m), each of its own frame; never if the end is before
    /// the begin.
    pub(in crate::kernel) fn travels_of(&self, a: &Aabb, b: &Aabb) -> [f32; 2] {
        let b_in_a = self.frames.to_a.moved_plainly(b);
        let a_in_b = self.frames.to_b.moved_plainly(a);
        let [mut first, mut last] = [f32::NEG_INFINITY, f32::INFINITY];
        let frames = [(a, &b_in_a, &self.inverses[0]), (&a_in_b, b, &self.inverses[1])];
        for (a, b, Inverse(inverse)) in frames {
            for (k, inverse) in inverse.iter().enumerate() {
                let (p, q) = ((a.min[k] - b.max[k]) * inverse, (a.max[k] - b.min[k]) * inverse);
                (first, last) = (first.max(p.min(q)), last.min(p.max(q)));
            }
        }
        [first - self.tolerance, last + self.tolerance]
    }

    /// From when to when each of two leaves may meet the slab of the other (m), within two travels:
    /// patches of a surface that is oblique to all axes come near each other much later than their
    /// boxes.
    pub(in crate::kernel) fn slabs_travels(
        &self,
        a: &WideLeaf,
        b: &WideLeaf,
        [mut first, mut last]: [f64; 2],
    ) -> [f64; 2] {
        let RelativePose { rotation: [p, q, r], translation } = self.pose;
        let (p, q, r) = (DVec3::from_array(p), DVec3::from_array(q), DVec3::from_array(r));
        let shift = DVec3::from_array(translation);
        let normal = |slab: &Slab| DVec3::from_array(slab.normal.map(f64::from));
        let reach = |bounds: &Aabb, normal: DVec3| {
            let bounds = bounds.bounds();
            let (middle, half) = ((bounds.min + bounds.max) * 0.5, (bounds.max - bounds.min) * 0.5);
            [normal.dot(middle), normal.abs().dot(half)]
        };
        // What B's leaf reaches along the normal of A's slab, and A's along that of B's, which
        // moves.
        let of_a = normal(&a.slab);
        let [middle, half] = reach(&b.bounds, p * of_a.x + q * of_a.y + r * of_a.z);
        let middle = middle + of_a.dot(shift);
        let (low, high) = (f64::from(a.slab.low), f64::from(a.slab.high));
        let meets_a = [low - middle - half, high - middle + half, of_a.dot(self.ahead)];
        let own = normal(&b.slab);
        let of_b = DVec3::new(p.dot(own), q.dot(own), r.dot(own));
        let [middle, half] = reach(&a.bounds, of_b);
        let middle = middle - of_b.dot(shift);
        let (low, high) = (f64::from(b.slab.low), f64::from(b.slab.high));
        let meets_b = [middle - half - high, middle + half - low, of_b.dot(self.ahead)];
        for [least, most, along] in [meets_a, meets_b] {
            // A slab along the motion is met at all travels, or at none.
            if along.abs() < SLAB_ALONG_MIN {
                continue;
            }
            let inverse = 1.0 / along;
            let (p, q) =
                ((least - self.frames.slack) * inverse, (most + self.frames.slack) * inverse);
            (first, last) = (first.max(p.min(q)), last.min(p.max(q)));
        }
        let tolerance = f64::from(self.tolerance);
        [first - tolerance, last + tolerance]
    }

    /// Adds those triangles of two leaves that may meet one of the other leaf between two travels
    /// (m) to patches; `None` if there are none. `posed` is B's pose at the first of these.
    #[simd]
    pub(in crate::kernel) fn pack<S: Simd>(
        &self,
        simd: S,
        posed: &Posed<'_>,
        (a, b): (&[WideLeaf], &[WideLeaf]),
        [begin_m, end_m]: [f64; 2],
        sweep: &Sweep,
        (patch_a, patch_b): (&mut Patch, &mut Patch),
    ) -> Option<(Close, Window)> {
        let Frames { to_a, to_b, slack } = &self.frames;
        let (box_a, box_b) = (OneBox::of(simd, &a[0].bounds), OneBox::of(simd, &b[0].bounds));
        let [ahead_a, ahead_b] = self.directions;
        // What B's leaf meets of A's lies in this box.
        let passed = swept(simd, &to_a.moved_one(simd, &box_b), &ahead_a, [begin_m, end_m]);
        let common = passed.intersection(&box_a);
        if common.is_empty() {
            return None;
        }
        // Seen from B, A moves the other way.
        let seen = swept(simd, &to_b.moved_one(simd, &common), &ahead_b, [-begin_m, -end_m]);
        let of_b = cells(simd, b, &seen);
        if of_b.is_empty() {
            return None;
        }
        patch_b.want_b(simd, posed, b[0].first, &of_b);
        let close = posed.close(&a[0].bounds, &b[0].bounds);
        let window = Window::new(&sweep.until(end_m), begin_m, &close);
        let origin = side_by_side(simd, close.origin());
        let target = common.moved(-origin).spread(simd);
        let choice = Approaching { simd, window: &window, target };
        let boxes = patch_b.take_b(simd, (posed, &close), &choice).all(simd);
        if patch_b.triangles().is_empty() {
            return None;
        }
        let passed = swept(simd, &boxes, &ahead_a, [0.0, end_m - begin_m]);
        let in_a = passed.moved(origin).enlarged(*slack as f32).intersection(&common);
        let of_a = cells(simd, a, &in_a);
        if of_a.is_empty() {
            return None;
        }
        patch_a.want_a(simd, posed, a[0].first, &of_a);
        let choice = Approached { simd, window: &window, comer: boxes.spread(simd) };
        patch_a.take_a(simd, (posed, &close), &choice);
        (!patch_a.triangles().is_empty()).then_some((close, window))
    }
}

/// All that a box passes as it moves between two travels, up to rounding.
#[inline(always)]
fn swept<S: Simd>(
    simd: S,
    OneBox { min, max }: &OneBox<S>,
    direction: &[f32; 3],
    [p, q]: [f64; 2],
) -> OneBox<S> {
    let ahead = side_by_side(simd, *direction);
    let (p, q) = (ahead * (p as f32), ahead * (q as f32));
    OneBox { min: *min + p.min(q), max: *max + p.max(q) }
}

/// A box of a node, repeated eight times.
#[inline(always)]
fn one<S: Simd>(
    simd: S,
    [u, v, w]: &[[f32; LANES]; 3],
    [x, y, z]: &[[f32; LANES]; 3],
    lane: usize,
) -> Boxes<S> {
    Boxes {
        min: same(simd, &[u[lane], v[lane], w[lane]]),
        max: same(simd, &[x[lane], y[lane], z[lane]]),
    }
}

/// The triangles of B that meet a box of A on their way.
struct Approaching<'w, S: Simd> {
    simd: S,
    window: &'w Window,
    target: Boxes<S>,
}

impl<S: Simd> Choice<S> for Approaching<'_, S> {
    #[inline(always)]
    fn of(&self, _: &[Vector<S>; 3], boxes: &Boxes<S>) -> mask32x8<S> {
        self.window.meet(self.simd, &self.target, boxes).0
    }
}

/// The triangles of A that a box of B meets on its way.
struct Approached<'w, S: Simd> {
    simd: S,
    window: &'w Window,
    comer: Boxes<S>,
}

impl<S: Simd> Choice<S> for Approached<'_, S> {
    #[inline(always)]
    fn of(&self, _: &[Vector<S>; 3], boxes: &Boxes<S>) -> mask32x8<S> {
        self.window.meet(self.simd, boxes, &self.comer).0
    }
}
