//! One injury risk curve: a logistic function of speed, anchored at zero.
//!
//! P(x) = 1/(1+exp(−(a+b x))) as published has P(0) > 0: it assigns a risk to people who are not
//! hit at all. So harm is H = (P(x) − P(0)) / (1 − P(0)), here in the form (1 − exp(−b x)) / (1 +
//! exp(−(a+b x))), which is the same and is exactly 0 at 0.
//!
//! Of the persons whom a front strikes, more are injured by a tall one: a curve may have a term
//! f(x, h) for that, which rises with speed and with the height h of the front's edge. Then z = a +
//! b x + f(x, h) takes the place of a + b x.
//!
//! Speeds come in m/s and are turned into the curve's own unit: forgetting that is the commonest
//! fault in public code. A curve knows its source, but not whose risk it describes (see
//! [`crate::injury`]).

use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Severity that a curve speaks of, the mildest first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Level {
    /// At least one moderate injury.
    #[serde(rename = "mais2+")]
    Mais2,
    /// At least one serious injury.
    #[serde(rename = "mais3+")]
    Mais3,
    /// Death.
    #[serde(rename = "fatal")]
    Fatal,
}

/// Unit of a curve's x.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum CurveUnit {
    /// Metres per second.
    #[serde(rename = "m/s")]
    MetresPerSecond,
    /// Kilometres per hour.
    #[serde(rename = "km/h")]
    KilometresPerHour,
    /// Miles per hour, of 1609.344 m.
    #[serde(rename = "mph")]
    MilesPerHour,
}

/// What a tall front adds to a + b x: max(0, `per_cm` + `per_cm_and_unit` (x − `at`)) · max(0, h −
/// `from_cm`), h being the height of its edge (cm) and x in the curve's unit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FrontTerm {
    /// The height from which on it counts (cm).
    pub from_cm: f64,
    /// Per centimetre, at `at`.
    pub per_cm: f64,
    /// What a unit of x adds to that, at least 0.
    pub per_cm_and_unit: f64,
    /// x at which `per_cm` holds.
    pub at: f64,
}

impl FrontTerm {
    fn of(&self, x: f64, front_m: f64) -> f64 {
        let per_cm = (self.per_cm + self.per_cm_and_unit * (x - self.at)).max(0.0);
        per_cm * (100.0 * front_m - self.from_cm).max(0.0)
    }
}

/// A speed, and how tall the front is that strikes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Dose {
    /// The speed (m/s).
    pub speed_m_s: f64,
    /// The height of the front's edge (m); 0 where no front strikes.
    pub front_m: f64,
}

impl Dose {
    /// Of a speed (m/s) alone.
    #[must_use]
    pub fn at(speed_m_s: f64) -> Self {
        Self { speed_m_s, front_m: 0.0 }
    }
}

/// A risk curve with its source.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Curve {
    /// Name within its file.
    pub id: Arc<str>,
    /// What it gives the probability of.
    pub outcome: Level,
    /// Unit of x.
    pub unit: CurveUnit,
    /// Intercept a.
    pub a: f64,
    /// Slope b > 0, per unit of x.
    pub b: f64,
    /// What a tall front adds.
    pub front: Option<FrontTerm>,
    /// x between which the sample supports the curve, in `unit`.
    pub valid: [f64; 2],
    /// Who published it, where.
    pub source: String,
    /// Year of publication.
    pub year: u16,
    /// Whom it was fitted to.
    pub sample: String,
    /// Data base or group that it descends from; curves of one origin can be compared.
    pub origin: String,
    /// Doubts and adaptations; may be empty.
    pub note: String,
}

impl Level {
    /// All levels, the mildest first.
    pub const ALL: [Self; 3] = [Self::Mais2, Self::Mais3, Self::Fatal];

    /// The name as files write it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Mais2 => "mais2+",
            Self::Mais3 => "mais3+",
            Self::Fatal => "fatal",
        }
    }
}

impl CurveUnit {
    /// How many m/s one unit is.
    #[must_use]
    pub fn metres_per_second(self) -> f64 {
        match self {
            Self::MetresPerSecond => 1.0,
            Self::KilometresPerHour => 1.0 / 3.6,
            Self::MilesPerHour => 0.447_04,
        }
    }

    /// The name as files write it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::MetresPerSecond => "m/s",
            Self::KilometresPerHour => "km/h",
            Self::MilesPerHour => "mph",
        }
    }

    /// A speed (m/s) in this unit.
    #[must_use]
    pub fn of(self, speed_m_s: f64) -> f64 {
        match self {
            Self::MetresPerSecond => speed_m_s,
            Self::KilometresPerHour => speed_m_s * 3.6,
            Self::MilesPerHour => speed_m_s / 0.447_04,
        }
    }
}

impl Curve {
    /// z, the argument of the logistic function, at x in the curve's unit.
    fn argument(&self, x: f64, front_m: f64) -> f64 {
        self.a + self.b * x + self.front.map_or(0.0, |front| front.of(x, front_m))
    }

    /// The anchored risk in [0, 1]; exactly 0 at a speed of 0 and below, never falling.
    #[must_use]
    pub fn risk(&self, dose: Dose) -> f64 {
        let x = self.unit.of(dose.speed_m_s);
        if x <= 0.0 {
            return 0.0;
        }
        let (z, at_rest) = (self.argument(x, dose.front_m), self.argument(0.0, dose.front_m));
        let rise = -libm::expm1(at_rest - z);
        (rise / (1.0 + libm::exp(-z))).clamp(0.0, 1.0)
    }

    /// The probability as published, not anchored.
    #[must_use]
    pub fn published(&self, dose: Dose) -> f64 {
        let z = self.argument(self.unit.of(dose.speed_m_s), dose.front_m);
        1.0 / (1.0 + libm::exp(-z))
    }

    /// Whether the sample supports the curve at this speed (m/s).
    #[must_use]
    pub fn is_valid_at(&self, speed_m_s: f64) -> bool {
        let x = self.unit.of(speed_m_s);
        self.valid[0] <= x && x <= self.valid[1]
    }
}

#[cfg(test)]
mod tests;
