//! What is known of how a body meets others, in place of parameters that hold for all bodies.

use crate::BodyKind;
use serde::{Deserialize, Serialize};

/// A parameter with the range within which it is known.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Setting {
    /// Low end.
    pub low: f64,
    /// What the nominal computation takes.
    pub nominal: f64,
    /// High end.
    pub high: f64,
}

impl Setting {
    /// Whether it is a range from 0 to `most`.
    #[must_use]
    pub fn is_within(&self, most: f64) -> bool {
        let Self { low, nominal, high } = *self;
        0.0 <= low && low <= nominal && nominal <= high && high <= most
    }
}

/// What a side file says of a body's impacts. What is absent is taken from the parameters in force.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OwnParameters {
    /// Restitution e with what it catches, and along the normal of a long flat face from 60° on.
    pub restitution: Option<Setting>,
    /// Friction μ, of its flat faces, too.
    pub friction: Option<Setting>,
    /// Of a fixed object: what is added to the restitution of a long flat face up to 30°.
    pub face_restitution_more: Option<f64>,
    /// Of a fixed object: the most that the impulse along a long flat face is of the one across it.
    pub face_tangential_share: Option<f64>,
    /// Of what moves: its radius of gyration is known to this share.
    pub gyration_share: Option<f64>,
    /// Of what moves: its mass is known to this share.
    pub mass_share: Option<f64>,
}

/// Maximum coefficient of friction.
pub const FRICTION_MAX: f64 = 10.0;

impl OwnParameters {
    /// Whether nothing is stated.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// Checks values, and that they belong to a body of this kind.
    ///
    /// # Errors
    ///
    /// A description of the value that is out of its range, or does not fit the kind.
    pub fn check(&self, kind: BodyKind) -> Result<(), String> {
        for (key, setting, most) in
            [("restitution", self.restitution, 1.0), ("friction", self.friction, FRICTION_MAX)]
        {
            if setting.is_some_and(|setting| !setting.is_within(most)) {
                return Err(format!("{key} is not 0 ≤ low ≤ nominal ≤ high ≤ {most}"));
            }
        }
        for (key, value) in [
            ("face_restitution_more", self.face_restitution_more),
            ("face_tangential_share", self.face_tangential_share),
            ("gyration_share", self.gyration_share),
            ("mass_share", self.mass_share),
        ] {
            if value.is_some_and(|value| !(0.0..1.0).contains(&value)) {
                return Err(format!("{key} is not at least 0 and below 1"));
            }
        }
        let of_faces = self.face_restitution_more.is_some() || self.face_tangential_share.is_some();
        if of_faces && !kind.is_fixed() {
            return Err(format!("a {kind} has no long flat face along which others are turned"));
        }
        if (self.mass_share.is_some() || self.gyration_share.is_some()) && kind.is_fixed() {
            return Err(format!("a {kind} is fixed to the ground and has no mass"));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
