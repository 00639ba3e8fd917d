//! Whose risk follows which curve: a set of curves, as a data file states it.
//!
//! For every kind of person and severity level, a [`Rung`] names the nominal curve and the quantity
//! it is a function of, and for each end of the model range the curves and the factor on that
//! quantity. [`Curves::parse`] (in `injury/load.rs`) refuses files without units or sources, and
//! files in which a severer injury is anywhere likelier than a milder one.
//!
//! A person without a curve is refused, never given another's. Age and sex do not occur.

use crate::curve::{Curve, Dose, Level};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

mod load;
mod shift;
#[cfg(test)]
mod tests;

/// The curves in force unless others are named: `config/curves/default.toml`.
pub const DEFAULT_CURVES: &str =
    include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/config/curves/default.toml"));

/// A kind of person, by what hits them and where.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Victim {
    /// Inside a vehicle that is struck at its front.
    OccupantFront,
    /// Inside a vehicle that is struck at the side of the seat.
    OccupantNear,
    /// Inside a vehicle that is struck at the other side.
    OccupantFar,
    /// Inside a vehicle that is struck at its rear.
    OccupantRear,
    /// On foot.
    Pedestrian,
    /// On a bicycle.
    Cyclist,
    /// On a motorcycle.
    Motorcyclist,
}

/// The speed that a risk is a function of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Quantity {
    /// Change of velocity of the person's vehicle.
    DeltaV,
    /// Closing speed along the contact normal, v_n, as if a car struck: what is lighter than a car
    /// throws a person less.
    ClosingNormal,
    /// Closing speed, |v_rel|.
    Closing,
}

/// Speeds of one crash as one person meets them (m/s).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Speeds {
    /// ΔV of the person's vehicle.
    pub delta_v: f64,
    /// v_n, times what the striker's mass makes of it.
    pub normal: f64,
    /// |v_rel|, likewise.
    pub closing: f64,
    /// The height of the front's edge that strikes a person outside (m), else 0.
    pub front_m: f64,
}

/// One end of a model range: the extreme of some curves at a scaled quantity.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RangeEnd {
    /// Numbers of curves within the set; at least one.
    pub curves: Vec<usize>,
    /// The quantity that they are evaluated at.
    pub x: Quantity,
    /// Factor on x, above 0.
    pub times: f64,
}

/// The risk of one kind of person at one level.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Rung {
    /// Whose.
    pub victim: Victim,
    /// Of what.
    pub level: Level,
    /// Quantity of the nominal curve.
    pub x: Quantity,
    /// Number of the nominal curve within the set.
    pub nominal: usize,
    /// Number of a curve of a milder outcome that the nominal risk never exceeds: where published
    /// curves of one study cross.
    pub at_most: Option<usize>,
    /// Lower end of the model range.
    pub low: RangeEnd,
    /// Upper end of the model range.
    pub high: RangeEnd,
}

/// A checked set of curves.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Curves {
    /// Name of the set.
    pub name: String,
    /// Why nominal curves come from several origins; empty if they do not.
    pub mixed_origins: String,
    /// All curves, shared by the worlds that follow them.
    pub curves: Arc<[Curve]>,
    /// Who follows which, ascending by person and level, none twice.
    pub rungs: Vec<Rung>,
}

/// A person whose risk no curve gives.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "the curve set has no curve for {victim} at level {level}: add one with its source, or choose \
     another level",
    victim = .victim.name(),
    level = .level.name()
)]
pub struct MissingCurve {
    /// Whose.
    pub victim: Victim,
    /// Of what.
    pub level: Level,
}

impl diagnostic::Diagnostic for MissingCurve {
    fn kind(&self) -> diagnostic::FailureKind {
        diagnostic::FailureKind::Input
    }
}

impl Victim {
    /// All kinds of persons.
    pub const ALL: [Self; 7] = [
        Self::OccupantFront,
        Self::OccupantNear,
        Self::OccupantFar,
        Self::OccupantRear,
        Self::Pedestrian,
        Self::Cyclist,
        Self::Motorcyclist,
    ];

