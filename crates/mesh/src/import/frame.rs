//! From a file's unit and axes to the body frame: metres, x forward, y left, z up.

use super::{Format, MeshDefect};
use core::{fmt, str::FromStr};
use diagnostic::{Diagnostic, FailureKind};

/// Length of one unit of a file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LengthUnit {
    metres: f64,
}

impl LengthUnit {
    /// Metres.
    pub const METRE: Self = Self { metres: 1.0 };

    /// Names accepted by [`LengthUnit::from_str`] besides numbers, with their lengths in metres.
    pub const NAMED: [(&'static str, f64); 5] =
        [("m", 1.0), ("dm", 0.1), ("cm", 0.01), ("mm", 0.001), ("inch", 0.0254)];

    /// Length in metres.
    #[must_use]
    pub fn metres(self) -> f64 {
        self.metres
    }
}

impl Default for LengthUnit {
    fn default() -> Self {
        Self::METRE
    }
}

impl fmt::Display for LengthUnit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match Self::NAMED.iter().find(|(_, metres)| *metres == self.metres) {
            Some((name, _)) => f.pad(name),
            None => write!(f, "{} m", self.metres),
        }
    }
}

/// The text is not a [`LengthUnit`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("\"{0}\" is not a unit: one of m, dm, cm, mm, inch, or a factor to metres above 0")]
pub struct UnknownUnit(pub String);

impl Diagnostic for UnknownUnit {
    fn kind(&self) -> FailureKind {
        FailureKind::Configuration
    }
}

impl FromStr for LengthUnit {
    type Err = UnknownUnit;

    fn from_str(text: &str) -> Result<Self, UnknownUnit> {
        let named = Self::NAMED.iter().find(|(name, _)| *name == text).map(|(_, metres)| *metres);
        let metres = named.or_else(|| text.parse().ok());
        match metres {
            Some(metres) if (1e-9..=1e9).contains(&metres) => Ok(Self { metres }),
            _ => Err(UnknownUnit(text.to_owned())),
        }
    }
}

/// A direction along an axis of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Axis {
    index: usize,
    negative: bool,
}

impl Axis {
    /// +x.
    pub const X: Self = Self { index: 0, negative: false };
    /// +y.
    pub const Y: Self = Self { index: 1, negative: false };
    /// +z.
    pub const Z: Self = Self { index: 2, negative: false };

    /// 0, 1, 2 for x, y, z, whichever way it points.
    pub(super) fn index(self) -> usize {
        self.index
    }

    fn vector(self) -> [f64; 3] {
        let mut vector = [0.0; 3];
        vector[self.index] = if self.negative { -1.0 } else { 1.0 };
        vector
    }

    fn of(vector: [f64; 3]) -> Self {
        let index = vector.iter().position(|x| *x != 0.0).unwrap_or(0);
        Self { index, negative: vector[index] < 0.0 }
    }

    fn component(self, point: [f64; 3]) -> f64 {
        if self.negative { -point[self.index] } else { point[self.index] }
    }
}

impl fmt::Display for Axis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let sign = if self.negative { '-' } else { '+' };
        write!(f, "{sign}{}", ["x", "y", "z"][self.index])
    }
}

/// The text is not an [`Axis`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("\"{0}\" is not an axis: one of +x, -x, +y, -y, +z, -z")]
pub struct UnknownAxis(pub String);

impl Diagnostic for UnknownAxis {
    fn kind(&self) -> FailureKind {
        FailureKind::Configuration
    }
}

impl FromStr for Axis {
    type Err = UnknownAxis;

    /// The plus sign is optional; case does not matter.
    fn from_str(text: &str) -> Result<Self, UnknownAxis> {
        let lower = text.to_ascii_lowercase();
        let (negative, name) = match lower.strip_prefix('-') {
            Some(name) => (true, name),
            None => (false, lower.strip_prefix('+').unwrap_or(&lower)),
        };
        let index = ["x", "y", "z"].iter().position(|axis| *axis == name);
        index.map(|index| Self { index, negative }).ok_or_else(|| UnknownAxis(text.to_owned()))
    }
}

/// The unit and the up axis that a file states.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StatedFrame {
    /// Unit of its coordinates.
    pub unit: LengthUnit,
    /// Up in the file.
    pub up: Axis,
}

/// The transform from a file's coordinates to the body frame: a signed permutation and a factor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// Unit of the file.
    pub unit: LengthUnit,
    /// Up in the file.
    pub up: Axis,
    /// Forward in the file.
    pub forward: Axis,
    left: Axis,
}

impl Frame {
    /// Creates a frame; axes that are not given are the format's: y up and +z forward for glTF (its
    /// specification, section 3.4), z up and +x forward for the others, which have no rule.
    ///
    /// # Errors
    ///
    /// Up and forward are parallel.
    pub fn new(
        format: Format,
        unit: LengthUnit,
        up: Option<Axis>,
        forward: Option<Axis>,
    ) -> Result<Self, MeshDefect> {
        let (usual_up, usual_forward) = match format {
            Format::Gltf | Format::Glb => (Axis::Y, Axis::Z),
            Format::Obj | Format::Stl | Format::Ply | Format::Collada | Format::LsDyna => {
                (Axis::Z, Axis::X)
            }
        };
        let (up, forward) = (up.unwrap_or(usual_up), forward.unwrap_or(usual_forward));
        if up.index == forward.index {
            return Err(MeshDefect::Options(format!(
                "up {up} and forward {forward} are parallel: state both --up and --forward"
            )));
        }
        // Left is up × forward: the three are right-handed as forward, left, up.
        let ([a, b, c], [x, y, z]) = (up.vector(), forward.vector());
        let left = Axis::of([b * z - c * y, c * x - a * z, a * y - b * x]);
        Ok(Self { unit, up, forward, left })
    }

    /// Converts a point of the file to the body frame, in metres, before rounding to f32.
    #[must_use]
    pub fn point(&self, point: [f64; 3]) -> [f64; 3] {
        [self.forward, self.left, self.up].map(|axis| axis.component(point) * self.unit.metres)
    }
}

impl fmt::Display for Frame {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "unit {}, up {}, forward {}", self.unit, self.up, self.forward)
    }
}

#[cfg(test)]
mod tests;
