//! Room for labels in the plan view: texts that cover neither each other nor what is marked.

use super::drawing::{PlanWindow, WIDTH};
use trolley::plan::PlanSample;

/// Room for a line of text and for a letter: the greater of the two sizes in `plan.css`.
const LINE: f64 = 26.0;
const LETTER: f64 = 12.0;
/// What of a line is under the base line.
pub(super) const UNDER: f64 = 6.0;

/// Rectangles that are taken: left, top, right, bottom.
#[derive(Clone, Debug, Default)]
pub(super) struct TakenRoom {
    taken: Vec<[f64; 4]>,
    /// What had better be left free.
    avoided: Vec<[f64; 4]>,
}

impl TakenRoom {
    /// The first free place near a point for a text, taken from then on: its left end and its base
    /// line. `None`: all are taken or outside.
    pub(super) fn place(
        &mut self,
        window: &PlanWindow,
        at: [f64; 2],
        text: &str,
    ) -> Option<[f64; 2]> {
        let [left, _, _, bottom] = self.placed(window, at, text)?;
        Some([left, bottom - UNDER])
    }

    /// The rectangle of [`TakenRoom::place`].
    pub(super) fn placed(
        &mut self,
        window: &PlanWindow,
        [x, y]: [f64; 2],
        text: &str,
    ) -> Option<[f64; 4]> {
        let width = width(text);
        let tries = (1..=7).flat_map(|ring| {
            let up = 16.0 + LINE * f64::from(ring - 1);
            [-up, up + LINE - 8.0]
                .into_iter()
                .flat_map(move |dy| [12.0, -12.0 - width, -0.5 * width].map(|dx| [x + dx, y + dy]))
        });
        self.first_free(window, tries.map(|[left, base]| rectangle([left, base], width)))
    }

    /// The first free place right beside a mark on the ego's way: its left end and its base line.
    pub(super) fn place_beside(
        &mut self,
        window: &PlanWindow,
        [x, y]: [f64; 2],
        text: &str,
    ) -> Option<[f64; 2]> {
        let width = width(text);
        let tries = [
            [x - 0.5 * width, y + LINE],
            [x - 0.5 * width, y - 12.0],
            [x + 10.0, y + 8.0],
            [x - 10.0 - width, y + 8.0],
        ];
        let tries = tries.into_iter().map(|at| rectangle(at, width));
        let [left, _, _, bottom] = self.first_free(window, tries)?;
        Some([left, bottom - UNDER])
    }

    /// The first of these that is free and inside, taken from then on. What is avoided is covered
    /// if there is no other way.
    fn first_free(
        &mut self,
        window: &PlanWindow,
        tries: impl Iterator<Item = [f64; 4]> + Clone,
    ) -> Option<[f64; 4]> {
        let is_free = |room: &[f64; 4]| {
            let is_inside = room[0] >= 2.0
                && room[1] >= 2.0
                && room[2] <= WIDTH - 2.0
                && room[3] <= window.height - 2.0;
            is_inside && !self.taken.iter().any(|taken| overlap(taken, room))
        };
        let is_clear = |room: &[f64; 4]| {
            is_free(room) && !self.avoided.iter().any(|avoided| overlap(avoided, room))
        };
        let room = tries.clone().find(is_clear).or_else(|| tries.clone().find(is_free))?;
        self.taken.push(room);
        Some(room)
    }

    /// Takes squares along a body, which is longer than it is wide.
    pub(super) fn take_body(
        &mut self,
        window: &PlanWindow,
        outline_m: &[[f64; 2]],
        pose: &[f64; 5],
    ) {
        let [_, x, y, cos, sin] = *pose;
        let most = |k: usize| outline_m.iter().fold(0.0, |most: f64, at| most.max(at[k].abs()));
        let (length_m, width_m) = (most(0), most(1));
        let by = 0.9 * width_m.min(length_m) * window.per_m + 2.0;
        let count = (length_m / width_m.max(0.1)).clamp(1.0, 20.0).round() as usize;
        for k in 0..=count {
            let along = (2.0 * k as f64 / count as f64 - 1.0) * (length_m - width_m).max(0.0);
            self.take(window.at([x + cos * along, y + sin * along]), by);
        }
    }

    /// Takes or avoids squares along a track.
    pub(super) fn take_track(
        &mut self,
        window: &PlanWindow,
        track: &[PlanSample],
        take: impl Fn(&mut Self, [f64; 2], f64),
    ) {
        // At every quarter of a step between samples, as a fast body leaves gaps.
        for pair in track.windows(2) {
            for quarter in 0..4 {
                let share = 0.25 * f64::from(quarter);
                let along = |k: usize| pair[0].0[k] + share * (pair[1].0[k] - pair[0].0[k]);
                take(self, window.at([along(1), along(2)]), 5.0);
            }
        }
    }

    /// Takes squares along a closed line.
    pub(super) fn take_line(&mut self, corners: &[[f64; 2]]) {
        for (from, to) in corners.iter().zip(corners.iter().cycle().skip(1)) {
            let count = (f64::hypot(to[0] - from[0], to[1] - from[1]) / 4.0).ceil().max(1.0);
            for k in 0..count as usize {
                let share = k as f64 / count;
                self.take([0, 1].map(|axis| from[axis] + share * (to[axis] - from[axis])), 3.0);
            }
        }
    }

    /// Takes the place of the bar that says how long a metre is.
    pub(super) fn take_scale(&mut self, window: &PlanWindow) {
        let top = window.height - 14.0 - LINE;
        self.taken.push([0.0, top, 0.2 * WIDTH + 120.0, window.height]);
    }

    /// Avoids a square around a point.
    pub(super) fn avoid(&mut self, [x, y]: [f64; 2], by: f64) {
        self.avoided.push([x - by, y - by, x + by, y + by]);
    }

    /// Takes a square around a point.
    pub(super) fn take(&mut self, [x, y]: [f64; 2], by: f64) {
        self.taken.push([x - by, y - by, x + by, y + by]);
    }
}

pub(super) fn overlap(a: &[f64; 4], b: &[f64; 4]) -> bool {
    a[0] < b[2] && b[0] < a[2] && a[1] < b[3] && b[1] < a[3]
}

/// The width of a text, at most.
fn width(text: &str) -> f64 {
    LETTER * text.chars().count() as f64
}

/// What a text takes whose left end and base line are these.
fn rectangle([left, base]: [f64; 2], width: f64) -> [f64; 4] {
    [left, base - LINE + UNDER, left + width, base + UNDER]
}
