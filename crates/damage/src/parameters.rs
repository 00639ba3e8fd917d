//! Parameters of contact and dynamics: a data file, each value with its range and its source.

use crate::fault::{DataFileError, Source};
use body::OwnParameters;
use body::impact::FRICTION_MAX;
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use toml::Spanned;

pub use body::Setting;

/// The parameters in force unless others are named: `config/parameters/default.toml`.
pub const DEFAULT_PARAMETERS: &str =
    include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/config/parameters/default.toml"));

const KEYS: &str = "a file of parameters has schema, name and the tables restitution, friction, \
                    flat_friction, face_restitution (low, nominal, high, source), \
                    face_restitution_more, face_tangential_share, gyration_share, mass_share, \
                    speed_share and normal_degrees (value, source)";

/// Parameters of contact and dynamics.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Parameters {
    /// Name of the set.
    pub name: String,
    /// Restitution e of bodies that catch each other. Constant: falling with speed it could make
    /// harm fall with speed.
    pub restitution: Setting,
    /// Friction μ of vehicles, poles and ends of walls.
    pub friction: Setting,
    /// Friction μ of flat faces of fixed objects.
    pub flat_friction: Setting,
    /// Restitution along the normal of a long flat face, from 60° on ...
    pub face_restitution: Setting,
    /// ... and what is added to it up to 30°, linearly in between.
    pub face_restitution_more: f64,
    /// The most that the impulse along a long flat face is of the one across it.
    pub face_tangential_share: f64,
    /// Gyration is known to this share.
    pub gyration_share: f64,
    /// Masses are known to this share.
    pub mass_share: f64,
    /// Speeds are known to this share.
    pub speed_share: f64,
    /// The normal is known to this angle (degrees).
    pub normal_degrees: f64,
    /// Source of each, in the order of the fields.
    pub sources: Arc<[String]>,
}

/// The parameters of one contact: those in force, with what is known of both parties in their
/// place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PairParameters {
    /// Restitution e of bodies that catch each other.
    pub restitution: Setting,
    /// Friction μ ...
    pub friction: Setting,
    /// ... and where one of them is a flat face of a fixed object.
    pub flat_friction: Setting,
    /// Restitution along the normal of a long flat face, from 60° on ...
    pub face_restitution: Setting,
    /// ... and what is added to it up to 30°.
    pub face_restitution_more: f64,
    /// The most that the impulse along a long flat face is of the one across it.
    pub face_tangential_share: f64,
    /// Gyration of each party is known to this share.
    pub gyration_share: [f64; 2],
    /// Mass of each party is known to this share.
    pub mass_share: [f64; 2],
}

/// Which end of the parameters' ranges.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Pick {
    Low,
    Nominal,
    High,
}

impl Pick {
    pub(crate) const ALL: [Self; 3] = [Self::Low, Self::Nominal, Self::High];

