//! One of the two parties of a collision: its body as dynamics see it, and who is with it.
//!
//! Persons carry kind (by their body), seat and nothing else. Fixed objects have no persons and no
//! mass. It knows nothing of the other party.

use crate::crush::Stiffness;
use crate::injury::Victim;
use body::{BodyKind, OwnParameters, Seat};
use geometry::DVec3;
use serde::Serialize;
use smallvec::SmallVec;

/// A person of the request: a number in the one fixed list of persons for all candidates.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub struct PersonId(pub usize);

/// A person with a party.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Aboard {
    /// Who.
    pub id: PersonId,
    /// Where; `None` on foot.
    pub seat: Option<Seat>,
}

/// Number of persons of a party that lists store in place; more are allocated on the heap.
pub const IN_PLACE: usize = 64;

/// Who is with a body, by their seats; `None` on foot.
pub type Seats = SmallVec<[Option<Seat>; IN_PLACE]>;

/// A party of a collision, in A's frame at the given pose.
#[derive(Clone, Debug, PartialEq)]
pub struct CollisionParty {
    /// Kind of body.
    pub kind: BodyKind,
    /// Mass (kg); `None` if fixed to the ground.
    pub mass_kg: Option<f64>,
    /// Yaw radius of gyration k (m); ignored if fixed.
    pub gyration_m: f64,
    /// Centre of mass (m).
    pub centre_m: DVec3,
    /// Where the body's x axis (forward) points; unit vector.
    pub forward: DVec3,
    /// Stiffness, if configured; ignored if fixed.
    pub stiffness: Option<Stiffness>,
    /// The height of the edge of its front above its lowest point (m), if it has one.
    pub front_m: Option<f64>,
    /// What is known of its impacts, in place of the parameters in force.
    pub own: OwnParameters,
    /// Who is with it.
    pub persons: SmallVec<[Aboard; IN_PLACE]>,
}

/// The side of a vehicle that is struck.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Struck {
    /// Within 45° of forward.
    Front,
    /// Between 45° and 135° to the left.
    Left,
    /// Between 45° and 135° to the right.
    Right,
    /// Within 45° of backward.
    Rear,
}

/// An invalid party.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PartyError {
    /// Zero, negative or not finite.
    #[error("mass is not a finite number above 0 kg: correct it, or mark the body as fixed")]
    Mass,
    /// Zero, negative or not finite.
    #[error("radius of gyration is not a finite number above 0 m: correct it")]
    Gyration,
    /// Not finite, or no direction.
    #[error("centre or forward direction is not finite: check the pose")]
    Place,
    /// Persons in a fixed object.
    #[error("a fixed object cannot have persons: remove them, or choose another kind")]
    PersonsInFixed,
    /// One person in two seats.
    #[error("person {} occurs twice in one collision: give each person a number", .0.0)]
    Twice(PersonId),
}

/// Degrees of the struck side are compared at this precision, so that rounding decides no side.
const DEGREE_PRECISION: f64 = 1e6;

/// An angle (degrees) wrapped into (−180, 180].
#[must_use]
pub fn wrapped(degrees: f64) -> f64 {
    let turns = degrees - 360.0 * ((degrees + 180.0) / 360.0).floor();
    if turns <= -180.0 { 180.0 } else { turns }
}

impl Struck {
    /// All sides.
    pub const ALL: [Self; 4] = [Self::Front, Self::Left, Self::Right, Self::Rear];

    /// The side for an angle from forward (degrees, positive to the left), wrapped.
    #[must_use]
    pub fn at(degrees: f64) -> Self {
        let degrees = wrapped(degrees);
        let off = (degrees.abs() * DEGREE_PRECISION).round() / DEGREE_PRECISION;
        if off < 45.0 {
            Self::Front
        } else if off <= 135.0 {
            if degrees > 0.0 { Self::Left } else { Self::Right }
        } else {
            Self::Rear
        }
    }
}

