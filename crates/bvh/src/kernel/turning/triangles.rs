//! Triangles of two leaves in an interval: whether any may touch, and at last whether any do.

use super::{First, Frame, Possible, Search, TurningTask};
use crate::descent::side_to_open;
use body::Node;
use geometry::motion::TimeInterval;
use geometry::{Triangle, triangle};
use std::ops::ControlFlow;

/// Maximum number of open pairs among which an earlier touch is sought by bisection.
const TOUCHING_MAX: usize = 1 << 12;

/// Steps of that bisection: an interval of 1 mm is resolved to 1 nm.
const BISECTIONS: u32 = 20;

/// What the open pairs of a short interval say.
#[derive(Clone, Copy, Debug, Default)]
struct Verdict {
    /// The earliest exact touch, and whose.
    touch: Option<(f64, [u32; 2])>,
    /// The least source ids of an open pair.
    ids: Option<[u32; 2]>,
    /// The number of open pairs: that, too, depends on triangles alone.
    count: usize,
}

impl Verdict {
    /// Takes an open pair of triangles, by their numbers in leaf order.
    fn take(&mut self, task: &TurningTask<'_>, interval: &TimeInterval, pair: [u32; 2]) {
        let ids = task.ids(pair);
        self.count += 1;
        self.ids = Some(self.ids.map_or(ids, |least| least.min(ids)));
        let [a, b] = task.corners(pair);
        let until_s = self.touch.map_or(f64::INFINITY, |(time_s, _)| time_s);
        let touch = interval.first_touch(&task.motion, a, b, until_s);
        self.touch = touch.map(|time_s| (time_s, ids)).or(self.touch);
    }
}

impl Search<'_, '_> {
    /// Decides a short interval.
    pub(super) fn decide(&mut self, Frame { interval, begin, .. }: &Frame) -> ControlFlow<First> {
        self.kernel.open.clear();
        self.kernel.touching.clear();
        let mut verdict = Verdict::default();
        for at in begin[0]..begin[1] {
            self.kernel.open.push(self.kernel.pairs[at]);
            while let Some(pair) = self.kernel.open.pop() {
                self.check_budget(interval)?;
                let Some((a, b)) = self.meeting(interval, pair) else { continue };
                match side_to_open(a, a.is_leaf(), b, b.is_leaf()) {
                    Some(side) => self.open(pair, side, (a, b)),
                    None => self.judge(interval, (a, b), &mut verdict),
                }
            }
        }
        let possible = self.possible;
        match verdict {
            Verdict { touch: Some(touch), count, .. } => {
                let (time_s, ids) = match count {
                    0..=TOUCHING_MAX => self.earlier(interval.from_s, touch),
                    _ => touch,
                };
                let clear_before_s = possible.map_or(interval.from_s, |possible| possible.from_s);
                return ControlFlow::Break(First::Certain { time_s, clear_before_s, ids });
            }
            Verdict { ids: Some(ids), .. } if possible.is_none() => {
                let (from_s, to_s) = (interval.from_s, interval.to_s);
                self.possible = Some(Possible { from_s, to_s, ids });
            }
            Verdict { .. } => {}
        }
        ControlFlow::Continue(())
    }

    /// An earlier touch of the open pairs, by bisection between a time and that of a touch.
    fn earlier(
        &mut self,
        mut from_s: f64,
        (mut to_s, mut ids): (f64, [u32; 2]),
    ) -> (f64, [u32; 2]) {
        let task = self.task;
        let pairs = &mut self.kernel.touching;
        for step in 0..=BISECTIONS {
            // First, which pairs touch at the time that is known.
            let time_s = if step == 0 { to_s } else { from_s + (to_s - from_s) * 0.5 };
            if !(from_s < time_s && time_s <= to_s) {
                break;
            }
            let pose = task.motion.pose_at(time_s);
            let touch = |pair: &[u32; 2]| {
                let [a, b] = task.corners(*pair);
                triangle::intersect(&Triangle::stored(a), &pose.triangle(b))
            };
            if !pairs.iter().any(touch) {
                from_s = time_s;
                continue;
            }
            pairs.retain(touch);
            (to_s, ids) = (time_s, pairs.iter().map(|pair| task.ids(*pair)).min().unwrap_or(ids));
        }
        (to_s, ids)
    }

    /// Whether any pair of triangles of two leaves may touch in the interval.
    pub(super) fn any_open(&mut self, interval: &TimeInterval, leaves: (&Node, &Node)) -> bool {
        let stop = |_: &mut Self, _: [u32; 2]| ControlFlow::Break(());
        self.each_open(interval, leaves, stop).is_break()
    }

    /// Takes the pairs of triangles of two leaves that are open in a short interval: not apart in
    /// it nor in any that contains it.
    fn judge(&mut self, interval: &TimeInterval, leaves: (&Node, &Node), verdict: &mut Verdict) {
        let _all = self.each_open(interval, leaves, |search, [a, b]| {
            let task = search.task;
            let [of_a, of_b] = task.corners([a, b]);
            if !interval.are_apart(of_a, of_b, &interval.moved_b(of_b)) {
                verdict.take(task, interval, [a, b]);
                if search.kernel.touching.len() < TOUCHING_MAX {
                    search.kernel.touching.push([a, b]);
                }
            }
            ControlFlow::Continue(())
        });
    }

    fn each_open(
        &mut self,
        interval: &TimeInterval,
        (a, b): (&Node, &Node),
        mut each: impl FnMut(&mut Self, [u32; 2]) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let task = self.task;
        let box_a = a.bounds.bounds();
        for of_b in b.link..b.link + b.count {
            let corners_b = &task.b.corners[of_b as usize];
            let moved = interval.moved_b(corners_b);
            self.counters.nb += 1;
            if !moved.bounds.overlaps(&box_a) {
                continue;
            }
            for of_a in a.link..a.link + a.count {
                self.counters.np += 1;
                if !interval.are_clearly_apart(&task.a.corners[of_a as usize], corners_b, &moved) {
                    each(self, [of_a, of_b])?;
                }
            }
        }
        ControlFlow::Continue(())
    }
}
