//! From a recording to the text of a scenario: where everybody goes, and what the ego could do. Who
//! meets whom is not asked here.
//!
//! Time 0 is when the manoeuvres begin. A body is where the middle of its outline is,
//! rounded to 0.1 mm and 0.0001°; times are rounded to 0.1 µs. Of tracks
//! that do not last from 0 to the horizon:
//!
//! - who leaves the recording goes on as in its last state;
//! - who comes into it is taken to have come with the velocity of its first state, straight;
//! - who is in it only before 0 or after the horizon is left out.
//!
//! Each of these is noted. A path has at most [`PATH_STATES_MAX`] states, so a manoeuvre is written
//! with every second or third step of its way: a curve of 9 m/s² is within 4 mm of chords of
//! 0.06 s.

use crate::library::Library;
use crate::manoeuvre::{Manoeuvre, Manoeuvres, arc, began};
use crate::outline::{Outline, overlap};
use crate::recording::{Recording, TimedState};
use crate::write::{
    comments, entry, errors, moved, names, party, quoted, rounded, shortened, title, too_many,
};
use course::{Course, Extent};
use diagnostic::{Diagnostic, FailureKind};
use scenario::{CANDIDATES_MAX, PARTIES_MAX, PATH_STATES_MAX, SCHEMA, Scenario, decimal};
use std::borrow::Cow;
use std::fmt::Write as _;
use std::ops::Range;

mod course;

/// Bodies whose outlines stay further apart than this do not touch (m): more than rounding and the
/// coarsest resolution of a scenario.
const APART_M: f64 = 0.5;
/// States of a manoeuvre that are further apart than this are noted (s).
const COARSE_S: f64 = 0.1;
/// So many obstacles are listed by their ids.
const LISTED_MAX: usize = 20;

/// A recording of which no scenario can be made.
///
/// ```
/// use trolley_traffic::{DEFAULT_LIBRARY, Library, Manoeuvres, scenario_text, read};
///
/// let text = "<commonRoad commonRoadVersion='2020a' timeStepSize='0.1'><planningProblem id='1'>\
///             <initialState><position><point><x>0</x><y>0</y></point></position><orientation>\
///             <exact>0</exact></orientation><time><exact>0</exact></time><velocity>\
///             <exact>9</exact></velocity></initialState></planningProblem></commonRoad>";
/// let alone = read("a.xml", text, &Default::default())?;
/// let library = Library::parse("default.toml", DEFAULT_LIBRARY)?;
/// let error = scenario_text("a.xml", &alone, &Manoeuvres::default(), &library).unwrap_err();
/// assert!(error.to_string().starts_with("a.xml: nobody is there but the ego"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{file}: {what}")]
pub struct ScenarioTextError {
    /// The recording, as named by the caller.
    pub file: String,
    /// What is wrong, on one line.
    pub what: String,
    /// What to do about it, on one line.
    pub remedy: String,
}

impl Diagnostic for ScenarioTextError {
    fn kind(&self) -> FailureKind {
        FailureKind::Input
    }

    fn place(&self) -> Option<String> {
        Some(self.file.clone())
    }

    fn what(&self) -> String {
        self.what.clone()
    }

    fn remedy(&self) -> Option<Cow<'_, str>> {
        Some(self.remedy.as_str().into())
    }
}

