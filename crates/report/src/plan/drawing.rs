//! The plan view as SVG: paths with a mark each second, contacts with labels that do not cover each
//! other, bodies, a scale bar.

use super::labels::{TakenRoom, UNDER};
use super::{apart, cut, name, spread};
use serde::Serialize;
use std::fmt::Write as _;
use trolley::plan::{PlanCourse, PlanSample, PlanScene};

/// Width in the drawing's own units.
pub(super) const WIDTH: f64 = 1000.0;
/// Least and greatest height, as shares of the width.
const HEIGHT: [f64; 2] = [0.3, 0.75];
/// What is left free around ways and bodies (m).
const MARGIN_M: f64 = 6.0;
/// A party that is met is shown where it starts if that is not farther from the ego's ways (m).
const FAR_M: f64 = 40.0;
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
    pub(super) height: f64,
}

/// What a drawing is made for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Use {
    /// All candidates, which the page's script shows one at a time.
    Screen,
    /// One candidate, which stands still.
    Paper,
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
        for course in scene.members.iter().flat_map(|member| &member.courses) {
            course.ego.iter().for_each(|point| hold([point.0[1], point.0[2]], 1.0));
        }
        for course in &scene.courses {
            // Whom it comes nearest to is in the picture, and as much of both as is wide.
            let Some(nearest) = &course.nearest else { continue };
            for number in [scene.ego, nearest.party] {
                let pose = pose_at(followed(scene, course, number), nearest.time_s);
                outline_at(&scene.parties[number].outline_m, &pose).for_each(|at| hold(at, 1.0));
            }
        }
        let (near, far) = (low, high);
        for (number, party) in scene.parties.iter().enumerate() {
            let Some(sample) = party.paths.first().and_then(|path| path.track.first()) else {
                continue;
            };
            let at = [sample.0[1], sample.0[2]];
            let mut met = scene.courses.iter().flat_map(|course| &course.contacts);
            // Where it is not known what happens, anybody may be met.
            let is_open = scene.courses.iter().any(|course| course.open_from_s.is_some());
            let is_met = is_open || met.any(|contact| contact.party == number);
            let reach = if is_met { FAR_M } else { 3.0 };
            if (0..2).all(|k| at[k] > near[k] - reach && at[k] < far[k] + reach) {
                // As a whole, and its name beside it.
                for [x, y] in outline_at(&party.outline_m, &sample.0) {
                    low = [low[0].min(x - 2.0), low[1].min(y - 2.0)];
                    high = [high[0].max(x + 2.0), high[1].max(y + 2.0)];
                }
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

    /// A place in the world (m) in the drawing's units.
    pub(super) fn at(&self, [x, y]: [f64; 2]) -> [f64; 2] {
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

    pub(super) fn holds(&self, [x, y]: [f64; 2]) -> bool {
        (0.0..=WIDTH).contains(&x) && (0.0..=self.height).contains(&y)
    }
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
pub(super) fn followed<'s>(
    scene: &'s PlanScene,
    course: &'s PlanCourse,
    party: usize,
) -> &'s [PlanSample] {
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
pub(super) fn svg(
    scene: &PlanScene,
    window: &PlanWindow,
    shown: usize,
    made_for: Use,
    title: &str,
) -> String {
    let (mut under, mut over) = (String::new(), String::new());
    let is_drawn = |k: usize| made_for == Use::Screen || k == shown;
    let mut shown_room = TakenRoom::default();
    for k in (0..scene.courses.len()).filter(|k| is_drawn(*k)) {
        let mut room = room_of(scene, window, k);
        let hidden = if k == shown { "" } else { " style=\"display:none\"" };
        let open = match made_for {
            Use::Screen => format!("<g data-course=\"{k}\"{hidden}>"),
            Use::Paper => "<g>".to_owned(),
        };
        under.push_str(&open);
        ways(scene, window, k, &mut under);
        under.push_str("</g>");
        over.push_str(&open);
        said(scene, window, k, &mut room, &mut over);
        over.push_str("</g>");
        if k == shown {
            shown_room = room;
        }
    }
    let mut inside = spread::spread(scene, window, shown, made_for);
    inside.push_str(&under);
    bodies(scene, window, shown, made_for, &mut shown_room, &mut inside);
    inside.push_str(&over);
    scale_bar(window, &mut inside);
    let id = if made_for == Use::Screen { " id=\"plan\"" } else { "" };
    format!(
        "<svg{id} class=\"plan\" xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 \
         {WIDTH} {:.0}\" role=\"img\" aria-label=\"{1}\"><title>{1}</title>{inside}</svg>",
        window.height,
        name(title)
    )
}

/// What labels of a candidate must not cover: bodies at the start, what touches, and the ego's way;
/// and what they had better not cover: the ways of others.
fn room_of(scene: &PlanScene, window: &PlanWindow, k: usize) -> TakenRoom {
    let course = &scene.courses[k];
    let mut room = TakenRoom::default();
    for (number, party) in scene.parties.iter().enumerate() {
        let track = followed(scene, course, number);
        room.take_body(window, &party.outline_m, &pose_at(track, 0.0));
        if number != scene.ego {
            room.take_track(window, track, TakenRoom::avoid);
        }
    }
    room.take_track(window, &course.ego, TakenRoom::take);
    for contact in &course.contacts {
        room.take(window.at(contact.at_m), 12.0);
    }
    room.take_scale(window);
    room
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

/// A dot each second, where it is apart from the one before.
fn dots(window: &PlanWindow, track: &[PlanSample], to_s: f64) -> Vec<(usize, [f64; 2])> {
    let mut dots: Vec<(usize, [f64; 2])> = Vec::new();
    for second in 1..=to_s.floor() as usize {
        let [_, x, y, ..] = pose_at(track, second as f64);
        let at = window.at([x, y]);
        let is_apart = dots.last().is_none_or(|(_, [p, q])| f64::hypot(at[0] - p, at[1] - q) > 3.0);
        if is_apart && window.holds(at) {
            dots.push((second, at));
        }
    }
    dots
}

fn marks(window: &PlanWindow, track: &[PlanSample], to_s: f64, class: &str, out: &mut String) {
    for (_, [x, y]) in dots(window, track, to_s) {
        let _w = write!(out, "<circle class=\"dot {class}\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"4\"/>");
    }
}

/// The times beside the ego's dots, where there is room.
fn times(window: &PlanWindow, course: &PlanCourse, room: &mut TakenRoom, out: &mut String) {
    let end_s = course.ego.last().map_or(0.0, |sample| sample.0[0]);
    let mut last: Option<[f64; 2]> = None;
    for (second, at @ [x, y]) in dots(window, &course.ego, end_s) {
        let is_near = last.is_some_and(|[p, q]| f64::hypot(x - p, y - q) <= TICK);
        if is_near {
            continue;
        }
        if let Some([left, base]) = room.place_beside(window, at, &format!("{second} s")) {
            last = Some(at);
            let _w = write!(
                out,
                "<text class=\"tick\" x=\"{left:.1}\" y=\"{base:.1}\">{second} s</text>"
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
    made_for: Use,
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
            "<g{5}><title>{0}</title><g class=\"turned\" \
             transform=\"matrix({cos} {1} {sin} {cos} {e:.1} {f:.1})\"><polygon class=\"{class}\" \
             points=\"{2}\"/><line class=\"front\" x1=\"{3:.1}\" y1=\"0\" x2=\"{4:.1}\" \
             y2=\"0\"/></g>",
            name(&party.name),
            -sin,
            points.trim_end(),
            0.45 * front,
            0.85 * front,
            match made_for {
                Use::Screen => format!(" data-body=\"{number}\""),
                Use::Paper => String::new(),
            }
        );
        let is_named = scene.parties.len() <= NAMED_MAX || is_ego || is_ever_met(number);
        let text = cut(&party.name, 18);
        if is_named
            && window.holds([e, f])
            && let Some([left, base]) = room.place(window, [e, f], &text)
        {
            let _w = write!(
                out,
                "<text class=\"name\" transform=\"translate({e:.1} {f:.1})\" x=\"{:.1}\" \
                 y=\"{:.1}\">{}</text>",
                left - e,
                base - f,
                name(&text)
            );
        }
        out.push_str("</g>");
    }
}

/// A cross in a circle for each contact, and when and whom beside it; or where the ego comes
/// nearest to whom; and times.
fn said(scene: &PlanScene, window: &PlanWindow, k: usize, room: &mut TakenRoom, out: &mut String) {
    let course = &scene.courses[k];
    for contact in &course.contacts {
        let at = window.at(contact.at_m);
        let who = &scene.parties[contact.party].name;
        label(window, at, &format!("{:.2} s", contact.time_s), who, "said", room, out);
        let [x, y] = at;
        let _w = write!(
            out,
            "<circle class=\"hit\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"9\"/><path class=\"cross\" \
             d=\"M{0:.1} {1:.1}l9 9m0 -9l-9 9\"/>",
            x - 4.5,
            y - 4.5
        );
    }
    if let Some(nearest) = &course.nearest {
        let both: [Vec<[f64; 2]>; 2] = [scene.ego, nearest.party].map(|number| {
            let pose = pose_at(followed(scene, course, number), nearest.time_s);
            let of = &scene.parties[number].outline_m;
            let corners = outline_at(of, &pose).map(|at| window.at(at)).collect::<Vec<_>>();
            outline(&corners, out);
            room.take_line(&corners);
            corners
        });
        let [from, to] = gap(&both[0], &both[1]);
        let _w = write!(
            out,
            "<line class=\"gap\" x1=\"{:.1}\" y1=\"{:.1}\" x2=\"{:.1}\" y2=\"{:.1}\"/>",
            from[0], from[1], to[0], to[1]
        );
        room.take_line(&[from, to]);
        let at = [0, 1].map(|axis| 0.5 * (from[axis] + to[axis]));
        let text = format!("{:.2} s, {} to", nearest.time_s, apart(nearest.gap_m));
        let who = &scene.parties[nearest.party].name;
        if window.holds(at) {
            label(window, at, &text, who, "near", room, out);
        }
    }
    times(window, course, room, out);
}

/// A text with a name beside a point, and a line to it.
fn label(
    window: &PlanWindow,
    at @ [x, y]: [f64; 2],
    text: &str,
    who: &str,
    class: &str,
    room: &mut TakenRoom,
    out: &mut String,
) {
    let who = cut(who, 18);
    let Some(placed) = room.placed(window, at, &format!("{text} {who}")) else { return };
    let [left, top, right, bottom] = placed;
    // The text is not as long as its room: it begins or ends where the line comes from.
    let (anchor, from, end) = if left >= x {
        ("start", left, [left - 2.0, 0.5 * (top + bottom)])
    } else if right <= x {
        ("end", right, [right + 2.0, 0.5 * (top + bottom)])
    } else {
        ("middle", 0.5 * (left + right), [x, if y < top { top } else { bottom }])
    };
    let _w = write!(
        out,
        "<line class=\"lead {class}\" x1=\"{x:.1}\" y1=\"{y:.1}\" x2=\"{:.1}\" \
         y2=\"{:.1}\"/><text class=\"{class}\" x=\"{from:.1}\" y=\"{:.1}\" \
         text-anchor=\"{anchor}\">{text} <tspan>{}</tspan></text>",
        end[0],
        end[1],
        bottom - UNDER,
        name(&who)
    );
}

/// The corners of a body at a pose (m).
fn outline_at<'o>(
    outline_m: &'o [[f64; 2]],
    pose: &[f64; 5],
) -> impl Iterator<Item = [f64; 2]> + use<'o> {
    let [_, x, y, cos, sin] = *pose;
    outline_m.iter().map(move |[u, v]| [x + cos * u - sin * v, y + sin * u + cos * v])
}

/// Two points, one of each outline, that are as near as both outlines come.
pub(super) fn gap(a: &[[f64; 2]], b: &[[f64; 2]]) -> [[f64; 2]; 2] {
    let nearest_of = |corners: &[[f64; 2]], others: &[[f64; 2]]| {
        let sides = others.iter().zip(others.iter().cycle().skip(1));
        let pairs = corners.iter().flat_map(|corner| {
            sides.clone().map(move |(from, to)| {
                let side = [to[0] - from[0], to[1] - from[1]];
                let length = side[0] * side[0] + side[1] * side[1];
                let along = (corner[0] - from[0]) * side[0] + (corner[1] - from[1]) * side[1];
                let share = if length > 0.0 { (along / length).clamp(0.0, 1.0) } else { 0.0 };
                let foot = [from[0] + share * side[0], from[1] + share * side[1]];
                (f64::hypot(foot[0] - corner[0], foot[1] - corner[1]), *corner, foot)
            })
        });
        pairs.min_by(|one, other| one.0.total_cmp(&other.0))
    };
    match (nearest_of(a, b), nearest_of(b, a)) {
        (Some(one), Some(other)) if other.0 < one.0 => [other.2, other.1],
        (Some(one), _) => [one.1, one.2],
        _ => [[0.0; 2]; 2],
    }
}

/// A dashed outline.
fn outline(corners: &[[f64; 2]], out: &mut String) {
    let points: Vec<String> = corners.iter().map(|[p, q]| format!("{p:.1},{q:.1}")).collect();
    let _w = write!(out, "<polygon class=\"then\" points=\"{}\"/>", points.join(" "));
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
        "<rect class=\"plate\" x=\"0\" y=\"{3:.1}\" width=\"{4:.1}\" height=\"38\"/><path \
         class=\"scale\" d=\"M{left} {0:.1}v8H{right:.1}v-8\"/><text x=\"{1:.1}\" \
         y=\"{2:.1}\">{size_m} m</text>",
        base - 8.0,
        right + 8.0,
        base + 3.0,
        window.height - 38.0,
        right + 84.0
    );
}
