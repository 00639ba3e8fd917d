//! The metadata of a body: kind, mass, seats, origin, and how its tree was built.

use crate::impact::OwnParameters;
use crate::outline::Outlines;
use serde::{Deserialize, Serialize};

/// The kind of road user or object. It determines defaults and injury curves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum BodyKind {
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

/// The seat of a person, which has a zone bit.
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
    /// On a motorcycle or bicycle: who steers it.
    Rider,
    /// Behind the rider.
    Pillion,
}

/// How the tree of a body was built.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Build {
    /// The split of Wiseman and Grinberg with k in [n/8, 7n/8].
    #[default]
    Paper,
    /// The paper's split without a balance rule: peels slivers, depth up to thousands.
    Literal,
    /// Binned surface-area heuristic.
    Sah,
}

impl Build {
    /// All builds, the default first.
    pub const ALL: [Self; 3] = [Self::Paper, Self::Literal, Self::Sah];

    /// The name, as used in files and on the command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Paper => "paper",
            Self::Literal => "literal",
            Self::Sah => "sah",
        }
    }

    /// The build with this name. Files from before 0.1.0 call [`Build::Paper`] "seed".
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        let name = if name == "seed" { Self::Paper.name() } else { name };
        Self::ALL.into_iter().find(|build| build.name() == name)
    }
}

/// A person that belongs to a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Occupant {
    /// The seat; `None` for a pedestrian.
    pub seat: Option<Seat>,
}

/// The metadata of a body.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Meta {
    /// Name, from the file or the generator.
    pub name: String,
    /// The kind.
    pub kind: BodyKind,
    /// Mass `[kg]`; `None` for an object fixed to the ground.
    pub mass_kg: Option<f64>,
    /// Centre of mass, body frame `[m]`.
    pub centre_m: [f64; 3],
    /// Yaw radius of gyration k `[m]`; yaw inertia = m k².
    pub gyration_m: f64,
    /// Source of mass, centre and gyration: a file, or the source of the default.
    pub mass_source: String,
    /// What is known of its impacts, in place of the parameters in force.
    pub impact: OwnParameters,
    /// Where that comes from; empty if nothing is known.
    pub impact_source: String,
    /// Persons aboard unless a scenario says otherwise; `None` if not stated.
    pub occupants: Option<Vec<Occupant>>,
    /// Names of parts, indexed by `part_of`.
    pub parts: Vec<String>,
    /// Where the triangles come from: file name, unit, axes, or the generator's call.
    pub origin: String,
    /// BLAKE3 of the source bytes, hexadecimal; for generated bodies, of the call.
    pub origin_hash: String,
    /// Triangles with zero area, kept.
    pub degenerate: u32,
    /// How the tree was built.
    pub build: Build,
    /// Maximum number of triangles in a leaf, at most [`LEAF_SIZE_MAX`].
    pub leaf_size: u32,
    /// Depth of the tree: number of nodes on the longest path from the root, 1 for a single leaf.
    pub depth: u32,
    /// The outlines in plan that carry an impact: what makes the plane of a contact.
    pub outlines: Outlines,
    /// Height of the leading edge of the front above the ground `[m]`
    /// ([`crate::outline::front_height_m`]); `None` for what has no front.
    pub front_height_m: Option<f64>,
}

/// Maximum number of triangles that a leaf of the binary tree may hold.
pub const LEAF_SIZE_MAX: u32 = 64;

/// Maximum mass of a body that moves, in kilograms.
pub const MASS_MAX_KG: f64 = 1.0e6;

/// Maximum yaw radius of gyration, and distance of the centre of mass from the origin, in metres.
pub const LENGTH_MAX_M: f64 = 1.0e6;

impl BodyKind {
    /// Every kind, in the order of the declaration.
    pub const ALL: [Self; 10] = [
        Self::Sedan,
        Self::Suv,
        Self::Truck,
        Self::Bus,
        Self::Motorcycle,
        Self::Cyclist,
        Self::Pedestrian,
        Self::Wall,
        Self::Pole,
        Self::Building,
    ];

