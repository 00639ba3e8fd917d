//! Facts about the body in a model file.
//!
//! ```
//! use trolley::model::facts;
//!
//! assert_eq!(facts::triangles(39_170), "39,170 triangles");
//! ```

use crate::Failure;
use body::{BodyKind, BodyView, Build, Mesh, Meta, Seat, Shells, file};
use mesh::import::{Guess, guess};
use serde::Serialize;

/// Facts about a body. Lengths are in metres, in the body frame: x forward, y left, z up.
///
/// ```
/// # use trolley::model::{self, Generate, Shape};
/// # let folder = std::env::temp_dir().join(format!("trolley-facts-{}", std::process::id()));
/// # std::fs::create_dir_all(&folder).ok();
/// # let out = folder.join("pole.trolley");
/// # let tree = model::tree(model::Build::Paper, 4);
/// # let (shape, triangles, seed) = (Shape::Pole, 600, 0);
/// # let pole = Generate { shape, triangles, seed, tree, out: out.clone() };
/// # let generated = pole.run(&|_, _| {})?;
/// let facts = &generated.body;
/// println!("{}: {:?} m, {} triangles", facts.name, facts.size_m, facts.triangles);
/// assert!(facts.mass_kg.is_none(), "a pole is fixed to the ground");
/// # std::fs::remove_dir_all(&folder).ok();
/// # Ok::<(), trolley::Failure>(())
/// ```
#[derive(Clone, Debug, Serialize)]
pub struct Facts {
    /// Its name.
    pub name: String,
    /// Its stated kind.
    pub kind: BodyKind,
    /// Extent forward, left and up (m).
    pub size_m: [f64; 3],
    /// Least coordinates (m).
    pub min_m: [f32; 3],
    /// Greatest coordinates (m).
    pub max_m: [f32; 3],
    /// What it looks like by its size, such as "a car".
    pub looks_like: Option<&'static str>,
    /// Doubts about its unit and axes.
    pub doubts: Vec<String>,
    /// Mass (kg); `None` if it is fixed to the ground.
    pub mass_kg: Option<f64>,
    /// Centre of mass (m).
    pub centre_m: [f64; 3],
    /// Yaw radius of gyration (m).
    pub gyration_m: f64,
    /// Yaw inertia (kg m²).
    pub yaw_inertia_kg_m2: Option<f64>,
    /// Where the mass comes from.
    pub mass_source: String,
    /// What is known of its impacts, in place of the parameters in force.
    pub impact: body::OwnParameters,
    /// Where that comes from; empty if nothing is known.
    pub impact_source: String,
    /// Length and width of its outlines, without weak parts as mirrors (m).
    pub outline_m: Option<[f64; 2]>,
    /// Height of the leading edge of its front above the ground (m), if it has a front.
    pub front_height_m: Option<f64>,
    /// Seats of its occupants, `None` for a person on foot. `None` if nothing was stated.
    pub occupants: Option<Vec<Option<Seat>>>,
    /// Triangles of the body.
    pub triangles: usize,
    /// Triangles dropped on import, because another one has the same corners.
    pub duplicates_dropped: usize,
    /// Triangles of zero area.
    pub degenerate_kept: u32,
    /// Pieces that hang together by edges.
    pub shells: usize,
    /// Edges of an odd number of triangles; 0 if the body is watertight, so that each point off
    /// its surface is inside or outside.
    pub open_edges: usize,
    /// Its parts, in their order in the file.
    pub parts: Vec<BodyPart>,
    /// How its tree was built.
    pub build: Build,
    /// Most triangles in a leaf.
    pub leaf_size: u32,
    /// Nodes on the longest path from the root.
    pub depth: u32,
    /// Nodes of the tree.
    pub nodes: usize,
    /// Bytes of the model file.
    pub bytes: usize,
    /// Where the triangles come from: file name, unit, axes, or the generator's call.
    pub origin: String,
    /// BLAKE3 hash of the source bytes, or of the generator's call.
    pub origin_hash: String,
    /// BLAKE3 hash of the content of the model file.
    pub content_hash: String,
    /// Size and guess in words.
    #[serde(skip)]
    pub sentence: String,
}

/// A part of a body.
///
/// ```
/// # use trolley::model::{self, Generate, Shape};
/// # let folder = std::env::temp_dir().join(format!("trolley-part-{}", std::process::id()));
/// # std::fs::create_dir_all(&folder).ok();
/// # let out = folder.join("pole.trolley");
/// # let tree = model::tree(model::Build::Paper, 4);
/// # let (shape, triangles, seed) = (Shape::Pole, 600, 0);
/// # let pole = Generate { shape, triangles, seed, tree, out: out.clone() };
/// # let generated = pole.run(&|_, _| {})?;
/// for part in &generated.body.parts {
///     println!("{}: {}", part.name, model::facts::triangles(part.triangles));
/// }
/// # std::fs::remove_dir_all(&folder).ok();
/// # Ok::<(), trolley::Failure>(())
/// ```
#[derive(Clone, Debug, Serialize)]
pub struct BodyPart {
    /// Its name.
    pub name: String,
    /// Its triangles.
    pub triangles: usize,
}

