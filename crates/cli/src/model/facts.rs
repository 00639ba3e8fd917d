//! What is known of a body, as a table for people and as JSON.

use body::{BodyView, Build, Kind, Mesh, Meta, Seat, file};
use mesh::import::{Guess, guess};
use serde::Serialize;
use std::fmt::Write as _;
use trolley::Failure;

/// Parts that the table names; JSON names all.
const PARTS_SHOWN: usize = 20;

/// What is known of a body. Lengths are metres in the body frame: x forward, y left, z up.
#[derive(Debug, Serialize)]
pub(super) struct Facts {
    pub(super) name: String,
    pub(super) kind: Kind,
    pub(super) size_m: [f64; 3],
    min_m: [f32; 3],
    max_m: [f32; 3],
    looks_like: Option<&'static str>,
    doubts: Vec<String>,
    mass_kg: Option<f64>,
    centre_m: [f64; 3],
    gyration_m: f64,
    yaw_inertia_kg_m2: Option<f64>,
    mass_source: String,
    /// Seats of those aboard; `null` stands for a person on foot. None if nothing was stated.
    occupants: Option<Vec<Option<Seat>>>,
    pub(super) triangles: usize,
    duplicates_dropped: usize,
    degenerate_kept: u32,
    parts: Vec<Part>,
    build: Build,
    leaf_size: u32,
    depth: u32,
    nodes: usize,
    bytes: usize,
    origin: String,
    origin_hash: String,
    content_hash: String,
    #[serde(skip)]
    sentence: String,
}

#[derive(Debug, Serialize)]
struct Part {
    name: String,
    triangles: usize,
}

impl Facts {
    /// The facts of a model file that was viewed: `bytes` are all of it.
    pub(super) fn new(meta: Meta, body: &BodyView<'_>, bytes: &[u8]) -> Result<Self, Failure> {
        let content_hash = file::content_hash(bytes)?;
        let bounds = body.bounds();
        let Guess { size_m, looks_like, doubts } = guess_of(body);
        let sentence =
            Guess { size_m, looks_like: looks_like.or(Some(NOTHING)), doubts: Vec::new() };
        let mut counts = vec![0_usize; meta.parts.len()];
        for part in body.part_of {
            counts[usize::from(*part)] += 1;
        }
        let parts = meta.parts.into_iter().zip(counts);
        Ok(Self {
            sentence: sentence.to_string(),
            yaw_inertia_kg_m2: meta.mass_kg.map(|mass| mass * meta.gyration_m * meta.gyration_m),
            name: meta.name,
            kind: meta.kind,
            size_m,
            min_m: bounds.min,
            max_m: bounds.max,
            looks_like,
            doubts,
            mass_kg: meta.mass_kg,
            centre_m: meta.centre_m,
            gyration_m: meta.gyration_m,
            mass_source: meta.mass_source,
            occupants: meta.occupants.map(|all| all.iter().map(|one| one.seat).collect()),
            triangles: body.corners.len(),
            duplicates_dropped: body.dropped.len(),
            degenerate_kept: meta.degenerate,
            parts: parts.map(|(name, triangles)| Part { name, triangles }).collect(),
            build: meta.build,
            leaf_size: meta.leaf_size,
            depth: meta.depth,
            nodes: body.nodes.len(),
            bytes: bytes.len(),
            origin: meta.origin,
            origin_hash: meta.origin_hash,
            content_hash,
        })
    }

    /// The table. `read` and `notes` say what an import saw beside.
    pub(super) fn table(&self, read: Option<&str>, notes: &[String]) -> String {
        let mut text = format!("{}\n\n", self.sentence);
        let mut row = |name: &str, value: &str| {
            // Writing to a string cannot fail.
            let _done = writeln!(text, "  {name:<11} {value}");
        };
        row("name", &format!("{} ({})", shown(&self.name), self.kind));
        row("from", &shown(&self.origin));
        if let Some(read) = read {
            row("read", read);
        }
        row("triangles", &self.count());
        row("mass", &self.mass());
        let [x, y, z] = self.centre_m;
        row("centre", &format!("{x:.3}, {y:.3}, {z:.3} m forward, left, up of the origin"));
        row("reaches", &self.reach());
        row("aboard", &self.aboard());
        for (at, part) in self.parts.iter().take(PARTS_SHOWN).enumerate() {
            let name = if at == 0 { "parts" } else { "" };
            row(name, &format!("{:>9}  {}", thousands(part.triangles), shown(&part.name)));
        }
        if let Some(more) = self.parts.len().checked_sub(PARTS_SHOWN + 1) {
            row("", &format!("{:>9}  and {} more parts: see --json", "", more + 1));
        }
        row("tree", &self.tree());
        row("source", &format!("blake3 {}", self.origin_hash));
        row("content", &format!("blake3 {}", self.content_hash));
        for note in notes {
            row("note", &shown(note));
        }
        for doubt in &self.doubts {
            row("doubt", doubt);
        }
        if self.looks_like.is_some_and(|looks| !agrees(self.kind, looks)) {
            let looks = self.looks_like.unwrap_or(NOTHING);
            row("doubt", &format!("it is called a {}, but has the size of {looks}", self.kind));
        }
        text
    }

