//! The shapes that can be generated, their names and their sizes.

use crate::BodyKind;
use core::fmt;
use core::str::FromStr;
use serde::{Deserialize, Serialize};

/// A shape that can be generated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Shape {
    /// A four-door car with a boot.
    Sedan,
    /// A tall car with a tailgate.
    Suv,
    /// A rigid lorry with a box body.
    Truck,
    /// A city bus.
    Bus,
    /// A motorcycle with its rider.
    Motorcycle,
    /// A bicycle with its rider.
    Cyclist,
    /// A person walking.
    Pedestrian,
    /// A concrete barrier with the Jersey profile, its length along x.
    Wall,
    /// A round pole, slightly tapered.
    Pole,
}

impl Shape {
    /// All shapes.
    pub const ALL: [Self; 9] = [
        Self::Sedan,
        Self::Suv,
        Self::Truck,
        Self::Bus,
        Self::Motorcycle,
        Self::Cyclist,
        Self::Pedestrian,
        Self::Wall,
        Self::Pole,
    ];

    /// The name, as used on the command line and in scenario files.
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
        }
    }

    /// Nominal length, width and height in metres.
    ///
    /// Outer mirrors protrude beyond the width by up to 0.22 m a side, as in registration papers.
    /// Shapes with a rider and the pedestrian are scaled only to their height, so their length and
    /// width are approximate.
    #[must_use]
    pub fn size_m(self) -> [f64; 3] {
        match self {
            Self::Sedan => [4.6, 1.85, 1.45],
            Self::Suv => [4.8, 1.95, 1.8],
            Self::Truck => [10.0, 2.5, 3.6],
            Self::Bus => [12.0, 2.55, 3.1],
            Self::Motorcycle => [2.22, 0.86, 1.75],
            Self::Cyclist => [1.79, 0.66, 1.75],
            Self::Pedestrian => [0.86, 0.6, 1.75],
            Self::Wall => [10.0, 0.6, 0.9],
            Self::Pole => [0.3, 0.3, 5.0],
        }
    }

    /// Whether length and width are fitted independently; otherwise they follow the height.
    #[must_use]
    pub fn is_stretched(self) -> bool {
        !matches!(self, Self::Motorcycle | Self::Cyclist | Self::Pedestrian)
    }

    /// The kind of road user or object.
    #[must_use]
    pub fn kind(self) -> BodyKind {
        match self {
            Self::Sedan => BodyKind::Sedan,
            Self::Suv => BodyKind::Suv,
            Self::Truck => BodyKind::Truck,
            Self::Bus => BodyKind::Bus,
            Self::Motorcycle => BodyKind::Motorcycle,
            Self::Cyclist => BodyKind::Cyclist,
            Self::Pedestrian => BodyKind::Pedestrian,
            Self::Wall => BodyKind::Wall,
            Self::Pole => BodyKind::Pole,
        }
    }
}

impl fmt::Display for Shape {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// There is no shape with this name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("no generated shape is called '{name}'; there are: {}", names())]
pub struct UnknownShape {
    /// The requested name.
    pub name: String,
}

fn names() -> String {
    Shape::ALL.map(Shape::name).join(", ")
}

impl FromStr for Shape {
    type Err = UnknownShape;

    fn from_str(name: &str) -> Result<Self, UnknownShape> {
        let found = Self::ALL.into_iter().find(|shape| shape.name() == name);
        found.ok_or_else(|| UnknownShape { name: name.to_owned() })
    }
}
