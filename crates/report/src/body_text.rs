//! A body, a mesh or a checked file as lines for a terminal.

use std::fmt::Write as _;
use trolley::model::facts::{surface, triangles};
use trolley::model::{Facts, FileCheck, MeshInfo, Reading, Report, Seat};

pub use trolley::model::facts::thousands;

/// Maximum number of parts in the table; JSON has all.
const PARTS_SHOWN: usize = 20;

/// The table. `read` and `notes` come from an import.
#[must_use]
pub fn table(facts: &Facts, read: Option<&str>, notes: &[String]) -> String {
    let mut text = format!("{}\n\n", facts.sentence);
    let mut row = |name: &str, value: &str| {
        // Writing to a string cannot fail.
        let _done = writeln!(text, "  {name:<11} {value}");
    };
    row("name", &format!("{} ({})", shown(&facts.name), facts.kind));
    row("from", &shown(&facts.origin));
    if let Some(read) = read {
        row("read", read);
    }
    row("triangles", &count(facts));
    row("surface", &surface(facts.shells, facts.open_edges));
    row("mass", &mass(facts));
    let [x, y, z] = facts.centre_m;
    row("centre", &format!("{x:.3}, {y:.3}, {z:.3} m forward, left, up of the origin"));
    row("reaches", &reach(facts));
    if let Some([length, width]) = facts.outline_m {
        let front = facts
            .front_height_m
            .map_or(String::new(), |height| format!("; edge of the front at {height:.2} m"));
        row("outline", &format!("{length:.2} by {width:.2} m without weak parts{front}"));
    }
    if let Some(impact) = impact(facts) {
        row("impact", &impact);
    }
    row("aboard", &aboard(facts));
    for (at, part) in facts.parts.iter().take(PARTS_SHOWN).enumerate() {
        let name = if at == 0 { "parts" } else { "" };
        row(name, &format!("{:>9}  {}", thousands(part.triangles), shown(&part.name)));
    }
    if let Some(more) = facts.parts.len().checked_sub(PARTS_SHOWN + 1) {
        row("", &format!("{:>9}  and {} more parts: see --json", "", more + 1));
    }
    row("tree", &tree(facts));
    row("source", &format!("blake3 {}", facts.origin_hash));
    row("content", &format!("blake3 {}", facts.content_hash));
    for note in notes {
        row("note", &shown(note));
    }
    for doubt in &facts.doubts {
        row("doubt", doubt);
    }
    if let Some(doubt) = facts.contradiction() {
        row("doubt", &doubt);
    }
    text
}

fn count(facts: &Facts) -> String {
    let mut text = thousands(facts.triangles);
    if facts.duplicates_dropped > 0 {
        text += &format!(", {} duplicates dropped", thousands(facts.duplicates_dropped));
    }
    if facts.degenerate_kept > 0 {
        text += &format!(", {} of zero area kept", thousands(facts.degenerate_kept as usize));
    }
    text
}

/// What is known of its impacts: "e 0.12 in 0.05–0.2, mass to 2 %; from taxi.toml (a data sheet)".
fn impact(facts: &Facts) -> Option<String> {
    let own = &facts.impact;
    let ranges = [("e", own.restitution), ("μ", own.friction)];
    let values = [
        ("added to e of faces up to 30°", own.face_restitution_more),
        ("along faces", own.face_tangential_share),
    ];
    let shares = [("mass", own.mass_share), ("gyration", own.gyration_share)];
    let ranges = ranges.into_iter().filter_map(|(name, of)| {
        of.map(|of| format!("{name} {} in {}–{}", of.nominal, of.low, of.high))
    });
    let values = values.into_iter().filter_map(|(name, of)| of.map(|of| format!("{of} {name}")));
    let shares = shares
        .into_iter()
        .filter_map(|(name, of)| of.map(|of| format!("{name} to {} %", rounded(100.0 * of))));
    let known: Vec<String> = ranges.chain(values).chain(shares).collect();
    let is_known = !known.is_empty();
    is_known.then(|| format!("{}; from {}", known.join(", "), shown(&facts.impact_source)))
}

fn mass(facts: &Facts) -> String {
    match (facts.mass_kg, facts.yaw_inertia_kg_m2) {
        (Some(mass), Some(inertia)) => format!(
            "{} kg, yaw gyration {:.2} m, yaw inertia {} kg m²\n  {:<11} {}",
            rounded(mass),
            facts.gyration_m,
            rounded(inertia),
            "",
            shown(&facts.mass_source)
        ),
        _ => shown(&facts.mass_source),
    }
}