    fn count(&self) -> String {
        let mut text = thousands(self.triangles);
        if self.duplicates_dropped > 0 {
            text += &format!(", {} duplicates dropped", thousands(self.duplicates_dropped));
        }
        if self.degenerate_kept > 0 {
            text += &format!(", {} of zero area kept", thousands(self.degenerate_kept as usize));
        }
        text
    }

    fn mass(&self) -> String {
        match (self.mass_kg, self.yaw_inertia_kg_m2) {
            (Some(mass), Some(inertia)) => format!(
                "{} kg, yaw gyration {:.2} m, yaw inertia {} kg m²\n  {:<11} {}",
                rounded(mass),
                self.gyration_m,
                rounded(inertia),
                "",
                shown(&self.mass_source)
            ),
            _ => shown(&self.mass_source),
        }
    }

    fn reach(&self) -> String {
        let [a, b] = [self.min_m, self.max_m];
        format!(
            "{:.2} to {:.2} m forward, {:.2} to {:.2} m left, {:.2} to {:.2} m up",
            a[0], b[0], a[1], b[1], a[2], b[2]
        )
    }

    fn aboard(&self) -> String {
        match &self.occupants {
            None => "not stated: a scenario says who is aboard".to_owned(),
            Some(all) if all.is_empty() => "nobody".to_owned(),
            Some(all) => {
                let names: Vec<&str> =
                    all.iter().map(|seat| seat.map_or("on foot", Seat::name)).collect();
                names.join(", ")
            }
        }
    }

    fn tree(&self) -> String {
        let build = self.build.name();
        format!(
            "{build}, depth {}, {} nodes, leaves of {} at most; {:.1} MB",
            self.depth,
            thousands(self.nodes),
            self.leaf_size,
            self.bytes as f64 / 1.0e6
        )
    }
}

/// What a body of no known size looks like.
const NOTHING: &str = "like nothing known";

/// What a stored body looks like: the same guess as on import.
fn guess_of(body: &BodyView<'_>) -> Guess {
    guess(&Mesh { corners: body.corners.to_vec(), ..Mesh::default() })
}

/// Whether what a body looks like goes with what it is said to be.
fn agrees(kind: Kind, looks: &str) -> bool {
    let expected = match kind {
        Kind::Sedan | Kind::Suv => "a car",
        Kind::Truck | Kind::Bus => "a truck or bus",
        Kind::Motorcycle | Kind::Cyclist => "a motorcycle or bicycle",
        Kind::Pedestrian => "a person",
        Kind::Wall => "a wall or barrier",
        Kind::Pole => "a pole or tree",
        Kind::Building => return true,
    };
    looks == expected
}

/// "1,733", for figures of which the fraction says nothing.
fn rounded(value: f64) -> String {
    if value < 100.0 { format!("{value:.1}") } else { thousands(value.round() as usize) }
}

/// "1 triangle", "39,170 triangles".
pub(super) fn triangles(count: usize) -> String {
    format!("{} triangle{}", thousands(count), if count == 1 { "" } else { "s" })
}

/// "39,170".
pub(crate) fn thousands(count: usize) -> String {
    let digits = count.to_string();
    let mut text = String::new();
    for (at, digit) in digits.chars().enumerate() {
        if at > 0 && (digits.len() - at).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// A text of a stranger's, for a terminal: control characters could move the cursor or worse.
pub(crate) fn shown(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { '\u{fffd}' } else { c }).collect()
}
