//! What is known of a body that lies in a model file.

use crate::Failure;
use body::{BodyKind, BodyView, Build, Mesh, Meta, Seat, file};
use mesh::import::{Guess, guess};
use serde::Serialize;

/// What is known of a body. Lengths are metres in the body frame: x forward, y left, z up.
#[derive(Clone, Debug, Serialize)]
pub struct Facts {
    /// What it is called.
    pub name: String,
    /// What it is said to be.
    pub kind: BodyKind,
    /// Extent forward, left and up (m).
    pub size_m: [f64; 3],
    /// Least coordinates (m).
    pub min_m: [f32; 3],
    /// Greatest coordinates (m).
    pub max_m: [f32; 3],
    /// What it has the size of: "a car".
    pub looks_like: Option<&'static str>,
    /// What speaks against its unit and axes.
    pub doubts: Vec<String>,
    /// Mass (kg); none: it is fixed to the ground.
    pub mass_kg: Option<f64>,
    /// Centre of mass (m).
    pub centre_m: [f64; 3],
    /// Yaw radius of gyration (m).
    pub gyration_m: f64,
    /// Yaw inertia (kg m²).
    pub yaw_inertia_kg_m2: Option<f64>,
    /// Where the mass is from.
    pub mass_source: String,
    /// Seats of those aboard; `null` stands for a person on foot. None if nothing was stated.
    pub occupants: Option<Vec<Option<Seat>>>,
    /// Triangles of the body.
    pub triangles: usize,
    /// Triangles left out on import, because another has the same corners.
    pub duplicates_dropped: usize,
    /// Triangles of zero area.
    pub degenerate_kept: u32,
    /// Its parts, in their order in the file.
    pub parts: Vec<BodyPart>,
    /// How its tree was built.
    pub build: Build,
    /// Triangles in a leaf at most.
    pub leaf_size: u32,
    /// Nodes on the longest way from the root.
    pub depth: u32,
    /// Nodes of the tree.
    pub nodes: usize,
    /// Bytes of the model file.
    pub bytes: usize,
    /// Where the triangles come from: file name, unit, axes, or the generator's call.
    pub origin: String,
    /// BLAKE3 of the source bytes, or of the call.
    pub origin_hash: String,
    /// BLAKE3 of what the model file holds.
    pub content_hash: String,
    /// Size and guess in words.
    #[serde(skip)]
    pub sentence: String,
}

/// A part of a body.
#[derive(Clone, Debug, Serialize)]
pub struct BodyPart {
    /// What it is called.
    pub name: String,
    /// Its triangles.
    pub triangles: usize,
}

impl Facts {
    /// The facts of a model file that was [viewed](super::open::view): `bytes` are all of it.
    ///
    /// # Errors
    ///
    /// If the bytes are no model file.
    pub fn new(meta: Meta, body: &BodyView<'_>, bytes: &[u8]) -> Result<Self, Failure> {
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
            parts: parts.map(|(name, triangles)| BodyPart { name, triangles }).collect(),
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

    /// That it has the size of something else than it is said to be, if so.
    #[must_use]
    pub fn contradiction(&self) -> Option<String> {
        let looks = self.looks_like.filter(|looks| !agrees(self.kind, looks))?;
        Some(format!("it is called a {}, but has the size of {looks}", self.kind))
    }
}

/// What a body of no known size looks like.
const NOTHING: &str = "like nothing known";

/// What a stored body looks like: the same guess as on import.
fn guess_of(body: &BodyView<'_>) -> Guess {
    guess(&Mesh { corners: body.corners.to_vec(), ..Mesh::default() })
}

/// Whether what a body looks like goes with what it is said to be.
fn agrees(kind: BodyKind, looks: &str) -> bool {
    let expected = match kind {
        BodyKind::Sedan | BodyKind::Suv => "a car",
        BodyKind::Truck | BodyKind::Bus => "a truck or bus",
        BodyKind::Motorcycle | BodyKind::Cyclist => "a motorcycle or bicycle",
        BodyKind::Pedestrian => "a person",
        BodyKind::Wall => "a wall or barrier",
        BodyKind::Pole => "a pole or tree",
        BodyKind::Building => return true,
    };
    looks == expected
}

/// A count of triangles as people read it: "1 triangle", "39,170 triangles".
#[must_use]
pub fn triangles(count: usize) -> String {
    format!("{} triangle{}", thousands(count), if count == 1 { "" } else { "s" })
}

/// A count as people read it: "39,170".
#[must_use]
pub fn thousands(count: usize) -> String {
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
