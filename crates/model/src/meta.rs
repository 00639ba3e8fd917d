//! What is known of a body beside its triangles: kind, mass, seats, origin, and how its tree was made.

use serde::{Deserialize, Serialize};

/// What kind of road user or object a body is. It chooses defaults and injury curves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// A passenger car: sedan, hatchback, estate.
    Sedan,
    /// A tall passenger car, a pick-up, a van.
    Suv,
    /// A lorry.
    Truck,
    /// A bus or coach.
    Bus,
    /// A motorcycle with its rider.
    Motorcycle,
    /// A bicycle with its rider.
    Cyclist,
    /// A person on foot.
    Pedestrian,
    /// A wall or barrier, fixed.
    Wall,
    /// A pole or tree, fixed.
    Pole,
    /// A building, fixed and concave.
    Building,
}

/// Where a person sits, and which zone bit stands for it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Seat {
    /// Front left.
    FrontLeft,
    /// Front right.
    FrontRight,
    /// Rear left.
    RearLeft,
    /// Rear middle.
    RearMiddle,
    /// Rear right.
    RearRight,
    /// On a motorcycle or bicycle.
    Rider,
}

/// How the tree of a body was built.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Build {
    /// The split of Wiseman and Grinberg with k in [n/8, 7n/8].
    #[default]
    Seed,
    /// The same split by the letter: peels slivers, depth up to thousands.
    Literal,
    /// Binned surface-area heuristic.
    Sah,
}

/// A person that belongs to a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Occupant {
    /// The seat; `None` for a pedestrian.
    pub seat: Option<Seat>,
}

/// Everything known of a body beside its triangles.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Meta {
    /// Name, from the file or the generator.
    pub name: String,
    /// Kind.
    pub kind: Kind,
    /// Mass [kg]; `None` for an object fixed to the ground.
    pub mass_kg: Option<f64>,
    /// Centre of mass, body frame [m].
    pub centre_m: [f64; 3],
    /// Yaw radius of gyration k [m]; yaw inertia = m k².
    pub gyration_m: f64,
    /// Where mass, centre and gyration come from: a file, or the default's source.
    pub mass_source: String,
    /// Persons aboard if a scenario does not say otherwise; `None` if nothing was stated.
    pub occupants: Option<Vec<Occupant>>,
    /// Names of parts; `part_of` counts into it.
    pub parts: Vec<String>,
    /// Where the triangles come from: file name, unit, axes, or the generator's call.
    pub origin: String,
    /// BLAKE3 of the source bytes, hexadecimal; of the call for generated bodies.
    pub origin_hash: String,
    /// Triangles with zero area, kept.
    pub degenerate: u32,
    /// How the tree was built.
    pub build: Build,
    /// Greatest number of triangles in a leaf.
    pub leaf_size: u32,
    /// Depth of the tree: nodes on the longest way from the root, 1 for a single leaf.
    pub depth: u32,
}
