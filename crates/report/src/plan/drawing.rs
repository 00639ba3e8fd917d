//! The plan view as SVG: paths with a mark each second, contacts with labels that do not cover each
//! other, bodies, a scale bar.

use super::{cut, name};
use serde::Serialize;
use std::fmt::Write as _;
use trolley::{PlanCourse, PlanSample, PlanScene};

/// Width in the drawing's own units.
const WIDTH: f64 = 1000.0;
/// Least and greatest height, as shares of the width.
const HEIGHT: [f64; 2] = [0.3, 0.75];
/// What is left free around ways and bodies (m).
const MARGIN_M: f64 = 6.0;
/// A party that is met is shown where it starts if that is not farther from the ego's ways (m).
const FAR_M: f64 = 40.0;
/// Room for a line of text and for a letter: the greater of the two sizes in `plan.css`.
const LINE: f64 = 26.0;
const LETTER: f64 = 12.0;
/// What of a line is under the base line.
const UNDER: f64 = 6.0;
/// Least distance between two times beside a way.
const TICK: f64 = 50.0;
/// With more parties, only those are named that are met or named elsewhere on the page.
const NAMED_MAX: usize = 8;

/// Where the drawing lies in the world.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(super) struct PlanWindow {
    /// The left edge (m).
    pub(super) left_m: f64,
    /// The upper edge (m).
    pub(super) top_m: f64,
    /// Units per metre.
    pub(super) per_m: f64,
    height: f64,
}

impl PlanWindow {
    /// Around all ways of the ego, and whom it meets.
    pub(super) fn of(scene: &PlanScene) -> Self {
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        let mut hold = |[x, y]: [f64; 2], by: f64| {
            low = [low[0].min(x - by), low[1].min(y - by)];
            high = [high[0].max(x + by), high[1].max(y + by)];
        };
        for course in &scene.courses {
            course.ego.iter().for_each(|sample| hold([sample.0[1], sample.0[2]], MARGIN_M));
            course.contacts.iter().for_each(|contact| hold(contact.at_m, MARGIN_M));
        }
        let (near, far) = (low, high);
        for (number, party) in scene.parties.iter().enumerate() {
            let Some(sample) = party.paths.first().and_then(|path| path.track.first()) else {
                continue;
            };
            let at = [sample.0[1], sample.0[2]];
            let is_met = scene.courses.iter().flat_map(|course| &course.contacts);
            let reach =
                if is_met.clone().any(|contact| contact.party == number) { FAR_M } else { 3.0 };
            if (0..2).all(|k| at[k] > near[k] - reach && at[k] < far[k] + reach) {
                low = [low[0].min(at[0] - 4.0), low[1].min(at[1] - 4.0)];
                high = [high[0].max(at[0] + 4.0), high[1].max(at[1] + 4.0)];
            }
        }
        if !(low[0] < high[0] && low[1] < high[1]) {
            (low, high) = ([-MARGIN_M; 2], [MARGIN_M; 2]);
        }
        let (mut wide, mut tall) = (high[0] - low[0], high[1] - low[1]);
        let middle = [0, 1].map(|k| 0.5 * (low[k] + high[k]));
        tall = tall.max(HEIGHT[0] * wide);
        wide = wide.max(tall / HEIGHT[1]);
        let per_m = WIDTH / wide;
        Self {
            left_m: middle[0] - 0.5 * wide,
            top_m: middle[1] + 0.5 * tall,
            per_m,
            height: tall * per_m,
        }
    }

    fn at(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [(x - self.left_m) * self.per_m, (self.top_m - y) * self.per_m]
    }

    /// Whether a place in the world (m) is in the picture.
    #[cfg(test)]
    pub(super) fn shows(&self, at_m: [f64; 2]) -> bool {
        self.holds(self.at(at_m))
    }

    /// Its height as a share of its width.
    #[cfg(test)]
    pub(super) fn share(&self) -> f64 {
        self.height / WIDTH
    }

    fn holds(&self, [x, y]: [f64; 2]) -> bool {
        (0.0..=WIDTH).contains(&x) && (0.0..=self.height).contains(&y)
    }
}

/// Rectangles that are taken: left, top, right, bottom.
#[derive(Clone, Debug, Default)]
pub(super) struct TakenRoom(Vec<[f64; 4]>);