    /// The name as files write it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::OccupantFront => "occupant-front",
            Self::OccupantNear => "occupant-near",
            Self::OccupantFar => "occupant-far",
            Self::OccupantRear => "occupant-rear",
            Self::Pedestrian => "pedestrian",
            Self::Cyclist => "cyclist",
            Self::Motorcyclist => "motorcyclist",
        }
    }
}

impl Quantity {
    /// The name as files write it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::DeltaV => "delta-v",
            Self::ClosingNormal => "closing-normal",
            Self::Closing => "closing",
        }
    }
}

impl Speeds {
    /// One of them (m/s), `times` a factor, with the height of the front.
    #[must_use]
    pub fn dose(&self, x: Quantity, times: f64) -> Dose {
        Dose { speed_m_s: self.get(x) * times, front_m: self.front_m }
    }

    /// One of them (m/s).
    #[must_use]
    pub fn get(&self, x: Quantity) -> f64 {
        match x {
            Quantity::DeltaV => self.delta_v,
            Quantity::ClosingNormal => self.normal,
            Quantity::Closing => self.closing,
        }
    }
}

impl Curves {
    /// The rung of a person at a level.
    ///
    /// # Errors
    ///
    /// If the set has no curve for this person at this level.
    pub fn rung(&self, victim: Victim, level: Level) -> Result<&Rung, MissingCurve> {
        let find = |r: &&Rung| r.victim == victim && r.level == level;
        self.rungs.iter().find(find).ok_or(MissingCurve { victim, level })
    }

    /// Checks that every kind of person has a curve at this level, so that a policy may use it.
    ///
    /// # Errors
    ///
    /// The first person without one.
    pub fn covers(&self, level: Level) -> Result<(), MissingCurve> {
        Victim::ALL.iter().try_for_each(|v| self.rung(*v, level).map(drop))
    }

    /// The nominal curve of a rung.
    #[must_use]
    pub fn nominal(&self, rung: &Rung) -> &Curve {
        &self.curves[rung.nominal]
    }

    /// Nominal risk.
    #[must_use]
    pub fn risk(&self, rung: &Rung, speeds: &Speeds) -> f64 {
        let dose = speeds.dose(rung.x, 1.0);
        let risk = self.nominal(rung).risk(dose);
        rung.at_most.map_or(risk, |most| risk.min(self.curves[most].risk(dose)))
    }

    /// Lower end of the model range, clipped to the ladder: never below that of a severer level.
    #[must_use]
    pub fn low(&self, rung: &Rung, speeds: &Speeds) -> f64 {
        self.family(rung)
            .filter(|r| r.level >= rung.level)
            .map(|r| self.low_end(r, speeds))
            .fold(0.0, f64::max)
    }

    /// Upper end of the model range, clipped to the ladder: never above that of a milder level.
    #[must_use]
    pub fn high(&self, rung: &Rung, speeds: &Speeds) -> f64 {
        self.family(rung)
            .filter(|r| r.level <= rung.level)
            .map(|r| self.extreme(&r.high, speeds, f64::NEG_INFINITY, f64::max))
            .fold(1.0, f64::min)
    }

    /// Lower end of the model range of one level; where the nominal risk is cut, it is, too.
    fn low_end(&self, rung: &Rung, speeds: &Speeds) -> f64 {
        let low = self.extreme(&rung.low, speeds, f64::INFINITY, f64::min);
        let dose = speeds.dose(rung.low.x, rung.low.times);
        rung.at_most.map_or(low, |most| low.min(self.curves[most].risk(dose)))
    }

    /// The rungs of the same person.
    fn family(&self, rung: &Rung) -> impl Iterator<Item = &Rung> {
        let victim = rung.victim;
        self.rungs.iter().filter(move |r| r.victim == victim)
    }

    fn extreme(
        &self,
        end: &RangeEnd,
        speeds: &Speeds,
        from: f64,
        pick: fn(f64, f64) -> f64,
    ) -> f64 {
        let dose = speeds.dose(end.x, end.times);
        end.curves.iter().map(|c| self.curves[*c].risk(dose)).fold(from, pick)
    }
}
