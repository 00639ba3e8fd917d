//! One of the two parties of a collision: its body as dynamics see it, and who is with it.
//!
//! Persons carry kind (by their body), seat and nothing else. Fixed objects have no persons and no
//! mass. It knows nothing of the other party.

use crate::crush::Stiffness;
use crate::injury::Victim;
use body::meta::Occupant;
use body::{BodyKind, Seat};
use geometry::DVec3;
use serde::Serialize;
use smallvec::{SmallVec, smallvec};

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
    /// Whether the body is concave in plan, so that its hull says nothing about the normal.
    pub concave: bool,
    /// Who is with it.
    pub persons: SmallVec<[Aboard; IN_PLACE]>,
}

/// The side of a vehicle that is struck.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Struck {
    /// Within 45° of forward.
    Front,
    /// Between 45° and 135° on either side.
    Side,
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
    /// The side for an angle from forward (degrees), either way round, wrapped.
    #[must_use]
    pub fn at(degrees: f64) -> Self {
        let off = (wrapped(degrees).abs() * DEGREE_PRECISION).round() / DEGREE_PRECISION;
        if off < 45.0 {
            Self::Front
        } else if off <= 135.0 {
            Self::Side
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

    /// What kind of victim a person of this party is, struck from `side`; `None` for fixed objects.
    #[must_use]
    pub fn victim(&self, side: Struck) -> Option<Victim> {
        match self.kind {
            BodyKind::Sedan | BodyKind::Suv | BodyKind::Truck | BodyKind::Bus => Some(match side {
                Struck::Front => Victim::OccupantFront,
                Struck::Side => Victim::OccupantSide,
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

/// Whether bodies of this kind are concave in plan.
#[must_use]
pub fn is_concave(kind: BodyKind) -> bool {
    matches!(kind, BodyKind::Building)
}

/// Who is with a body: as stated, or, where not stated, one driver or rider if it moves (our
/// assumption), and for a person on foot that person.
#[must_use]
pub fn occupants(kind: BodyKind, speed_m_s: f64, stated: Option<&[Occupant]>) -> Seats {
    if let Some(stated) = stated {
        return stated.iter().map(|o| o.seat).collect();
    }
    let is_moving = speed_m_s > 0.0;
    match kind {
        BodyKind::Pedestrian => smallvec![None],
        BodyKind::Sedan | BodyKind::Suv | BodyKind::Truck | BodyKind::Bus if is_moving => {
            smallvec![Some(Seat::FrontLeft)]
        }
        BodyKind::Motorcycle | BodyKind::Cyclist if is_moving => smallvec![Some(Seat::Rider)],
        BodyKind::Sedan
        | BodyKind::Suv
        | BodyKind::Truck
        | BodyKind::Bus
        | BodyKind::Motorcycle
        | BodyKind::Cyclist => Seats::new(),
        BodyKind::Wall | BodyKind::Pole | BodyKind::Building => Seats::new(),
    }
}

#[cfg(test)]
mod tests;
