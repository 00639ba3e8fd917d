//! Worlds: what the model does not know, drawn once for all candidates.
//!
//! A range by end points lets each candidate have its own doubts. But restitution, friction, masses
//! and the right curve are what they are, whichever way is taken. A *world* is one draw of them; it
//! assesses known contacts again, without geometry and without going another way.
//!
//! Restitution and friction are drawn within their ranges, the nominal value in the middle: half of
//! the worlds lie below it, half above, evenly. Masses are drawn evenly within their share, each
//! party's on its own. The curve of a person is the nominal one or, as probable, each of those that
//! make the range, as published; the same in a world for all persons of a kind.

use crate::assess::{AssessError, Basis, Drawn, Encounter, nominal_of};
use crate::curve::Level;
use crate::injury::{Curves, Rung};
use crate::parameters::{Parameters, Setting};
use crate::party::{CollisionParty, PersonId};
use schemars::JsonSchema;
use serde::Serialize;

/// What a world draws.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Doubt {
    /// Restitution.
    Restitution,
    /// Friction.
    Friction,
    /// Masses of all parties.
    Masses,
    /// Injury curves.
    Curves,
}

/// Coordinates of a world, each in [0, 1); in the middle is what is nominal.
#[derive(Clone, Debug, PartialEq)]
pub struct WorldDraw {
    /// Of restitution.
    pub restitution: f64,
    /// Of friction.
    pub friction: f64,
    /// Of the mass of each party of the request.
    pub masses: Vec<f64>,
    /// Of the curves; `None`: the nominal ones.
    pub curves: Option<f64>,
}

/// A world.
#[derive(Clone, Debug, PartialEq)]
pub struct World {
    /// The parameters: nominal values are those of this world.
    pub parameters: Parameters,
    /// The curves: nominal ones are those of this world.
    pub curves: Curves,
    draw: WorldDraw,
}

impl Doubt {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Restitution, Self::Friction, Self::Masses, Self::Curves];

    /// The name as answers write it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Restitution => "restitution",
            Self::Friction => "friction",
            Self::Masses => "masses",
            Self::Curves => "curves",
        }
    }
}

impl WorldDraw {
    /// What is nominal, of so many parties.
    #[must_use]
    pub fn nominal(parties: usize) -> Self {
        Self { restitution: 0.5, friction: 0.5, masses: vec![0.5; parties], curves: None }
    }

    /// This draw in one respect, all else nominal.
    #[must_use]
    pub fn only(&self, doubt: Doubt) -> Self {
        let nominal = Self::nominal(self.masses.len());
        match doubt {
            Doubt::Restitution => Self { restitution: self.restitution, ..nominal },
            Doubt::Friction => Self { friction: self.friction, ..nominal },
            Doubt::Masses => Self { masses: self.masses.clone(), ..nominal },
            Doubt::Curves => Self { curves: self.curves, ..nominal },
        }
    }
}

/// A setting whose nominal value is the one at this coordinate.
fn drawn(setting: Setting, at: f64) -> Setting {
    let Setting { low, nominal, high } = setting;
    let value = if at < 0.5 {
        low + (nominal - low) * (2.0 * at)
    } else {
        nominal + (high - nominal) * (2.0 * at - 1.0)
    };
    // At a coordinate of 0.5 it is nominal to the bit.
    Setting { nominal: value.clamp(low, high), ..setting }
}

/// The curve of a person at this coordinate, in place of the nominal one.
fn other_curve(rung: &Rung, at: f64) -> Rung {
    let mut others = Vec::new();
    for end in [&rung.low, &rung.high] {
        for curve in &end.curves {
            let known = others.iter().any(|(other, _)| other == curve);
            if *curve != rung.nominal && !known {
                others.push((*curve, end.x));
            }
        }
    }
    let number = (at * (others.len() + 1) as f64) as usize;
    match number.checked_sub(1).and_then(|other| others.get(other)) {
        None => rung.clone(),
        // What another study says of milder injuries bounds nothing here.
        Some((nominal, x)) => Rung { nominal: *nominal, x: *x, at_most: None, ..rung.clone() },
    }
}

impl World {
    /// The world of a draw, about what is nominal in these.
    #[must_use]
    pub fn of(draw: WorldDraw, parameters: &Parameters, curves: &Curves) -> Self {
        let Parameters { restitution, friction, flat_friction, face_restitution, .. } = parameters;
        let rungs = match draw.curves {
            None => curves.rungs.clone(),
            Some(at) => curves.rungs.iter().map(|rung| other_curve(rung, at)).collect(),
        };
        Self {
            parameters: Parameters {
                restitution: drawn(*restitution, draw.restitution),
                face_restitution: drawn(*face_restitution, draw.restitution),
                friction: drawn(*friction, draw.friction),
                flat_friction: drawn(*flat_friction, draw.friction),
                ..parameters.clone()
            },
            curves: Curves { rungs, ..curves.clone() },
            draw,
        }
    }

    /// Whether this is the world of another draw, too, about the same nominal values: then its
    /// figures are the same.
    #[must_use]
    pub fn is_same(&self, other: &Self) -> bool {
        let settings = |world: &Self| (world.draw.restitution, world.draw.friction);
        settings(self) == settings(other)
            && self.draw.masses == other.draw.masses
            && self.curves.rungs == other.curves.rungs
    }

    /// Masses and parameters of two parties in this world; `numbers` are theirs in the request.
    fn drawn(&self, parties: [&CollisionParty; 2], numbers: [usize; 2]) -> Drawn {
        let mass_kg = |p: usize| {
            let share = parties[p].own.mass_share.unwrap_or(self.parameters.mass_share);
            let factor = 1.0 + share * (2.0 * self.draw.masses[numbers[p]] - 1.0);
            parties[p].mass_kg.map(|kg| kg * factor)
        };
        let own = |p: usize| {
            let mut own = parties[p].own;
            own.restitution = own.restitution.map(|setting| drawn(setting, self.draw.restitution));
            own.friction = own.friction.map(|setting| drawn(setting, self.draw.friction));
            own
        };
        Drawn { mass_kg: [0, 1].map(mass_kg), own: [0, 1].map(own) }
    }

    /// The risks of a contact in this world, and the energy lost (J). `parties` are the numbers of
    /// both in the request.
    ///
    /// # Errors
    ///
    /// As [`crate::assess()`].
    pub fn assess(
        &self,
        encounter: &Encounter<'_>,
        parties: [usize; 2],
        level: Level,
        take: impl FnMut(PersonId, f64),
    ) -> Result<f64, AssessError> {
        let drawn = self.drawn([encounter.a, encounter.b], parties);
        let basis = Basis { curves: &self.curves, level, parameters: &self.parameters };
        nominal_of(encounter, &drawn, &basis, take)
    }
}

#[cfg(test)]
mod tests;
