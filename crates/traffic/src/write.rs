//! From meetings to the text of a scenario: one candidate for each, bodies from the library. What
//! both forms of a scenario have in common is written here.
//!
//! Bodies are put where the middle of their outline is, stretched to its length and width; a circle
//! gives a body its longest side. Coordinates are rounded to 0.1 mm and 0.0001°.

use crate::library::{Entry, Library};
use crate::outline::{Outline, Placed};
use crate::recording::{Recording, TimedState, wrapped};
use crate::sweep::Swept;
use scenario::{CANDIDATES_MAX, decimal};
use std::collections::BTreeMap;
use std::fmt::Write as _;

/// Coordinates beyond this are moved so that the ego starts near the origin (m): maps count from a
/// far away equator.
const FAR_M: f64 = 100_000.0;

/// The scenario of all meetings, as TOML, and what was left out, in whole sentences.
///
/// `source` is the name of the file, for the header.
///
/// # Errors
///
/// In words: the library has no body for a type that is met, or nothing is met at all.
pub fn scenario_text(
    source: &str,
    recording: &Recording,
    swept: &Swept,
    library: &Library,
) -> Result<(String, Vec<String>), String> {
    let mut notes = Vec::new();
    let meetings = &swept.meetings[..swept.meetings.len().min(CANDIDATES_MAX)];
    if meetings.is_empty() {
        return Err("no manoeuvre meets anybody: there is nothing to rank".to_owned());
    }
    if meetings.len() < swept.meetings.len() {
        notes.push(too_many(swept.meetings.len()));
    }
    let moved = moved(recording);
    let mut text = String::new();
    comments(&mut text, source, "ego manoeuvres and whom each meets first", moved);
    let _w = writeln!(text, "schema = {}", quoted(scenario::SCHEMA));
    let _w = writeln!(text, "name = {}\n", quoted(&title(recording)));
    let ego_outline = recording.ego_outline();
    party(&mut text, "ego", &ego_outline, entry(library, "ego")?, NOBODY);
    let names = names(recording, meetings.iter().map(|meeting| meeting.whom));
    for (index, name) in &names {
        let obstacle = &recording.others[*index];
        party(&mut text, name, &obstacle.outline, entry(library, &obstacle.kind)?, NOBODY);
    }
    for meeting in meetings {
        let other = &recording.others[meeting.whom];
        let party = &names[&meeting.whom];
        let name = shortened(&format!("{} → {party}", meeting.manoeuvre.name()));
        let _w = writeln!(text, "\n# After {:.2} s.", meeting.ego.time_s - swept.began_s);
        let _w = writeln!(text, "[[candidates]]\nname = {}", quoted(&name));
        let _w = writeln!(text, "ego = {{ {} }}", state(&meeting.ego, &ego_outline, moved));
        let state = state(&meeting.other, &other.outline, moved);
        let _w = writeln!(text, "other = {{ party = {}, {state} }}", quoted(party));
    }
    Ok((text, notes))
}

/// How a party says that nobody is inside.
const NOBODY: &str = "persons = []";

/// What a scenario cannot hold of so many candidates.
pub(crate) fn too_many(candidates: usize) -> String {
    let more = candidates - CANDIDATES_MAX;
    format!("a request ranks {CANDIDATES_MAX} candidates: {more} more are left out")
}

/// By how much all coordinates are moved (m): not at all, unless the ego is far from the origin.
pub(crate) fn moved(recording: &Recording) -> [f64; 2] {
    let start = recording.ego.start.place.at;
    if start.iter().any(|x| x.abs() > FAR_M) { start.map(f64::round) } else { [0.0; 2] }
}

/// The lines before the first key: where the scenario is from, what it says, how it is moved.
pub(crate) fn comments(text: &mut String, source: &str, says: &str, moved: [f64; 2]) {
    let source = source.replace(|c: char| c.is_control(), " ");
    let _w = writeln!(text, "# From {source}: {says}.");
    if moved != [0.0; 2] {
        let [x, y] = moved.map(decimal);
        let _w = writeln!(text, "# Moved by [{x}, {y}] m, so that the ego starts near the origin.");
    }
}