impl Facts {
    /// Collects the facts of a model file that was [viewed](super::open::view); `bytes` are all of
    /// it.
    ///
    /// ```
    /// # use trolley::model::{self, Generate, Shape};
    /// # let folder = std::env::temp_dir();
    /// # let folder = folder.join(format!("trolley-facts-new-{}", std::process::id()));
    /// # std::fs::create_dir_all(&folder).ok();
    /// # let out = folder.join("pole.trolley");
    /// # let tree = model::tree(model::Build::Paper, 4);
    /// # let (shape, triangles, seed) = (Shape::Pole, 600, 0);
    /// # let pole = Generate { shape, triangles, seed, tree, out: out.clone() };
    /// # let generated = pole.run(&|_, _| {})?;
    /// use trolley::model::{Facts, open};
    ///
    /// let map = open::bytes(&out, trolley::files::InputKind::Model)?;
    /// let (meta, view) = open::view(&out, map.bytes())?;
    /// assert_eq!(Facts::new(meta, &view, map.bytes())?.triangles, 600);
    /// # std::fs::remove_dir_all(&folder).ok();
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    ///
    /// # Errors
    ///
    /// If the bytes are not a model file.
    pub fn new(meta: Meta, body: &BodyView<'_>, bytes: &[u8]) -> Result<Self, Failure> {
        let content_hash = file::content_hash(bytes)?;
        let bounds = body.bounds();
        let shells = Shells::of(body.corners);
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
            impact: meta.impact,
            impact_source: meta.impact_source,
            outline_m: meta.outlines.size_m(),
            front_height_m: meta.front_height_m,
            occupants: meta.occupants.map(|all| all.iter().map(|one| one.seat).collect()),
            triangles: body.corners.len(),
            duplicates_dropped: body.dropped.len(),
            degenerate_kept: meta.degenerate,
            shells: shells.kinds().len(),
            open_edges: shells.open_edges(),
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

    /// Returns a sentence if the size of the body contradicts its kind.
    ///
    /// ```
    /// # use trolley::model::{self, Generate, Shape};
    /// # let folder = std::env::temp_dir();
    /// # let folder = folder.join(format!("trolley-contradiction-{}", std::process::id()));
    /// # std::fs::create_dir_all(&folder).ok();
    /// # let out = folder.join("pole.trolley");
    /// # let tree = model::tree(model::Build::Paper, 4);
    /// # let (shape, triangles, seed) = (Shape::Pole, 600, 0);
    /// # let pole = Generate { shape, triangles, seed, tree, out: out.clone() };
    /// # let generated = pole.run(&|_, _| {})?;
    /// assert!(generated.body.contradiction().is_none(), "the pole has the size of a pole");
    /// # std::fs::remove_dir_all(&folder).ok();
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    #[must_use]
    pub fn contradiction(&self) -> Option<String> {
        let looks = self.looks_like.filter(|looks| !agrees(self.kind, looks))?;
        Some(format!("it is called a {}, but has the size of {looks}", self.kind))
    }
}

/// What a body of no known size looks like.
const NOTHING: &str = "like nothing known";

/// What a stored body looks like: the guess made on import.
fn guess_of(body: &BodyView<'_>) -> Guess {
    guess(&Mesh { corners: body.corners.to_vec(), ..Mesh::default() })
}

/// Whether what a body looks like agrees with its kind.
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

/// Returns a count of triangles in words: "1 triangle", "39,170 triangles".
///
/// ```
/// use trolley::model::facts::triangles;
///
/// assert_eq!([triangles(1), triangles(39_170)], ["1 triangle", "39,170 triangles"]);
/// ```
#[must_use]
pub fn triangles(count: usize) -> String {
    format!("{} triangle{}", thousands(count), if count == 1 { "" } else { "s" })
}

/// Returns in words whether a surface is closed, which tells inside from outside.
///
/// ```
/// use trolley::model::facts::surface;
///
/// assert_eq!(surface(1, 0), "watertight, 1 shell");
/// assert_eq!(surface(22, 1_200), "not watertight: 1,200 open edges, 22 shells");
/// ```
#[must_use]
pub fn surface(shells: usize, open_edges: usize) -> String {
    let plural = |count: usize| if count == 1 { "" } else { "s" };
    let shells = format!("{} shell{}", thousands(shells), plural(shells));
    match open_edges {
        0 => format!("watertight, {shells}"),
        open => format!("not watertight: {} open edge{}, {shells}", thousands(open), plural(open)),
    }
}

/// Returns a count with thousands separators: "39,170".
///
/// ```
/// assert_eq!(trolley::model::facts::thousands(39_170), "39,170");
/// ```
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