fn reach(facts: &Facts) -> String {
    let [a, b] = [facts.min_m, facts.max_m];
    format!(
        "{:.2} to {:.2} m forward, {:.2} to {:.2} m left, {:.2} to {:.2} m up",
        a[0], b[0], a[1], b[1], a[2], b[2]
    )
}

fn aboard(facts: &Facts) -> String {
    match &facts.occupants {
        None => "not stated: a scenario says who is aboard".to_owned(),
        Some(all) if all.is_empty() => "nobody".to_owned(),
        Some(all) => {
            let names: Vec<&str> =
                all.iter().map(|seat| seat.map_or("on foot", Seat::name)).collect();
            names.join(", ")
        }
    }
}

fn tree(facts: &Facts) -> String {
    format!(
        "{}, depth {}, {} nodes, leaves of {} at most; {:.1} MB",
        facts.build.name(),
        facts.depth,
        thousands(facts.nodes),
        facts.leaf_size,
        facts.bytes as f64 / 1.0e6
    )
}

/// "1,733", without a meaningless fraction.
fn rounded(value: f64) -> String {
    if value < 100.0 { format!("{value:.1}") } else { thousands(value.round() as usize) }
}

/// "OBJ, 36,972 triangles, of which 26,756 in the selected parts; body.toml".
#[must_use]
pub fn read(report: &Report) -> String {
    let mut text = format!("{}, {}", report.format, triangles(report.triangles_in_file));
    if report.triangles_selected != report.triangles_in_file {
        let selected = thousands(report.triangles_selected);
        text += &format!(", of which {selected} in the selected parts");
    }
    if let Some(side) = &report.side_file {
        text += &format!("; side file {side}");
    }
    text
}

/// The line of a checked file.
#[must_use]
pub fn verdict(verdict: &FileCheck) -> String {
    let (state, mut text) = match (&verdict.what, &verdict.fault) {
        (Some(what), _) => ("ok", format!("{}: {what}", verdict.file)),
        (None, fault) => ("refused", fault.clone().unwrap_or_default()),
    };
    for doubt in &verdict.doubts {
        text += &format!("; {doubt}");
    }
    if let Some(help) = &verdict.help {
        text += &format!("; help: {help}");
    }
    format!("{state:<8} {}", shown(&text))
}

/// The contents of a mesh, and suggestions of its unit and axes.
#[must_use]
pub fn mesh(info: &MeshInfo) -> String {
    let [x, y, z] = info.extent;
    let mut text = format!(
        "{}: {} mesh, {} triangles, {x:.5} × {y:.5} × {z:.5} along x, y, z in its own numbers\n",
        shown(&info.file),
        info.format,
        thousands(info.triangles)
    );
    for (at, part) in info.parts.iter().take(12).enumerate() {
        let _w = writeln!(text, "  {:<7}{}", if at == 0 { "parts" } else { "" }, shown(part));
    }
    if info.parts.len() > 12 {
        let _w = writeln!(text, "         and {} more", info.parts.len() - 12);
    }
    for note in &info.notes {
        let _w = writeln!(text, "  note   {}", shown(note));
    }
    if info.readings.is_empty() {
        text +=
            "It matches no known kind of body in any usual unit: state both when you import it.\n";
    }
    for (at, reading) in info.readings.iter().enumerate() {
        let [length, width, height] = reading.size_m;
        let Reading { unit, up, forward, looks_like, kind, .. } = reading;
        let mass = match reading.mass_kg {
            Some(mass) => format!("{} kg unless you state it", rounded(mass)),
            None => "fixed to the ground".to_owned(),
        };
        let start = if at == 0 { "It looks like" } else { "  or like" };
        let _w = writeln!(
            text,
            "{start} {looks_like} in {unit}, up +{up}, forward {} ({length:.2} × {width:.2} × \
             {height:.2} m; as a {kind} {mass}): --unit {unit} --up {up} --forward {forward} \
             --kind {kind}",
            if forward.starts_with('-') { forward.clone() } else { format!("+{forward}") }
        );
    }
    text += "These are suggestions: nothing is applied. The front end is a guess; check it.";
    text
}

/// Untrusted text, safe for a terminal: control characters are replaced.
#[must_use]
pub fn shown(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { '\u{fffd}' } else { c }).collect()
}