/// The name of a recording as that of a scenario.
pub(crate) fn title(recording: &Recording) -> String {
    let title = shortened(&recording.name);
    if title.is_empty() { "recording".to_owned() } else { title }
}

/// As much of a name as a scenario takes: 60 visible characters.
pub(crate) fn shortened(name: &str) -> String {
    let plain = name.replace(|c: char| c.is_control(), " ");
    plain.trim().chars().take(60).collect::<String>().trim().to_owned()
}

/// The middle of an outline in the world: where its body is put.
pub(crate) fn middle(moment: &TimedState, outline: &Outline) -> Placed {
    Placed { at: moment.place.point(outline.middle()), yaw: moment.place.yaw }
}

/// The body for a type.
pub(crate) fn entry<'l>(library: &'l Library, kind: &str) -> Result<&'l Entry, String> {
    library.get(kind).ok_or_else(|| {
        format!("the library has no body for \"{kind}\"; it has {}", library.types())
    })
}

/// What these obstacles are called: type and id, as letters that fit a table, each name once.
pub(crate) fn names(
    recording: &Recording,
    whom: impl Iterator<Item = usize>,
) -> BTreeMap<usize, String> {
    let mut names: BTreeMap<usize, String> = BTreeMap::new();
    for whom in whom {
        let obstacle = &recording.others[whom];
        let plain = |c: char| if c.is_alphanumeric() || "-_.".contains(c) { c } else { '_' };
        let id: String = obstacle.id.chars().take(20).map(plain).collect();
        let mut name = format!("{} {id}", obstacle.kind);
        if names.iter().any(|(index, taken)| *index != whom && *taken == name) {
            name = format!("{name} ({whom})");
        }
        names.entry(whom).or_insert(name);
    }
    names
}

/// The table of a party without its motion. `nobody` is the line that says that nobody is inside:
/// each form of a scenario has its own.
pub(crate) fn party(text: &mut String, name: &str, outline: &Outline, entry: &Entry, nobody: &str) {
    let _w = writeln!(text, "[parties.{}]", quoted(name));
    let _w = match (&entry.shape, &entry.file) {
        (Some(shape), _) => {
            let (triangles, seed) = (entry.triangles.unwrap_or(20_000), entry.seed);
            let seed = if seed == 0 { String::new() } else { format!(", seed = {seed}") };
            let body = format!("{{ shape = {}, triangles = {triangles}{seed} }}", quoted(shape));
            writeln!(text, "generate = {body}")
        }
        (None, file) => writeln!(text, "file = {}", quoted(file.as_deref().unwrap_or_default())),
    };
    let [length, width] = outline.size().map(rounded);
    let _w = if outline.is_round() {
        writeln!(text, "size_m = [{length}]")
    } else {
        writeln!(text, "size_m = [{length}, {width}]")
    };
    if entry.nobody {
        let _w = writeln!(text, "{nobody}");
    }
    if entry.unknown {
        text.push_str("kind = \"unknown\"\n");
    }
}

fn state(moment: &TimedState, outline: &Outline, moved: [f64; 2]) -> String {
    let place = middle(moment, outline);
    let [x, y] = [0, 1].map(|axis| rounded(place.at[axis] - moved[axis]));
    let yaw = rounded(wrapped(place.yaw).to_degrees());
    let motion = if moment.slip == 0.0 {
        format!("speed_m_s = {}", rounded(moment.speed_m_s))
    } else {
        let [x, y] = moment.velocity_m_s().map(rounded);
        format!("velocity_m_s = [{x}, {y}]")
    };
    format!("position_m = [{x}, {y}, 0.0], yaw_deg = {yaw}, {motion}")
}

/// Rounded to 0.0001; −0 becomes +0.
pub(crate) fn rounded(value: f64) -> String {
    decimal((value * 1e4).round() / 1e4 + 0.0)
}

/// A TOML string.
pub(crate) fn quoted(text: &str) -> String {
    let mut quoted = String::from("\"");
    for c in text.chars() {
        match c {
            '"' | '\\' => quoted.extend(['\\', c]),
            c if c.is_control() => quoted.push(' '),
            c => quoted.push(c),
        }
    }
    quoted.push('"');
    quoted
}

#[cfg(test)]
mod tests;
