//! Parameters of contact and dynamics: a data file, each value with its range and its source.

use crate::fault::{DataFileError, Source};
use serde::{Deserialize, Serialize};
use toml::Spanned;

/// The parameters in force unless others are named: `config/parameters/default.toml`.
pub const DEFAULT_PARAMETERS: &str =
    include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/config/parameters/default.toml"));

const KEYS: &str = "a file of parameters has schema, name and the tables restitution, friction, \
                    flat_friction, face_restitution (low, nominal, high, source), \
                    face_restitution_more, face_tangential_share, gyration_share, mass_share, \
                    speed_share and normal_degrees (value, source)";

/// A parameter with its expert range.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Setting {
    /// Low end.
    pub low: f64,
    /// What the nominal computation takes.
    pub nominal: f64,
    /// High end.
    pub high: f64,
}

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
    pub sources: Vec<String>,
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

impl Setting {
    pub(crate) fn pick(&self, pick: Pick) -> f64 {
        match pick {
            Pick::Low => self.low,
            Pick::Nominal => self.nominal,
            Pick::High => self.high,
        }
    }
}

/// The factor `1 ± share`.
pub(crate) fn factor(share: f64, pick: Pick) -> f64 {
    match pick {
        Pick::Low => 1.0 - share,
        Pick::Nominal => 1.0,
        Pick::High => 1.0 + share,
    }
}

impl Parameters {
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
            if !(0.0 <= low && low <= nominal && nominal <= high && high <= most) {
                let remedy = format!("write 0 ≤ low ≤ nominal ≤ high ≤ {most}");
                return Err(source.fault(span, "not a range", remedy));
            }
            Ok(Setting { low, nominal, high })
        };
        let restitution = range(read.restitution, 1.0)?;
        let friction = range(read.friction, 10.0)?;
        let flat_friction = range(read.flat_friction, 10.0)?;
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
            sources,
        })
    }
}

#[cfg(test)]
mod tests;