    pub(crate) fn of(self, setting: &Setting) -> f64 {
        match self {
            Self::Low => setting.low,
            Self::Nominal => setting.nominal,
            Self::High => setting.high,
        }
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    schema: Spanned<u32>,
    name: String,
    restitution: Spanned<RangeText>,
    friction: Spanned<RangeText>,
    flat_friction: Spanned<RangeText>,
    face_restitution: Spanned<RangeText>,
    face_restitution_more: Spanned<ValueText>,
    face_tangential_share: Spanned<ValueText>,
    gyration_share: Spanned<ValueText>,
    mass_share: Spanned<ValueText>,
    speed_share: Spanned<ValueText>,
    normal_degrees: Spanned<ValueText>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RangeText {
    low: f64,
    nominal: f64,
    high: f64,
    source: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ValueText {
    value: f64,
    source: String,
}

/// The factor `1 ± share`.
pub(crate) fn factor(share: f64, pick: Pick) -> f64 {
    match pick {
        Pick::Low => 1.0 - share,
        Pick::Nominal => 1.0,
        Pick::High => 1.0 + share,
    }
}

/// What both parties state, by the mean where both do.
fn joint<T>(of: [Option<T>; 2], usual: T, mean: impl Fn(T, T) -> T) -> T {
    match of {
        [Some(a), Some(b)] => mean(a, b),
        [Some(one), None] | [None, Some(one)] => one,
        [None, None] => usual,
    }
}

fn mean(a: f64, b: f64) -> f64 {
    0.5 * (a + b)
}

fn mean_setting(a: Setting, b: Setting) -> Setting {
    Setting {
        low: mean(a.low, b.low),
        nominal: mean(a.nominal, b.nominal),
        high: mean(a.high, b.high),
    }
}

impl Parameters {
    /// The parameters of a contact of two parties of which this is known.
    ///
    /// What a party states takes the place of the set's value; where both state it, the mean of
    /// both does, our assumption. Mass and gyration are each party's own.
    #[must_use]
    pub fn of_pair(&self, own: [&OwnParameters; 2]) -> PairParameters {
        let setting = |of: fn(&OwnParameters) -> Option<Setting>, usual: Setting| {
            joint(own.map(of), usual, mean_setting)
        };
        let value =
            |of: fn(&OwnParameters) -> Option<f64>, usual: f64| joint(own.map(of), usual, mean);
        let face_restitution = setting(|own| own.restitution, self.face_restitution);
        let more = value(|own| own.face_restitution_more, self.face_restitution_more);
        PairParameters {
            restitution: setting(|own| own.restitution, self.restitution),
            friction: setting(|own| own.friction, self.friction),
            flat_friction: setting(|own| own.friction, self.flat_friction),
            face_restitution,
            // Nothing leaves faster than it came.
            face_restitution_more: more.min(1.0 - face_restitution.high),
            face_tangential_share: value(
                |own| own.face_tangential_share,
                self.face_tangential_share,
            ),
            gyration_share: own.map(|own| own.gyration_share.unwrap_or(self.gyration_share)),
            mass_share: own.map(|own| own.mass_share.unwrap_or(self.mass_share)),
        }
    }

    /// The set that ships with the program.
    ///
    /// # Errors
    ///
    /// Never for the file as shipped: a test reads it.
    pub fn shipped() -> Result<Self, DataFileError> {
        Self::parse("config/parameters/default.toml", DEFAULT_PARAMETERS)
    }

    /// Reads and checks a set. `file` is only named in errors.
    ///
    /// # Errors
    ///
    /// Line, column, fault and remedy, for: text that is not TOML, a missing or unknown key, a
    /// value that is not finite or out of its range, ends out of order, an empty source.
    pub fn parse(file: &str, text: &str) -> Result<Self, DataFileError> {
        let source = Source { file, text };
        let read: File = toml::from_str(text).map_err(|e| source.malformed(&e, KEYS))?;
        if *read.schema.get_ref() != 1 {
            return Err(source.fault(read.schema.span(), "unknown schema", "write schema = 1"));
        }
        let mut sources = Vec::new();
        let mut sourced = |text: &str, span: core::ops::Range<usize>| {
            if text.trim().is_empty() {
                let remedy = "say where the value comes from, or that it is an assumption";
                return Err(source.fault(span, "the source is empty", remedy));
            }
            sources.push(text.to_owned());
            Ok(())
        };
        let mut range = |text: Spanned<RangeText>, most: f64| {
            let (span, text) = (text.span(), text.into_inner());
            sourced(&text.source, span.clone())?;
            let RangeText { low, nominal, high, .. } = text;
            let setting = Setting { low, nominal, high };
            if !setting.is_within(most) {
                let remedy = format!("write 0 ≤ low ≤ nominal ≤ high ≤ {most}");
                return Err(source.fault(span, "not a range", remedy));
            }
            Ok(setting)
        };
        let restitution = range(read.restitution, 1.0)?;
        let friction = range(read.friction, FRICTION_MAX)?;
        let flat_friction = range(read.flat_friction, FRICTION_MAX)?;
        let face_restitution = range(read.face_restitution, 1.0)?;
        let mut value = |text: Spanned<ValueText>, below: f64| {
            let (span, text) = (text.span(), text.into_inner());
            sourced(&text.source, span.clone())?;
            if !(0.0..below).contains(&text.value) {
                let remedy = format!("write a value of at least 0 and below {below}");
                return Err(source.fault(span, "out of its range", remedy));
            }
            Ok(text.value)
        };
        let more_at = read.face_restitution_more.span();
        let face_restitution_more = value(read.face_restitution_more, 1.0)?;
        if face_restitution.high + face_restitution_more > 1.0 {
            let fault = "together with face_restitution it is above 1";
            return Err(source.fault(more_at, fault, "lower one of them"));
        }
        Ok(Self {
            name: read.name,
            restitution,
            friction,
            flat_friction,
            face_restitution,
            face_restitution_more,
            face_tangential_share: value(read.face_tangential_share, 1.0)?,
            gyration_share: value(read.gyration_share, 1.0)?,
            mass_share: value(read.mass_share, 1.0)?,
            speed_share: value(read.speed_share, 1.0)?,
            normal_degrees: value(read.normal_degrees, 45.0)?,
            sources: sources.into(),
        })
    }
}

#[cfg(test)]
mod tests;