    /// The name, as used in files and on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Sedan => "sedan",
            Self::Suv => "suv",
            Self::Truck => "truck",
            Self::Bus => "bus",
            Self::Motorcycle => "motorcycle",
            Self::Cyclist => "cyclist",
            Self::Pedestrian => "pedestrian",
            Self::Wall => "wall",
            Self::Pole => "pole",
            Self::Building => "building",
        }
    }

    /// Whether the body is fixed to the ground: it has no mass and no occupants.
    #[must_use]
    pub fn is_fixed(self) -> bool {
        matches!(self, Self::Wall | Self::Pole | Self::Building)
    }

    /// Whether it is a vehicle with a body around its occupants.
    #[must_use]
    pub fn is_car_like(self) -> bool {
        matches!(self, Self::Sedan | Self::Suv | Self::Truck | Self::Bus)
    }

    /// Seats that a body of this kind may have.
    #[must_use]
    pub fn seats(self) -> &'static [Seat] {
        match self {
            Self::Sedan | Self::Suv | Self::Bus => &[
                Seat::FrontLeft,
                Seat::FrontRight,
                Seat::RearLeft,
                Seat::RearMiddle,
                Seat::RearRight,
            ],
            Self::Truck => &[Seat::FrontLeft, Seat::FrontRight],
            Self::Motorcycle | Self::Cyclist => &[Seat::Rider, Seat::Pillion],
            Self::Pedestrian | Self::Wall | Self::Pole | Self::Building => &[],
        }
    }
}

impl core::fmt::Display for BodyKind {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.pad(self.name())
    }
}

/// The text is not the name of a [`BodyKind`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "\"{0}\" is no kind: one of sedan, suv, truck, bus, motorcycle, cyclist, pedestrian, wall, \
         pole, building"
)]
pub struct UnknownKind(pub String);

impl core::str::FromStr for BodyKind {
    type Err = UnknownKind;

    fn from_str(text: &str) -> Result<Self, UnknownKind> {
        let found = Self::ALL.into_iter().find(|kind| kind.name() == text);
        found.ok_or_else(|| UnknownKind(text.to_owned()))
    }
}

impl Seat {
    /// All seats. Files and messages number them, so a new one is the last.
    pub const ALL: [Self; 7] = [
        Self::FrontLeft,
        Self::FrontRight,
        Self::RearLeft,
        Self::RearMiddle,
        Self::RearRight,
        Self::Rider,
        Self::Pillion,
    ];

    /// The bit of [`crate::Zones`] for "beside this seat".
    #[must_use]
    pub fn zone_bit(self) -> u16 {
        1 << (8 + self as u16)
    }

    /// The name, as used in files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::FrontLeft => "front-left",
            Self::FrontRight => "front-right",
            Self::RearLeft => "rear-left",
            Self::RearMiddle => "rear-middle",
            Self::RearRight => "rear-right",
            Self::Rider => "rider",
            Self::Pillion => "pillion",
        }
    }
}

impl Meta {
    /// Checks every value that consumers divide by or index with.
    ///
    /// # Errors
    ///
    /// A description of the value that is not finite, out of range or contradicts the kind.
    pub fn check(&self) -> Result<(), String> {
        match self.mass_kg {
            Some(_) if self.kind.is_fixed() => {
                return Err(format!("a {} is fixed to the ground and has no mass", self.kind));
            }
            None if !self.kind.is_fixed() => return Err(format!("a {} needs a mass", self.kind)),
            Some(mass) if !(mass > 0.0 && mass <= MASS_MAX_KG) => {
                return Err(format!("mass {mass} kg is not in (0, {MASS_MAX_KG}]"));
            }
            _ => {}
        }
        if !(self.gyration_m > 0.0 && self.gyration_m <= LENGTH_MAX_M) {
            return Err(format!("radius of gyration {} m is not positive", self.gyration_m));
        }
        if self.centre_m.iter().any(|x| !(x.abs() <= LENGTH_MAX_M)) {
            return Err(format!("centre of mass {:?} m is not finite", self.centre_m));
        }
        self.impact.check(self.kind)?;
        if self.impact_source.trim().is_empty() && !self.impact.is_empty() {
            return Err("what is known of its impacts has no source".to_owned());
        }
        if self.parts.len() > usize::from(u16::MAX) + 1 {
            return Err(format!("{} parts are too many", self.parts.len()));
        }
        for (at, occupant) in self.occupants.iter().flatten().enumerate() {
            let earlier = self.occupants.iter().flatten().take(at);
            check_occupant(self.kind, *occupant, earlier)?;
        }
        if self.front_height_m.is_some_and(|height| !(0.0..=LENGTH_MAX_M).contains(&height)) {
            return Err(format!("the height of its front is {:?} m", self.front_height_m));
        }
        self.outlines.check()
    }
}

fn check_occupant<'a>(
    kind: BodyKind,
    occupant: Occupant,
    mut earlier: impl Iterator<Item = &'a Occupant>,
) -> Result<(), String> {
    match occupant.seat {
        Some(seat) if !kind.seats().contains(&seat) => {
            Err(format!("a {kind} has no seat {}", seat.name()))
        }
        None if kind != BodyKind::Pedestrian => {
            Err(format!("an occupant of a {kind} needs a seat"))
        }
        Some(seat) if earlier.any(|other| *other == occupant) => {
            Err(format!("two occupants on seat {}", seat.name()))
        }
        None if earlier.next().is_some() => Err("a pedestrian is one person".to_owned()),
        _ => Ok(()),
    }
}
