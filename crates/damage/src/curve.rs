//! One injury risk curve: a logistic function of speed, anchored at zero.
//!
//! P(x) = 1/(1+exp(−(a+b x))) as published has P(0) > 0: it assigns a risk to people who are not
//! hit at all. So harm is H = (P(x) − P(0)) / (1 − P(0)), here in the form (1 − exp(−b x)) / (1 +
//! exp(−(a+b x))), which is the same and is exactly 0 at 0.
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
    /// The anchored risk in [0, 1] at a speed (m/s); exactly 0 at 0 and below, never falling.
    #[must_use]
    pub fn risk(&self, speed_m_s: f64) -> f64 {
        let x = self.unit.of(speed_m_s);
        if x <= 0.0 {
            return 0.0;
        }
        let rise = -libm::expm1(-self.b * x);
        (rise / (1.0 + libm::exp(-(self.a + self.b * x)))).clamp(0.0, 1.0)
    }

    /// The probability as published, not anchored, at a speed (m/s).
    #[must_use]
    pub fn published(&self, speed_m_s: f64) -> f64 {
        1.0 / (1.0 + libm::exp(-(self.a + self.b * self.unit.of(speed_m_s))))
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
