//! Pieces of the text of a scenario.
//!
//! Bodies are put where the middle of their outline is, stretched to its length and width; a circle
//! gives a body its longest side. Coordinates are rounded to 0.1 mm and 0.0001°.

use crate::library::{Entry, Library};
use crate::outline::{Outline, Placed};
use crate::recording::{Recording, StateSpread, TimedState};
use scenario::{CANDIDATES_MAX, decimal};
use std::collections::BTreeMap;
use std::fmt::Write as _;

/// Coordinates beyond this are moved so that the ego starts near the origin (m): maps count from a
/// far away equator.
const FAR_M: f64 = 100_000.0;

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

/// What these obstacles are called: type and id, as letters that fit a table, each name once. An id
/// that begins with the type is enough.
pub(crate) fn names(
    recording: &Recording,
    whom: impl Iterator<Item = usize>,
) -> BTreeMap<usize, String> {
    let mut names: BTreeMap<usize, String> = BTreeMap::new();
    for whom in whom {
        let obstacle = &recording.others[whom];
        let plain = |c: char| if c.is_alphanumeric() || "-_.".contains(c) { c } else { '_' };
        let id: String = obstacle.id.chars().take(20).map(plain).collect();
        let says_kind = id.starts_with(obstacle.kind.as_str());
        let mut name = if says_kind { id } else { format!("{} {id}", obstacle.kind) };
        if names.iter().any(|(index, taken)| *index != whom && *taken == name) {
            name = format!("{name} ({whom})");
        }
        names.entry(whom).or_insert(name);
    }
    names
}

/// The table of a party without its motion.
pub(crate) fn party(text: &mut String, name: &str, outline: &Outline, entry: &Entry) {
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
        text.push_str("empty = true\n");
    }
    if entry.unknown {
        text.push_str("kind = \"unknown\"\n");
    }
}

/// How well a party is known, where the recording says so, and the values that a scenario cannot
/// hold, which are cut, in words. `speed_m_s` is its speed: a scenario has errors as shares of it.
pub(crate) fn errors(
    text: &mut String,
    spread: &StateSpread,
    speed_m_s: f64,
) -> Option<&'static str> {
    // The limits of `scenario`.
    let most = [10.0, 10.0, 90.0, 0.5];
    let share = if speed_m_s == 0.0 { f64::INFINITY } else { spread.speed_m_s / speed_m_s.abs() };
    let share = if spread.speed_m_s == 0.0 { 0.0 } else { share };
    let values = [spread.longitudinal_m, spread.lateral_m, spread.yaw.to_degrees(), share];
    let names = ["longitudinal_m", "lateral_m", "yaw_deg", "speed_share"];
    let stated = || names.iter().zip(values).zip(most).filter(|((_, value), _)| *value > 0.0);
    let said: Vec<String> = stated()
        .map(|((name, value), most)| format!("{name} = {}", rounded(value.min(most))))
        .collect();
    if !said.is_empty() {
        let _w = writeln!(text, "errors = {{ {} }}", said.join(", "));
    }
    stated().any(|((_, value), most)| value > most).then_some(
        "its first state is known less well than a scenario can say (10 m, 90°, half of its speed)",
    )
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