impl CollisionParty {
    /// Checks what dynamics rely on.
    ///
    /// # Errors
    ///
    /// The first invalid value: see [`PartyError`].
    pub fn check(&self) -> Result<(), PartyError> {
        let is_positive = |x: f64| x > 0.0 && x.is_finite();
        if let Some(mass) = self.mass_kg {
            if !is_positive(mass) {
                return Err(PartyError::Mass);
            }
            if !is_positive(self.gyration_m) {
                return Err(PartyError::Gyration);
            }
        }
        let level = self.forward.x * self.forward.x + self.forward.y * self.forward.y;
        if !(self.centre_m.is_finite() && self.forward.is_finite() && level > 0.0) {
            return Err(PartyError::Place);
        }
        if !self.persons.is_empty() && (self.mass_kg.is_none() || is_fixed(self.kind)) {
            return Err(PartyError::PersonsInFixed);
        }
        for (i, person) in self.persons.iter().enumerate() {
            if self.persons[..i].iter().any(|p| p.id == person.id) {
                return Err(PartyError::Twice(person.id));
            }
        }
        Ok(())
    }

    /// The angle (degrees) from forward, positive to the left, of a horizontal direction in A's
    /// frame; `up` is the vertical there.
    #[must_use]
    pub fn bearing(&self, direction: DVec3, up: DVec3) -> f64 {
        let left = up.cross(self.forward);
        libm::atan2(left.dot(direction), self.forward.dot(direction)).to_degrees()
    }

    /// What kind of victim a person of this party is in a seat, struck from `side`; `None` for
    /// fixed objects. In the middle both sides are near.
    #[must_use]
    pub fn victim(&self, side: Struck, seat: Option<Seat>) -> Option<Victim> {
        let is_far = match side {
            Struck::Left => matches!(seat, Some(Seat::FrontRight | Seat::RearRight)),
            Struck::Right => matches!(seat, Some(Seat::FrontLeft | Seat::RearLeft)),
            Struck::Front | Struck::Rear => false,
        };
        match self.kind {
            BodyKind::Sedan | BodyKind::Suv | BodyKind::Truck | BodyKind::Bus => Some(match side {
                Struck::Front => Victim::OccupantFront,
                Struck::Left | Struck::Right if is_far => Victim::OccupantFar,
                Struck::Left | Struck::Right => Victim::OccupantNear,
                Struck::Rear => Victim::OccupantRear,
            }),
            BodyKind::Motorcycle => Some(Victim::Motorcyclist),
            BodyKind::Cyclist => Some(Victim::Cyclist),
            BodyKind::Pedestrian => Some(Victim::Pedestrian),
            BodyKind::Wall | BodyKind::Pole | BodyKind::Building => None,
        }
    }
}

/// Whether bodies of this kind are fixed to the ground.
#[must_use]
pub fn is_fixed(kind: BodyKind) -> bool {
    matches!(kind, BodyKind::Wall | BodyKind::Pole | BodyKind::Building)
}

/// Whether who is with a body of this kind is outside of a vehicle, without a shell around.
#[must_use]
pub fn is_vulnerable(kind: BodyKind) -> bool {
    matches!(kind, BodyKind::Pedestrian | BodyKind::Cyclist | BodyKind::Motorcycle)
}

/// How much of a closing speed a person outside feels who is struck by a mass, against a car: the
/// share that the striker's mass has in both, over the share that a car's would have, at most 1.
/// The person's own mass is that of the kind, never a stated one.
#[must_use]
pub fn throw_share(kind: BodyKind, striker_kg: Option<f64>) -> f64 {
    /// The lightest car in the samples of the curves, kg; our assumption.
    const CAR_KG: f64 = 800.0;
    let person_kg = match kind {
        BodyKind::Motorcycle => 325.0,
        BodyKind::Cyclist => 90.0,
        _ => 75.0,
    };
    let share = |striker_kg: f64| striker_kg / (striker_kg + person_kg);
    striker_kg.map_or(1.0, |striker_kg| (share(striker_kg) / share(CAR_KG)).min(1.0))
}

#[cfg(test)]
mod tests;