/// The scenario of a recording from when manoeuvres begin until the horizon, as TOML, and what was
/// assumed or left out, in whole sentences.
///
/// `source` is the name of the file, for the header and errors. Candidates are the manoeuvres of
/// these options, whether or not they meet anybody: "as recorded" if the recording has the ego,
/// every solution of a planner, and every arc. Parties are the ego and every obstacle; of more than
/// 32 those are left out that no manoeuvre can reach, the farthest first.
///
/// # Errors
///
/// Nobody but the ego is there until the horizon, the library has no body for a type, more than 32
/// obstacles can be reached, or a scenario may not say what the recording does: that somebody
/// jumps, that what is fixed to the ground moves.
pub fn scenario_text(
    source: &str,
    recording: &Recording,
    manoeuvres: &Manoeuvres,
    library: &Library,
) -> Result<(String, Vec<String>), ScenarioTextError> {
    let failed =
        |(what, remedy): Fault| ScenarioTextError { file: source.to_owned(), what, remedy };
    let horizon_s = manoeuvres.horizon_s;
    let start = began(&recording.ego, recording.ego.start.time_s + manoeuvres.after_s);
    let frame = Frame { began_s: start.time_s, horizon_s, moved: moved(recording) };
    let mut notes = Vec::new();
    let candidates = candidates(recording, manoeuvres, &start, &frame, &mut notes);
    let others = others(recording, &start, &frame, &mut notes);
    let others = reachable(recording, others, &candidates, &frame, &mut notes).map_err(failed)?;

    let no_body = |what: String| {
        let remedy = "add it to a library and name that: --bodies FILE";
        failed((what, remedy.to_owned()))
    };
    let names = names(recording, others.iter().map(|(index, _)| *index));
    let mut text = String::new();
    comments(&mut text, source, "the ego's manoeuvres, and where everybody goes", frame.moved);
    let _w = writeln!(text, "# Time 0 is {} s of the recording.", rounded(frame.began_s));
    let _w = writeln!(text, "schema = {}", quoted(SCHEMA));
    let _w = writeln!(text, "name = {}", quoted(&title(recording)));
    let _w = writeln!(text, "horizon_s = {}\n", decimal(horizon_s));
    let mut written: Vec<(Range<usize>, Subject<'_>)> = Vec::new();
    let mut from = 0;
    let mut closed = |text: &str, subject| {
        let to = text.len();
        written.push((from..to, subject));
        from = to;
    };
    closed(&text, Subject::Recording);
    party(&mut text, "ego", &recording.ego_outline(), entry(library, "ego").map_err(no_body)?);
    let cut = errors(&mut text, &recording.ego.spread, recording.ego.start.speed_m_s);
    notes.extend(cut.map(|cut| format!("the ego: {cut}")));
    closed(&text, Subject::Recording);
    for (index, course) in &others {
        let obstacle = &recording.others[*index];
        let body = entry(library, &obstacle.kind).map_err(no_body)?;
        text.push('\n');
        party(&mut text, &names[index], &obstacle.outline, body);
        let cut = errors(&mut text, &obstacle.spread, obstacle.track[0].speed_m_s);
        notes.extend(cut.map(|cut| format!("obstacle {}: {cut}", obstacle.id)));
        if course.stands() {
            let [x, y] = course.knots[0].at.map(rounded);
            let yaw = degrees(course.knots[0].yaw);
            let _w = writeln!(text, "place = {{ position_m = [{x}, {y}, 0.0], yaw_deg = {yaw} }}");
        } else {
            let _w = writeln!(text, "\n[[parties.{}.paths]]", quoted(&names[index]));
            states(&mut text, "states = [", course, "]");
        }
        closed(&text, Subject::Obstacle(&obstacle.id));
    }
    for (name, course) in &candidates {
        let _w = writeln!(text, "\n[[candidates]]\nname = {}", quoted(name));
        states(&mut text, "path = { states = [", course, "] }");
        closed(&text, Subject::Manoeuvre(name));
    }
    // Its rules are the reader's, so they stand nowhere else.
    let Err(error) = Scenario::parse(source, &text) else { return Ok((text, notes)) };
    let before: usize =
        text.split_inclusive('\n').take(error.place.line.saturating_sub(1)).map(str::len).sum();
    let subject = written.iter().find(|(range, _)| range.contains(&before));
    Err(failed(match subject.map(|(_, subject)| subject) {
        Some(Subject::Obstacle(id)) => (
            format!("obstacle {id}: {}", error.what),
            format!(
                "leave it out: --without {id}; or correct the recording, or the library's body"
            ),
        ),
        Some(Subject::Manoeuvre(name)) => {
            (format!("the ego's manoeuvre \"{name}\": {}", error.what), error.remedy)
        }
        Some(Subject::Recording) | None => (error.what, error.remedy),
    }))
}

/// What is wrong, and the remedy.
type Fault = (String, String);

/// Whose lines of the text these are.
enum Subject<'r> {
    Recording,
    Obstacle(&'r str),
    Manoeuvre(&'r str),
}

/// When and where the scenario is, in the recording.
struct Frame {
    /// Time 0 of the scenario (s).
    began_s: f64,
    /// From then on (s).
    horizon_s: f64,
    /// The origin of the scenario (m).
    moved: [f64; 2],
}

impl Frame {
    fn course(&self, moments: &[TimedState], outline: &Outline) -> Course {
        Course::new(moments, outline, self.moved, self.horizon_s)
    }
}

/// What the ego could do: names and ways.
fn candidates(
    recording: &Recording,
    manoeuvres: &Manoeuvres,
    start: &TimedState,
    frame: &Frame,
    notes: &mut Vec<String>,
) -> Vec<(String, Course)> {
    let outline = recording.ego_outline();
    let mut candidates: Vec<(String, Course)> = Vec::new();
    // The ways that are given, each with what a note calls it.
    let recorded = (!recording.ego.went.is_empty()).then(|| {
        let name = Manoeuvre::Recorded.name();
        ("the recording of the ego".to_owned(), name, &recording.ego.went)
    });
    let planned = recording.planned.iter().map(|planned| {
        let name = shortened(&planned.name);
        (format!("the solution \"{name}\""), name, &planned.went)
    });
    for (subject, name, went) in recorded.into_iter().chain(planned) {
        let extent = Extent::new(went, frame.began_s, frame.horizon_s);
        let Extent::There { moments, ends_s, .. } = extent else {
            notes.push(format!(
                "{subject} says nothing of the time of the manoeuvres: \"{name}\" is left out"
            ));
            continue;
        };
        if let Some(ends_s) = ends_s {
            notes.push(format!(
                "{subject} ends after {ends_s:.2} s: \"{name}\" then goes on as in its last state"
            ));
        }
        let course = frame.course(&moments, &outline);
        if let Some(apart_s) = course.thinned_s {
            notes.push(format!("{subject} {}", thinning(apart_s)));
        }
        candidates.push((name, course));
    }
    // The last step may end after the horizon; the way is cut there.
    let steps = (frame.horizon_s / manoeuvres.step_s - 1e-6).ceil() as u32;
    let mut coarse_s = 0.0_f64;
    for [brake_m_s2, lateral_m_s2] in manoeuvres.arcs() {
        let name = shortened(&Manoeuvre::Arc { brake_m_s2, lateral_m_s2 }.name());
        if candidates.iter().any(|(twin, _)| *twin == name) {
            notes.push(format!("the manoeuvre \"{name}\" is asked for twice: it stands once"));
            continue;
        }
        let mut way = vec![TimedState { slip: 0.0, ..*start }];
        way.extend(arc(start, brake_m_s2, lateral_m_s2, manoeuvres, steps));
        // Where it stands the path may end: it goes on as in its last state.
        let stands = way.iter().position(|moment| moment.speed_m_s == 0.0);
        way.truncate(stands.map_or(way.len(), |index| index + 1));
        if let Extent::There { moments, .. } = Extent::new(&way, frame.began_s, frame.horizon_s) {
            let course = frame.course(&moments, &outline);
            coarse_s = coarse_s.max(course.thinned_s.unwrap_or(0.0));
            candidates.push((name, course));
        }
    }
    if coarse_s > COARSE_S {
        notes.push(format!("every manoeuvre of the ego {}", thinning(coarse_s)));
    }
    if candidates.len() > CANDIDATES_MAX {
        notes.push(too_many(candidates.len()));
        candidates.truncate(CANDIDATES_MAX);
    }
    candidates
}

fn thinning(apart_s: f64) -> String {
    format!(
        "has more states than the {PATH_STATES_MAX} of a path: of these some are left, evenly, up \
         to {apart_s:.2} s apart"
    )
}

/// Every obstacle that is there until the horizon, by its number, and where it goes.
fn others(
    recording: &Recording,
    start: &TimedState,
    frame: &Frame,
    notes: &mut Vec<String>,
) -> Vec<(usize, Course)> {
    let ego_outline = recording.ego_outline();
    let (mut gone, mut later, mut leaving) = (Vec::new(), Vec::new(), Vec::new());
    let mut others = Vec::new();
    for (index, obstacle) in recording.others.iter().enumerate() {
        let id = obstacle.id.as_str();
        let extent = Extent::new(&obstacle.track, frame.began_s, frame.horizon_s);
        let (moments, comes_s, ends_s) = match extent {
            Extent::There { moments, comes_s, ends_s } => (moments, comes_s, ends_s),
            Extent::Gone => {
                gone.push(id);
                continue;
            }
            Extent::Later => {
                later.push(id);
                continue;
            }
        };
        if ends_s.is_some() {
            leaving.push(id);
        }
        if let Some(comes_s) = comes_s {
            let inside = overlap(&ego_outline, start.place, &obstacle.outline, moments[0].place);
            let inside = if inside {
                format!(", and so it begins inside the ego: --without {id} leaves it out")
            } else {
                String::new()
            };
            notes.push(format!(
                "obstacle {id} comes into the recording after {comes_s:.2} s: until then it is \
                 taken to go straight, as fast as then{inside}"
            ));
        }
        let course = frame.course(&moments, &obstacle.outline);
        if let Some(apart_s) = course.thinned_s {
            notes.push(format!("obstacle {id} {}", thinning(apart_s)));
        }
        others.push((index, course));
    }
    for (ids, is_so) in [
        (gone, "gone from the recording when manoeuvres begin: left out"),
        (later, "not in the recording before the horizon: left out"),
        (leaving, "gone from the recording before the horizon, going on as in the last state"),
    ] {
        if !ids.is_empty() {
            notes.push(format!("{}: {is_so}", listed(&ids)));
        }
    }
    others
}

/// "obstacle 7", "obstacles 7, 12, …".
fn listed(ids: &[&str]) -> String {
    let shown = ids[..ids.len().min(LISTED_MAX)].join(", ");
    let more = if ids.len() > LISTED_MAX { ", …" } else { "" };
    let several = if ids.len() > 1 { "s" } else { "" };
    format!("obstacle{several} {shown}{more}")
}

/// As many obstacles as a scenario holds: the others must be out of reach, whatever the ego does.
///
/// Two bodies cannot touch while their middles are further apart than half their diagonals.
fn reachable(
    recording: &Recording,
    others: Vec<(usize, Course)>,
    candidates: &[(String, Course)],
    frame: &Frame,
    notes: &mut Vec<String>,
) -> Result<Vec<(usize, Course)>, Fault> {
    const OTHERS_MAX: usize = PARTIES_MAX - 1;
    if others.is_empty() {
        let what = "nobody is there but the ego from when manoeuvres begin until the horizon";
        return Err((what.to_owned(), "begin them at another time: --at".to_owned()));
    }
    if others.len() <= OTHERS_MAX {
        return Ok(others);
    }
    let ego_m = half_diagonal_m(&recording.ego_outline());
    let gap_m = |(index, course): &(usize, Course)| {
        let ways = candidates.iter().map(|(_, ego)| ego.nearest_m(course, frame.horizon_s));
        let radii_m = ego_m + half_diagonal_m(&recording.others[*index].outline);
        ways.fold(f64::INFINITY, f64::min) - radii_m
    };
    let mut by_gap: Vec<(f64, (usize, Course))> =
        others.into_iter().map(|other| (gap_m(&other), other)).collect();
    by_gap.sort_by(|(a, _), (b, _)| a.total_cmp(b));
    let reached = by_gap.iter().take_while(|(gap_m, _)| *gap_m <= APART_M).count();
    if reached > OTHERS_MAX {
        let ids = by_gap[OTHERS_MAX..reached].iter().rev();
        let ids: Vec<&str> =
            ids.map(|(_, (index, _))| recording.others[*index].id.as_str()).collect();
        let what = format!(
            "the ego can come near {reached} obstacles within {} s, and a scenario holds \
             {OTHERS_MAX}",
            frame.horizon_s
        );
        let remedy = format!(
            "leave some out, each with --without ID, of which farthest is {}; or look less far \
             ahead: --horizon",
            listed(&ids)
        );
        return Err((what, remedy));
    }
    notes.push(format!(
        "a scenario holds {OTHERS_MAX} obstacles: {} more, which no manoeuvre can reach, are left \
         out",
        by_gap.len() - OTHERS_MAX
    ));
    by_gap.truncate(OTHERS_MAX);
    let mut kept: Vec<(usize, Course)> = by_gap.into_iter().map(|(_, other)| other).collect();
    kept.sort_by_key(|(index, _)| *index);
    Ok(kept)
}

/// No point of a body is further from its middle, in plan (m).
fn half_diagonal_m(outline: &Outline) -> f64 {
    let [length, width] = outline.size();
    0.5 * libm::hypot(length, width)
}

impl Course {
    /// Whether it is one place, as it is written.
    fn stands(&self) -> bool {
        let place = |knot: &course::Knot| (knot.at.map(rounded), degrees(knot.yaw));
        let is_still = self.knots.last().is_some_and(|last| {
            !self.goes_on || last.velocity_m_s.iter().all(|speed| rounded(*speed) == "0.0")
        });
        is_still && self.knots.windows(2).all(|pair| place(&pair[0]) == place(&pair[1]))
    }
}

/// A heading in degrees, as it is written.
fn degrees(yaw: f64) -> String {
    rounded(crate::recording::wrapped(yaw).to_degrees())
}

/// The states of a course, one a line. The last one has its velocity if the body goes on with it.
fn states(text: &mut String, open: &str, course: &Course, close: &str) {
    let _w = writeln!(text, "{open}");
    for (index, knot) in course.knots.iter().enumerate() {
        let time_s = decimal((knot.time_s * 1e7).round() / 1e7);
        let [x, y] = knot.at.map(rounded);
        let yaw = degrees(knot.yaw);
        let _w = write!(text, "  {{ t_s = {time_s}, position_m = [{x}, {y}, 0.0], yaw_deg = {yaw}");
        if course.goes_on && index + 1 == course.knots.len() {
            let [x, y] = knot.velocity_m_s.map(rounded);
            let _w = write!(text, ", velocity_m_s = [{x}, {y}]");
        }
        text.push_str(" },\n");
    }
    let _w = writeln!(text, "{close}");
}

#[cfg(test)]
mod tests;