impl TakenRoom {
    /// The first free place near a point for a text, taken from then on: its left end and its base
    /// line. `None`: all are taken or outside.
    fn place(&mut self, window: &PlanWindow, at: [f64; 2], text: &str) -> Option<[f64; 2]> {
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
        let width = LETTER * text.chars().count() as f64;
        let tries = (1..=7).flat_map(|ring| {
            let up = 16.0 + LINE * f64::from(ring - 1);
            [-up, up + LINE - 8.0]
                .into_iter()
                .flat_map(move |dy| [12.0, -12.0 - width, -0.5 * width].map(|dx| [x + dx, y + dy]))
        });
        for [left, base] in tries {
            let room = [left, base - LINE + UNDER, left + width, base + UNDER];
            let is_inside = room[0] >= 2.0
                && room[1] >= 2.0
                && room[2] <= WIDTH - 2.0
                && room[3] <= window.height - 2.0;
            if is_inside && !self.0.iter().any(|taken| overlap(taken, &room)) {
                self.0.push(room);
                return Some(room);
            }
        }
        None
    }

    /// Takes squares along a body, which is longer than it is wide.
    fn take_body(&mut self, window: &PlanWindow, outline_m: &[[f64; 2]], pose: &[f64; 5]) {
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

    /// Takes the ego's way, and the times beside it.
    fn take_times(&mut self, window: &PlanWindow, course: &PlanCourse) {
        let end_s = course.ego.last().map_or(0.0, |sample| sample.0[0]);
        for second in 1..=end_s.floor() as usize {
            let [_, x, y, ..] = pose_at(&course.ego, second as f64);
            let [x, y] = window.at([x, y]);
            self.0.push([x - 20.0, y - 5.0, x + 20.0, y + 30.0]);
        }
        for sample in &course.ego {
            self.take(window.at([sample.0[1], sample.0[2]]), 5.0);
        }
    }

    /// Takes a square around a point.
    fn take(&mut self, [x, y]: [f64; 2], by: f64) {
        self.0.push([x - by, y - by, x + by, y + by]);
    }
}

pub(super) fn overlap(a: &[f64; 4], b: &[f64; 4]) -> bool {
    a[0] < b[2] && b[0] < a[2] && a[1] < b[3] && b[1] < a[3]
}

/// A body on its track at a time: linear between samples, still after the last.
pub(super) fn pose_at(track: &[PlanSample], time_s: f64) -> [f64; 5] {
    let after = track.partition_point(|sample| sample.0[0] <= time_s);
    let Some(last) = track.last() else { return [time_s, 0.0, 0.0, 1.0, 0.0] };
    let (a, b) = (track[after.saturating_sub(1)].0, track.get(after).unwrap_or(last).0);
    let share = if b[0] > a[0] { ((time_s - a[0]) / (b[0] - a[0])).clamp(0.0, 1.0) } else { 0.0 };
    core::array::from_fn(|k| a[k] + (b[k] - a[k]) * share)
}

/// How a party moves in a candidate.
fn followed<'s>(scene: &'s PlanScene, course: &'s PlanCourse, party: usize) -> &'s [PlanSample] {
    if party == scene.ego {
        return &course.ego;
    }
    let reacts = course.reactions.iter().find(|(number, _)| *number == party);
    let of = &scene.parties[party];
    reacts.map_or_else(
        || of.paths.get(of.followed).map_or(&[][..], |path| &path.track),
        |(_, track)| track,
    )
}

/// The whole drawing; `shown` is the candidate that a reader sees first.
pub(super) fn svg(scene: &PlanScene, window: &PlanWindow, shown: usize, title: &str) -> String {
    let mut inside = String::new();
    for k in 0..scene.courses.len() {
        let hidden = if k == shown { "" } else { " style=\"display:none\"" };
        let _w = write!(inside, "<g data-course=\"{k}\"{hidden}>");
        ways(scene, window, k, &mut inside);
        inside.push_str("</g>");
    }
    let mut room = TakenRoom::default();
    bodies(scene, window, shown, &mut room, &mut inside);
    for (k, course) in scene.courses.iter().enumerate() {
        let hidden = if k == shown { "" } else { " style=\"display:none\"" };
        let _w = write!(inside, "<g data-course=\"{k}\"{hidden}>");
        contacts(scene, window, course, room.clone(), &mut inside);
        inside.push_str("</g>");
    }
    scale_bar(window, &mut inside);
    format!(
        "<svg id=\"plan\" class=\"plan\" xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 \
         {WIDTH} {:.0}\" role=\"img\" aria-label=\"{1}\"><title>{1}</title>{inside}</svg>",
        window.height,
        name(title)
    )
}

/// The line of a track between two times, if it is longer than half a metre.
fn line(
    window: &PlanWindow,
    track: &[PlanSample],
    [from_s, to_s]: [f64; 2],
    class: &str,
) -> String {
    let between = track.iter().map(|sample| sample.0[0]).filter(|t| *t > from_s && *t < to_s);
    let times: Vec<f64> = [from_s].into_iter().chain(between).chain([to_s]).collect();
    let (mut points, mut length, mut before) = (String::new(), 0.0, None::<[f64; 2]>);
    for time_s in times {
        let [_, x, y, ..] = pose_at(track, time_s);
        if let Some([p, q]) = before {
            length += f64::hypot(x - p, y - q);
        }
        before = Some([x, y]);
        let [x, y] = window.at([x, y]);
        let _w = write!(points, "{x:.1},{y:.1} ");
    }
    if length < 0.5 {
        return String::new();
    }
    format!("<polyline class=\"way {class}\" points=\"{}\"/>", points.trim_end())
}

/// A dot each second, and its time where there is room beside it.
fn marks(window: &PlanWindow, track: &[PlanSample], to_s: f64, class: &str, out: &mut String) {
    let mut before: Option<[f64; 2]> = None;
    let mut said: Option<[f64; 2]> = None;
    for second in 1..=to_s.floor() as usize {
        let [_, x, y, ..] = pose_at(track, second as f64);
        let at = window.at([x, y]);
        let far = |from: Option<[f64; 2]>, by: f64| {
            from.is_none_or(|[p, q]| f64::hypot(at[0] - p, at[1] - q) > by)
        };
        if !far(before, 3.0) || !window.holds(at) {
            continue;
        }
        before = Some(at);
        let [x, y] = at;
        let _w = write!(out, "<circle class=\"dot {class}\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"4\"/>");
        if class == "own" && far(said, TICK) {
            said = Some(at);
            let _w = write!(
                out,
                "<text class=\"tick\" x=\"{x:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{second} \
                 s</text>",
                y + 24.0
            );
        }
    }
}

fn ways(scene: &PlanScene, window: &PlanWindow, k: usize, out: &mut String) {
    let (course, horizon_s) = (&scene.courses[k], scene.horizon_s);
    for (number, party) in scene.parties.iter().enumerate().filter(|(n, _)| *n != scene.ego) {
        let track = followed(scene, course, number);
        let reacts = course.reactions.iter().any(|(who, _)| *who == number);
        let others = party.paths.iter().enumerate();
        for (_, path) in others.filter(|(n, _)| !reacts && *n != party.followed) {
            out.push_str(&line(window, &path.track, [0.0, horizon_s], "else"));
        }
        let way = line(window, track, [0.0, horizon_s], "");
        if !way.is_empty() {
            out.push_str(&way);
            marks(window, track, horizon_s, "", out);
        }
    }
    let end_s = course.ego.last().map_or(0.0, |sample| sample.0[0]);
    let leaves_s = course.run_outs_s.first().copied().unwrap_or(end_s).min(end_s);
    out.push_str(&line(window, &course.ego, [0.0, leaves_s], "own"));
    out.push_str(&line(window, &course.ego, [leaves_s, end_s], "out"));
    marks(window, &course.ego, end_s, "own", out);
}

/// All bodies where they are at the start, and names.
fn bodies(
    scene: &PlanScene,
    window: &PlanWindow,
    shown: usize,
    room: &mut TakenRoom,
    out: &mut String,
) {
    let Some(course) = scene.courses.get(shown) else { return };
    let is_met = |number: usize| course.contacts.iter().any(|contact| contact.party == number);
    let is_ever_met = |number: usize| {
        let all = scene.courses.iter().flat_map(|course| &course.contacts);
        all.clone().any(|contact| contact.party == number)
    };
    let poses: Vec<[f64; 5]> =
        (0..scene.parties.len()).map(|n| pose_at(followed(scene, course, n), 0.0)).collect();
    for (party, pose) in scene.parties.iter().zip(&poses) {
        room.take_body(window, &party.outline_m, pose);
    }
    room.take_times(window, course);
    for (number, party) in scene.parties.iter().enumerate() {
        let [_, x, y, cos, sin] = poses[number];
        let [e, f] = window.at([x, y]);
        let is_ego = number == scene.ego;
        let class = match (is_ego, is_met(number)) {
            (true, _) => "body ego",
            (false, true) => "body met",
            (false, false) => "body",
        };
        let mut points = String::new();
        let mut front: f64 = 0.0;
        for [u, v] in &party.outline_m {
            front = front.max(u * window.per_m);
            let _w = write!(points, "{:.1},{:.1} ", u * window.per_m, -v * window.per_m);
        }
        let _w = write!(
            out,
            "<g data-body=\"{number}\"><title>{0}</title><g class=\"turned\" \
             transform=\"matrix({cos} {1} {sin} {cos} {e:.1} {f:.1})\"><polygon class=\"{class}\" \
             points=\"{2}\"/><line class=\"front\" x1=\"{3:.1}\" y1=\"0\" x2=\"{4:.1}\" \
             y2=\"0\"/></g>",
            name(&party.name),
            -sin,
            points.trim_end(),
            0.45 * front,
            0.85 * front
        );
        let is_named = scene.parties.len() <= NAMED_MAX || is_ego || is_ever_met(number);
        let text = cut(&party.name, 18);
        if is_named
            && window.holds([e, f])
            && let Some([left, base]) = room.place(window, [e, f], &text)
        {
            let _w = write!(
                out,
                "<text transform=\"translate({e:.1} {f:.1})\" x=\"{:.1}\" y=\"{:.1}\">{}</text>",
                left - e,
                base - f,
                name(&text)
            );
        }
        out.push_str("</g>");
    }
}

/// A cross in a circle for each contact, and when and whom beside it.
fn contacts(
    scene: &PlanScene,
    window: &PlanWindow,
    course: &PlanCourse,
    mut room: TakenRoom,
    out: &mut String,
) {
    room.take_times(window, course);
    for contact in &course.contacts {
        room.take(window.at(contact.at_m), 12.0);
    }
    for contact in &course.contacts {
        let at @ [x, y] = window.at(contact.at_m);
        let who = cut(&scene.parties[contact.party].name, 18);
        let text = format!("{:.2} s {who}", contact.time_s);
        if let Some([left, base]) = room.place(window, at, &text) {
            let end = if left > x { left } else { left + 20.0 };
            let _w = write!(
                out,
                "<line class=\"lead\" x1=\"{x:.1}\" y1=\"{y:.1}\" x2=\"{end:.1}\" \
                 y2=\"{:.1}\"/><text class=\"said\" x=\"{left:.1}\" y=\"{base:.1}\">{:.2} s \
                 <tspan>{}</tspan></text>",
                base - 5.0,
                contact.time_s,
                name(&who)
            );
        }
        let _w = write!(
            out,
            "<circle class=\"hit\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"9\"/><path class=\"cross\" \
             d=\"M{0:.1} {1:.1}l9 9m0 -9l-9 9\"/>",
            x - 4.5,
            y - 4.5
        );
    }
}

/// A bar of 1, 2 or 5 times a power of ten metres.
fn scale_bar(window: &PlanWindow, out: &mut String) {
    let most_m = 0.2 * WIDTH / window.per_m;
    let sizes = [500.0, 200.0, 100.0, 50.0, 20.0, 10.0, 5.0, 2.0];
    let size_m = sizes.into_iter().find(|size| *size <= most_m).unwrap_or(1.0);
    let (left, base) = (16.0, window.height - 14.0);
    let right = left + size_m * window.per_m;
    let _w = write!(
        out,
        "<path class=\"scale\" d=\"M{left} {0:.1}v8H{right:.1}v-8\"/><text x=\"{1:.1}\" \
         y=\"{2:.1}\">{size_m} m</text>",
        base - 8.0,
        right + 8.0,
        base + 3.0
    );
}
